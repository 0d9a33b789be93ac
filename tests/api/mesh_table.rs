//! Mesh files as other programs write them, against numbers known from elsewhere: by hand for the squares, from VTK's
//! and meshio's own readers for the others.

use canopy_fem::mesh::file::{Axes, Diagonals};
use canopy_fem::mesh::read::{Imported, file_from_bytes, formats};
use canopy_fem::mesh::write::write_mesh;
use canopy_fem::mesh::{EdgeKind, MeshFile, Topology};
use std::path::{Path, PathBuf};

/// What a file holds.
#[derive(Debug, PartialEq)]
struct Row {
    nodes: usize,
    edges: usize,
    lines: usize,
    triangles: usize,
    parts: usize,
    /// [m^2] in millionths
    area: i64,
    groups: Vec<String>,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/meshes")
}

fn read(file: &MeshFile) -> Imported {
    file.read(&folder()).unwrap_or_else(|error| panic!("{error}"))
}

fn row(imported: &Imported) -> Row {
    let mesh = &imported.mesh;
    let topology = Topology::new(mesh).expect("a mesh");
    let lines = (0..mesh.edges.len()).filter(|&e| topology.edge_kind(e) == EdgeKind::Line).count();
    let area: f64 = mesh
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|node| nalgebra::Vector3::from(mesh.nodes[node as usize]));
            0.5 * (b - a).cross(&(c - a)).norm()
        })
        .sum();
    let groups = mesh.groups.iter().map(|(name, group)| format!("{name}: {}", group.describe())).collect();
    let (nodes, edges, triangles) = (mesh.nodes.len(), mesh.edges.len(), mesh.triangles.len());
    Row { nodes, edges, lines, triangles, parts: topology.components(), area: (area * 1e6).round() as i64, groups }
}

/// The square of 2 by 2 quads that most files hold, with groups.
fn square(groups: &[&str]) -> Row {
    let groups = groups.iter().map(|group| (*group).to_owned()).collect();
    Row { nodes: 9, edges: 16, lines: 0, triangles: 8, parts: 1, area: 1_000_000, groups }
}

/// The same with two lines to a node below it.
fn hung(groups: &[&str]) -> Row {
    Row { nodes: 10, edges: 18, lines: 2, ..square(groups) }
}

/// A square that Gmsh wrote with the parameters of its nodes.
fn parametric() -> Row {
    Row { nodes: 12, edges: 25, triangles: 14, ..square(&["cloth: 14 triangles", "hem: 2 edges"]) }
}

fn of_format(file: &str, endings: &[&str]) -> bool {
    Path::new(file).extension().is_some_and(|ending| endings.iter().any(|known| ending == *known))
}

/// A format that is read has a row in the guide, and a file with which the fuzzer begins.
#[test]
fn every_format_is_in_the_guide_and_fuzzed() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("docs/guide/src/mesh-files.md")).expect("the page");
    let names = |folder: &str| -> Vec<String> {
        let entries = std::fs::read_dir(root.join(folder)).expect("a folder");
        entries.map(|entry| entry.expect("an entry").file_name().into_string().expect("a name")).collect()
    };
    let seeds = names("tests/fuzz/seeds/mesh");
    for endings in formats() {
        let rows = || page.lines().filter(|line| line.starts_with('|'));
        let told = endings.iter().any(|ending| rows().any(|row| row.contains(&format!("`.{ending}`"))));
        assert!(told, "docs/guide/src/mesh-files.md has no row of .{}", endings[0]);
        let seeded = seeds.iter().any(|file| of_format(file, endings));
        assert!(seeded, "tests/fuzz/seeds/mesh has no .{}", endings[0]);
    }
}

