//! What a mesh of a file or a case shows: told by `mesh inspect`, by `check` and by `solve`; nothing of sound meshes.

use crate::bench::Bench;
use canopy_fem::mesh::look::{canopy_along_y, look, units};
use canopy_fem::mesh::{MeshSource, Topology};
use serde_json::{Value, json};
use std::path::Path;

/// Two panels of 4 x 4 squares, 1 m across, side by side with a gap [m].
fn panels(gap: f64, scale: f64) -> String {
    let at = |k: usize| scale * k as f64 / 4.0;
    let nodes = |from: f64| (0..25).map(move |k| format!("v {} {} 0\n", scale * from + at(k / 5), at(k % 5)));
    let faces = (0..2).flat_map(|panel| (0..16).map(move |k| 25 * panel + 5 * (k / 4) + k % 4 + 1));
    let faces = faces.map(|a| format!("f {a} {} {}\nf {a} {} {}\n", a + 5, a + 6, a + 6, a + 1));
    nodes(0.0).chain(nodes(1.0 + gap)).chain(faces).collect()
}

fn case(mesh: &Value) -> String {
    json!({"name": "look", "system": {"network": {"mesh": mesh, "mass": {"areal_density": 0.05},
        "springs": [{"on": "all", "stiffness": 100}], "supports": [{"on": "outer", "fix": "xyz"}],
        "gravity": [0, 0, -9.81]}}, "time": {"end": 0.002, "method": "newmark", "step": 1e-3}})
    .to_string()
}

/// The warnings of a file in a case, which `check` and `solve` say alike, without those of the reader.
fn told(bench: &Bench, file: &str, mesh: &Value) -> Vec<String> {
    std::fs::write(bench.path("mesh.obj"), file).expect("written");
    std::fs::write(bench.path("look.json"), case(mesh)).expect("written");
    let [checked, solved] = [bench.run(&["check", "look.json"]), bench.run(&["solve", "look.json", "--force"])];
    assert_eq!((checked.code, solved.code), (Some(0), Some(0)), "{}{}", checked.stderr, solved.stderr);
    let lines = |text: &str| -> Vec<String> {
        let lines = text.lines().filter_map(|line| line.strip_prefix("warning: "));
        lines.filter(|line| !line.ends_with("[mesh-file]")).map(str::to_owned).collect()
    };
    let said = lines(&checked.stdout);
    assert_eq!(said, lines(&solved.stderr));
    said
}

/// A gap is told with what joins it, and nothing is told once it is joined.
#[test]
fn a_gap_is_told_by_check_and_solve() {
    let bench = Bench::new();
    for gap in [1e-5, 1e-3, 5e-3] {
        let said = told(&bench, &panels(gap, 1.0), &json!({"file": "mesh.obj"}));
        let [one] = said.as_slice() else { panic!("{said:?}") };
        assert!(one.contains("5 nodes lie at most") && one.ends_with("[seam-gap]"), "{one}");
        let inspected = bench.run(&["mesh", "inspect", "mesh.obj"]).stdout;
        let distance = one.split("--merge ").nth(1).and_then(|rest| rest.split(' ').next()).expect("a distance");
        assert!(inspected.contains(&format!("--merge {distance} ")), "{inspected}");
        let distance: f64 = distance.parse().expect("a number");
        assert_eq!(told(&bench, &panels(gap, 1.0), &json!({"file": "mesh.obj", "merge": distance})), [""; 0]);
    }
    assert_eq!(told(&bench, &panels(0.05, 1.0), &json!({"file": "mesh.obj"})), [""; 0]);
}

/// A canopy-sized mesh in other units is told; a scale ends it, and a comment of the file names its unit.
#[test]
fn units_are_told() {
    let bench = Bench::new();
    for (scale, unit, code) in
        [(4000.0, "0.001", "large-extent"), (157.5, "0.0254", "large-extent"), (0.004, "1000", "small-extent")]
    {
        let said = told(&bench, &panels(0.0, scale), &json!({"file": "mesh.obj", "merge": 0.0}));
        let of_size: Vec<&String> = said.iter().filter(|line| line.ends_with(&format!("[{code}]"))).collect();
        assert!(of_size.len() == 1 && of_size[0].contains(&format!("--scale {unit}")), "{said:?}");
        let factor: f64 = unit.parse().expect("a number");
        assert_eq!(
            told(&bench, &panels(0.0, scale), &json!({"file": "mesh.obj", "merge": 0.0, "scale": factor})),
            [""; 0]
        );
    }
    let commented = format!("# File units = inches\n{}", panels(0.0, 20.0));
    told(&bench, &commented, &json!({"file": "mesh.obj", "merge": 0.0}));
    let checked = bench.run(&["check", "look.json"]).stdout;
    assert!(checked.contains("a comment gives its lengths in inches: --scale 0.0254"), "{checked}");
}

/// `inspect` gives the box, and a line for ten loops at most.
#[test]
fn inspect_counts_loops_beyond_ten() {
    let bench = Bench::new();
    let many: String = (0..13).map(|k| format!("v {k} 0 0\nv {k}.5 0 0\nv {k} 1 -2\n")).collect();
    let faces: String = (0..13).map(|k| format!("f {} {} {}\n", 3 * k + 1, 3 * k + 2, 3 * k + 3)).collect();
    std::fs::write(bench.path("many.obj"), many + &faces).expect("written");
    let shown = bench.run(&["mesh", "inspect", "many.obj"]).stdout;
    assert!(shown.contains("box          x 0 to 12.5 m, y 0 to 1 m, z -2 to 0 m\n"), "{shown}");
    assert_eq!(shown.matches("outer loop ").count(), 10, "{shown}");
    assert!(shown.contains("more loops   3 outer, 0 inner, length "), "{shown}");
    let value: Value =
        serde_json::from_str(&bench.run(&["mesh", "inspect", "many.obj", "--json"]).stdout).expect("JSON");
    assert_eq!(value["box"], json!({"low": [0.0, 0.0, -2.0], "high": [12.5, 1.0, 0.0]}));
    assert_eq!(value["loops"].as_array().map(Vec::len), Some(13));
}

/// The meshes of all shipped cases and of the guide show nothing, whether they are generated or come from files.
#[test]
fn shipped_meshes_show_nothing() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut seen = 0;
    for folder in ["assets/cases", "assets/cases/parachute", "docs/guide/cases"] {
        for entry in std::fs::read_dir(root.join(folder)).expect("a folder") {
            let path = entry.expect("an entry").path();
            let Ok(text) = std::fs::read_to_string(&path) else { continue };
            let value: Value = serde_json::from_str(&text).unwrap_or_default();
            let Ok(source) = serde_json::from_value::<MeshSource>(value["system"]["network"]["mesh"].clone()) else {
                continue;
            };
            let mesh = source.build(&root.join(folder)).expect("a mesh");
            let topology = Topology::new(&mesh).expect("a mesh");
            let found = look(&mesh, &topology, &[]);
            let size = canopy_fem::mesh::box_tree::Bounds::of(&mesh.nodes).extent();
            let path = path.display();
            assert!(found.gaps.warning().is_none() && found.others.is_empty(), "{path}: {found:?}");
            assert!(units(size).is_none() && !canopy_along_y(&mesh, &topology), "{path}: {size}");
            seen += 1;
        }
    }
    assert!(seen > 30, "{seen}");
}
