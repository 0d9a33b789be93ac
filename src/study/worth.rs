//! What a number is worth: its error by the steps, from runs of the same method with other steps.
//!
//! Of three runs with steps h, 2 h and 4 h the differences d1 = |a_2h - a_h| and d2 = |a_4h - a_2h| show the order, if
//! d2/d1 is about R = 2^p. Then a_h is off by about d1/(R - 1); a quarter is added, as in the grid convergence index
//! (Roache 1994, J. Fluids Eng. 116, 405-413). Two runs show no order and have Roache's factor of 3. With adaptive
//! steps the tolerances differ by ten, and R = 10^(p/(p + 1)), as the error of a method of order p goes with h^p and
//! the tolerance with h^(p + 1).
//!
//! Runs may agree in a number by chance: two curves that tremble about each other cross somewhere. Where the order is
//! not shown, three things are set against that:
//! 1. Of a value at the end the curves count, and not their last points: the largest difference over the last tenth of
//!    the run takes the place of d1 and d2.
//! 2. d1 is not taken for less than d2/R, the difference that the coarser two lead to expect.
//! 3. A coarsest run of fewer than eight steps, and a d2/d1 well above R, show no order.

use serde::{Deserialize, Serialize};

/// Factor on an error that three runs show.
const SHOWN: f64 = 1.25;
/// Factor on an error that they do not.
const NOT_SHOWN: f64 = 3.0;
/// Powers of R between which d2/d1 counts as showing the order.
const ORDER: [f64; 2] = [0.6, 1.25];
/// [-] Difference over the value up to which values are equal: solvers of implicit steps stop before it.
pub(super) const EQUAL: f64 = 1e-9;
/// [-] Differences that grow by more than twice, and are more than this share of the value, contradict each other.
const LITTLE: f64 = 0.02;

/// How the error of a number is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum KnownError {
    /// three runs show the order of the method
    Order,
    /// two runs, or three that do not show the order
    Difference,
    /// the runs contradict each other: there is no error
    Contradiction,
    /// there was no other run
    #[default]
    Unknown,
}

impl KnownError {
    /// In words, for results.
    pub fn words(self) -> &'static str {
        match self {
            KnownError::Order => "three runs show the order of the method",
            KnownError::Difference => "difference of the runs",
            KnownError::Contradiction => {
                "the runs contradict each other: a snap or an event within a step; take shorter steps"
            }
            KnownError::Unknown => "no other run came to its end",
        }
    }
}

/// What a number is worth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Worth {
    /// estimate of the error, in the unit of the number; `None` where there is none
    pub error: Option<f64>,
    /// how it is known
    pub known: KnownError,
    /// the value that the runs extrapolate to, where they show the order
    pub extrapolated: Option<f64>,
}

/// The number of a run with step h beside those of other runs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Runs {
    /// with step h: the run itself
    pub own: f64,
    /// with 2 h and 4 h
    pub coarser: [Option<f64>; 2],
    /// with h/2, where 2 h cannot be run
    pub finer: Option<f64>,
    /// largest differences of the curves near the place where the number is read: of h and 2 h (or h and h/2), and of
    /// 2 h and 4 h
    pub apart: [f64; 2],
}

/// How much the error shrinks from one run to the next: R.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shrinks {
    /// R
    pub by: f64,
    /// [-] least error: of a time of a peak, the step, as it falls on steps
    pub least: f64,
    /// whether the values can be extrapolated
    pub extrapolates: bool,
    /// whether the runs have enough steps to show the order
    pub shows: bool,
}

impl Shrinks {
    /// Of a method of order `p` when fixed steps are doubled.
    pub fn with_steps(p: u32) -> Self {
        Shrinks { by: 2.0_f64.powi(p.min(8) as i32), least: 0.0, extrapolates: true, shows: true }
    }

    /// Of a method of order `p` when the tolerance is ten times as wide.
    pub fn with_tolerance(p: u32) -> Self {
        let p = f64::from(p);
        Shrinks { by: 10.0_f64.powf(p / (p + 1.0)), least: 0.0, extrapolates: false, shows: true }
    }

    /// The worth of a number.
    pub fn worth(self, runs: Runs) -> Worth {
        let Runs { own, coarser, finer, apart } = runs;
        let near = |a: f64| (a - own).abs().max(apart[0]);
        let worth = match (coarser, finer) {
            ([Some(a), Some(b)], _) => self.of_three([own, a, b], apart),
            ([Some(a), None], _) => self.known(NOT_SHOWN * near(a) / (self.by.min(4.0) - 1.0)),
            // The run itself is the coarser one of the two.
            ([None, _], Some(a)) => self.known(SHOWN * near(a) * self.by / (self.by - 1.0)),
            ([None, _], None) => Worth::default(),
        };
        let least = self.least.max(EQUAL * own.abs());
        Worth { error: worth.error.map(|error| error.max(least)), ..worth }
    }

    fn known(self, error: f64) -> Worth {
        Worth { error: Some(error), known: KnownError::Difference, extrapolated: None }
    }

