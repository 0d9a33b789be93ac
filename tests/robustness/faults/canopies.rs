//! Canopies that lean, that are deployed across the wind, that never fill, whose numbers do not belong together.

use super::program::{program, summary};
use super::warnings::{warnings, with};
use canopy_fem::case::Case;
use serde_json::{Value, json};
use std::path::PathBuf;

const N: &str = "/system/network";

/// A small canopy over a payload of 20 kg, which falls at 20 m/s: nothing is to be said of it.
fn rig() -> Value {
    let tape = |name: &str| {
        json!({"on": {"group": name}, "axial_rigidity": 8000, "linear_density": 0.006, "slack": "tension-only",
            "dashpot": {"axial": {"time": 1e-3}}})
    };
    json!({"name": "rig", "system": {"network": {
        "mesh": {"parachute": {"type": "flat-circular", "nominal_diameter": 4.0, "gores": 8, "vent_diameter": 0.3,
            "radial_segments": 4, "lines": {"length": 3.6}, "start": "inflated"}},
        "mass": {"areal_density": 0.05, "points": [{"on": {"group": "payload"}, "mass": 20}]},
        "springs": [
            {"on": {"group": "cloth"}, "membrane": {"modulus": 4.3e8, "thickness": 1e-4}, "slack": "tension-only",
             "dashpot": {"axial": {"time": 1e-3}}},
            tape("radials"), tape("skirt"), tape("vent"), tape("vent-lines"), tape("lines")],
        "gravity": [0, 0, -9.81],
        "aero": {"canopy": {"on": {"group": "canopy"}, "schedule": {"drag_area": 9.4, "filling_constant": 8},
                            "law": {"permeable": {"a": 1.6e6, "b": 4.8e5, "thickness": 1e-4}}}},
        "initial": {"velocity": [0, 0, -20]}}},
        "time": {"end": 2.0, "method": "newmark", "step": 2e-3}})
}

/// The same with a reefing line.
fn reefed(cut: Value, schedule: Value) -> Value {
    let mut case = with(&rig(), &[(&format!("{N}/aero/canopy/schedule"), schedule)]);
    case["system"]["network"]["mesh"]["parachute"]["reefing"] = json!({"diameter": 1.0});
    let mut line = json!({"on": {"group": "reefing"}, "axial_rigidity": 20000, "linear_density": 0.01,
        "slack": "tension-only", "dashpot": {"axial": {"time": 1e-3}}});
    if !cut.is_null() {
        line["cut"] = cut;
    }
    case["system"]["network"]["springs"].as_array_mut().expect("a list").push(line);
    case
}

fn stages(start: f64) -> Value {
    json!([{"drag_area": 1.4, "filling_time": 0.3}, {"drag_area": 9.4, "filling_time": 0.5, "start": start}])
}

#[test]
fn canopies_whose_numbers_do_not_fit_are_warned_of() {
    let schedule = |value: Value| with(&rig(), &[(&format!("{N}/aero/canopy/schedule"), value)]);
    let isa = |altitude: f64, up: f64| {
        with(
            &rig(),
            &[
                (&format!("{N}/aero/atmosphere"), json!("isa")),
                (&format!("{N}/aero/altitude"), json!(altitude)),
                (&format!("{N}/initial"), json!({"velocity": [0, 5, up]})),
            ],
        )
    };
    let slow = |speed: f64| with(&rig(), &[(&format!("{N}/initial"), json!({"velocity": [0, 0, -speed]}))]);
    for (case, code, words) in [
        (schedule(json!({"drag_area": 120, "filling_constant": 8})), "drag-coefficient", "drag coefficient of 9.5"),
        (schedule(json!({"drag_coefficient": 0.2, "filling_constant": 8})), "drag-coefficient", "0.2: a drag area"),
        (slow(0.02), "filling-beyond-end", "1600 s to fill from t = 0 s on, but the run ends at 2 s"),
        (schedule(json!({"drag_area": 9.4, "filling_time": 100})), "filling-beyond-end", "needs 100 s"),
        (reefed(Value::Null, stages(1.0)), "reefing-line", "never cut, but its last stage begins at 1 s"),
        (reefed(json!(0.8), stages(1.0)), "reefing-line", "cut at 0.8 s, but its last stage begins at 1 s"),
        (
            reefed(json!(0.8), json!({"drag_area": 9.4, "filling_time": 0.5})),
            "reefing-line",
            "its schedule has one stage",
        ),
        (reefed(json!(1.0), stages(1.0)), "reefing-line", "is cut at 1 s, and no air slows the opening"),
        (isa(85e3, 200.0), "thin-air", "may rise, as high as 87040 m"),
    ] {
        let (codes, texts) = warnings(&case);
        assert_eq!(codes, [code], "{texts}");
        assert!(texts.contains(words), "no \"{words}\" in {texts}");
    }
    for case in [
        rig(),
        schedule(json!({"drag_coefficient": 0.75, "filling_constant": 8})),
        schedule(json!({"drag_area": 9.4, "filling_time": 15})),
        slow(3.0),
        with(&reefed(json!(1.0), stages(1.0)), &[(&format!("{N}/aero/canopy/inflow_loss"), json!(1))]),
        isa(80e3, -20.0),
    ] {
        let (codes, texts) = warnings(&case);
        assert!(codes.is_empty(), "{texts}of {case}");
    }
}

