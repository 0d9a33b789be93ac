//! What is set in the runs of a rollout on the way.

use crate::select::{mesh_of, selected};
use crate::simulation::load_name;
use canopy_fem::mesh::Mesh;
use canopy_fem::scene::Scene;
use canopy_fem::simulation::{Load, Simulation, SimulationError};
use numpy::{PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use std::cell::OnceCell;

/// Nodes or edges: a group, or numbers.
#[derive(Clone, FromPyObject)]
pub(crate) enum Place {
    Group(String),
    Numbers(Vec<u32>),
}

impl Place {
    fn numbers(&self, mesh: &OnceCell<Mesh>, scene: &dyn Scene, kind: &str) -> PyResult<Vec<u32>> {
        match self {
            Place::Group(name) => selected(mesh.get_or_init(|| mesh_of(scene)), name, kind),
            Place::Numbers(numbers) => Ok(numbers.clone()),
        }
    }

    fn name(&self) -> String {
        match self {
            Place::Group(name) => name.clone(),
            Place::Numbers(numbers) => format!("nodes {numbers:?}"),
        }
    }
}

/// What is set on the way: values of all runs and times, each of `size` numbers.
pub(crate) struct Action {
    what: String,
    place: Place,
    size: usize,
    /// `[runs * times * size]`
    values: Vec<f64>,
}

/// Nodes or edges of each action; none of loads and wind.
pub(crate) type Sites = Vec<Vec<u32>>;

/// The same, as a scene knows it.
pub(crate) enum Acts<'a> {
    Force { name: String, nodes: &'a [u32], of: &'a Action },
    RestScale { edges: &'a [u32], of: &'a Action },
    Load(Load, &'a Action),
    Wind(&'a Action),
}

impl Action {
    /// For arrays (runs, times, …).
    pub(crate) fn read((what, place, array): (String, Place, PyReadonlyArrayDyn<'_, f64>)) -> PyResult<Self> {
        let values = array.as_slice().map_err(|error| PyValueError::new_err(error.to_string()))?.to_vec();
        let size = array.shape().iter().skip(2).product();
        Ok(Action { what, place, size, values })
    }

    fn row(&self, row: usize) -> &[f64] {
        &self.values[row * self.size..(row + 1) * self.size]
    }

    /// Where the actions act in a scene. Its mesh is copied once, and only where a group is named.
    pub(crate) fn sites(all: &[Action], scene: &dyn Scene) -> PyResult<Sites> {
        let mesh = OnceCell::new();
        let site = |action: &Action| match action.what.as_str() {
            "force" => action.nodes(&mesh, scene),
            "rest_scale" => action.place.numbers(&mesh, scene, "edges"),
            _ => Ok(Vec::new()),
        };
        all.iter().map(site).collect()
    }

    fn nodes(&self, mesh: &OnceCell<Mesh>, scene: &dyn Scene) -> PyResult<Vec<u32>> {
        let (name, nodes) = (self.place.name(), self.place.numbers(mesh, scene, "nodes")?);
        let all = scene.reference().len();
        if let Some((place, &node)) = nodes.iter().enumerate().find(|(_, node)| **node as usize >= all) {
            let error = SimulationError::NoNode { what: "force: place", place, node, nodes: all };
            return Err(PyValueError::new_err(error.to_string()));
        }
        if self.size != 3 && self.size != 3 * nodes.len() {
            let text =
                format!("the force on {name} needs the shape (runs, times, 3) or (runs, times, {}, 3)", nodes.len());
            return Err(PyValueError::new_err(text));
        }
        Ok(nodes)
    }

    pub(crate) fn of_scene<'a>(&'a self, site: &'a [u32], simulation: &Simulation) -> PyResult<Acts<'a>> {
        match self.what.as_str() {
            "force" => Ok(Acts::Force { name: self.place.name(), nodes: site, of: self }),
            "rest_scale" => Ok(Acts::RestScale { edges: site, of: self }),
            "load" => {
                let (name, loads) = (self.place.name(), simulation.load_factors());
                let found = loads.iter().find(|(load, _)| load_name(*load) == name);
                found.map(|(load, _)| Acts::Load(*load, self)).ok_or_else(|| {
                    let known: Vec<String> = loads.iter().map(|(load, _)| load_name(*load)).collect();
                    PyKeyError::new_err(format!("there is no load \"{name}\"; the scene has: {}", known.join(", ")))
                })
            }
            _ => Ok(Acts::Wind(self)),
        }
    }
}

impl Acts<'_> {
    /// Sets the values of a row; `force` has a row for each node.
    pub(crate) fn set(
        &self,
        simulation: &mut Simulation,
        row: usize,
        force: &mut [[f64; 3]],
    ) -> Result<(), SimulationError> {
        match self {
            Acts::Force { name, nodes, of } => {
                let values = of.row(row).as_chunks::<3>().0;
                force.fill([0.0; 3]);
                for (place, node) in nodes.iter().enumerate() {
                    force[*node as usize] = values[if values.len() == 1 { 0 } else { place }];
                }
                simulation.set_force(name, force)
            }
            Acts::RestScale { edges, of } => simulation.set_rest_scale(edges, of.row(row)[0]),
            Acts::Load(load, of) => simulation.set_load_factor(*load, of.row(row)[0]),
            Acts::Wind(of) => simulation.set_wind(of.row(row).first_chunk().copied()),
        }
    }
}
