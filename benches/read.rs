//! Reading of mesh files: a wavy sheet of a million nodes in every format that other programs read too, in binary and
//! in text.
//!
//! ```text
//! cargo bench -p canopy-fem-benches --bench read                                  # a minute
//! cargo bench -p canopy-fem-benches --bench read -- --python python3 --rounds 5   # VTK and Gmsh beside it
//! cargo bench -p canopy-fem-benches --bench read -- --folder shapes               # all files of a folder
//! ```
//! Processor time of all threads, the least of the rounds, in which all readers take turns. "read" is the mesh with its
//! edges, groups and checks; "inspect" is `canopy-fem mesh inspect`, which reads too. Of VTK and Gmsh it is the reading
//! alone (`read.py`).

mod fixture;

use canopy_fem::cli::mesh::{FileArgs, InspectArgs, MeshArgs, MeshCommand, run};
use canopy_fem::mesh::Mesh;
use canopy_fem::mesh::file::{Axes, Diagonals};
use canopy_fem::mesh::read::read_mesh;
use canopy_fem::mesh::rectangle::{RectangleParameters, RectanglePattern};
use canopy_fem::mesh::write::write_mesh;
use canopy_fem::process::cpu_seconds;
use fixture::figure::after;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

const CELLS: usize = 999;

/// Flat along no axis, so that no number is as short as it would be on a grid.
fn sheet() -> Mesh {
    let (width, height, pattern) = (10.0, 10.0, RectanglePattern::Regular);
    let parameters = RectangleParameters { width, height, columns: CELLS, rows: CELLS, pattern };
    let mut mesh = parameters.build().expect("a sheet");
    // In single precision, which is all that some of the formats hold.
    let wave = |[x, y, _]: [f64; 3]| [x, y, (0.7 * x).sin() * (1.1 * y).cos()].map(|x| f64::from(x as f32));
    mesh.nodes.iter_mut().for_each(|p| *p = wave(*p));
    mesh
}

/// Writes the sheet in all formats: by the writers of the program, and as the programs whose format it is do.
fn write_all(folder: &Path) {
    let mut mesh = sheet();
    let file = |name: &str| folder.join(name);
    let put = |name: &str, bytes: Vec<u8>| std::fs::write(file(name), bytes).expect("room on the disk");
    for ending in ["vtu", "msh", "ply", "stl", "obj"] {
        // Edges of triangles as cells of their own would make the file twice as large.
        let edges = std::mem::take(&mut mesh.edges);
        write_mesh(&mesh, &file(&format!("ours.{ending}")), true).expect("a file");
        mesh.edges = edges;
    }
    put("appended.vtu", appended_vtu(&mesh));
    put("binary.vtk", legacy_vtk(&mesh));
    put("text.vtk", legacy_text(&mesh));
    put("binary.msh", binary_msh(&mesh));
    put("binary.ply", binary_ply(&mesh));
}

fn cells<const N: usize>(mesh: &Mesh, number: fn(u32) -> [u8; N]) -> Vec<u8> {
    mesh.triangles.as_flattened().iter().flat_map(|node| number(*node)).collect()
}

