//! Mesh files: every format is read, what is written comes back, and damaged files do no harm.

use canopy_fem::mesh::Mesh;
use canopy_fem::mesh::annulus::AnnulusParameters;
use canopy_fem::mesh::read::read_mesh;
use canopy_fem::mesh::write::{obj_text, vtu_text, write_mesh};
use canopy_fem::vtk::write::{Array, Cells, Snapshot, Values, VtuWriter};
use canopy_fem::vtk::{Compression, Encoding, Precision, VtuFormat};
use std::path::PathBuf;

/// A folder under the system's temporary folder, removed at the end.
fn scratch() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn write(folder: &tempfile::TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("a written file");
    path
}

const MSH_2: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n10 0 0 0\n20 1 0 0\n30 1 1 0\n40 0 1 0\n99 5 5 5\n\
    $EndNodes\n$Elements\n3\n1 1 2 0 1 30 10\n2 2 2 0 1 10 20 30\n3 2 2 0 1 10 30 40\n$EndElements\n";
const MSH_4: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4 1 4\n2 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n\
    $EndNodes\n$Elements\n2 3 1 3\n1 1 1 1\n1 3 1\n2 1 2 2\n2 1 2 3\n3 1 3 4\n$EndElements\n";
const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nl 3 1\nf 1/1 2/1 3/1\nf -4 3//2 4\n";
const VTK: &str = "# vtk DataFile Version 3.0\nsquare\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n0 0 0 1 0 0 1 1 0 0 1 0\n\
    CELLS 3 11\n2 2 0\n3 0 1 2\n3 0 2 3\nCELL_TYPES 3\n3\n5\n5\n";
const STL: &str = "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nendloop\nendfacet\n\
    facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid s\n";
/// The square as VTK 9 writes it with zlib compression.
const ZLIB_VTU: &str = include_str!("../data/square-zlib.vtu");

/// A compressed array of no blocks, as VTK writes it.
const NO_BLOCKS: &str = "AAAAAACAAAAAAAAA";

/// The unit square as a binary Gmsh 4.1 file.
fn msh_4_binary() -> Vec<u8> {
    fn int(out: &mut Vec<u8>, values: &[i32]) {
        values.iter().for_each(|v| out.extend(v.to_le_bytes()));
    }
    fn size(out: &mut Vec<u8>, values: &[u64]) {
        values.iter().for_each(|v| out.extend(v.to_le_bytes()));
    }
    let mut out = b"$MeshFormat\n4.1 1 8\n".to_vec();
    int(&mut out, &[1]);
    out.extend(b"\n$EndMeshFormat\n$Nodes\n");
    size(&mut out, &[1, 4, 1, 4]);
    int(&mut out, &[2, 1, 0]);
    size(&mut out, &[4, 1, 2, 3, 4]);
    for point in square().nodes {
        point.iter().for_each(|v| out.extend(v.to_le_bytes()));
    }
    out.extend(b"\n$EndNodes\n$Elements\n");
    size(&mut out, &[2, 3, 1, 3]);
    int(&mut out, &[1, 1, 1]);
    size(&mut out, &[1, 1, 3, 1]);
    int(&mut out, &[2, 1, 2]);
    size(&mut out, &[2, 2, 1, 2, 3, 3, 1, 3, 4]);
    out.extend(b"\n$EndElements\n");
    out
}

/// Binary STL whose z is -0 here and there, which is the same place as 0.
fn stl_binary() -> Vec<u8> {
    let mut out = vec![0; 80];
    out.extend(2_u32.to_le_bytes());
    for (zero, corners) in
        [(0.0, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), (-0.0, [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0_f32]])]
    {
        [0.0, 0.0, 1.0_f32].iter().for_each(|v| out.extend(v.to_le_bytes()));
        for [x, y] in corners {
            [x, y, zero].iter().for_each(|v| out.extend(v.to_le_bytes()));
        }
        out.extend([0, 0]);
    }
    out
}

/// The unit square in every format, with the line 2-0 first where the format has lines.
fn samples() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("a.msh", MSH_2.into()),
        ("b.msh", MSH_4.into()),
        ("c.msh", msh_4_binary()),
        ("a.obj", OBJ.into()),
        ("a.vtk", VTK.into()),
        ("a.stl", STL.into()),
        ("b.stl", stl_binary()),
        ("a.vtu", vtu_text(&square()).expect("sound").into()),
        ("b.obj", obj_text(&square()).into()),
        ("b.vtu", ZLIB_VTU.into()),
    ]
}

