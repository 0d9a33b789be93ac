//! Which steps and tolerances are tried when nobody says.
//!
//! Explicit methods: just below their critical step, and halved from there; and once at twice the limit, to show it.
//! Implicit methods: from a fraction of the period of what moves most, halved until the fastest motion is resolved.
//! Steps are the interval of the frames over, or times, numbers 2^a 5^b, so that they are round and meet the frames.

use crate::analysis::spectrum::Spectrum;
use crate::integrate::registry::{Family, MethodChoice};

/// Share of the critical step that the largest explicit step takes at most.
const BELOW: f64 = 0.95;
/// Multiple of the critical step that is tried beyond it.
const BEYOND: f64 = 2.0;
/// Largest step as a share of the run.
const LARGEST: f64 = 0.1;
/// Share of the main period that the largest implicit step takes.
const OF_PERIOD: f64 = 0.25;
/// Steps of a method of order up to 2, and above.
const STEPS: [usize; 2] = [6, 5];
/// Steps of an implicit method.
const IMPLICIT_STEPS: usize = 8;
/// Share by which a quotient of two times is off.
const ROUNDING: f64 = 1e-9;
/// Errors smaller than this are of no interest to a study without a list of what to try.
const FINE_ENOUGH: f64 = 1e-8;
/// Tolerances tried by methods of order 2 and above.
pub(crate) const TOLERANCES: [f64; 5] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6];

/// What the steps of a scene are laid around.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepScales {
    /// [s] interval of the frames
    pub every: f64,
    /// [s] end of the run
    pub end: f64,
    /// [s] about the period of what moves most
    pub period: f64,
    /// [s] what an explicit method with a limit of 2 over the fastest frequency may take; infinite if nothing
    /// oscillates
    pub fastest: f64,
}

impl StepScales {
    /// Of a scene's spectrum and the motion of its reference.
    pub(crate) fn of(spectrum: &Spectrum<'_>, every: f64, end: f64, period: f64) -> Self {
        let rates = spectrum.rates();
        let rate = rates.frequency.max(rates.damping);
        let fastest = if rate > 0.0 { 2.0 / rate } else { f64::INFINITY };
        StepScales { every, end, period, fastest }
    }

    /// [s] The largest step that is not above `wanted` and meets the frames: the interval over, or times, a number 2^a
    /// 5^b.
    pub(crate) fn round(&self, wanted: f64) -> f64 {
        let ratio = wanted / self.every;
        if !(ratio > 0.0 && ratio.is_finite()) {
            return wanted;
        }
        // Whole numbers, so that the digits of round intervals are kept: 0.02/8 is 0.0025.
        if ratio < 1.0 - ROUNDING {
            self.every / regular(1.0 / ratio, Neighbour::Above)
        } else {
            self.every * regular(ratio, Neighbour::Below)
        }
    }

    /// [-] About the error of a step of `h` [s] by a method of this order: (2 pi h / T)^p with the main period T.
    fn rough_error(&self, h: f64, order: u32) -> f64 {
        (std::f64::consts::TAU * h / self.period).powi(order.min(60) as i32)
    }

    /// [s] About the step that a method of this order takes within a tolerance.
    pub(crate) fn rough_step(&self, tolerance: f64, order: u32) -> f64 {
        self.period / std::f64::consts::TAU * tolerance.powf(1.0 / f64::from(order.max(1)))
    }

    /// How often a step of `h` [s] is worth halving: until errors are of no interest, but once at least.
    fn levels(&self, h: f64, order: u32, most: usize) -> usize {
        let fine = |k: &usize| self.rough_error(h * 0.5f64.powi(*k as i32), order) < FINE_ENOUGH;
        (0..most).find(fine).map_or(most, |k| (k + 1).clamp(2, most))
    }

    /// Those of [`TOLERANCES`] that matter for a method with a limit of `limit` [s], infinite if it has none: where
    /// stability holds the steps, looser tolerances all give the same run.
    pub(crate) fn tolerances(&self, order: u32, limit: f64) -> Vec<f64> {
        let held = if limit > 0.0 && limit.is_finite() { 10.0 * self.rough_error(limit, order) } else { f64::INFINITY };
        let matters = |(i, t): &(usize, f64)| *i == 0 || *t < held;
        TOLERANCES.into_iter().enumerate().filter(matters).map(|(_, t)| t).collect()
    }

