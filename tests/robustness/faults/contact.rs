//! Contact at the start: parts that are too close, cloth that is entangled, and what `check` says of each contact.

use serde_json::{Value, json};

use super::program::program;
use super::warnings::{warnings, with};

/// Two triangles of cloth, one 0.1 m above the other, and a line of which one end is 0.04 m beside an edge of the
/// lower one. A support holds a node, so that nothing else is to be said.
fn close(contact: &Value) -> Value {
    json!({"name": "close", "system": {"network": {
        "mesh": {"explicit": {
            "nodes": [[0,0,0],[1,0,0],[0,1,0],[0,0,0.1],[1,0,0.1],[0,1,0.1],[0.5,-0.04,0],[0.5,-1,0]],
            "springs": [[6, 7]], "triangles": [[0,1,2],[3,4,5]],
            "groups": {"lower": {"triangles": [0]}, "upper": {"triangles": [1]}, "line": {"edges": [0]}}}},
        "mass": {"nodal": 0.1},
        "springs": [{"on": "all", "stiffness": 100.0}],
        "contact": contact}},
        "time": {"end": 0.01, "method": "velocity-verlet", "step": 1e-3}})
}

/// The warnings of a case but for those of its lack of supports.
fn told(case: &Value) -> (usize, String) {
    let (codes, text) = warnings(case);
    (codes.iter().filter(|code| *code == "contact-at-start").count(), text)
}

