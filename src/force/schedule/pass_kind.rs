//! What a pass does in a block: which terms it evaluates, and which sums it gives.

use crate::force::kernel::element_block::ElementBlock;
use crate::force::kernel::local_buffer::{PaddedVec3, Records, rows, rows_of, sum_rows};
use crate::force::schedule::sweep::Terms;
use crate::force::schedule::threads::SUMS;
use crate::model::forces::Tally;

/// Which sums a pass gives, and whether forces that depend on position only are stored or reused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::force) enum PassKind {
    /// every sum
    Full,
    /// the first sum alone, which gets all forces; what depends on position only is kept
    TotalOnly,
    /// every sum; forces and energies that depend on position only were kept
    ReusePosition,
}

impl PassKind {
    /// Whether the terms of a sum are gone over.
    pub fn goes_over(self, sum: usize) -> bool {
        self != PassKind::ReusePosition || sum > 0
    }

    /// Number of sums.
    pub fn sums(self) -> usize {
        if self == PassKind::TotalOnly { 1 } else { SUMS }
    }
}

/// A block's local buffers of forces [N].
pub(in crate::force) struct Sums<'a> {
    /// records that are used
    pub n: usize,
    pub sums: [&'a mut Records; SUMS],
    /// which of them are there
    pub present: [bool; SUMS],
    /// what own terms of the first sum give to it
    pub kept: &'a mut [PaddedVec3],
}

impl Sums<'_> {
    /// Leaves in the local buffers what the terms add to the nodes of a block, and returns their energies and powers.
    /// Where terms of the first sum are gone over, it holds zeros before.
    pub fn add<T: Terms + ?Sized>(
        &mut self,
        terms: &T,
        kind: PassKind,
        block: &ElementBlock<'_>,
        tallies: &mut [Tally],
    ) {
        let n = self.n;
        let [total, others @ ..] = &mut self.sums;
        let is_told = |other: usize| self.present[other + 1] && kind != PassKind::TotalOnly;
        for (_, other) in others.iter_mut().enumerate().filter(|(i, _)| is_told(*i)) {
            rows(other, n).fill(PaddedVec3::default());
        }
        if kind.goes_over(0) {
            for (i, tally) in tallies.iter_mut().enumerate() {
                if let (term, 0) = terms.term(i) {
                    *tally = term.add(block, total);
                }
            }
        }
        if kind == PassKind::TotalOnly && terms.is_position_only() {
            self.kept.copy_from_slice(rows(total, n));
        }
        for (i, tally) in tallies.iter_mut().enumerate() {
            if let (term, sum @ 1..) = terms.term(i) {
                *tally = term.add(block, if is_told(sum - 1) { others[sum - 1] } else { total });
            }
        }
        let kept = (kind == PassKind::ReusePosition).then_some(&*self.kept);
        let others = std::array::from_fn(|i| if is_told(i) { rows_of(others[i], n) } else { &[] });
        sum_rows(rows(total, n), kept, others);
    }
}
