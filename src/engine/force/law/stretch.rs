//! The largest stretch l^2/l0^2 of springs, from which the largest strain is sqrt(l^2/l0^2) - 1: one division per
//! spring and no root. Springs without rest length do not count.

use crate::force::kernel::local_buffer::{Records, record};
use crate::model::quad::{self, Quad, Real, VectorUnit};

/// [m] The length that a strain is relative to: a spring without rest length has the strain 0 at every length.
#[inline(always)]
pub(in crate::force) fn strain_base(rest_length: f64) -> f64 {
    if rest_length > 0.0 { rest_length } else { f64::INFINITY }
}

/// Springs by their end nodes, and the positions of the nodes.
pub(in crate::force) struct SpringLengths<'a, E, P> {
    pub ends: &'a [[E; 2]],
    /// [m]
    pub rest_length: &'a [f64],
    /// [-] factor of all rest lengths
    pub rest_scale: f64,
    pub at: P,
}

/// Positions of nodes; its function is `#[inline(always)]`.
pub(in crate::force) trait Positions<E>: Copy {
    /// [m] the coordinates of a node, and an unused number
    fn of(&self, node: E) -> [f64; 4];
}

/// Positions of all nodes, `[n_dof]`.
#[derive(Clone, Copy)]
pub(in crate::force) struct WholeScene<'a>(pub &'a [f64]);

/// The records of a block.
#[derive(Clone, Copy)]
pub(in crate::force) struct InLocalBuffer<'a>(pub &'a Records);

impl Positions<u32> for WholeScene<'_> {
    #[inline(always)]
    fn of(&self, node: u32) -> [f64; 4] {
        let from = &self.0[3 * node as usize..];
        match from.first_chunk() {
            Some(four) => *four,
            None => [from[0], from[1], from[2], 0.0],
        }
    }
}

impl Positions<u16> for InLocalBuffer<'_> {
    #[inline(always)]
    fn of(&self, node: u16) -> [f64; 4] {
        record(self.0, node)
    }
}

/// [-] Largest l^2/l0^2, -inf without springs. The bits do not depend on how the springs are divided.
pub(in crate::force) fn largest<E: Copy, P: Positions<E>>(springs: SpringLengths<'_, E, P>) -> f64 {
    quad::run(springs)
}

impl<E: Copy, P: Positions<E>> quad::Pass for SpringLengths<'_, E, P> {
    type Output = f64;

    #[inline(always)]
    fn run<U: VectorUnit>(self, unit: U) -> f64 {
        let (ends, ends_last) = self.ends.as_chunks::<4>();
        let (l0, l0_last) = self.rest_length.as_chunks::<4>();
        let mut largest = unit.splat(f64::NEG_INFINITY);
        for (ends, l0) in ends.iter().zip(l0) {
            largest = self.four(unit, ends, *l0).larger(largest);
        }
        if let Some(&first) = ends_last.first() {
            let (mut ends, mut l0) = ([first; 4], [l0_last[0]; 4]);
            ends[..ends_last.len()].copy_from_slice(ends_last);
            l0[..l0_last.len()].copy_from_slice(l0_last);
            largest = self.four(unit, &ends, l0).larger(largest);
        }
        largest.numbers().into_iter().fold(f64::NEG_INFINITY, f64::max)
    }
}

impl<E: Copy, P: Positions<E>> SpringLengths<'_, E, P> {
    #[inline(always)]
    fn four<U: VectorUnit>(&self, unit: U, ends: &[[E; 2]; 4], l0: [f64; 4]) -> U::Quad {
        let mut d = [unit.splat(0.0); 4];
        for (d, &[a, b]) in d.iter_mut().zip(ends) {
            *d = unit.quad(self.at.of(b)) - unit.quad(self.at.of(a));
        }
        let (d, l0) = (U::Quad::columns(d), unit.quad(l0.map(strain_base)) * unit.splat(self.rest_scale));
        (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) / (l0 * l0)
    }
}
