//! What a pass does in a tile: which terms it goes over, and which sums it tells.

use crate::force::kernel::element_block::Tile;
use crate::force::kernel::local_buffer::{Padded, Records, rows, rows_of, sum_rows};
use crate::force::schedule::sweep::Terms;
use crate::force::schedule::threads::SUMS;
use crate::model::forces::Tally;

/// Which sums a pass tells, and what becomes of the first one's own terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::force) enum Told {
    /// every sum
    All,
    /// the first alone; what its own terms give to it is kept, if they are still
    First,
    /// every sum; what the first one's own terms give was kept, and so were their energies
    AllWithKept,
}

impl Told {
    /// Whether the terms of a sum are gone over.
    pub fn goes_over(self, sum: usize) -> bool {
        self != Told::AllWithKept || sum > 0
    }

    /// How many sums are told.
    pub fn sums(self) -> usize {
        if self == Told::First { 1 } else { SUMS }
    }
}

/// A tile's windows of forces [N].
pub(in crate::force) struct Sums<'a> {
    /// records that are used
    pub n: usize,
    pub sums: [&'a mut Records; SUMS],
    /// which of them are there
    pub present: [bool; SUMS],
    /// what own terms of the first sum give to it
    pub kept: &'a mut [Padded],
}

impl Sums<'_> {
    /// Leaves in the windows what the terms add to the nodes of a tile, and tells their energies and powers. Where
    /// terms of the first sum are gone over, it holds zeros before.
    pub fn add<T: Terms + ?Sized>(&mut self, terms: &T, told: Told, tile: &Tile<'_>, tallies: &mut [Tally]) {
        let n = self.n;
        let [total, others @ ..] = &mut self.sums;
        let is_told = |other: usize| self.present[other + 1] && told != Told::First;
        for (_, other) in others.iter_mut().enumerate().filter(|(i, _)| is_told(*i)) {
            rows(other, n).fill(Padded::default());
        }
        if told.goes_over(0) {
            for (i, tally) in tallies.iter_mut().enumerate() {
                if let (term, 0) = terms.term(i) {
                    *tally = term.add(tile, total);
                }
            }
        }
        if told == Told::First && terms.still() {
            self.kept.copy_from_slice(rows(total, n));
        }
        for (i, tally) in tallies.iter_mut().enumerate() {
            if let (term, sum @ 1..) = terms.term(i) {
                *tally = term.add(tile, if is_told(sum - 1) { others[sum - 1] } else { total });
            }
        }
        let kept = (told == Told::AllWithKept).then_some(&*self.kept);
        let others = std::array::from_fn(|i| if is_told(i) { rows_of(others[i], n) } else { &[] });
        sum_rows(rows(total, n), kept, others);
    }
}
