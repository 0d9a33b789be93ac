//! How the values of a key are distributed.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::super::vary::number;
use super::normal::{normal_quantile, normal_share};

/// A distribution of one key, or of several keys together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Law {
    /// the normal distribution, of which what is outside of `within` may be cut off
    Normal {
        /// mean, before anything is cut off
        mean: f64,
        /// standard deviation, above 0, before anything is cut off
        sd: f64,
        /// least and largest value
        within: Option<[f64; 2]>,
    },
    /// the logarithm is normal
    Lognormal {
        /// mean of the values, above 0
        mean: f64,
        /// standard deviation of the values, above 0
        sd: f64,
    },
    /// the same density from end to end
    Uniform {
        /// least value
        from: f64,
        /// largest value
        to: f64,
    },
    /// a distribution function with straight lines between its points
    Table {
        /// values, which grow
        values: Vec<f64>,
        /// [-] probability of lower values: from 0 to 1, without falling
        cumulative: Vec<f64>,
    },
    /// one of several rows, each with a value for every key
    Rows {
        /// the rows
        rows: Vec<Vec<Value>>,
        /// their shares, of any sum
        weights: Vec<f64>,
    },
}

impl Law {
    /// The values below which the share `u` of the distribution is, with `u` above 0 and below 1: the inverse of the
    /// distribution function, a value for each key.
    pub fn at(&self, u: f64) -> Vec<Value> {
        match self {
            Law::Rows { rows, weights } => rows.get(row_at(weights, u)).cloned().unwrap_or_default(),
            _ => vec![number(self.value(u))],
        }
    }

    /// The same of one number; NaN for rows.
    pub(super) fn value(&self, u: f64) -> f64 {
        match self {
            &Law::Normal { mean, sd, within } => {
                let [low, high] = within.map_or([0.0, 1.0], |ends| ends.map(|end| normal_share((end - mean) / sd)));
                let value = mean + sd * normal_quantile(low + u * (high - low));
                // Rounding alone may leave the interval.
                within.map_or(value, |[least, most]| value.max(least).min(most))
            }
            &Law::Lognormal { mean, sd } => {
                let variance = (sd / mean).powi(2).ln_1p();
                let log = mean.ln() - 0.5 * variance + variance.sqrt() * normal_quantile(u);
                log.exp()
            }
            &Law::Uniform { from, to } => from + u * (to - from),
            Law::Table { values, cumulative } => {
                let after = cumulative.partition_point(|share| *share < u).clamp(1, values.len().max(2) - 1);
                let (Some([a, b]), Some([p, q])) = (values.get(after - 1..=after), cumulative.get(after - 1..=after))
                else {
                    return f64::NAN;
                };
                a + (b - a) * if q > p { (u - p) / (q - p) } else { 0.5 }
            }
            Law::Rows { .. } => f64::NAN,
        }
    }

    /// Why no values can be drawn from it, if so.
    pub(super) fn fault(&self) -> Option<String> {
        let finite = |numbers: &[f64]| numbers.iter().all(|x| x.is_finite());
        match self {
            &Law::Normal { mean, sd, within } => {
                let [least, most] = within.unwrap_or([mean - sd, mean + sd]);
                if !finite(&[mean, sd, least, most]) || sd <= 0.0 {
                    return Some("the mean must be finite, and the standard deviation above 0".to_owned());
                }
                if least >= most {
                    return Some("the first end must be below the second".to_owned());
                }
                let share = normal_share((most - mean) / sd) - normal_share((least - mean) / sd);
                // Of less, the distribution function has too few digits in the tail.
                (share < 1e-6).then(|| format!("only {share:.1e} of the distribution is between {least} and {most}"))
            }
            &Law::Lognormal { mean, sd } => (!finite(&[mean, sd]) || mean <= 0.0 || sd <= 0.0)
                .then(|| "mean and standard deviation must be above 0; both are those of the values".to_owned()),
            &Law::Uniform { from, to } => (!finite(&[from, to]) || from >= to)
                .then(|| "both ends must be finite, and the first below the second".to_owned()),
            Law::Table { values, cumulative } => {
                let grows = |list: &[f64], equal: bool| {
                    list.windows(2).all(|pair| pair[0] < pair[1] || (equal && pair[0] == pair[1]))
                };
                let ends = [cumulative.first(), cumulative.last()] == [Some(&0.0), Some(&1.0)];
                let good = values.len() > 1 && finite(values) && finite(cumulative);
                (!good || !ends || !grows(values, false) || !grows(cumulative, true))
                    .then(|| "values must grow, and their cumulative probabilities go from 0 to 1".to_owned())
            }
            Law::Rows { rows, weights } => {
                let good = weights.iter().all(|weight| weight.is_finite() && *weight >= 0.0);
                let sum: f64 = weights.iter().sum();
                if rows.is_empty() {
                    return Some("there are no values".to_owned());
                }
                (!good || !sum.is_finite() || sum <= 0.0)
                    .then(|| "weights must be 0 or more, and one of them above 0".to_owned())
            }
        }
    }

