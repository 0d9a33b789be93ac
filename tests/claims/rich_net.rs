//! A problem that hides nothing: large motion of a net with axial and relative dashpots and Rayleigh damping, in a
//! wind, under a load and a follower pressure that change with time.
//!
//! Steps are powers of two and the rows of the tables fall on multiples of the largest, so that the force is smooth
//! within every step and the kinks of the tables cost no order.

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

/// [N s/m] of the springs of rule [`AXIAL`]
pub const AXIAL_DASHPOT: f64 = 0.6;
/// [s] k times this is the coefficient of the springs of rule [`RELATIVE`]
pub const RELATIVE_TIME: f64 = 0.02;
/// [1/s] and [s] Rayleigh's alpha and beta
pub const ALPHA: f64 = 0.3;
pub const BETA: f64 = 0.005;
pub const TRIANGLES: [[usize; 3]; 4] = [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]];
/// [Pa s/m^2], [Pa s^2/m^3] and [m] of the cloth
pub const CLOTH: [f64; 3] = [400.0, 100.0, 1e-3];
/// [s] and [m/s]
pub const WIND: [[f64; 4]; 4] =
    [[0.0, 0.5, 0.0, 12.0], [0.25, 1.0, 1.0, 16.0], [0.75, 0.0, -1.0, 13.0], [1.0, 0.0, 0.0, 15.0]];
/// [N] on node [`PULLED`], times [`PULL_TABLE`]
pub const PULL: [f64; 3] = [2.0, 1.0, 0.5];
pub const PULLED: usize = 5;
pub const PULL_TABLE: [[f64; 2]; 3] = [[0.0, 0.0], [0.5, 1.5], [1.0, 0.2]];
/// [Pa] follower pressure, times [`PRESSURE_TABLE`]
pub const PRESSURE: f64 = 1.5;
pub const PRESSURE_TABLE: [[f64; 2]; 2] = [[0.0, 1.0], [0.75, 2.0]];

pub fn rule(spring: usize) -> Rule {
    if spring.is_multiple_of(2) { AXIAL } else { RELATIVE }
}

/// A sheet of four triangles and six nodes, pulled far out of its plane.
pub fn net() -> Value {
    json!({
        "name": "rich",
        "system": {"network": {
            "mesh": {"explicit": {
                "nodes": NODES, "springs": SPRINGS, "triangles": TRIANGLES
            }},
            "mass": {"nodal": MASS},
            "springs": [
                {"on": {"ids": [0, 2, 4, 6]}, "stiffness": AXIAL.stiffness, "rest_scale": AXIAL.rest_scale,
                 "dashpot": {"axial": {"coefficient": AXIAL_DASHPOT}}},
                {"on": "all", "stiffness": RELATIVE.stiffness, "rest_scale": RELATIVE.rest_scale,
                 "dashpot": {"relative": {"time": RELATIVE_TIME}}}
            ],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}, {"on": {"ids": [3]}, "fix": "xz"}],
            "gravity": [0, 0, -GRAVITY],
            "aero": {
                "wind": {"table": WIND},
                "law": {"permeable": {"a": CLOTH[0], "b": CLOTH[1], "thickness": CLOTH[2]}}
            },
            "loads": [
                {"on": {"ids": [PULLED]}, "force": PULL, "table": PULL_TABLE},
                {"on": "all", "pressure": PRESSURE, "kind": "follower", "table": PRESSURE_TABLE}
            ],
            "damping": {"rayleigh": {"mass": ALPHA, "stiffness": BETA}},
            "initial": {"displacement": [0.05, -0.03, 0.1], "velocity": [0.3, 0.2, -0.5]}
        }},
        "time": {"end": 1.0, "method": "rk4", "step": 0.015625},
        "solver": {"newton": {"relative": 1e-12}}
    })
}
