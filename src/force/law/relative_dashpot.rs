//! Dashpots on the whole relative velocity of a spring's ends (thesis Eq. 53 and 68; Kang 2000).
//!
//! ```text
//! force on a = c (vb - va), on b = -c (vb - va)      power = -c |vb - va|^2      -df/dv = c [[I, -I], [-I, I]]
//! ```
//! They also damp rigid rotation, so they are not a material; the thesis uses them with c = k dt.

use crate::force::kernel::axial_kernel::{AxialLaw, Pull, pull};
use crate::force::kernel::batch::{Records, Wants};
use crate::force::kernel::coefficient::Coefficient;
use crate::force::kernel::edges::{EdgeBatch, EdgeKernel, Edges};
use crate::force::{ForceTerm, NodeState, TangentSink};
use crate::model::forces::{Role, Tally};
use crate::model::quad::VectorUnit;
use crate::model::system::{TermInfo, Weights};
use nalgebra::Matrix3;
use std::sync::Arc;

/// A batch of relative dashpots.
pub type RelativeDashpots = EdgeBatch<RelativeData>;

/// Plain arrays of the batch.
#[derive(Clone, Debug)]
pub struct RelativeData {
    /// end nodes
    pub nodes: Arc<[[u32; 2]]>,
    /// [N s/m] c
    pub coefficient: Coefficient,
}

impl EdgeKernel for RelativeData {
    const WANTS: Wants = Wants { x: false, v: true };

    fn elements(&self) -> &[[u32; 2]] {
        &self.nodes
    }

    fn numbers(&self) -> [Coefficient; 2] {
        [self.coefficient.clone(), Coefficient::Uniform(0.0)]
    }

    fn add(&self, block: Edges<'_>, f: &mut Records) -> Tally {
        Tally { energy: 0.0, power: pull(&DashpotLaw, &block, block.v, f) }
    }
}

/// By the coefficient; the second number is nothing.
struct DashpotLaw;

impl AxialLaw for DashpotLaw {
    #[inline(always)]
    fn pull<U: VectorUnit>(&self, unit: U, [c, _]: [U::Quad; 2], square: U::Quad) -> Pull<U::Quad> {
        Pull { scale: c, amount: unit.splat(-1.0) * c * square }
    }
}

impl ForceTerm for RelativeDashpots {
    fn info(&self) -> TermInfo {
        TermInfo { velocity_dependent: true, ..TermInfo::of("relative dashpots", Role::Dissipative) }
    }

    fn symmetric(&self) -> bool {
        true
    }

    fn tangent(&self, _at: NodeState<'_>, w: Weights, sink: &mut dyn TangentSink) {
        let data = self.kernel();
        for (i, &nodes) in data.nodes.iter().enumerate() {
            sink.edge(nodes, Matrix3::from_diagonal_element(w.c * data.coefficient.at(i)));
        }
    }
}