/// A schedule for cloth that is tight or unknown is warned of with the load that was measured, 0.6 m V^2/D0. Canopies
/// with slots, full ones and those whose cloth lets air through are not meant.
#[test]
fn a_schedule_for_tight_cloth_is_warned_of() {
    let canopy = format!("{N}/aero/canopy");
    let law = |value: Value| with(&rig(), &[(&format!("{canopy}/law"), value)]);
    let permeable = |a: f64| json!({"permeable": {"a": a, "b": 0, "thickness": 1e-4}});
    let ringslot = |case: &Value| {
        let parachute = &format!("{N}/mesh/parachute");
        let slots = [("type", json!("ringslot")), ("rings", json!(2)), ("slot_porosity", json!(0.15))];
        let slots = slots.map(|(key, value)| (format!("{parachute}/{key}"), value));
        with(case, &slots.each_ref().map(|(key, value)| (key.as_str(), value.clone())))
    };
    let unknown = law(Value::Null);
    // 124.5 Pa through 0.1 m/s, and a little more.
    for (case, words) in [
        (unknown.clone(), "no permeability of its cloth is given: measured openings"),
        (law(permeable(1.3e7)), "and its cloth is tight: measured openings"),
    ] {
        let (codes, texts) = warnings(&case);
        assert_eq!(codes, ["tight-cloth"], "{texts}");
        let mass = 20.0 + 0.05 * 12.5 + 0.3;
        let load = 0.6 * mass * 400.0 / 4.0;
        assert!(texts.contains(words) && texts.contains("K m V^2/D0 with K = 0.6, here 12"), "{load}: {texts}");
        assert!(texts.contains("at 20 m/s on D0 = 4 m; take \"filling\""), "{texts}");
    }
    let full =
        with(&unknown, &[(&format!("{canopy}/schedule"), json!({"drag_area": 9.4, "filling_time": 1, "start": -2}))]);
    for case in [law(permeable(1.2e7)), ringslot(&unknown), full] {
        let (codes, texts) = warnings(&case);
        assert!(!codes.contains(&"tight-cloth".to_owned()), "{texts}of {case}");
    }
    let table = [(
        canopy.as_str(),
        json!({"on": {"group": "canopy"}, "table": {"pressure_coefficient": 1.7}, "law": permeable(1e6)}),
    )];
    let refused = Case::from_text(with(&rig(), &table).to_string(), "case.json", PathBuf::new(), &[]);
    let text = refused.err().map(|error| error.to_string()).unwrap_or_default();
    assert!(text.contains("aero/canopy/law") && text.contains("only beside schedule"), "{text}");
}

