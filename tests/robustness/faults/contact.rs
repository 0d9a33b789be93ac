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
    ] {
        assert!(said.stdout.contains(line), "{line} is not in\n{}", said.stdout);
    }
}