    /// The worth of the distance between two runs, as of their motion: `near` from h to 2 h and `far` from 2 h to 4 h.
    pub fn of_distances(self, near: f64, far: Option<f64>) -> Worth {
        // On a line, the runs lie at these places.
        let worth = self.worth(Runs { coarser: [Some(near), far.map(|far| near + far)], ..Runs::default() });
        Worth { extrapolated: None, ..worth }
    }

    /// Of the numbers with h, 2 h and 4 h.
    fn of_three(self, [own, a, b]: [f64; 3], apart: [f64; 2]) -> Worth {
        let (near, far) = (a - own, b - a);
        let equal = EQUAL * own.abs().max(a.abs()).max(b.abs());
        let ratio = far / near;
        let [slow, fast] = ORDER.map(|power| self.by.powf(power));
        if self.shows && near.abs() > equal && (slow..=fast).contains(&ratio) {
            let error = SHOWN * near.abs() / (ratio.min(self.by) - 1.0);
            let extrapolated = self.extrapolates.then_some(own - near / (self.by - 1.0));
            return Worth { error: Some(error), known: KnownError::Order, extrapolated };
        }
        let (near, far) = (near.abs().max(apart[0]), far.abs().max(apart[1]));
        if near > 2.0 * far {
            return match near > LITTLE * own.abs() && near > equal {
                true => Worth { known: KnownError::Contradiction, ..Worth::default() },
                false => self.known(NOT_SHOWN * near),
            };
        }
        let shrinks = (far / near).min(self.by).max(2.0_f64.sqrt());
        self.known(SHOWN * (near / (shrinks - 1.0)).max(far / self.by))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn runs(own: f64, a: f64, b: f64) -> Runs {
        Runs { own, coarser: [Some(a), Some(b)], ..Runs::default() }
    }

    /// a_h = 1 + h^2: the error of h = 0.1 is 0.01, and the extrapolated value is exact.
    #[test]
    fn three_runs_show_the_order() {
        let a = |h: f64| 1.0 + h * h;
        let worth = Shrinks::with_steps(2).worth(runs(a(0.1), a(0.2), a(0.4)));
        assert_eq!(worth.known, KnownError::Order);
        assert!((worth.error.unwrap() - 1.25 * 0.01).abs() < 1e-12);
        assert!((worth.extrapolated.unwrap() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn differences_that_do_not_shrink_are_not_divided() {
        let worth = Shrinks::with_steps(2).worth(runs(1.0, 1.001, 1.0019));
        assert_eq!(worth.known, KnownError::Difference);
        assert!(worth.error.unwrap() >= 1e-3);
        // A difference of nothing, by chance.
        let chance = Shrinks::with_steps(2).worth(runs(1.0, 1.0, 1.12));
        assert!((chance.error.unwrap() - 1.25 * 0.12 / 4.0).abs() < 1e-12, "{chance:?}");
    }

    #[test]
    fn runs_that_contradict_each_other_have_no_error() {
        let snap = Shrinks::with_steps(2).worth(runs(4000.0, 2500.0, 2499.0));
        assert_eq!((snap.error, snap.known), (None, KnownError::Contradiction));
        // The noise of a number that is known to 1 % is no contradiction.
        assert_eq!(Shrinks::with_steps(2).worth(runs(4000.0, 4010.0, 4010.1)).error, Some(30.0));
    }

    #[test]
    fn two_runs_and_finer_ones() {
        let two = Shrinks::with_steps(2).worth(Runs { own: 1.0, coarser: [Some(1.03), None], ..Runs::default() });
        assert!((two.error.unwrap() - 0.03).abs() < 1e-12);
        // The error of the coarser of two runs of order 4 is their difference, nearly.
        let finer = Shrinks::with_steps(4).worth(Runs { own: 1.016, finer: Some(1.001), ..Runs::default() });
        assert!((finer.error.unwrap() - 1.25 * 0.015 * 16.0 / 15.0).abs() < 1e-12);
        assert_eq!(Shrinks::with_steps(1).worth(Runs { own: 1.0, ..Runs::default() }), Worth::default());
    }

    /// Curves that cross at the last instant are as far apart as they are before it, unless the order is shown.
    #[test]
    fn curves_that_cross_do_not_agree() {
        let shrinks = Shrinks::with_steps(2);
        let crossing = Runs { apart: [0.01, 0.02], ..runs(1.0, 1.0 + 1e-6, 1.0 + 1e-6) };
        assert!(shrinks.worth(crossing).error.unwrap() >= 0.01);
        let shown = Runs { apart: [0.01, 0.02], ..runs(1.01, 1.04, 1.16) };
        assert_eq!(shrinks.worth(shown), shrinks.worth(runs(1.01, 1.04, 1.16)));
        let few = Shrinks { shows: false, ..shrinks }.worth(runs(1.01, 1.04, 1.16));
        assert!(few.known == KnownError::Difference && few.error.unwrap() > 0.03);
    }

    /// The distances of motions are those of numbers on a line.
    #[test]
    fn distances_show_the_order_too() {
        let worth = Shrinks::with_steps(2).of_distances(0.03, Some(0.12));
        assert_eq!((worth.known, worth.extrapolated), (KnownError::Order, None));
        assert!((worth.error.unwrap() - 1.25 * 0.01).abs() < 1e-12);
    }
}
