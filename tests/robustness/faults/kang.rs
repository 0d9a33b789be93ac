//! Kang's scheme on springs that are slack, go taut, and go slack again.

use crate::common::run::{case_of, follow_on, run};
use canopy_fem::drive::Status;
use serde_json::{Value, json};

const MASS: f64 = 3.0;
const STIFFNESS: f64 = 25_000.0;
const SPEED: f64 = 4.0;

/// A mass 1 m from an anchor, flying away from it at 4 m/s on a rope of 2 m.
fn rope(step: f64, end: f64) -> Value {
    json!({
        "name": "rope",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0]], "springs": [[0, 1]]}},
            "mass": {"nodal": MASS},
            "springs": [{"on": "all", "stiffness": STIFFNESS, "rest_length": 2.0, "slack": "tension-only"}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
            "initial": {"velocity": [[0, 0, 0], [SPEED, 0, 0]]}
        }},
        "time": {"end": end, "method": "kang", "step": step}
    })
}

/// The published filter's h k (v_j - v_i) along the slack rope left v exp(-k h t/m).
#[test]
fn free_flight_on_a_slack_rope_keeps_its_speed() {
    for step in [1e-1, 1e-2, 1e-3, 1e-4] {
        let end = run(&case_of(&rope(step, 0.24), &[]));
        assert_eq!(end.velocities[1], [SPEED, 0.0, 0.0], "h = {step}");
        assert!((end.positions[1][0] - 1.96).abs() < 1e-12, "h = {step}: {:?}", end.positions[1]);
    }
}

/// Backward Euler of a mass on one such rope, solved: the pull at the end of the step is k (l - l0) there, or nothing;
/// a rope that is taut at the start of a step is taken as taut at its end.
fn backward_euler(h: f64, steps: usize) -> Vec<[f64; 2]> {
    let (mut x, mut v) = (1.0, SPEED);
    let kappa = h * h * STIFFNESS / MASS;
    let step = |_| {
        let beyond = x + h * v - 2.0;
        if beyond > 0.0 || x > 2.0 {
            v -= kappa / (1.0 + kappa) * beyond / h;
        }
        x += h * v;
        [x, v]
    };
    (0..steps).map(step).collect()
}

#[test]
fn a_rope_catches_a_mass_as_by_backward_euler_at_any_step() {
    for kappa in [1e-4, 1e-2, 1.0, 1e2, 1e4] {
        let h: f64 = (kappa * MASS / STIFFNESS).sqrt();
        let steps = (0.4 / h).ceil().max(30.0) as usize;
        let mut seen: Vec<[f64; 2]> = Vec::new();
        let mut most = 0.0_f64;
        let outcome = follow_on(&case_of(&rope(h, h * steps as f64), &[]), |at| {
            seen.push([at.positions[1][0], at.velocities[1][0]]);
            most = most.max(at.ledger.kinetic + at.ledger.elastic);
        });
        assert_eq!(outcome.status, Status::Completed, "kappa {kappa}: {:?}", outcome.failure);
        // Rounding of l - l0 near 1e-16 becomes k h/m times that in the speed of a step.
        let rounding = 1e-12 * (1.0 + kappa.sqrt()) * steps as f64;
        for (i, (found, expected)) in seen.iter().skip(1).zip(backward_euler(h, steps)).enumerate() {
            let off = [0, 1].map(|c| (found[c] - expected[c]).abs());
            assert!(off[0].max(off[1]) < rounding, "kappa {kappa}, step {i}: {found:?}, expected {expected:?}");
        }
        let start = 0.5 * MASS * SPEED * SPEED;
        assert!(most <= start * (1.0 + 1e-12), "kappa {kappa}: {most} J of {start} J");
    }
}

/// First order in the step across the catch and the throw back: at 0.4 s the mass flies back at 4 m/s.
#[test]
fn the_throw_back_is_of_first_order() {
    // Half a period of the spring after the rope is taut at t = 0.25 s.
    let back = 0.25 + std::f64::consts::PI * (MASS / STIFFNESS).sqrt();
    let exact = 2.0 - SPEED * (0.4 - back);
    let off = |h: f64| (run(&case_of(&rope(h, 0.4), &[])).positions[1][0] - exact).abs();
    let (coarse, fine) = (off(1e-5), off(2.5e-6));
    assert!(fine < 2e-3 && (3.0..5.0).contains(&(coarse / fine)), "{coarse} {fine}");
}

/// A dashpot c = k h that the case asks for acts along slack springs as it does with every other method: v exp(-k h
/// t/m) here is its damping.
#[test]
fn a_step_dashpot_acts_along_a_slack_rope() {
    let step = 1e-3;
    let mut case = rope(step, 0.1);
    case["system"]["network"]["springs"][0]["dashpot"] = json!({"relative": "step"});
    let v = run(&case_of(&case, &[])).velocities[1][0];
    let kappa = step * step * STIFFNESS / MASS;
    // Implicit in the filter: v m/(m + h^2 k) a step.
    assert!((v / (SPEED * (1.0 + kappa).powi(-100)) - 1.0).abs() < 1e-9, "{v}");
}

/// A net that never goes slack has the same bits whether its springs could be slack or not.
#[test]
fn taut_springs_do_not_notice_that_they_could_be_slack() {
    let net = |slack: Option<&str>| {
        let mut case = json!({
            "name": "net",
            "system": {"network": {
                "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": 6, "rows": 6}},
                "mass": {"nodal": 0.01},
                "springs": [{"on": "all", "stiffness": 1000.0, "rest_scale": 0.8}],
                "supports": [{"on": "boundary", "fix": "xyz"}],
                "initial": {"velocity": [0, 0, 0.5]}
            }},
            "time": {"end": 0.1, "method": "kang", "step": 1e-3}
        });
        if let Some(slack) = slack {
            case["system"]["network"]["springs"][0]["slack"] = json!(slack);
        }
        run(&case_of(&case, &[])).state
    };
    let (one_sided, plain) = (net(Some("tension-only")), net(None));
    assert_eq!(one_sided.x, plain.x);
    assert_eq!(one_sided.v, plain.v);
}