fn places(mesh: &Mesh) -> Vec<u8> {
    mesh.nodes.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// As `vtkXMLUnstructuredGridWriter` does with raw appended data.
fn appended_vtu(mesh: &Mesh) -> Vec<u8> {
    let (nodes, count) = (mesh.nodes.len(), mesh.triangles.len());
    let arrays = [
        places(mesh),
        cells(mesh, |node| i64::from(node).to_le_bytes()),
        (1..=count as i64).flat_map(|cell| (3 * cell).to_le_bytes()).collect(),
        vec![5; count],
    ];
    let mut head = format!(
        "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
         <UnstructuredGrid>\n<Piece NumberOfPoints=\"{nodes}\" NumberOfCells=\"{count}\">\n"
    );
    let (mut offset, mut data) = (0, Vec::new());
    for ((section, kind, name, components), bytes) in [
        ("Points", "Float64", "Points", 3),
        ("Cells", "Int64", "connectivity", 1),
        ("", "Int64", "offsets", 1),
        ("/Cells", "UInt8", "types", 1),
    ]
    .into_iter()
    .zip(&arrays)
    {
        if !section.is_empty() && !section.starts_with('/') {
            let _ = writeln!(head, "<{section}>");
        }
        let _ = writeln!(
            head,
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"appended\" \
             offset=\"{offset}\"/>"
        );
        match section {
            "Points" => head.push_str("</Points>\n"),
            "/Cells" => head.push_str("</Cells>\n"),
            _ => {}
        }
        offset += 8 + bytes.len();
        data.extend((bytes.len() as u64).to_le_bytes());
        data.extend(bytes);
    }
    head += "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
    [head.into_bytes(), data, b"\n</AppendedData>\n</VTKFile>\n".to_vec()].concat()
}

/// As `vtkUnstructuredGridWriter` does by default up to VTK 9.0, and meshio.
fn legacy_vtk(mesh: &Mesh) -> Vec<u8> {
    let (nodes, count) = (mesh.nodes.len(), mesh.triangles.len());
    let big = |numbers: &mut dyn Iterator<Item = u32>| numbers.flat_map(u32::to_be_bytes).collect::<Vec<u8>>();
    [
        format!("# vtk DataFile Version 3.0\na sheet\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS {nodes} double\n")
            .into(),
        mesh.nodes.as_flattened().iter().flat_map(|x| x.to_be_bytes()).collect(),
        format!("\nCELLS {count} {}\n", 4 * count).into(),
        big(&mut mesh.triangles.iter().flat_map(|[a, b, c]| [3, *a, *b, *c])),
        format!("\nCELL_TYPES {count}\n").into(),
        big(&mut std::iter::repeat_n(5, count)),
        b"\n".to_vec(),
    ]
    .concat()
}

fn legacy_text(mesh: &Mesh) -> Vec<u8> {
    let (nodes, count) = (mesh.nodes.len(), mesh.triangles.len());
    let mut text =
        format!("# vtk DataFile Version 3.0\na sheet\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {nodes} double\n");
    for [x, y, z] in &mesh.nodes {
        let _ = writeln!(text, "{x} {y} {z}");
    }
    let _ = writeln!(text, "CELLS {count} {}", 4 * count);
    for [a, b, c] in &mesh.triangles {
        let _ = writeln!(text, "3 {a} {b} {c}");
    }
    let _ = writeln!(text, "CELL_TYPES {count}");
    text.push_str(&"5\n".repeat(count));
    text.into_bytes()
}

/// As Gmsh does with `Mesh.Binary`, version 4.1.
fn binary_msh(mesh: &Mesh) -> Vec<u8> {
    let (nodes, count) = (mesh.nodes.len() as u64, mesh.triangles.len() as u64);
    let sizes = |numbers: &[u64]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
    let ints = |numbers: &[i32]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
    let elements = (1..).zip(&mesh.triangles);
    [
        b"$MeshFormat\n4.1 1 8\n\x01\0\0\0\n$EndMeshFormat\n$Nodes\n".to_vec(),
        sizes(&[1, nodes, 1, nodes]),
        ints(&[2, 1, 0]),
        sizes(&[nodes]),
        (1..=nodes).flat_map(u64::to_le_bytes).collect(),
        places(mesh),
        b"\n$EndNodes\n$Elements\n".to_vec(),
        sizes(&[1, count, 1, count]),
        ints(&[2, 1, 2]),
        sizes(&[count]),
        elements
            .flat_map(|(tag, t)| [tag, t[0] + 1, t[1] + 1, t[2] + 1].map(u64::from))
            .flat_map(u64::to_le_bytes)
            .collect(),
        b"\n$EndElements\n".to_vec(),
    ]
    .concat()
}

fn binary_ply(mesh: &Mesh) -> Vec<u8> {
    let (nodes, count) = (mesh.nodes.len(), mesh.triangles.len());
    let xyz = "property float x\nproperty float y\nproperty float z";
    let head = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {nodes}\n{xyz}\nelement face {count}\nproperty list uchar int \
         vertex_indices\nend_header\n"
    );
    let face = |t: &[u32; 3]| {
        let mut bytes = [3; 13];
        for (to, node) in bytes[1..].as_chunks_mut().0.iter_mut().zip(t) {
            *to = node.to_le_bytes();
        }
        bytes
    };
    [
        head.into_bytes(),
        mesh.nodes.as_flattened().iter().flat_map(|x| (*x as f32).to_le_bytes()).collect(),
        mesh.triangles.iter().flat_map(face).collect(),
    ]
    .concat()
}

fn inspect(path: &Path) -> String {
    let mesh = FileArgs {
        input: path.to_owned(),
        with: Vec::new(),
        scale: None,
        axes: Axes::Auto,
        translate: None,
        edge: None,
        merge: None,
        orient: false,
        diagonals: Diagonals::One,
        strict: false,
        sew: None,
    };
    let command = MeshCommand::Inspect(InspectArgs { mesh, json: false });
    run(&MeshArgs { command }).unwrap_or_else(|fault| panic!("{}: {fault}", path.display()))
}

/// Processor time [s] of a call, and what it made.
fn timed<T>(call: impl FnOnce() -> T) -> (f64, T) {
    let clock = || cpu_seconds().expect("a processor clock");
    let start = clock();
    let made = call();
    (clock() - start, made)
}

/// Processor time [s] of VTK's or Gmsh's reader, where there is one.
fn other(python: &str, path: &Path) -> Option<f64> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("read.py");
    let output = Command::new(python).arg(script).arg(path).output().expect("python");
    String::from_utf8_lossy(&output.stdout).trim().parse().ok()
}

fn main() {
    let folder = tempfile::tempdir().expect("a folder");
    let given = after("--folder").map(PathBuf::from);
    let rounds: usize = after("--rounds").map_or(3, |word| word.parse().expect("--rounds wants a number"));
    let python = after("--python");
    let folder = given.as_deref().unwrap_or_else(|| {
        write_all(folder.path());
        folder.path()
    });
    let mut paths: Vec<PathBuf> =
        std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()).collect();
    paths.sort();
    println!(
        "file              MB      nodes    read [s]  [ns/node]  inspect [s]  inspect/read  other [s]  read/other"
    );
    for path in paths {
        let (mut read, mut inspected, mut others, mut nodes) = (f64::INFINITY, f64::INFINITY, f64::INFINITY, 0);
        for _ in 0..rounds {
            let (seconds, imported) = timed(|| read_mesh(&path));
            nodes = imported.unwrap_or_else(|fault| panic!("{fault}")).mesh.nodes.len();
            (read, inspected) = (read.min(seconds), inspected.min(timed(|| inspect(&path)).0));
            others = others.min(python.as_ref().and_then(|python| other(python, &path)).unwrap_or(f64::INFINITY));
        }
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let megabytes = std::fs::metadata(&path).map_or(0.0, |about| about.len() as f64 / 1e6);
        let beside = match others.is_finite() {
            true => format!("{others:>9.3}  {:>10.2}", read / others),
            false => String::new(),
        };
        println!(
            "{name:<14} {megabytes:>5.1}  {nodes:>9}  {read:>10.3}  {:>9.0}  {inspected:>11.3}  {:>12.2}  {beside}",
            1e9 * read / nodes as f64,
            inspected / read
        );
    }
}
