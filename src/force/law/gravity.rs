//! Weight: f = m g on every node (thesis Eq. 5), energy -m g . (x - x_start).
//!
//! The energy is counted from the displacement, so that an origin far away costs no digits. Fixed nodes have no
//! weight here: their support carries it and nothing moves.

use crate::force::kernel::batch::{PARTS, Records, Summand, Wants};
use crate::force::kernel::element_block::ElementBlock;
use crate::force::kernel::local_buffer::PaddedVec3;
use crate::force::kernel::nodes::{self, NodeLaw, padded};
use crate::force::{ForceTerm, NodeState, TangentForm, TangentSink};
use crate::model::forces::{Role, Tally};
use crate::model::quad::VectorUnit;
use crate::model::system::{TermInfo, Weights};
use nalgebra::Vector3;

/// Uniform gravity.
#[derive(Clone, Debug)]
pub struct Gravity {
    /// [N] weight of every node, 0 where it is held in all directions
    weight: Vec<PaddedVec3>,
    /// [m] node positions from which the energy counts
    origin: Vec<PaddedVec3>,
}

impl Gravity {
    /// Masses [kg] in the acceleration of free fall `g` [m/s^2]; `origin` are the node positions [m] from which the
    /// energy counts.
    pub fn new(g: Vector3<f64>, mass: impl Iterator<Item = f64>, origin: &[Vector3<f64>]) -> Self {
        let weight = mass.map(|m| padded(m * g)).collect();
        Gravity { weight, origin: origin.iter().map(|x| padded(*x)).collect() }
    }
}

impl NodeLaw for Gravity {
    #[inline(always)]
    fn force<U: VectorUnit>(&self, unit: U, i: usize, x: U::Quad, _: U::Quad) -> [U::Quad; 2] {
        let weight = unit.quad(self.weight[i]);
        [weight, weight * (unit.quad(self.origin[i]) - x)]
    }
}

impl Summand for Gravity {
    fn elements(&self) -> usize {
        self.weight.len()
    }

    fn wants(&self) -> Wants {
        Wants { x: true, v: false }
    }

    fn add(&self, block: &ElementBlock<'_>, [sum, _]: [Option<&mut Records>; PARTS]) -> [Tally; PARTS] {
        let energy = sum.map_or(0.0, |f| nodes::add(self, None, block, f));
        [Tally { energy, power: 0.0 }, Tally::default()]
    }
}

impl ForceTerm for Gravity {
    fn parts(&self) -> &[TermInfo] {
        const INFO: TermInfo = TermInfo::of("gravity", Role::Gravity);
        &[INFO]
    }

    fn symmetric(&self) -> bool {
        true
    }

    fn tangent(&self, _at: NodeState<'_>, _w: Weights, _: TangentForm, _sink: &mut dyn TangentSink) {}
}
