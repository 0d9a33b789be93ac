//! The section `contact`: the parts that names stand for, rigid bodies, the gap that follows from edges, and faults.

use canopy_fem::case::spec::{GaugeOf, SystemSpec};
use canopy_fem::case::{Case, CaseError};
use canopy_fem::model::spec::{ContactParts, ContactSide, ContactSpec, NetworkSpec, ObstacleShape, Series};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

use super::common::faults;

/// A square of two triangles, a triangle 0.1 m above it, a line and a lone node, each a group. "rim" has sides of
/// triangles, "all-kinds" has what is named twice: a side of its triangle, and ends of both.
fn scene(contact: &Value) -> Value {
    json!({"name": "c", "system": {"network": {
        "mesh": {"explicit": {
            "nodes": [[0,0,0],[1,0,0],[1,1,0],[0,1,0],[0,0,0.1],[1,0,0.1],[0,1,0.1],[2,2,2],[3,2,2],[5,5,5]],
            "springs": [[7,8],[0,1],[0,2]],
            "triangles": [[0,1,2],[0,2,3],[4,5,6]],
            "groups": {
                "cloth": {"triangles": [0, 1]}, "cloth-2": {"triangles": [2]}, "line": {"edges": [0]},
                "bob": {"nodes": [9]}, "rim": {"edges": [1]},
                "kinds": {"triangles": [1], "edges": [0, 1, 2], "nodes": [0, 1, 2, 7, 9]}
            }}},
        "mass": {"nodal": 0.1},
        "springs": [{"on": "all", "stiffness": 100.0}],
        "contact": contact}},
        "time": {"end": 0.01, "method": "velocity-verlet", "step": 1e-3}})
}

fn read_at(case: &Value, base: &Path) -> Result<Case, CaseError> {
    Case::from_text(case.to_string(), "c.json", base.to_owned(), &[])
}

fn spec_of(case: &Value) -> NetworkSpec {
    let read = read_at(case, &PathBuf::new()).unwrap_or_else(|e| panic!("{e}"));
    match read.into_problem().system {
        SystemSpec::Network(spec) => *spec,
        SystemSpec::Pendulum(_) => panic!("a network is expected"),
    }
}

fn one(contact: &Value) -> ContactSpec {
    spec_of(&scene(&json!([contact]))).contacts.remove(0)
}

fn parts(triangles: &[u32], edges: &[u32], nodes: &[u32]) -> ContactParts {
    ContactParts { triangles: triangles.to_vec(), edges: edges.to_vec(), nodes: nodes.to_vec() }
}

/// Names stand for triangles, lines that are no sides of them, and nodes that are in neither.
#[test]
fn names_stand_for_parts() {
    let everything = parts(&[0, 1, 2], &[0], &[9]);
    for (name, right) in [
        ("all", everything.clone()),
        ("cloth", parts(&[0, 1], &[], &[])),
        ("line", parts(&[], &[0], &[])),
        ("bob", parts(&[], &[], &[9])),
        // A side of triangles that are not in the group is a line of it.
        ("rim", parts(&[], &[1], &[])),
        // Edge 2 is a side of triangle 1; nodes 0, 1, 2 and 7 are in the elements.
        ("kinds", parts(&[1], &[0, 1], &[9])),
    ] {
        let found = one(&json!({"between": [name, "cloth-2"], "gap": 0.01, "friction": 0.3}));
        let other = ContactSide::Parts(parts(&[2], &[], &[]));
        assert_eq!(found, ContactSpec { parts: right, other, gap: 0.01, friction: 0.3 }, "{name}");
    }
    for between in [json!("self"), json!(["all", "all"])] {
        let found = one(&json!({"between": between}));
        assert_eq!((found.parts, found.other, found.friction), (everything.clone(), ContactSide::Itself, 0.0));
    }
    let found = one(&json!({"between": ["cloth", "cloth"]}));
    assert_eq!((found.parts, found.other), (parts(&[0, 1], &[], &[]), ContactSide::Itself));
}

/// "all" and "self" leave out lines without springs, as the spacers of a cluster may be; their ends are lone nodes.
#[test]
fn lines_without_springs_touch_nothing() {
    for all in [json!("self"), json!(["all", {"plane": {"point": [0, 0, -1], "normal": [0, 0, 1]}}])] {
        let mut case = scene(&json!([{"between": all}]));
        case["system"]["network"]["springs"][0]["on"] = json!({"group": "rim"});
        assert_eq!(spec_of(&case).contacts[0].parts, parts(&[0, 1, 2], &[], &[7, 8, 9]));
    }
}

