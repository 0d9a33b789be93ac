//! Short steps of stiff springs in long steps of all else: the scheme beside its equations, its limits, its work.

use crate::common::run::{apart, asset, case_of, changed, run};
use canopy_fem::analysis::spectrum::Spectrum;
use canopy_fem::case::Case;
use canopy_fem::drive::Status;
use canopy_fem::simulation::build_scene;
use serde_json::{Value, json};

/// [N/m] springs of the chain, whose masses are 0.1 kg at unit distances along x
const STIFFNESS: [f64; 6] = [1e4, 1e4, 10.0, 10.0, 10.0, 10.0];
/// [N s/m] their relative dashpots
const DASHPOT: [f64; 6] = [0.5, 0.5, 0.02, 0.02, 0.02, 0.02];
/// [kg]
const MASS: f64 = 0.1;
/// [m/s] of the last mass at the start
const PULL: f64 = 0.3;

/// Masses on a line that move along it. The springs at masses 1 and 2 are stiff, among them one that is soft.
fn chain(network: Value, time: Value) -> Case {
    let nodes: Vec<[f64; 3]> = (0..=STIFFNESS.len()).map(|i| [i as f64, 0.0, 0.0]).collect();
    let edges: Vec<[usize; 2]> = (0..STIFFNESS.len()).map(|i| [i, i + 1]).collect();
    let velocity: Vec<[f64; 3]> = (0..=STIFFNESS.len()).map(|i| [if i == 6 { PULL } else { 0.0 }, 0.0, 0.0]).collect();
    let springs: Vec<Value> = STIFFNESS
        .iter()
        .zip(DASHPOT)
        .enumerate()
        .map(|(i, (k, c))| json!({"on": {"ids": [i]}, "stiffness": k, "dashpot": {"relative": {"coefficient": c}}}))
        .collect();
    let mut base = json!({
        "mesh": {"explicit": {"nodes": nodes, "springs": edges}},
        "mass": {"nodal": MASS},
        "springs": springs,
        "supports": [{"on": {"ids": [0]}, "fix": "xyz"}, {"on": "all", "fix": "yz"}],
        "initial": {"velocity": velocity},
        "gravity": [1.5, 0, 0]
    });
    for (key, value) in network.as_object().into_iter().flatten() {
        base[key] = value.clone();
    }
    case_of(&json!({"name": "chain", "system": {"network": base}, "time": time}), &[])
}

fn multirate(substeps: u32) -> Value {
    json!({"multirate": {"substeps": substeps}})
}

/// The equations by hand, with which springs are stiff written down: displacements and velocities of masses 1 to 6.
fn by_hand(h: f64, substeps: u32, steps: u32) -> [[f64; 6]; 2] {
    let (stiff, slow) = ([0, 1, 2], [3, 4, 5]);
    let forces = |springs: &[usize], x: &[f64; 6], v: &[f64; 6]| {
        let mut a = [0.0; 6];
        for &i in springs {
            let of = |u: &[f64; 6]| u[i] - if i > 0 { u[i - 1] } else { 0.0 };
            let pull = (STIFFNESS[i] * of(x) + DASHPOT[i] * of(v)) / MASS;
            a[i] -= pull;
            if i > 0 {
                a[i - 1] += pull;
            }
        }
        a
    };
    let others = |x: &[f64; 6], v: &[f64; 6]| forces(&slow, x, v).map(|a| a + 1.5);
    let add = |v: &mut [f64; 6], h: f64, a: &[f64; 6]| v.iter_mut().zip(a).for_each(|(v, a)| *v += h * a);
    let (mut x, mut v) = ([0.0; 6], [0.0, 0.0, 0.0, 0.0, 0.0, PULL]);
    let (mut s, mut g) = (forces(&stiff, &x, &v), others(&x, &v));
    let short = h / f64::from(substeps);
    for _ in 0..steps {
        add(&mut v, 0.5 * h, &g);
        for _ in 0..substeps {
            add(&mut v, 0.5 * short, &s);
            let drift = v;
            add(&mut x, short, &drift);
            s = forces(&stiff, &x, &v);
            add(&mut v, 0.5 * short, &s);
        }
        g = others(&x, &v);
        add(&mut v, 0.5 * h, &g);
    }
    [x, v]
}

/// Positions and velocities after 200 steps.
#[test]
fn a_chain_moves_as_its_equations_say() {
    for substeps in [2, 5] {
        let ran = run(&chain(json!({}), json!({"end": 0.2, "step": 1e-3, "method": multirate(substeps)})));
        assert_eq!(ran.outcome.status, Status::Completed);
        let [x, v] = by_hand(1e-3, substeps, 200);
        for i in 0..6 {
            let found = [ran.positions[i + 1][0] - (i + 1) as f64, ran.velocities[i + 1][0]];
            for (found, expected) in found.into_iter().zip([x[i], v[i]]) {
                assert!((found - expected).abs() < 1e-11, "{substeps}: mass {}: {found}, {expected}", i + 1);
            }
        }
    }
}

