//! The steps of a run: of fixed size, with the last one cut to meet the end, or of the size that a tolerance allows.

use serde::{Deserialize, Serialize};

/// The steps of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// [s] in steps of this size
    Fixed(f64),
    /// in steps whose error stays within a tolerance
    Adaptive(Tolerance),
}

impl Step {
    /// [s] The step, if it is fixed.
    pub fn fixed(self) -> Option<f64> {
        match self {
            Step::Fixed(step) => Some(step),
            Step::Adaptive(_) => None,
        }
    }

    /// The tolerance, if steps are adaptive.
    pub fn tolerance(self) -> Option<Tolerance> {
        match self {
            Step::Fixed(_) => None,
            Step::Adaptive(tolerance) => Some(tolerance),
        }
    }
}

/// Error that the run may make in positions: `absolute` plus `relative` times the largest displacement so far, both as
/// the root mean square over the free degrees of freedom. Each step may make a share of it in proportion to its size.
/// The error of a run also depends on the scene: on swinging pendulums and cloths it is within a factor of ten of this.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Tolerance {
    /// [-] Share of the largest displacement so far.
    #[cfg_attr(feature = "schema", schemars(extend("minimum" = 1e-13, "exclusiveMaximum" = 1)))]
    pub relative: f64,
    /// [m] Error that is always allowed ([rad] for a pendulum); it matters while the motion is small.
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub absolute: f64,
}

/// A fixed step from 0 to the end; only the last step may be shorter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedSteps {
    /// [s] step
    step: f64,
    /// [s] end
    end: f64,
    /// number of steps, the last included
    count: u64,
}

/// One step of the clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tick {
    /// [s] step size
    pub h: f64,
    /// [s] time at its end
    pub t: f64,
}

/// Share of a step by which the end may differ from a multiple of the step without an extra step.
const SLACK: f64 = 1e-9;

impl FixedSteps {
    /// A clock for positive finite `step` and `end` [s]; a step above the end is cut to it.
    pub fn new(step: f64, end: f64) -> Self {
        let ratio = end / step;
        let nearest = ratio.round();
        let whole = nearest >= 1.0 && (ratio - nearest).abs() <= SLACK.max(4.0 * f64::EPSILON * nearest);
        let count = if whole { nearest } else { ratio.ceil().max(1.0) };
        FixedSteps { step, end, count: count as u64 }
    }

    /// Number of steps.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Step number `k`, counted from 1.
    pub fn tick(&self, k: u64) -> Tick {
        if k < self.count {
            return Tick { h: self.step, t: k as f64 * self.step };
        }
        let rest = self.end - (self.count - 1) as f64 * self.step;
        // If the last step differs from the others by rounding only, it keeps their size.
        let h = if (rest - self.step).abs() <= 1e-6 * self.step { self.step } else { rest };
        Tick { h, t: self.end }
    }
}

/// Fixed steps of a scene with events: a step within which an event lies is made in two.
#[derive(Clone, Debug)]
pub struct EventSteps {
    steps: FixedSteps,
    /// number of every step that ends at an event within one of `steps`, and its end [s], ascending
    divided: Vec<(u64, f64)>,
    /// [s] times at which events are passed, ascending
    events: Vec<f64>,
}

/// Where a run stands in its steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JoinedAt {
    /// number of the last step that ends there or before
    pub step: u64,
    /// [s]
    pub t: f64,
}

impl EventSteps {
    /// The steps of a run; `events` [s] ascend and lie after 0. An event that rounding parts from the end of a step is
    /// passed there.
    pub fn new(steps: FixedSteps, events: &[f64]) -> Self {
        let mut made = EventSteps { steps, divided: Vec::new(), events: Vec::new() };
        for &event in events {
            let ratio = event / steps.step;
            let nearest = ratio.round();
            let slack = SLACK.max(4.0 * f64::EPSILON * nearest);
            if (event - steps.end).abs() <= slack * steps.step {
                made.events.push(steps.end);
            } else if event > steps.end {
                made.events.push(event);
            } else if nearest >= 1.0 && (ratio - nearest).abs() <= slack {
                made.events.push(steps.tick(nearest as u64).t);
            } else {
                let within = (ratio as u64).min(steps.count - 1);
                made.divided.push((within + made.divided.len() as u64 + 1, event));
                made.events.push(event);
            }
        }
        made
    }

