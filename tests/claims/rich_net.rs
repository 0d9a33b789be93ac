//! A problem that hides nothing: large motion of a net with axial and relative dashpots and Rayleigh damping, in a wind, under a
//! load and a follower pressure that change with time.
//!
//! Steps are powers of two and the rows of the tables fall on multiples of the largest, so that the force is smooth within every
//! step and the kinks of the tables cost no order.

use serde_json::{Value, json};

pub const NODES: [[f64; 3]; 6] =
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.1, 0.0, 0.1], [0.0, 1.0, 0.0], [1.0, 1.2, 0.0], [2.0, 1.0, 0.2]];
pub const SPRINGS: [[usize; 2]; 8] = [[0, 1], [1, 2], [3, 4], [4, 5], [1, 4], [2, 5], [0, 4], [1, 5]];
/// [kg]
pub const MASS: [f64; 6] = [0.5, 0.4, 0.6, 0.5, 0.7, 0.45];
/// [m/s^2] along -z
pub const GRAVITY: f64 = 9.81;

/// One of the two rules: every second spring has an axial dashpot, the others a relative one.
#[derive(Clone, Copy)]
pub struct Rule {
    /// [N/m]
    pub stiffness: f64,
    /// [-] of the length on the mesh
    pub rest_scale: f64,
}

pub const AXIAL: Rule = Rule { stiffness: 20.0, rest_scale: 0.9 };
pub const RELATIVE: Rule = Rule { stiffness: 15.0, rest_scale: 0.95 };

pub fn rule(spring: usize) -> Rule {
    if spring.is_multiple_of(2) { AXIAL } else { RELATIVE }
}

/// A sheet of four triangles and six nodes, pulled far out of its plane.
pub fn net() -> Value {
    json!({
        "name": "rich",
        "system": {"network": {
            "mesh": {"explicit": {
                "nodes": NODES, "springs": SPRINGS, "triangles": [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]]
            }},
            "mass": {"nodal": MASS},
            "springs": [
                {"on": {"ids": [0, 2, 4, 6]}, "stiffness": AXIAL.stiffness, "rest_scale": AXIAL.rest_scale,
                 "dashpot": {"axial": {"coefficient": 0.6}}},
                {"on": "all", "stiffness": RELATIVE.stiffness, "rest_scale": RELATIVE.rest_scale,
                 "dashpot": {"relative": {"time": 0.02}}}
            ],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}, {"on": {"ids": [3]}, "fix": "xz"}],
            "gravity": [0, 0, -GRAVITY],
            "aero": {
                "wind": {"table": [[0, 0.5, 0, 12], [0.25, 1, 1, 16], [0.75, 0, -1, 13], [1, 0, 0, 15]]},
                "law": {"permeable": {"a": 400.0, "b": 100.0, "thickness": 1e-3}}
            },
            "loads": [
                {"on": {"ids": [5]}, "force": [2, 1, 0.5], "table": [[0, 0], [0.5, 1.5], [1, 0.2]]},
                {"on": "all", "pressure": 1.5, "kind": "follower", "table": [[0, 1], [0.75, 2]]}
            ],
            "damping": {"rayleigh": {"mass": 0.3, "stiffness": 0.005}},
            "initial": {"displacement": [0.05, -0.03, 0.1], "velocity": [0.3, 0.2, -0.5]}
        }},
        "time": {"end": 1.0, "method": "rk4", "step": 0.015625},
        "solver": {"newton": {"relative": 1e-12}}
    })
}
