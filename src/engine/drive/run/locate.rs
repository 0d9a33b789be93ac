//! The end of a step at an event that waits for a state: found by shorter and shorter brackets around it, with a step
//! of the scheme itself from the same state to each place that is tried. So the event is where the scheme has it, to
//! rounding, and what it is off by is the error of the scheme.

use super::super::adaptive::{AdaptiveState, AdaptiveStep, AttemptContext, DropReason, PlannedStep};
use super::super::clock::Tick;
use super::super::outcome::Status;
use super::super::step_policy::StepPolicy;
use super::Run;
use crate::integrate::StepReport;
use crate::integrate::stepper::Stepper;
use crate::model::point::Point;

/// [-] Width of the last bracket over the step.
const WIDTH: f64 = 1e-12;
/// Tries after which brackets are halved, and after which the search ends.
const TRIES: [u32; 2] = [20, 80];

/// A search for the step at which a margin falls to 0 (regula falsi, the Illinois variant).
pub(super) struct Search {
    /// [s] a step before the event, with the margin there
    low: (f64, f64),
    /// [s] the shortest step that is known to reach it, with the margin there
    high: (f64, f64),
    /// [s] shortest step to try
    least: f64,
    /// [s] width of a bracket that is narrow enough
    width: f64,
    tries: u32,
    /// whether the last try reached the event
    reached: Option<bool>,
}

impl Search {
    /// In a step of `h` [s] at whose ends the margins are these; no step is below `least` [s], and times are rounded by
    /// `rounding` [s].
    pub(super) fn new(h: f64, [start, end]: [f64; 2], [least, rounding]: [f64; 2]) -> Self {
        let width = WIDTH * h + rounding;
        Search { low: (0.0, start), high: (h, end), least, width, tries: 0, reached: None }
    }

    /// [s] The next step to try; `None` once the bracket is narrow enough.
    pub(super) fn next(&mut self) -> Option<f64> {
        let ((low, before), (high, after)) = (self.low, self.high);
        self.tries += 1;
        if high - low <= self.width || high <= self.least || self.tries > TRIES[1] {
            return None;
        }
        let by_margin = low + (high - low) * before / (before - after);
        let middle = 0.5 * (low + high);
        let next = if self.tries > TRIES[0] || !by_margin.is_finite() { middle } else { by_margin };
        // Next to an end, so that a place that is found is bracketed from both sides.
        let near = 0.5 * self.width;
        let next = next.clamp(low + near, high - near).max(self.least);
        (next < high).then_some(next)
    }

    /// Takes the margin at the end of a step of `h` [s].
    pub(super) fn add(&mut self, h: f64, margin: f64) {
        let reached = margin <= 0.0;
        let again = self.reached == Some(reached);
        if reached {
            self.high = (h, margin);
            self.low.1 *= if again { 0.5 } else { 1.0 };
        } else {
            self.low = (h, margin);
            self.high.1 *= if again { 0.5 } else { 1.0 };
        }
        self.reached = Some(reached);
    }

    /// [s] The step to take.
    pub(super) fn found(&self) -> f64 {
        self.high.0
    }
}

