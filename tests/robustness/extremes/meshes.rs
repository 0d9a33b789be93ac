//! Hostile mesh files: each is read as what it says, or refused with a sentence; and what was read can be used and
//! written.
//!
//! A new file is a line of `files`. What must hold of everything that is read is in `tests/fuzz/oracle/mesh.rs`, where
//! the fuzzers use it too.

use crate::mesh_oracle;
use base64::Engine as _;
use canopy_fem::mesh::read::mesh_from_bytes;
use std::path::Path;

/// What must come of a file.
enum Must {
    /// a mesh of so many nodes, edges and triangles
    Read([usize; 3]),
    /// a sentence with these words
    Refuse(&'static str),
}
use Must::{Read, Refuse};

const SQUARE: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

fn obj(vertices: &str, rest: &str) -> Vec<u8> {
    format!("{vertices}{rest}").into_bytes()
}

/// Version 2.2 with the unit square's nodes 1 to 4, if `nodes` does not say otherwise.
fn msh(nodes: &str, elements: &str) -> Vec<u8> {
    let nodes = if nodes.is_empty() { "4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n" } else { nodes };
    format!("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{nodes}$EndNodes\n$Elements\n{elements}$EndElements\n")
        .into()
}

fn vtk(points: &str, cells: &str) -> Vec<u8> {
    format!("# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {points}\n{cells}\n").into()
}

/// The square as .vtu with arrays given as they stand between the tags.
fn vtu([points, connectivity, offsets, types]: [&str; 4], counts: [u64; 2], format: &str) -> Vec<u8> {
    let array = |kind: &str, name: &str, components: u8, data: &str| {
        format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"{format}\">{data}</DataArray>"
        )
    };
    format!(
        "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\
         <UnstructuredGrid><Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\"><Points>{}</Points><Cells>{}{}{}</Cells>\
         </Piece></UnstructuredGrid></VTKFile>",
        counts[0],
        counts[1],
        array("Float64", "points", 3, points),
        array("Int64", "connectivity", 1, connectivity),
        array("Int64", "offsets", 1, offsets),
        array("UInt8", "types", 1, types)
    )
    .into()
}

/// Base64 of an array with its length before it, `told` bytes more or fewer than there are.
fn packed(bytes: &[u8], told: i64) -> String {
    let mut all = (bytes.len() as i64 + told).to_le_bytes().to_vec();
    all.extend(bytes);
    base64::engine::general_purpose::STANDARD.encode(all)
}

fn packed_vtu(told: i64, cut: usize) -> Vec<u8> {
    let points: Vec<u8> = SQUARE.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
    let whole = |values: &[i64]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let mut points = packed(&points, told);
    points.truncate(points.len() - cut);
    vtu(
        [&points, &packed(&whole(&[0, 1, 2, 0, 2, 3]), 0), &packed(&whole(&[3, 6]), 0), &packed(&[5, 5], 0)],
        [4, 2],
        "binary",
    )
}

/// A binary STL that tells of `told` triangles and holds these.
fn stl(told: u32, triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut out = vec![0; 80];
    out.extend(told.to_le_bytes());
    for corners in triangles {
        [0.0, 0.0, 1.0_f32].iter().chain(corners.iter().flatten()).for_each(|v| out.extend(v.to_le_bytes()));
        out.extend([0, 0]);
    }
    out
}

const V: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
const P: &str = "4 double\n0 0 0 1 0 0 1 1 0 0 1 0";
const FLAT: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]];

