//! Groups of mesh files: what Gmsh and Wavefront call parts of a mesh, through a .vtu file, into a case.

use canopy_fem::mesh::read::{Imported, mesh_from_bytes, read_mesh};
use canopy_fem::mesh::write::{vtu_text, write_mesh};
use canopy_fem::mesh::{Group, Mesh};
use serde_json::json;
use std::path::{Path, PathBuf};

/// A square pyramid of 16 triangles with four lines, as Gmsh 4 writes it.
const PYRAMIDS: [&str; 3] = ["pyramid-2.2.msh", "pyramid-4.1.msh", "pyramid-4.1-binary.msh"];

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn read(name: &str) -> Mesh {
    read_mesh(&data(name)).unwrap_or_else(|error| panic!("{name}: {error}")).mesh
}

/// Numbers of nodes, edges and triangles of each group.
fn counts(mesh: &Mesh) -> Vec<(&str, [usize; 3])> {
    let count = |group: &Group| [group.nodes.len(), group.edges.len(), group.triangles.len()];
    mesh.groups.iter().map(|(name, group)| (name.as_str(), count(group))).collect()
}

/// Names with blanks, a group without a name, a point, a triangle in two groups: the same in every version of the
/// format.
#[test]
fn physical_groups_of_gmsh_are_groups() {
    for name in PYRAMIDS {
        let Imported { mesh, notes, .. } = read_mesh(&data(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        let expected = [
            ("5", [0, 4, 0]),
            ("canopy", [0, 0, 16]),
            ("confluence", [1, 0, 0]),
            ("lines", [0, 4, 0]),
            ("marked panel", [0, 0, 4]),
            ("skirt", [0, 8, 0]),
        ];
        assert_eq!(counts(&mesh), expected, "{name}");
        assert_eq!(mesh.triangles.len(), 16, "{name}");
        assert!(!notes.iter().any(|note| note.contains("repeated")), "{notes:?}");
        let place = |node: u32| mesh.nodes[node as usize];
        assert_eq!(place(mesh.groups["confluence"].nodes[0]), [0.0, 0.0, -2.0], "{name}");
        for [a, b] in mesh.groups["skirt"].edges.iter().map(|&edge| mesh.edges[edge as usize]) {
            assert!(place(a)[2] == 0.0 && place(b)[2] == 0.0, "{name}");
        }
        for corners in mesh.groups["marked panel"].triangles.iter().map(|&t| mesh.triangles[t as usize]) {
            assert!(corners.iter().all(|&node| place(node)[0] >= 0.0 && place(node)[1] >= 0.0), "{name}");
        }
    }
}

/// Objects, groups and materials; several names stand at once, and `g` alone ends them.
#[test]
fn names_of_an_obj_file_are_groups() {
    let mesh = read("pyramid.obj");
    let expected = [
        ("canopy", [0, 0, 3]),
        ("cap", [0, 0, 1]),
        ("confluence", [1, 0, 0]),
        ("edge", [0, 4, 0]),
        ("lines", [0, 4, 0]),
        ("marked", [0, 0, 1]),
        ("rig", [1, 8, 3]),
        ("ripstop nylon", [0, 0, 2]),
        ("skirt", [0, 4, 0]),
    ];
    assert_eq!(counts(&mesh), expected);
    // A line on the side of a triangle is that edge, not another one beside it.
    assert_eq!(mesh.edges.len(), 4 + 4 + 4);
}

/// What was read stays in a .vtu file, bit for bit.
#[test]
fn groups_stay_in_converted_files() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in PYRAMIDS.iter().chain(&["pyramid.obj"]) {
        let mesh = read(name);
        let path = folder.path().join(format!("{name}.vtu"));
        write_mesh(&mesh, &path, false).expect("written");
        assert_eq!(read_mesh(&path).expect("read").mesh, mesh, "{name}");
        assert_eq!(mesh_from_bytes(&path, vtu_text(&mesh).expect("sound").as_bytes()).expect("read").mesh, mesh);
    }
}

/// A damaged table of names or entities is refused with words.
#[test]
fn damaged_tables_of_groups_are_refused() {
    let text = std::fs::read_to_string(data("pyramid-4.1.msh")).expect("a file");
    for (from, to, words) in [
        ("2 1 \"canopy\"", "2 one \"canopy\"", "$PhysicalNames"),
        ("$EndPhysicalNames", "", "$PhysicalNames has no end"),
        ("6 12 4 0\n", "6 12 9999999 0\n", "too early"),
    ] {
        let damaged = text.replacen(from, to, 1);
        assert_ne!(damaged, text);
        let error = mesh_from_bytes(Path::new("a.msh"), damaged.as_bytes()).expect_err(words).to_string();
        assert!(error.contains(words), "{words}: {error}");
    }
}

/// A case that names groups of the file: springs on edges of the cloth, loads on triangles, supports and masses of
/// nodes, a canopy with its skirt and confluence.
#[test]
fn a_case_selects_groups_of_a_file() {
    for name in PYRAMIDS {
        let case = json!({
            "name": "pyramid",
            "system": {"network": {
                "mesh": {"file": data(name)},
                "mass": {"areal_density": 0.05},
                "springs": [
                    {"on": {"group": "skirt"}, "stiffness": 700},
                    {"on": {"group": "lines"}, "stiffness": 500},
                    {"on": {"group": "canopy"}, "stiffness": 100}
                ],
                "supports": [{"on": {"group": "confluence"}, "fix": "xyz"}],
                "loads": [{"on": {"group": "marked panel"}, "pressure": 2}],
                "aero": {"canopy": {"on": {"group": "canopy"}, "table": {"pressure_coefficient": 1.5}}}
            }},
            "time": {"end": 0.01, "method": "velocity-verlet", "step": 1e-3}
        });
        let case = crate::common::run::case_of(&case, &[]);
        let canopy_fem::case::spec::SystemSpec::Network(spec) = &case.problem().system else { panic!("a network") };
        // Rules for groups add up: an edge of the skirt has a spring of its own and one of the cloth.
        assert_eq!(spec.springs.iter().map(|s| s.edges.len()).collect::<Vec<_>>(), [8, 4, 28], "{name}");
        assert_eq!(spec.pressures[0].triangles.len(), 4, "{name}");
        let canopy = &spec.canopies[0];
        assert_eq!((canopy.skirt.len(), canopy.apex.len(), canopy.triangles.len()), (8, 1, 16), "{name}");
        assert_eq!(spec.mesh.nodes[canopy.apex[0] as usize], [0.0, 0.0, 0.5], "{name}");
    }
}
