//! A rope with an axial dashpot: no force while it is slack, no push, no jump where it becomes taut, and a ledger that
//! closes.

use super::program::{Finished, program};
use serde_json::{Value, json};
use std::path::Path;

/// A mass of 3 kg, 2 m from the anchor of a rope of `rest` m, moving away at 2 m/s.
fn rope(rest: f64, slack: Value, time: Value) -> Value {
    json!({"name": "rope", "system": {"network": {
        "mesh": {"chain": {"from": [0, 0, 0], "to": [2, 0, 0], "segments": 1}},
        "mass": {"nodal": 3.0},
        "springs": [{"on": "all", "stiffness": 2000.0, "slack": slack, "rest_length": rest,
            "dashpot": {"axial": {"coefficient": 100.0}}}],
        "supports": [{"on": {"ids": [0]}, "fix": "xyz"}, {"on": {"ids": [1]}, "fix": "yz"}],
        "initial": {"velocity": [2, 0, 0]}}},
        "time": time,
        "output": {"gauges": [{"name": "rope", "of": "tension", "on": "all"}, {"name": "end", "of": "position", "on": {"ids": [1]}}],
            "frames": {"every": 0.001}, "history": {"every": 1}}})
}

fn solved(folder: &Path, case: &Value) -> Finished {
    let run = program(folder, case, &["solve", "--force"]);
    assert_eq!(run.status, Some(0), "{}{}", run.stdout, run.stderr);
    run
}

/// The values of a quantity of a gauge, in the order of time.
fn gauge(folder: &Path, name: &str, quantity: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(folder.join("out/rope/gauges.csv")).expect("gauges");
    let rows = text.lines().map(|row| row.split(',').collect::<Vec<_>>());
    let found: Vec<f64> =
        rows.filter(|row| row[1] == name && row[2] == quantity).flat_map(|row| row[3].parse()).collect();
    assert!(!found.is_empty(), "no {quantity} in\n{text}");
    found
}

/// A column of the history.
fn history(folder: &Path, column: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(folder.join("out/rope/history.csv")).expect("a history");
    let at = text.lines().next().expect("a head").split(',').position(|name| name == column).expect("a column");
    text.lines().skip(1).flat_map(|row| row.split(',').nth(at).expect("a column").parse()).collect()
}

/// The mass flies on at 2 m/s until the rope is taut, whatever its kind of slack.
#[test]
fn a_slack_rope_does_not_pull() {
    let folder = tempfile::tempdir().expect("a folder");
    for (rest, slack) in [(2.04, json!("tension-only")), (2.0, json!({"dead_zone": 0.04}))] {
        solved(folder.path(), &rope(rest, slack, json!({"end": 0.01, "method": "rk4", "step": 1e-4})));
        assert!(gauge(folder.path(), "rope", "tension_max").iter().all(|t| *t == 0.0));
        let x = *gauge(folder.path(), "end", "position_x").last().expect("a row");
        assert!((x - 2.02).abs() < 1e-12, "{x}");
    }
}

/// Every method catches the mass and throws it back: tension is between 0 and twice that of the spring, dashpots only
/// take energy, and nothing is taken before the rope is taut or after it is slack again.
#[test]
fn a_rope_that_catches_a_mass_keeps_its_account() {
    let folder = tempfile::tempdir().expect("a folder");
    let end = 0.25;
    let exact = {
        let time = json!({"end": end, "method": "rk4", "step": 1e-5});
        solved(folder.path(), &rope(2.04, json!("tension-only"), time));
        history(folder.path(), "dissipated").last().copied().expect("a row")
    };
    assert!(exact > 2.0 && exact < 6.0, "{exact} J of 6 J");
    for (method, step) in [
        ("velocity-verlet", 1e-4),
        ("rk4", 1e-3),
        ("newmark", 1e-3),
        ("hht", 1e-3),
        ("generalized-alpha", 1e-3),
        ("energy-momentum", 1e-3),
        ("backward-euler", 1e-4),
        ("newmark", 5e-3),
        ("backward-euler", 5e-3),
        ("hht", 5e-3),
    ] {
        let time = json!({"end": end, "method": method, "step": step});
        solved(folder.path(), &rope(2.04, json!("tension-only"), time));
        let [tension, x] = [gauge(folder.path(), "rope", "tension_max"), gauge(folder.path(), "end", "position_x")];
        for (t, x) in tension.iter().zip(&x) {
            let spring = 2000.0 * (x - 2.04).max(0.0);
            assert!((-1e-9..=2.0 * spring + 1e-9).contains(t), "{method}: {t} N at {x} m");
        }
        let taken = history(folder.path(), "dissipated");
        // Where the mass turns within a step, the rule of the ledger has an error of the third order.
        assert!(taken.windows(2).all(|pair| pair[1] - pair[0] >= -1e-6), "{method} at {step}: the loss falls");
        let last = taken.last().copied().expect("a row");
        let numerical = history(folder.path(), "numerical").last().copied().expect("a row");
        assert!(numerical > -0.01, "{method} at {step} makes {numerical} J");
        let tolerance = if step < 2e-3 { 0.03 } else { 0.3 };
        assert!((last - exact).abs() < tolerance * exact, "{method} at {step}: {last} J in place of {exact} J");
        let at = history(folder.path(), "t").iter().position(|t| *t > 0.0181).expect("a row");
        assert!(step > 1e-3 || taken[at] == 0.0, "{method}: {} J while slack", taken[at]);
    }
}
