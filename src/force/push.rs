//! Triangles that are pushed along their normal: the air.
//!
//! ```text
//! S = 1/2 (x1 - x0) x (x2 - x0) = A N,      a vertex gets p S
//! ```
//! To add such a force, write a [`PushLaw`]: p and the energy or power from S and the vertex velocities, as equations on four numbers at once.

use super::coefficient::Place;
use super::phases::{Phases, add};
use super::tile::Elements;
use super::window::{Padded, Records, record, set_record};
use crate::model::lanes::LANES;
use crate::model::quad::{Quad, VectorUnit};

/// How triangles are pushed.
pub(super) trait PushLaw {
    /// Four triangles with the components of S [m^2] and of the sums [m/s] of their vertices' velocities; `#[inline(always)]`.
    fn push<U: VectorUnit>(&self, unit: U, s: [U::Quad; 3], v: [U::Quad; 3]) -> Push<U::Quad>;
}

/// What happens to four triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Push<Q> {
    /// [Pa] a vertex's share of the pressure
    pub share: Q,
    /// [W] power
    pub amount: Q,
}

/// Adds the forces [N] of a tile's triangles to its window.
pub(super) fn push<L: PushLaw>(law: L, tile: Elements<'_, 3>, f: &mut Records) -> f64 {
    add(Pushing { law, x: tile.x, v: tile.v }, tile.nodes, f)
}

struct Pushing<'a, L> {
    law: L,
    x: &'a Records,
    v: &'a Records,
}

/// Of both halves of a block, component by component.
#[derive(Clone, Copy, Default)]
#[repr(align(32))]
struct Kept {
    /// S, and at last the force on each vertex
    s: [[Padded; 3]; 2],
    /// sums of the vertices' velocities
    v: [[Padded; 3]; 2],
}

impl<L: PushLaw> Phases<3> for Pushing<'_, L> {
    type Kept = Kept;
    type Chunk = [Kept; 4];

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
        let (a, b, half) = (U::Quad::columns(a), U::Quad::columns(b), unit.splat(0.5));
        let s = [
            half * (a[1] * b[2] - a[2] * b[1]),
            half * (a[2] * b[0] - a[0] * b[2]),
            half * (a[0] * b[1] - a[1] * b[0]),
        ];
        kept.s[at.half] = s.map(Quad::numbers);
        kept.v[at.half] = U::Quad::columns(v).map(Quad::numbers);
        unit.splat(0.0)
    }

    #[inline(always)]
    fn finish<U: VectorUnit>(&self, unit: U, half: usize, kept: &mut Kept) -> U::Quad {
        let [x, y, z] = kept.s[half];
        let s = [unit.quad(x), unit.quad(y), unit.quad(z)];
        let [x, y, z] = kept.v[half];
        let Push { share, amount } = self.law.push(unit, s, [unit.quad(x), unit.quad(y), unit.quad(z)]);
        kept.s[half] = [(share * s[0]).numbers(), (share * s[1]).numbers(), (share * s[2]).numbers()];
        amount
    }

    #[inline(always)]
    fn scatter<U: VectorUnit>(&self, unit: U, nodes: &[[u16; 3]], kept: &Kept, f: &mut Records) {
        for (nodes, &[x, y, z]) in nodes.chunks(4).zip(&kept.s) {
            let forces = U::Quad::rows([unit.quad(x), unit.quad(y), unit.quad(z)]);
            for (nodes, force) in nodes.iter().zip(forces) {
                for &node in nodes {
                    set_record(f, node, (unit.quad(record(f, node)) + force).numbers());
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force::phases::tests::{elements, on_both, vectors};
    use crate::force::tile::vector;

    /// Pressure 2 Pa, a third to each vertex.
    struct Law;

    impl PushLaw for Law {
        #[inline(always)]
        fn push<U: VectorUnit>(&self, unit: U, s: [U::Quad; 3], v: [U::Quad; 3]) -> Push<U::Quad> {
            let share = unit.splat(2.0 / 3.0);
            Push { share, amount: share * (s[0] * v[0] + s[1] * v[1] + s[2] * v[2]) }
        }
    }

    #[test]
    fn all_units_push_along_the_area_vector() {
        for n in (0..20).chain([127, 128, 129, 300]) {
            let (nodes, mut x, mut v) = (elements::<3>(n, 4), vectors(5), vectors(6));
            let (x, v) = (&*x.records(), &*v.records());
            let [best, portable] = on_both(|| Pushing { law: Law, x, v }, &nodes);
            assert_eq!(best, portable, "{n} triangles");
            let (mut forces, mut power) = (vec![glam::DVec3::ZERO; best.0.len()], 0.0);
            for nodes in &nodes {
                let [a, b, c] = nodes.map(|i| vector(x, i));
                let s = 0.5 * (b - a).cross(c - a);
                for &node in nodes {
                    forces[node as usize / 4] += 2.0 / 3.0 * s;
                    power += 2.0 / 3.0 * s.dot(vector(v, node));
                }
            }
            for (found, force) in best.0.iter().zip(&forces) {
                let found = glam::DVec3::from_array(found.map(f64::from_bits));
                assert!((found - *force).length() < 1e-13, "{n} triangles: {found} against {force}");
            }
            assert!((f64::from_bits(best.1) - power).abs() < 1e-12, "{n} triangles: {power}");
        }
    }
}
