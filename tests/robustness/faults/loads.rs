//! Loads over time whose tables have corners within fixed steps: impulse is kept by every method, wherever the corners
//! lie.

use super::program::program;
use crate::common::run::{Run, case_of, follow, run};
use canopy_fem::drive::clock::{Step, Tolerance};
use canopy_fem::drive::{self, RunSpec, Status};
use canopy_fem::integrate::registry::methods;
use canopy_fem::simulation::{bind, build_scene};
use serde_json::{Value, json};
use std::sync::atomic::AtomicBool;

/// The edges of a pulse take this long [s].
const EDGE: f64 = 1e-6;

/// A pulse of height 1 from `start` to `end` [s].
fn pulse(start: f64, end: f64) -> Vec<[f64; 2]> {
    vec![[0.0, 0.0], [start, 0.0], [start + EDGE, 1.0], [end, 1.0], [end + EDGE, 0.0]]
}

fn integral(table: &[[f64; 2]]) -> f64 {
    table.windows(2).map(|w| 0.5 * (w[0][1] + w[1][1]) * (w[1][0] - w[0][0])).sum()
}

/// A mass on a spring, w = 10 rad/s, pushed by 1000 N times a table.
fn oscillator(table: &[[f64; 2]], method: &str, step: f64, end: f64) -> Value {
    json!({
        "name": "pulse",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [10, 0, 0]], "springs": [[0, 1]]}},
            "mass": {"nodal": 1.0},
            "springs": [{"on": "all", "stiffness": 100.0}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}, {"on": {"ids": [1]}, "fix": "yz"}],
            "loads": [{"on": {"ids": [1]}, "force": [1000.0, 0, 0], "table": table}]
        }},
        "time": {"end": end, "method": method, "step": step}
    })
}

/// Two free masses, both pushed by 3 N times a table; the spring between them stays as it is.
fn free(table: &[[f64; 2]], method: &str, step: f64, end: f64) -> Value {
    json!({
        "name": "free",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [0, 1, 0]], "springs": [[0, 1]]}},
            "mass": {"nodal": 2.0},
            "springs": [{"on": "all", "stiffness": 1.0}],
            "loads": [{"on": {"ids": [0, 1]}, "force": [3.0, 0, 0], "table": table}]
        }},
        "time": {"end": end, "method": method, "step": step}
    })
}

#[test]
fn a_pulse_between_steps_moves_what_it_pushes() {
    for (start, end) in [(0.5037, 0.5047), (0.5037, 0.5137), (0.5, 0.501), (0.509, 0.511), (0.5099, 0.5199)] {
        let table = pulse(start, end);
        // F/k 2 sin(w d/2) with the pulse's length d at half height.
        let exact = 1000.0 / 100.0 * 2.0 * (0.5 * 10.0 * (end - start + EDGE) - 5.0 * EDGE).sin();
        for method in methods().iter().filter(|m| m.order >= 2) {
            let mut largest = 0.0_f64;
            let outcome = follow(&case_of(&oscillator(&table, method.name, 0.01, 2.0), &[]), |at| {
                largest = largest.max(at.positions[1][0] - 10.0);
            });
            assert_eq!(outcome.status, Status::Completed, "{}", method.name);
            let off = largest / exact - 1.0;
            assert!(off.abs() < 0.015, "{} from {start} to {end} s: {largest} m, expected {exact}", method.name);
            // Heun's account of the work of a load that changes within steps is off by second order, wherever its
            // corners lie.
            if method.name.starts_with("improved-euler") {
                continue;
            }
            let (numerical, work) = (outcome.ledger.numerical.abs(), outcome.ledger.external_work);
            assert!(numerical < 0.03 * work, "{}: {numerical} J of {work} J made or lost", method.name);
        }
    }
}

