//! Meshes that are written: names of groups in every format.

use canopy_fem::mesh::write::write_mesh;
use canopy_fem::mesh::{Group, Groups, Mesh, MeshFile};
use std::collections::BTreeSet;
use std::path::Path;

/// A square of two triangles, a line and a lone node, in groups with these names: a triangle, a line and a node each.
fn with_groups(names: &[String]) -> Mesh {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.5], [0.1, 1.0, 0.0], [0.0, 0.0, -1.0]];
    let edges = vec![[0, 4], [0, 1], [0, 2], [0, 3], [1, 2], [2, 3]];
    let group = |number: usize| match number % 3 {
        0 => Group { triangles: vec![number as u32 % 2], ..Group::default() },
        1 => Group { edges: vec![0], ..Group::default() },
        _ => Group { nodes: vec![number as u32 % 5], ..Group::default() },
    };
    let groups = names.iter().enumerate().map(|(number, name)| (name.clone(), group(number))).collect();
    Mesh { nodes: corners.to_vec(), edges, triangles: vec![[0, 1, 2], [0, 2, 3]], groups, ..Mesh::default() }
}

/// Any name of a group comes back, or is told with the name that stands for it; no two groups become one.
#[test]
fn any_name_of_a_group_is_written() {
    let folder = tempfile::TempDir::new().expect("a folder");
    let hard = [
        "canopy",
        "Canopy",
        "a b",
        "a_b",
        "x",
        "vertex_indices",
        "default",
        "#1",
        "größe",
        "12",
        "say \"so\"",
        "a,b",
        "part.sub",
        "back\\",
        "//",
        "vtkGhostType",
        "nx",
        "-",
        "a\u{a0}b",
        "*ELSET",
    ];
    let letters: Vec<char> = "ab_ \"#.,/*$é0-\\".chars().collect();
    let mut state = 7_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize
    };
    let mut name = |_| {
        let length = 1 + random() % 6;
        (0..length).map(|_| letters[random() % letters.len()]).collect::<String>()
    };
    let some: BTreeSet<String> =
        (0..60).map(&mut name).filter(|name| name.trim() == name && !name.is_empty()).collect();
    for names in [hard.map(str::to_owned).to_vec(), some.into_iter().collect()] {
        let mesh = with_groups(&names);
        for ending in ["vtu", "vtp", "msh", "obj", "ply", "inp", "mdpa"] {
            let path = folder.path().join("names").with_extension(ending);
            let notes = write_mesh(&mesh, &path, true).expect(ending);
            let told = |name: &String| {
                let head = format!("group \"{name}\" is written as \"");
                let note = notes.iter().find_map(|note| note.strip_prefix(head.as_str()));
                note.map_or(name.clone(), |note| note.strip_suffix('"').unwrap_or(note).to_owned())
            };
            let back = MeshFile::plain(path.display().to_string()).read(Path::new("")).expect(ending).mesh;
            let expected: Groups = mesh.groups.iter().map(|(name, group)| (told(name), group.clone())).collect();
            assert_eq!(back.groups, expected, "{ending}: {notes:?}");
            assert_eq!((&back.nodes, &back.triangles), (&mesh.nodes, &mesh.triangles), "{ending}");
        }
    }
}

/// Nastran has numbers in place of names, and glTF no groups of nodes: both are told, and cells come back in parts.
#[test]
fn formats_without_names_tell_what_stands_for_them() {
    let folder = tempfile::TempDir::new().expect("a folder");
    let mesh = with_groups(&["canopy".to_owned(), "line".to_owned(), "held".to_owned()]);
    let path = folder.path().join("a.bdf");
    let told = write_mesh(&mesh, &path, false).expect("written");
    assert_eq!(
        told,
        [
            "group \"canopy\" is written as property 3",
            "group \"held\" is written as set 1",
            "group \"line\" is written as property 1"
        ]
    );
    let back = MeshFile::plain(path.display().to_string()).read(Path::new("")).expect("bdf").mesh;
    assert_eq!((&back.nodes, &back.triangles), (&mesh.nodes, &mesh.triangles));
    assert_eq!(back.groups.get("property 3"), mesh.groups.get("canopy"));
    let path = folder.path().join("a.glb");
    let told = write_mesh(&mesh, &path, false).expect("written");
    assert_eq!(told, [".glb does not hold 1 group of nodes, 1 coordinate in double precision"]);
    let back = MeshFile::plain(path.display().to_string()).read(Path::new("")).expect("glb").mesh;
    assert_eq!((back.nodes.len(), back.triangles.len()), (5, 2));
    let sizes = |name: &str| back.groups.get(name).map(|group| (group.triangles.len(), group.edges.len()));
    assert_eq!((sizes("canopy"), sizes("line")), (Some((1, 0)), Some((0, 1))));
}
