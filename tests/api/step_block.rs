//! Steps made in one go, of which only the last state is seen, leave what steps made one by one leave: every file, byte
//! for byte, and every counter.

use crate::common::run::{case_of, changed};
use canopy_fem::case::Case;
use canopy_fem::drive::observer::{AcceptedStep, ObserveError, Observer, UpcomingStep, Wants};
use canopy_fem::drive::{self, Outcome, RunSpec, Status};
use canopy_fem::integrate::registry::methods;
use canopy_fem::output::frame::Fields;
use canopy_fem::output::recorder::{Recorder, RecorderSpec};
use canopy_fem::simulation::{bind, build_scene};
use serde_json::{Value, json};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Schemes that have blocks of steps.
const STRIDING: [&str; 3] = ["velocity-verlet", "central-difference", "euler-cromer"];

/// Lets steps be made in one go, or does not, and counts.
struct Witness {
    lets: bool,
    alone: u64,
    in_blocks: u64,
}

impl Observer for Witness {
    fn wants(&self, _step: UpcomingStep) -> Wants {
        if self.lets { Wants::ACCOUNT } else { Wants::default() }
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        if step.summary.is_some() {
            self.in_blocks += 1
        } else {
            self.alone += 1
        }
        assert_eq!(self.alone + self.in_blocks, step.step);
        assert!(step.end.is_none_or(|end| end.state.t == step.t));
        Ok(())
    }
}

/// Columns and rows of sheets: of four strips of nodes, and of one, whose nodes stay in its windows.
const SIZES: [[u32; 2]; 2] = [[69, 79], [18, 22]];

/// Sizes and schemes that have blocks of steps there.
fn striding() -> impl Iterator<Item = ([u32; 2], &'static str)> {
    SIZES.into_iter().flat_map(|size| STRIDING.map(|method| (size, method)))
}

fn sheet() -> Value {
    sheet_of(SIZES[0])
}

/// A sheet of springs, held along its edge, that falls and is thrown; taut springs, slack ones and short ones.
fn sheet_of([columns, rows]: [u32; 2]) -> Value {
    let middle = (columns + 1) * (rows + 1) / 2;
    // The same for every node, so that the critical steps are.
    let density = 20.0 * f64::from(columns * rows) / f64::from(SIZES[0][0] * SIZES[0][1]);
    json!({
        "name": "sheet",
        "system": {"network": {
            "mesh": {"rectangle": {"width": 1.0, "height": 1.1, "columns": columns, "rows": rows, "pattern": "regular"}},
            "mass": {"areal_density": density},
            "springs": [{"on": "all", "stiffness": 300.0, "slack": "tension-only"}],
            "supports": [{"on": "boundary", "fix": "xyz"}],
            "initial": {"velocity": [0.3, 0.1, 1.0]},
            "gravity": [0.0, 0.0, -9.81]
        }},
        "time": {"end": 0.06, "step": 1e-3, "method": "velocity-verlet"},
        "output": {
            "frames": {"every": 0.013}, "history": {"every": 1}, "probes": [{"name": "middle", "on": {"ids": [middle]}}]
        }
    })
}

/// How a case is run.
#[derive(Clone, Copy)]
struct How {
    threads: usize,
    keep_going: bool,
}

fn solve(case: &Case, dir: &Path, How { threads, keep_going }: How, lets: bool) -> (Outcome, Witness) {
    let problem = case.problem();
    let scene = build_scene(problem.system.clone(), threads).expect("the case is good");
    let mut stepper = bind(problem, &*scene).expect("the method fits");
    let recorded = RecorderSpec::of(problem, dir);
    let fields = Fields { force: true, reaction: true, tension: true, strain: true, ..recorded.fields };
    let recorded = RecorderSpec { fields, ..recorded };
    let mut recorder = Recorder::new(&*scene, &recorded).expect("a folder");
    let mut witness = Witness { lets, alone: 0, in_blocks: 0 };
    let stop = AtomicBool::new(false);
    let observers: &mut [&mut dyn Observer] = &mut [&mut recorder, &mut witness];
    let spec = RunSpec { keep_going, ..problem.run_spec() };
    let outcome = drive::run(&*scene, &mut stepper, &spec, observers, &stop).expect("it starts");
    (outcome, witness)
}

fn until_the_end(threads: usize) -> How {
    How { threads, keep_going: false }
}

