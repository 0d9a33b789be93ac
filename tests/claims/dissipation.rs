//! One mass on a spring with one damper of every kind, m x'' = -k x - c x': what its column `dissipated` says against
//! the energy that the closed form has lost, with d = c/(2 m), wd^2 = k/m - d^2:
//! ```text
//! x = X exp(-d t) (cos wd t + (d/wd) sin wd t),     v = -X (w^2/wd) exp(-d t) sin wd t
//! dissipated = k X^2/2 - m v^2/2 - k x^2/2
//! ```
//! Along a line all dampers are the same c: Rayleigh's alpha is c/m and beta is c/k. Nothing else acts, so
//! `external_work` is 0.

use crate::claim::Claim;
use crate::common::run::{case_of, follow};
use crate::one_mass::{MASS, REST, START, STIFFNESS, frequency};
use canopy_fem::drive::Status;
use canopy_fem::drive::observer::Energies;
use serde_json::{Value, json};

/// [N s/m] a damping ratio of 0.1
const C: f64 = 0.49;
/// [-] 2000 steps at w h = 0.005: some 1.6 periods
const STEPS: u32 = 2000;
const PACE: f64 = 0.005;

fn last_row(method: &str, damper: (&str, &Value)) -> (f64, Energies) {
    let h = PACE / frequency();
    let mut network = json!({
        "mesh": {"explicit": {"nodes": [[-REST, 0, 0], [0, 0, 0]], "springs": [[0, 1]]}},
        "mass": {"nodal": MASS},
        "springs": [{"on": "all", "stiffness": STIFFNESS}],
        "supports": [{"on": {"ids": [0]}, "fix": "xyz"}, {"on": {"ids": [1]}, "fix": "yz"}],
        "initial": {"displacement": [START, 0, 0]}
    });
    match damper {
        ("damping", rule) => network["damping"] = rule.clone(),
        (key, rule) => network["springs"][0][key] = rule.clone(),
    }
    let time = json!({"end": f64::from(STEPS) * h, "method": method, "step": h});
    let mut last = (0.0, Energies::default());
    let outcome =
        follow(&case_of(&json!({"name": "damper", "system": {"network": network}, "time": time}), &[]), |seen| {
            last = (seen.t, seen.ledger);
        });
    assert_eq!(outcome.status, Status::Completed, "{method}, {damper:?}");
    last
}

/// [-] Energy lost by the closed form over the first energy.
fn lost(t: f64) -> f64 {
    let (d, w) = (C / (2.0 * MASS), frequency());
    let wd = (w * w - d * d).sqrt();
    let (sin, cos) = (wd * t).sin_cos();
    let decay = (-d * t).exp();
    let (x, v) = (decay * (cos + d / wd * sin), -decay * w * w / wd * sin);
    1.0 - x * x - (v / w).powi(2)
}

pub fn claims() -> Vec<Claim> {
    let dampers = [
        ("axial dashpot", "dashpot", json!({"axial": {"coefficient": C}})),
        ("relative dashpot", "dashpot", json!({"relative": {"coefficient": C}})),
        ("Rayleigh, mass", "damping", json!({"rayleigh": {"mass": C / MASS, "stiffness": 0.0}})),
        ("Rayleigh, stiffness", "damping", json!({"rayleigh": {"mass": 0.0, "stiffness": C / STIFFNESS}})),
    ];
    let first = 0.5 * STIFFNESS * START * START;
    let mut claims = Vec::new();
    for (name, key, rule) in &dampers {
        // rk4 integrates the power with the motion, to w t (w h)^4/120 = 5e-11. Newmark's phase is w t (w h)^2/12 =
        // 2e-5 late, and the loss of the end changes by a quarter of that; its own account closes to the rounding of
        // 2000 steps.
        for (method, tolerance, remainder) in [("rk4", 5e-11, 5e-11), ("newmark", 5e-6, 1e-12)] {
            let (t, ledger) = last_row(method, (key, rule));
            let what = |column| format!("{name}, {method}: {column} over the first energy");
            claims.push(Claim::absolute(what("dissipated"), ledger.dissipated / first, lost(t), tolerance));
            claims.push(Claim::absolute(what("external work"), ledger.external_work / first, 0.0, 0.0));
            claims.push(Claim::below(what("numerical"), ledger.numerical / first, remainder));
        }
    }
    claims
}
