//! What the nodes of a network are like: kinetic energy, speed, bounds, and whether all is finite.

use super::network::{Network, by_node};
use crate::model::bounds::Bounds;
use crate::model::quad::{self, Quad, VectorUnit};
use crate::model::stride::NodeSums;
use crate::model::workers::{ALONE, Workers};
use glam::DVec3;
use std::ops::Range;

impl Network {
    /// Of some nodes: their positions [m], velocities [m/s] and forces [N].
    pub(super) fn node_sums(&self, nodes: Range<usize>, [x, v, f]: [&[f64]; 3]) -> NodeSums {
        let bounds = bounds(by_node(x));
        let Motion { kinetic, largest_square } = motion(v, &self.mass[nodes]);
        let finite = ALONE.all_finite(f);
        NodeSums { kinetic, largest_square, bounds, finite }
    }
}

/// How nodes move.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Motion {
    /// [J] sum of 1/2 m v^2
    pub kinetic: f64,
    /// [m^2/s^2] largest v^2; one that is not a number is left out
    pub largest_square: f64,
}

/// Of nodes with velocities `v` [m/s], three a node, and masses [kg].
pub(super) fn motion(v: &[f64], mass: &[f64]) -> Motion {
    quad::run(Moving { v, mass })
}

/// Nodes whose energies are summed before they are added to the others: sums of sums lose fewer digits.
const BLOCK: usize = 64;

struct Moving<'a> {
    v: &'a [f64],
    mass: &'a [f64],
}

impl quad::Pass for Moving<'_> {
    type Output = Motion;

    #[inline(always)]
    fn run<U: VectorUnit>(self, unit: U) -> Motion {
        let (mut doubled, mut largest) = (0.0, unit.splat(0.0));
        for (v, mass) in self.v.chunks(3 * BLOCK).zip(self.mass.chunks(BLOCK)) {
            let ((v, v_last), (mass, mass_last)) = (v.as_chunks::<12>(), mass.as_chunks::<4>());
            let mut sum = unit.splat(0.0);
            for (v, mass) in v.iter().zip(mass) {
                let squares = squares(unit, v);
                sum = sum + unit.quad(*mass) * squares;
                largest = squares.larger(largest);
            }
            if !mass_last.is_empty() {
                let (mut v, mut mass) = ([0.0; 12], [0.0; 4]);
                v[..v_last.len()].copy_from_slice(v_last);
                mass[..mass_last.len()].copy_from_slice(mass_last);
                let squares = squares(unit, &v);
                sum = sum + unit.quad(mass) * squares;
                largest = squares.larger(largest);
            }
            let [a, b, c, d] = sum.numbers();
            doubled += (a + b) + (c + d);
        }
        let [a, b, c, d] = largest.numbers();
        Motion { kinetic: 0.5 * doubled, largest_square: a.max(b).max(c.max(d)) }
    }
}

/// v^2 of four nodes.
#[inline(always)]
fn squares<U: VectorUnit>(unit: U, v: &[f64; 12]) -> U::Quad {
    let at = |first: usize| v[first..].first_chunk().copied().unwrap_or_default();
    let rows: [[f64; 4]; 4] = [at(0), at(3), at(6), [v[9], v[10], v[11], 0.0]];
    let [a, b, c, d] = rows;
    let [x, y, z] = U::Quad::columns([unit.quad(a), unit.quad(b), unit.quad(c), unit.quad(d)]);
    x * x + y * y + z * z
}

/// [m] half the longest side of the box that nodes lie in
pub(super) fn extent(x: &[DVec3], workers: &Workers) -> f64 {
    workers.fold(x.len(), Bounds::default(), |r| bounds(&x[r]), Bounds::and).extent()
}

/// Coordinates that are no numbers may be left out.
fn bounds(x: &[DVec3]) -> Bounds {
    let (rows, rest) = x.as_chunks::<4>();
    let [low, high]: [[[f64; 3]; 4]; 2] = quad::run(Boxes(bytemuck::cast_slice(rows))).map(bytemuck::cast);
    let four = (0..4).map(|i| Bounds { low: low[i], high: high[i] });
    let last = rest.iter().map(|x| Bounds { low: x.to_array(), high: x.to_array() });
    four.chain(last).fold(Bounds::default(), Bounds::and)
}

/// Four nodes side by side, in three quads.
struct Boxes<'a>(&'a [[[f64; 4]; 3]]);

impl quad::Pass for Boxes<'_> {
    type Output = [[[f64; 4]; 3]; 2];

    #[inline(always)]
    fn run<U: VectorUnit>(self, unit: U) -> [[[f64; 4]; 3]; 2] {
        let mut low = [unit.splat(f64::INFINITY); 3];
        let mut high = [unit.splat(f64::NEG_INFINITY); 3];
        for row in self.0 {
            for i in 0..3 {
                let x = unit.quad(row[i]);
                (low[i], high[i]) = (x.smaller(low[i]), x.larger(high[i]));
            }
        }
        [low.map(Quad::numbers), high.map(Quad::numbers)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::quad::{Pass, Portable};

    /// Whatever the number of nodes, and on any machine the same bits.
    #[test]
    fn energy_and_speed_are_those_of_a_plain_loop() {
        for n in (0..10).chain([63, 64, 65, 1000]) {
            let v: Vec<f64> = (0..3 * n).map(|i| (0.7 * f64::from(i)).sin()).collect();
            let mass: Vec<f64> = (0..n).map(|i| 1.0 + f64::from(i % 5)).collect();
            let squares: Vec<f64> = v.chunks(3).map(|v| v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).collect();
            let kinetic: f64 = squares.iter().zip(&mass).map(|(s, m)| 0.5 * m * s).sum();
            let found = motion(&v, &mass);
            assert_eq!(found.largest_square, squares.iter().copied().fold(0.0, f64::max));
            assert!((found.kinetic - kinetic).abs() <= 1e-14 * kinetic, "{n} nodes: {} for {kinetic}", found.kinetic);
            assert_eq!(found, Moving { v: &v, mass: &mass }.run(Portable));
        }
    }
}
