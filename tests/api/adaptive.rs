//! Adaptive steps: what is dropped leaves no trace, and what no step can follow ends with a diagnosis.

use crate::common::run::{asset, case_of, changed, run};
use canopy_fem::case::Case;
use canopy_fem::case::spec::Problem;
use canopy_fem::drive::observer::{AcceptedStep, Energies, ObserveError, Observer, Point, Resumable};
use canopy_fem::drive::{self, Outcome, Status};
use canopy_fem::integrate::Counters;
use canopy_fem::integrate::registry::{Family, methods};
use canopy_fem::integrate::stepper::Attempt;
use canopy_fem::model::state::State;
use canopy_fem::simulation::{bind, build_scene};
use serde_json::{Value, json};
use std::sync::atomic::AtomicBool;

/// A small cloth that goes slack, in a gust that begins and ends within a hundredth of a millisecond: every corner
/// makes steps fail.
fn gusty(method: &str, tolerance: &str) -> Case {
    let wind = "[[0, 0, 0, 5], [0.02, 0, 0, 5], [0.02001, 0, 0, 60], [0.03, 0, 0, 60], [0.03001, 0, 0, 5]]";
    asset(
        "cloth-k1000",
        &[
            ("system.network.mesh.annulus.nodes", "60"),
            ("system.network.mesh.annulus.boundary_nodes", "30"),
            ("system.network.springs.0.slack", "tension-only"),
            ("system.network.aero.wind", &format!("{{\"table\": {wind}}}")),
            ("time.end", "0.05"),
            ("time.step", "null"),
            ("time.tolerance", tolerance),
            ("time.method", method),
        ],
    )
}

const LOOSE: &str = r#"{"relative": 1e-3, "absolute": 1e-5}"#;

/// Times of accepted states, and of those at which the scheme began anew.
#[derive(Default)]
struct Times {
    all: Vec<f64>,
    anew: Vec<f64>,
}

impl Observer for Times {
    fn started(&mut self, at: &Point, _ledger: Energies) -> Result<(), ObserveError> {
        self.all.push(at.state.t);
        Ok(())
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        self.all.push(step.t);
        Ok(())
    }

    fn resumable(&mut self, at: &Resumable<'_>) -> Result<(), ObserveError> {
        self.anew.extend(at.adaptive.filter(|state| state.restarts()).map(|_| at.at.state.t));
        Ok(())
    }
}

fn times(problem: &Problem) -> (Outcome, Times) {
    let scene = build_scene(problem.system.clone(), 1).expect("the case is good");
    let mut stepper = bind(problem, &*scene).expect("the method fits");
    let (mut times, stop) = (Times::default(), AtomicBool::new(false));
    let outcome = drive::run(&*scene, &mut stepper, &problem.run_spec(), &mut [&mut times], &stop).expect("starts");
    (outcome, times)
}

/// The same steps made one after another, with no attempt dropped between them, and new beginnings where they were.
fn replayed(problem: &Problem, times: &Times) -> State {
    let scene = build_scene(problem.system.clone(), 1).expect("the case is good");
    let mut stepper = bind(problem, &*scene).expect("the method fits");
    let mut from = Point { state: scene.initial_state(), forces: scene.new_forces() };
    scene.evaluate(from.state.as_ref(), &mut from.forces);
    stepper.start(&from).expect("a small scene");
    let (mut to, mut counters) = (from.clone(), Counters::default());
    for &t_next in &times.all[1..] {
        if times.anew.contains(&from.state.t) {
            stepper.restart(&from);
        }
        let h = t_next - from.state.t;
        let report =
            stepper.attempt(Attempt { from: &from, h, t_next }, &mut to, &mut counters).expect("was made before");
        if !report.forces_at_end {
            scene.evaluate(to.state.as_ref(), &mut to.forces);
        }
        stepper.accept();
        std::mem::swap(&mut from, &mut to);
    }
    from.state
}

fn bits(state: &State) -> Vec<u64> {
    state.x.iter().chain(&state.v).map(|v| v.to_bits()).collect()
}