/// Every file as it is.
#[test]
fn files_hold_what_their_programs_wrote() {
    let panel = |nodes, edges, triangles, area| Row { nodes, edges, triangles, area, ..square(&[]) };
    let vtk = ["part 1: 288 triangles", "part 2: 12 edges", "part 3: 72 edges", "skirt: 24 nodes"];
    let gmsh = ["cloth: 8 triangles", "confluence: 1 node", "lines: 2 edges"];
    let two_groups = ["canopy: 1 triangle", "everything: 1 triangle"];
    let property = ["property 1: 8 triangles", "property 5: 1 edge", "property 6: 1 edge"];
    let dyna = ["part 1000005: 1 edge", "part 1000006: 1 edge", "part 2000001: 8 triangles"];
    let inp = ["CANOPY: 8 triangles", "CONF: 1 node", "LINES: 2 edges", "NALL: 10 nodes", "SKIRT: 3 nodes"];
    let gmsh_inp = ["Line5: 1 edge", "Line6: 1 edge", "Surface1: 8 triangles", "cloth: 8 triangles", "lines: 2 edges"];
    let table = [
        ("abaqus-s4-s3-t3d2.inp", hung(&inp)),
        ("gmsh.inp", hung(&gmsh_inp)),
        ("lsdyna.k", square(&["node set 1: 3 nodes", "part 1: 8 triangles"])),
        ("gmsh.key", hung(&dyna)),
        ("nastran-free.bdf", square(&["property 1: 8 triangles"])),
        ("gmsh.bdf", hung(&property)),
        ("msh-22-comments.msh", square(&["1: 8 triangles"])),
        ("msh-22-two-groups.msh", Row { groups: square(&two_groups).groups, ..panel(3, 3, 1, 500_000) }),
        ("gmsh-1-text.msh", hung(&["1: 8 triangles", "2: 2 edges", "3: 1 node"])),
        ("gmsh-2.2-text.msh", hung(&gmsh)),
        ("gmsh-2.2-binary.msh", hung(&gmsh)),
        ("gmsh-2.2-parametric.msh", parametric()),
        ("gmsh-2.2-parametric-binary.msh", parametric()),
        ("gmsh-4-text.msh", hung(&gmsh)),
        ("gmsh-4.1-text.msh", hung(&gmsh)),
        ("gmsh-4.1-binary.msh", hung(&gmsh)),
        ("meshio-22-binary.msh", hung(&["cloth: 8 triangles", "lines: 2 edges"])),
        ("obj-utf8-bom.obj", square(&[])),
        ("obj-concave-quad.obj", panel(4, 5, 2, 1_000_000)),
        ("obj-ngon.obj", panel(6, 9, 4, 2_598_076)),
        ("cloth-8x8-quads.obj", panel(81, 208, 128, 1_000_000)),
        ("off-quads.off", square(&[])),
        ("ply-asc.ply", square(&[])),
        ("meshio-binary.ply", square(&[])),
        ("stl-asc-bom.stl", square(&["canopy: 8 triangles"])),
        ("stl-bin-noisy.stl", square(&[])),
        ("trimesh-binary.stl", square(&[])),
        ("vtk-field-before-points.vtk", square(&[])),
        ("pyvista-plane.vtp", panel(81, 208, 128, 1_000_000)),
        ("trimesh.glb", square(&["geometry_0: 8 triangles"])),
        ("kratos.mdpa", hung(&["cloth: 8 triangles", "lines: 2 edges", "skirt: 3 nodes"])),
    ];
    for endings in formats() {
        let mut shown = table.iter().map(|(file, _)| *file).chain(["canopy-3dface.dxf"]);
        let read = shown.any(|file| of_format(file, endings));
        assert!(read, "no row here for a file of the format .{}", endings[0]);
    }
    for (file, expected) in table {
        let mut found = row(&read(&MeshFile::plain(file)));
        // Some are written in single precision, with noise.
        if (found.area - expected.area).abs() <= 2 {
            found.area = expected.area;
        }
        assert_eq!(found, expected, "{file}");
    }
    for file in ["vtk-default.vtu", "vtk-binary-bigendian-zlib.vtu"] {
        let read = row(&read(&MeshFile::plain(file)));
        assert_eq!((read.nodes, read.triangles, read.lines), (169, 288, 12), "{file}: {read:?}");
        assert_eq!(read.groups, vtk, "{file}");
    }
    let seamed = read(&MeshFile::plain("vtk-seam-field.vtk")).mesh;
    assert_eq!(seamed.seams.len(), 2, "{seamed:?}");
    let mut drawn = row(&read(&MeshFile::plain("canopy-3dface.dxf")));
    drawn.groups.sort();
    assert!(drawn.triangles > 0 && drawn.parts == 1 && !drawn.groups.is_empty(), "{drawn:?}");
}

