//! Beads on elastic links, as cases: one hanging chain and one between two walls.

use crate::common::run::case_of;
use canopy_fem::case::Case;
use serde_json::{Value, json};

/// [m/s^2]
pub const G: f64 = 9.81;

/// Beads below each other from an anchor at the origin; every link is `link` long under the load below it.
pub struct Hanging {
    pub beads: usize,
    /// [kg] of a bead
    pub mass: f64,
    /// [m] of a link under load
    pub link: f64,
    /// [N/m] of a link
    pub stiffness: f64,
}

impl Hanging {
    /// The case at rest but for `displacement`, with rk4.
    pub fn case(&self, displacement: &[[f64; 3]], end: f64, step: f64) -> Case {
        let nodes: Vec<[f64; 3]> = (0..=self.beads).map(|i| [0.0, 0.0, -self.link * i as f64]).collect();
        let springs: Vec<Value> = (0..self.beads)
            .map(|i| {
                let tension = (self.beads - i) as f64 * self.mass * G;
                let rest_length = self.link - tension / self.stiffness;
                json!({"on": {"ids": [i]}, "stiffness": self.stiffness, "rest_length": rest_length})
            })
            .collect();
        let edges: Vec<[usize; 2]> = (0..self.beads).map(|i| [i, i + 1]).collect();
        let case = json!({
            "name": "hanging",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": nodes, "springs": edges}},
                "mass": {"nodal": self.mass},
                "springs": springs,
                "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
                "gravity": [0, 0, -G],
                "initial": {"displacement": displacement}
            }},
            "time": {"end": end, "method": "rk4", "step": step}
        });
        case_of(&case, &[])
    }

    /// The same at rest.
    pub fn at_rest(&self) -> Case {
        self.case(&vec![[0.0; 3]; self.beads + 1], 1.0, 1.0)
    }
}

/// Beads along x between two walls, nodes 0 and `beads` + 1.
pub struct Strung {
    pub beads: usize,
    /// [kg] of a bead
    pub mass: f64,
    /// [m] of a link, stretched
    pub link: f64,
    /// [N/m] of a link
    pub stiffness: f64,
    /// [N] pull in all links
    pub tension: f64,
}

/// How a strung chain is started and run.
pub struct Start<'a> {
    pub displacement: &'a [[f64; 3]],
    pub velocity: &'a [[f64; 3]],
    pub method: &'a str,
    /// [s]
    pub step: f64,
    pub steps: u32,
}

impl Strung {
    pub fn case(&self, start: &Start<'_>) -> Case {
        let mut nodes = vec![[0.0; 3]; self.beads + 2];
        nodes.iter_mut().enumerate().for_each(|(i, x)| x[0] = self.link * i as f64);
        let edges: Vec<[usize; 2]> = (0..=self.beads).map(|i| [i, i + 1]).collect();
        let case = json!({
            "name": "strung",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": nodes, "springs": edges}},
                "mass": {"nodal": self.mass},
                "springs": [{
                    "on": "all", "stiffness": self.stiffness,
                    "rest_length": self.link - self.tension / self.stiffness
                }],
                "supports": [{"on": {"ids": [0, self.beads + 1]}, "fix": "xyz"}],
                "initial": {"displacement": start.displacement, "velocity": start.velocity}
            }},
            "time": {"end": start.step * f64::from(start.steps), "method": start.method, "step": start.step},
            // Rounding is wanted, not Newton's own tolerance.
            "solver": {"newton": {"relative": 1e-13}}
        });
        case_of(&case, &[])
    }

    /// The same at rest.
    pub fn at_rest(&self) -> Case {
        let still = vec![[0.0; 3]; self.beads + 2];
        self.case(&Start { displacement: &still, velocity: &still, method: "rk4", step: 1.0, steps: 1 })
    }

    /// [1/s] 2 sqrt(k/m) sin(q a/2) of mode `j` = 1 ..= `beads` with a stiffness `k` of a link, q a = j pi/(beads + 1).
    pub fn frequency(&self, k: f64, j: usize) -> f64 {
        2.0 * (k / self.mass).sqrt() * (0.5 * self.phase(j)).sin()
    }

    /// [rad] q a of mode `j`.
    pub fn phase(&self, j: usize) -> f64 {
        std::f64::consts::PI * j as f64 / (self.beads + 1) as f64
    }
}
