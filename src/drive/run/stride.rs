//! Several steps in one go, where nobody needs to see the states on the way ([`crate::model::stride`]).
//!
//! Every step of a stride enters the account and is watched as a single step is, but for the size of the scene, which
//! is told of the last state and bounded in those before. Where one looks wrong, the whole stride is dropped and its
//! steps are made again one by one, so that what is reported is what the step itself shows.

use super::super::observer::{Coming, LedgerRow, Observer, Passing};
use super::super::watch::{Watched, power_of};
use super::{Pace, Run, RunError};
use crate::integrate::stepper::{Attempt, Stepper};
use crate::model::stride::{LONGEST, Passed};

/// What a run needs for strides.
#[derive(Default)]
pub(super) struct Strides {
    /// room for those of a stride
    passed: Vec<Passed>,
    rows: [LedgerRow; LONGEST],
    /// steps up to this number are made one by one
    not_before: u64,
    /// strides dropped since the last that was not
    dropped: u32,
}

/// After each dropped stride in a row twice as many steps are made one by one, up to its length times two to this
/// power.
const PATIENCE: u32 = 10;

impl Run<'_> {
    /// Makes some steps, at least two; `false` where there is no stride, and nothing was done.
    pub(super) fn stride(
        &mut self,
        stepper: &mut Stepper<'_>,
        observers: &mut [&mut dyn Observer],
    ) -> Result<bool, RunError> {
        if self.steps < self.strides.not_before || self.failure.is_some() {
            return Ok(false);
        }
        if !matches!(self.pace, Pace::Fixed(_)) || self.scene.longest_stride() < 2 {
            self.strides.not_before = u64::MAX;
            return Ok(false);
        }
        let (coming, n) = self.coming(observers);
        let coming = &coming[..n];
        let Some(last) = coming.last().filter(|_| n > 1) else { return Ok(false) };
        let mut strides = std::mem::take(&mut self.strides);
        strides.passed.resize_with(LONGEST, Passed::default);
        for (passed, step) in strides.passed.iter_mut().zip(coming) {
            (passed.t, passed.stretch_wanted) = (step.t, step.stretch_wanted);
        }
        let before = (self.ledger, self.watch, self.counters);
        let attempt = Attempt { from: &self.from, h: last.h, t_next: last.t };
        let made = stepper.stride(attempt, &mut self.to, &mut strides.passed[..n], &mut self.counters);
        if !made {
            strides.not_before = u64::MAX;
        } else if !self.account_for(coming, &mut strides) {
            (self.ledger, self.watch, self.counters) = before;
            strides.not_before = self.steps + ((n as u64) << strides.dropped.min(PATIENCE));
            strides.dropped += 1;
        } else {
            strides.dropped = 0;
            self.show(coming, &strides, observers)?;
        }
        let done = self.steps >= last.step;
        self.strides = strides;
        Ok(done)
    }

    /// The steps that may be made in one go; never the last of a run, which may be shorter and before which a run is
    /// kept.
    fn coming(&self, observers: &[&mut dyn Observer]) -> ([Coming; LONGEST], usize) {
        let mut coming = [Coming::default(); LONGEST];
        let Pace::Fixed(clock) = &self.pace else { return (coming, 0) };
        let longest = self.scene.longest_stride().min(LONGEST);
        let left = clock.count().saturating_sub(self.steps + 1).min(longest as u64) as usize;
        for (step, number) in coming[..left].iter_mut().zip(self.steps + 1..) {
            let tick = clock.tick(number);
            *step = Coming { step: number, h: tick.h, t: tick.t, stretch_wanted: false };
        }
        let allowed = |n: usize, o: &&mut dyn Observer| n.min(o.stride(self.from.state.t, &mut coming[..n]));
        let n = observers.iter().fold(left, allowed);
        (coming, n)
    }

    /// Whether all is well.
    fn account_for(&mut self, coming: &[Coming], strides: &mut Strides) -> bool {
        let (mut before, mut t, mut way) = (self.row, self.from.state.t, 0.0);
        let mut power_before = power_of(self.scene, &self.from.forces.tallies);
        for ((step, passed), row) in coming.iter().zip(&strides.passed).zip(&mut strides.rows) {
            let after = self.ledger.passed(self.scene, passed);
            // Where bounds are told, nodes were nowhere farther out before than they can have come from, with as much
            // again for what speeds are between the ends of steps.
            way += 2.0 * step.h * passed.max_speed();
            if !passed.nodes.finite || !after.is_finite() || self.has_left(passed.nodes.bounds.extent() + way) {
                return false;
            }
            let (scene, from, to) = (self.scene, &self.from, &self.to);
            let (h, power) = (step.t - t, [power_before, power_of(scene, &passed.tallies)]);
            // Schemes that integrate work by stages make their steps one by one.
            let (by_stages, step_number) = (false, step.step);
            let watched =
                Watched { scene, from, to, before: &before, after: &after, by_stages, power, step: step_number, h };
            if !self.watch.unseen_step(watched) || !self.reach.allows(passed.max_speed(), h) {
                return false;
            }
            (*row, before, t, power_before) = (after, after, step.t, power[1]);
        }
        true
    }

    fn show(
        &mut self,
        coming: &[Coming],
        strides: &Strides,
        observers: &mut [&mut dyn Observer],
    ) -> Result<(), RunError> {
        std::mem::swap(&mut self.from, &mut self.to);
        let mut from = self.to.state.t;
        for (i, (step, (passed, row))) in coming.iter().zip(strides.passed.iter().zip(&strides.rows)).enumerate() {
            (self.steps, self.row) = (step.step, *row);
            let at = (i + 1 == coming.len()).then_some(&self.from);
            for o in observers.iter_mut() {
                o.passed(Passing { step: step.step, from, t: step.t, ledger: *row, passed, at })?;
            }
            from = step.t;
        }
        Ok(())
    }
}