#[test]
fn parts_that_start_within_the_gap_are_told() {
    for (contact, words) in [
        (
            json!({"between": ["lower", "upper"], "gap": 0.11}),
            "nodes 0, 1 and 2 and the triangle of nodes 3, 4 and 5, 0.1 m",
        ),
        (json!({"between": ["lower", "line"], "gap": 0.05}), "nodes 0, 1 and 2 and the line of nodes 6 and 7, 0.04 m"),
        (json!({"between": "self", "gap": 0.05}), "1 pair of its parts is closer at the start than the gap of 0.05 m"),
        (json!({"between": ["all", "upper"], "gap": 0.2}), "2 pairs of its parts are closer"),
    ] {
        let (count, text) = told(&close(&json!([contact])));
        assert!(count == 1 && text.contains(words), "{contact}: {text}");
    }
    for contact in [
        json!({"between": ["lower", "upper"], "gap": 0.09}),
        json!({"between": ["upper", "line"], "gap": 0.05}),
        json!({"between": "self", "gap": 0.03}),
        json!({"between": ["all", {"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}], "gap": 0.5}),
    ] {
        let (count, text) = told(&close(&json!([contact])));
        assert_eq!(count, 0, "{contact}: {text}");
    }
    // What never moves is pushed nowhere; a case can accept the warning.
    let near = close(&json!([{"between": ["lower", "upper"], "gap": 0.11}]));
    let held = with(&near, &[("/system/network/supports", json!([{"on": {"ids": [0, 1, 2, 3, 4, 5]}, "fix": "xyz"}]))]);
    assert_eq!(told(&held).0, 0);
    assert_eq!(told(&with(&near, &[("/acknowledge", json!(["contact-at-start"]))])).0, 0);
}

/// Cloth that passes through cloth is told as without contact, and that contact does not part it.
#[test]
fn entangled_cloth_is_told() {
    let mut case = close(&json!([{"between": ["lower", "upper"], "gap": 0.01}]));
    case["system"]["network"]["mesh"]["explicit"]["nodes"][3] = json!([0.2, 0.2, -0.1]);
    let (count, text) = told(&case);
    assert!(count == 1 && text.contains("which meet or pass through each other"), "{text}");
    assert!(text.contains("contact leaves every sheet on the side where it starts"), "{text}");
}

/// `check` has a line for each contact, for runs and for equilibria.
#[test]
fn check_lists_every_contact() {
    let folder = tempfile::tempdir().expect("a folder");
    let ball = json!({"sphere": {"center": [0, 0, -5], "radius": 0.5}, "motion": {"table": [[0, 0, 0, 0]]}});
    let contact = json!([
        {"between": ["lower", "upper"], "gap": 0.005, "friction": 0.3},
        {"between": "self", "gap": 0.01},
        {"between": ["all", ball]}
    ]);
    let case =
        with(&close(&contact), &[("/system/network/supports", json!([{"on": {"ids": [0, 3, 7]}, "fix": "xyz"}]))]);
    let said = program(folder.path(), &case, &["check"]);
    assert_eq!(said.status, Some(0), "{}", said.stderr);
    for line in [
        "  contact         lower with upper: gap 0.005 m, friction 0.3; 1 triangle with 1 triangle\n",
        "  contact         everything with itself: gap 0.01 m, no friction; 2 triangles, 1 line\n",
        "  contact         everything with a sphere of radius 0.5 m that moves: gap 0.192 m, no friction; 2 triangles, 1 line\n",
        "                  3 nodes, 3 edges, 1 triangle with 3 nodes, 3 edges, 1 triangle; ",
        "                  8 nodes, 7 edges, 2 triangles with 1 node; 0 pairs near at the start, 0 of them touching\n",
        "\n  contact cost    ",
        "\n  contact step    contact ",
    ] {
        assert!(said.stdout.contains(line), "{line} is not in\n{}", said.stdout);
    }
}

/// A net of 0.1 kg a node that lies 4 mm above the ground, and its 0.01 m gap.
fn lies(time: &Value) -> Value {
    json!({"name": "lies", "system": {"network": {
        "mesh": {"rectangle": {"width": 0.4, "height": 0.4, "columns": 4, "rows": 4}},
        "mass": {"nodal": 0.1},
        "springs": [{"on": "all", "stiffness": 100.0}],
        "gravity": [0, 0, -9.81],
        "contact": [
            {"between": "self", "gap": 0.01},
            {"between": ["all", {"plane": {"point": [0, 0, -0.004], "normal": [0, 0, 1]}}], "gap": 0.01}
        ]}},
        "time": time})
}

/// `check --json` counts what is near and touches, measures what contact costs, and has the step that it leaves: with
/// kappa = m g/g0 two nodes of the same mass have w^2 = 2 10.08 g/g0, and a node on the ground half of that.
#[test]
fn check_has_counts_and_steps_of_contacts() {
    let folder = tempfile::tempdir().expect("a folder");
    for (method, told) in [("velocity-verlet", "velocity-verlet"), ("newmark", "velocity-verlet"), ("rk4", "rk4")] {
        let case = lies(&json!({"end": 0.01, "method": method, "step": 1e-3}));
        let said = program(folder.path(), &case, &["check", "--json"]);
        assert_eq!(said.status, Some(0), "{}", said.stderr);
        let report: Value = serde_json::from_str(&said.stdout).expect("JSON");
        let [itself, ground] = [0, 1].map(|i| &report["contacts"][i]);
        assert_eq!(itself["between"], json!("everything with itself"));
        assert_eq!(ground["first"], json!({"nodes": 25, "edges": 56, "triangles": 32}));
        assert_eq!(ground["second"], json!({"nodes": 0, "edges": 0, "triangles": 0}));
        let of = |contact: &Value| ["near", "touching", "at_one_node"].map(|key| contact[key].as_u64());
        assert_eq!(of(ground), [Some(25), Some(25), Some(1)]);
        assert_eq!(of(itself)[1], Some(0), "{itself}");
        // A node has at most six springs of 100 N/m: a twentieth of that is below the weight over the gap.
        let root = if told == "rk4" { 8.0_f64.sqrt() } else { 2.0 };
        let right = root / (10.0826 * 9.81 / 0.01_f64).sqrt();
        for (contact, right) in [(ground, right), (itself, right / 2.0_f64.sqrt())] {
            let step = contact["explicit_step"].as_f64().expect("a step");
            assert!((step / right - 1.0).abs() < 1e-3, "{method}: {step} and not {right}");
        }
        let limit = &report["contact_limit"];
        assert_eq!((&limit["contact"], &limit["method"]), (&json!(0), &json!(told)));
        assert!(limit["critical_step"].as_f64().is_some_and(|step| step > 0.0), "{limit}");
        let cost = &report["force"]["contact"];
        for key in ["seconds", "search_seconds", "share"] {
            assert!(cost[key].as_f64().is_some_and(|value| value > 0.0), "{cost}");
        }
    }
    let mut without = lies(&json!({"end": 0.01, "method": "rk4", "step": 1e-3}));
    without["system"]["network"].as_object_mut().expect("an object").remove("contact");
    let report: Value =
        serde_json::from_str(&program(folder.path(), &without, &["check", "--json"]).stdout).expect("JSON");
    assert_eq!((&report["contacts"], &report["contact_limit"]), (&json!([]), &Value::Null));
    assert_eq!(report["force"]["contact"], Value::Null);
}

/// A step that is longer than a contact allows is told before the run, of explicit methods only, and a case can accept
/// it.
#[test]
fn steps_that_contact_does_not_allow_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let said = |method: &str, step: f64, sets: &[(&str, Value)]| {
        let mass = json!({"name": "mass", "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0.008]]}},
            "mass": {"nodal": [2.0]},
            "gravity": [0, 0, -9.81],
            "contact": [{"between": ["all", {"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}], "gap": 0.01}]}},
            "time": {"end": 0.1, "method": method, "step": step}});
        let said = program(folder.path(), &with(&mass, sets), &["check"]);
        assert_eq!(said.status, Some(0), "{}", said.stderr);
        said.stdout
    };
    // 2/sqrt(10.08 g/g0) = 0.0201 s
    let words = "warning: contact 0: the step of 0.021 s is longer than the 0.0201 s that velocity-verlet may take";
    let long = said("velocity-verlet", 0.021, &[]);
    assert!(long.contains(words) && long.contains("[contact-step]"), "{long}");
    for (method, step) in [("velocity-verlet", 0.02), ("newmark", 0.021)] {
        let text = said(method, step, &[]);
        assert!(!text.contains("contact-step"), "{method}: {text}");
    }
    let accepted = said("velocity-verlet", 0.021, &[("/acknowledge", json!(["contact-step"]))]);
    assert!(accepted.contains("acknowledged: contact 0"), "{accepted}");
}