/// All ways in which VTK writes one grid.
#[test]
fn every_encoding_of_vtk_is_read() {
    let mut count = 0;
    for entry in std::fs::read_dir(folder()).expect("the folder") {
        let name = entry.expect("an entry").file_name().into_string().expect("a name");
        if ["vtk-lz4", "vtk-lzma", "vtk-zlib", "vtk-none", "vtk-legacy"].iter().any(|kind| name.starts_with(kind)) {
            let found = row(&read(&MeshFile::plain(name.as_str())));
            assert_eq!(found, hung(&["part 1: 8 triangles", "part 2: 2 edges"]), "{name}");
            count += 1;
        }
    }
    assert_eq!(count, 12);
}

/// Panels that do not share their nodes, lines with ends of their own, solids of one STL file.
#[test]
fn parts_are_joined() {
    let merged = |name: &str, distance| MeshFile { merge: Some(distance), ..MeshFile::plain(name) };
    let two = read(&MeshFile::plain("gmsh-4.1-two-panels-unmerged.msh"));
    assert_eq!((row(&two).nodes, row(&two).parts), (88, 2));
    let joined = read(&merged("gmsh-4.1-two-panels-unmerged.msh", 1e-6));
    assert_eq!((row(&joined).nodes, row(&joined).parts, row(&joined).area), (82, 1, 2_000_000));
    assert!(joined.repairs.iter().any(|note| note.contains("6 nodes were joined")), "{:?}", joined.repairs);
    let lines = read(&merged("obj-lines-own-vertices.obj", 0.0));
    assert_eq!(row(&lines), Row { nodes: 10, edges: 17, lines: 1, ..square(&[]) });
    let objects = row(&read(&merged("obj-two-objects-sharedcoords.obj", 1e-9)));
    assert_eq!((objects.nodes, objects.parts, objects.area), (15, 1, 2_000_000));
    let gores = row(&read(&MeshFile::plain("gmsh-gores-solid-per-surface.stl")));
    assert_eq!((gores.nodes, gores.triangles, gores.parts), (272, 480, 1));
    assert!((gores.area - 3_010_000).abs() < 500 && gores.groups.len() == 8, "{gores:?}");
}

/// A cell that names a point its own file does not have is refused, although the next file has points enough.
#[test]
fn files_name_their_own_points_only() {
    let scratch = tempfile::TempDir::new().expect("a folder");
    let path = scratch.path().join("beyond.off");
    std::fs::write(&path, "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n").expect("a file");
    let with = vec!["off-quads.off".to_owned()];
    let file = MeshFile { with, ..MeshFile::plain(path.display().to_string()) };
    let error = file.read(&folder()).expect_err("refused").to_string();
    assert!(error.contains("beyond.off") && error.contains("names node 3, but there are 3"), "{error}");
}

/// Millimetres, axes, and a place.
#[test]
fn meshes_are_scaled_turned_and_moved() {
    let plain = MeshFile::plain("obj-zup-mm.obj");
    let file = MeshFile { scale: Some(1e-3), axes: Axes::YUp, translate: [1.0, 2.0, 3.0], ..plain };
    let mesh = read(&file).mesh;
    assert_eq!(row(&Imported { mesh: mesh.clone(), notes: Vec::new(), repairs: Vec::new() }), square(&[]));
    assert_eq!((mesh.nodes[0], mesh.nodes[8]), ([1.0, 2.0, 3.0], [2.0, 2.0, 4.0]));
}