/// A dropped attempt is restored to the bit: a run ends where its accepted steps alone lead.
#[test]
#[ignore = "long"]
fn dropped_attempts_leave_no_trace() {
    let mut with_drops = 0;
    let kept = methods().iter().filter(|m| m.family == Family::Implicit).map(|m| (m, "quasi"));
    for (method, strategy) in methods().iter().map(|m| (m, "auto")).chain(kept) {
        // Stiff, with a tolerance that lets explicit steps run into their limit, and Newton's into its two iterations.
        let iterations = if strategy == "auto" { "2" } else { "12" };
        let sets = [
            ("solver.newton.max_iterations", iterations),
            ("solver.newton.strategy", strategy),
            ("system.network.springs.0.stiffness", "100000"),
        ];
        let case = changed(&gusty(method.name, r#"{"relative": 0.1, "absolute": 1e-3}"#), &sets);
        let (outcome, times) = times(case.problem());
        assert_eq!(outcome.status, Status::Completed, "{}: {:?}", method.name, outcome.failure);
        with_drops += u32::from(outcome.rejected_steps > 0);
        assert_eq!(times.all.len() as u64, outcome.steps + 1);
        assert!(times.anew.len() >= 4, "{}: begins anew at the table's corners, {:?}", method.name, times.anew);
        let (made, alone) = (run(&case), replayed(case.problem(), &times));
        assert!(bits(&made.state) == bits(&alone), "{}: a dropped attempt shows", method.name);
    }
    assert!(with_drops > 8, "only {with_drops} methods dropped an attempt");
}

/// Steps end at the rows of a table and at the end, to the bit; so a short gust between long steps is not jumped over.
#[test]
fn steps_end_at_corners() {
    let case = gusty("velocity-verlet", LOOSE);
    let (_, Times { all: times, .. }) = times(case.problem());
    for corner in [0.02, 0.02001, 0.03, 0.03001, 0.05] {
        assert!(times.contains(&corner), "no step ends at {corner}: {times:?}");
    }
    assert!(times.windows(2).all(|pair| pair[1] > pair[0]));

    // A mass at rest is kicked by 1 N for 2 ms in the middle of ten seconds: v = 0.002 m/s from then on.
    let kick = [[4.999, 0.0], [5.0, 1.0], [5.002, 1.0], [5.003, 0.0]];
    let work = 0.5 * 1e-3 + 2e-3 + 0.5 * 1e-3;
    for method in methods().iter().filter(|m| m.family != Family::MatrixFree) {
        let case = case_of(
            &json!({
                "name": "kick",
                "system": {"network": {
                    "mesh": {"explicit": {"nodes": [[0, 0, 0]], "springs": []}},
                    "mass": {"nodal": 1.0},
                    "loads": [{"on": "all", "force": [1, 0, 0], "table": kick}]
                }},
                "time": {"end": 10.0, "method": method.name, "tolerance": {"relative": 1e-2, "absolute": 1e-6}}
            }),
            &[],
        );
        let found = run(&case);
        let off = (found.velocities[0][0] / work - 1.0).abs();
        // What comes after the kick multiplies its error, which a scheme of order 1 has more of.
        assert!(
            off < if method.order == 1 { 0.2 } else { 2e-2 },
            "{}: v = {} after {} steps",
            method.name,
            found.velocities[0][0],
            found.outcome.steps
        );
    }
}

/// A step that Newton cannot solve is tried again smaller, and the run goes on.
#[test]
fn unsolved_steps_shrink() {
    for method in ["newmark", "hht", "backward-euler", "generalized-alpha"] {
        let loose = r#"{"relative": 0.5, "absolute": 1.0}"#;
        let case = changed(
            &gusty(method, loose),
            &[
                ("solver.newton", r#"{"strategy": "full", "max_iterations": 2}"#),
                ("system.network.springs.0.stiffness", "100000"),
            ],
        );
        let found = run(&case);
        assert_eq!(found.outcome.status, Status::Completed, "{method}: {:?}", found.outcome.failure);
        assert!(found.outcome.rejected_steps > 0, "{method}: two iterations are too few for some step");
        // With the tensions as unknowns, and on the exact tangent.
        assert!(found.most_iterations <= 4);
    }
}

/// Where rounding of positions is larger than what the tolerance allows, no step is small enough; the report says so
/// and names a node.
#[test]
fn a_floor_ends_in_a_diagnosis() {
    let case = |relative: f64, absolute: f64| -> Value {
        json!({
            "name": "far",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": [[1e7, 0, 0], [1e7 + 1.0, 0, 0]], "springs": [[0, 1]]}},
                "mass": {"nodal": 1.0},
                "springs": [{"on": "all", "stiffness": 1000.0}],
                "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
                "initial": {"velocity": [0.001, 0, 0]}
            }},
            "time": {"end": 10.0, "method": "velocity-verlet", "tolerance": {"relative": relative, "absolute": absolute}}
        })
    };
    let outcome = run(&case_of(&case(1e-12, 1e-18), &[])).outcome;
    assert_eq!(outcome.status, Status::NotConverged);
    let failure = outcome.failure.expect("said why");
    assert_eq!(failure.node, Some(1), "{failure:?}");
    for words in ["time tolerance", "rounding", "e-9 m in positions of 1.0e7 m"] {
        assert!(failure.cause.contains(words), "{}", failure.cause);
    }
    assert!(failure.advice.contains("raise time.tolerance"), "{}", failure.advice);
    // The advice works.
    assert_eq!(run(&case_of(&case(0.1, 1e-4), &[])).outcome.status, Status::Completed);
}

/// An explicit scheme at a loose tolerance runs into its stability limit, not into the ground: errors grow first, and
/// steps shrink.
#[test]
fn stiff_scenes_hold_explicit_steps_near_their_limit() {
    for (method, most) in [("velocity-verlet", 2.0), ("rk4", 2.0)] {
        let sets =
            [("time.step", "null"), ("time.tolerance", r#"{"relative": 0.3, "absolute": 0.1}"#), ("time.end", "0.05")];
        let case = changed(&asset("cloth-k100000", &sets), &[("time.method", method)]);
        let (outcome, times) = times(case.problem());
        assert_eq!(outcome.status, Status::Completed, "{method}: {:?}", outcome.failure);
        let problem = case.problem();
        let scene = build_scene(problem.system.clone(), 1).expect("the case is good");
        let rates = canopy_fem::analysis::spectrum::Spectrum::of(&*scene, scene.initial_state().as_ref()).rates();
        let critical = canopy_fem::analysis::limit::critical_step(&problem.method, rates);
        let mean = 0.05 / (times.all.len() - 1) as f64;
        assert!(
            mean < most * critical && mean > 0.3 * critical,
            "{method}: {mean:e} s a step, critical {critical:e} s"
        );
    }
}

/// A scene at rest until a load sets in: the error of velocity counts before anything has moved. (Explicit Euler's
/// positions say nothing of the load in the first step; two steps over the whole ramp once passed for exact.)
#[test]
fn a_late_load_is_met_at_every_tolerance() {
    let case = |method: &str, step: &Value| {
        let case = json!({
            "name": "late",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0]], "springs": [[0, 1]]}},
                "mass": {"nodal": 1.0},
                "springs": [{"on": "all", "stiffness": 10.0, "dashpot": {"relative": {"coefficient": 0.2}}}],
                "supports": [{"on": {"ids": [0]}, "fix": "xyz"}, {"on": {"ids": [1]}, "fix": "yz"}],
                "loads": [{"on": {"ids": [1]}, "force": [1, 0, 0], "table": [[3, 0], [4, 1]]}]
            }},
            "time": {"end": 8.0, "method": method, "step": step["step"], "tolerance": step["tolerance"]}
        });
        run(&case_of(&case, &[])).positions[1][0] - 1.0
    };
    let exact = case("rk4", &json!({"step": 1e-3}));
    for method in methods() {
        let relative = if method.order == 1 { 1e-2 } else { 1e-4 };
        let found = case(method.name, &json!({"tolerance": {"relative": relative, "absolute": 0.01 * relative}}));
        let off = (found - exact).abs() / exact.abs();
        assert!(off < 10.0 * relative, "{} at {relative:e}: {found}, exactly {exact}", method.name);
    }
}