/// Velocity of the free masses at the end, against the impulse of the table, some 40 steps after it: generalised alpha
/// hands a force on over many steps, each with less than half of what is left. Methods of order one take a load at one
/// end of every step; if it is there from the first step on they are half that step's share off, as with any load that
/// is there at t = 0.
fn check_impulse(what: &str, table: &[[f64; 2]], step: f64, end: f64) {
    let exact = 3.0 / 2.0 * integral(table);
    let acts = |row: &&[f64; 2]| row[1] != 0.0;
    let [first, last] = [table.iter().find(acts), table.iter().rfind(acts)].map(|row| row.map_or(0.0, |row| row[0]));
    let from_start = first < step && last + EDGE > step;
    for method in methods().iter().filter(|method| method.order >= 2 || !from_start) {
        let end = run(&case_of(&free(table, method.name, step, end), &[]));
        for v in &end.velocities {
            let off = (v[0] - exact).abs() / exact.abs();
            assert!(off < 1e-12, "{}, {what}: {} m/s, expected {exact}: {off:e}", method.name, v[0]);
        }
    }
}

#[test]
fn every_method_keeps_the_impulse_wherever_the_corners_lie() {
    let h = 0.01;
    for i in 0..40 {
        // From t = 0 on, the first step included.
        let start = 0.0013 * f64::from(i);
        for lasts in [1e-4, 1e-3, 0.01, 0.0137, 0.05] {
            check_impulse(&format!("{start} s for {lasts} s"), &pulse(start + EDGE, start + lasts), h, 0.6);
        }
    }
}

#[test]
fn impulse_is_kept_in_odd_tables_and_steps() {
    let h = 0.01;
    // At the end of a step but for rounding, on either side.
    for n in [1_u32, 3, 7, 29] {
        let t = f64::from(n) * h;
        for start in [t, t.next_up(), t.next_down(), t + 1e-12, t - 1e-12, t + 1e-9 * h] {
            check_impulse(&format!("a pulse from {start:?} s"), &pulse(start, start + 0.0123), h, 0.9);
            check_impulse(&format!("a pulse until {start:?} s"), &pulse(start - 0.0082, start), h, 0.9);
        }
    }
    // Jumps of the least width.
    let t = 0.07_f64;
    let jump = [[0.0, 0.0], [t, 0.0], [t.next_up(), 1.0], [0.1, 1.0], [0.1_f64.next_up(), 0.0]];
    check_impulse("jumps of one rounding", &jump, h, 0.9);
    // Three pulses in a step, of both signs.
    let comb: Vec<[f64; 2]> = (0_u8..7)
        .map(|i| [0.0512 + 0.001 * f64::from(i), [0.0, 1.0, 0.0, -0.3, 0.0, 2.0, 0.0][usize::from(i)]])
        .collect();
    check_impulse("a comb", &comb, h, 0.6);
    // A table that begins late, ends early, and is shorter than a step.
    check_impulse("a late table", &[[0.4321, 0.0], [0.4325, 1.0], [0.433, 0.0]], h, 1.0);
    check_impulse("a table within the first step", &[[0.0, 0.0], [0.02, 1.0], [0.05, 0.0]], 0.1, 5.0);
    // A last step that is cut.
    check_impulse("a cut last step", &pulse(0.0537, 0.0547), h, 0.6037);
    // A dense one: many rows a step.
    let dense: Vec<[f64; 2]> = (0_u32..=3000)
        .map(|i| {
            let s = f64::from(i) / 3000.0;
            [0.0111 + 0.1 * s, (std::f64::consts::PI * s).sin() * (1.0 + (900.0 * s).sin())]
        })
        .collect();
    let mut dense = dense;
    dense[3000][1] = 0.0;
    check_impulse("a dense table", &dense, h, 0.7);
}

/// A load that is there at t = 0 and goes away within a step; methods that sample one end of a step are off by that of
/// the jump at t = 0.
#[test]
fn a_load_that_ends_within_a_step_keeps_its_impulse() {
    let table = [[0.0, 1.0], [0.0537, 1.0], [0.0537 + EDGE, 0.0]];
    let exact = 1.5 * integral(&table);
    for method in methods().iter().filter(|m| m.order >= 2) {
        let v = run(&case_of(&free(&table, method.name, 0.01, 0.6), &[])).velocities[0][0];
        assert!((v / exact - 1.0).abs() < 1e-12, "{}: {v}, expected {exact}", method.name);
    }
}