fn files(dir: &Path) -> Vec<(String, Vec<u8>)> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(dir).expect("a folder").map(|entry| entry.expect("an entry").path()) {
        if entry.is_dir() {
            all.extend(files(&entry));
        } else {
            all.push((entry.display().to_string(), std::fs::read(&entry).expect("a file")));
        }
    }
    all.sort();
    all.iter_mut().for_each(|(name, _)| *name = name.rsplit('/').next().unwrap_or_default().to_owned());
    all
}

/// Both ways leave the same; returns the outcome and the steps that were made in blocks of steps.
fn assert_same(case: &Case, how: How, what: &str) -> (Outcome, u64) {
    let folders = [(), ()].map(|()| tempfile::tempdir().expect("a folder"));
    let (expected, alone) = solve(case, folders[0].path(), How { threads: 1, ..how }, false);
    let (found, witness) = solve(case, folders[1].path(), how, true);
    assert_eq!(alone.in_blocks, 0, "{what}");
    assert_eq!((found.status, found.steps, found.t_end), (expected.status, expected.steps, expected.t_end), "{what}");
    assert_eq!(found.counters, expected.counters, "{what}");
    assert_eq!((found.ledger, found.energy_error), (expected.ledger, expected.energy_error), "{what}");
    assert_eq!((found.energy_made, &found.doubt), (expected.energy_made, &expected.doubt), "{what}");
    assert_eq!(found.failure, expected.failure, "{what}");
    let [a, b] = folders.each_ref().map(|folder| files(folder.path()));
    assert_eq!(a.len(), b.len(), "{what}");
    for ((name, b), (other, a)) in a.into_iter().zip(b) {
        assert_eq!(name, other, "{what}");
        if name.ends_with(".csv") {
            assert_eq!(String::from_utf8_lossy(&a), String::from_utf8_lossy(&b), "{what}: {name}");
        }
        assert!(a == b, "{what}: {name} differs");
    }
    (found, witness.in_blocks)
}

