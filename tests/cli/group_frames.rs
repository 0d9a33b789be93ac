//! Frames and summary of a scene with groups: parts by number and name, places on the mesh, the pressure of the air.

use crate::bench::Bench;
use crate::common::read_vtu::{Vtu, parse};
use canopy_fem::mesh::read::read_mesh;
use nalgebra::Vector3;
use serde_json::{Value, json};

/// A small parachute that falls at 6 m/s, with pressure on its canopy.
pub(super) fn parachute() -> Value {
    json!({
        "name": "small",
        "system": {"network": {
            "mesh": {"parachute": {
                "type": "flat-circular", "nominal_diameter": 2.0, "gores": 8, "vent_diameter": 0.2,
                "radial_segments": 3, "lines": {"length": 2.0, "segments": 2}, "start": "inflated"
            }},
            "mass": {"areal_density": 0.05, "points": [{"on": {"group": "payload"}, "mass": 5.0}]},
            "springs": [{"on": "all", "axial_rigidity": 1e3, "linear_density": 0.002, "slack": "tension-only"}],
            "gravity": [0, 0, -9.81],
            "aero": {"canopy": {
                "on": {"group": "canopy"}, "table": {"pressure_coefficient": [[0, 1.2], [1, 2.0]]}
            }},
            "initial": {"velocity": [0, 0, -6]}
        }},
        "time": {"end": 0.02, "method": "velocity-verlet", "step": 2e-4}
    })
}

/// Runs a case with some keys replaced; the folder, the last frame and the summary.
fn solved(case: &Value, sets: &[&str]) -> (Bench, Vtu, Value) {
    let bench = Bench::new();
    std::fs::write(bench.path("case.json"), case.to_string()).expect("written");
    let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", *set]).collect();
    let ended = bench.run(&[&["solve", "case.json", "--out", "out"], sets.as_slice()].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let name = case["name"].as_str().expect("a name");
    let frame = parse(&std::fs::read(bench.path(&format!("out/frames/{name}_000001.vtu"))).expect("a frame"));
    let summary = std::fs::read(bench.path("out/summary.json")).expect("a summary");
    let summary = serde_json::from_slice(&summary).expect("JSON");
    (bench, frame, summary)
}

/// [m] current places of the points
fn points(frame: &Vtu) -> Vec<Vector3<f64>> {
    frame.floats("Points").as_chunks().0.iter().map(|p: &[f64; 3]| Vector3::from(*p)).collect()
}

/// [N] the force of the pressure in a frame, by the triangles of its mesh
fn force(frame: &Vtu, triangles: &[[u32; 3]]) -> Vector3<f64> {
    let (x, pressure) = (points(frame), frame.floats("pressure"));
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|node| x[node as usize]);
        0.5 * (b - a).cross(&(c - a))
    };
    triangles.iter().zip(pressure).map(|(t, p)| p * area(t)).sum()
}

