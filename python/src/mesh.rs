//! Meshes.

use crate::arrays::{index_rows, indices, of_indices, of_numbers, of_rows, rows};
use crate::errors::{CaseError, engine, of_mesh};
use crate::interrupt::watched;
use canopy_fem::mesh::read::Imported;
use canopy_fem::mesh::write::write_mesh;
use canopy_fem::mesh::{self, Group, Groups, MeshError, MeshSource, Quality};
use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::{PyKeyError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

/// A mesh: nodes, edges and triangles, in the user's numbering. Made of arrays, or by the functions of canopy_fem.mesh.
///
/// Args:
///     nodes: positions [m], (n, 3).
///     edges: pairs of nodes, (m, 2); the sides of the triangles if left out.
///     triangles: (k, 3).
///     groups: {name: {"nodes" | "edges" | "triangles": numbers}}.
///
/// Raises:
///     CaseError: a mesh that contradicts itself, e.g. a node that does not exist.
///     ValueError, TypeError, KeyError: arrays of another shape or type, an unknown kind of member.
#[pyclass(module = "canopy_fem._core", frozen, subclass)]
pub struct Mesh {
    /// the mesh, which has passed its check
    pub mesh: Arc<mesh::Mesh>,
    notes: Vec<String>,
}

/// Nodes, edges, triangles, groups; seams, displacement, notes.
type Parts<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<i64>>,
    Bound<'py, PyArray2<i64>>,
    Bound<'py, PyDict>,
    (Vec<u32>, Bound<'py, PyArray2<f64>>, Vec<String>),
);

#[pymethods]
impl Mesh {
    #[new]
    #[pyo3(signature = (nodes, *, edges=None, triangles=None, groups=None))]
    fn new(
        py: Python<'_>,
        nodes: &Bound<'_, PyAny>,
        edges: Option<&Bound<'_, PyAny>>,
        triangles: Option<&Bound<'_, PyAny>>,
        groups: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let nodes = rows(nodes, "nodes", None)?;
        let triangles = triangles.map_or(Ok(Vec::new()), |given| index_rows(given, "triangles"))?;
        let edges = edges.map(|given| index_rows(given, "edges")).transpose()?;
        let edges = edges.unwrap_or_else(|| sides(&triangles));
        let groups = groups.map_or(Ok(Groups::new()), groups_of)?;
        let made = mesh::Mesh { nodes, edges, triangles, groups, ..mesh::Mesh::default() };
        let checked = engine(py, || made.check().map(|()| made))?;
        Ok(Self::of(Imported {
            mesh: checked.map_err(|error| of_mesh(&error))?,
            notes: Vec::new(),
            repairs: Vec::new(),
        }))
    }

    /// [m] positions, (n, 3); a copy, read-only
    #[getter]
    fn nodes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        of_rows(py, self.mesh.nodes.clone())
    }

    /// pairs of nodes, (m, 2); a copy, read-only
    #[getter]
    fn edges<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        of_numbers(py, &self.mesh.edges)
    }

    /// triples of nodes, (k, 3); a copy, read-only
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        of_numbers(py, &self.mesh.triangles)
    }

    /// edges of the radial seams; a copy, read-only
    #[getter]
    fn seams<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        of_indices(py, &self.mesh.seams)
    }

    /// named parts: {name: {"nodes": numbers, "edges": numbers, "triangles": numbers}}
    #[getter]
    fn groups<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for (name, Group { nodes, edges, triangles }) in &self.mesh.groups {
            let group = PyDict::new(py);
            for (kind, list) in [("nodes", nodes), ("edges", edges), ("triangles", triangles)] {
                if !list.is_empty() {
                    group.set_item(kind, of_indices(py, list))?;
                }
            }
            all.set_item(name, group)?;
        }
        Ok(all)
    }

    /// one sentence for every change that the reader of a file made
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// Numbers that tell how good it is: angles [deg], lengths [m], areas [m^2], radius ratios [-] (twice the radius of
    /// the inner circle over that of the outer one, 1 for equal sides), counts.
    fn quality<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let measured = engine(py, || Quality::new(&self.mesh))?.map_err(|error| of_mesh(&error))?;
        let numbers = [
            ("min_angle", measured.min_angle),
            ("max_angle", measured.max_angle),
            ("min_edge", measured.min_edge),
            ("max_edge", measured.max_edge),
            ("mean_edge", measured.mean_edge),
            ("min_area", measured.min_area),
            ("total_area", measured.total_area),
            ("min_radius_ratio", measured.min_radius_ratio),
            ("mean_radius_ratio", measured.mean_radius_ratio),
        ];
        let all = PyDict::new(py);
        numbers.into_iter().try_for_each(|(name, value)| all.set_item(name, value))?;
        all.set_item("components", measured.components)?;
        all.set_item("euler_characteristic", measured.euler_characteristic)?;
        Ok(all)
    }

    /// Writes the mesh as .vtu, .msh, .obj, .ply or .stl. An existing file is refused unless replace is True.
    ///
    /// Returns:
    ///     Sentences for what the format does not hold; empty for .vtu, which holds all.
    ///
    /// Raises:
    ///     OSError: the file exists already, or cannot be written.
    ///     CaseError: another ending.
    #[pyo3(signature = (path, *, replace=false))]
    fn write(&self, py: Python<'_>, path: PathBuf, replace: bool) -> PyResult<Vec<String>> {
        engine(py, || write_mesh(&self.mesh, &path, replace))?.map_err(|error| of_mesh(&error))
    }

    /// For copies and pickles.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Parts<'py>)> {
        let more = (self.mesh.seams.clone(), of_rows(py, self.mesh.displacement.clone())?, self.notes.clone());
        let parts = (self.nodes(py)?, self.edges(py)?, self.triangles(py)?, self.groups(py)?, more);
        Ok((py.import("canopy_fem._core")?.getattr("_mesh_of")?, parts))
    }

    fn __repr__(&self) -> String {
        let mesh::Mesh { nodes, edges, triangles, groups, .. } = &*self.mesh;
        let names: Vec<&str> = groups.keys().map(String::as_str).collect();
        let groups = if names.is_empty() { String::new() } else { format!(", groups {}", names.join(", ")) };
        format!("<Mesh: {} nodes, {} edges, {} triangles{groups}>", nodes.len(), edges.len(), triangles.len())
    }
}

