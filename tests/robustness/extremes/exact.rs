//! Extremes whose answer is known in closed form.

use super::scenes::{chain, mote, patch};
use super::verdict::{End, Ran, attempt, attempt_within};
use canopy_fem::drive::Status;
use canopy_fem::integrate::registry::methods;
use serde_json::{Value, json};
use std::time::{Duration, Instant};

fn complete(json: &Value, sets: &[(&str, &str)]) -> Box<Ran> {
    let sets: Vec<_> = sets.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
    completed(attempt(json, &sets))
}

fn completed(end: End) -> Box<Ran> {
    match end {
        End::Ran(ran) if ran.outcome.status == Status::Completed => ran,
        end => panic!("{}", end.words()),
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
            let warned = there.problem.warnings.iter().any(|w| w.text.contains("are rounded to"));
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

/// A motion that is a few last digits of a coordinate a step, or less, comes out right or is told to be lost.
#[test]
fn motion_below_the_digits_of_a_place_is_right_or_told() {
    let digit = |x: f64| x.next_up() - x;
    let (mut right, mut told) = (0, 0);
    for method in methods() {
        for (x, speed) in [(1.0, 1e-9), (1e9, 1e-3), (1e9, 1.0), (1e-3, 1e6)] {
            for digits in [1e-6, 0.1, 0.49, 0.51, 1.4, 10.3, 49.7, 60.4, 1e3, 1e6] {
                let h = digits * digit(x) / speed;
                let mut drifting = mote();
                let network = &mut drifting["system"]["network"];
                network["gravity"] = json!([0, 0, 0]);
                network["mesh"]["explicit"]["nodes"] = json!([[x, 0, 0]]);
                network["initial"] = json!({"velocity": [speed, 0, 0]});
                let (step, end) = (format!("{h:e}"), format!("{:e}", 50.0 * h));
                let ran =
                    complete(&drifting, &[("time.method", method.name), ("time.step", &step), ("time.end", &end)]);
                let true_way = speed * ran.outcome.t_end;
                let off = (ran.positions[0][0] - x - true_way).abs() / true_way;
                if ran.problem.warnings.iter().any(|w| w.text.contains("will be lost")) {
                    told += 1;
                    assert!(digits < 51.0, "{} at {x} m with {digits} digits a step: {off} off", method.name);
                } else {
                    right += 1;
                    assert!(off < 0.01, "{} at {x} m with {digits} digits a step: {off} off", method.name);
                }
            }
        }
    }
    assert!(right > 100 && told > 100, "{right} right, {told} told");
}

/// A taut string moves as Newmark's recurrence does, cos(n theta) with tan(theta/2) = w h/2 (Hughes 2000, section 9.1),
/// however small the motion: what moves it may be less than the rounding of what its springs hold.
#[test]
fn motion_below_the_rounding_of_tension_is_right() {
    let (h, steps) = (1e-3_f64, 200);
    // T = k (l - l0) = 10 N, m = 0.1 kg, l = 0.1 m: w^2 = 2 T/(m l) (1 - cos(pi/10))
    let w = (2.0 * 10.0 / (0.1 * 0.1) * (1.0 - (std::f64::consts::PI / 10.0).cos())).sqrt();
    let expected = (f64::from(steps) * 2.0 * (0.5 * w * h).atan()).cos();
    for amplitude in [1e-6, 1e-9, 1e-12, 1e-14] {
        let shape = |i: i32| json!([0, 0, amplitude * (std::f64::consts::PI / 10.0 * f64::from(i)).sin()]);
        let string = json!({"name": "string", "system": {"network": {
            "mesh": {"chain": {"from": [0, 0, 0], "to": [1, 0, 0], "segments": 10}},
            "mass": {"nodal": 0.1}, "springs": [{"on": "all", "stiffness": 1000, "rest_scale": 0.9}],
            "supports": [{"on": {"ids": [0, 10]}, "fix": "xyz"}],
            "initial": {"displacement": (0..=10).map(shape).collect::<Vec<_>>()}}},
            "time": {"end": h * f64::from(steps), "method": "newmark", "step": h}});
        for strategy in ["full", "auto"] {
            let ran = complete(&string, &[("solver.newton.strategy", strategy)]);
            let off = (ran.positions[5][2] / amplitude - expected).abs();
            assert!(off < 1e-9, "{amplitude:e} m, {strategy}: {} of the motion, not {expected}", off + expected);
        }
    }
}

/// Where springs are so stiff that the rounding of their forces is as large as all that acts, the motion is right or
/// refused with the cause: no method that solves says that nothing moves.
#[test]
fn motion_below_the_rounding_of_stiff_springs_is_right_or_refused() {
    let (mut right, mut refused) = (0, 0);
    for (method, step, end) in [
        ("newmark", "1e-3", "0.02"),
        ("backward-euler", "1e-3", "0.02"),
        ("newmark", "1e-2", "0.2"),
        ("backward-euler", "1e-2", "0.2"),
        ("generalized-alpha", "1e-2", "0.2"),
    ] {
        let sets = |k| {
            let sets = [
                ("system.network.springs.0.stiffness", k),
                ("time.method", method),
                ("time.step", step),
                ("time.end", end),
            ];
            sets.map(|(key, value): (&str, &str)| (key.to_owned(), value.to_owned()))
        };
        let expected = completed(attempt(&chain(), &sets("1e6"))).positions[4][2];
        for k in ["1e14", "1e16", "1e18", "1e20", "1e25", "1e50", "1e300"] {
            let End::Ran(ran) = attempt(&chain(), &sets(k)) else { panic!("{k} N/m, {method}: not run") };
            match &ran.outcome.failure {
                None => {
                    right += 1;
                    let z = ran.positions[4][2];
                    assert!((z / expected - 1.0).abs() < 0.01, "{k} N/m, {method}, {step} s: {z} m, not {expected} m");
                }
                Some(failure) => {
                    refused += usize::from(failure.cause.contains("rounding hides the motion"));
                    assert_eq!(ran.outcome.status, Status::NotConverged, "{k} N/m, {method}: {}", failure.cause);
                }
            }
        }
    }
    assert!(right > 3 && refused > 6, "{right} right, {refused} refused");
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

/// What twenty steps of a million springs may take on a busy machine.
const MILLION: Duration = Duration::from_secs(300);

/// A hub on a million springs to a held rim: its oscillation has k_total = N k/2 in the plane of the rim.
#[test]
#[ignore = "long"]
fn a_million_springs_on_one_node() {
    for method in ["velocity-verlet", "newmark"] {
        // w = 1 rad/s.
        let hub = Hub { springs: 1_000_000, rim: Rim::Held, method, steps: 20.0 };
        let ran = completed(attempt_within(MILLION, &hub.case(), &[]));
        let (x, expected) = (ran.positions[0][0], 1e-3 * 1.0_f64.sin());
        assert!((x - expected).abs() < 1e-3 * expected, "{method}: {x} m, not {expected} m");
    }
}

/// The same hub with a rim that is free, and as heavy across a direction as the hub: half the motion goes on for ever,
/// half swings with w = 1 rad/s. A free rim makes the matrix an arrow: only an ordering that takes the hub last keeps
/// it sparse, wherever the hub falls when the nodes are halved.
#[test]
#[ignore = "long"]
fn a_million_springs_on_one_node_with_a_free_rim() {
    let runs = [(10_000, "newmark", 20.0), (10_001, "newmark", 20.0), (10_002, "hht", 20.0), (10_003, "kang", 20.0)];
    let large = [(1_000_000, "velocity-verlet", 10.0), (1_000_000, "newmark", 2.0)];
    for (n, name, steps) in runs.into_iter().chain(large) {
        let start = Instant::now();
        let hub = Hub { springs: n, rim: Rim::Free, method: name, steps };
        let ran = completed(attempt_within(MILLION, &hub.case(), &[]));
        println!("{n} springs, {name}, {steps} steps: {:?}", start.elapsed());
        let (x, v, t) = (ran.positions[0][0], ran.velocities[0][0], ran.outcome.t_end);
        let [expected_x, expected_v] = [0.5e-3 * (t + t.sin()), 0.5e-3 * (1.0 + t.cos())];
        let allowed = if name == "kang" { 0.1 } else { 1e-3 };
        assert!((x / expected_x - 1.0).abs() < allowed, "{n}, {name}: {x} m, not {expected_x} m");
        assert!((v / expected_v - 1.0).abs() < allowed, "{n}, {name}: {v} m/s, not {expected_v} m/s");
        let momentum = v + ran.velocities[1..].iter().map(|v| v[0] * 2.0 / n as f64).sum::<f64>();
        // Kang's filter loses momentum where nodes have springs of unequal number.
        assert!(name == "kang" || (momentum - 1e-3).abs() < 1e-9, "{n}, {name}: momentum {momentum} kg m/s");
        if let Some(nonzeros) = ran.outcome.linear.as_ref().and_then(|l| l.factor_nonzeros) {
            assert!(nonzeros > 0 && nonzeros < 20 * n, "{n}, {name}: {nonzeros} entries in the factor");
        }
    }
}

/// What holds the far ends of a hub's springs.
enum Rim {
    Held,
    Free,
}

/// A node of 1 kg that starts with 1 mm/s, and springs from it to a circle around it.
struct Hub<'a> {
    springs: usize,
    rim: Rim,
    method: &'a str,
    steps: f64,
}

impl Hub<'_> {
    fn case(&self) -> Value {
        let n = self.springs;
        let around = (0..n).map(|i| {
            let a = std::f64::consts::TAU * i as f64 / n as f64;
            [a.cos(), a.sin(), 0.0]
        });
        let nodes: Vec<[f64; 3]> = std::iter::once([0.0; 3]).chain(around).collect();
        let springs: Vec<[usize; 2]> = (1..=n).map(|i| [0, i]).collect();
        let mut speed = vec![[0.0; 3]; n + 1];
        speed[0][0] = 1e-3;
        let mut masses = vec![2.0 / n as f64; n + 1];
        masses[0] = 1.0;
        let mut network = json!({
            "mesh": {"explicit": {"nodes": nodes, "springs": springs}},
            "mass": {"nodal": masses},
            "initial": {"velocity": speed}
        });
        // Across any direction the springs add up to half their number: 1 N/m to a held rim, the half to a free one.
        let stiffness = match self.rim {
            Rim::Held => {
                network["supports"] = json!([{"on": {"ids": (1..=n).collect::<Vec<_>>()}, "fix": "xyz"}]);
                2.0 / n as f64
            }
            Rim::Free => 1.0 / n as f64,
        };
        network["springs"] = json!([{"on": "all", "stiffness": stiffness}]);
        json!({
            "name": "hub",
            "system": {"network": network},
            "time": {"end": 0.05 * self.steps, "method": self.method, "step": 0.05}
        })
    }
}
