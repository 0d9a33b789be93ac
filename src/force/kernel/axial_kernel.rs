//! Two-node elements that pull along a difference: springs along `xb - xa`, dashpots along `vb - va`.
//!
//! ```text
//! d = ub - ua      force on a = s d, on b = -s d
//! ```
//! To add such a force, write a [`AxialLaw`]: s and the energy or power from d^2 and two numbers of the element, as
//! equations on four elements at once, and an [`crate::force::kernel::edges::EdgeKernel`].

use crate::force::kernel::coefficient::{Column, Place};
use crate::force::kernel::edges::Edges;
use crate::force::kernel::lane_batches::{LaneKernel, add};
use crate::force::kernel::local_buffer::{PaddedVec3, Records, record, set_record};
use crate::force::kernel::star_batches::add_stars;
use crate::model::lanes::LANES;
use crate::model::quad::{Quad, VectorUnit};

/// How elements pull.
pub(in crate::force) trait AxialLaw {
    /// Four elements by their two numbers and the squares d^2 of their differences; `#[inline(always)]`.
    fn pull<U: VectorUnit>(&self, unit: U, numbers: [U::Quad; 2], square: U::Quad) -> Pull<U::Quad>;
}

/// What four elements do.
#[derive(Clone, Copy, Debug)]
pub(in crate::force) struct Pull<Q> {
    /// [N/m or N s/m] force on node a by difference
    pub scale: Q,
    /// [J] or [W] energy or power
    pub amount: Q,
}

/// Adds the forces [N] of a block's elements to its local buffer; `u` is the nodal vector of the differences.
pub(in crate::force) fn pull<L: AxialLaw>(law: &L, edges: &Edges<'_>, u: &Records, f: &mut Records) -> f64 {
    let (others, numbers) = edges.others();
    add_stars(law, edges.stars(), u, f) + add(Pulling { law, numbers, u }, others, f)
}

struct Pulling<'a, L> {
    law: &'a L,
    numbers: [Column<'a>; 2],
    u: &'a Records,
}

#[derive(Clone, Copy, Default)]
#[repr(align(32))]
struct Kept {
    d: [PaddedVec3; LANES],
    scale: [PaddedVec3; 2],
}

impl<L: AxialLaw> LaneKernel<2> for Pulling<'_, L> {
    type Kept = Kept;
    type Chunk = [Kept; 1];

    #[inline(always)]
    fn measure<U: VectorUnit>(&self, unit: U, at: Place, nodes: &[[u16; 2]; LANES], kept: &mut Kept) -> U::Quad {
        let mut d = [unit.splat(0.0); 4];
        for j in 0..4 {
            let [a, b] = nodes[4 * at.half + j];
            d[j] = unit.quad(record(self.u, b)) - unit.quad(record(self.u, a));
            kept.d[4 * at.half + j] = d[j].numbers();
        }
        let [x, y, z] = U::Quad::columns(d);
        let numbers = [self.numbers[0].quad(unit, at.quad()), self.numbers[1].quad(unit, at.quad())];
        let Pull { scale, amount } = self.law.pull(unit, numbers, x * x + y * y + z * z);
        kept.scale[at.half] = scale.numbers();
        amount
    }

    #[inline(always)]
    fn scatter<U: VectorUnit>(&self, unit: U, nodes: &[[u16; 2]], kept: &Kept, f: &mut Records) {
        for (j, &[a, b]) in nodes.iter().enumerate().take(LANES) {
            let force = unit.splat(kept.scale[j / 4][j % 4]) * unit.quad(kept.d[j]);
            set_record(f, a, (unit.quad(record(f, a)) + force).numbers());
            set_record(f, b, (unit.quad(record(f, b)) - force).numbers());
        }
    }
}

#[cfg(test)]
pub(in crate::force) mod tests {
    use super::*;
    use crate::force::kernel::lane_batches::tests::{elements, on_both, random, vectors};

    /// Pulls with given forces [N], the first numbers, once the second ones are taken off.
    pub struct Law;

    impl AxialLaw for Law {
        #[inline(always)]
        fn pull<U: VectorUnit>(&self, _: U, [force, less]: [U::Quad; 2], square: U::Quad) -> Pull<U::Quad> {
            let (l, force) = (square.sqrt(), force - less);
            Pull { scale: (force / l).where_positive(l), amount: force * l }
        }
    }

    /// [N] of which [`Law`] takes this off
    pub const LESS: [[f64; 4]; 3] = [[0.25; 4]; 3];

    /// Values in whole blocks, as columns have them.
    pub fn blocks(values: &[f64]) -> Vec<[f64; 4]> {
        let mut blocks = vec![[0.0; 4]; 2 * values.len().div_ceil(LANES)];
        blocks.as_flattened_mut()[..values.len()].copy_from_slice(values);
        blocks
    }

    /// The same, written as one would: an element after the other, their amounts in eight lanes.
    fn one_by_one(force: &[f64], nodes: &[[u16; 2]], u: &Records, f: &mut Records) -> [f64; LANES] {
        let mut lanes = [0.0; LANES];
        for (i, (&[a, b], force)) in nodes.iter().zip(force).enumerate() {
            let (xa, xb) = (record(u, a), record(u, b));
            let d = [xb[0] - xa[0], xb[1] - xa[1], xb[2] - xa[2]];
            let l = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
            let scale = if l > 0.0 { force / l } else { 0.0 };
            let (fa, w) = (record(f, a), d.map(|d| scale * d));
            set_record(f, a, [fa[0] + w[0], fa[1] + w[1], fa[2] + w[2], 0.0]);
            let fb = record(f, b);
            set_record(f, b, [fb[0] - w[0], fb[1] - w[1], fb[2] - w[2], 0.0]);
            lanes[if i < nodes.len() / LANES * LANES { i % LANES } else { 0 }] += force * l;
        }
        lanes
    }

    #[test]
    fn all_units_add_what_a_plain_loop_adds_in_its_order() {
        // Around a block, a chunk, and more than one chunk.
        for n in (0..20).chain([127, 128, 129, 300]) {
            let (nodes, mut window) = (elements::<2>(n, 1), vectors(2));
            let force: Vec<f64> = std::iter::repeat_with(random(3)).take(n).collect();
            let (u, in_blocks) = (&*window.records(), blocks(&force));
            let numbers = [Column::each(&in_blocks), Column::uniform(&LESS)];
            let [best, portable] = on_both(|| Pulling { law: &Law, numbers, u }, &nodes);
            assert_eq!(best, portable, "{n} elements");
            let mut f = crate::force::kernel::local_buffer::LocalBuffer::new(0);
            let force: Vec<f64> = force.iter().map(|force| force - LESS[0][0]).collect();
            let l = one_by_one(&force, &nodes, u, f.records());
            let sums = crate::force::kernel::local_buffer::rows(f.records(), best.0.len());
            let plain: Vec<_> = sums.iter().map(|r| [r[0], r[1], r[2]].map(f64::to_bits)).collect();
            assert_eq!(best.0, plain, "{n} elements");
            let sum = ((l[0] + l[4]) + (l[2] + l[6])) + ((l[1] + l[5]) + (l[3] + l[7]));
            assert_eq!(best.1, sum.to_bits(), "{n} elements");
        }
    }
}