    /// [s] Steps for a method, the largest first, each once.
    pub(crate) fn steps(&self, method: &MethodChoice, spectrum: &mut Spectrum<'_>) -> Vec<f64> {
        let most = LARGEST * self.end;
        let limit = match method.info.family {
            // Its filter has no limit; what acts outside it does.
            Family::MatrixFree => self.fastest,
            _ => spectrum.critical_step(method).step,
        };
        let wanted: Vec<f64> = if limit == 0.0 {
            // It grows at every step: how much, is the question.
            let largest = most.min(0.5 * self.fastest);
            (0..STEPS[0]).map(|k| largest * 0.25f64.powi(k as i32)).collect()
        } else if method.info.family == Family::Implicit {
            let largest = most.min(OF_PERIOD * self.period).max(0.5 * self.fastest.min(most));
            (0..IMPLICIT_STEPS).map(|k| largest * 0.5f64.powi(k as i32)).collect()
        } else {
            let largest = most.min(BELOW * limit).min(OF_PERIOD * self.period.max(self.fastest.min(self.end)));
            let count = self.levels(largest, method.order(), STEPS[usize::from(method.order() > 2)]);
            let beyond = BEYOND * limit;
            let first = (beyond <= most && largest == BELOW * limit).then_some(beyond);
            first.into_iter().chain((0..count).map(|k| largest * 0.5f64.powi(k as i32))).collect()
        };
        let mut steps: Vec<f64> = wanted.into_iter().map(|h| self.round(h)).collect();
        steps.dedup();
        steps
    }
}

/// Which neighbour is wanted.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Neighbour {
    Above,
    Below,
}

/// The number 2^a 5^b, a and b at least 0, next to `x` of at least 1.
fn regular(x: f64, side: Neighbour) -> f64 {
    let fives = (0..).map(|b| 5f64.powi(b)).take_while(|five| *five <= x * 5.0);
    let next = |five: f64| {
        let a = (x / five).log2();
        let a = if side == Neighbour::Above { (a - ROUNDING).ceil() } else { (a + ROUNDING).floor() };
        (side == Neighbour::Above || a >= 0.0).then(|| five * a.max(0.0).exp2())
    };
    let all = fives.filter_map(next);
    if side == Neighbour::Above { all.fold(f64::INFINITY, f64::min) } else { all.fold(1.0, f64::max) }
}

/// 1, 2 and 5 times powers of ten from one number to another, both ends included.
pub(crate) fn series(from: f64, to: f64) -> Vec<f64> {
    let first = from.log10().floor() as i32;
    let last = to.log10().ceil() as i32;
    let within = |x: &f64| (from * (1.0 - 1e-9)..=to * (1.0 + 1e-9)).contains(x);
    let of_power = |p: i32| [1, 2, 5].map(|m| format!("{m}e{p}").parse::<f64>().unwrap_or(f64::NAN));
    (first..=last).flat_map(of_power).filter(within).collect()
}

/// Powers of ten from one number to another, both ends included.
pub(crate) fn decades(from: f64, to: f64) -> Vec<f64> {
    series(from, to).into_iter().filter(|x| format!("{x:e}").starts_with("1e")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round_and_meet_the_frames() {
        let scales = StepScales { every: 0.02, end: 2.0, period: 1.0, fastest: 1e-3 };
        let pairs = [
            (0.0026, 0.0025),
            (0.0025, 0.0025),
            (6.3e-4, 6.25e-4),
            (0.021, 0.02),
            (0.09, 0.08),
            (0.5, 0.5),
            (1e-7, 1e-7),
        ];
        for (wanted, round) in pairs {
            assert_eq!(scales.round(wanted), round, "{wanted}");
        }
        for wanted in [0.3e-5, 1.7e-4, 9.99e-3, 0.0123] {
            let (h, ratio) = (scales.round(wanted), scales.every / scales.round(wanted));
            assert!(h <= wanted * (1.0 + 1e-9) && h > 0.5 * wanted, "{wanted} {h}");
            assert!((ratio - ratio.round()).abs() < 1e-9, "{wanted} {h}");
        }
    }

    /// A stiff scene, whose limit is far below what accuracy needs: few steps, and one tolerance that shows it. A soft
    /// one: all.
    #[test]
    fn nothing_is_tried_that_tells_nothing() {
        let scales = StepScales { every: 0.02, end: 2.0, period: 1.0, fastest: 1e-3 };
        assert_eq!([scales.levels(1e-5, 2, 6), scales.levels(1e-3, 2, 6), scales.levels(1e-5, 1, 6)], [2, 6, 6]);
        assert_eq!(scales.tolerances(4, 1e-3), [1e-2]);
        assert_eq!(scales.tolerances(2, 1e-3), [1e-2, 1e-4, 1e-5, 1e-6]);
        assert_eq!(scales.tolerances(2, f64::INFINITY), TOLERANCES);
    }

    #[test]
    fn series_have_both_ends() {
        assert_eq!(series(1e-3, 1e-2), [1e-3, 2e-3, 5e-3, 1e-2]);
        assert_eq!(series(2e-3, 2e-2), [2e-3, 5e-3, 1e-2, 2e-2]);
        assert_eq!(decades(1e-6, 1e-2), [1e-6, 1e-5, 1e-4, 1e-3, 1e-2]);
        assert_eq!(series(3e-3, 4e-3), [0.0; 0]);
    }
}