/// Steps that a tolerance lets go above the limit of stiff dashpots for a moment: the motion stays right, and the
/// account does not lose what the dashpots took. Where it does, because the scheme makes energy, the run is doubted.
#[test]
fn dashpots_keep_their_account_where_steps_overshoot() {
    let ended = |method: &str, tolerance: f64| {
        let both = format!(r#"{{"relative": {tolerance:e}, "absolute": {:e}}}"#, 1e-2 * tolerance);
        let sets = [
            ("time.end", "0.2"),
            ("time.step", "null"),
            ("time.tolerance", both.as_str()),
            ("time.method", method),
            ("output.frames", "null"),
        ];
        let run = run(&asset("cloth-k1000", &sets));
        assert_eq!(run.outcome.status, Status::Completed, "{method} {tolerance}");
        run
    };
    let exact = ended("dop853", 1e-8);
    for (method, tolerance) in [("dormand-prince", 1e-3), ("dop853", 1e-3), ("rk4", 1e-2)] {
        let run = ended(method, tolerance);
        let (found, expected) = (run.outcome.ledger.dissipated, exact.outcome.ledger.dissipated);
        let far = crate::common::run::apart(&run, &exact);
        assert!(far < 2e-2, "{method} {tolerance}: the motion is {far} off");
        assert!((found - expected).abs() < 0.35 * expected, "{method} {tolerance}: {found} J of {expected} J");
    }
    for method in ["dormand-prince", "dop853", "improved-euler-pec"] {
        let run = ended(method, 1e-2);
        assert!(run.outcome.energy_doubt().is_some(), "{method}: {:?}", run.outcome.ledger);
    }
}

/// Where steps resolve an oscillation coarsely, around its turning points the ends of a step know nothing of what lies
/// between: the stages count.
#[test]
fn coarse_steps_that_resolve_keep_the_account_of_their_stages() {
    for (step, allowed) in [("0.4", 1e-9), ("0.8", 1e-6), ("1.2", 1e-4)] {
        let sets = [("time.step", step), ("time.end", "24"), ("time.method", "dop853"), ("output.frames", "null")];
        let run = run(&asset("oscillator-damped", &sets));
        let error = run.outcome.energy_error;
        assert!(error < allowed, "w h = 1.22 x {step}: {error}");
        assert!(run.outcome.ledger.dissipated > 0.1 * run.outcome.ledger.kinetic);
    }
}