    /// Ends a step also at `t` [s], at which an event was found, unless only rounding parts it from the end of a step.
    /// All steps but those around it stay what they are.
    pub fn divide(&mut self, t: f64) {
        let ratio = t / self.steps.step;
        let nearest = ratio.round();
        let slack = SLACK.max(4.0 * f64::EPSILON * nearest);
        let before = self.divided.partition_point(|(_, of)| *of < t);
        let known = self.divided.get(before).is_some_and(|(_, of)| *of == t);
        let at_an_end = (nearest >= 0.0 && (ratio - nearest).abs() <= slack) || known;
        if at_an_end || t > self.steps.end - slack * self.steps.step || t <= 0.0 {
            return;
        }
        let within = (ratio as u64).min(self.steps.count - 1);
        self.divided[before..].iter_mut().for_each(|(number, _)| *number += 1);
        self.divided.insert(before, (within + before as u64 + 1, t));
    }

    /// [s] Differences of times at `t` [s] that count as rounding.
    pub fn slack(&self, t: f64) -> f64 {
        SLACK * self.steps.step + 8.0 * f64::EPSILON * t
    }

    /// Number of steps.
    pub fn count(&self) -> u64 {
        self.steps.count + self.divided.len() as u64
    }

    /// [s] Times at which events are passed.
    pub fn events(&self) -> &[f64] {
        &self.events
    }

    /// [s] End of step number `k`; the start of the run for 0.
    pub fn end_of(&self, k: u64) -> f64 {
        if k == 0 { 0.0 } else { self.tick(k).t }
    }

    /// Step number `k` from `t` [s]: shorter than others where a program has put the run between two ends of steps.
    pub fn tick_from(&self, k: u64, t: f64) -> Tick {
        let tick = self.tick(k);
        if self.end_of(k - 1) == t { tick } else { Tick { h: tick.t - t, t: tick.t } }
    }

    /// Where a run stands that is put at `t` [s]: the end of a step where only rounding parts them.
    pub fn join(&self, t: f64) -> JoinedAt {
        let slack = SLACK * self.steps.step;
        let (mut low, mut high) = (0, self.count());
        // Bisection, since events divide some of the steps.
        while low < high {
            let middle = low + (high - low).div_ceil(2);
            if self.end_of(middle) <= t + slack { low = middle } else { high = middle - 1 }
        }
        let end = self.end_of(low);
        JoinedAt { step: low, t: if (end - t).abs() <= slack { end } else { t } }
    }

    /// Step number `k`, counted from 1.
    pub fn tick(&self, k: u64) -> Tick {
        let before = self.divided.partition_point(|(n, _)| *n < k);
        let whole = self.steps.tick(k - before as u64);
        let own = self.divided.get(before).filter(|(n, _)| *n == k).map(|(_, t)| *t);
        let last = before.checked_sub(1).and_then(|i| self.divided.get(i)).filter(|(n, _)| *n + 1 == k);
        if own.is_none() && last.is_none() {
            return whole;
        }
        let start = match (last, k - before as u64) {
            (Some((_, t)), _) => *t,
            (None, 1) => 0.0,
            (None, n) => self.steps.tick(n - 1).t,
        };
        let t = own.unwrap_or(whole.t);
        Tick { h: t - start, t }
    }
}

/// Steps whose sizes a program gives.
#[derive(Clone, Debug)]
pub struct FreeSteps {
    /// [s] size of a step for which it gives none
    pub step: f64,
    /// [s] end of those
    pub end: f64,
    /// [s] times of events, ascending: a step ends there at the latest
    pub events: Vec<f64>,
}