/// Triangles are turned alike; both diagonals of quads are edges, the second ones a group.
#[test]
fn meshes_are_repaired() {
    let file = MeshFile { orient: true, ..MeshFile::plain("obj-mixed-orientation.obj") };
    let turned = read(&file);
    let check = |mesh: &canopy_fem::mesh::Mesh| Topology::new(mesh).expect("a mesh").check_orientation(mesh);
    assert!(check(&turned.mesh).is_ok() && turned.repairs.iter().any(|note| note.contains("were turned")));
    assert!(check(&read(&MeshFile::plain("obj-mixed-orientation.obj")).mesh).is_err());
    let both = MeshFile { diagonals: Diagonals::Both, ..MeshFile::plain("cloth-8x8-quads.obj") };
    let cloth = row(&read(&both));
    assert_eq!((cloth.nodes, cloth.edges, cloth.lines), (81, 272, 64));
    assert_eq!(cloth.groups, ["diagonals: 64 edges"]);
    let concave = MeshFile { diagonals: Diagonals::Both, ..MeshFile::plain("obj-concave-quad.obj") };
    assert_eq!(row(&read(&concave)).edges, 5, "the other diagonal of a concave quad is outside of it");
}

/// Two gores with a common side, one with a window, a ring with an island in it, in millimetres: filled with triangles.
/// The areas are those of the polygons; a circle has 72 chords.
#[test]
fn outlines_of_a_drawing_are_filled() {
    let plain = MeshFile { scale: Some(1e-3), ..MeshFile::plain("gores-outlines.dxf") };
    let lines = read(&plain);
    assert_eq!((row(&lines).triangles, row(&lines).lines), (0, 157));
    assert!(lines.notes.iter().any(|note| note.contains("--edge")), "{:?}", lines.notes);
    let circle = 36.0 * 5.0_f64.to_radians().sin();
    let areas = [0.15 - 0.1 * 0.08, 0.1545, 0.08 * 0.08, circle * (0.25 - 0.01)];
    for edge in [0.05, 0.2] {
        let filled = read(&MeshFile { edge: Some(edge), ..plain.clone() });
        let found = row(&filled);
        assert_eq!((found.lines, found.parts), (0, 3), "the gores share their side, and outlines are no lines");
        assert!((found.area as f64 - 1e6 * areas.iter().sum::<f64>()).abs() <= 1.0, "{found:?}");
        let topology = Topology::new(&filled.mesh).expect("a mesh");
        assert_eq!((topology.check_manifold(), topology.check_orientation(&filled.mesh)), (Ok(()), Ok(())));
        let mut loops: Vec<bool> = topology.loops().iter().map(|around| around.outer).collect();
        loops.sort_unstable();
        assert_eq!(loops, [false, false, true, true, true], "a window and a vent");
        for (name, area) in ["gore 1", "gore 2", "island", "vent"].iter().zip(areas) {
            let of = |t: &u32| {
                let [a, b, c] = filled.mesh.triangles[*t as usize]
                    .map(|node| nalgebra::Vector3::from(filled.mesh.nodes[node as usize]));
                0.5 * (b - a).cross(&(c - a)).z
            };
            let sum: f64 = filled.mesh.groups[*name].triangles.iter().map(of).sum();
            assert!((sum - area).abs() < 1e-9, "{name} has {sum} m^2, not {area}, with normals up");
        }
        let quality = canopy_fem::mesh::Quality::with_topology(&filled.mesh, &topology);
        assert!(quality.mean_edge < 1.1 * edge && quality.max_edge < 2.0 * edge, "{quality:?}");
        // Corners of the outlines are nodes.
        for corner in [[0.0, 0.0], [1.0, -0.15], [0.94, 0.45], [0.7, 0.04], [3.04, -0.04]] {
            let near = |node: &[f64; 3]| (node[0] - corner[0]).hypot(node[1] - corner[1]) < 1e-4;
            assert!(filled.mesh.nodes.iter().any(near), "{corner:?}");
        }
    }
    let fine = MeshFile { edge: Some(1e-6), ..plain }.read(&folder()).expect_err("refused").to_string();
    assert!(fine.contains("2e6 are made"), "{fine}");
}

