//! Linear solvers that a user forces, on stiffnesses that are far apart: a step is right or refused, never wrong
//! without a word.

use crate::common::run::{Run, apart, case_of, run};
use canopy_fem::drive::Status;
use serde_json::{Value, json};

/// Every solver with every strategy that goes with it.
const SOLVERS: [(&str, &[&str]); 4] = [
    ("auto", &["auto", "full", "modified", "quasi"]),
    ("cholesky", &["auto", "full", "modified", "quasi"]),
    ("lu", &["auto", "full"]),
    ("cg", &["auto", "full", "modified", "quasi"]),
];
const STEPS: usize = 5;
/// [kg] of every node
const MASS: f64 = 0.01;
/// [N] along the chain, on its end
const PULL: f64 = 0.01;

/// A chain along x, held at its start and pulled at its end; `k` [N/m] of its springs, each 1 m long.
fn chain(k: &[f64], method: &str, h: f64) -> Value {
    let n = k.len();
    let nodes: Vec<[f64; 3]> = (0..=n).map(|i| [i as f64, 0.0, 0.0]).collect();
    let springs: Vec<Value> = k.iter().enumerate().map(|(i, k)| json!({"on": {"ids": [i]}, "stiffness": k})).collect();
    json!({
        "name": "chain",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": nodes, "springs": (0..n).map(|i| [i, i + 1]).collect::<Vec<_>>()}},
            "mass": {"nodal": MASS},
            "springs": springs,
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
            "loads": [{"on": {"ids": [n]}, "force": [PULL, 0, 0]}]
        }},
        "time": {"end": h * STEPS as f64, "method": method, "step": h}
    })
}

/// [m] Displacements of the same chain after the steps: M (ca z + ...) + K (x + z) = f is solved from the free end,
/// where every operation adds positive numbers, and extensions are carried, so that no digit is lost at any stiffness.
fn displacements(k: &[f64], method: &str, h: f64) -> Vec<f64> {
    let n = k.len();
    let newmark = method == "newmark";
    let ca = if newmark { 4.0 / (h * h) } else { 1.0 / (h * h) };
    let force = |i: usize| if i + 1 == n { PULL } else { 0.0 };
    let zero = || vec![0.0; n];
    let (mut x, mut extension, mut v) = (zero(), zero(), zero());
    let mut a: Vec<f64> = (0..n).map(|i| force(i) / MASS).collect();
    for _ in 0..STEPS {
        // Stiffness and load that the rest of the chain puts on every node.
        let (mut c, mut g) = (zero(), zero());
        for i in (0..n).rev() {
            let tension = |i: usize| k.get(i).map_or(0.0, |k| k * extension[i]);
            let inertia = if newmark { ca * h * v[i] + a[i] } else { v[i] / h };
            (c[i], g[i]) = (MASS * ca, force(i) - tension(i) + tension(i + 1) + MASS * inertia);
            if i + 1 < n {
                let share = k[i + 1] / (k[i + 1] + c[i + 1]);
                c[i] += share * c[i + 1];
                g[i] += share * g[i + 1];
            }
        }
        let mut before = 0.0;
        for i in 0..n {
            let longer = (g[i] - c[i] * before) / (k[i] + c[i]);
            let z = before + longer;
            extension[i] += longer;
            x[i] += z;
            if newmark {
                let next = ca * (z - h * v[i]) - a[i];
                v[i] += 0.5 * h * (a[i] + next);
                a[i] = next;
            } else {
                v[i] = z / h;
            }
            before = z;
        }
    }
    x
}

fn with_solver(case: &Value, linear: &str, strategy: &str) -> Run {
    let strategy = format!("\"{strategy}\"");
    run(&case_of(case, &[("solver.linear", linear), ("solver.newton.strategy", &strategy)]))
}

/// Whether a run came to its end; else it must say which solver to take, if its own has failed.
fn completed(run: &Run, what: &str) -> bool {
    if run.outcome.status == Status::Completed {
        return true;
    }
    let failure = run.outcome.failure.as_ref().unwrap_or_else(|| panic!("{what}: {:?}", run.outcome.status));
    assert_eq!(run.outcome.status, Status::NotConverged, "{what}: {failure:?}");
    if failure.cause.contains("conjugate gradients") {
        assert!(failure.advice.contains("\"linear\": \"cholesky\""), "{what}: {failure:?}");
    }
    false
}

