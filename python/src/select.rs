//! Parts of a scene by their names.

use crate::errors::of_mesh;
use canopy_fem::mesh::{Mesh, Topology};
use canopy_fem::scene::Scene;
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;

/// The mesh of a scene, in the user's numbering.
pub(crate) fn mesh_of(scene: &dyn Scene) -> Mesh {
    Mesh {
        nodes: scene.reference().to_vec(),
        edges: scene.edges().to_vec(),
        triangles: scene.triangles().to_vec(),
        groups: scene.groups().clone(),
        ..Mesh::default()
    }
}

/// Numbers of a group, or of "all", "boundary", "outer", "inner": of "nodes", "edges" or "triangles".
///
/// # Errors
/// `KeyError` for an unknown group, `ValueError` for another kind.
pub(crate) fn selected(mesh: &Mesh, name: &str, kind: &str) -> PyResult<Vec<u32>> {
    let all = match kind {
        "nodes" => mesh.nodes.len(),
        "edges" => mesh.edges.len(),
        "triangles" => mesh.triangles.len(),
        _ => return Err(PyValueError::new_err(format!("kind is \"{kind}\": give nodes, edges or triangles"))),
    };
    if let Some(group) = mesh.groups.get(name) {
        return Ok(match kind {
            "nodes" => group.select_nodes(mesh),
            "edges" => group.select_edges(mesh),
            _ => group.triangles.clone(),
        });
    }
    let topology = || Topology::new(mesh).map_err(|error| of_mesh(&error));
    match (name, kind) {
        ("all", _) => Ok((0..all as u32).collect()),
        ("boundary", "nodes") => Ok(topology()?.boundary_nodes().to_vec()),
        ("outer", "nodes") => Ok(topology()?.outer_nodes().to_vec()),
        ("inner", "nodes") => Ok(topology()?.inner_nodes().to_vec()),
        _ => {
            let known: Vec<&str> = mesh.groups.keys().map(String::as_str).collect();
            let text = format!("there are no {kind} of \"{name}\"; groups here: {}", known.join(", "));
            Err(PyKeyError::new_err(text))
        }
    }
}
