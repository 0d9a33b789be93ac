//! Closed surfaces from mesh files.

use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::format_number::{counted, figures};
use crate::mesh::components::components;
use crate::mesh::{Mesh, MeshFile, Topology};
use crate::model::spec::ObstacleShape;
use crate::warning::WarningCode;
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::path::Path;

/// The surface of a body: closed, with outward normals.
pub(super) fn surface(at: &Pointer, file: &str, base: &Path, faults: &mut Faults<'_>) -> Option<ObstacleShape> {
    if !faults.readable(at) {
        return None;
    }
    let wanted = MeshFile { orient: true, merge: Some(0.0), ..MeshFile::plain(file) };
    let read = wanted.read(base).and_then(|found| Topology::new(&found.mesh).map(|topology| (found, topology)));
    let (found, topology) = match read {
        Ok(read) => read,
        Err(error) => {
            faults.add_hint(at, "a mesh file that can be read", error.to_string());
            return None;
        }
    };
    let mut mesh = found.mesh;
    if let Some((value, hint)) = not_closed(&mesh, &topology) {
        faults.add_value(at, format!("{file}: {value}"), "a closed surface of triangles", Some(hint));
        return None;
    }
    for note in &found.notes {
        faults.warn(WarningCode::MeshFile, format!("{at}: {note}"));
    }
    for (x, u) in mesh.nodes.iter_mut().zip(&mesh.displacement) {
        *x = std::array::from_fn(|k| x[k] + u[k]);
    }
    turn_outwards(&mut mesh);
    Some(ObstacleShape::Surface { nodes: mesh.nodes, triangles: mesh.triangles })
}

/// What is wrong with a mesh that is no closed surface, and advice.
fn not_closed(mesh: &Mesh, topology: &Topology) -> Option<(String, String)> {
    if mesh.triangles.is_empty() {
        return Some(("a mesh without triangles".to_owned(), "the body is what its triangles enclose".to_owned()));
    }
    let places = |[a, b]: [u32; 2]| {
        let place = |node: u32| {
            let x = mesh.nodes.get(node as usize).copied().unwrap_or([f64::NAN; 3]);
            format!("({})", x.map(|x| figures(x, 4)).join(", "))
        };
        format!("from {} to {}", place(a), place(b))
    };
    let mut open = topology.boundary_edges().map(|(edge, _)| edge);
    if let Some(first) = open.next() {
        let count = counted(1 + open.count() as u64, "open edge", "open edges");
        let hint = "every edge of a closed surface has two triangles: close the holes in the program that wrote it";
        return Some((format!("{count}, the first {}", places(first)), hint.to_owned()));
    }
    if let Some((edge, triangles)) = topology.branching_edges().next() {
        let value = format!("{} triangles at the edge {}", triangles.len(), places(edge));
        return Some((value, "every edge of a closed surface has two triangles: leave inner walls out".to_owned()));
    }
    let twisted = topology.check_orientation(mesh).err()?;
    Some(("a surface that has no inside".to_owned(), twisted.to_string()))
}

/// Turns every part whose normals point inwards, by the sign of its volume.
fn turn_outwards(mesh: &mut Mesh) {
    let sides = mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c]]);
    let part = components(mesh.nodes.len(), sides);
    let at = |node: u32| Vector3::from(mesh.nodes[node as usize]);
    let mut volumes: BTreeMap<u32, f64> = BTreeMap::new();
    for &[a, b, c] in &mesh.triangles {
        let part = part[a as usize];
        // From a node of the part, so that a body far from the origin keeps its digits.
        let origin = at(part);
        let [a, b, c] = [a, b, c].map(|node| at(node) - origin);
        *volumes.entry(part).or_default() += a.dot(&b.cross(&c));
    }
    for triangle in &mut mesh.triangles {
        if volumes.get(&part[triangle[0] as usize]).is_some_and(|volume| *volume < 0.0) {
            triangle.swap(1, 2);
        }
    }
}
