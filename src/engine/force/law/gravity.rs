//! Weight: f = m g on every node (thesis Eq. 5), energy -m g . (x - x_start).
//!
//! The energy is computed from the displacement, so that a far origin loses no digits. Fixed nodes have no weight here:
//! their support carries it. A program can scale g while a simulation runs.

use crate::force::kernel::batch::{BlockForces, BufferReads, PARTS, Records};
use crate::force::kernel::element_block::ElementBlock;
use crate::force::kernel::nodes::{self, NodeLaw, padded};
use crate::force::law::series::Scale;
use crate::force::{Copies, ForceTerm, NodeState, TangentForm, TangentSink};
use crate::model::forces::{Role, Tally};
use crate::model::quad::VectorUnit;
use crate::model::system::{TermInfo, Weights};
use nalgebra::Vector3;
use std::sync::Arc;

/// Uniform gravity.
#[derive(Clone, Debug)]
pub struct Gravity {
    /// [m/s^2] acceleration of free fall
    g: Vector3<f64>,
    /// [kg] mass of every node; the weight of what is held is a part of the reaction
    mass: Arc<[f64]>,
    /// [m] node positions of zero energy
    origin: Arc<[Vector3<f64>]>,
    scale: Arc<Scale>,
}

impl Gravity {
    /// Masses [kg] in the acceleration of free fall `g` [m/s^2] times `scale`; `origin` are the node positions [m] from
    /// which the energy counts.
    pub fn new(
        g: Vector3<f64>,
        scale: Arc<Scale>,
        mass: impl Iterator<Item = f64>,
        origin: Arc<[Vector3<f64>]>,
    ) -> Self {
        Gravity { g, mass: mass.collect(), origin, scale }
    }
}

/// Weight at one factor.
struct Weight<'a> {
    gravity: &'a Gravity,
    /// [m/s^2]
    g: Vector3<f64>,
}

impl NodeLaw for Weight<'_> {
    #[inline(always)]
    fn force<U: VectorUnit>(&self, unit: U, i: usize, x: U::Quad, _: U::Quad) -> [U::Quad; 2] {
        let weight = unit.splat(self.gravity.mass[i]) * unit.quad([self.g.x, self.g.y, self.g.z, 0.0]);
        [weight, weight * (unit.quad(padded(&self.gravity.origin, i)) - x)]
    }
}

impl BlockForces for Gravity {
    fn elements(&self) -> usize {
        self.mass.len()
    }

    fn reads(&self, _: [bool; PARTS]) -> BufferReads {
        BufferReads { x: true, v: false }
    }

    fn add(&self, block: &ElementBlock<'_>, [sum, _]: [Option<&mut Records>; PARTS]) -> [Tally; PARTS] {
        let law = Weight { gravity: self, g: self.g * self.scale.get() };
        let energy = sum.map_or(0.0, |f| nodes::add(&law, None, block, f));
        [Tally { energy, power: 0.0 }, Tally::default()]
    }
}

impl ForceTerm for Gravity {
    fn parts(&self) -> &[TermInfo] {
        const INFO: TermInfo = TermInfo::of("gravity", Role::Gravity);
        &[INFO]
    }

    fn by_mass(&self) -> bool {
        true
    }

    fn symmetric(&self) -> bool {
        true
    }

    fn tangent(&self, _at: NodeState<'_>, _w: Weights, _: TangentForm, _sink: &mut dyn TangentSink) {}

    fn for_run(&self, copies: &mut Copies) -> Box<dyn ForceTerm> {
        Box::new(Gravity { scale: copies.of(&self.scale), ..self.clone() })
    }
}
