//! Sheets of cloth: those that pass through each other, and those that are not joined where they seem to be.

use serde_json::{Value, json};
use std::path::Path;

use super::program::{Finished, program, program_with, summary};
use super::warnings::{lines, warnings, with};
use crate::common::read_vtu::{Vtu, parse};

/// A held square of 1 m with eight triangles, and an upright piece of 0.7 m by 1 m with two, whose lower edge is 0.05 m
/// above the square and which falls at 1 m/s. From 0.05 s on it passes through: two upright edges and its diagonal
/// through the square, an edge of squares and a diagonal of the square through the piece.
fn falling() -> Value {
    let square = (0..9).map(|k| [0.5 * f64::from(k / 3), 0.5 * f64::from(k % 3), 0.0]);
    let piece = [[0.4, 0.1, 0.05], [0.4, 0.8, 0.05], [0.4, 0.8, 1.05], [0.4, 0.1, 1.05]];
    let nodes: Vec<[f64; 3]> = square.chain(piece).collect();
    let cells = [0, 1, 3, 4].into_iter().flat_map(|k| [[k, k + 3, k + 4], [k, k + 4, k + 1]]);
    let triangles: Vec<[u32; 3]> = cells.chain([[9, 10, 11], [9, 11, 12]]).collect();
    let velocity: Vec<[f64; 3]> = (0..13).map(|k| [0.0, 0.0, if k < 9 { 0.0 } else { -1.0 }]).collect();
    json!({"name": "fall", "system": {"network": {
        "mesh": {"explicit": {"nodes": nodes, "triangles": triangles}}, "mass": {"nodal": 0.05},
        "membranes": [{"on": "all", "thickness": 1e-4, "modulus": 1e6, "poisson": 0.3}],
        "supports": [{"on": {"ids": (0..9).collect::<Vec<_>>()}, "fix": "xyz"}],
        "initial": {"velocity": velocity}}},
        "time": {"end": 0.14, "method": "newmark", "step": 0.01},
        "output": {"frames": {"every": 0.02}},
        "acknowledge": ["no-support"]})
}

fn solved(folder: &Path, case: &Value) -> Finished {
    let ended = program(folder, case, &["solve", "--force"]);
    assert_eq!(ended.status, Some(0), "{}", ended.stderr);
    ended
}

fn frame(folder: &Path, number: usize) -> Vtu {
    parse(&std::fs::read(folder.join(format!("out/fall/frames/fall_{number:06}.vtu"))).expect("a frame"))
}

fn close(found: &Value, right: f64) -> bool {
    found.as_f64().is_some_and(|found| (found - right).abs() < 1e-9)
}

/// Crossings are counted in every frame, told at the end with time, place and depth, and shown on both sheets.
#[test]
fn cloth_that_passes_through_cloth_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let ended = solved(folder.path(), &falling());
    let said = lines(&ended.stderr);
    assert!(said.len() == 1 && said[0].ends_with("[cloth-crossing]"), "{said:?}");
    for words in ["in 5 frames of 8, first at t = 0.06 s", "0.01 m deep", "at most 5 crossings", "0.09 m deep"] {
        assert!(said[0].contains(words), "no \"{words}\" in {}", said[0]);
    }
    let found = &summary(folder.path(), "fall")["crossings"];
    for (key, right) in [("states", 8), ("with_crossings", 5), ("largest", 5)] {
        assert_eq!(found[key], right, "{found}");
    }
    assert!(found["searched"] == "frames" && found["complete"] == true, "{found}");
    assert!(close(&found["largest_time"], 0.06) && close(&found["first"]["t"], 0.06), "{found}");
    // So far below the square is the lower end of the upright edges.
    assert!(close(&found["first"]["depth"], 0.01) && close(&found["deepest"]["depth"], 0.09), "{found}");
    assert!(close(&found["deepest"]["t"], 0.14), "{found}");
    assert!(frame(folder.path(), 2).bytes("crossing").iter().all(|flag| *flag == 0));
    for number in [3, 7] {
        let frame = frame(folder.path(), number);
        let flags = frame.bytes("crossing");
        assert_eq!(flags.len(), frame.cells);
        // Both triangles of the piece; none of the squares beyond x = 0.5; no edge.
        assert_eq!(flags[8..10], [1, 1]);
        assert!(flags[..4].contains(&1) && flags[4..8].iter().chain(&flags[10..]).all(|flag| *flag == 0), "{flags:?}");
    }
}

