//! Gauges: rows, largest values and what the terminal says of them, against the closed form of an oscillator.

use crate::bench::{Bench, Ended};
use serde_json::{Value, json};

/// [N/m], [kg], [m/s] stiffness, mass and initial velocity along x
const OSCILLATOR: [f64; 3] = [200.0, 2.0, 1.5];
/// [s]
const STEP: f64 = 0.002;

fn case() -> Value {
    let [k, m, v] = OSCILLATOR;
    json!({
        "name": "gauged",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0]], "springs": [[0, 1]]}},
            "mass": {"nodal": m},
            "springs": [{"on": "all", "stiffness": k, "strength": 60.0}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
            "initial": {"velocity": [v, 0, 0]}
        }},
        "time": {"end": 0.5, "method": "velocity-verlet", "step": STEP},
        "output": {"gauges": [
            {"name": "spring", "on": "all", "of": "tension"},
            {"name": "wall", "on": {"ids": [0]}, "of": "reaction"},
            {"name": "mass", "on": {"ids": [1]}, "of": "acceleration"},
            {"name": "speed", "on": {"ids": [1]}, "of": "speed", "every": 100},
            {"name": "way", "on": {"ids": [0, 1]}, "of": "displacement"},
            {"name": "place", "on": {"ids": [1]}, "of": "position"},
            {"name": "v", "on": {"ids": [1]}, "of": "velocity"}
        ]}
    })
}

fn solve(case: &Value) -> (Bench, Ended) {
    let bench = Bench::new();
    std::fs::write(bench.path("case.json"), case.to_string()).expect("written");
    let ended = bench.run(&["solve", "case.json", "--out", "out"]);
    (bench, ended)
}

/// Time and value of the rows of a channel.
fn rows(text: &str, name: &str, quantity: &str) -> Vec<[f64; 2]> {
    let cells = text.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>());
    let chosen = cells.filter(|cells| cells[1] == name && cells[2] == quantity);
    chosen.map(|cells| [cells[0], cells[3]].map(|cell| cell.parse().expect("a number"))).collect()
}

#[test]
fn gauges_follow_an_oscillator() {
    let (bench, ended) = solve(&case());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let text = bench.results().text("gauges.csv");
    assert_eq!(text.lines().next(), Some("t,name,quantity,value"));
    let [k, m, v] = OSCILLATOR;
    let w = (k / m).sqrt();
    let at = |t: f64| v / w * (w * t).sin();
    type Form<'a> = (&'a str, &'a str, &'a dyn Fn(f64) -> f64);
    let forms: [Form<'_>; 8] = [
        ("spring", "tension_sum", &|t| k * at(t)),
        ("spring", "tension_max", &|t| k * at(t)),
        ("wall", "reaction_x", &|t| -k * at(t)),
        ("mass", "acceleration_x", &|t| -k / m * at(t)),
        ("mass", "acceleration_max", &|t| k / m * at(t).abs()),
        ("way", "displacement_mean", &|t| 0.5 * at(t).abs()),
        ("place", "position_x", &|t| 1.0 + at(t)),
        ("v", "velocity_x", &|t| v * (w * t).cos()),
    ];
    for (name, quantity, form) in forms {
        let rows = rows(&text, name, quantity);
        assert_eq!(rows.len(), 251, "{name} {quantity}");
        let size = rows.iter().fold(0.0, |most: f64, row| most.max(row[1].abs()));
        for [t, value] in rows {
            assert!((value - form(t)).abs() < 1e-3 * size, "{name} {quantity} at {t}: {value} for {}", form(t));
        }
    }
    let times: Vec<f64> = rows(&text, "speed", "speed_max").iter().map(|row| row[0]).collect();
    assert_eq!(times, [0.0, 0.2, 0.4, 0.5], "every hundredth step, and the last");
}

/// Largest values come from all steps: there are no frames here, and no row of `speed` lies at the start of a quarter.
#[test]
fn peaks_are_found_at_every_step() {
    let (bench, ended) = solve(&case());
    let summary = bench.results().summary();
    let peak = |name: &str, quantity: &str| {
        let all = summary["peaks"].as_array().expect("peaks").iter();
        all.into_iter().find(|p| p["name"] == name && p["quantity"] == quantity).expect("is there").clone()
    };
    let [k, m, v] = OSCILLATOR;
    let w = (k / m).sqrt();
    let quarter = 0.5 * std::f64::consts::PI / w;
    let tension = peak("spring", "tension_max");
    assert!((tension["value"].as_f64().expect("N") - k * v / w).abs() < 1e-3 * k * v / w);
    assert!((tension["t"].as_f64().expect("s") - quarter).abs() <= STEP);
    let load = peak("springs[0]", "tension_max");
    let factor = load["safety_factor"].as_f64().expect("a factor");
    assert!((factor - 60.0 / (k * v / w)).abs() < 1e-3 * factor);
    // Of components the largest magnitude counts, with its sign.
    let reaction = peak("wall", "reaction_x");
    assert!((reaction["value"].as_f64().expect("N").abs() - k * v / w).abs() < 1e-3 * k * v / w);
    assert!(ended.stdout.contains("strength 60 N: safety factor 2"), "{}", ended.stdout);
    // Every gauge has a line, with its peak and its time: v/w = 0.15 m from 1 m, at a quarter of a period.
    for words in
        ["(spring, tension)", "(wall, reaction)", "(mass, acceleration)", "(speed, speed)", "(v, velocity along x)"]
    {
        assert!(ended.stdout.contains(words), "no {words} in {}", ended.stdout);
    }
    let line = |words: &str| ended.stdout.lines().find(|line| line.ends_with(words)).unwrap_or_default().to_owned();
    let displacement = line("(way, displacement)");
    assert!(displacement.starts_with("  peak            0.15 m at t = "), "{displacement}");
    assert!(displacement.contains(" m at the end "), "{displacement}");
    let place = line("(place, position along x)");
    assert!(place.starts_with("  peak            1.15 m at t = 0.15"), "{place}");
}

/// A case without gauges has neither file nor peaks, and the other results have the same bytes with and without. Its
/// steps are then made in blocks, also beside an event within a step and one at the end of a step.
#[test]
fn gauges_change_nothing_else() {
    let mut gauged = case();
    gauged["system"]["network"]["springs"][0]["cut"] = json!(0.3173);
    gauged["system"]["network"]["supports"][0]["until"] = json!(0.4);
    let mut plain = gauged.clone();
    plain["output"] = json!({});
    plain["system"]["network"]["springs"][0].as_object_mut().expect("a rule").remove("strength");
    let ([(with, _), (without, _)], path) = ([gauged, plain].map(|case| solve(&case)), "gauges.csv");
    assert!(with.path("out").join(path).exists() && !without.path("out").join(path).exists());
    assert!(without.results().summary().get("peaks").is_none());
    assert_eq!(with.results().text("history.csv"), without.results().text("history.csv"));
}
