//! `model: "point"`: the whole parachute as one mass with a drag area, against closed forms and the full model.

use canopy_fem::case::Case;
use canopy_fem::case::spec::SystemSpec;
use serde_json::{Value, json};

use crate::bench::Bench;

/// [m/s^2], [kg/m^3]
const GRAVITY: f64 = 9.81;
const DENSITY: f64 = 1.225;
/// [m^2] of the canopy
const AREA: f64 = 42.9;

/// The shipped parachute as a point.
fn c9() -> Value {
    let path = format!("{}/assets/cases/parachute/c9-drop.json", env!("CARGO_MANIFEST_DIR"));
    let mut case: Value = serde_json::from_str(&std::fs::read_to_string(path).expect("a case")).expect("JSON");
    case["system"]["network"]["model"] = json!("point");
    case
}

/// [kg] Mass of a case.
fn mass(case: &Value) -> f64 {
    let case = Case::from_text(case.to_string(), "case.json", "".into(), &[]).expect("a case");
    match &case.problem().system {
        SystemSpec::Network(spec) => spec.mass.iter().sum(),
        SystemSpec::Pendulum(_) => unreachable!("a network"),
    }
}

fn written(case: &Value) -> Bench {
    let bench = Bench::new();
    std::fs::write(bench.path("case.json"), case.to_string()).expect("written");
    bench
}