/// A frame is the mesh at its time: read back, it has the groups of the case, and `reference_position` has the mesh.
#[test]
fn a_frame_keeps_groups_and_places() {
    let (bench, frame, summary) = solved(&parachute(), &[]);
    let made = bench.run(&[
        "mesh",
        "parachute",
        "--type",
        "flat-circular",
        "--nominal-diameter",
        "2",
        "--gores",
        "8",
        "--vent-diameter",
        "0.2",
        "--radial-segments",
        "3",
        "--lines",
        "2",
        "--line-segments",
        "2",
        "--output",
        "mesh.vtu",
    ]);
    assert_eq!(made.code, Some(0), "{}", made.stderr);
    let mesh = read_mesh(&bench.path("mesh.vtu")).expect("a mesh").mesh;
    let shown = read_mesh(&bench.path("out/frames/small_000001.vtu")).expect("a mesh").mesh;
    assert_eq!((&shown.groups, &shown.edges, &shown.triangles), (&mesh.groups, &mesh.edges, &mesh.triangles));
    let reference = frame.floats("reference_position");
    assert_eq!(reference.as_chunks().0, mesh.nodes.as_slice());
    let displacement = frame.floats("displacement");
    for (i, x) in points(&frame).iter().enumerate() {
        for c in 0..3 {
            assert!((x[c] - reference[3 * i + c] - displacement[3 * i + c]).abs() < 1e-15);
        }
    }
    assert_eq!(frame.integers("node group payload").len(), 1);
    // Cells that ParaView colours apart: triangles, cloth between tapes, lines.
    let kinds: std::collections::BTreeSet<i32> = (0..frame.cells).map(|cell| number(&frame, cell)).collect();
    assert!(kinds.len() >= 6 && !kinds.contains(&0), "{kinds:?}");
    // The summary: counts, rest lengths, areas and masses.
    let groups = &summary["groups"];
    assert_eq!((&groups["canopy"]["triangles"], &groups["lines"]["edges"]), (&json!(8 * 6), &json!(16)));
    let near = |value: &Value, expected: f64| {
        let value = value.as_f64().expect("a number");
        assert!((value / expected - 1.0).abs() < 1e-12, "{value} instead of {expected}");
    };
    near(&groups["lines"]["rest_length"], 16.0);
    let vent = 4.0 * 0.1_f64.powi(2) * (0.25 * std::f64::consts::PI).sin();
    near(&groups["canopy"]["area"], std::f64::consts::PI - vent);
    // Half of each lowest line segment, 1 m long, and the point mass.
    near(&groups["payload"]["mass"], 5.0 + 8.0 * 0.5 * 0.002);
    let keys = ["nodes", "edges", "triangles", "rest_length", "area", "mass"];
    assert!(groups.as_object().expect("groups").values().all(|g| keys.iter().all(|key| !g[*key].is_null())));
}

/// The number of the groups of a cell.
fn number(frame: &Vtu, cell: usize) -> i32 {
    let bytes = frame.bytes("group").as_chunks().0[cell];
    i32::from_le_bytes(bytes)
}

/// The pressures on the triangles have the force that the gauge of the canopy reports, also with triangles that turn
/// inwards, where they are negative.
#[test]
fn pressures_add_up_to_the_drag() {
    let (bench, frame, _) = solved(&parachute(), &[]);
    let mesh = read_mesh(&bench.path("out/frames/small_000001.vtu")).expect("a mesh").mesh;
    let rows = std::fs::read_to_string(bench.path("out/gauges.csv")).expect("gauges");
    let last = rows.lines().rfind(|row| row.contains(",drag,")).expect("a row of the drag");
    let drag: f64 = last.split(',').next_back().expect("a value").parse().expect("a number");
    let upwards = force(&frame, &mesh.triangles);
    assert!(drag > 1.0 && (upwards.z / drag - 1.0).abs() < 1e-9, "{upwards:?} and {drag}");
    // The same mesh with all triangles turned.
    let turned: Vec<[u32; 3]> = mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let mut case = parachute();
    let network = case.pointer_mut("/system/network").expect("a network");
    let made = bench.run(&[
        "mesh",
        "parachute",
        "--type",
        "flat-circular",
        "--nominal-diameter",
        "2",
        "--gores",
        "8",
        "--vent-diameter",
        "0.2",
        "--radial-segments",
        "3",
        "--lines",
        "2",
        "--line-segments",
        "2",
        "--start",
        "inflated",
        "--output",
        "mesh.vtu",
    ]);
    assert_eq!(made.code, Some(0), "{}", made.stderr);
    let whole = read_mesh(&bench.path("mesh.vtu")).expect("a mesh").mesh;
    let start = canopy_fem::mesh::Mesh { triangles: turned.clone(), ..whole };
    let path = bench.path("turned.vtu");
    canopy_fem::mesh::write::write_mesh(&start, &path, false).expect("written");
    network["mesh"] = json!({"file": path});
    let (_, other, _) = solved(&case, &[]);
    let of = |frame: &Vtu| frame.floats("pressure")[..turned.len()].to_vec();
    assert!(of(&frame).iter().all(|p| *p > 0.0) && of(&other).iter().all(|p| *p < 0.0));
    let back = force(&other, &turned);
    assert!((back - upwards).norm() < 1e-9 * drag, "{back:?} and {upwards:?}");
}