/// The gap that is not given is a fifth of the shortest edge of both sides, where nodes are at the start.
#[test]
fn the_gap_follows_from_the_shortest_edge() {
    let gap = |case: &Value| spec_of(case).contacts[0].gap;
    let close = |found: f64, right: f64| assert!((found - right).abs() < 1e-15, "{found} {right}");
    let with = |between: &Value| scene(&json!([{"between": between}]));
    close(gap(&with(&json!(["cloth", "cloth-2"]))), 0.2);
    close(gap(&with(&json!(["bob", "line"]))), 0.2);
    close(gap(&with(&json!(["cloth", {"sphere": {"center": [0, 0, -3], "radius": 1}}]))), 0.2);
    let mut moved = with(&json!(["cloth", "line"]));
    let mut displacement = vec![[0.0; 3]; 10];
    displacement[8] = [-0.5, 0.0, 0.0];
    moved["system"]["network"]["initial"] = json!({"displacement": displacement});
    close(gap(&moved), 0.1);
    // Of what the contact does not have, it takes no edge.
    moved["system"]["network"]["contact"][0]["between"] = json!(["cloth", "cloth-2"]);
    close(gap(&moved), 0.2);
}

/// Every shape of a body arrives; normals are unit vectors.
#[test]
fn bodies_arrive() {
    let shape = |body: Value| match one(&json!({"between": ["cloth", body], "gap": 0.01})).other {
        ContactSide::Obstacle(body) => (body.shape, body.motion),
        other => panic!("{other:?}"),
    };
    let plane = json!({"plane": {"point": [0, 0, -1], "normal": [0, 0, 1e200]}});
    assert_eq!(shape(plane), (ObstacleShape::Plane { point: [0.0, 0.0, -1.0], normal: [0.0, 0.0, 1.0] }, None));
    let motion = json!({"table": [[0, 0, 0, 0], [1, 0, 0, 2]]});
    let sphere = json!({"sphere": {"center": [0, 0, -1], "radius": 0.5}, "motion": motion});
    let moved = Series { t: vec![0.0, 1.0], value: vec![[0.0; 3], [0.0, 0.0, 2.0]] };
    assert_eq!(shape(sphere), (ObstacleShape::Sphere { center: [0.0, 0.0, -1.0], radius: 0.5 }, Some(moved)));
    let cylinder = json!({"cylinder": {"from": [0, 0, -2], "to": [1, 0, -2], "radius": 0.5}});
    let right = ObstacleShape::Cylinder { from: [0.0, 0.0, -2.0], to: [1.0, 0.0, -2.0], radius: 0.5 };
    assert_eq!(shape(cylinder).0, right);
    let cuboid = json!({"box": {"min": [0, 0, -2], "max": [1, 1, -1]}});
    assert_eq!(shape(cuboid).0, ObstacleShape::Box { min: [0.0, 0.0, -2.0], max: [1.0, 1.0, -1.0] });
}

/// The corners of a box as an .obj, with triangles that point out, or in.
fn block(low: [f64; 3], high: [f64; 3], inwards: bool, without: usize) -> String {
    let corner = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { high[axis] } else { low[axis] });
    let quads = [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]];
    let mut text: String = (0..8).map(corner).map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    let faces = quads.iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).skip(without);
    for [a, b, c] in faces {
        text += &if inwards { format!("f {a} {c} {b}\n") } else { format!("f {a} {b} {c}\n") };
    }
    text
}

/// Six times the volume of a surface.
fn volume(nodes: &[[f64; 3]], triangles: &[[u32; 3]]) -> f64 {
    let of = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|n| nodes[n as usize]);
        a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    };
    triangles.iter().map(of).sum()
}

/// A closed surface of a file points out, whichever way it was wound; one with a hole is refused with the place.
#[test]
fn surfaces_are_closed_and_point_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let contact = |file: &str| json!([{"between": ["cloth", {"file": file}], "gap": 0.01}]);
    let (low, high) = ([0.2, 0.2, -1.0], [0.8, 0.8, -0.5]);
    for inwards in [false, true] {
        std::fs::write(folder.path().join("block.obj"), block(low, high, inwards, 0)).expect("a file");
        let read = read_at(&scene(&contact("block.obj")), folder.path()).unwrap_or_else(|e| panic!("{e}"));
        let SystemSpec::Network(spec) = read.into_problem().system else { panic!("a network") };
        let ContactSide::Obstacle(body) = &spec.contacts[0].other else { panic!("a body") };
        let ObstacleShape::Surface { nodes, triangles } = &body.shape else { panic!("a surface") };
        assert_eq!((nodes.len(), triangles.len()), (8, 12));
        assert!((volume(nodes, triangles) / 6.0 - 0.18).abs() < 1e-12, "{inwards}");
    }
    std::fs::write(folder.path().join("open.obj"), block(low, high, false, 1)).expect("a file");
    std::fs::write(folder.path().join("line.obj"), "v 0 0 0\nv 1 0 0\nl 1 2\n").expect("a file");
    for (file, words) in [
        ("open.obj", "3 open edges, the first from (0.2, 0.2, -1) to "),
        ("line.obj", "a mesh without triangles"),
        ("none.obj", "cannot be read"),
    ] {
        let list = faults(read_at(&scene(&contact(file)), folder.path()));
        assert!(list.len() == 1 && list[0].pointer.ends_with("/contact/0/between/1/file"), "{list:?}");
        assert!(list[0].to_string().contains(words), "{words}: {}", list[0]);
    }
}