/// `summary.json` of a case.
fn solved(case: &Value, flags: &[&str]) -> (Bench, Value) {
    let bench = written(case);
    let ended = bench.run(&[&["solve", "case.json", "--out", "out", "--quiet"], flags].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let summary = bench.results().summary();
    (bench, summary)
}

/// The largest and the last value of a column.
fn peak(summary: &Value, name: &str, quantity: &str) -> [f64; 2] {
    let all = summary["peaks"].as_array().expect("peaks");
    let one = all.iter().find(|peak| peak["name"] == name && peak["quantity"] == quantity);
    let one = one.unwrap_or_else(|| panic!("{name}, {quantity}: not in {all:#?}"));
    ["value", "last"].map(|key| one[key].as_f64().expect("a number"))
}

fn near(what: &str, value: f64, expected: f64, share: f64) {
    assert!((value - expected).abs() <= share * expected.abs(), "{what}: {value}, not {expected} within {share}");
}

/// Without gravity the largest drag over q_s CdS is tau^j/(1 + tau^(j + 1)/(A (j + 1)))^2 with
/// A = 2 m/(rho CdS v_s t_f) and tau = min(1, (j A (j + 1)/(j + 2))^(1/(j + 1))) (Pflanz 1942), whatever the direction;
/// that of an infinite mass is q_s CdS.
#[test]
fn opening_loads_are_those_of_pflanz() {
    let speed = 45.0;
    for (direction, payload, j, a) in [
        ([0.0, 0.0, -1.0], 90.7, 2.0, 0.1),
        ([0.6, 0.0, -0.8], 90.7, 2.0, 1.0),
        ([0.0, 1.0, 0.0], 90.7, 1.0, 0.3),
        ([0.0, 0.0, -1.0], 1e9, 2.0, 1e9),
    ] {
        let mut case = c9();
        let network = &mut case["system"]["network"];
        network["mass"]["points"][0]["mass"] = json!(payload);
        network["gravity"] = json!([0, 0, 0]);
        network["aero"]["drag"] = json!([]);
        network["initial"]["velocity"] = json!(direction.map(|of: f64| of * speed));
        let m = mass(&case);
        let filling = 2.0 * m / (DENSITY * AREA * speed * a);
        case["system"]["network"]["aero"]["canopy"]["schedule"] =
            json!({"drag_area": AREA, "filling_time": filling, "exponent": j});
        case["time"] = json!({"end": 1.2 * filling, "method": "newmark", "step": filling / 2000.0});
        let (_, summary) = solved(&case, &[]);
        let tau = (j * a * (j + 1.0) / (j + 2.0)).powf(1.0 / (j + 1.0)).min(1.0);
        let factor = tau.powf(j) / (1.0 + tau.powf(j + 1.0) / (a * (j + 1.0))).powi(2);
        let load = 0.5 * DENSITY * speed * speed * AREA;
        near(&format!("{direction:?}, {j}, {a}"), peak(&summary, "canopy", "drag")[0] / load, factor, 1e-4);
    }
}

/// The tension of a riser is the payload's weight without its drag in steady flight, and with half of the riser itself.
/// The speed is that of equal weight and drag, and the drift that of the wind.
#[test]
fn it_falls_and_drifts_steadily() {
    let mut case = c9();
    case["system"]["network"]["aero"]["wind"] =
        json!({"sum": [[4, -1, 0], {"gust": {"velocity": [3, 0, 0], "start": 1, "duration": 1}}]});
    case["time"]["end"] = json!(20);
    let gauges = case["output"]["gauges"].as_array_mut().expect("gauges");
    gauges.push(json!({"name": "all", "on": "all", "of": "velocity"}));
    let m = mass(&case);
    let (_, summary) = solved(&case, &[]);
    let speed = (2.0 * m * GRAVITY / (DENSITY * (AREA + 0.5))).sqrt();
    near("speed", peak(&summary, "canopy", "axial_speed")[1], speed, 1e-5);
    for (column, expected) in [("velocity_x", 4.0), ("velocity_y", -1.0), ("velocity_z", -speed)] {
        near(column, peak(&summary, "all", column)[1], expected, 1e-3);
    }
    let q = 0.5 * DENSITY * speed * speed;
    let tension = peak(&summary, "riser", "tension_max")[1];
    near("tension", tension, (90.7 + 0.05) * GRAVITY - 0.5 * q, 1e-4);
    near("drag", peak(&summary, "canopy", "drag")[1], q * AREA, 1e-4);
    assert_eq!(tension, peak(&summary, "riser", "tension_sum")[1], "a riser of one edge");
}

/// The numbers of the full model, and their names: loads within 1 %, those of the payload within 2 %.
#[test]
fn its_numbers_are_those_of_the_full_model() {
    let point = c9();
    let mut full = point.clone();
    full["system"]["network"].as_object_mut().expect("a network").remove("model");
    let [(_, point), (_, full)] = [&point, &full].map(|case| solved(case, &["--end", "2.5"]));
    for (name, quantity, share) in [
        ("canopy", "drag", 0.01),
        ("canopy", "drag_area", 1e-6),
        ("riser", "tension_max", 0.02),
        ("payload", "acceleration_max", 0.02),
    ] {
        let [own, of_full] = [&point, &full].map(|summary| peak(summary, name, quantity)[0]);
        near(&format!("{name} {quantity}"), own, of_full, share);
    }
    assert!(point["peaks"].as_array().expect("peaks").iter().all(|peak| peak["quantity"] != "projected_diameter"));
}

/// The air that a canopy takes along has inertia and no weight: from rest a = m g/(m + k rho 0.07614 D0^3).
#[test]
fn it_takes_air_along() {
    let mut case = c9();
    let network = &mut case["system"]["network"];
    network["initial"] = Value::Null;
    let canopy = &mut network["aero"]["canopy"];
    canopy["apparent_mass"] = json!(1.5);
    canopy["schedule"] = json!({"drag_area": AREA, "filling_time": 1, "start": -5});
    case["time"]["end"] = json!(10);
    let m = mass(&case);
    let (bench, summary) = solved(&case, &[]);
    let text = bench.results().text("gauges.csv");
    let first = text.lines().find(|line| line.contains("payload,acceleration_max")).expect("a row");
    let first: f64 = first.rsplit(',').next().expect("a value").parse().expect("a number");
    // S0 of 28 gores on the mesh is a little less than that of a circle.
    let air = 1.5 * DENSITY * 0.076_14 * 8.534_f64.powi(3);
    near("acceleration", first, m * GRAVITY / (m + air), 0.003);
    let speed = (2.0 * m * GRAVITY / (DENSITY * (AREA + 0.5))).sqrt();
    near("speed", peak(&summary, "canopy", "axial_speed")[1], speed, 1e-4);
    near("tension", peak(&summary, "riser", "tension_max")[1], 90.75 * GRAVITY - 0.25 * DENSITY * speed * speed, 1e-3);
}

/// A payload that is held until it is released, stages of the drag area, adaptive steps, and any number of threads.
#[test]
fn events_and_stages_are_those_of_the_case() {
    let mut case = c9();
    let network = &mut case["system"]["network"];
    network["initial"] = Value::Null;
    network["supports"] = json!([{"on": {"group": "payload"}, "fix": "xyz", "until": 0.5}]);
    network["aero"]["wind"] = json!([0, 0, 30]);
    network["aero"]["canopy"]["schedule"] = json!([
        {"drag_area": 6, "filling_time": 0.2},
        {"drag_area": AREA, "filling_time": 0.5, "start": 1.0}
    ]);
    case["time"] = json!({"end": 2.0, "method": "newmark", "step": 0.002});
    let gauges = case["output"]["gauges"].as_array_mut().expect("gauges");
    gauges.push(json!({"name": "hold", "on": {"group": "payload"}, "of": "reaction"}));
    let (bench, summary) = solved(&case, &["--threads", "1"]);
    let q = 0.5 * DENSITY * 900.0;
    let above = mass(&case) - 90.75;
    let rows = bench.results().text("gauges.csv");
    let at = |t: &str, of: &str| -> f64 {
        let row = rows.lines().find(|line| line.starts_with(&format!("{t},{of},"))).expect("a row");
        row.rsplit(',').next().expect("a value").parse().expect("a number")
    };
    near("held", at("0.3", "riser,tension_max"), 6.0 * q - above * GRAVITY, 1e-9);
    near("reaction", at("0.3", "hold,reaction_total"), 6.5 * q - mass(&case) * GRAVITY, 1e-9);
    assert_eq!(at("0.8", "hold,reaction_total"), 0.0);
    near("second stage", peak(&summary, "canopy", "drag_area")[1], AREA, 1e-12);
    let (two, _) = solved(&case, &["--threads", "2"]);
    assert_eq!(two.results().text("gauges.csv"), rows);
    case["time"] = json!({"end": 2.0, "method": "newmark", "tolerance": {"relative": 1e-6, "absolute": 1e-8}});
    let (_, adaptive) = solved(&case, &[]);
    for (name, quantity) in [("canopy", "drag"), ("riser", "tension_max")] {
        near(quantity, peak(&adaptive, name, quantity)[0], peak(&summary, name, quantity)[0], 1e-3);
    }
}

/// A canopy with a glide ratio and a payload with drag glide steadily by lift over both drags, against the wind; a net
/// refuses to.
#[test]
fn a_point_glides_and_a_net_does_not() {
    let (ratio, payload) = (2.0, 0.5);
    let mut case = c9();
    let network = &mut case["system"]["network"];
    network["aero"]["canopy"]["glide"] = json!({"ratio": ratio, "heading": 270});
    network["aero"]["wind"] = json!([4, -1, 0]);
    case["time"] = json!({"end": 60, "method": "dormand-prince", "tolerance": {"relative": 1e-8, "absolute": 1e-6}});
    let gauges = case["output"]["gauges"].as_array_mut().expect("gauges");
    gauges.push(json!({"name": "all", "on": "all", "of": "velocity"}));
    let m = mass(&case);
    let (_, summary) = solved(&case, &[]);
    let (lift, drag) = (ratio * AREA, AREA + payload);
    let speed = (2.0 * m * GRAVITY / (DENSITY * lift.hypot(drag))).sqrt();
    let [forward, down] = [lift, drag].map(|part| speed * part / lift.hypot(drag));
    near("speed", peak(&summary, "canopy", "axial_speed")[1], speed, 1e-5);
    near("drag", peak(&summary, "canopy", "drag")[1], 0.5 * DENSITY * speed * speed * AREA, 1e-5);
    for (column, expected) in [("velocity_x", 4.0 - forward), ("velocity_y", -1.0), ("velocity_z", -down)] {
        near(column, peak(&summary, "all", column)[1], expected, 1e-4);
    }
    let bench = written(&case);
    let ended = bench.run(&["check", "case.json", "--set", "system.network.model=null"]);
    assert_eq!(ended.code, Some(2), "{}", ended.stdout);
    for words in ["/system/network/aero/canopy/glide:", "a net that glides", "\"model\": \"point\""] {
        assert!(ended.stderr.contains(words), "no {words}: {}", ended.stderr);
    }
}

/// What a point cannot have is refused at its key.
#[test]
fn what_a_point_has_not_is_refused() {
    for (set, at, words) in [
        (
            r#"system.network.aero.canopy={"on":{"group":"canopy"},"table":{"pressure_coefficient":1.7}}"#,
            "/system/network/aero/canopy",
            "canopies with a schedule",
        ),
        ("system.network.aero.canopy=null", "/system/network/aero/canopy", "a canopy with a schedule"),
        (
            r#"output.probes=[{"name":"rim","on":{"group":"skirt"}}]"#,
            "/output/probes/0/on",
            "the payload, or all nodes",
        ),
        (r#"output.gauges.0.on={"group":"lines"}"#, "/output/gauges/0/on", "each carries all canopies"),
        (r#"output.gauges.1={"name":"c","on":"all","of":"crossings"}"#, "/output/gauges/1/of", "a point has no cloth"),
        ("system.network.springs.6.cut=1.0", "/system/network/springs/6/cut", "a riser that is cut"),
        (r#"system.network.supports=[{"on":{"group":"skirt"},"fix":"x"}]"#, "/system/network/supports", "the payload"),
        (r#"system.network.loads=[{"on":"all","pressure":1.0}]"#, "/system/network/loads", "forces on the payload"),
        ("system.network.damping.rayleigh.mass=1", "/system/network/damping", "mass-proportional"),
        (r#"system.network.model="points""#, "/system/network/model", "point"),
    ] {
        let bench = written(&c9());
        let ended = bench.run(&["check", "case.json", "--set", set]);
        assert_eq!(ended.code, Some(2), "{set}: {}", ended.stdout);
        assert!(ended.stderr.contains(&format!("{at}:")) && ended.stderr.contains(words), "{set}: {}", ended.stderr);
    }
    // A reefing line may be cut: the stages tell what follows.
    let reefed = format!("{}/assets/cases/parachute/g12-reefed.json", env!("CARGO_MANIFEST_DIR"));
    let mut case: Value = serde_json::from_str(&std::fs::read_to_string(reefed).expect("a case")).expect("JSON");
    case["system"]["network"]["model"] = json!("point");
    case["output"]["gauges"].as_array_mut().expect("gauges").truncate(1);
    let (_, summary) = solved(&case, &[]);
    near("load", peak(&summary, "canopy", "drag")[0], 53_500.0, 0.04);
}