/// Every step can be searched, by any method, with or without frames; a run in two parts tells the same.
#[test]
fn every_step_can_be_searched() {
    let folder = tempfile::tempdir().expect("a folder");
    for (method, frames) in [("newmark", json!({"every": 0.015})), ("velocity-verlet", Value::Null)] {
        let sets = [("/output/crossings", json!("steps")), ("/output/frames", frames), ("/time/method", json!(method))];
        let case = with(&with(&falling(), &sets), &[("/output/checkpoint", json!({"every": 0.05}))]);
        let ended = solved(folder.path(), &case);
        assert!(ended.stderr.contains("in 9 states of 15, the start and every step"), "{}", ended.stderr);
        let whole = summary(folder.path(), "fall")["crossings"].clone();
        assert!(whole["states"] == 15 && whole["with_crossings"] == 9 && whole["largest"] == 5, "{whole}");
        assert!(close(&whole["first"]["t"], 0.06), "{whole}");
        let first = program(folder.path(), &case, &["solve", "--force", "--end", "0.1"]);
        assert_eq!(first.status, Some(0), "{}", first.stderr);
        assert_eq!(summary(folder.path(), "fall")["crossings"]["with_crossings"], 5);
        let second = program(folder.path(), &case, &["solve", "--resume"]);
        assert_eq!(second.status, Some(0), "{}", second.stderr);
        assert_eq!(summary(folder.path(), "fall")["crossings"], whole, "{method}");
    }
}

/// A run that is to search nothing has no array, no word, and nothing in its summary; a scene whose sheets do not meet
/// has the array, and no word.
#[test]
fn nothing_is_said_where_nothing_is_searched_or_crosses() {
    let folder = tempfile::tempdir().expect("a folder");
    let ended = solved(folder.path(), &with(&falling(), &[("/output/crossings", json!("none"))]));
    assert_eq!(ended.stderr, "");
    assert!(summary(folder.path(), "fall").get("crossings").is_none());
    assert!(frame(folder.path(), 7).names().iter().all(|name| name != "crossing"));
    let ended = solved(folder.path(), &with(&falling(), &[("/time/end", json!(0.04))]));
    assert_eq!(ended.stderr, "");
    assert_eq!(summary(folder.path(), "fall")["crossings"]["with_crossings"], 0);
    assert!(frame(folder.path(), 2).bytes("crossing").iter().all(|flag| *flag == 0));
    let known = json!(["no-support", "cloth-crossing"]);
    assert_eq!(solved(folder.path(), &with(&falling(), &[("/acknowledge", known)])).stderr, "");
}

/// A gauge counts at every step; an edge or a triangle counts if all its nodes are selected.
#[test]
fn a_gauge_counts_crossings() {
    let folder = tempfile::tempdir().expect("a folder");
    let gauge = |name: &str, on: Value| json!({"name": name, "on": on, "of": "crossings"});
    let gauges = json!([
        gauge("all", json!("all")),
        gauge("piece", json!({"ids": [9, 10, 11, 12]})),
        // Its upright edges, without its triangles and its diagonal.
        gauge("edge", json!({"ids": [9, 12]})),
        gauge("node", json!({"ids": [9]})),
    ]);
    solved(folder.path(), &with(&falling(), &[("/output/gauges", gauges)]));
    let summary = summary(folder.path(), "fall");
    let peaks = summary["peaks"].as_array().expect("peaks");
    let found: Vec<(&Value, &Value, &Value)> =
        peaks.iter().map(|p| (&p["name"], &p["quantity"], &p["value"])).collect();
    let name = json!("crossings");
    let right = [("all", 5.0), ("piece", 5.0), ("edge", 1.0), ("node", 0.0)].map(|(n, v)| (json!(n), json!(v)));
    assert_eq!(found, right.iter().map(|(n, v)| (n, &name, v)).collect::<Vec<_>>());
    assert!(close(&peaks[0]["t"], 0.06) && peaks[0]["last"] == 5.0, "{peaks:?}");
    let line = json!([{"name": "x", "on": "lines", "of": "crossings"}]);
    let refused = program(folder.path(), &with(&falling(), &[("/output/gauges", line)]), &["check"]);
    assert!(refused.status == Some(2) && refused.stderr.contains("/output/gauges/0/on"), "{}", refused.stderr);
}

