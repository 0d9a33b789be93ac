//! The kind of a pass: which terms it evaluates, and which sums it computes.

use crate::force::kernel::element_block::{ElementBlock, MOST_NUMBERS, NodeVectors, PassNumbers};
use crate::force::kernel::local_buffer::{PaddedVec3, Records, rows, rows_of, sum_rows};
use crate::force::schedule::terms::{PartTarget, Term, Terms};
use crate::force::schedule::threads::SUMS;
use crate::model::forces::Tally;

/// Which sums a pass computes, and whether forces that depend on position only are stored or reused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::force) enum PassKind {
    /// every sum
    Full,
    /// only the first sum, of all forces; forces that depend on position only are kept
    TotalOnly,
    /// every sum; forces and energies that depend on position only were kept
    ReusePosition,
}

impl PassKind {
    /// Whether the terms of a sum are evaluated.
    pub(crate) fn goes_over(self, sum: usize) -> bool {
        self != PassKind::ReusePosition || sum > 0
    }

    /// Number of sums.
    pub(crate) fn sums(self) -> usize {
        if self == PassKind::TotalOnly { 1 } else { SUMS }
    }
}

/// A block's local buffers of forces [N].
pub(in crate::force) struct Sums<'a> {
    /// records that are used
    pub n: usize,
    pub sums: [&'a mut Records; SUMS],
    /// which sums the scene has
    pub present: [bool; SUMS],
    /// forces of the terms of the first sum
    pub kept: &'a mut [PaddedVec3],
    pub numbers: PassNumbers<'a>,
}

impl Sums<'_> {
    /// Writes the sums of the terms for the nodes of a block to the local buffers, and their energies and powers to
    /// `tallies`. If the terms of the first sum are evaluated, its buffer must hold zeros before.
    pub(crate) fn add<T: Terms + ?Sized>(
        &mut self,
        terms: &T,
        kind: PassKind,
        block: &ElementBlock<'_>,
        tallies: &mut [Tally],
    ) {
        for (sum, _) in self.sums.iter_mut().zip(self.present).skip(1).filter(|(_, present)| *present) {
            rows(sum, self.n).fill(PaddedVec3::default());
        }
        let adds_to_first = |term: &Term<'_>| term.parts.iter().flatten().any(|part| part.sum == 0);
        let all = || (0..terms.count()).map(|i| (i, terms.term(i)));
        if kind.goes_over(0) {
            all().filter(|(_, term)| adds_to_first(term)).for_each(|term| self.add_term(term, block, tallies));
            if kind == PassKind::TotalOnly && terms.is_position_only() {
                self.kept.copy_from_slice(rows(self.sums[0], self.n));
            }
        }
        for (i, term) in all() {
            match (kind.goes_over(0), adds_to_first(&term)) {
                (true, true) => {}
                (_, false) => self.add_term((i, term), block, tallies),
                (false, true) => {
                    let parts = term.parts.map(|part| part.filter(|part| part.sum > 0));
                    self.add_term((i, Term { parts, ..term }), block, tallies);
                }
            }
        }
        let kept = (kind == PassKind::ReusePosition).then_some(&*self.kept);
        let [total, others @ ..] = &mut self.sums;
        let others = std::array::from_fn(|i| if self.present[i + 1] { rows_of(others[i], self.n) } else { &[] });
        sum_rows(rows(total, self.n), kept, others);
    }

    fn add_term(
        &mut self,
        (i, Term { forces, parts }): (usize, Term<'_>),
        block: &ElementBlock<'_>,
        tallies: &mut [Tally],
    ) {
        let [a, b, c] = &mut self.sums;
        let mut all = [Some(&mut **a), Some(&mut **b), Some(&mut **c)];
        let sums = parts.map(|part| all.get_mut(part?.sum)?.take());
        let found = match forces.scene_numbers() {
            None => forces.add(block, sums),
            Some(numbers) => {
                let mut in_block = [0.0; MOST_NUMBERS];
                let scene_numbers = match self.numbers {
                    PassNumbers::Found(numbers) => &numbers[i],
                    PassNumbers::InBlock => {
                        let [x, v] = [block.x, block.v].map(NodeVectors::Records);
                        numbers.find(block.t, x, v, &mut in_block);
                        &in_block
                    }
                };
                let &ElementBlock { number, ref own, t, x, v, .. } = block;
                forces.add(&ElementBlock { number, own: own.clone(), t, x, v, scene_numbers }, sums)
            }
        };
        for (part, found) in parts.into_iter().zip(found) {
            if let Some(PartTarget { tally, .. }) = part {
                tallies[tally] = found;
            }
        }
    }
}
