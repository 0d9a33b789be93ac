//! Blocks of steps: several steps at once, where no observer wants the states between ([`crate::model::step_block`]).
//!
//! Every step of a block enters the energy account and is watched as a single step is. Only the extent of the scene
//! differs: it is computed for the last state, and bounded for the states before. Where a step is not credible, the
//! whole block is dropped and its steps are made again one by one. A failure is then reported from the states of its
//! own step.

use super::super::clock::Tick;
use super::super::observer::{AcceptedStep, Energies, Observer, States, UpcomingStep, Wants};
use super::super::watch::{WatchedStep, power_of};
use super::{Run, RunError, StepPolicy};
use crate::integrate::stepper::{Attempt, Stepper};
use crate::model::step_block::{LONGEST, StepSummary};
use crate::model::system::longest_block;

/// Buffers and state of the blocks of a run.
#[derive(Default)]
pub(super) struct StepBlocks {
    /// summaries of the steps of a block
    summaries: Vec<StepSummary>,
    rows: [Energies; LONGEST],
    /// steps up to this number are made one by one
    not_before: u64,
    /// blocks dropped in a row
    dropped: u32,
}

/// After each further block that is dropped in a row, twice as many steps are made one by one: up to the length of the
/// block times two to this power.
const PATIENCE: u32 = 10;

