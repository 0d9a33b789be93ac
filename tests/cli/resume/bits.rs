//! For every method, on scenes with every kind of term: interrupted twice and resumed, the files are those of one run.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use canopy_fem::case::Case;
use canopy_fem::case::fingerprint::Fingerprint;
use canopy_fem::drive::observer::{AcceptedStep, Energies, ObserveError, Observer, Point, UpcomingStep, Wants};
use canopy_fem::drive::{self, Outcome, RunSpec, Status};
use canopy_fem::integrate::registry::{Family, MethodInfo, methods};
use canopy_fem::output::checkpoint::Checkpoint;
use canopy_fem::output::frame::Fields;
use canopy_fem::output::recorder::{CheckpointSpec, Recorder, RecorderSpec};
use canopy_fem::process::{Cost, Stopwatch};
use canopy_fem::simulation::{bind, build_scene};
use serde_json::{Value, json};

use super::folders::{assert_same, checkpoint};
use crate::bench::{SAIL, contents};
use crate::common::parachute::Parachute;
use crate::common::run::{asset, case_of, changed};

/// Sets the flag after a step.
struct StopAfter<'a> {
    step: u64,
    stop: &'a AtomicBool,
}

impl StopAfter<'_> {
    fn look(&self, step: u64) {
        if step >= self.step {
            self.stop.store(true, Ordering::Relaxed);
        }
    }
}

impl Observer for StopAfter<'_> {
    fn started(&mut self, _at: &Point, _ledger: Energies) -> Result<(), ObserveError> {
        self.look(0);
        Ok(())
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        self.look(step.step);
        Ok(())
    }

    fn wants(&self, step: UpcomingStep) -> Wants {
        Wants::end_if(step.step >= self.step)
    }
}

/// Watches nothing.
struct Nobody;

impl Observer for Nobody {
    fn accepted(&mut self, _step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        Ok(())
    }

    fn wants(&self, _step: UpcomingStep) -> Wants {
        Wants::ACCOUNT
    }
}

/// How a part of a run goes.
#[derive(Clone, Copy)]
struct Part {
    /// goes on from the checkpoint
    resume: bool,
    /// is interrupted after this step
    until: u64,
    threads: usize,
    keep_going: bool,
}

const WHOLE: Part = Part { resume: false, until: u64::MAX, threads: 1, keep_going: false };

/// What `solve` does, with an interrupt at a chosen step.
fn solve(case: &Case, dir: &Path, part: Part) -> Outcome {
    solve_watched(case, dir, part, &mut Nobody)
}

/// The same with an observer that sees each step before the recorder does.
fn solve_watched(case: &Case, dir: &Path, part: Part, watch: &mut dyn Observer) -> Outcome {
    let problem = case.problem();
    let fingerprint = Fingerprint::of(problem).expect("numbers");
    let scene = build_scene(problem.system.clone(), part.threads).expect("the case is good");
    let mut stepper = bind(problem, &*scene).expect("the method fits");
    let spec = RunSpec { keep_going: part.keep_going, ..problem.run_spec() };
    let fields = Fields {
        force: true,
        reaction: true,
        tension: true,
        strain: true,
        rest_length: false,
        pressure: false,
        membrane: false,
        crossing: true,
    };
    let recorded = RecorderSpec { fields, ..RecorderSpec::of(problem, dir) };
    let kept = CheckpointSpec {
        case: fingerprint.clone(),
        every: problem.output.checkpoint_every,
        stopwatch: Stopwatch::start(Cost::default()),
    };
    let stop = AtomicBool::new(false);
    let mut stopper = StopAfter { step: part.until, stop: &stop };
    if part.resume {
        let checkpoint = Checkpoint::read(&dir.join("checkpoint.bin"), &fingerprint).expect("a checkpoint");
        let mut recorder =
            Recorder::resume(&*scene, &recorded, &checkpoint).expect("the files are there").with_checkpoints(kept);
        let observers: &mut [&mut dyn Observer] = &mut [watch, &mut recorder, &mut stopper];
        drive::resume(&*scene, &mut stepper, &spec, checkpoint.snapshot, observers, &stop).expect("it goes on")
    } else {
        let mut recorder = Recorder::new(&*scene, &recorded).expect("a folder").with_checkpoints(kept);
        let observers: &mut [&mut dyn Observer] = &mut [watch, &mut recorder, &mut stopper];
        drive::run(&*scene, &mut stepper, &spec, observers, &stop).expect("it starts")
    }
}

