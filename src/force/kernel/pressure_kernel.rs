//! Triangles that are pushed along their normal: the air, and pressure that follows the cloth.
//!
//! ```text
//! S = 1/2 (x1 - x0) x (x2 - x0) = A N,      a vertex gets p S
//! ```
//! To add such a force, write a [`PressureLaw`]: p and the energy or power from S and the vertex velocities, as
//! equations on four triangles at once, and a [`crate::force::kernel::faces::FaceKernel`].

use crate::force::kernel::coefficient::Place;
use crate::force::kernel::faces::Faces;
use crate::force::kernel::lane_batches::{LaneKernel, add};
use crate::force::kernel::local_buffer::{PaddedVec3, Records, record, set_record};
use crate::force::kernel::triangle_pairs::{area, numbers, push_pairs, quads, scaled};
use crate::model::lanes::LANES;
use crate::model::quad::{Quad, VectorUnit};

/// How triangles are pushed.
pub(in crate::force) trait PressureLaw {
    /// Four triangles with the components of S [m^2] and of the sums [m/s] of their vertices' velocities;
    /// `#[inline(always)]`.
    fn push<U: VectorUnit>(&self, unit: U, s: [U::Quad; 3], v: [U::Quad; 3]) -> Push<U::Quad>;
}

/// What happens to four triangles.
#[derive(Clone, Copy, Debug)]
pub(in crate::force) struct Push<Q> {
    /// [Pa] a vertex's share of the pressure
    pub share: Q,
    /// [W] power
    pub amount: Q,
}

/// Adds the forces [N] of a block's triangles to its local buffer.
pub(in crate::force) fn push<L: PressureLaw>(law: &L, faces: &Faces<'_>, f: &mut Records) -> f64 {
    let &Faces { x, v, pairs, others, .. } = faces;
    push_pairs(law, pairs, [x, v], f) + add(Pushing { law, x, v }, others, f)
}

struct Pushing<'a, L> {
    law: &'a L,
    x: &'a Records,
    v: &'a Records,
}

/// Of both halves of a block, component by component.
#[derive(Clone, Copy, Default)]
#[repr(align(32))]
struct Kept {
    /// S, and at last the force on each vertex
    s: [[PaddedVec3; 3]; 2],
    /// sums of the vertices' velocities
    v: [[PaddedVec3; 3]; 2],
}

impl<L: PressureLaw> LaneKernel<3> for Pushing<'_, L> {
    type Kept = Kept;
    type Chunk = [Kept; 1];

    #[inline(always)]
    fn measure<U: VectorUnit>(&self, unit: U, at: Place, nodes: &[[u16; 3]; LANES], kept: &mut Kept) -> U::Quad {
        let zero = unit.splat(0.0);
        let (mut a, mut b, mut v) = ([zero; 4], [zero; 4], [zero; 4]);
        for t in 0..4 {
            let [i, j, k] = nodes[4 * at.half + t];
            let x = unit.quad(record(self.x, i));
            (a[t], b[t]) = (unit.quad(record(self.x, j)) - x, unit.quad(record(self.x, k)) - x);
            v[t] = unit.quad(record(self.v, i)) + unit.quad(record(self.v, j)) + unit.quad(record(self.v, k));
        }
        kept.s[at.half] = numbers(area(unit, U::Quad::columns(a), U::Quad::columns(b)));
        kept.v[at.half] = numbers(U::Quad::columns(v));
        unit.splat(0.0)
    }

    #[inline(always)]
    fn finish<U: VectorUnit>(&self, unit: U, half: usize, kept: &mut Kept) -> U::Quad {
        let (s, v) = (quads(unit, &kept.s[half]), quads(unit, &kept.v[half]));
        let Push { share, amount } = self.law.push(unit, s, v);
        kept.s[half] = numbers(scaled(share, s));
        amount
    }

    #[inline(always)]
    fn scatter<U: VectorUnit>(&self, unit: U, nodes: &[[u16; 3]], kept: &Kept, f: &mut Records) {
        for (nodes, force) in nodes.chunks(4).zip(&kept.s) {
            let forces = U::Quad::rows(quads(unit, force));
            for (nodes, force) in nodes.iter().zip(forces) {
                for &node in nodes {
                    set_record(f, node, (unit.quad(record(f, node)) + force).numbers());
                }
            }
        }
    }
}

#[cfg(test)]
pub(in crate::force) mod tests {
    use super::*;
    use crate::force::kernel::element_block::vector;
    use crate::force::kernel::lane_batches::tests::{NODES, elements, on_both, vectors};
    use nalgebra::Vector3;

    /// Pressure 2 Pa, a third to each vertex.
    pub struct Law;

    impl PressureLaw for Law {
        #[inline(always)]
        fn push<U: VectorUnit>(&self, unit: U, s: [U::Quad; 3], v: [U::Quad; 3]) -> Push<U::Quad> {
            let share = unit.splat(2.0 / 3.0);
            Push { share, amount: share * (s[0] * v[0] + s[1] * v[1] + s[2] * v[2]) }
        }
    }

    /// Forces [N] of [`Law`] by node, and its power, written as one would: a triangle after the other.
    pub fn one_by_one(triangles: &[[u16; 3]], [x, v]: [&Records; 2]) -> (Vec<Vector3<f64>>, f64) {
        let (mut forces, mut power) = (vec![Vector3::zeros(); NODES], 0.0);
        for nodes in triangles {
            let [a, b, c] = nodes.map(|i| vector(x, i));
            let s = 0.5 * (b - a).cross(&(c - a));
            for &node in nodes {
                forces[node as usize / 4] += 2.0 / 3.0 * s;
                power += 2.0 / 3.0 * s.dot(&vector(v, node));
            }
        }
        (forces, power)
    }

    #[test]
    fn all_units_push_along_the_area_vector() {
        for n in (0..20).chain([127, 128, 129, 300]) {
            let (nodes, mut x, mut v) = (elements::<3>(n, 4), vectors(5), vectors(6));
            let (x, v) = (&*x.records(), &*v.records());
            let [best, portable] = on_both(|| Pushing { law: &Law, x, v }, &nodes);
            assert_eq!(best, portable, "{n} triangles");
            let (forces, power) = one_by_one(&nodes, [x, v]);
            for (found, force) in best.0.iter().zip(&forces) {
                let found = Vector3::from(found.map(f64::from_bits));
                assert!((found - *force).norm() < 1e-13, "{n} triangles: {found} against {force}");
            }
            assert!((f64::from_bits(best.1) - power).abs() < 1e-12, "{n} triangles: {power}");
        }
    }
}