/// A drawing whose outlines cannot be filled: refused with the place.
#[test]
fn outlines_that_cross_are_refused() {
    let scratch = tempfile::TempDir::new().expect("a folder");
    let outline = |corners: &[[f64; 2]]| {
        let points: String = corners.iter().map(|[x, y]| format!("10\n{x}\n20\n{y}\n")).collect();
        format!("0\nLWPOLYLINE\n8\nsail\n70\n1\n{points}")
    };
    let bow = outline(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 2.0]]);
    let square = outline(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    let touching = outline(&[[0.1, 0.1], [0.9, 0.1], [0.5, 0.9], [0.0, 1.0]]);
    let pinched = outline(&[[0.0, 0.0], [1.0, 0.0], [0.5, 0.5], [1.0, 1.0], [0.0, 1.0], [0.5, 0.5]]);
    let twice = square.clone() + &square;
    for (name, entities, expected) in [
        ("bow", bow, Err("crosses or touches itself")),
        ("pinched", pinched, Err("crosses or touches itself")),
        ("touching", square + &touching, Err("touches itself or one of its holes")),
        ("twice", twice, Ok(1)),
    ] {
        let path = scratch.path().join(name).with_extension("dxf");
        std::fs::write(&path, format!("0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n0\nEOF\n")).expect("a file");
        let file = MeshFile { edge: Some(0.3), ..MeshFile::plain(path.display().to_string()) };
        match (file.read(Path::new("")), expected) {
            (Ok(read), Ok(parts)) => assert_eq!(row(&read).parts, parts, "{name}"),
            (Err(error), Err(words)) => assert!(error.to_string().contains(words), "{name}: {error}"),
            (found, _) => panic!("{name}: {found:?}"),
        }
    }
}

/// A .gltf whose data lie beside it, and what is said if they do not, or lie elsewhere.
#[test]
fn data_beside_a_file_are_read() {
    let scratch = tempfile::TempDir::new().expect("a folder");
    let mut data: Vec<u8> = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0_f32]]
        .as_flattened()
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    data.extend([0_u16, 1, 2].iter().flat_map(|n| n.to_le_bytes()));
    std::fs::write(scratch.path().join("my sail.bin"), data).expect("a file");
    let read = |uri: &str| {
        let file = serde_json::json!({
            "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
            "buffers": [{"byteLength": 42, "uri": uri}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 6}],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
                {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}
            ]
        });
        std::fs::write(scratch.path().join("sail.gltf"), file.to_string()).expect("a file");
        MeshFile::plain("sail.gltf").read(scratch.path())
    };
    assert_eq!(row(&read("my%20sail.bin").expect("read")).area, 500_000);
    for (uri, words) in [
        ("sail.bin", "cannot be read"),
        ("../my%20sail.bin", "save it as .glb"),
        ("http://sails/my%20sail.bin", "save it as .glb"),
    ] {
        let error = read(uri).expect_err("refused").to_string();
        assert!(error.contains(words) && error.contains("sail.bin"), "{error}");
    }
}

