//! Extremes whose answer is known in closed form.

use crate::scenes::{chain, mote, patch};
use crate::verdict::{End, Ran, attempt};
use canopy_fem::drive::Status;
use canopy_fem::integrate::registry::{Family, methods};
use serde_json::{Value, json};

fn complete(json: &Value, sets: &[(&str, &str)]) -> Box<Ran> {
    let sets: Vec<_> = sets.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
    match attempt(json, &sets) {
        End::Ran(ran) if ran.outcome.status == Status::Completed => ran,
        end => panic!("{sets:?}: {}", end.words()),
    }
}

/// Far from the origin the motion is the same up to what rounded positions do to it.
#[test]
fn a_far_away_origin_costs_digits_only() {
    // 1e9 m are rounded to 1.2e-7 m.
    for (offset, rounding) in [(1e3, 1.2e-13), (1e6, 1.2e-10), (1e9, 1.2e-7)] {
        for method in methods() {
            let sets = [("time.method", method.name)];
            let (here, there) = (complete(&patch(0.0), &sets), complete(&patch(offset), &sets));
            let warned = there.problem.warnings.iter().any(|w| w.contains("are rounded to"));
            assert_eq!(warned, offset > 1e8, "{:?}", there.problem.warnings);
            let off =
                here.positions.iter().zip(&there.positions).flat_map(|(a, b)| (0..3).map(|c| b[c] - offset - a[c]));
            let off = off.fold(0.0_f64, |m, d| m.max(d.abs()));
            // Twenty roundings of the positions, and springs (w h = 0.05) that feel them.
            assert!(off < 40.0 * rounding, "{} at {offset} m: off by {off} m", method.name);
            let moved =
                here.positions.iter().zip(&here.reference).map(|(a, b)| (a[2] - b[2]).abs()).fold(0.0, f64::max);
            assert!(moved > 0.01, "{}: moved by {moved} m only", method.name);
        }
    }
}

/// A single mass falls on its parabola from any step on; first-order methods miss it by a step's share.
#[test]
fn one_node_falls_on_its_parabola() {
    for method in methods() {
        for h in [1e-15, 1e-6, 1.0, 1e6, 1e50] {
            let n = 20.0;
            let sets = [
                ("time.method", method.name),
                ("time.step", &*format!("{h:e}")),
                ("time.end", &*format!("{:e}", n * h)),
            ];
            let ran = complete(&mote(), &sets);
            let t = ran.outcome.t_end;
            let fallen = -ran.positions[0][2] / (0.5 * 9.81 * t * t);
            let allowed = if method.order == 1 { 1.0 / n + 1e-9 } else { 1e-9 };
            assert!((fallen - 1.0).abs() <= allowed, "{} with {h:e} s: {fallen} of the fall", method.name);
            let speed = -ran.velocities[0][2] / (9.81 * t);
            assert!((speed - 1.0).abs() <= 1e-9, "{} with {h:e} s: {speed} of the speed", method.name);
        }
    }
}

/// A chain hung up straight: in long steps of a method that damps it ends stretched by the weights below, whatever the
/// stiffness.
#[test]
fn stiff_chains_hang_by_their_weights() {
    let mut hung = chain();
    let network = &mut hung["system"]["network"];
    network["mesh"]["explicit"]["nodes"] = json!([[0, 0, 0], [0, 0, -1], [0, 0, -2], [0, 0, -3], [0, 0, -4]]);
    for k in [1e2, 1e6, 1e9, 1e12] {
        let sets = [
            ("system.network.springs.0.stiffness", &*format!("{k:e}")),
            ("time.method", "backward-euler"),
            ("time.step", "1e3"),
            ("time.end", "2e4"),
        ];
        let ran = complete(&hung, &sets);
        // Springs carry 4, 3, 2 and 1 weights: the tip sinks by their sum.
        let sunk = -4.0 - ran.positions[4][2];
        let expected = 10.0 * 0.1 * 9.81 / k;
        let rounding = 16.0 * f64::EPSILON;
        assert!((sunk - expected).abs() <= 1e-6 * expected + rounding, "k {k:e}: sunk by {sunk} m, not {expected} m");
    }
}

/// A hub on a million springs to a held rim: its oscillation has k_total = N k/2 in the plane of the rim.
#[test]
fn a_million_springs_on_one_node() {
    let n = 1_000_000;
    let hub = |method: &str, free_rim: bool, n: usize, steps: f64| {
        let rim = (0..n).map(|i| {
            let a = std::f64::consts::TAU * i as f64 / n as f64;
            [a.cos(), a.sin(), 0.0]
        });
        let nodes: Vec<[f64; 3]> = std::iter::once([0.0; 3]).chain(rim).collect();
        let springs: Vec<[usize; 2]> = (1..=n).map(|i| [0, i]).collect();
        let ids: Vec<usize> = if free_rim { vec![1] } else { (1..=n).collect() };
        let mut speed = vec![[0.0; 3]; n + 1];
        speed[0][0] = 1e-3;
        json!({
            "name": "hub",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": nodes, "springs": springs}},
                "mass": {"nodal": 1.0},
                "springs": [{"on": "all", "stiffness": 2.0 / n as f64}],
                "supports": [{"on": {"ids": ids}, "fix": "xyz"}],
                "initial": {"velocity": speed}
            }},
            "time": {"end": 0.05 * steps, "method": method, "step": 0.05}
        })
    };
    for method in ["velocity-verlet", "newmark"] {
        // w = 1 rad/s.
        let ran = complete(&hub(method, false, n, 20.0), &[]);
        let (x, expected) = (ran.positions[0][0], 1e-3 * 1.0_f64.sin());
        assert!((x - expected).abs() < 1e-3 * expected, "{method}: {x} m, not {expected} m");
    }
    // A free rim makes the matrix an arrow: only an ordering that takes the hub last keeps it sparse.
    for method in methods().iter().filter(|m| m.family == Family::Implicit).take(1) {
        let ran = complete(&hub(method.name, true, 100_000, 3.0), &[]);
        let momentum: f64 = ran.velocities.iter().map(|v| v[0]).sum();
        let nonzeros = ran.outcome.linear.as_ref().and_then(|l| l.factor_nonzeros).unwrap_or(0);
        assert!((momentum - 1e-3).abs() < 1e-7, "{}: momentum {momentum}", method.name);
        assert!(nonzeros > 0 && nonzeros < 20 * 100_000, "{}: {nonzeros} entries in the factor", method.name);
    }
}
