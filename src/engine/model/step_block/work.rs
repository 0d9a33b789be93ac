//! The work of forces along the motion of their nodes.
//!
//! ```text
//! 1/2 (f_n + f_{n+1}) . (x_{n+1} - x_n)
//! ```
//! The two halves are separate sums: in a block of steps, the first is computed when a step begins, and the other when
//! it ends.

use super::groups::{begun, columns, filled, groups};
use crate::model::motion::BLOCK;
use crate::model::quad::{self, Quad, VectorUnit};

/// [J] Sums of f . (x - x_from) for each of the forces [N]; vectors [m] have `W` numbers per node: three, and possibly
/// a fourth that is 0.
pub fn work<const W: usize, const N: usize>(forces: [&[f64]; N], from: &[f64], x: &[f64]) -> [f64; N] {
    quad::run(Pass::<W, N> { forces, from, x })
}

struct Pass<'a, const W: usize, const N: usize> {
    forces: [&'a [f64]; N],
    from: &'a [f64],
    x: &'a [f64],
}

impl<const W: usize, const N: usize> quad::Pass for Pass<'_, W, N> {
    type Output = [f64; N];

    #[inline(always)]
    fn run<U: VectorUnit>(self, unit: U) -> [f64; N] {
        let mut sums = Sums::<U::Quad, N>::new(unit);
        let n = W * BLOCK;
        for (block, (from, x)) in self.from.chunks(n).zip(self.x.chunks(n)).enumerate() {
            let (from, from_last) = groups::<W>(from);
            let (x, x_last) = groups::<W>(x);
            for (place, force) in self.forces.into_iter().enumerate() {
                let force = force.get(n * block..).unwrap_or_default();
                let (force, force_last) = groups::<W>(&force[..force.len().min(n)]);
                for (force, (from, x)) in force.iter().zip(from.iter().zip(x)) {
                    sums.add(place, along::<U, W>(unit, force, &way(unit, [from, x])));
                }
                if !force_last.is_empty() {
                    let [from, x] = [from_last, x_last].map(filled::<W>);
                    sums.add(place, along::<U, W>(unit, &begun(force_last), &way(unit, [&from, &x])));
                }
            }
            sums.end_block(unit);
        }
        sums.sums()
    }
}

/// Sums over nodes that are added four by four, block after block.
pub(super) struct Sums<Q, const N: usize> {
    /// sums of whole blocks
    sums: [f64; N],
    block: [Q; N],
}

impl<Q: Quad, const N: usize> Sums<Q, N> {
    #[inline(always)]
    pub(super) fn new<U: VectorUnit<Quad = Q>>(unit: U) -> Self {
        Sums { sums: [0.0; N], block: [unit.splat(0.0); N] }
    }

    /// Adds four nodes to one of the sums.
    #[inline(always)]
    pub(super) fn add(&mut self, place: usize, four: Q) {
        self.block[place] = self.block[place] + four;
    }

    /// Called after the last four of every block of [`BLOCK`] nodes, and of all.
    #[inline(always)]
    pub(super) fn end_block<U: VectorUnit<Quad = Q>>(&mut self, unit: U) {
        for (sum, block) in self.sums.iter_mut().zip(&mut self.block) {
            let [a, b, c, d] = block.numbers();
            *sum += (a + b) + (c + d);
            *block = unit.splat(0.0);
        }
    }

    #[inline(always)]
    pub(super) fn sums(self) -> [f64; N] {
        self.sums
    }
}

#[inline(always)]
fn way<U: VectorUnit, const W: usize>(unit: U, [from, x]: [&[[f64; 4]; W]; 2]) -> [U::Quad; W] {
    let mut way = [unit.splat(0.0); W];
    for i in 0..W {
        way[i] = unit.quad(x[i]) - unit.quad(from[i]);
    }
    way
}

/// [J] f . d of four nodes.
#[inline(always)]
pub(super) fn along<U: VectorUnit, const W: usize>(unit: U, force: &[[f64; 4]; W], way: &[U::Quad; W]) -> U::Quad {
    let mut products = [unit.splat(0.0); W];
    for i in 0..W {
        products[i] = unit.quad(force[i]) * way[i];
    }
    let [x, y, z] = columns::<U::Quad, W>(products);
    x + y + z
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::quad::{Pass as _, Portable};

    fn vectors<const W: usize>(nodes: usize, phase: f64) -> Vec<f64> {
        let number = |i: usize| if i % W < 3 { (0.7 * (3 * (i / W) + i % W) as f64 + phase).sin() } else { 0.0 };
        (0..W * nodes).map(number).collect()
    }

    fn found<const W: usize>(nodes: usize) -> [f64; 2] {
        let [f, g, from, x] = [0.0, 1.0, 2.0, 3.0].map(|phase| vectors::<W>(nodes, phase));
        let pass = || Pass::<W, 2> { forces: [&f, &g], from: &from, x: &x };
        assert_eq!(pass().run(Portable), quad::run(pass()), "{nodes} nodes");
        assert_eq!(work::<W, 1>([&g], &from, &x), [quad::run(pass())[1]]);
        work::<W, 2>([&f, &g], &from, &x)
    }

    /// Packed vectors and records give the same bits, on any machine, and the value of a plain loop.
    #[test]
    fn work_is_that_of_a_plain_loop() {
        for nodes in (0..10).chain([63, 64, 65, 130, 1000]) {
            let [f, g, from, x] = [0.0, 1.0, 2.0, 3.0].map(|phase| vectors::<3>(nodes, phase));
            let plain = |f: &[f64]| f.iter().zip(from.iter().zip(&x)).map(|(f, (from, x))| f * (x - from)).sum::<f64>();
            let found = [found::<3>(nodes), found::<4>(nodes)];
            assert_eq!(found[0], found[1], "{nodes} nodes");
            for (found, expected) in found[0].into_iter().zip([plain(&f), plain(&g)]) {
                assert!((found - expected).abs() < 1e-14 * (1.0 + nodes as f64), "{nodes} nodes: {found}, {expected}");
            }
        }
    }
}