/// Nodes inside of a body at the start are refused, with the first one and its depth; held ones may be there.
#[test]
fn nothing_that_moves_starts_inside_of_a_body() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = block([-0.1, -0.1, -0.5], [1.1, 0.5, 0.25], false, 0);
    std::fs::write(folder.path().join("block.obj"), text).expect("a file");
    let read = |body: &Value, sets: &[(&str, Value)]| {
        let mut case = scene(&json!([{"between": ["cloth", body], "gap": 0.01}]));
        sets.iter().for_each(|(key, value)| case["system"]["network"][*key] = value.clone());
        read_at(&case, folder.path())
    };
    let ball = json!({"sphere": {"center": [1, 0, -0.5], "radius": 0.625}});
    for (body, key, words) in [
        (json!({"plane": {"point": [0, 0, 0.25], "normal": [0, 0, 2]}}), "plane", "node 0 is 0.25 m below the plane"),
        (ball.clone(), "sphere", "node 1 is 0.125 m inside of the sphere at the start"),
        // The half ball beyond the end of the axis.
        (
            json!({"cylinder": {"from": [1, 0, -3], "to": [1, 0, -0.5], "radius": 0.625}}),
            "cylinder",
            "node 1 is 0.125 m inside of the cylinder",
        ),
        (json!({"box": {"min": [0.5, -1, -1], "max": [2, 0.75, 1]}}), "box", "node 1 is 0.5 m inside of the box"),
        (
            json!({"file": "block.obj"}),
            "file",
            "node 0 is 0.1 m inside of the closed surface at the start; so is another",
        ),
    ] {
        let list = faults(read(&body, &[]));
        assert!(list.len() == 1 && list[0].pointer.ends_with(&format!("/contact/0/between/1/{key}")), "{list:?}");
        assert!(list[0].to_string().contains(words), "{words}: {}", list[0]);
    }
    // Touching is not inside; a motion and displacements count; held nodes may be anywhere.
    let accepted = |body: &Value, sets: &[(&str, Value)]| {
        let _ = read(body, sets).unwrap_or_else(|e| panic!("{e}"));
    };
    accepted(&json!({"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}), &[]);
    accepted(&json!({"sphere": {"center": [1, 0, -0.5], "radius": 0.5}}), &[]);
    let mut away = ball.clone();
    away["motion"] = json!({"table": [[0, 0, 0, -1]]});
    accepted(&away, &[]);
    accepted(&ball, &[("initial", json!({"displacement": [0, 0, 0.125]}))]);
    accepted(&ball, &[("supports", json!([{"on": {"ids": [1]}, "fix": "xyz"}]))]);
    let moving = json!([{"on": {"ids": [1]}, "fix": "xyz", "motion": {"table": [[0, 0, 0, 0], [1, 0, 0, 1]]}}]);
    assert_eq!(faults(read(&ball, &[("supports", moving)])).len(), 1);
    // The surface is where it is seen to be: between the square and the triangle above it.
    let above = json!([{"between": ["cloth-2", {"file": "block.obj"}], "gap": 0.01}]);
    let list = faults(read(&json!({"file": "block.obj"}), &[("contact", above)]));
    assert!(list[0].to_string().contains("node 4 is 0.1 m inside"), "{}", list[0]);
}

/// Every fault is told at its place, and nothing that only follows from it.
#[test]
fn faults_are_told_at_their_place() {
    let ball = json!({"sphere": {"center": [0, 0, -5], "radius": 0.5}});
    let plane = |normal: Value| json!({"plane": {"point": [0, 0, -1], "normal": normal}});
    let between = |pair: Value| json!({"between": pair});
    let on = |body: Value| json!({"between": ["cloth", body], "gap": 0.01});
    for (contact, place, words) in [
        (between(json!("selv")), "/between", "did you mean \"self\""),
        (between(json!(["cloth"])), "/between", "exactly 2"),
        (between(json!(["cloht", "all"])), "/between/0", "did you mean \"cloth\""),
        (between(json!(["all", "clothes"])), "/between/1", "known names here: all, bob, cloth"),
        (between(json!(["self", "cloth"])), "/between/0", "\"between\": \"self\""),
        (between(json!([ball, "cloth"])), "/between/0", "write it second: [\"cloth\", {...}]"),
        (between(json!([ball, plane(json!([0, 0, 1]))])), "/between", "two rigid bodies"),
        (between(json!(["bob", "bob"])), "/between", "only 1 node, which cannot touch itself"),
        (between(json!(["bob", ball])), "/gap", "required here"),
        (json!({"between": "self", "gap": 0}), "/gap", "above 0"),
        (json!({"between": "self", "friction": -0.1}), "/friction", "0 or more"),
        (json!({"gap": 0.1}), "/between", "required here"),
        (on(plane(json!([0, 0, 0]))), "/between/1/plane/normal", "not zero"),
        (on(json!({"sphere": {"center": [0, 0, -5], "radius": -1}})), "/between/1/sphere/radius", "above 0"),
        (
            on(json!({"cylinder": {"from": [0, 0, -1], "to": [0, 0, -1], "radius": 0.1}})),
            "/between/1/cylinder/to",
            "another point",
        ),
        (on(json!({"box": {"min": [0, 0, -2], "max": [1, 0, -3]}})), "/between/1/box/max", "it is not in y and z"),
        (on(json!({})), "/between/1", "a body without a shape"),
        (on(json!({"shpere": {"center": [0, 0, -5], "radius": 1}})), "/between/1/shpere", "did you mean \"sphere\""),
        (
            on(json!({"sphere": {"center": [0, 0, -5], "radius": 1}, "file": "a.stl"})),
            "/between/1",
            "a body with sphere and file",
        ),
        (
            on(
                json!({"sphere": {"center": [0, 0, -5], "radius": 1}, "motion": {"table": [[0, 0, 0, 0], [0, 1, 1, 1]]}}),
            ),
            "/between/1/motion/table/1",
            "strictly increasing",
        ),
        (
            on(json!({"sphere": {"center": [0, 0, -5], "radius": 1}, "motion": {"table": []}})),
            "/between/1/motion/table",
            "",
        ),
    ] {
        let list = faults(read_at(&scene(&json!([contact])), &PathBuf::new()));
        let told = list.iter().find(|fault| fault.pointer == format!("/system/network/contact/0{place}"));
        let told = told.unwrap_or_else(|| panic!("{contact}: {list:#?}"));
        assert!(told.to_string().contains(words) && told.place.is_some(), "{contact}: \"{words}\" is not in\n{told}");
        assert_eq!(list.len(), 1, "{contact}: {list:#?}");
    }
}

/// A gauge of contact names a contact that is there; nothing else is measured on one.
#[test]
fn gauges_of_contact_name_one() {
    let two = scene(&json!([{"between": "self", "gap": 0.01}, {"between": ["cloth", "cloth-2"], "gap": 0.01}]));
    let gauge = |case: &Value, on: Value, of: &str| {
        let mut case = case.clone();
        case["output"] = json!({"gauges": [{"name": "g", "on": on, "of": of}]});
        case
    };
    let read = read_at(&gauge(&two, json!({"contact": 1}), "contact"), &PathBuf::new()).expect("it is there");
    assert_eq!(read.problem().output.gauges[0].of, GaugeOf::Contact { contact: 1 });
    let mut none = two.clone();
    none["system"]["network"].as_object_mut().expect("an object").remove("contact");
    let at = "/output/gauges/0/on";
    for (case, place, words) in [
        (gauge(&two, json!({"contact": 2}), "contact"), format!("{at}/contact"), "a number below 2"),
        (gauge(&none, json!({"contact": 0}), "contact"), format!("{at}/contact"), "no section contact"),
        (gauge(&two, json!("all"), "contact"), at.to_owned(), "the number of a contact"),
        (gauge(&two, json!({"contact": 0}), "force"), at.to_owned(), "a contact is for gauges of"),
        (gauge(&two, json!({"contact": 0}), "tension"), at.to_owned(), "a selection of edges"),
    ] {
        let list = faults(read_at(&case, &PathBuf::new()));
        assert!(list.len() == 1 && list[0].pointer == place, "{place}: {list:?}");
        assert!(list[0].to_string().contains(words), "{words}: {}", list[0]);
    }
}
