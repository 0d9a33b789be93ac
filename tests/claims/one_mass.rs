//! One mass on one spring from an anchor, free along the spring only: m x'' = -k x, with x the distance from rest. The
//! spring's length at rest is 16 times the displacement, so few digits are lost in l - l0 and the mass stays on its
//! side of the anchor.

use crate::common::run::{case_of, follow_on};
use canopy_fem::case::Case;
use canopy_fem::drive::observer::Energies;
use serde_json::{Value, json};

/// [N/m] and [kg] of the thesis' Appendix A
pub const STIFFNESS: f64 = 3.0;
pub const MASS: f64 = 2.0;
/// [m] length of the spring at rest
pub const REST: f64 = 1.0;
/// [m] displacement at the start
pub const START: f64 = 0.0625;

/// [rad/s] w
pub fn frequency() -> f64 {
    (STIFFNESS / MASS).sqrt()
}

/// A row of a run: state and account.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// [m] from rest
    pub x: f64,
    /// [m/s]
    pub v: f64,
    pub ledger: Energies,
}

impl Row {
    /// [J] kinetic and elastic, as the program's account has them
    pub fn energy(&self) -> f64 {
        self.ledger.kinetic + self.ledger.elastic
    }
}

pub fn case(method: &Value, step: f64, steps: usize) -> Case {
    // Half a step more than wanted: the last step, shortened, is not looked at.
    let end = (steps as f64 + 0.5) * step;
    case_of(
        &json!({
            "name": "one-mass",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": [[-REST, 0, 0], [0, 0, 0]], "springs": [[0, 1]]}},
                "mass": {"nodal": MASS},
                "springs": [{"on": "all", "stiffness": STIFFNESS}],
                "supports": [{"on": {"ids": [0]}, "fix": "xyz"}, {"on": {"ids": [1]}, "fix": "yz"}],
                "initial": {"displacement": [START, 0, 0]}
            }},
            "time": {"end": end, "method": method, "step": step}
        }),
        &[],
    )
}

/// The start and `steps` steps of w h = `wh`.
pub fn rows(method: &Value, wh: f64, steps: usize) -> Vec<Row> {
    let mut rows = Vec::with_capacity(steps + 2);
    let case = case(method, wh / frequency(), steps);
    let outcome = follow_on(&case, |seen| {
        rows.push(Row { x: seen.positions[1][0], v: seen.velocities[1][0], ledger: seen.ledger });
    });
    assert_eq!(outcome.t_end, case.problem().time.end, "{method}, w h = {wh}");
    rows.truncate(steps + 1);
    assert_eq!(rows.len(), steps + 1, "{method}, w h = {wh}");
    rows
}
