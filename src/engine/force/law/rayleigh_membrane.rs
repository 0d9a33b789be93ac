//! Rayleigh damping of membranes: f = -beta K0 v with their stiffness on the mesh as given, without its geometric part.
//!
//! ```text
//! s = beta C^-1 (sum of B_b v_b),   f_a = -A0 B_a^T s,   power = -A0 s . (sum of B_b v_b)   B_a = dE/dx_a at rest
//! ```

use crate::force::kernel::batch::{Batch, BufferReads, Elements, Kernel, Records};
use crate::force::kernel::element_block::{add, vector};
use crate::force::{Copies, ForceTerm, NodeState, TangentForm, TangentSink};
use crate::model::forces::{Role, Tally};
use crate::model::system::{TermInfo, Weights};
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// Rayleigh damping of membranes as a force term.
pub type RayleighMembrane = Batch<RayleighMembraneData, 3>;

/// A triangle at rest.
#[derive(Clone, Debug)]
pub struct RestTriangle {
    /// B of every corner
    pub by_node: [Matrix3<f64>; 3],
    /// beta A0 C^-1
    pub matrix: Matrix3<f64>,
}

/// Plain arrays of the triangles.
#[derive(Clone, Debug)]
pub struct RayleighMembraneData {
    /// vertices
    pub triangles: Arc<[[u32; 3]]>,
    /// one each
    pub rest: Vec<RestTriangle>,
}

impl Kernel<3> for RayleighMembraneData {
    const READS: BufferReads = BufferReads { x: false, v: true };

    fn elements(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    fn add(&self, block: Elements<'_, 3>, f: &mut Records) -> Tally {
        let mut power = 0.0;
        for (nodes, i) in block.nodes.iter().zip(block.range()) {
            let RestTriangle { by_node, matrix } = &self.rest[i];
            let mut rate = Vector3::zeros();
            for (b, &node) in by_node.iter().zip(nodes) {
                rate += b * vector(block.v, node);
            }
            let s = matrix * rate;
            power -= s.dot(&rate);
            for (b, &node) in by_node.iter().zip(nodes) {
                add(f, node, -(b.transpose() * s));
            }
        }
        Tally { energy: 0.0, power }
    }
}

impl ForceTerm for RayleighMembrane {
    fn parts(&self) -> &[TermInfo] {
        const INFO: TermInfo = TermInfo {
            velocity_dependent: true,
            on_triangles: true,
            ..TermInfo::of("rayleigh stiffness damping", Role::Dissipative)
        };
        &[INFO]
    }

    fn symmetric(&self) -> bool {
        true
    }

    fn tangent(&self, _: NodeState<'_>, w: Weights, _: TangentForm, sink: &mut dyn TangentSink) {
        let data = self.kernel();
        for (&nodes, RestTriangle { by_node, matrix }) in data.triangles.iter().zip(&data.rest) {
            let block = |p: usize, q: usize| by_node[p].transpose() * matrix * by_node[q] * w.c;
            sink.triangle(nodes, &[0, 1, 2].map(|p| [0, 1, 2].map(|q| block(p, q))));
        }
    }

    fn for_run(&self, copies: &mut Copies) -> Box<dyn ForceTerm> {
        Box::new(Batch::for_run(self, copies))
    }
}
