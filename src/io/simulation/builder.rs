//! Networks made in code.

use crate::mesh::{Mesh, MeshError};
use crate::model::spec::{DashpotKind, DashpotSpec, ElasticLaw, NetworkSpec, NodalLoad, Slack, SpringGroup};

/// Springs that share a law.
#[derive(Clone, Debug, PartialEq)]
pub struct SpringLaw {
    /// [N/m] stiffness
    pub stiffness: f64,
    /// [m] rest length; `None`: the distance of the nodes as given
    pub rest_length: Option<f64>,
    /// tension over strain
    pub law: ElasticLaw,
    /// when they pull and push
    pub slack: Slack,
    /// kind and coefficient [N s/m] of a dashpot in parallel
    pub dashpot: Option<(DashpotKind, f64)>,
}

impl Default for SpringLaw {
    fn default() -> Self {
        SpringLaw { stiffness: 0.0, rest_length: None, law: ElasticLaw::Linear, slack: Slack::None, dashpot: None }
    }
}

/// Builds a [`NetworkSpec`]: nodes, springs, masses, supports and loads. What has no method here is a field of the
/// specification.
#[derive(Clone, Debug, Default)]
pub struct NetworkBuilder {
    /// what has been said so far
    pub spec: NetworkSpec,
}

impl NetworkBuilder {
    /// Free nodes without mass at these positions [m].
    pub fn new(nodes: Vec<[f64; 3]>) -> Self {
        Self::from_mesh(Mesh { nodes, ..Mesh::default() })
    }

    /// The nodes, edges and triangles of a mesh, with its displacement at the start; the nodes are free and have no
    /// mass.
    pub fn from_mesh(mesh: Mesh) -> Self {
        let n = mesh.nodes.len();
        let displacement = mesh.displacement.clone();
        let (mass, fixed) = (vec![0.0; n], vec![[false; 3]; n]);
        let spec = NetworkSpec { mesh, mass, fixed, displacement, ..NetworkSpec::default() };
        NetworkBuilder { spec }
    }

    /// Adds springs between pairs of nodes, which become edges.
    #[must_use]
    pub fn springs(mut self, pairs: &[[u32; 2]], law: SpringLaw) -> Self {
        let first = self.spec.mesh.edges.len() as u32;
        self.spec.mesh.edges.extend_from_slice(pairs);
        let edges = (first..).take(pairs.len()).collect();
        self.springs_on(edges, law)
    }

    /// Puts springs on all edges of the mesh.
    #[must_use]
    pub fn springs_on_edges(self, law: SpringLaw) -> Self {
        let edges = (0..self.spec.mesh.edges.len() as u32).collect();
        self.springs_on(edges, law)
    }

    fn springs_on(mut self, edges: Vec<u32>, law: SpringLaw) -> Self {
        let mesh = &self.spec.mesh;
        // A node that does not exist is refused when the scene is built.
        let node = |i: u32| mesh.nodes.get(i as usize).copied().unwrap_or_default();
        let distance = |&edge: &u32| {
            let [a, b] = mesh.edges[edge as usize].map(node);
            (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
        };
        let rest_length = edges.iter().map(|edge| law.rest_length.unwrap_or_else(|| distance(edge))).collect();
        let dashpot = law.dashpot.map(|(kind, c)| DashpotSpec { kind, coefficient: c.into(), from_step: false });
        let SpringLaw { stiffness, law, slack, .. } = law;
        let stiffness = stiffness.into();
        let group = SpringGroup { edges, stiffness, rest_length, law, slack, dashpot, ..SpringGroup::default() };
        self.spec.springs.push(group);
        self
    }

    /// Sets the mass [kg] of every node, `[n_nodes]`.
    #[must_use]
    pub fn masses(mut self, mass: Vec<f64>) -> Self {
        self.spec.mass = mass;
        self
    }

    /// Shares a mass [kg] out equally over the nodes.
    #[must_use]
    pub fn total_mass(mut self, mass: f64) -> Self {
        let n = self.spec.mesh.nodes.len();
        self.spec.mass = vec![mass / n as f64; n];
        self
    }

    /// Holds nodes in x, y and z, chosen by number and position [m].
    #[must_use]
    pub fn hold(mut self, which: impl Fn(usize, [f64; 3]) -> bool) -> Self {
        for (i, (fixed, x)) in self.spec.fixed.iter_mut().zip(&self.spec.mesh.nodes).enumerate() {
            if which(i, *x) {
                *fixed = [true; 3];
            }
        }
        self
    }

    /// Sets gravity [m/s^2].
    #[must_use]
    pub fn gravity(mut self, gravity: [f64; 3]) -> Self {
        self.spec.gravity = Some(gravity);
        self
    }

    /// Adds a constant force [N] on each of these nodes.
    #[must_use]
    pub fn force(mut self, nodes: &[u32], force: [f64; 3]) -> Self {
        let mut nodes = nodes.to_vec();
        nodes.sort_unstable();
        self.spec.forces.push(NodalLoad { nodes, force, factor: None });
        self
    }

    /// The specification, checked as far as the mesh goes; the rest is checked when a simulation is made of it.
    ///
    /// # Errors
    /// A mesh that contradicts itself.
    pub fn build(self) -> Result<NetworkSpec, MeshError> {
        self.spec.mesh.check()?;
        Ok(self.spec)
    }
}