impl FreeSteps {
    /// The step from `t` [s] of size `h` [s].
    pub fn tick(&self, t: f64, h: f64) -> Tick {
        let slack = 4.0 * f64::EPSILON;
        let event = self.events.iter().copied().find(|event| event - t > slack * event);
        match event.filter(|event| t + h > *event - SLACK * h) {
            Some(event) => Tick { h: event - t, t: event },
            None => Tick { h, t: t + h },
        }
    }

    /// The step from `t` [s] for which the program gives no size; `None` at the end.
    pub fn next(&self, t: f64) -> Option<Tick> {
        let left = self.end - t;
        let h = if left <= self.step * (1.0 + SLACK) { left } else { self.step };
        (left > SLACK * self.step).then(|| self.tick(t, h))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_steps_keep_their_size_and_end_exactly() {
        for (step, end, count) in [(0.1, 1.0, 10), (1e-12, 1.5e-10, 150), (2e-3, 2.0, 1000), (0.3, 0.9, 3)] {
            let clock = FixedSteps::new(step, end);
            assert_eq!(clock.count(), count, "{step} {end}");
            assert!((1..=count).all(|k| clock.tick(k).h == step));
            assert_eq!(clock.tick(count).t, end);
        }
    }

    #[test]
    fn only_the_last_step_is_cut() {
        let clock = FixedSteps::new(0.3, 1.0);
        assert_eq!(clock.count(), 4);
        assert_eq!(clock.tick(3).h, 0.3);
        assert!((clock.tick(4).h - 0.1).abs() < 1e-15);
        assert_eq!(FixedSteps::new(5.0, 1.0).tick(1), Tick { h: 1.0, t: 1.0 });
    }

    /// A run may be put between two ends of steps: its next step ends at the second of them.
    #[test]
    fn a_run_joins_its_steps() {
        let steps = EventSteps::new(FixedSteps::new(0.25, 1.0), &[0.625]);
        for (t, step, found) in [(0.0, 0, 0.0), (0.3, 1, 0.3), (0.5 - 1e-12, 2, 0.5), (0.63, 3, 0.63), (1.0, 5, 1.0)] {
            assert_eq!(steps.join(t), JoinedAt { step, t: found }, "{t}");
        }
        assert_eq!(steps.tick_from(2, 0.3), Tick { h: 0.2, t: 0.5 });
        assert_eq!(steps.tick_from(2, 0.25), steps.tick(2));
    }

    /// Events within a step divide it, also two in one step; those at the end of a step do not.
    #[test]
    fn events_divide_steps() {
        let steps = EventSteps::new(FixedSteps::new(0.25, 1.0), &[0.125, 0.5, 0.625, 0.6875]);
        assert_eq!(steps.count(), 7);
        let ends: Vec<f64> = (1..=7).map(|k| steps.tick(k).t).collect();
        assert_eq!(ends, [0.125, 0.25, 0.5, 0.625, 0.6875, 0.75, 1.0]);
        let mut from = 0.0;
        for k in 1..=7 {
            let Tick { h, t } = steps.tick(k);
            assert_eq!(h, t - from, "{k}");
            from = t;
        }
        let plain = EventSteps::new(FixedSteps::new(0.1, 1.0), &[0.3]);
        assert_eq!((plain.count(), plain.events()), (10, &[3.0 * 0.1][..]));
        assert!((1..=10).all(|k| plain.tick(k) == FixedSteps::new(0.1, 1.0).tick(k)));
        // Found later in any order, they divide steps in the same way.
        let mut found = EventSteps::new(FixedSteps::new(0.25, 1.0), &[0.625]);
        [0.6875, 0.125, 0.5, 0.6875].into_iter().for_each(|t| found.divide(t));
        assert_eq!(found.count(), 7);
        assert!((1..=7).all(|k| found.tick(k) == steps.tick(k)));
        let beyond = EventSteps::new(FixedSteps::new(0.3, 1.0), &[1.0, 1.2, 2.0]);
        assert_eq!((beyond.count(), beyond.events()), (4, &[1.0, 1.2, 2.0][..]), "events beyond the end wait there");
    }
}