/// A load switched on at t = 0 by two close rows is a load from t = 0 on.
#[test]
fn a_load_switched_on_at_the_start_acts_from_the_start() {
    let table = [[0.0, 0.0], [1e-12, 1.0]];
    let constant = [[0.0, 1.0]];
    for method in methods() {
        let end = |table: &[[f64; 2]]| run(&case_of(&free(table, method.name, 0.01, 0.2), &[])).positions[0][0];
        let (switched, always) = (end(&table), end(&constant));
        assert!((switched / always - 1.0).abs() < 1e-9, "{}: {switched}, expected {always}", method.name);
    }
}

/// The wind keeps its mean: what a linear law takes from a gust is right.
#[test]
fn a_gust_between_steps_is_felt() {
    let gust = |method: &str, h: f64| {
        let case = json!({
            "name": "gust",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "springs": [[0, 1], [1, 2], [2, 0]], "triangles": [[0, 1, 2]]}},
                "mass": {"nodal": 1.0},
                "springs": [{"on": "all", "stiffness": 1.0}],
                "aero": {"law": {"permeable": {"a": 0.01, "b": 0.0, "thickness": 1.0}},
                    "wind": {"table": [[0, 0, 0, 0], [0.0537, 0, 0, 0], [0.0538, 0, 0, 40], [0.0547, 0, 0, 40], [0.0548, 0, 0, 0]]}}
            }},
            "time": {"end": 0.1, "method": method, "step": h}
        });
        run(&case_of(&case, &[])).velocities[0][2]
    };
    let exact = gust("rk4", 1e-4);
    // a A/3 per node and kilogram, times 40 m/s for 1 ms.
    assert!((exact / (0.01 * 0.5 / 3.0 * 40.0 * 1e-3) - 1.0).abs() < 1e-3, "{exact}");
    for method in methods() {
        let v = gust(method.name, 0.01);
        assert!((v / exact - 1.0).abs() < 1e-3, "{}: {v}, expected {exact}", method.name);
    }
}

/// A mass with drag in a gust of 25 m/s, and what the wind is beside it.
fn drag_in(wind: Value, method: &str, step: f64) -> Value {
    json!({
        "name": "gust",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [0.8, 0, 0]], "springs": [[0, 1]]}},
            "mass": {"nodal": 1.5},
            "springs": [{"on": "all", "stiffness": 60.0}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}, {"on": {"ids": [1]}, "fix": "yz"}],
            "aero": {"drag": [{"on": {"ids": [1]}, "drag_area": 2.0}], "wind": wind}
        }},
        "time": {"end": 0.6, "method": method, "step": step}
    })
}

fn gust_of(start: f64, duration: f64) -> Value {
    json!({"gust": {"velocity": [25, 0, 0], "start": start, "duration": duration}})
}

/// Cloth of a linear law takes the mean of a gust from it, however short and wherever in a step; one of many steps is
/// felt as it is.
#[test]
fn a_gust_shorter_than_a_step_keeps_its_mean() {
    let velocity = |method: &str, wind: &Value| {
        let case = json!({
            "name": "gust",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "springs": [[0, 1], [1, 2], [2, 0]], "triangles": [[0, 1, 2]]}},
                "mass": {"nodal": 1.0},
                "springs": [{"on": "all", "stiffness": 1.0}],
                "aero": {"law": {"permeable": {"a": 0.01, "b": 0.0, "thickness": 1.0}}, "wind": wind}
            }},
            "time": {"end": 0.8, "method": method, "step": 0.01}
        });
        run(&case_of(&case, &[])).velocities[0][2]
    };
    let h = 0.01;
    for (start, steps) in
        [(0.3, 1.0), (0.3, 0.2), (0.3037, 0.5), (0.297, 1.0), (0.3, 2.0), (0.305, 3.3), (0.3, 7.9), (0.301, 8.6)]
    {
        let of = |z: f64| json!({"gust": {"velocity": [0, 0, z], "start": start, "duration": steps * h}});
        // a A/3 per node and kilogram, times half of 40 m/s for the time of the gust; the air brakes by 1e-3 of it.
        let exact = 0.01 * 0.5 / 3.0 * 20.0 * steps * h;
        for method in methods() {
            let alone = velocity(method.name, &of(40.0));
            assert!((alone / exact - 1.0).abs() < 4e-3, "{} {start} {steps}: {alone} m/s of {exact}", method.name);
            let halves = velocity(method.name, &json!({"sum": [of(15.0), [0, 0, 0], of(25.0)]}));
            assert!((halves / alone - 1.0).abs() < 1e-9, "{} {start} {steps}: {halves} m/s of {alone}", method.name);
        }
    }
}

