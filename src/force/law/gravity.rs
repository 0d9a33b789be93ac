//! Weight: f = m g on every node (thesis Eq. 5), energy -m g . (x - x_start).
//!
//! The energy is counted from the displacement, so that an origin far away costs no digits. Fixed nodes have no
//! weight here: their support carries it and nothing moves.

use crate::force::kernel::batch::{Records, Summand, Wants};
use crate::force::kernel::element_block::ElementBlock;
use crate::force::kernel::local_buffer::{PaddedVec3, rows};
use crate::force::{ForceTerm, NodeState, TangentSink};
use crate::model::forces::{Role, Tally};
use crate::model::quad::{self, Quad, VectorUnit};
use crate::model::system::{TermInfo, Weights};
use nalgebra::Vector3;
use std::sync::Arc;

/// Uniform gravity.
#[derive(Clone, Debug)]
pub struct Gravity {
    /// [m/s^2] acceleration of free fall
    g: Vector3<f64>,
    /// [kg] mass of every node, 0 where it is held in all directions
    mass: Vec<f64>,
    /// [m] node positions from which the energy counts
    origin: Arc<[Vector3<f64>]>,
}

impl Gravity {
    /// Masses [kg] in the acceleration of free fall `g` [m/s^2]; `origin` are the node positions [m] from which the
    /// energy counts.
    pub fn new(g: Vector3<f64>, mass: impl Iterator<Item = f64>, origin: Arc<[Vector3<f64>]>) -> Self {
        Gravity { g, mass: mass.collect(), origin }
    }
}

/// Nodes whose energies are summed before they are added to the others: sums of sums lose fewer digits.
const BLOCK: usize = 64;

/// f += m g; its output is -g . sum of m (x - origin).
struct Weigh<'a> {
    g: Vector3<f64>,
    mass: &'a [f64],
    origin: &'a [Vector3<f64>],
    x: &'a [PaddedVec3],
    f: &'a mut [PaddedVec3],
}

impl quad::Pass for Weigh<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<U: VectorUnit>(self, unit: U) -> f64 {
        let g = unit.quad([self.g.x, self.g.y, self.g.z, 0.0]);
        let mut energy = 0.0;
        let blocks = self.f.chunks_mut(BLOCK).zip(self.x.chunks(BLOCK));
        for ((f, x), (mass, origin)) in blocks.zip(self.mass.chunks(BLOCK).zip(self.origin.chunks(BLOCK))) {
            let ((f, f_last), (x, x_last)) = (f.as_chunks_mut::<4>(), x.as_chunks::<4>());
            let ((mass, mass_last), (origin, origin_last)) = (mass.as_chunks::<4>(), origin.as_chunks::<4>());
            let mut moments = unit.splat(0.0);
            for ((f, x), (mass, origin)) in f.iter_mut().zip(x).zip(mass.iter().zip(origin)) {
                let [a, b, c, d] = origins(unit, origin);
                let m = mass.map(|m| unit.splat(m));
                let sum = m[0] * (unit.quad(x[0]) - a) + m[1] * (unit.quad(x[1]) - b);
                let sum = sum + (m[2] * (unit.quad(x[2]) - c) + m[3] * (unit.quad(x[3]) - d));
                moments = moments + sum;
                for (f, m) in f.iter_mut().zip(m) {
                    *f = (unit.quad(*f) + m * g).numbers();
                }
            }
            for ((f, x), (mass, from)) in f_last.iter_mut().zip(x_last).zip(mass_last.iter().zip(origin_last)) {
                let m = unit.splat(*mass);
                moments = moments + m * (unit.quad(*x) - unit.quad([from.x, from.y, from.z, 0.0]));
                *f = (unit.quad(*f) + m * g).numbers();
            }
            let [x, y, z, _] = moments.numbers();
            energy -= self.g.dot(&Vector3::new(x, y, z));
        }
        energy
    }
}

/// Four nodes' positions; the last number of each means nothing.
#[inline(always)]
fn origins<U: VectorUnit>(unit: U, nodes: &[Vector3<f64>; 4]) -> [U::Quad; 4] {
    let numbers: &[f64; 12] = bytemuck::cast_ref(nodes);
    let at = |first: usize| numbers[first..].first_chunk().copied().unwrap_or_default();
    [at(0), at(3), at(6), [nodes[3].x, nodes[3].y, nodes[3].z, 0.0]].map(|n| unit.quad(n))
}

impl Summand for Gravity {
    fn elements(&self) -> usize {
        self.mass.len()
    }

    fn wants(&self) -> Wants {
        Wants { x: true, v: false }
    }

    fn add(&self, block: &ElementBlock<'_>, f: &mut Records) -> Tally {
        let own = block.own.clone();
        let mass = &self.mass[own.clone()];
        let origin = &self.origin[own.clone()];
        let x = &block.x.as_chunks().0[..own.len()];
        Tally { energy: quad::run(Weigh { g: self.g, mass, origin, x, f: rows(f, own.len()) }), power: 0.0 }
    }
}

impl ForceTerm for Gravity {
    fn info(&self) -> TermInfo {
        TermInfo::of("gravity", Role::Gravity)
    }

    fn symmetric(&self) -> bool {
        true
    }

    fn tangent(&self, _at: NodeState<'_>, _w: Weights, _sink: &mut dyn TangentSink) {}
}
