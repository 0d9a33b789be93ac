//! The shipped parachutes from their start to the end: without a word of warning, to the loads and speeds that are
//! known of them.

use crate::bench::Bench;
use serde_json::Value;

/// The largest and the last value of a gauge in `summary.json`.
fn peak(summary: &Value, name: &str, quantity: &str) -> [f64; 2] {
    let all = summary["peaks"].as_array().expect("peaks");
    let one = all.iter().find(|peak| peak["name"] == name && peak["quantity"] == quantity);
    let one = one.unwrap_or_else(|| panic!("{name}, {quantity}: not in {all:?}"));
    ["value", "last"].map(|key| one[key].as_f64().expect("a number"))
}

/// [s] When a gauge is largest.
fn peak_time(summary: &Value, name: &str, quantity: &str) -> f64 {
    let all = summary["peaks"].as_array().expect("peaks");
    let one = all.iter().find(|peak| peak["name"] == name && peak["quantity"] == quantity);
    one.expect("a gauge")["t"].as_f64().expect("a time")
}

/// `summary.json` of a shipped parachute, and what the terminal says.
fn flown(name: &str) -> (Value, String) {
    let bench = Bench::new();
    let case = format!("{}/assets/cases/parachute/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let ended = bench.run(&["solve", &case, "--out", "out"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let summary: Value = serde_json::from_str(&bench.results().text("summary.json")).expect("JSON");
    // Canopies beside each other go through each other, which is told; there is no contact.
    let (warned, crossed) = (ended.stderr.matches("warning").count(), ended.stderr.matches("[cloth-crossing]").count());
    assert_eq!((warned, crossed), if name == "cluster" { (1, 1) } else { (0, 0) }, "{}", ended.stderr);
    let energy_error = summary["energy_error"].as_f64().expect("a number");
    assert!(energy_error < 1e-4, "{name}: {energy_error:e}");
    (summary, ended.stdout)
}

fn within(what: &str, value: f64, [low, high]: [f64; 2]) {
    assert!((low..=high).contains(&value), "{what}: {value}, not {low} to {high}");
}

/// [N] The largest drag of the canopy on a body of `mass` [kg] that falls at 45 m/s while its drag area grows by
/// (t/t_f)^2, t_f = 8 D0/45.
fn braked(mass: f64) -> f64 {
    let (mut v, mut most, step, filling) = (45.0, 0.0_f64, 1e-4, 8.0 * 8.534 / 45.0);
    for i in 0..20_000 {
        let area = 42.9 * (f64::from(i) * step / filling).min(1.0).powi(2);
        let pressure = 0.5 * 1.225 * v * v;
        most = most.max(pressure * area);
        v += step * (9.81 - pressure * (area + 0.5) / mass);
    }
    most
}

/// sqrt(2 m g/(rho CdS)) with the drag areas of canopy and payload, the cloth's and the lines' weight; lines add a
/// little drag.
#[test]
fn a_c9_opens_and_falls() {
    let (summary, text) = flown("c9-drop");
    let mass: f64 = 90.7 + 0.0534 * 57.0 + 0.1 + 0.006 * 361.0;
    let speed = (2.0 * mass * 9.81 / (1.225 * (42.9 + 0.5))).sqrt();
    within("speed", peak(&summary, "canopy", "axial_speed")[1], [0.99 * speed, 1.001 * speed]);
    let load = braked(mass);
    within("largest drag", peak(&summary, "canopy", "drag")[0], [0.985 * load, 1.015 * load]);
    // Cloth and lines are braked too, and fall.
    within("load of the riser", peak(&summary, "riser", "tension_max")[0], [0.92 * load, load]);
    within("projected diameter over D0", peak(&summary, "canopy", "projected_diameter")[1] / 8.534, [0.64, 0.70]);
    assert!(text.contains("opening load") && text.contains("safety factor") && text.contains("steady"), "{text}");
}

/// It is told no filling time. Its load is largest while it falls what would be 4.5 to 9 diameters at the first speed.
#[test]
fn a_c9_fills_by_itself() {
    let (summary, _) = flown("c9-filling");
    within("speed", peak(&summary, "canopy", "axial_speed")[1], [5.6, 6.4]);
    within("load of the riser", peak(&summary, "riser", "tension_max")[0], [5.5e3, 9.5e3]);
    within("projected diameter over D0", peak(&summary, "canopy", "projected_ratio")[1], [0.64, 0.70]);
    let diameter = 8.534 / 45.0;
    within("time of the largest load", peak_time(&summary, "riser", "tension_max"), [4.5 * diameter, 9.0 * diameter]);
}

/// Within the spread of the three measured drops, 10.9 to 17.3 g with single spikes, or a fifth below it.
#[test]
fn a_rescue_parachute_has_the_load_of_its_test() {
    let (summary, _) = flown("rescue-115kg");
    let felt = peak(&summary, "riser", "tension_max")[0] / (115.0 * 9.81);
    within("felt acceleration over g", felt, [0.8 * 10.89, 17.3]);
}

/// 19 to 23 ft/s. The wind changes by 15 mm/s a metre, so the jumper lags behind it a little.
#[test]
fn a_t10_drifts_with_the_wind() {
    let (summary, _) = flown("t10-drop");
    within("speed", peak(&summary, "canopy", "axial_speed")[1], [19.0 * 0.3048, 23.0 * 0.3048]);
    within("opening load", peak(&summary, "riser", "tension_max")[0], [4500.0, 6500.0]);
}

/// 27.5 to 28.5 ft/s. Without the cut of the reefing line it falls faster, and its skirt stays at the ring.
#[test]
fn a_g12_opens_in_two_stages() {
    let (summary, _) = flown("g12-reefed");
    within("speed", peak(&summary, "canopy", "axial_speed")[1], [27.5 * 0.3048, 28.5 * 0.3048]);
    within("skirt", peak(&summary, "canopy", "skirt_diameter")[1] / 19.507, [0.62, 0.68]);
    within("load with the reefing line", peak(&summary, "riser", "tension_max")[0], [45e3, 58e3]);
    within("reefing line after the cut", peak(&summary, "reefing", "tension_max")[1], [0.0, 0.0]);
}

/// The peak load of flight SR02, to which the coefficient is calibrated; the lines share it evenly.
#[test]
fn a_disk_gap_band_parachute_carries_its_calibrated_load() {
    let (summary, _) = flown("dgb-aspire");
    let load = peak(&summary, "riser", "tension_max")[0];
    within("load", load, [0.99 * 248.2e3, 1.01 * 248.2e3]);
    within("line", 80.0 * peak(&summary, "springs[6] lines", "tension_max")[1] / load, [1.0, 1.05]);
}

/// `check` and `solve` warn of a schedule for cloth of which nothing is known, in the same words, and go on.
#[test]
fn a_schedule_for_unknown_cloth_is_warned_of() {
    let bench = Bench::new();
    let case = format!("{}/assets/cases/parachute/c9-drop.json", env!("CARGO_MANIFEST_DIR"));
    let unknown = ["--set", "system.network.aero.canopy.law=null", "--end", "0.01"];
    let checked = bench.run(&[&["check", &case], &unknown[..]].concat());
    let solved = bench.run(&[&["solve", &case, "--out", "out"], &unknown[..]].concat());
    assert_eq!((checked.code, solved.code), (Some(0), Some(0)), "{}{}", checked.stderr, solved.stderr);
    let told = |text: &str| text.lines().find(|line| line.ends_with("[tight-cloth]")).map(str::to_owned);
    let [checked, solved] = [told(&checked.stdout), told(&solved.stderr)];
    let words = checked.expect("a warning of check");
    assert_eq!(Some(&words), solved.as_ref());
    for part in ["up to three times harder", "K = 0.6", "at 45 m/s on D0 = 8.53 m", "take \"filling\""] {
        assert!(words.contains(part), "no {part} in {words}");
    }
}

/// Both canopies alike.
#[test]
fn two_canopies_share_a_load() {
    let (summary, _) = flown("cluster");
    let speeds = [0, 1].map(|i| peak(&summary, &format!("canopy {i}"), "axial_speed")[1]);
    assert!((speeds[0] / speeds[1] - 1.0).abs() < 1e-4, "{speeds:?}");
    within("speed along the leaning axes", speeds[0], [8.0, 8.8]);
    let weight = 9.81 * (1996.0 + 2.0 * (0.08 * 298.0 + 0.024 * 900.0 + 0.5 * 18.0));
    within("risers over the load", peak(&summary, "risers", "tension_max")[1] * 2.0 / weight, [0.93, 1.07]);
}