/// An interrupted and twice resumed run against one in one piece: files, counters, energy account.
fn assert_resumes(case: &Case, stops: [u64; 2], what: &str) {
    let (whole, parts) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
    let expected = solve(case, whole.path(), WHOLE);
    assert_eq!(expected.status, Status::Completed, "{what}");
    for (i, until) in stops.into_iter().enumerate() {
        let part = solve(case, parts.path(), Part { resume: i > 0, until, threads: 1 + i, ..WHOLE });
        assert_eq!(part.status, Status::Interrupted, "{what}");
        assert!((until..until + 2).contains(&part.steps), "{what}: {} steps", part.steps);
    }
    let found = solve(case, parts.path(), Part { resume: true, ..WHOLE });
    assert_eq!((found.status, found.steps, found.t_end), (expected.status, expected.steps, expected.t_end), "{what}");
    assert_eq!((found.counters, &found.doubt), (expected.counters, &expected.doubt), "{what}");
    assert_eq!(
        (found.ledger, found.energy_error, found.energy_made),
        (expected.ledger, expected.energy_error, expected.energy_made),
        "{what}"
    );
    if case.problem().output.checkpoint_every.is_none() {
        std::fs::remove_file(parts.path().join("checkpoint.bin")).expect("the interrupt's");
    }
    assert_same(parts.path(), whole.path(), what);
}

/// 50 steps, frames between them, a row every third, so that frames and rows are under way wherever the run is stopped.
fn sail() -> Value {
    let mut case: Value = serde_json::from_str(SAIL).expect("JSON");
    case["time"]["end"] = json!(0.497);
    case["output"]["frames"]["every"] = json!(0.035);
    case["output"]["history"]["every"] = json!(3);
    case
}

/// The same sail without air, follower pressure and axial dashpots: its matrices are symmetric.
fn calm() -> Value {
    let mut case = sail();
    let network = case["system"]["network"].as_object_mut().expect("a network");
    network.retain(|key, _| key != "aero" && key != "loads");
    network["springs"][0]["dashpot"] = json!({"relative": {"coefficient": 0.2}});
    network["springs"][0]["slack"] = json!("tension-only");
    case
}

/// The same without dashpots: forces follow from positions alone.
fn free() -> Value {
    let mut case = calm();
    case["system"]["network"].as_object_mut().expect("a network").remove("damping");
    case["system"]["network"]["springs"][0].as_object_mut().expect("springs").remove("dashpot");
    case
}

/// The sail of membranes that wrinkle, with bars of finite strain along its springs.
fn membrane() -> Value {
    let mut case = sail();
    let network = &mut case["system"]["network"];
    network["springs"] = json!([{"on": "all", "stiffness": 10.0, "law": "green", "slack": "tension-only"}]);
    network["membranes"] = json!([{
        "on": "all", "thickness": 1e-3, "modulus": [4e4, 3e4], "poisson": 0.2, "shear": 5e3, "warp": [1, 0, 0],
        "wrinkling": true, "damping_time": 0.01
    }]);
    network["bending"] = json!([{"on": "all", "stiffness": 0.01}]);
    case
}

fn pendulum() -> Value {
    json!({
        "name": "pendulum",
        "system": {"pendulum": {"length": 1.0, "mass": 2.0, "damping": 0.3, "gravity": 9.81, "angle": 2.0, "rate": 0.5}},
        "time": {"end": 0.497, "step": 0.01, "method": "newmark"},
        "output": {"frames": {"every": 0.035}, "probes": [{"name": "bob", "on": "all"}], "history": {"every": 3}}
    })
}

/// Some methods need springs, and some of these springs of a constant stiffness.
fn fits(method: &MethodInfo, scene: &Value) -> bool {
    let network = &scene["system"]["network"];
    let linear = network["springs"][0].get("law").is_none();
    (method.family != Family::MatrixFree || !network.is_null()) && (!method.linear.solves_dashpots || linear)
}

