//! The distributions that intervals and draws need: normal, Student's t, binomial.

use std::f64::consts::{PI, SQRT_2};

/// [-] Share of the standard normal distribution below x.
pub(super) fn normal_share(x: f64) -> f64 {
    0.5 * libm::erfc(-x / SQRT_2)
}

/// The value below which the share p of the standard normal distribution is, for p above 0 and below 1. Hastings's
/// rational formula (Abramowitz & Stegun 1964, 26.2.23) is within 4.5e-4; two steps by Halley's rule, of third order,
/// leave rounding only.
pub(super) fn normal_quantile(p: f64) -> f64 {
    if p > 0.5 {
        // 1 - p is exact here, and the lower tail has all its digits.
        return -normal_quantile(1.0 - p);
    }
    let t = (-2.0 * p.ln()).sqrt();
    let mut x = (2.515517 + t * (0.802853 + t * 0.010328)) / (1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308))) - t;
    for _ in 0..2 {
        let u = (normal_share(x) - p) * (2.0 * PI).sqrt() * (0.5 * x * x).exp();
        x -= u / (1.0 + 0.5 * x * u);
    }
    x
}

/// The value below which the share p of Student's t with v degrees of freedom is, by the expansion of Cornish and
/// Fisher (Abramowitz & Stegun 1964, 26.7.5): at 97.5 % within 1 % from v = 2 on, and 1e-5 from v = 9 on.
pub(crate) fn student_quantile(p: f64, v: f64) -> f64 {
    let z = normal_quantile(p);
    let powers = |coefficients: &[f64]| coefficients.iter().rev().fold(0.0, |sum, c| sum * z * z + c) * z;
    let terms = [
        powers(&[1.0, 1.0]) / 4.0,
        powers(&[3.0, 16.0, 5.0]) / 96.0,
        powers(&[-15.0, 17.0, 19.0, 3.0]) / 384.0,
        powers(&[-945.0, -1920.0, 1482.0, 776.0, 79.0]) / 92160.0,
    ];
    terms.iter().rev().fold(0.0, |sum, term| (sum + term) / v) + z
}

/// [-] Probability that just k of n independent events come about, each with probability p above 0 and below 1.
pub(super) fn binomial(k: usize, n: usize, p: f64) -> f64 {
    let factorial = |m: usize| libm::lgamma(m as f64 + 1.0);
    let ways = factorial(n) - factorial(k) - factorial(n - k);
    (ways + k as f64 * p.ln() + (n - k) as f64 * (-p).ln_1p()).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `scipy.stats.norm.ppf` and `t.ppf` of SciPy 1.17.1.
    #[test]
    fn quantiles_are_those_of_scipy() {
        for (p, expected) in [
            (1e-9, -5.997_807_015_007_686_5),
            (0.025, -1.959_963_984_540_054_5),
            (0.3, -0.524_400_512_708_040_9),
            (0.999, 3.090_232_306_167_813),
        ] {
            let found = normal_quantile(p);
            assert!((found - expected).abs() < 1e-12 * f64::abs(expected), "{p}: {found}, not {expected}");
        }
        assert!(normal_quantile(0.5).abs() < 1e-15);
        for (v, expected, share) in [(9.0, 2.262_157_162_798_205, 1e-5), (2.0, 4.302_652_729_749_462, 1e-2)] {
            let found = student_quantile(0.975, v);
            assert!((found / expected - 1.0).abs() < share, "{v}: {found}, not {expected}");
        }
    }

    /// The inverse of the distribution function from one tail to the other.
    #[test]
    fn shares_and_quantiles_are_inverse() {
        for i in 1..4000 {
            let p = f64::from(i) / 4000.0;
            assert!((normal_share(normal_quantile(p)) - p).abs() < 1e-14, "{p}");
        }
        for power in [-300, -100, -20, -10] {
            let p = 10_f64.powi(power);
            assert!((normal_share(normal_quantile(p)) / p - 1.0).abs() < 1e-9, "1e{power}");
        }
    }

    #[test]
    fn probabilities_add_up_to_one() {
        let sum: f64 = (0..=500).map(|k| binomial(k, 500, 0.3)).sum();
        assert!((sum - 1.0).abs() < 1e-11 && (binomial(2, 4, 0.5) - 0.375).abs() < 1e-14);
    }
}