impl Run<'_> {
    /// A search in an attempted step to `end`, if an event happens in it.
    fn search(&self, end: &Point, least: f64) -> Option<Search> {
        let (events, from) = (&self.state.events, &self.state.from.state);
        if !events.waits() {
            return None;
        }
        let margin = events.margin(self.scene, end.state.as_ref());
        let start = || events.margin(self.scene, from.as_ref());
        let rounding = 4.0 * f64::EPSILON * end.state.t;
        (margin <= 0.0).then(|| Search::new(end.state.t - from.t, [start(), margin], [least, rounding]))
    }

    /// Ends an attempted step of fixed size at the first event within it.
    pub(super) fn end_at_event(
        &mut self,
        stepper: &mut Stepper<'_>,
        tick: Tick,
        whole: StepReport,
    ) -> Result<StepReport, Status> {
        let least = 2.0 * self.state.policy.slack(tick.t);
        let search = self.search(&self.state.to, least);
        self.state.events.ends_step(search.is_some());
        let Some(mut search) = search else {
            self.state.events.none_is_due();
            return Ok(whole);
        };
        let from = self.state.from.state.t;
        let (mut report, mut made) = (whole, tick.h);
        let mut attempt = |run: &mut Self, h: f64| {
            let t = if h == tick.h { tick.t } else { from + h };
            run.fixed_step(stepper, Tick { h, t })
        };
        while let Some(h) = search.next() {
            (report, made) = (attempt(self, h)?, h);
            search.add(h, self.state.events.margin(self.scene, self.state.to.state.as_ref()));
        }
        // At the end of the step, where only rounding parts them.
        let found = if tick.h - search.found() <= least { tick.h } else { search.found() };
        if made != found {
            report = attempt(self, found)?;
        }
        Ok(report)
    }

    /// Ends an adaptive step that was kept at the first event within it.
    pub(super) fn end_adaptive_at_event(
        &mut self,
        stepper: &mut Stepper<'_>,
        planned: PlannedStep,
        saved: &AdaptiveState,
        kept: AdaptiveStep,
    ) -> Result<AdaptiveStep, DropReason> {
        let from = self.state.from.state.t;
        let StepPolicy::Adaptive(policy) = &mut self.state.policy else { return Ok(kept) };
        let least = policy.floor(from);
        let end = match kept {
            AdaptiveStep::Halves(_) => policy.second().map(|end| end.clone()),
            AdaptiveStep::Single(_) => None,
        };
        let search = self.search(end.as_ref().unwrap_or(&self.state.to), least);
        self.state.events.ends_step(search.is_some());
        let Some(mut search) = search else { return Ok(kept) };
        let (mut kept, mut made) = (kept, planned.h);
        let mut attempt = |run: &mut Self, h: f64| {
            let StepPolicy::Adaptive(policy) = &mut run.state.policy else { return Ok(f64::NAN) };
            let halves = matches!(kept, AdaptiveStep::Halves(_));
            policy.rewind(saved, halves.then_some(&mut *stepper)).map_err(DropReason::Unsolved)?;
            let t = if h == planned.h { planned.t } else { from + h };
            let counters = &mut run.state.counters;
            let context = AttemptContext { scene: run.scene, stepper: &mut *stepper, counters };
            let shorter = PlannedStep { h: t - from, t, at_corner: true };
            kept = policy.attempt(context, shorter, &run.state.from, &mut run.state.to)?;
            let end = match kept {
                AdaptiveStep::Halves(_) => policy.second().map_or(&run.state.to, |end| &*end),
                AdaptiveStep::Single(_) => &run.state.to,
            };
            Ok(run.state.events.margin(run.scene, end.state.as_ref()))
        };
        while let Some(h) = search.next() {
            search.add(h, attempt(self, h)?);
            made = h;
        }
        if made != search.found() {
            attempt(self, search.found())?;
        }
        Ok(kept)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Finds the zero of a margin in a step of 1, with a bracket that is narrow on both sides, in few tries.
    #[test]
    fn a_search_ends_at_the_first_step_that_reaches() {
        let margins: [(&dyn Fn(f64) -> f64, f64); 4] = [
            (&|h| 0.25 - h, 0.25),
            (&|h| 0.5 - h * h, 0.5_f64.sqrt()),
            (&|h| 0.3_f64.powi(9) - h.powi(9), 0.3),
            // a jump
            (&|h| if h < 0.7 { 1.0 } else { -1e-3 }, 0.7),
        ];
        for (margin, place) in margins {
            let mut search = Search::new(1.0, [margin(0.0), margin(1.0)], [1e-9, 1e-9]);
            let mut tries = 0;
            while let Some(h) = search.next() {
                search.add(h, margin(h));
                tries += 1;
            }
            let found = search.found();
            assert!(margin(found) <= 0.0 && (found - place).abs() <= 2e-9 && tries < 60, "{found} {place} {tries}");
        }
    }

    /// Where a margin is met at the start already, as after a jump, the step is the shortest.
    #[test]
    fn what_is_met_at_the_start_is_found_at_once() {
        let mut search = Search::new(1.0, [-1.0, -2.0], [1e-9, 0.0]);
        while let Some(h) = search.next() {
            search.add(h, -1.0 - h);
        }
        assert_eq!(search.found(), 1e-9);
    }
}
