//! The size of the next step, from the error of this one.
//!
//! E is the error of the step per unit of time over the allowed error per unit of time; it is proportional to h^p for a
//! scheme of order p. The next step is that of a proportional-integral controller (Gustafsson 1991, ACM TOMS 17; Hairer
//! & Wanner 1996, section IV.2, "A PI step size control", with these exponents):
//! ```text
//! h_{n+1} = 0.9 h_n E_n^(-0.7/p) E_{n-1}^(0.4/p)          after an accepted step (E_n <= 1)
//! h       = 0.9 h E^(-1/p)                                for the next attempt after a dropped one
//! ```

use serde::{Deserialize, Serialize};

const SAFETY: f64 = 0.9;
/// Exponents of the present and the previous error, times the order.
const PRESENT: f64 = 0.7;
const PREVIOUS: f64 = 0.4;
/// Errors below this value all mean the same: the step may grow.
const NO_ERROR: f64 = 1e-10;
/// Lower bound of the previous error in the formula (Hairer, Norsett & Wanner 1993, `dopri5`): growth from zero to a
/// small error is no reason to shrink the step.
const LEAST_PREVIOUS: f64 = 1e-4;
/// Largest reduction of a step at once.
const MOST_SHRINK: f64 = 0.1;
/// Reduction after a step that could not be solved, which gives no error to compute it from.
const UNSOLVED: f64 = 0.25;

/// The proportional-integral controller; part of a checkpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Controller {
    /// [s] the next step
    h: f64,
    /// [-] E of the last accepted step
    previous: f64,
    /// attempts dropped since the last accepted step
    dropped: u32,
}

/// An attempt's error and what it was made with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RatedAttempt {
    /// [s] its step; shorter than the controller's where it was cut to end at a given time
    pub h: f64,
    /// [-] E
    pub error: f64,
    /// [-] order of the scheme
    pub order: u32,
    /// [-] largest growth of a step
    pub most_growth: f64,
}

impl Controller {
    /// A controller whose first step is `h` [s].
    pub fn new(h: f64) -> Self {
        Controller { h, previous: 1.0, dropped: 0 }
    }

    /// [s] the next step
    pub fn step(&self) -> f64 {
        self.h
    }

    /// Attempts dropped since the last accepted step.
    pub fn dropped(&self) -> u32 {
        self.dropped
    }

    /// Computes the next step after an accepted one.
    pub fn accept(&mut self, RatedAttempt { h, error, order, most_growth }: RatedAttempt) {
        let (now, p) = (error.max(NO_ERROR), f64::from(order));
        let factor = SAFETY * now.powf(-PRESENT / p) * self.previous.powf(PREVIOUS / p);
        // A size that has just been dropped would be too large again.
        let most = if self.dropped > 0 { 1.0 } else { most_growth };
        let next = h * factor.clamp(MOST_SHRINK, most);
        // A step that was cut to end at a given time does not limit the next one.
        self.h = if h < self.h && factor >= 1.0 { self.h.max(next) } else { next };
        (self.previous, self.dropped) = (now.max(LEAST_PREVIOUS), 0);
    }

    /// Where forces are not smooth: clears the history, but keeps the size of the last steps if it is above `least`
    /// [s].
    pub fn restart(&mut self, least: f64) {
        *self = Controller::new(self.h.max(least));
    }

    /// After a step that ended where forces are not smooth: it was cut to that time, so its size and error are not used
    /// for the next.
    pub fn end_smooth_interval(&mut self) {
        (self.previous, self.dropped) = (1.0, 0);
    }

    /// Sets the next attempt to `h` [s] because a force changes its law, not because of an error.
    pub fn cut(&mut self, h: f64) {
        self.h = h;
    }

    /// Reduces the step after one whose error was too large or not a number.
    pub fn too_large(&mut self, RatedAttempt { h, error, order, .. }: RatedAttempt) {
        let factor = if error.is_finite() { SAFETY * error.powf(-1.0 / f64::from(order)) } else { MOST_SHRINK };
        self.drop_to(h * factor.clamp(MOST_SHRINK, SAFETY));
    }

    /// Reduces the step after one of `h` [s] that could not be solved.
    pub fn unsolved(&mut self, h: f64) {
        self.drop_to(h * UNSOLVED);
    }

    /// Reduces the step after one of `h` [s] whose error was small enough, but which is wrong for another reason.
    pub fn refuse(&mut self, h: f64) {
        self.drop_to(h * MOST_SHRINK);
    }

    fn drop_to(&mut self, h: f64) {
        self.h = h;
        self.dropped += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On E = (h / 0.01)^p it settles where E is SAFETY^(p / 0.3): the two exponents leave 0.3 of the integral.
    #[test]
    fn settles_just_below_the_tolerance() {
        for order in [1, 2, 4] {
            for first in [1e-6, 1.0] {
                let mut c = Controller::new(first);
                for _ in 0..200 {
                    let (h, p) = (c.step(), f64::from(order));
                    let judged = RatedAttempt { h, error: (h / 0.01).powf(p), order, most_growth: 2.0 };
                    if judged.error <= 1.0 { c.accept(judged) } else { c.too_large(judged) }
                }
                let expected = 0.01 * SAFETY.powf(1.0 / 0.3);
                assert!((c.step() / expected - 1.0).abs() < 1e-6, "order {order} from {first}: {}", c.step());
            }
        }
    }

    #[test]
    fn a_step_cut_short_is_not_remembered() {
        let mut c = Controller::new(0.1);
        c.accept(RatedAttempt { h: 0.001, error: 1e-6, order: 2, most_growth: 2.0 });
        assert_eq!(c.step(), 0.1);
        c.too_large(RatedAttempt { h: 0.1, error: f64::NAN, order: 2, most_growth: 2.0 });
        assert!((c.step() - 0.01).abs() < 1e-15 && c.dropped() == 1);
        c.accept(RatedAttempt { h: 0.01, error: 1e-9, order: 2, most_growth: 2.0 });
        assert!((c.step() - 0.01).abs() < 1e-15 && c.dropped() == 0, "no growth right after a drop");
    }
}
