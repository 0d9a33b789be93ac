//! Kinetic energy and largest speed of nodes.

use super::quad::{self, Quad, VectorUnit};

/// Kinetic energy and largest speed of nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// [J] sum of 1/2 m v^2
    pub kinetic: f64,
    /// [m^2/s^2] largest v^2; NaN is left out
    pub largest_square: f64,
}

/// The motion of nodes with velocities `v` [m/s] `[n_dof]` and masses [kg] `[n_nodes]`.
pub fn motion(v: &[f64], mass: &[f64]) -> Motion {
    quad::run(MotionPass { v, mass })
}

/// Number of nodes whose energies are summed before they are added to the others: sums of sums lose fewer digits.
pub(in crate::model) const BLOCK: usize = 64;

/// Sum of the motion of nodes, added four by four, block after block.
pub(super) struct MotionSum<Q> {
    /// [J] twice the kinetic energy of whole blocks
    doubled: f64,
    block: Q,
    largest: Q,
}

impl<Q: Quad> MotionSum<Q> {
    #[inline(always)]
    pub(super) fn new<U: VectorUnit<Quad = Q>>(unit: U) -> Self {
        MotionSum { doubled: 0.0, block: unit.splat(0.0), largest: unit.splat(0.0) }
    }

    /// Four nodes by their masses [kg] and the components of their velocities [m/s].
    #[inline(always)]
    pub(super) fn add(&mut self, mass: Q, [x, y, z]: [Q; 3]) {
        let squares = x * x + y * y + z * z;
        self.block = self.block + mass * squares;
        self.largest = squares.larger(self.largest);
    }

    /// Called after the last four of every block of [`BLOCK`] nodes, and of all.
    #[inline(always)]
    pub(super) fn end_block<U: VectorUnit<Quad = Q>>(&mut self, unit: U) {
        let [a, b, c, d] = self.block.numbers();
        self.doubled += (a + b) + (c + d);
        self.block = unit.splat(0.0);
    }

    #[inline(always)]
    pub(super) fn motion(self) -> Motion {
        let [a, b, c, d] = self.largest.numbers();
        Motion { kinetic: 0.5 * self.doubled, largest_square: a.max(b).max(c.max(d)) }
    }
}

struct MotionPass<'a> {
    v: &'a [f64],
    mass: &'a [f64],
}

impl quad::Pass for MotionPass<'_> {
    type Output = Motion;

    #[inline(always)]
    fn run<U: VectorUnit>(self, unit: U) -> Motion {
        let mut sum = MotionSum::new(unit);
        for (v, mass) in self.v.chunks(3 * BLOCK).zip(self.mass.chunks(BLOCK)) {
            let ((v, v_last), (mass, mass_last)) = (v.as_chunks::<12>(), mass.as_chunks::<4>());
            for (v, mass) in v.iter().zip(mass) {
                sum.add(unit.quad(*mass), columns(unit, v));
            }
            if !mass_last.is_empty() {
                let (mut v, mut mass) = ([0.0; 12], [0.0; 4]);
                v[..v_last.len()].copy_from_slice(v_last);
                mass[..mass_last.len()].copy_from_slice(mass_last);
                sum.add(unit.quad(mass), columns(unit, &v));
            }
            sum.end_block(unit);
        }
        sum.motion()
    }
}

/// The components of four nodes.
#[inline(always)]
fn columns<U: VectorUnit>(unit: U, v: &[f64; 12]) -> [U::Quad; 3] {
    let at = |first: usize| unit.quad(v[first..].first_chunk().copied().unwrap_or_default());
    U::Quad::unpack([at(0), at(4), at(8)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::quad::{Pass, Portable};

    /// The same bits for any number of nodes, on any machine.
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
            assert_eq!(found, MotionPass { v: &v, mass: &mass }.run(Portable));
        }
    }
}