fn square() -> Mesh {
    Mesh {
        nodes: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
        edges: vec![[2, 0], [0, 1], [0, 3], [1, 2], [2, 3]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        seams: vec![0, 3],
        ..Mesh::default()
    }
}

/// All formats give the same square: nodes, triangles, lines first, unused nodes gone, coincident corners welded.
#[test]
fn all_formats_are_read() {
    let folder = scratch();
    for (name, bytes) in samples() {
        let mesh = read_mesh(&write(&folder, name, &bytes)).expect(name).mesh;
        assert_eq!(mesh.nodes, square().nodes, "{name}");
        assert_eq!(mesh.triangles, square().triangles, "{name}");
        assert_eq!(mesh.edges.len(), 5, "{name}");
        if !["a.stl", "b.stl", "b.obj"].contains(&name) {
            assert_eq!(mesh.edges[0], [2, 0], "{name}");
        }
    }
    let notes = read_mesh(&write(&folder, "a.msh", MSH_2.as_bytes())).expect("read").notes;
    assert!(notes.iter().any(|n| n.starts_with("1 nodes")), "{notes:?}");
}

/// What we write as .vtu comes back bit for bit, seams included; .obj keeps nodes and triangles; files are not
/// overwritten unasked.
#[test]
fn written_meshes_come_back() {
    let folder = scratch();
    let canopy = AnnulusParameters {
        inner_radius: 0.1,
        outer_radius: 1.0,
        nodes: 703,
        boundary_nodes: Some(126),
        seams: Some(12),
        seed: 2,
        grading: None,
    };
    let mesh = canopy.build().expect("a mesh");
    let path = folder.path().join("canopy.vtu");
    write_mesh(&mesh, &path, false).expect("written");
    assert_eq!(read_mesh(&path).expect("read").mesh, mesh);
    let again = write_mesh(&mesh, &path, false);
    assert!(again.is_err_and(|e| e.to_string().contains("--force")), "an existing file must be kept");
    write_mesh(&mesh, &path, true).expect("replaced");
    let path = folder.path().join("canopy.obj");
    write_mesh(&mesh, &path, false).expect("written");
    let back = read_mesh(&path).expect("read").mesh;
    assert_eq!((back.nodes, back.triangles), (mesh.nodes, mesh.triangles));
}

/// The square as a frame of a run, moved by (2, 0, 0).
fn frame_of(format: VtuFormat) -> Vec<u8> {
    let Mesh { nodes, edges, triangles, .. } = square();
    let points: Vec<[f64; 3]> = nodes.iter().map(|[x, y, z]| [x + 2.0, *y, *z]).collect();
    let displacement = vec![[2.0, 0.0, 0.0]; 4];
    let cells = Cells { points: 4, triangles: &triangles, edges: &edges };
    let mut writer = VtuWriter::new(&cells, format).expect("good cells");
    let data = [Array { name: "displacement", values: Values::Vectors(&displacement) }];
    let mut file = Vec::new();
    let picture = Snapshot { time: Some(0.5), points: &points, point_data: &data, cell_data: &[] };
    writer.write(&picture, &mut file).expect("memory");
    file
}

/// A frame of a run is a mesh, in every format that frames have: raw or base64, compressed or not. Cut off anywhere it
/// is refused, or read as the same mesh.
#[test]
fn frames_are_meshes() {
    let folder = scratch();
    let moved: Vec<[f64; 3]> = square().nodes.iter().map(|[x, y, z]| [x + 2.0, *y, *z]).collect();
    for encoding in [Encoding::Raw, Encoding::Base64] {
        for compression in [Compression::None, Compression::Zlib] {
            for precision in [Precision::F64, Precision::F32] {
                let format = VtuFormat { encoding, compression, precision, ..VtuFormat::default() };
                let file = frame_of(format);
                let mesh = read_mesh(&write(&folder, "frame.vtu", &file)).expect("a mesh").mesh;
                assert_eq!((&mesh.nodes, &mesh.triangles), (&moved, &square().triangles), "{format:?}");
                assert_eq!(mesh.edges, square().edges, "{format:?}");
                for length in (0..file.len()).step_by(7) {
                    let read = read_mesh(&write(&folder, "cut.vtu", &file[..length]));
                    assert!(read.is_err() || read.is_ok_and(|read| read.mesh == mesh), "{format:?}, {length} bytes");
                }
            }
        }
    }
}

/// Compressed arrays without any block, as VTK writes those of no numbers, are read.
#[test]
fn empty_compressed_arrays_are_read() {
    let array = "<DataArray type=\"Float64\" Name=\"none\" NumberOfComponents=\"0\" format=\"binary\">";
    let file = ZLIB_VTU.replacen("<CellData>", &format!("<CellData>{array}\n{NO_BLOCKS}\n</DataArray>"), 1);
    assert_ne!(file, ZLIB_VTU);
    assert_eq!(read_mesh(&write(&scratch(), "empty.vtu", file.as_bytes())).expect("read").mesh.nodes, square().nodes);
}

/// Missing files, unknown formats, binary Gmsh 2, solid elements and silly counts are refused with the file's name.
#[test]
fn unreadable_files_are_named() {
    let folder = scratch();
    let tetra = MSH_2.replace("3 2 2 0 1 10 30 40", "3 4 2 0 1 10 20 30 40");
    // Sixteen million blocks of 32768 bytes in no data at all.
    let first = ZLIB_VTU.find("AQAAA").expect("a compressed array");
    let bomb = format!("{}////AACAAAAAAAAA{}", &ZLIB_VTU[..first], &ZLIB_VTU[first + NO_BLOCKS.len()..]);
    let cases = [
        (folder.path().join("none.vtu"), "cannot be read"),
        (write(&folder, "mesh.xyz", b""), "are not read; read are .vtu"),
        (write(&folder, "mesh.fbx", b""), "mesh.glb` writes one"),
        (write(&folder, "b2.msh", MSH_2.replace("2.2 0 8", "2.2 1 8").as_bytes()), "not little-endian"),
        (write(&folder, "solid.msh", tetra.as_bytes()), "type 4"),
        (write(&folder, "bow.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 4 3\n"), "crosses itself"),
        (
            write(&folder, "nine.obj", b"v 0 0 0\nv 1 0 0\nf 1 2 3\nv 1 1 0\nf 1 2 9\n"),
            "line 5: there is no vertex 9; the file has 3",
        ),
        (write(&folder, "huge.msh", MSH_2.replace("\n5\n", "\n99999999999999999\n").as_bytes()), "too early"),
        (write(&folder, "huge.vtk", VTK.replace("POINTS 4", "POINTS 999999999999").as_bytes()), "huge.vtk"),
        (write(&folder, "bomb.vtu", bomb.as_bytes()), "impossible header"),
    ];
    for (path, reason) in cases {
        let text = read_mesh(&path).expect_err("refused").to_string();
        let name = path.file_name().and_then(|n| n.to_str()).expect("a name");
        assert!(text.contains(reason) && text.contains(name), "{text}");
    }
}

/// Truncated files and files with damaged bytes give a valid mesh or an error, never a panic or an endless wait.
#[test]
fn damaged_files_do_no_harm() {
    let folder = scratch();
    let mut state = 0x1234_5678_9abc_def1_u64;
    // xorshift64 (Marsaglia 2003): the same damage on every run.
    let mut next = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state as usize
    };
    let mut refused = 0;
    let mut try_bytes = |name: &str, bytes: &[u8]| match read_mesh(&write(&folder, name, bytes)) {
        Ok(imported) => imported.mesh.check().expect("whatever is read is valid"),
        Err(_) => refused += 1,
    };
    for (name, bytes) in samples() {
        let cuts = bytes.len().min(200);
        for cut in 0..cuts {
            try_bytes(name, &bytes[..cut * bytes.len() / cuts]);
        }
        for _ in 0..400 {
            let mut damaged = bytes.clone();
            for _ in 0..1 + next() % 3 {
                let at = next() % damaged.len();
                damaged[at] = if next() % 2 == 0 { b'0' + (next() % 10) as u8 } else { next() as u8 };
            }
            try_bytes(name, &damaged);
        }
    }
    assert!(refused > 1000, "only {refused} damaged files were refused");
}