#[test]
fn drag_areas_and_filling_times_that_say_nothing_are_refused() {
    let schedule = |value: Value| with(&rig(), &[(&format!("{N}/aero/canopy/schedule"), value)]);
    let at_rest = with(&rig(), &[(&format!("{N}/initial"), Value::Null)]);
    // Rounding is no speed.
    let drifting = with(
        &rig(),
        &[
            (&format!("{N}/aero/wind"), json!([25, 0, 1e-17])),
            (&format!("{N}/initial"), json!({"velocity": [25, 0, 0]})),
        ],
    );
    for (case, pointer, words) in [
        (at_rest, "schedule/speed", "at rest in the air"),
        (drifting, "schedule/speed", "a speed above 0"),
        // A type whose drag coefficient was found takes that.
        (
            with(
                &schedule(json!({"filling_constant": 8})),
                &[
                    (&format!("{N}/mesh/parachute/type"), json!("square")),
                    (&format!("{N}/mesh/parachute/start"), json!("flat")),
                ],
            ),
            "canopy/schedule",
            "exactly one of drag_area and drag_coefficient",
        ),
        (
            schedule(json!({"drag_area": 9.4, "drag_coefficient": 0.75, "filling_constant": 8})),
            "canopy/schedule",
            "exactly one of drag_area and drag_coefficient",
        ),
        (schedule(json!({"drag_coefficient": -0.75, "filling_time": 1})), "schedule/drag_coefficient", "above 0"),
    ] {
        let made = Case::from_text(case.to_string(), "case.json", PathBuf::new(), &[]);
        let message = made.err().unwrap_or_else(|| panic!("{words}: {case} was taken")).to_string();
        assert!(message.contains(&format!("{pointer}:")) && message.contains(words), "{message}");
    }
}

/// The largest and the last value of a quantity of the canopy.
fn of_canopy(summary: &Value, quantity: &str) -> [f64; 2] {
    let peaks = summary["peaks"].as_array().expect("peaks");
    let peak = peaks.iter().find(|peak| peak["quantity"] == quantity).unwrap_or_else(|| panic!("no {quantity}"));
    ["value", "last"].map(|key| peak[key].as_f64().expect("a number"))
}

/// A drone's canopy, stretched upwards across a flight at 20 m/s: it fills by the speed that it has, turns into the
/// wind, and brakes the flight. It was told to have an opening load of 1e-28 N.
#[test]
fn a_canopy_across_the_flight_turns_into_the_wind() {
    let folder = tempfile::tempdir().expect("a folder");
    let across =
        [(&*format!("{N}/initial"), json!({"velocity": [20, 0, 0]})), ("/time/method", json!("backward-euler"))];
    let case = with(&rig(), &across);
    let run = program(folder.path(), &case, &["solve"]);
    assert_eq!(run.status, Some(0), "{}{}", run.stdout, run.stderr);
    let found = summary(folder.path(), "rig");
    let [lean, lean_at_end] = of_canopy(&found, "angle_of_attack");
    assert!(lean_at_end < 30.0, "{lean} {lean_at_end}");
    let [load, _] = of_canopy(&found, "drag");
    assert!((200.0..2000.0).contains(&load), "{load} N");
    assert!(run.stdout.contains("CD0") && run.stdout.contains("Dp/D0"), "{}", run.stdout);
    assert_eq!(run.stderr.contains("[leaning-canopy]"), lean > 30.0, "{lean}: {}", run.stderr);
}

/// The same rig, turned so that its payload flies ahead: the same load as in a fall, but for the weight.
#[test]
fn a_turned_rig_opens_as_one_that_falls() {
    let folder = tempfile::tempdir().expect("a folder");
    let weightless =
        [(&*format!("{N}/gravity"), Value::Null), ("/time/end", json!(0.5)), ("/time/method", json!("backward-euler"))];
    let falling = with(&rig(), &weightless);
    let mut turned = with(&falling, &[(&format!("{N}/initial"), json!({"velocity": [12, -16, 0]}))]);
    let parachute = &mut turned["system"]["network"]["mesh"]["parachute"];
    (parachute["axis"], parachute["at"]) = (json!([-3, 4, 0]), json!([100, 20, 300]));
    let loads = [falling, turned].map(|case| {
        let run = program(folder.path(), &case, &["solve", "--force"]);
        assert_eq!(run.status, Some(0), "{}{}", run.stdout, run.stderr);
        of_canopy(&summary(folder.path(), "rig"), "drag")
    });
    for (one, other) in loads[0].iter().zip(&loads[1]) {
        assert!((one / other - 1.0).abs() < 1e-5, "{loads:?}");
    }
}

#[test]
fn check_prints_the_drag_coefficient() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = program(folder.path(), &rig(), &["check"]);
    assert!(run.stdout.contains("full drag area 9.4 m^2: CD0 0.748; Dp/D0 0.6"), "{}", run.stdout);
}