/// A held square in the wind, with the law dp = cp rho v^2/2; without groups its frames have only what they had.
#[test]
fn a_scene_without_groups_has_pressure_on_request() {
    let case = json!({
        "name": "held",
        "system": {"network": {
            "mesh": {"explicit": {
                "nodes": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]],
                "springs": [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2]], "triangles": [[0, 1, 2], [0, 2, 3]]
            }},
            "mass": {"nodal": 1.0},
            "springs": [{"on": "all", "stiffness": 100}],
            "supports": [{"on": "all", "fix": "xz"}],
            "aero": {"wind": [3, 0, 8], "law": {"pressure_coefficient": {"cp": 1.2, "air_density": 1.25}}}
        }},
        "time": {"end": 0.01, "method": "velocity-verlet", "step": 1e-3}
    });
    let (_, plain, summary) = solved(&case, &[]);
    let has = |frame: &Vtu, name: &str| frame.names().iter().any(|other| other == name);
    assert!(["group", "reference_position", "pressure"].iter().all(|name| !has(&plain, name)), "{:?}", plain.names());
    assert!(summary.get("groups").is_none());
    let (_, asked, _) = solved(&case, &[r#"output.fields=["pressure"]"#]);
    let expected = 0.5 * 1.2 * 1.25 * 64.0;
    let pressure = asked.floats("pressure");
    assert!(pressure[..2].iter().all(|p| (p / expected - 1.0).abs() < 1e-14), "{pressure:?}");
    assert_eq!((pressure.len(), &pressure[2..]), (7, &[0.0; 5][..]));
    // The same scene with a group has it unasked.
    let grouped = r#"system.network.mesh.explicit.groups={"sheet": {"triangles": [0, 1]}}"#;
    let (_, grouped, summary) = solved(&case, &[grouped]);
    assert_eq!(grouped.floats("pressure"), pressure);
    assert_eq!((number(&grouped, 0), number(&grouped, 2)), (1, 0));
    assert_eq!(summary["groups"]["sheet"]["area"], json!(1.0));
}

/// Sides of triangles are cells of every frame, but VTK does not draw them unless the case asks for it; suspension
/// lines are always drawn.
#[test]
fn sides_of_triangles_are_not_drawn_over_them() {
    const HIDDEN: u8 = 32;
    let shown = |sets: &[&str]| {
        let (bench, frame, _) = solved(&parachute(), sets);
        let mesh = read_mesh(&bench.path("out/frames/small_000001.vtu")).expect("a mesh").mesh;
        let has = frame.names().iter().any(|name| name == "vtkGhostType");
        let hidden = has.then(|| frame.bytes("vtkGhostType"));
        (mesh, frame.bytes("kind").to_vec(), hidden.map(<[u8]>::to_vec))
    };
    let (mesh, kinds, hidden) = shown(&[]);
    let sides: std::collections::BTreeSet<[u32; 2]> = mesh
        .triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    let of_edge = |&[a, b]: &[u32; 2]| if sides.contains(&[a.min(b), a.max(b)]) { 1 } else { 2 };
    let expected: Vec<u8> = mesh.triangles.iter().map(|_| 0).chain(mesh.edges.iter().map(of_edge)).collect();
    assert_eq!(kinds, expected);
    let lines = &mesh.groups["lines"].edges;
    assert!(!lines.is_empty() && lines.iter().all(|edge| kinds[mesh.triangles.len() + *edge as usize] == 2));
    let flags: Vec<u8> = kinds.iter().map(|kind| if *kind == 1 { HIDDEN } else { 0 }).collect();
    assert_eq!(hidden.as_ref(), Some(&flags));
    let (_, same, drawn) = shown(&["output.edges=true"]);
    assert_eq!((same, drawn), (kinds, None));
}
