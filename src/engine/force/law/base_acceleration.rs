//! Uniform excitation: the base accelerates, and positions and velocities are relative to it.
//!
//! f = -m a_b(t) on every node, tangents zero, power = f . v (Clough and Penzien, Dynamics of Structures, 1993,
//! section 2-6).
//!
//! Nodes that are held in all directions have no force here: their support carries them along.

use crate::force::kernel::batch::{BlockForces, BufferReads, PARTS, Records};
use crate::force::kernel::element_block::ElementBlock;
use crate::force::kernel::nodes::{self, NodeLaw};
use crate::force::law::series::Table;
use crate::force::{Copies, ForceTerm, NodeState, TangentForm, TangentSink};
use crate::model::forces::{Role, Tally};
use crate::model::quad::VectorUnit;
use crate::model::system::{TermInfo, Weights};
use std::sync::Arc;

/// Inertia in the frame of an accelerated base.
#[derive(Clone, Debug)]
pub struct BaseAcceleration {
    /// [m/s^2] acceleration of the base over time
    acceleration: Arc<Table<3>>,
    /// [kg] mass of every node, 0 where it is held in all directions
    mass: Arc<[f64]>,
}

impl BaseAcceleration {
    /// Masses [kg] by node on a base with this acceleration [m/s^2].
    pub fn new(acceleration: Arc<Table<3>>, mass: impl Iterator<Item = f64>) -> Self {
        BaseAcceleration { acceleration, mass: mass.collect() }
    }
}

/// Inertia at one time.
struct Inertia<'a> {
    mass: &'a [f64],
    /// [m/s^2] minus the acceleration of the base
    g: [f64; 3],
}

impl NodeLaw for Inertia<'_> {
    #[inline(always)]
    fn force<U: VectorUnit>(&self, unit: U, i: usize, _: U::Quad, v: U::Quad) -> [U::Quad; 2] {
        let [x, y, z] = self.g;
        let force = unit.splat(self.mass[i]) * unit.quad([x, y, z, 0.0]);
        [force, force * v]
    }
}

impl BlockForces for BaseAcceleration {
    fn elements(&self) -> usize {
        self.mass.len()
    }

    fn reads(&self, _: [bool; PARTS]) -> BufferReads {
        BufferReads { x: false, v: true }
    }

    fn add(&self, block: &ElementBlock<'_>, [sum, _]: [Option<&mut Records>; PARTS]) -> [Tally; PARTS] {
        let law = Inertia { mass: &self.mass, g: self.acceleration.at(block.t).map(|a| -a) };
        let power = sum.map_or(0.0, |f| nodes::add(&law, None, block, f));
        [Tally { energy: 0.0, power }, Tally::default()]
    }
}

impl ForceTerm for BaseAcceleration {
    fn parts(&self) -> &[TermInfo] {
        const INFO: TermInfo = TermInfo::of("base acceleration", Role::External);
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
        Box::new(BaseAcceleration { acceleration: copies.of(&self.acceleration), mass: self.mass.clone() })
    }
}