impl Run<'_> {
    /// Makes a block of at least two steps. Returns `false` where it did nothing.
    pub fn step_block(
        &mut self,
        stepper: &mut Stepper<'_>,
        observers: &mut [&mut dyn Observer],
    ) -> Result<bool, RunError> {
        let busy = !self.state.events.is_idle();
        if busy || self.state.steps < self.state.blocks.not_before || self.state.failure.is_some() {
            return Ok(false);
        }
        let touches = self.scene.touches();
        if touches.is_some_and(|touches| !touches.begin_block(self.state.from.state.as_ref())) {
            return Ok(false);
        }
        let made = self.block_apart(stepper, observers);
        touches.into_iter().for_each(|touches| touches.leave_block());
        made
    }

    /// The same where nothing is near anything that it may touch.
    fn block_apart(
        &mut self,
        stepper: &mut Stepper<'_>,
        observers: &mut [&mut dyn Observer],
    ) -> Result<bool, RunError> {
        let h = match &self.state.policy {
            StepPolicy::Fixed(clock) if longest_block(self.scene) > 1 => {
                clock.tick_from(self.state.steps + 1, self.state.from.state.t).h
            }
            _ => {
                self.state.blocks.not_before = u64::MAX;
                return Ok(false);
            }
        };
        let mut blocks = std::mem::take(&mut self.state.blocks);
        blocks.summaries.resize_with(LONGEST, StepSummary::default);
        let (coming, n) = self.next_block(h, observers, &mut blocks.summaries);
        let coming = &coming[..n];
        let Some(last) = coming.last().filter(|_| n > 1) else {
            self.state.blocks = blocks;
            return Ok(false);
        };
        let before = (self.state.ledger, self.state.watch, self.state.counters);
        let attempt = Attempt { from: &self.state.from, h, t_next: last.t };
        let made =
            stepper.advance_block(attempt, &mut self.state.to, &mut blocks.summaries[..n], &mut self.state.counters);
        let apart = self.scene.touches().is_none_or(|touches| touches.covers(self.state.to.state.as_ref()));
        if !made {
            blocks.not_before = u64::MAX;
        } else if !apart || !self.record_block(coming, &mut blocks) {
            (self.state.ledger, self.state.watch, self.state.counters) = before;
            blocks.not_before = self.state.steps + ((n as u64) << blocks.dropped.min(PATIENCE));
            blocks.dropped += 1;
        } else {
            blocks.dropped = 0;
            stepper.accept();
            self.state.before_change = None;
            self.show_block(coming, &blocks, observers)?;
            self.pass_events(stepper, observers)?;
        }
        let done = self.state.steps >= last.step;
        self.state.blocks = blocks;
        Ok(done)
    }

    /// The steps of the next block: up to the first at whose end an observer wants a state, or before the first of
    /// which an observer wants both ends. The last step of a run is never in a block: it may be shorter, and a run can
    /// be resumed before it. Sets what the summary of each step must hold.
    fn next_block(
        &self,
        h: f64,
        observers: &[&mut dyn Observer],
        summaries: &mut [StepSummary],
    ) -> ([UpcomingStep; LONGEST], usize) {
        let mut coming = [UpcomingStep::default(); LONGEST];
        let StepPolicy::Fixed(clock) = &self.state.policy else { return (coming, 0) };
        let longest = longest_block(self.scene).min(LONGEST);
        let left = clock.count().saturating_sub(self.state.steps + 1).min(longest as u64) as usize;
        let mut from = self.state.from.state.t;
        for (made, (next, summary)) in coming[..left].iter_mut().zip(summaries).enumerate() {
            let number = self.state.steps + 1 + made as u64;
            let Tick { h: size, t } = clock.tick(number);
            if size != h {
                return (coming, made);
            }
            *next = UpcomingStep { step: number, from, t };
            (from, summary.t, summary.stretch_wanted) = (next.t, next.t, false);
            let mut states = States::None;
            for Wants { states: wanted, strain } in observers.iter().map(|o| o.wants(*next)) {
                states = states.max(wanted);
                summary.stretch_wanted |= strain;
            }
            match states {
                States::None if self.state.events.tells([next.from, t]) => return (coming, made + 1),
                States::None if clock.events().binary_search_by(|event| event.total_cmp(&t)).is_ok() => {
                    return (coming, made + 1);
                }
                States::None => {}
                States::End => return (coming, made + 1),
                States::BothEnds => return (coming, made),
            }
        }
        (coming, left)
    }

    /// Adds the steps of a block to the account; `false` if one of them is not credible.
    fn record_block(&mut self, coming: &[UpcomingStep], blocks: &mut StepBlocks) -> bool {
        let (mut before, mut way) = (self.state.row, 0.0);
        let mut tallies_before = self.state.from.forces.tallies.as_slice();
        for ((step, summary), row) in coming.iter().zip(&blocks.summaries).zip(&mut blocks.rows) {
            let after = self.state.ledger.close_with(self.scene, step.from, tallies_before, summary);
            // Bounds the extent of the states before the last by the way that nodes can have moved; doubled, because
            // speeds within a step may exceed those at its ends.
            way += 2.0 * step.h() * summary.max_speed();
            if !summary.nodes.finite || !after.is_finite() || self.has_left(summary.nodes.bounds.extent() + way) {
                return false;
            }
            let (scene, from, to) = (self.scene, &self.state.from, &self.state.to);
            let ends = [tallies_before, &summary.tallies];
            let (h, power) = (step.h(), ends.map(|tallies| power_of(scene, [step.from, step.t], tallies)));
            // Schemes that integrate work by stages make their steps one by one.
            let (by_stages, step_number) = (false, step.step);
            let watched =
                WatchedStep { scene, from, to, before: &before, after: &after, by_stages, power, step: step_number, h };
            if !self.state.watch.unseen_step(watched) || !self.state.scene_limits.allows(summary.max_speed(), h) {
                return false;
            }
            (*row, before, tallies_before) = (after, after, &summary.tallies);
        }
        true
    }

    fn show_block(
        &mut self,
        coming: &[UpcomingStep],
        blocks: &StepBlocks,
        observers: &mut [&mut dyn Observer],
    ) -> Result<(), RunError> {
        std::mem::swap(&mut self.state.from, &mut self.state.to);
        for (i, (step, (summary, row))) in coming.iter().zip(blocks.summaries.iter().zip(&blocks.rows)).enumerate() {
            (self.state.steps, self.state.row) = (step.step, *row);
            let end = (i + 1 == coming.len()).then_some(&self.state.from);
            let UpcomingStep { step, from, t } = *step;
            let (ledger, summary, credible) = (*row, Some(summary), true);
            let accepted = AcceptedStep { step, from, t, ledger, end, summary, credible, ..AcceptedStep::default() };
            for o in observers.iter_mut() {
                o.accepted(accepted)?;
            }
        }
        Ok(())
    }
}