#[test]
fn one_short_step_is_central_differences() {
    let time = |method: Value| json!({"end": 0.2, "step": 1e-3, "method": method});
    let [one, plain] = [multirate(1), json!("central-difference")].map(|method| run(&chain(json!({}), time(method))));
    assert_eq!(one.state, plain.state);
    assert_eq!(one.outcome.counters, plain.outcome.counters);
}

/// What dashpots take, short steps and long ones, is what a method of order eight finds, to the error of the motion.
#[test]
fn the_ledger_has_the_work_of_short_steps() {
    let time = |method: Value, step: f64| json!({"end": 0.5, "step": step, "method": method});
    let exact = run(&chain(json!({}), time(json!("dop853"), 1e-4))).outcome.ledger;
    let found = |step| run(&chain(json!({}), time(multirate(5), step))).outcome.ledger;
    let off = |step| (found(step).dissipated / exact.dissipated - 1.0).abs();
    let [coarse, fine] = [off(1e-3), off(5e-4)];
    println!("dissipated: off by {coarse:e} and {fine:e}");
    assert!(exact.dissipated > 0.0 && coarse < 1e-2 && fine < 0.7 * coarse);
    let largest = exact.kinetic + exact.elastic + exact.dissipated;
    assert!(found(1e-3).numerical.abs() < 1e-3 * largest, "{:e} of {largest:e}", found(1e-3).numerical);
}

fn critical(case: &Case) -> f64 {
    let scene = build_scene(case.problem().clone().take_system(), 1).expect("the case is good");
    Spectrum::of(&*scene, scene.initial_state().as_ref()).critical_step(&case.problem().method).step
}

/// Springs set the limit: so many times that of central differences.
#[test]
fn the_limit_of_springs_is_so_many_times_longer() {
    let case = chain(json!({}), json!({"end": 2.0, "step": 1e-3, "method": "central-difference"}));
    let limit = critical(&case);
    for substeps in [2, 5, 8] {
        let method = multirate(substeps).to_string();
        let case = changed(&case, &[("time.method", &method)]);
        let found = critical(&case);
        assert!((found / limit - f64::from(substeps)).abs() < 0.01, "{substeps}: {found} where one step has {limit}");
        let stable = run(&changed(&case, &[("time.step", &(0.98 * found).to_string())])).outcome;
        assert_eq!(stable.status, Status::Completed, "{:?}", stable.failure);
        let unstable = run(&changed(&case, &[("time.step", &(1.1 * found).to_string())])).outcome;
        assert_eq!(unstable.status, Status::Diverged, "{substeps} beyond {found}");
    }
}

/// Other forces set it: damping by mass, which no short step makes, allows 2 over its rate; beside stiff springs with
/// dashpots and without.
#[test]
fn the_limit_of_other_forces_stays() {
    let time = json!({"end": 2.0, "step": 4.5e-3, "method": multirate(8)});
    let case = chain(json!({"damping": {"rayleigh": {"mass": 400.0}}}), time);
    let found = critical(&case);
    assert!((0.9 * 0.005..=0.005).contains(&found), "{found}");
    for (rate, substeps) in [(400.0, 8), (200.0, 2), (200.0, 3), (200.0, 6)] {
        for dashpot in [0.5, 0.0] {
            let (rate, method) = (rate.to_string(), multirate(substeps).to_string());
            let mut sets = vec![("system.network.damping.rayleigh.mass", rate.as_str()), ("time.method", &method)];
            let dashpot = dashpot.to_string();
            let stiff = [0, 1].map(|i| format!("system.network.springs.{i}.dashpot.relative.coefficient"));
            sets.extend(stiff.iter().map(|key| (key.as_str(), dashpot.as_str())));
            let case = changed(&case, &sets);
            let found = critical(&case);
            let stable = run(&changed(&case, &[("time.step", &(0.95 * found).to_string())])).outcome;
            let what = format!("{sets:?}: {found}, {:?}", stable.failure);
            assert_eq!(stable.status, Status::Completed, "{what}");
        }
    }
    let with = |step: f64| run(&changed(&case, &[("time.step", &step.to_string())])).outcome.status;
    assert_eq!([with(found), with(1.4 * found)], [Status::Completed, Status::Diverged]);
}

/// The C-9 in long steps of six times those that central differences need: the same motion from a third of the passes.
#[test]
fn a_parachute_takes_a_third_of_the_work() {
    let case = asset("parachute/c9-drop", &[("time.end", "0.02"), ("time.method", "central-difference")]);
    let with =
        |method: Value, step: &str| run(&changed(&case, &[("time.method", &method.to_string()), ("time.step", step)]));
    let reference = with(json!("central-difference"), "2e-6");
    let plain = with(json!("central-difference"), "8e-6");
    let found = with(multirate(6), "4e-5");
    let passes = |run: &canopy_fem::drive::Outcome| run.counters.force_evaluations as f64;
    let (off, less) = (apart(&reference, &found), passes(&plain.outcome) / passes(&found.outcome));
    println!("off by {off:e} (single steps: {:e}), {less:.2} times fewer passes", apart(&reference, &plain));
    assert!(off < 1e-4 && less > 2.4, "{off:e}, {less}");
}