/// Frames between steps and at their ends, rows of every step, of every third and seventh; one, two and three threads.
#[test]
fn every_file_is_the_same() {
    for (size, method) in striding() {
        let case = case_of(&sheet_of(size), &[]);
        for (threads, frames, history) in [
            (1, r#"{"every": 0.013}"#, "1"),
            (2, r#"{"every": 0.0135}"#, "3"),
            (3, "null", "7"),
            (1, r#"{"every": 1e-3}"#, "1"),
        ] {
            let sets = [("time.method", method), ("output.frames", frames), ("output.history.every", history)];
            let (outcome, in_blocks) =
                assert_same(&changed(&case, &sets), until_the_end(threads), &format!("{size:?}, {method}, {sets:?}"));
            assert_eq!(outcome.status, Status::Completed);
            // Where every step ends a frame, none; else all but the last and the few that a frame falls into.
            let expected = if frames.contains("1e-3") { 0..1 } else { 45..60 };
            assert!(expected.contains(&in_blocks), "{method}, {sets:?}: {in_blocks} of 60 steps");
        }
    }
}

/// So many node blocks that the steps of a block on several threads are in different places of the sheet.
#[test]
fn a_large_sheet() {
    let mut large = sheet();
    large["system"]["network"]["mesh"]["rectangle"]["columns"] = json!(199);
    large["system"]["network"]["mesh"]["rectangle"]["rows"] = json!(219);
    large["system"]["network"]["supports"] = json!([]);
    let case = case_of(&large, &[("time.step", "1e-4"), ("time.end", "2e-3"), ("output.frames", "null")]);
    for threads in [1, 2, 3] {
        let (outcome, in_blocks) = assert_same(&case, until_the_end(threads), &format!("{threads} threads"));
        assert_eq!((outcome.status, in_blocks > 14), (Status::Completed, true), "{threads} threads: {in_blocks}");
    }
}

/// What goes wrong within a block is told of the step in which it does, also if the run goes on.
#[test]
#[ignore = "long"]
fn a_divergence_is_found_at_its_step() {
    for (size, method) in SIZES.into_iter().flat_map(|size| STRIDING.map(|method| (size, method))) {
        let case = case_of(&sheet_of(size), &[("time.end", "0.6"), ("output.frames", "null")]);
        // A block of steps of one block is longer than most of these runs last.
        let steps = match size == SIZES[0] {
            true => [("2e-2", 0), ("4e-3", 0), ("3e-3", 0), ("2.8e-3", 32)],
            false => [("2e-2", 0), ("4e-3", 0), ("3e-3", 0), ("2.92e-3", 32)],
        };
        for (step, at_least) in steps {
            let case = changed(&case, &[("time.method", method), ("time.step", step)]);
            let (outcome, in_blocks) = assert_same(&case, until_the_end(2), &format!("{method}, {step}"));
            let on = assert_same(&case, How { threads: 1, keep_going: true }, &format!("{method}, {step}, and on"));
            assert!(
                on.0.steps > outcome.steps,
                "{size:?}, {method}, {step}: {:?} after {}",
                outcome.status,
                outcome.steps
            );
            assert_eq!(outcome.status, Status::Diverged, "{method}, {step}");
            let failure = outcome.failure.expect("a diverged run says why");
            assert_eq!(failure.step, outcome.steps + 1, "{method}, {step}");
            assert!(in_blocks >= at_least, "{size:?}, {method}, {step}: {in_blocks} of {} steps", outcome.steps);
        }
    }
}

/// A mass on a spring from the origin, 2e-3 m long, with this speed [m/s]; the scene is half as large, and 1e4 times
/// that is too far. Steps are so short that no node moves farther than the scene's size in one.
fn thrown(speed: f64, spring: Value, step: f64) -> Case {
    let mut spring = spring;
    spring["on"] = json!("all");
    case_of(
        &json!({
            "name": "thrown",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": [[0,0,0],[2e-3,0,0]], "springs": [[0,1]]}},
                "mass": {"nodal": 1.0},
                "springs": [spring],
                "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
                "initial": {"velocity": [[0,0,0],[speed,0,0]]}
            }},
            "time": {"end": 2.0, "step": step, "method": "velocity-verlet"},
            "output": {"frames": null}
        }),
        &[],
    )
}

/// Also one that is back at the end of the block in which it is away: it swings by 20 m and 1.4e-6 m, and is more than
/// 20 m away for 15 steps.
#[test]
fn who_leaves_the_scene_is_told_at_its_step() {
    let swings = |speed| thrown(speed, json!({"stiffness": 1.0, "rest_length": 1e-3}), 5e-5);
    let flies = thrown(100.0, json!({"stiffness": 1.0, "rest_length": 1e-3, "slack": "compression-only"}), 9e-6);
    for (case, step, left) in [(swings(19.9990014), 31_408, true), (flies, 22_220, true), (swings(19.9), 0, false)] {
        for method in STRIDING {
            let case = changed(&case, &[("time.method", method)]);
            for keep_going in [false, true] {
                let (outcome, in_blocks) =
                    assert_same(&case, How { threads: 1, keep_going }, &format!("{method}, {step}"));
                assert!(in_blocks >= 32, "{method}: {in_blocks} of {} steps", outcome.steps);
                assert_eq!(outcome.status == Status::Diverged, left, "{method}, {step}: {:?}", outcome.status);
                let found = outcome.failure.map_or(0, |failure| failure.step);
                assert!(found.abs_diff(step) <= 1, "{method}: {found} for {step}");
            }
        }
    }
}

/// A warning within a block is that of the step that gives it; the run then goes on in blocks of steps.
#[test]
fn a_doubt_is_had_at_its_step() {
    let mut calm = sheet();
    let network = calm["system"]["network"].as_object_mut().expect("a network");
    network.remove("initial");
    network["springs"][0].as_object_mut().expect("springs").remove("slack");
    let sets = [("time.end", "0.3"), ("time.step", "2.8e-3"), ("output.frames", "null")];
    let (outcome, in_blocks) = assert_same(&case_of(&calm, &sets), until_the_end(1), "a doubt");
    assert_eq!(outcome.status, Status::Completed);
    assert!(outcome.doubt.is_some());
    assert!(in_blocks > 60, "{in_blocks} of {} steps", outcome.steps);
}

/// Other schemes go step by step.
#[test]
fn nothing_else_is_made_in_one_go() {
    for size in SIZES {
        let case = case_of(&sheet_of(size), &[("time.end", "0.012")]);
        for method in methods().iter().filter(|method| !STRIDING.contains(&method.name)) {
            let case = changed(&case, &[("time.method", method.name)]);
            let (_, in_blocks) = assert_same(&case, until_the_end(1), method.name);
            assert_eq!(in_blocks, 0, "{}", method.name);
        }
    }
}

/// Nodes held in some directions only, and velocities that are zeros below zero where a node is held.
#[test]
fn held_directions_stay_where_they_are() {
    for (method, fix) in STRIDING.into_iter().flat_map(|method| ["z", "xy", "xyz"].map(|fix| (method, fix))) {
        let mut scene = sheet_of(SIZES[1]);
        let [columns, rows] = SIZES[1].map(|n| n as usize);
        let inside = |node: usize| {
            let (column, row) = (node % (columns + 1), node / (columns + 1));
            (1..columns).contains(&column) && (1..rows).contains(&row)
        };
        let velocity = |node| if inside(node) { [0.3, 0.1, 1.0] } else { [-0.0; 3] };
        let velocities: Vec<[f64; 3]> = (0..(columns + 1) * (rows + 1)).map(velocity).collect();
        scene["system"]["network"]["initial"]["velocity"] = json!(velocities);
        scene["system"]["network"]["supports"][0]["fix"] = json!(fix);
        let case = case_of(&scene, &[("time.method", method), ("output.frames", r#"{"every": 0.02}"#)]);
        let (outcome, in_blocks) = assert_same(&case, until_the_end(1), &format!("{method}, {fix}"));
        assert_eq!((outcome.status, in_blocks > 50), (Status::Completed, true), "{method}, {fix}: {in_blocks}");
    }
}

/// Forces that a sheet can have besides springs and weight: keys of `system.network`.
fn forces() -> [(&'static str, Value); 12] {
    let springs =
        |dashpot: Value| json!([{"on": "all", "stiffness": 300.0, "slack": "tension-only", "dashpot": dashpot}]);
    let reeled = |dashpot: Value| {
        let mut rule = springs(dashpot);
        rule[0]["rest_scale"] = json!({"table": [[0.0, 1.0], [0.0113, 0.9], [0.03, 0.95]]});
        rule
    };
    let table = json!([[0.0, 0.0], [0.011, 1.0], [0.023, 0.3]]);
    [
        ("springs", springs(json!({"relative": {"coefficient": 0.05}}))),
        ("springs", springs(json!({"axial": {"coefficient": 0.05}}))),
        ("damping", json!({"rayleigh": {"mass": 0.7, "stiffness": 1e-4}})),
        ("loads", json!([{"on": {"ids": [100, 101]}, "force": [0.0, 0.1, 0.3], "table": table}])),
        ("loads", json!([{"on": "all", "pressure": 30.0, "table": table}])),
        ("loads", json!([{"on": "all", "pressure": 30.0, "kind": "dead", "direction": [0.0, 0.2, 1.0]}])),
        (
            "aero",
            json!({
                "wind": {"table": [[0.0, 0.0, 1.0, 2.0], [0.02, 0.0, 0.0, 9.0]]},
                "law": {"ergun": {
                    "porosity": 0.9, "pore_diameter": 1e-3, "thickness": 1e-4, "air_density": 1.225,
                    "air_viscosity": 1.81e-5, "form": "corrected"
                }}
            }),
        ),
        ("springs", reeled(json!({"axial": {"coefficient": 0.05}}))),
        ("base_acceleration", json!({"table": [[0.0, 0.0, 1.0, 2.0], [0.02, 0.0, 0.0, 9.0]]})),
        (
            "membranes",
            json!([{"on": "all", "thickness": 1e-3, "modulus": 2e5, "poisson": 0.3, "wrinkling": true,
                    "damping_time": 1e-4}]),
        ),
        ("bending", json!([{"on": "all", "stiffness": 1e-4}])),
        (
            "springs",
            json!([{"on": "all", "stiffness": 300.0, "law": "green", "dashpot": {"axial": {"coefficient": 0.05}}}]),
        ),
    ]
}

/// Every force alone, and all together: with work in the ledger, tables in time, and velocities that are predicted and
/// corrected.
#[test]
fn all_forces_work_in_blocks() {
    let all = forces().into_iter().enumerate().filter(|(i, _)| ![1, 3, 5, 8, 11].contains(i)).map(|(_, force)| force);
    let scenes = forces().map(|force| vec![force]).into_iter().chain([all.collect()]);
    for (number, forces) in scenes.enumerate() {
        for (size, method) in SIZES.into_iter().flat_map(|size| STRIDING.map(|method| (size, method))) {
            let (mut scene, mut external, mut dissipates) = (sheet_of(size), false, false);
            for (key, force) in &forces {
                scene["system"]["network"][*key] = force.clone();
                external |=
                    ["loads", "aero", "base_acceleration"].contains(key) || force[0].get("rest_scale").is_some();
                dissipates |= ["springs", "damping", "membranes"].contains(key);
            }
            let threads = 1 + number % 2;
            let case = case_of(&scene, &[("time.method", method)]);
            let what = format!("{forces:?}, {size:?}, {method}");
            let (outcome, in_blocks) = assert_same(&case, until_the_end(threads), &what);
            assert_eq!(outcome.status, Status::Completed, "{what}: {:?}", outcome.failure);
            assert!((42..60).contains(&in_blocks), "{what}: {in_blocks} of 60 steps");
            let ledger = outcome.ledger;
            assert_eq!([ledger.external_work != 0.0, ledger.dissipated != 0.0], [external, dissipates], "{what}");
        }
    }
}

/// Where dashpots and air make the step too long, the step and the cause are those of single steps.
#[test]
#[ignore = "long"]
fn a_divergence_by_dashpots_and_air_is_found_at_its_step() {
    let [(_, dashpots), _, _, _, _, _, (_, air), ..] = forces();
    let small = [("1e-3", "0.9"), ("1e-3", "1.4"), ("1e-3", "3"), ("2.8e-3", "0.05")];
    let runs = small.into_iter().flat_map(|run| STRIDING.map(|method| (SIZES[1], method, run)));
    for (size, method, (step, coefficient)) in runs.chain([(SIZES[0], STRIDING[0], small[1])]) {
        let mut scene = sheet_of(size);
        scene["system"]["network"]["springs"] = dashpots.clone();
        scene["system"]["network"]["aero"] = air.clone();
        let sets = [
            ("time.method", method),
            ("time.step", step),
            ("time.end", "0.2"),
            ("output.frames", "null"),
            ("system.network.springs.0.dashpot.relative.coefficient", coefficient),
        ];
        let what = format!("{size:?}, {method}, {step}, {coefficient}");
        let (outcome, in_blocks) = assert_same(&case_of(&scene, &sets), until_the_end(2), &what);
        // Dashpots this stiff are too much for Verlet from 1.4 on, and sooner for the other.
        let limit = if method == STRIDING[0] { 1.0 } else { 0.5 };
        let too_stiff = coefficient.parse::<f64>().expect("a number") > limit;
        assert_eq!(outcome.status == Status::Diverged, too_stiff, "{what}: {:?}", outcome.status);
        assert_eq!(outcome.failure.map(|failure| failure.step), too_stiff.then_some(outcome.steps + 1), "{what}");
        assert!(in_blocks > 30 || too_stiff, "{what}: {in_blocks} of {} steps", outcome.steps);
    }
}

/// On several threads each has a part of the scene; the last steps do not fill a block.
#[test]
#[ignore = "long"]
fn a_large_sheet_with_dashpots_and_air() {
    let mut large = sheet();
    large["system"]["network"]["mesh"]["rectangle"]["columns"] = json!(299);
    large["system"]["network"]["mesh"]["rectangle"]["rows"] = json!(329);
    large["system"]["network"]["mass"]["areal_density"] = json!(100.0);
    let [(_, dashpots), _, _, _, (_, pressure), _, (_, air), ..] = forces();
    large["system"]["network"]["springs"] = dashpots;
    large["system"]["network"]["loads"] = pressure;
    large["system"]["network"]["aero"] = air;
    let sets = [("time.step", "1e-4"), ("time.end", "1.1e-3"), ("output.frames", "null")];
    for method in STRIDING {
        let case = changed(&case_of(&large, &sets), &[("time.method", method)]);
        for threads in [1, 2, 3] {
            let (outcome, in_blocks) = assert_same(&case, until_the_end(threads), &format!("{threads} threads"));
            assert_eq!((outcome.status, in_blocks > 7), (Status::Completed, true), "{threads} threads: {in_blocks}");
        }
    }
}