/// A gust as long as a step moves a mass, by every method alike, and a step that resolves it gives the right motion.
#[test]
fn a_gust_as_long_as_a_step_is_not_missed() {
    let end = |method: &str, step: f64| {
        let Run { positions, velocities, .. } = run(&case_of(&drag_in(gust_of(0.3, 0.01), method, step), &[]));
        [positions[1][0], velocities[1][0]]
    };
    for method in methods() {
        let [x, v] = end(method.name, 5e-4);
        assert!((x - 1.026_72).abs() < 0.01 && (v + 0.534_89).abs() < 0.03, "{}: {x} m, {v} m/s", method.name);
        let [x, _] = end(method.name, 0.01);
        assert!((0.83..1.03).contains(&x), "{}: {x} m", method.name);
    }
    let mut adaptive = drag_in(gust_of(0.3, 0.01), "newmark", 0.01);
    adaptive["time"].as_object_mut().expect("an object").remove("step");
    for relative in [1e-2_f64, 1e-3, 1e-6] {
        adaptive["time"]["tolerance"] = json!({"relative": relative, "absolute": 1e-3 * relative});
        let x = run(&case_of(&adaptive, &[])).positions[1][0];
        assert!((x - 1.026_72).abs() < 0.226_72 * 5.0 * relative.max(1e-4), "{relative}: {x} m");
    }
}

/// One word on every gust, table and file that steps do not resolve, also in a sum.
#[test]
fn short_gusts_and_files_are_warned_of() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("wind.csv"), "t,x,y,z\n0,0,0,0\n0.3,0,0,0\n0.304,25,0,0\n0.309,0,0,0\n")
        .expect("written");
    let file = json!({"file": "wind.csv"});
    for (wind, words) in [
        (gust_of(0.3, 0.01), &["/aero/wind/gust: the pulse at t = 0.3 s lasts 0.01 s"][..]),
        (file.clone(), &["/aero/wind/file: the pulse at t = 0.3 s lasts 0.009 s"]),
        (
            json!({"sum": [[1, 0, 0], gust_of(0.1, 0.015), gust_of(0.2, 0.02), file]}),
            &["/aero/wind/sum/1/gust: the pulse at t = 0.1 s", "/aero/wind/sum/3/file: the pulse at t = 0.3 s"],
        ),
        (json!({"sum": [gust_of(0.1, 0.02), gust_of(0.2, 0.1), gust_of(0.7, 0.001)]}), &[]),
    ] {
        for args in [&["check"][..], &["solve", "--force"]] {
            let run = program(folder.path(), &drag_in(wind.clone(), "newmark", 0.01), args);
            assert_eq!(run.status, Some(0), "{}{}", run.stdout, run.stderr);
            let said = format!("{}{}", run.stdout, run.stderr);
            assert_eq!(said.matches("[short-pulse]").count(), words.len(), "{said}");
            words.iter().for_each(|word| assert!(said.contains(word), "{word} in {said}"));
        }
    }
}

/// A hundred thousand rows are made ready in the time of reading them.
#[test]
fn long_tables_run() {
    let table: Vec<[f64; 2]> = (0..100_000).map(|i| [1e-5 * f64::from(i), f64::from(i % 7) - 3.0]).collect();
    let outcome = run(&case_of(&free(&table, "velocity-verlet", 3e-3, 1.0), &[])).outcome;
    assert_eq!(outcome.status, Status::Completed);
}

#[test]
fn check_and_solve_warn_of_a_pulse_that_loses_its_shape() {
    let folder = tempfile::tempdir().expect("a folder");
    for args in [&["check"][..], &["solve", "--force"], &["solve", "--force", "--method", "rk4"]] {
        let run = program(folder.path(), &oscillator(&pulse(0.5037, 0.5047), "newmark", 0.01, 2.0), args);
        assert_eq!(run.status, Some(0), "{}{}", run.stdout, run.stderr);
        let said = format!("{}{}", run.stdout, run.stderr);
        let warnings: Vec<&str> = said.lines().filter(|line| line.contains("pulse at")).collect();
        assert_eq!(warnings.len(), 1, "{said}");
        for part in
            ["/system/network/loads/0/table", "t = 0.5037 s", "0.001001 s", "the step is 0.01 s", "take time.step="]
        {
            assert!(warnings[0].contains(part), "{part} in {}", warnings[0]);
        }
    }
}