fn files() -> Vec<(&'static str, &'static str, Vec<u8>, Must)> {
    let ascii = ["0 0 0 1 0 0 1 1 0 0 1 0", "0 1 2 0 2 3", "3 6", "5 5"];
    let spoilt = |at: usize, with: &'static str| {
        let mut arrays = ascii;
        arrays[at] = with;
        vtu(arrays, [4, 2], "ascii")
    };
    let half_max = "v 0 0 0\nv 8e307 0 0\nv 0 8e307 0\n";
    vec![
        ("an index of 2^32", "a.obj", obj(V, "f 1 2 4294967297\n"), Refuse("no vertex 4294967297; the file has")),
        ("an index of 2^63", "a.obj", obj(V, "f 1 2 9223372036854775808\n"), Refuse("not a vertex number")),
        ("the least index there is", "a.obj", obj(V, "f 1 2 -9223372036854775808\n"), Refuse("no vertex")),
        ("index 0", "a.obj", obj(V, "f 0 1 2\n"), Refuse("no vertex 0")),
        ("an index before the first vertex", "a.obj", obj(V, "f 1 2 -5\n"), Refuse("no vertex -5")),
        ("a face before its vertices", "a.obj", obj("f 1 2 3\n", V), Read([3, 3, 1])),
        (
            "coordinates that are not numbers",
            "a.obj",
            obj("v NaN 0 0\nv 1 0 0\nv 1 1 0\n", "f 1 2 3\n"),
            Refuse("finite"),
        ),
        ("coordinates without end", "a.obj", obj("v inf 0 0\nv 1 0 0\nv 1 1 0\n", "f 1 2 3\n"), Refuse("finite")),
        ("coordinates that overflow", "a.obj", obj("v 1e999 0 0\nv 1 0 0\nv 1 1 0\n", "f 1 2 3\n"), Refuse("finite")),
        (
            "lengths that overflow",
            "a.obj",
            obj("v -1e308 0 0\nv 1e308 0 0\nv 0 1e308 0\n", "f 1 2 3\n"),
            Refuse("degenerate"),
        ),
        ("areas that overflow", "a.obj", obj(half_max, "f 1 2 3\n"), Refuse("degenerate")),
        (
            "areas that vanish",
            "a.obj",
            obj("v 0 0 0\nv 1e-170 0 0\nv 0 1e-170 0\n", "f 1 2 3\n"),
            Refuse("with an area"),
        ),
        ("a line of the smallest length", "a.obj", obj("v 0 0 0\nv 5e-324 0 0\n", "l 1 2\n"), Read([2, 1, 0])),
        ("a line of the greatest length", "a.obj", obj("v -1.7e308 0 0\nv 1.7e308 0 0\n", "l 1 2\n"), Read([2, 1, 0])),
        ("a triangle without area", "a.obj", obj("v 0 0 0\nv 1 0 0\nv 2 0 0\n", "f 1 2 3\n"), Refuse("with an area")),
        ("a triangle on a point", "a.obj", obj("v 1 1 1\nv 1 1 1\nv 1 1 1\n", "f 1 2 3\n"), Refuse("with an area")),
        ("a corner twice", "a.obj", obj(V, "f 1 2 2\n"), Refuse("with an area")),
        ("a line to itself", "a.obj", obj(V, "l 1 1\n"), Refuse("no lines")),
        ("a face twice", "a.obj", obj(V, "f 1 2 3\nf 3 1 2\n"), Read([3, 3, 1])),
        ("a line twice", "a.obj", obj(V, "l 1 2\nl 2 1\n"), Read([2, 1, 0])),
        ("a face of five corners", "a.obj", obj(V, "v 0 2 0\nf 1 2 3 4 5\n"), Read([4, 5, 2])),
        ("a face of two corners", "a.obj", obj(V, "f 1 2\n"), Refuse("with an area")),
        ("vertices alone", "a.obj", obj(V, ""), Refuse("no lines and no triangles")),
        ("nothing", "a.obj", Vec::new(), Refuse("no lines and no triangles")),
        ("bytes that are no text", "a.obj", vec![0xFF; 64], Refuse("no lines and no triangles")),
        ("a node listed twice", "a.msh", msh("2\n1 0 0 0\n1 1 0 0\n", "0\n"), Refuse("listed twice")),
        ("2^64 - 1 nodes told", "a.msh", msh("18446744073709551615\n1 0 0 0\n", "0\n"), Refuse("ends too early")),
        ("2^64 nodes told", "a.msh", msh("18446744073709551616\n", "0\n"), Refuse("not a count")),
        ("fewer nodes than told", "a.msh", msh("9\n1 0 0 0\n2 1 0 0\n", "0\n"), Refuse("ends too early")),
        (
            "more nodes than told",
            "a.msh",
            msh("2\n1 0 0 0\n2 1 0 0\n3 1 1 0\n", "1\n1 1 0 1 3\n"),
            Refuse("more in $Nodes"),
        ),
        (
            "more tags than any file holds",
            "a.msh",
            msh("", "1\n1 2 18446744073709551615 0\n"),
            Refuse("ends too early"),
        ),
        (
            "a node tag of 2^64 - 1",
            "a.msh",
            msh("2\n18446744073709551615 0 0 0\n0 1 0 0\n", "1\n1 1 0 0 18446744073709551615\n"),
            Read([2, 1, 0]),
        ),
        ("mixed cells", "a.msh", msh("", "4\n1 15 0 1\n2 1 0 1 3\n3 2 0 1 2 3\n4 3 0 1 3 4 2\n"), Read([3, 3, 1])),
        ("points, lines and quads", "a.msh", msh("", "3\n1 15 0 1\n2 1 0 1 3\n3 3 0 1 2 3 4\n"), Read([4, 5, 2])),
        ("a tetrahedron among triangles", "a.msh", msh("", "2\n1 2 0 1 2 3\n2 4 0 1 2 3 4\n"), Refuse("type 4")),
        ("coordinates that are words", "a.msh", msh("1\n1 nan x 0\n", "0\n"), Refuse("number")),
        (
            "binary that ends in a number",
            "a.msh",
            b"$MeshFormat\n4.1 1 8\n\x01\0\0\0\n$EndMeshFormat\n$Nodes\n\x01\0\0".to_vec(),
            Refuse("is cut off"),
        ),
        ("an index beyond the points", "a.vtk", vtk(P, "CELLS 1 4\n3 0 1 4\nCELL_TYPES 1\n5"), Refuse("names node 4")),
        ("a negative index", "a.vtk", vtk(P, "CELLS 1 4\n3 0 1 -1\nCELL_TYPES 1\n5"), Refuse("fit together")),
        ("a cell longer than the list", "a.vtk", vtk(P, "CELLS 1 4\n9 0 1 2\nCELL_TYPES 1\n5"), Refuse("fit together")),
        (
            "a billion points told",
            "a.vtk",
            vtk("1000000000 double\n0 0 0", "CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5"),
            Refuse("cut off"),
        ),
        (
            "2^64 - 1 points told",
            "a.vtk",
            vtk("18446744073709551615 double\n0 0 0", "CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5"),
            Refuse(""),
        ),
        (
            "a billion cells told",
            "a.vtk",
            vtk(P, "CELLS 1000000000 4000000000\n3 0 1 2\nCELL_TYPES 1\n5"),
            Refuse("cut off"),
        ),
        (
            "points that are words",
            "a.vtk",
            vtk("3 double\nnan nan nan 0 0 0 1 1 1", "CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5"),
            Refuse("finite"),
        ),
        ("a volume cell", "a.vtk", vtk(P, "CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10"), Refuse("Tetra")),
        ("a cell of an unknown type", "a.vtk", vtk(P, "CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n200"), Refuse("")),
        ("plain text", "a.vtu", vtu(ascii, [4, 2], "ascii"), Read([4, 5, 2])),
        ("counts that tell of more", "a.vtu", vtu(ascii, [9, 7], "ascii"), Refuse("4 of 9 points")),
        ("a coordinate too few", "a.vtu", spoilt(0, "0 0 0 1 0 0 1 1 0 0 1"), Refuse("three coordinates")),
        ("offsets beyond the list", "a.vtu", spoilt(2, "3 600"), Refuse("fit together")),
        ("offsets that go back", "a.vtu", spoilt(2, "6 3"), Refuse("more numbers than it should")),
        ("a type too few", "a.vtu", spoilt(3, "5"), Refuse("2 cells but 1 cell types")),
        ("negative indices", "a.vtu", spoilt(1, "0 1 -2 0 2 3"), Refuse("")),
        ("sound base64", "b.vtu", packed_vtu(0, 0), Read([4, 5, 2])),
        ("base64 cut between bytes", "b.vtu", packed_vtu(0, 4), Refuse("")),
        ("base64 cut within a byte", "b.vtu", packed_vtu(0, 5), Refuse("")),
        ("base64 of fewer bytes than told", "b.vtu", packed_vtu(1 << 40, 0), Refuse("is cut off")),
        ("base64 of a negative length", "b.vtu", packed_vtu(-(1 << 40), 0), Refuse("impossible header")),
        ("base64 of more bytes than told", "b.vtu", packed_vtu(-24, 0), Refuse("3 of 4 points")),
        (
            "an XML bomb",
            "a.vtu",
            b"<!DOCTYPE a [<!ENTITY b \"&c;&c;&c;&c;\"><!ENTITY c \"&b;&b;\">]><VTKFile>&b;</VTKFile>".to_vec(),
            Refuse("VTK"),
        ),
        ("an open tag", "a.vtu", b"<VTKFile type=\"UnstructuredGrid\"".to_vec(), Refuse("is cut off")),
        ("a sound triangle", "a.stl", stl(1, &[FLAT]), Read([3, 3, 1])),
        ("four billion triangles told", "a.stl", stl(u32::MAX, &[FLAT]), Refuse("")),
        ("a triangle cut off", "a.stl", stl(1, &[FLAT])[..100].to_vec(), Refuse("")),
        ("a corner that is no number", "a.stl", stl(1, &[[[f32::NAN; 3], FLAT[1], FLAT[2]]]), Refuse("finite")),
        ("a triangle as small as a float", "a.stl", stl(1, &[FLAT.map(|p| p.map(|c| c * 1e-45))]), Read([3, 3, 1])),
        ("a triangle as large as a float", "a.stl", stl(1, &[FLAT.map(|p| p.map(|c| c * f32::MAX))]), Read([3, 3, 1])),
        ("a flat triangle", "a.stl", stl(1, &[[FLAT[0], FLAT[1], FLAT[1]]]), Refuse("no faces with an area")),
        ("the same triangle twice", "a.stl", stl(2, &[FLAT, FLAT]), Read([3, 3, 1])),
    ]
}

#[test]
fn every_hostile_mesh_file_is_read_or_refused_with_a_sentence() {
    let mut wrong = Vec::new();
    for (what, name, bytes, must) in files() {
        let read = mesh_from_bytes(Path::new(name), &bytes);
        if std::env::var_os("EXTREMES_SHOW").is_some() {
            println!("{what} | {}", read.as_ref().map_or_else(ToString::to_string, |i| i.notes.join("; ")));
        }
        match (must, read) {
            (Read(counts), Ok(i)) if [i.mesh.nodes.len(), i.mesh.edges.len(), i.mesh.triangles.len()] == counts => {}
            (Refuse(words), Err(error)) if error.to_string().contains(words) => {}
            (_, Ok(i)) => wrong.push(format!("{what}: read as {:?}", i.mesh)),
            (_, Err(error)) => wrong.push(format!("{what}: {error}")),
        }
        if let Err(why) = mesh_oracle::judge(&bytes) {
            wrong.push(format!("{what}: {why}"));
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), files().len(), wrong.join("\n"));
}