    /// In words.
    pub fn words(&self) -> String {
        match self {
            Law::Normal { mean, sd, within } => {
                let within = within.map_or(String::new(), |[a, b]| format!(", between {a} and {b}"));
                format!("normal, {mean} ± {sd}{within}")
            }
            Law::Lognormal { mean, sd } => format!("lognormal, {mean} ± {sd}"),
            Law::Uniform { from, to } => format!("uniform from {from} to {to}"),
            Law::Table { values, .. } => format!(
                "a table from {} to {}",
                values.first().copied().unwrap_or_default(),
                values.last().copied().unwrap_or_default()
            ),
            Law::Rows { rows, weights } => {
                let equal = weights.windows(2).all(|pair| pair[0] == pair[1]);
                let how = if equal { "equally likely" } else { "with weights" };
                format!("one of {} {}, {how}", rows.len(), if rows.len() == 1 { "row" } else { "rows" })
            }
        }
    }
}

/// The row at the share `u` of the sum of weights.
fn row_at(weights: &[f64], u: f64) -> usize {
    let wanted = u * weights.iter().sum::<f64>();
    let mut sum = 0.0;
    let reached = weights.iter().position(|weight| {
        sum += weight;
        *weight > 0.0 && sum >= wanted
    });
    // The last sum may be less by rounding.
    reached.or_else(|| weights.iter().rposition(|weight| *weight > 0.0)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// Mean and standard deviation, by the midpoint rule over the shares, are those that were given.
    #[test]
    fn means_and_deviations_are_those_given() {
        for (law, mean, sd) in [
            (Law::Normal { mean: 3.0, sd: 0.5, within: None }, 3.0, 0.5),
            (Law::Lognormal { mean: 2.0, sd: 0.6 }, 2.0, 0.6),
            (Law::Uniform { from: 1.0, to: 4.0 }, 2.5, 3.0 / 12.0_f64.sqrt()),
            (
                Law::Table { values: vec![0.0, 1.0, 3.0], cumulative: vec![0.0, 0.5, 1.0] },
                1.25,
                (7.0_f64 / 3.0 - 1.5625).sqrt(),
            ),
            // Of the standard normal beyond 0: sqrt(2/pi) and sqrt(1 - 2/pi).
            (Law::Normal { mean: 0.0, sd: 1.0, within: Some([0.0, 50.0]) }, 0.797_884_560_8, 0.602_810_297),
        ] {
            assert_eq!(law.fault(), None);
            let n = 200_000;
            let values: Vec<f64> = (0..n).map(|i| law.value((i as f64 + 0.5) / f64::from(n))).collect();
            let found = values.iter().sum::<f64>() / f64::from(n);
            let deviation = (values.iter().map(|x| (x - found).powi(2)).sum::<f64>() / f64::from(n)).sqrt();
            assert!((found - mean).abs() < 1e-4 && (deviation - sd).abs() < 1e-3, "{law:?}: {found} {deviation}");
        }
    }

    #[test]
    fn rows_have_their_shares() {
        let law =
            Law::Rows { rows: vec![vec![json!("a")], vec![json!(2)], vec![json!(3)]], weights: vec![1.0, 0.0, 3.0] };
        let at = |u: f64| law.at(u)[0].clone();
        assert_eq!([at(1e-9), at(0.25), at(0.2501), at(1.0 - 1e-12)], [json!("a"), json!("a"), json!(3), json!(3)]);
    }
}
