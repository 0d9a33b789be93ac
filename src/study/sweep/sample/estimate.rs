//! What a column of a sample says of its distribution: moments, quantiles and extremes, each with the interval that
//! holds the true number with 95 % probability where rows are independent.

use serde::Serialize;

use super::normal::{binomial, normal_quantile, student_quantile};

/// [-] Probability that an interval misses the number, to either side.
const TAIL: f64 = 0.025;

/// A number with its interval of 95 %.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Estimate {
    /// the number
    pub value: f64,
    /// lower end; `None` where the sample is too small for one
    pub low: Option<f64>,
    /// upper end
    pub high: Option<f64>,
}

impl Estimate {
    /// With the same margin to both sides.
    pub(super) fn with_margin(value: f64, margin: f64) -> Self {
        let end = |x: f64| Some(x).filter(|x| x.is_finite());
        Estimate { value, low: end(value - margin), high: end(value + margin) }
    }

    /// The larger distance to an end; `None` where one is missing.
    pub fn margin(&self) -> Option<f64> {
        Some((self.value - self.low?).max(self.high? - self.value))
    }
}

/// The margin of an interval over the standard error of a normal number: 1.96.
pub(super) fn errors_of_margin() -> f64 {
    normal_quantile(1.0 - TAIL)
}

/// The mean of numbers; NaN of none.
pub(super) fn mean_of(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The mean, with Student's interval, which is that of normal numbers and in the limit that of all.
pub fn mean(values: &[f64]) -> Estimate {
    let n = values.len() as f64;
    let errors = student_quantile(1.0 - TAIL, n - 1.0);
    Estimate::with_margin(mean_of(values), errors * deviation(values).value / n.sqrt())
}

/// The standard deviation s. The variance of s^2 is (m4 - s^4 (n - 3)/(n - 1))/n, with the fourth central moment m4.
pub fn deviation(values: &[f64]) -> Estimate {
    let (n, mean) = (values.len() as f64, mean_of(values));
    let moment = |power: i32| values.iter().map(|x| (x - mean).powi(power)).sum::<f64>();
    let variance = moment(2) / (n - 1.0);
    let of_variance = (moment(4) / n - variance * variance * (n - 3.0) / (n - 1.0)) / n;
    let value = variance.sqrt();
    let margin = if value > 0.0 { errors_of_margin() * of_variance.max(0.0).sqrt() / (2.0 * value) } else { 0.0 };
    let margin = Estimate::with_margin(value, margin);
    Estimate { low: margin.low.map(|low| low.max(0.0)), ..margin }
}

/// The value below which the share p of the distribution is: between the order statistics around (n - 1) p, as NumPy
/// and R have it. The interval is from one order statistic to another and holds for every distribution: x_(l) is above
/// the quantile with the probability that fewer than l of n values are below it, which is binomial.
pub fn quantile(sorted: &[f64], p: f64) -> Estimate {
    let n = sorted.len();
    let at = p * n.saturating_sub(1) as f64;
    let (floor, share) = (at.floor() as usize, at.fract());
    let order = |rank: usize| sorted.get(rank).copied();
    let a = order(floor).unwrap_or(f64::NAN);
    let b = order(floor + 1).unwrap_or(a);
    let [low, high] = ranks(n, p).map(|rank| rank.and_then(|rank| order(rank - 1)));
    Estimate { value: a + (b - a) * share, low, high }
}

/// The ranks, from 1, of the order statistics that are the ends of the interval of a quantile: the last one below which
/// fewer values are with 2.5 % at most, and the first one below which fewer are with 97.5 % at least.
fn ranks(n: usize, p: f64) -> [Option<usize>; 2] {
    let mut ends = [None, None];
    // The probability that fewer values than the rank are below the quantile.
    let mut fewer = 0.0;
    for rank in 1..=n {
        fewer += binomial(rank - 1, n, p);
        if fewer <= TAIL {
            ends[0] = Some(rank);
        } else if fewer >= 1.0 - TAIL {
            ends[1] = Some(rank);
            break;
        }
    }
    ends
}

/// [-] With a probability of 95 % at most this share of the distribution is beyond the largest of n independent values:
/// 1 - 0.05^(1/n) (Wilks 1941, Ann. Math. Stat. 12, 91-96).
pub fn beyond_largest(n: usize) -> f64 {
    1.0 - 0.05_f64.powf(1.0 / n as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::random::SplitMix64;

    const VALUES: [f64; 10] = [3.1, -2.0, 7.5, 0.4, 5.5, 1.25, 9.0, 2.2, -4.5, 6.0];

    const MEAN: f64 = 2.845;
    const SD: f64 = 4.255_483_390_742_923;
    const T9: f64 = 2.262_157_162_798_205;
    const RANKS: [(usize, f64, [Option<usize>; 2]); 5] = [
        (100, 0.5, [Some(40), Some(61)]),
        (100, 0.95, [Some(90), Some(100)]),
        (368, 0.99, [Some(360), Some(368)]),
        (367, 0.99, [Some(359), None]),
        (1000, 0.99, [Some(983), Some(997)]),
    ];

    fn near(found: f64, expected: f64) -> bool {
        (found - expected).abs() < 1e-9 * expected.abs().max(1.0)
    }

    /// `numpy.quantile`, `mean`, `std(ddof=1)` of NumPy 2.4.6, and the quantile of Student's t of SciPy 1.17.1.
    #[test]
    fn numbers_are_those_of_numpy() {
        let mut sorted = VALUES;
        sorted.sort_by(f64::total_cmp);
        for (p, expected) in [(0.01, -4.275), (0.05, -3.375), (0.5, 2.65), (0.95, 8.325), (0.99, 8.865)] {
            assert!(near(quantile(&sorted, p).value, expected), "{p}: {:?}", quantile(&sorted, p));
        }
        let (mean, sd) = (mean(&VALUES), deviation(&VALUES).value);
        assert!(near(mean.value, MEAN) && near(sd, SD), "{mean:?} {sd}");
        let margin = T9 * SD / 10.0_f64.sqrt();
        assert!((mean.margin().expect("both ends") / margin - 1.0).abs() < 1e-5, "{mean:?}");
    }

    /// Ranks by sums over `scipy.stats.binom.cdf` of SciPy 1.17.1.
    #[test]
    fn ranks_are_those_of_the_binomial_distribution() {
        for (n, p, expected) in RANKS {
            assert_eq!(ranks(n, p), expected, "{n} values, {p}");
        }
    }

    /// Of 2000 samples of 200 exponential numbers, as many intervals hold the true number as they say: mean 1, standard
    /// deviation 1, quantiles -ln(1 - p). Those of quantiles hold it at least so often; moments of 200 skew numbers
    /// may miss it by a few hundredths more.
    #[test]
    fn intervals_hold_what_they_say() {
        let mut numbers = SplitMix64::of_seed(5);
        let mut draw = || -numbers.uniform().ln();
        let mut missed = [0; 5];
        let trials = 2000;
        for _ in 0..trials {
            let mut values: Vec<f64> = (0..200).map(|_| draw()).collect();
            let moments = [(mean(&values), 1.0), (deviation(&values), 1.0)];
            values.sort_by(f64::total_cmp);
            let quantiles = [0.05, 0.5, 0.95].map(|p: f64| (quantile(&values, p), -(1.0 - p).ln()));
            for (count, (found, truth)) in missed.iter_mut().zip(moments.into_iter().chain(quantiles)) {
                let [low, high] = [found.low, found.high].map(|end| end.expect("an end"));
                *count += u32::from(truth < low || truth > high);
            }
        }
        let missed = missed.map(|count| f64::from(count) / f64::from(trials));
        assert!(missed[0] < 0.08 && missed[1] < 0.14 && missed[2..].iter().all(|share| *share < 0.06), "{missed:?}");
        assert!(missed.iter().all(|share| *share > 0.01), "intervals are not too wide: {missed:?}");
    }

    /// The largest of n values leaves 1 - 0.95 = 5 % of samples with more beyond it.
    #[test]
    fn what_is_beyond_the_largest() {
        assert!(near((1.0 - beyond_largest(59)).powi(59), 0.05));
        assert!(beyond_largest(59) < 0.05 && beyond_largest(58) > 0.05, "Wilks's 59 runs");
    }
}
