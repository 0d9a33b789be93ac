//! The force terms of a pass, and where they add to.

use crate::force::kernel::batch::{BlockForces, PARTS};
use crate::force::kernel::element_block::ElementBlock;

/// A force term in a pass.
#[derive(Clone, Copy)]
pub(crate) struct Term<'a> {
    /// the term
    pub forces: &'a dyn BlockForces,
    /// the output of each of its parts; `None` = the part is left out
    pub parts: [Option<PartTarget>; PARTS],
}

/// The output of a part of a force term.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PartTarget {
    /// the sum of its forces: 0, 1 or 2
    pub sum: usize,
    /// index of its energy and power
    pub tally: usize,
}

/// The force terms of a pass.
pub(crate) trait Terms: Sync {
    /// Number of terms.
    fn count(&self) -> usize;

    /// Number of energies and powers: of all parts of all terms.
    fn tallies(&self) -> usize;

    /// A term.
    fn term(&self, i: usize) -> Term<'_>;

    /// Whether all terms of the first sum depend on position only, so that their forces do not change with velocities.
    fn is_position_only(&self) -> bool {
        false
    }

    /// [-] Largest l^2/l0^2 of all springs of a block, if wanted; otherwise, and without springs, -inf.
    fn largest_stretch(&self, block: &ElementBlock<'_>, wanted: bool) -> f64 {
        let terms = if wanted { 0..self.count() } else { 0..0 };
        terms.map(|i| self.term(i).forces.largest_stretch(block)).fold(f64::NEG_INFINITY, f64::max)
    }
}