/// No word where steps meet the corners or are short, for a load that is only switched, and for adaptive steps.
#[test]
fn tables_that_steps_resolve_are_not_warned_of() {
    let switched = vec![[0.0, 0.0], [0.5037, 0.0], [0.5037 + EDGE, 1.0]];
    let met = vec![[0.0, 0.0], [0.5, 0.0], [0.51, 1.0], [0.52, 0.0]];
    for (table, step) in [(switched, 0.01), (met, 0.01), (pulse(0.5037, 0.5047), 1e-4)] {
        let case = case_of(&oscillator(&table, "newmark", step, 2.0), &[]);
        assert!(case.problem().warnings.is_empty(), "{:?}", case.problem().warnings);
    }
    let adaptive = [("time.step", "null"), ("time.tolerance", r#"{"relative": 1e-4, "absolute": 1e-6}"#)];
    let case = case_of(&oscillator(&pulse(0.5037, 0.5047), "newmark", 0.01, 2.0), &adaptive);
    assert!(case.problem().warnings.is_empty(), "{:?}", case.problem().warnings);
}

/// A run that is carried further has the bits of one that was not stopped, also where it was stopped in the middle of a
/// pulse.
#[test]
fn a_run_carried_further_has_the_same_bits() {
    let folder = tempfile::tempdir().expect("a folder");
    for (method, end) in [("rk4", "0.51"), ("newmark", "0.51"), ("velocity-verlet", "0.5")] {
        let mut case = oscillator(&pulse(0.5037, 0.5137), method, 0.01, 2.0);
        case["output"] = json!({"checkpoint": {"every": 0.1}, "history": {"every": 1}, "frames": null});
        let solve = |args: &[&str]| {
            let run = program(folder.path(), &case, &[&["solve", "-q"], args].concat());
            assert_eq!(run.status, Some(0), "{}", run.stderr);
        };
        let history = |name: &str| std::fs::read_to_string(folder.path().join(name).join("history.csv")).expect("rows");
        solve(&["--out", "whole", "--force"]);
        solve(&["--out", "parts", "--force", "--end", end]);
        solve(&["--out", "parts", "--resume"]);
        assert_eq!(history("whole"), history("parts"), "{method} stopped at {end} s");
    }
}

/// Runs of one scene that follow each other, as in a study, leave nothing behind in it.
#[test]
fn runs_of_one_scene_do_not_disturb_each_other() {
    let mut problem = case_of(&oscillator(&pulse(0.5037, 0.5137), "newmark", 0.01, 1.0), &[]).problem().clone();
    let scene = build_scene(problem.take_system(), 1).expect("a scene");
    let end = |step: Step| {
        let mut stepper = bind(&problem, &*scene).expect("it fits");
        let spec = RunSpec { step, ..problem.run_spec() };
        let outcome = drive::run(&*scene, &mut stepper, &spec, &mut [], &AtomicBool::new(false)).expect("it starts");
        assert_eq!(outcome.status, Status::Completed);
        outcome.ledger
    };
    let adaptive = Step::Adaptive(Tolerance { relative: 1e-4, absolute: 1e-6 });
    let steps = [Step::Fixed(0.01), adaptive, Step::Fixed(0.02)];
    let alone = steps.map(|step| {
        // A scene of its own.
        let mut problem = case_of(&oscillator(&pulse(0.5037, 0.5137), "newmark", 0.01, 1.0), &[]).problem().clone();
        let scene = build_scene(problem.take_system(), 1).expect("a scene");
        let mut stepper = bind(&problem, &*scene).expect("it fits");
        let spec = RunSpec { step, ..problem.run_spec() };
        drive::run(&*scene, &mut stepper, &spec, &mut [], &AtomicBool::new(false)).expect("it starts").ledger
    });
    for _ in 0..2 {
        assert_eq!(steps.map(end), alone);
    }
}
