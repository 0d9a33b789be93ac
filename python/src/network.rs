//! Networks from arrays, without JSON.

use crate::arrays::{index_rows, indices, numbers, rows, spring_values, vector};
use crate::errors::{CaseError, of_mesh};
use crate::mesh::Mesh;
use canopy_fem::mesh;
use canopy_fem::model::spec::{DashpotKind, DashpotSpec, ElasticLaw, NetworkSpec, NodalLoad, Slack, SpringGroup};
use canopy_fem::simulation::NetworkBuilder;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::collections::HashMap;
use std::sync::Mutex;

/// Masses and springs from arrays.
#[pyclass(module = "canopy_fem._core", frozen, subclass)]
pub struct Network {
    builder: Mutex<NetworkBuilder>,
}

#[pymethods]
impl Network {
    /// mesh: a Mesh, or positions [m] of nodes, (n, 3). mass: [kg], a number for each node or one for all.
    #[new]
    #[pyo3(signature = (mesh, *, mass, gravity=None))]
    fn new(mesh: &Bound<'_, PyAny>, mass: &Bound<'_, PyAny>, gravity: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let mesh = match mesh.cast::<Mesh>() {
            Ok(mesh) => (*mesh.get().mesh).clone(),
            Err(_) => mesh::Mesh { nodes: rows(mesh, "nodes", None)?, ..mesh::Mesh::default() },
        };
        let mass = numbers(mass, "mass", mesh.nodes.len())?;
        let mut builder = NetworkBuilder::from_mesh(mesh).masses(mass);
        builder.spec.gravity = gravity.map(|given| vector(given, "gravity")).transpose()?;
        Ok(Network { builder: Mutex::new(builder) })
    }

    /// Adds springs between pairs of nodes, (m, 2), or on all edges of the mesh if pairs is None. Pairs that are no
    /// edges yet become edges, after those of the mesh. stiffness [N/m],
    /// rest_length [m] (default: the distance as given) and dashpot [N s/m] are a number each or one for all. law:
    /// "linear" or "green" (finite strain); slack: "none", "tension-only" or "compression-only"; dashpot_kind: "axial"
    /// or "relative".
    ///
    /// Raises:
    ///     ValueError, TypeError: arrays of another shape or type, nodes that do not exist.
    #[pyo3(signature = (
        pairs=None, *, stiffness, rest_length=None, law="linear", slack="none", dashpot=None, dashpot_kind="axial"
    ))]
    #[expect(clippy::too_many_arguments, reason = "they are keywords in Python")]
    fn springs(
        &self,
        pairs: Option<&Bound<'_, PyAny>>,
        stiffness: &Bound<'_, PyAny>,
        rest_length: Option<&Bound<'_, PyAny>>,
        law: &str,
        slack: &str,
        dashpot: Option<&Bound<'_, PyAny>>,
        dashpot_kind: &str,
    ) -> PyResult<()> {
        let mut builder = self.builder()?;
        let mesh = &builder.spec.mesh;
        let pairs = pairs.map(|given| index_rows::<2>(given, "pairs")).transpose()?;
        let (edges, pairs, added) = match pairs {
            Some(pairs) => {
                let (edges, added) = placed(mesh, &pairs);
                (edges, pairs, added)
            }
            None => ((0..mesh.edges.len() as u32).collect(), mesh.edges.clone(), Vec::new()),
        };
        let n = edges.len();
        let stiffness = spring_values(stiffness, "stiffness", n)?;
        let rest_length = match rest_length {
            Some(given) => numbers(given, "rest_length", n)?,
            None => lengths(mesh, &pairs)?,
        };
        let slack = match slack {
            "none" => Slack::None,
            "tension-only" => Slack::TensionOnly,
            "compression-only" => Slack::CompressionOnly,
            _ => {
                let text = format!("slack is \"{slack}\": give \"none\", \"tension-only\" or \"compression-only\"");
                return Err(PyValueError::new_err(text));
            }
        };
        let law = match law {
            "linear" => ElasticLaw::Linear,
            "green" => ElasticLaw::Green,
            _ => return Err(PyValueError::new_err(format!("law is \"{law}\": give \"linear\" or \"green\""))),
        };
        let kind = match dashpot_kind {
            "axial" => DashpotKind::Axial,
            "relative" => DashpotKind::Relative,
            _ => {
                let text = format!("dashpot_kind is \"{dashpot_kind}\": give \"axial\" or \"relative\"");
                return Err(PyValueError::new_err(text));
            }
        };
        let coefficient = dashpot.map(|given| spring_values(given, "dashpot", n)).transpose()?;
        let dashpot = coefficient.map(|coefficient| DashpotSpec { kind, coefficient, from_step: false });
        builder.spec.mesh.edges.extend_from_slice(&added);
        let group = SpringGroup { edges, stiffness, rest_length, law, slack, dashpot, ..SpringGroup::default() };
        builder.spec.springs.push(group);
        Ok(())
    }

    /// Holds nodes in x, y and z, or in those directions that are named.
    ///
    /// Raises:
    ///     ValueError, TypeError: nodes that do not exist, other directions.
    #[pyo3(signature = (nodes, directions="xyz"))]
    fn hold(&self, nodes: &Bound<'_, PyAny>, directions: &str) -> PyResult<()> {
        if directions.is_empty() || directions.chars().any(|c| !"xyz".contains(c)) {
            return Err(PyValueError::new_err(format!("directions is \"{directions}\": give letters of \"xyz\"")));
        }
        let mut builder = self.builder()?;
        let nodes = existing(&builder.spec, indices(nodes, "nodes")?)?;
        for node in nodes {
            for (held, name) in builder.spec.fixed[node as usize].iter_mut().zip(["x", "y", "z"]) {
                *held |= directions.contains(name);
            }
        }
        Ok(())
    }

    /// Adds a constant force [N], (3,), on each of these nodes.
    ///
    /// Raises:
    ///     ValueError, TypeError: nodes that do not exist, another shape or type.
    fn force(&self, nodes: &Bound<'_, PyAny>, force: &Bound<'_, PyAny>) -> PyResult<()> {
        let mut builder = self.builder()?;
        let mut nodes = existing(&builder.spec, indices(nodes, "nodes")?)?;
        nodes.sort_unstable();
        nodes.dedup();
        let force = vector(force, "force")?;
        builder.spec.forces.push(NodalLoad { nodes, force, factor: None });
        Ok(())
    }

    /// Starts displaced [m] and moving [m/s]: each (n, 3) or left out.
    ///
    /// Raises:
    ///     ValueError, TypeError: another shape or type.
    #[pyo3(signature = (*, displacement=None, velocity=None))]
    fn initial(&self, displacement: Option<&Bound<'_, PyAny>>, velocity: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let mut builder = self.builder()?;
        let n = Some(builder.spec.mesh.nodes.len());
        if let Some(given) = displacement {
            builder.spec.displacement = rows(given, "displacement", n)?;
        }
        if let Some(given) = velocity {
            builder.spec.velocity = rows(given, "velocity", n)?;
        }
        Ok(())
    }
}

