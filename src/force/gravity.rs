//! Weight: f = m g on every node (thesis Eq. 5), energy -m g . (x - x_start).
//!
//! The energy is counted from the displacement, so that an origin far away costs no digits. Fixed nodes have no
//! weight here: their support carries it and nothing moves.

use super::batch::{Threads, lane_sum};
use super::{ForceTerm, NodeState, TangentSink};
use crate::model::forces::{Role, Tally};
use crate::model::system::{TermInfo, Weights};
use glam::DVec3;
use std::sync::Arc;

/// Uniform gravity.
#[derive(Clone, Debug)]
pub struct Gravity {
    /// [m/s^2] acceleration of free fall
    pub g: DVec3,
    /// [kg] mass of every node, 0 where it is held in all directions
    pub mass: Arc<[f64]>,
    /// [m] node positions from which the energy counts
    pub origin: Arc<[DVec3]>,
}

impl ForceTerm for Gravity {
    fn info(&self) -> TermInfo {
        TermInfo { name: "gravity", role: Role::Gravity }
    }

    fn elements(&self) -> usize {
        self.mass.len()
    }

    fn velocity_dependent(&self) -> bool {
        false
    }

    fn symmetric(&self) -> bool {
        true
    }

    fn add(&self, at: NodeState<'_>, _threads: &Threads, f: &mut [DVec3]) -> Tally {
        let mut energy = 0.0;
        let mut buffer = [0.0; 64];
        for (((f, x), m), origin) in
            f.chunks_mut(64).zip(at.x.chunks(64)).zip(self.mass.chunks(64)).zip(self.origin.chunks(64))
        {
            let buffer = &mut buffer[..m.len()];
            for ((((f, x), m), origin), e) in f.iter_mut().zip(x).zip(m).zip(origin).zip(buffer.iter_mut()) {
                *f += *m * self.g;
                *e = -m * self.g.dot(*x - *origin);
            }
            energy += lane_sum(buffer);
        }
        Tally { energy, power: 0.0 }
    }

    fn tangent(&self, _at: NodeState<'_>, _w: Weights, _sink: &mut dyn TangentSink) {}
}
