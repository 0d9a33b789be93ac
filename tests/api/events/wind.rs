//! Winds that begin with events: where they begin, what they do, and the same bits again.

use std::path::PathBuf;

use canopy_fem::case::Case;
use canopy_fem::drive::Status;
use serde_json::{Value, json};

use super::{BODY, G, adaptive, fixed};
use crate::common::run::{Run, case_of, run, run_with};

/// [m] height at which the wind begins, below the start at 100 m
const LOW: f64 = 80.0;

/// [m/s] of a steady fall.
fn terminal() -> f64 {
    let [mass, area, density] = BODY;
    (2.0 * mass * G / (density * area)).sqrt()
}

/// A body that falls steadily from z = 100 m in a wind.
fn falling(wind: &Value, time: &Value) -> Value {
    let [mass, area, density] = BODY;
    json!({
        "name": "falling",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 100]], "springs": []}},
            "mass": {"nodal": mass},
            "gravity": [0, 0, -G],
            "aero": {"drag": [{"on": "all", "drag_area": area}], "atmosphere": {"density": density}, "wind": wind},
            "initial": {"velocity": [0, 0, -terminal()]}
        }},
        "time": time
    })
}

/// A wind that has begun, one by height, and a gust after it.
pub(super) fn blown(time: &Value) -> Value {
    let wind = json!({"sum": [
        [0.5, 0, 0],
        {"table": [[0, 2, 1, 0], [0.31, 3, -1, 0.5], [0.77, 1, 4, 0]],
         "when": {"name": "low", "height_below": LOW}},
        {"gust": {"velocity": [0, -5, 1], "start": 0.1, "duration": 0.37}, "when": {"after": "low", "delay": 0.23}}
    ]});
    let mut case = falling(&wind, time);
    // Such that all of it is within 0.8 s.
    case["system"]["network"]["mesh"]["explicit"]["nodes"] = json!([[0, 0, LOW + 1.0]]);
    case
}

fn ended(case: &Value) -> Run {
    let ended = run(&case_of(case, &[]));
    assert_eq!(ended.outcome.status, Status::Completed);
    ended
}

/// In a wind U that is small beside the steady fall at V, which begins at a height, a body drifts by
/// U (t - (1 - exp(-b t))/b) in the time t from there on, b = g/V. Steps of methods of second order and above meet it.
#[test]
fn a_wind_that_begins_at_a_height_carries_along() {
    let (small, end, b) = (1e-4, 6.0, G / terminal());
    let wind = json!({"table": [[0, small, 0, 0]], "when": {"height_below": LOW}});
    let since = end - (100.0 - LOW) / terminal();
    let drift = small * (since - (1.0 - (-b * since).exp()) / b);
    for (time, within) in [
        (adaptive("dop853", 1e-11, end), 1e-6),
        (fixed("rk4", 0.05, end), 1e-6),
        (fixed("velocity-verlet", 0.01, end), 1e-4),
        (fixed("newmark", 0.01, end), 1e-4),
        (fixed("energy-momentum", 0.01, end), 1e-4),
        (fixed("backward-euler", 0.001, end), 2e-2),
    ] {
        let ran = ended(&falling(&wind, &time));
        let found = ran.positions[0][0];
        assert!((found / drift - 1.0).abs() < within, "{time}: {found:e} {drift:e}");
        assert!(ran.outcome.energy_error < 1e-9, "{time}: {:e}", ran.outcome.energy_error);
    }
}

/// A wind by an event is that of a table whose times begin then, and methods keep their order over its corners.
#[test]
fn a_wind_by_event_is_that_of_its_table() {
    let exact = ended(&blown(&adaptive("dop853", 1e-12, 0.8)));
    let at = exact.outcome.fired[0].t;
    let then = |rows: &[[f64; 4]]| rows.iter().map(|row| [row[0] + at, row[1], row[2], row[3]]).collect::<Vec<_>>();
    let rows = then(&[[-1e-9, 0.0, 0.0, 0.0], [0.0, 2.0, 1.0, 0.0], [0.31, 3.0, -1.0, 0.5], [0.77, 1.0, 4.0, 0.0]]);
    let mut timed = blown(&adaptive("dop853", 1e-12, 0.8));
    timed["system"]["network"]["aero"]["wind"] = json!({"sum": [
        [0.5, 0, 0], {"table": rows}, {"gust": {"velocity": [0, -5, 1], "start": at + 0.33, "duration": 0.37}}
    ]});
    let timed = ended(&timed);
    let apart = |a: &Run, b: &Run| {
        let [a, b] = [a, b].map(|run| [run.positions[0], run.velocities[0]].concat());
        a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    assert!(apart(&exact, &timed) < 1e-8, "{:e}", apart(&exact, &timed));
    for (method, order) in [("velocity-verlet", 2), ("newmark", 2), ("rk4", 4), ("esdirk4", 4)] {
        let error = |step: f64| apart(&exact, &ended(&blown(&fixed(method, step, 0.8))));
        let (coarse, fine) = (error(0.025), error(0.00625));
        assert!(
            coarse < 0.02 && (fine < 1e-9 || fine < 2.0 * coarse / 4.0_f64.powi(order)),
            "{method}: {coarse:e} {fine:e}"
        );
    }
}

/// Before its event there is none of a wind, and what never comes changes no bit.
#[test]
fn a_wind_that_never_begins_changes_no_bit() {
    for time in [fixed("rk4", 0.02, 1.0), fixed("newmark", 0.02, 1.0), adaptive("dormand-prince", 1e-8, 1.0)] {
        let never = json!({"sum": [[1, 0, 0], {"table": [[0, 9, 9, 9]], "when": {"height_below": -1e6}}]});
        let [one, other] = [json!([1, 0, 0]), never].map(|wind| ended(&falling(&wind, &time)));
        assert!(one.state == other.state, "{time}");
    }
}

/// Nor do threads: nodes of a cloth in a wind that begins as it falls.
#[test]
fn two_threads_meet_the_same_wind() {
    let case = case_of(
        &json!({
            "name": "cloth",
            "system": {"network": {
                "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": 50, "rows": 50}},
                "mass": {"nodal": 1e-4},
                "springs": [{"on": "all", "stiffness": 20.0}],
                "gravity": [0, 0, -G],
                "aero": {"drag": [{"on": "all", "drag_area": 0.5}],
                         "wind": {"table": [[0, 3, 1, 0], [0.004, 5, 0, 2]], "when": {"height_below": -2e-4}}}
            }},
            "time": fixed("velocity-verlet", 5e-4, 0.02)
        }),
        &[],
    );
    let [one, two] = [1, 2].map(|threads| run_with(&case, threads));
    assert!(one.outcome.fired.len() == 1 && one.outcome.fired == two.outcome.fired);
    assert!(one.state == two.state);
}

/// A constant wind and a profile have no times that could count from an event.
#[test]
fn only_what_has_times_takes_an_event() {
    let when = json!({"height_below": LOW});
    let time = fixed("rk4", 0.05, 1.0);
    for wind in [json!({"profile": [[0, 1, 0, 0]], "when": when}), json!({"table": [[0, 1, 0, 0]], "when": {}})] {
        let text = falling(&wind, &time).to_string();
        let refused = Case::from_text(text, "case.json", PathBuf::new(), &[]);
        let words = refused.err().map(|error| error.to_string()).expect("it is refused");
        assert!(words.contains("/aero/wind"), "{words}");
    }
}