impl Network {
    fn builder(&self) -> PyResult<std::sync::MutexGuard<'_, NetworkBuilder>> {
        self.builder.lock().map_err(|_| CaseError::new_err("the network was left unfinished by a failure"))
    }

    /// The specification so far.
    ///
    /// # Errors
    /// A mesh that contradicts itself.
    pub fn spec(&self) -> PyResult<NetworkSpec> {
        self.builder()?.clone().build().map_err(|error| of_mesh(&error))
    }
}

/// The edges of pairs of nodes: those that the mesh has, and new ones for the others, which are returned too.
fn placed(mesh: &mesh::Mesh, pairs: &[[u32; 2]]) -> (Vec<u32>, Vec<[u32; 2]>) {
    let key = |&[a, b]: &[u32; 2]| (a.min(b), a.max(b));
    let mut known: HashMap<(u32, u32), u32> = mesh.edges.iter().map(key).zip(0..).collect();
    let mut added = Vec::new();
    let edges = pairs.iter().map(|pair| {
        let next = (mesh.edges.len() + added.len()) as u32;
        *known.entry(key(pair)).or_insert_with(|| {
            added.push(*pair);
            next
        })
    });
    (edges.collect(), added)
}

/// [m] distances of pairs of nodes
fn lengths(mesh: &mesh::Mesh, pairs: &[[u32; 2]]) -> PyResult<Vec<f64>> {
    let n = mesh.nodes.len();
    let length = |pair: &[u32; 2]| {
        let [a, b] = pair.map(|node| mesh.nodes.get(node as usize));
        let (Some(a), Some(b)) = (a, b) else {
            return Err(PyValueError::new_err(format!("pairs has {pair:?}; nodes are numbered 0 to {}", n - 1)));
        };
        Ok(a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt())
    };
    pairs.iter().map(length).collect()
}

fn existing(spec: &NetworkSpec, nodes: Vec<u32>) -> PyResult<Vec<u32>> {
    let n = spec.mesh.nodes.len();
    match nodes.iter().find(|node| **node as usize >= n) {
        Some(node) => Err(PyValueError::new_err(format!("node {node} does not exist: there are {n}, counted from 0"))),
        None => Ok(nodes),
    }
}