/// Springs whose stiffnesses stand by up to 1e14 apart: what is completed is right to a thousandth of the motion,
/// whichever solver was forced. Conjugate gradients once left soft springs where they were (all of the motion missing,
/// status 0), and factorisations were up to twice the motion off at 1e14.
#[test]
fn stiffness_ratios_never_give_a_wrong_answer() {
    let (mut runs, mut refused, mut wrong) = (0, 0, Vec::new());
    for n in [12, 40] {
        for power in (0..=14).step_by(2) {
            let stiff = 10_f64.powi(power);
            let alternating: Vec<f64> = (0..n).map(|i| if i % 2 == 0 { 1.0 } else { stiff }).collect();
            let one_soft: Vec<f64> = (0..n).map(|i| if i == n / 2 { 1.0 } else { stiff }).collect();
            for (pattern, k) in [("alternating", &alternating), ("one soft", &one_soft)] {
                for (method, h) in
                    [("newmark", 1e-2), ("newmark", 1.0), ("backward-euler", 1e-2), ("backward-euler", 1.0)]
                {
                    let (case, expected) = (chain(k, method, h), displacements(k, method, h));
                    let size = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                    for (linear, strategies) in SOLVERS {
                        for strategy in strategies {
                            let what =
                                format!("{n} springs {pattern}, 1e{power}, {method} at {h}, {linear} {strategy}");
                            let found = with_solver(&case, linear, strategy);
                            runs += 1;
                            if !completed(&found, &what) {
                                refused += 1;
                                // Factorisations solve all of them, and so does what chooses.
                                assert_eq!(linear, "cg", "{what}: {:?}", found.outcome.failure);
                                assert!(power > 2, "{what}: {:?}", found.outcome.failure);
                                continue;
                            }
                            let off = expected.iter().zip(&found.positions[1..]).zip(&found.reference[1..]);
                            let off = off.fold(0.0_f64, |most, ((x, to), from)| most.max((to[0] - from[0] - x).abs()));
                            if off > 1e-3 * size {
                                wrong.push(format!("{what}: {:.1e} of the motion off", off / size));
                            }
                        }
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {runs}:\n{}", wrong.len(), wrong.join("\n"));
    assert!(runs == 1792 && refused < runs / 4, "{refused} of {runs} refused");
}

/// The same on a hanging sheet with every seventh spring stiff, taut or slack, against LU in every iteration.
#[test]
fn stiff_springs_in_a_sheet_never_give_a_wrong_answer() {
    let (mut compared, mut wrong) = (0, Vec::new());
    let ids = |stiff: bool| (0..161).filter(|i| (i % 7 == 0) == stiff).collect::<Vec<u32>>();
    for slack in [None, Some("tension-only")] {
        for power in (0..=12).step_by(3) {
            for (method, h) in [("newmark", 1e-3), ("backward-euler", 1e-2)] {
                let mut springs = [
                    json!({"on": {"ids": ids(true)}, "stiffness": 100.0 * 10_f64.powi(power)}),
                    json!({"on": "all", "stiffness": 100.0}),
                ];
                if let Some(slack) = slack {
                    springs.iter_mut().for_each(|rule| rule["slack"] = slack.into());
                }
                let case = json!({
                    "name": "sheet",
                    "system": {"network": {
                        "mesh": {"rectangle": {"width": 1, "height": 1, "columns": 7, "rows": 7, "pattern": "regular"}},
                        "mass": {"areal_density": 0.5},
                        "springs": springs,
                        "supports": [{"on": "boundary", "fix": "xyz"}],
                        "gravity": [0, 0, -9.81]
                    }},
                    "time": {"end": h * STEPS as f64, "method": method, "step": h}
                });
                let reference = with_solver(&case, "lu", "full");
                let what = format!("1e{power}, {method} at {h}, {slack:?}");
                if !completed(&reference, &what) {
                    continue;
                }
                for (linear, strategies) in SOLVERS {
                    for strategy in strategies {
                        let what = format!("{what}, {linear} {strategy}");
                        let found = with_solver(&case, linear, strategy);
                        if !completed(&found, &what) {
                            continue;
                        }
                        compared += 1;
                        let off = apart(&reference, &found);
                        if off > 1e-3 {
                            wrong.push(format!("{what}: {off:.1e} of the motion off"));
                        }
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {compared}:\n{}", wrong.len(), wrong.join("\n"));
    assert!(compared > 150, "{compared}");
}