/// The start is looked at before a run, with its displacements; sheets that lie on each other or touch do not cross.
#[test]
fn sheets_that_cross_at_the_start_are_told() {
    let lowered = |by: f64| -> Value {
        let moved: Vec<[f64; 3]> = (0..13).map(|k| [0.0, 0.0, if k < 9 { 0.0 } else { -by }]).collect();
        with(&falling(), &[("/system/network/initial", json!({"displacement": moved}))])
    };
    let (codes, texts) = warnings(&lowered(0.1));
    assert_eq!(codes, ["cloth-crossing"], "{texts}");
    assert!(texts.contains("at the start: 5 crossings, the deepest of the edge of nodes"), "{texts}");
    assert!(texts.contains(" 0.05 m deep"), "{texts}");
    for by in [0.0, 0.05, 1.05] {
        let (codes, texts) = warnings(&lowered(by));
        assert!(codes.is_empty(), "{by}: {texts}");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let checked = program(folder.path(), &lowered(0.1), &["check"]);
    assert!(checked.status == Some(0) && checked.stdout.contains("[cloth-crossing]"), "{}", checked.stdout);
}

/// A triangle above the x axis, and two below it that meet in a node at (1, y).
fn half_split(y: f64) -> ([[f64; 3]; 5], [[u32; 3]; 3]) {
    let nodes = [[0.0; 3], [3.0, 0.0, 0.0], [1.0, y, 0.0], [1.0, -1.0, 0.0], [1.0, 2.0, 0.0]];
    (nodes, [[0, 1, 4], [0, 3, 2], [2, 3, 1]])
}

const HANGS: &str = "node 2 lies on the edge 0-1 of triangle 0 and does not belong to it";

/// A node on the edge of a triangle that it does not belong to is told of a mesh and of cloth made from it.
#[test]
fn a_node_on_an_edge_that_does_not_have_it_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    for (y, hangs) in [(0.0, true), (-0.01, false)] {
        let (nodes, triangles) = half_split(y);
        let case = json!({"name": "cloth", "system": {"network": {
            "mesh": {"explicit": {"nodes": nodes, "triangles": triangles}}, "mass": {"areal_density": 0.1},
            "membranes": [{"on": "all", "thickness": 1e-4, "modulus": 1e8, "poisson": 0.3}],
            "supports": [{"on": {"ids": [0, 1]}, "fix": "xyz"}]}},
            "time": {"end": 0.1, "method": "newmark", "step": 1e-3}});
        let (codes, texts) = warnings(&case);
        assert_eq!(codes, if hangs { vec!["hanging-node"] } else { vec![] }, "{texts}");
        assert_eq!(texts.contains(HANGS), hangs, "{texts}");
        let points = nodes.map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
        let faces = triangles.map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1)).concat();
        std::fs::write(folder.path().join("mesh.obj"), points + &faces).expect("written");
        let seen = program_with(folder.path(), &["mesh", "inspect", "mesh.obj"]);
        assert_eq!(seen.status, Some(0), "{}", seen.stderr);
        assert_eq!(seen.stdout.contains(&format!("note: {HANGS}")), hangs, "{}", seen.stdout);
    }
}