impl Mesh {
    fn of(Imported { mesh, notes, repairs }: Imported) -> Self {
        Mesh { mesh: Arc::new(mesh), notes: [repairs, notes].concat() }
    }
}

/// The sides of triangles, each once, in ascending order.
fn sides(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let all = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [a, c]]);
    all.map(|[a, b]| [a.min(b), a.max(b)]).collect::<BTreeSet<_>>().into_iter().collect()
}

/// Groups from a dictionary.
fn groups_of(given: &Bound<'_, PyDict>) -> PyResult<Groups> {
    let mut groups = Groups::new();
    for (name, members) in given {
        let name: String = name.extract()?;
        let members = members.cast_into::<PyDict>();
        let members = members.map_err(|_| {
            PyTypeError::new_err(format!("group \"{name}\" must be a dictionary with nodes, edges or triangles"))
        })?;
        let mut group = Group::default();
        for (kind, list) in members {
            let kind: String = kind.extract()?;
            let place = match kind.as_str() {
                "nodes" => &mut group.nodes,
                "edges" => &mut group.edges,
                "triangles" => &mut group.triangles,
                _ => {
                    let text = format!("group \"{name}\" has \"{kind}\"; known are nodes, edges, triangles");
                    return Err(PyKeyError::new_err(text));
                }
            };
            *place = indices(&list, &format!("{kind} of group \"{name}\""))?;
            place.sort_unstable();
            place.dedup();
        }
        groups.insert(name, group);
    }
    Ok(groups)
}

/// Makes a mesh from its section of a case, as JSON text; paths are relative to `base`.
#[pyfunction]
pub(crate) fn generate(py: Python<'_>, section: &str, base: PathBuf) -> PyResult<Mesh> {
    let source: MeshSource =
        serde_json::from_str(section).map_err(|error| CaseError::new_err(format!("mesh: {error}")))?;
    made(py, move || source.build_with_notes(&base))
}

/// The mesh that a pickle holds.
#[pyfunction]
pub(crate) fn _mesh_of(
    py: Python<'_>,
    nodes: &Bound<'_, PyAny>,
    edges: &Bound<'_, PyAny>,
    triangles: &Bound<'_, PyAny>,
    groups: &Bound<'_, PyDict>,
    more: (Vec<u32>, Bound<'_, PyAny>, Vec<String>),
) -> PyResult<Mesh> {
    let Mesh { mesh, .. } = Mesh::new(py, nodes, Some(edges), Some(triangles), Some(groups))?;
    let (seams, displacement, notes) = more;
    let displacement = rows(&displacement, "displacement", None)?;
    let mesh = Arc::new(mesh::Mesh { seams, displacement, ..(*mesh).clone() });
    Ok(Mesh { mesh, notes })
}

fn made(py: Python<'_>, make: impl FnOnce() -> Result<Imported, MeshError> + Send) -> PyResult<Mesh> {
    watched(py, |_| make(), |_| Ok(()))?.map(Mesh::of).map_err(|error| of_mesh(&error))
}
