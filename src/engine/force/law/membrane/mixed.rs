//! Membranes of Newton's mixed iteration (`solve/mixed`): their stresses are unknowns, so the matrix has those in place
//! of the stresses that their strains give.
//!
//! ```text
//! K_ab = A0 [(g_a . S g_b) I + B_a^T D B_b],   D = (1 + tau dv/dx) dS/dE
//! ```
//! The part of the damping that is not symmetric, B_a^T (dS/dE) tau dB_b/dt, is left out.

use super::{Membrane, MembraneData, strain_by_node};
use crate::force::{NodeState, SheetTerm, TangentSink};
use crate::model::spring_state::SheetState;
use crate::model::system::Weights;
use nalgebra::{Matrix2, Matrix3, Vector3};

impl MembraneData {
    fn sheet_state(&self, i: usize, at: NodeState<'_>, cv: f64) -> SheetState {
        let [f, rate] = [at.x, at.v].map(|of| self.deformation(i, of));
        let [_, total] = self.strains([&f, &rate]);
        let (area, [one, two]) = (self.shapes[i].area, self.scale);
        SheetState {
            nodes: self.triangles[i],
            area,
            by_node: self.shapes[i].gradients().map(|g| strain_by_node(&f, &g)),
            stress: Vector3::from(self.sheet.stress(total)),
            stiffness: self.stiffness(total) * (1.0 + self.damping_time * cv),
            flexibility: area.sqrt() / (one * two),
        }
    }
}

impl SheetTerm for Membrane {
    fn count(&self) -> usize {
        self.data.triangles.len()
    }

    fn measure(&self, at: NodeState<'_>, cv: f64, out: &mut [SheetState]) {
        out.iter_mut().enumerate().for_each(|(i, out)| *out = self.data.sheet_state(i, at, cv));
    }

    fn mixed_tangent(&self, at: NodeState<'_>, w: Weights, stresses: &[Vector3<f64>], sink: &mut dyn TangentSink) {
        for (i, stress) in stresses.iter().enumerate() {
            let cv = if w.k > 0.0 { w.c / w.k } else { 0.0 };
            let SheetState { nodes, area, by_node, stiffness, .. } = self.data.sheet_state(i, at, cv);
            let g = self.data.shapes[i].gradients();
            let stress = Matrix2::new(stress.x, stress.z, stress.z, stress.y);
            let block = |p: usize, q: usize| {
                let across = Matrix3::from_diagonal_element(g[p].dot(&(stress * g[q])));
                (across + by_node[p].transpose() * stiffness * by_node[q]) * (area * w.k)
            };
            sink.triangle(nodes, &[0, 1, 2].map(|p| [0, 1, 2].map(|q| block(p, q))));
        }
    }
}