fn every_method(scene: &Value, what: &str) {
    let case = case_of(scene, &[]);
    for method in methods() {
        if !fits(method, scene) {
            continue;
        }
        let case = changed(&case, &[("time.method", method.name)]);
        for stops in [[7, 31], [0, 49]] {
            assert_resumes(&case, stops, &format!("{} of the {what}, stopped at {stops:?}", method.name));
        }
    }
}

/// A factor that is kept over many steps is there after the resumption too, with fixed steps and adaptive ones.
#[test]
fn a_kept_factor_is_made_again() {
    let adaptive = [("time.step", "null"), ("time.tolerance", r#"{"relative": 1e-3, "absolute": 1e-3}"#)];
    for (scene, what) in [(sail(), "sail"), (calm(), "calm sail")] {
        for method in methods().iter().filter(|m| m.family == Family::Implicit) {
            for (strategy, linear) in
                [("modified", "auto"), ("quasi", "auto"), ("quasi", "cg"), ("modified", "cholesky")]
            {
                // Their tangents are not symmetric.
                if linear == "cholesky" && (what == "sail" || method.name == "energy-momentum") {
                    continue;
                }
                let sets =
                    [("time.method", method.name), ("solver.newton.strategy", strategy), ("solver.linear", linear)];
                let case = case_of(&scene, &sets);
                let whole = solve(&case, tempfile::tempdir().expect("a folder").path(), WHOLE);
                assert!(
                    whole.counters.factorizations < whole.counters.newton_iterations,
                    "{strategy}, {linear} keeps no factor in {} of the {what}: {:?}",
                    method.name,
                    whole.counters
                );
                assert_resumes(&case, [7, 31], &format!("{} of the {what}, {strategy}, {linear}", method.name));
                let case = case_of(&scene, &[&sets[..], &adaptive, &[("output.history", "null")]].concat());
                assert_resumes(
                    &case,
                    [2, 4],
                    &format!("{} of the {what}, {strategy}, {linear}, adaptive", method.name),
                );
            }
        }
    }
}

#[test]
fn every_method_resumes_with_the_same_bits_in_the_wind() {
    every_method(&sail(), "sail");
}

#[test]
fn every_method_resumes_with_the_same_bits_without_wind() {
    every_method(&calm(), "calm sail");
}

#[test]
fn every_method_resumes_membranes_with_the_same_bits() {
    every_method(&membrane(), "sail of membranes");
}

#[test]
fn every_method_resumes_the_pendulum_with_the_same_bits() {
    every_method(&pendulum(), "pendulum");
}

/// Steps made in one go end where a run is kept or stopped.
#[test]
fn of_a_sail_without_damping() {
    every_method(&free(), "free sail");
    let case = case_of(&free(), &[("output.checkpoint.every", "0.07"), ("output.frames", "null")]);
    for method in ["velocity-verlet", "euler-cromer"] {
        let case = changed(&case, &[("time.method", method)]);
        for stops in [[7, 31], [22, 23]] {
            assert_resumes(&case, stops, &format!("{method} of the free sail with checkpoints, stopped at {stops:?}"));
        }
    }
}

/// Adaptive steps: their size, the errors and the motion that they depend on go on where they were, and so do rows of
/// the history by time. HHT's carried acceleration depends on the step that made it.
#[test]
fn every_method_resumes_adaptive_steps_with_the_same_bits() {
    let scenes = [(sail(), "sail"), (calm(), "calm sail"), (membrane(), "sail of membranes"), (pendulum(), "pendulum")];
    for (scene, what) in scenes {
        for method in methods() {
            if !fits(method, &scene) {
                continue;
            }
            let tolerance = if method.order == 1 { "3e-2" } else { "1e-4" };
            let tolerance = format!("{{\"relative\": {tolerance}, \"absolute\": 1e-3}}");
            let sets = [
                ("time.step", "null"),
                ("time.tolerance", tolerance.as_str()),
                ("time.method", method.name),
                ("output.history", "null"),
            ];
            // The halves of the first steps and of steps after a corner are taken together: a run stops after both.
            let case = case_of(&scene, &sets);
            let steps = solve(&case, tempfile::tempdir().expect("a folder").path(), WHOLE).steps;
            let stops = [2, (steps / 4 * 2).max(4)];
            assert_resumes(
                &case,
                stops,
                &format!("{} of the {what} in {steps} adaptive steps, {stops:?}", method.name),
            );
        }
    }
}

/// A parachute that falls, with all its air.
#[test]
fn of_a_parachute() {
    let small = Parachute { gores: 6, rings: 3, line_segments: 2, nominal_diameter: 2.0, line_length: 2.0 };
    let mut scene = small.case(1.7, 4.0, 6.0);
    scene["time"]["end"] = serde_json::json!(0.006);
    scene["time"]["step"] = serde_json::json!(0.0001);
    let aero = &mut scene["system"]["network"]["aero"];
    aero["wind"] =
        serde_json::json!({"sum": [[1, 0, 0], {"gust": {"velocity": [0, 2, 0], "start": 0.001, "duration": 0.004}}]});
    aero["atmosphere"] = serde_json::json!("isa");
    aero["drag"] = serde_json::json!([{"on": "lines", "diameter": 0.004, "coefficient": 1.1}]);
    let table = scene["system"]["network"]["aero"]["canopy"]["table"].to_string();
    let cavity = "{\"inflow\": 0.5, \"outer_pressure_coefficient\": -0.6, \
                  \"law\": {\"permeable\": {\"a\": 1.6e6, \"b\": 4.8e5, \"thickness\": 1e-4}}}";
    for (apparent, table, cavity) in [("null", &*table, "null"), ("1.0", &*table, "null"), ("1.0", "null", cavity)] {
        for method in ["velocity-verlet", "rk4", "newmark", "hht"] {
            let sets = [
                ("time.method", method),
                ("system.network.aero.canopy.apparent_mass", apparent),
                ("system.network.aero.canopy.table", table),
                ("system.network.aero.canopy.cavity", cavity),
            ];
            let what = format!("{method} of a parachute, {apparent}, {cavity}");
            assert_resumes(&case_of(&scene, &sets), [7, 31], &what);
        }
    }
}

/// A canopy that fills ring by ring, with fixed and with adaptive steps.
#[test]
fn of_a_canopy_that_fills() {
    let groups = ["radials", "cloth", "vent-lines", "lines"];
    let springs = groups.map(|group| {
        json!({"on": {"group": group}, "axial_rigidity": 4e3, "slack": "tension-only",
               "dashpot": {"axial": {"time": 1e-3}}})
    });
    let scene = json!({
        "name": "tube",
        "system": {"network": {
            "mesh": {"parachute": {
                "type": "flat-circular", "nominal_diameter": 3.0, "gores": 6, "vent_diameter": 0.2,
                "radial_segments": 4, "lines": {"length": 2.5}, "start": "stretched"
            }},
            "mass": {"areal_density": 0.05, "points": [{"on": {"group": "payload"}, "mass": 12.0}]},
            "springs": springs,
            "gravity": [0, 0, -9.81],
            "aero": {"canopy": {"on": {"group": "canopy"}, "filling": {
                "law": {"permeable": {"a": 1.6e6, "b": 4.8e5, "thickness": 1e-4}}
            }}},
            "initial": {"velocity": [0, 0, -30.0]}
        }},
        "time": {"end": 0.08, "method": "newmark", "step": 2e-3},
        "output": {"frames": {"every": 0.02}}
    });
    for (method, step) in [("newmark", "2e-3"), ("hht", "2e-3"), ("velocity-verlet", "2e-4"), ("rk4", "2e-4")] {
        let case = case_of(&scene, &[("time.method", method), ("time.step", step)]);
        assert_resumes(&case, [7, 31], &format!("{method} of a canopy that fills"));
    }
}

/// Parameters, checkpoints of its own, and steps and frames that fall together or not at all.
#[test]
fn of_a_point() {
    for (key, value) in [("time.step", "0.002"), ("system.network.aero.canopy.apparent_mass", "1")] {
        let sets = [("system.network.model", "point"), ("time.end", "0.4"), (key, value)];
        assert_resumes(&asset("parachute/c9-drop", &sets), [23, 101], key);
    }
}

#[test]
fn other_outputs_resume_too() {
    for (sets, what) in [
        (&[("output.probes", "null"), ("output.frames.every", "0.001")][..], "ten frames a step, no probes"),
        (&[("output.frames", "null"), ("output.history.every", "100")], "only the ends"),
        (&[("output.frames.every", "0.02"), ("output.history.every", "1")], "frames at steps"),
        (&[("time.method", r#"{"hht": {"alpha": -0.3}}"#), ("output.checkpoint.every", "0.03")], "checkpoints"),
    ] {
        assert_resumes(&case_of(&sail(), sets), [30, 31], what);
    }
}

/// Copies a folder as it is right after a checkpoint was written, before the run goes on.
struct Copier<'a> {
    /// the checkpoint's step
    step: u64,
    from: &'a Path,
    to: &'a Path,
}

impl Observer for Copier<'_> {
    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        if step.step == self.step + 1 {
            while checkpoint(self.from).is_none_or(|found| found.snapshot.step < self.step) {
                std::thread::sleep(Duration::from_millis(1));
            }
            std::fs::create_dir(self.to.join("frames")).expect("a folder");
            for (path, bytes) in contents(self.from) {
                std::fs::write(self.to.join(path.strip_prefix(self.from).expect("below")), bytes).expect("a file");
            }
        }
        Ok(())
    }
}

/// What is on the disk when a checkpoint is, is all that is needed, though nothing else was told to write: rows and
/// frames that wait for more are written first. Beyond a thousand frames the collection waits too.
#[test]
fn a_checkpoint_has_its_results_beside_it() {
    let sets = [("time.end", "0.32"), ("output.frames.every", "0.0002"), ("output.checkpoint.every", "0.3")];
    let case = case_of(&sail(), &sets);
    let (whole, copy) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
    let mut copier = Copier { step: 30, from: whole.path(), to: copy.path() };
    solve_watched(&case, whole.path(), WHOLE, &mut copier);
    assert_eq!(checkpoint(copy.path()).expect("copied").snapshot.step, 30);
    solve(&case, copy.path(), Part { resume: true, ..WHOLE });
    assert_same(copy.path(), whole.path(), "resumed from a copy");
}

/// A run that was let go on past its blow-up still knows, after it was resumed, what happened first.
#[test]
fn the_first_trouble_is_kept() {
    let case = case_of(&sail(), &[("time.method", "explicit-euler"), ("time.step", "0.3"), ("time.end", "100")]);
    let (whole, parts) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
    let on = Part { keep_going: true, ..WHOLE };
    let expected = solve(&case, whole.path(), on);
    let found = expected.failure.clone().expect("it blows up");
    assert!(found.step < expected.steps, "it went on");
    solve(&case, parts.path(), Part { until: expected.steps - 1, ..on });
    let resumed = solve(&case, parts.path(), Part { resume: true, ..on });
    assert_eq!((resumed.status, resumed.steps), (Status::Diverged, expected.steps));
    assert_eq!(resumed.failure, expected.failure);
}

/// A run that was warned of before it was stopped is told as such after it was resumed.
#[test]
fn the_warning_is_kept() {
    let sets =
        [("time.method", "explicit-euler"), ("time.step", "0.02"), ("time.end", "3"), ("system.pendulum.damping", "0")];
    let case = case_of(&pendulum(), &sets);
    let (whole, parts) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
    let expected = solve(&case, whole.path(), WHOLE);
    assert!(expected.doubt.is_some() && expected.status == Status::Completed, "{:?}", expected.status);
    assert_eq!(solve(&case, parts.path(), Part { until: expected.steps - 1, ..WHOLE }).doubt, expected.doubt);
    assert_eq!(solve(&case, parts.path(), Part { resume: true, ..WHOLE }).doubt, expected.doubt);
}

/// Counts the checkpoints a run keeps, as they replace each other: at t = 0, at each interval, before the last step;
/// and none where nobody asked.
#[test]
fn checkpoints_are_kept_when_asked_for() {
    let dir = tempfile::tempdir().expect("a folder");
    let case = case_of(&sail(), &[("output.checkpoint.every", "0.2")]);
    for (until, at) in [(1, 1), (u64::MAX, 49)] {
        let outcome = solve(&case, dir.path(), Part { until, ..WHOLE });
        let found = checkpoint(dir.path()).expect("asked for");
        assert_eq!(found.snapshot.step, at, "{:?}", outcome.status);
        assert!(found.spent.wall.as_nanos() > 0);
    }
    let plain = tempfile::tempdir().expect("a folder");
    solve(&case_of(&sail(), &[]), plain.path(), WHOLE);
    assert!(checkpoint(plain.path()).is_none());
}

/// Supports that move, a base that shakes, and rest lengths that change.
#[test]
fn every_method_resumes_over_motion() {
    let mut scene = calm();
    let network = &mut scene["system"]["network"];
    let rule = network["springs"][0].clone();
    network["springs"] = json!([rule.clone(), rule]);
    network["springs"][0]["on"] = json!({"ids": [0, 1]});
    network["springs"][0]["rest_scale"] = json!({"table": [[0.0, 1.0], [0.1, 1.1], [0.3317, 0.9]]});
    network["supports"] = json!([
        {"on": {"ids": [0]}, "fix": "xyz", "motion": {"table": [[0, 0, 0, 0], [0.1213, 0.1, 0, 0.05], [0.3, 0, 0, 0]]}},
        {"on": {"ids": [3]}, "fix": "xz", "until": 0.2511, "motion": {"table": [[-1, 0.4, 0, 0], [1, -0.4, 0, 0]]}}
    ]);
    network["base_acceleration"] = json!({"table": [[0, 0, 0, 1], [0.1503, 1, 2, -3], [0.4, 0, 0, 0]]});
    scene["output"]["gauges"] = json!([{"name": "hold", "on": {"ids": [0, 3]}, "of": "reaction", "every": 4}]);
    let case = case_of(&scene, &[]);
    for method in methods() {
        let case = changed(&case, &[("time.method", method.name)]);
        for stops in [[7, 15], [13, 26], [21, 33]] {
            assert_resumes(&case, stops, &format!("{} over motion, stopped at {stops:?}", method.name));
        }
    }
    scene["time"] = json!({"end": 0.497, "method": "newmark", "tolerance": {"relative": 1e-4, "absolute": 1e-5}});
    for method in ["newmark", "hht", "velocity-verlet", "dormand-prince", "kang"] {
        let case = changed(&case_of(&scene, &[]), &[("time.method", method)]);
        assert_resumes(&case, [5, 30], &format!("{method} over motion, adaptive"));
    }
}

/// Supports that are released, springs that are cut, and gauges: a run that is interrupted before, between and after
/// the events has the bytes of one in one piece, on any number of threads.
#[test]
fn every_method_resumes_over_events() {
    let mut scene = calm();
    let network = &mut scene["system"]["network"];
    let rule = network["springs"][0].clone();
    network["springs"] = json!([rule.clone(), rule]);
    network["springs"][0]["on"] = json!({"ids": [0, 1]});
    network["springs"][0]["cut"] = json!(0.1234);
    network["springs"][0]["strength"] = json!(40.0);
    network["supports"] = json!([
        {"on": {"ids": [0]}, "fix": "xyz"}, {"on": {"ids": [3]}, "fix": "xyz", "until": 0.2},
        {"on": {"ids": [3]}, "fix": "z", "until": 0.3071}
    ]);
    scene["output"]["gauges"] = json!([
        {"name": "lines, all", "on": "all", "of": "tension"},
        {"name": "hold", "on": {"ids": [0, 3]}, "of": "reaction", "every": 4},
        {"name": "tip", "on": {"ids": [5]}, "of": "acceleration"}
    ]);
    let case = case_of(&scene, &[]);
    for method in methods() {
        let case = changed(&case, &[("time.method", method.name)]);
        for stops in [[7, 15], [13, 26], [21, 33]] {
            assert_resumes(&case, stops, &format!("{} over events, stopped at {stops:?}", method.name));
        }
    }
    scene["time"] = json!({"end": 0.497, "method": "newmark", "tolerance": {"relative": 1e-4, "absolute": 1e-5}});
    for method in ["newmark", "hht", "velocity-verlet", "dormand-prince", "kang"] {
        let case = changed(&case_of(&scene, &[]), &[("time.method", method)]);
        assert_resumes(&case, [5, 30], &format!("{method} over events, adaptive"));
    }
}