/// Values out of range are refused where they stand in a case.
#[test]
fn bad_options_are_named() {
    for (file, key) in [
        (MeshFile { scale: Some(0.0), ..MeshFile::plain("ply-asc.ply") }, "/scale"),
        (MeshFile { edge: Some(0.0), ..MeshFile::plain("ply-asc.ply") }, "/edge"),
        (MeshFile { merge: Some(-1.0), ..MeshFile::plain("ply-asc.ply") }, "/merge"),
        (MeshFile { translate: [f64::NAN, 0.0, 0.0], ..MeshFile::plain("ply-asc.ply") }, "/translate"),
    ] {
        let error = file.read(&folder()).expect_err("refused").to_string();
        assert!(error.contains(key), "{error}");
    }
}

/// What is written is read back with its groups; what a format does not hold is said.
#[test]
fn written_files_hold_groups() {
    let folder = tempfile::TempDir::new().expect("a folder");
    let mesh = read(&MeshFile::plain("abaqus-s4-s3-t3d2.inp")).mesh;
    for ending in ["vtu", "vtp", "msh", "obj", "ply", "inp", "mdpa"] {
        let path = folder.path().join("cloth").with_extension(ending);
        assert_eq!(write_mesh(&mesh, &path, false), Ok(Vec::new()), "{ending}");
        let back = MeshFile::plain(path.display().to_string()).read(Path::new("")).expect(ending).mesh;
        assert_eq!(
            (&back.nodes, &back.triangles, &back.groups),
            (&mesh.nodes, &mesh.triangles, &mesh.groups),
            "{ending}"
        );
        assert!(write_mesh(&mesh, &path, false).is_err(), "an existing file is kept");
    }
    let path = folder.path().join("cloth.stl");
    let lost = write_mesh(&mesh, &path, false).expect("written");
    assert_eq!(lost, [".stl does not hold 2 lines, 5 groups"]);
    let back = MeshFile::plain(path.display().to_string()).read(Path::new("")).expect("stl").mesh;
    assert_eq!((back.nodes.len(), back.triangles.len()), (9, 8));
}

/// `mesh inspect` names what to do.
#[test]
fn repairs_are_suggested() {
    for (file, option) in [
        ("gmsh-4.1-two-panels-unmerged.msh", "--merge"),
        ("obj-mixed-orientation.obj", "--orient"),
        ("obj-zup-mm.obj", "--scale 0.001"),
    ] {
        let program = assert_cmd::cargo::cargo_bin!("canopy-fem");
        let shown = std::process::Command::new(program).args(["mesh", "inspect"]).arg(folder().join(file)).output();
        let text = String::from_utf8(shown.expect("it runs").stdout).expect("text");
        assert!(text.lines().any(|line| line.starts_with("note: ") && line.contains(option)), "{file}: {text}");
        assert!(text.matches("turn opposite ways").count() <= 1, "{file} is told twice: {text}");
    }
}

/// Every file cut off and with damaged bytes: refused with a sentence, or a mesh that passes its check.
#[test]
fn damage_does_no_harm() {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    // xorshift64 (Marsaglia 2003): the same damage on every run.
    let mut next = move |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below as u64) as usize
    };
    let wanted = MeshFile { edge: Some(100.0), ..MeshFile::plain("") };
    for entry in std::fs::read_dir(folder()).expect("the folder") {
        let path = entry.expect("an entry").path();
        let whole = std::fs::read(&path).expect("a file");
        if whole.len() > 10_000 {
            continue;
        }
        for trial in 0..60 {
            let mut bytes = whole.clone();
            if trial % 3 == 0 {
                bytes.truncate(next(whole.len()));
            } else {
                for _ in 0..1 + trial % 4 {
                    let at = next(bytes.len());
                    // A digit mostly makes another number, and other bytes another word.
                    bytes[at] = if trial % 2 == 0 { b'0' + next(10) as u8 } else { next(256) as u8 };
                }
            }
            match file_from_bytes(&wanted, &path, &bytes) {
                Ok(read) => assert_eq!(read.mesh.check(), Ok(()), "{}", path.display()),
                Err(error) => assert!(error.to_string().split_whitespace().count() > 3, "{error}"),
            }
        }
    }
}
