//! When a sample is large enough: a statistic of a column is known within a margin.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::estimate::{Estimate, deviation, mean, quantile};
use crate::error::StudyError;

/// A number of a distribution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Statistic {
    /// the mean
    Mean,
    /// the standard deviation
    Sd,
    /// the value below which so many percent are
    Percentile(f64),
}

/// A statistic, and how well it must be known.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rule {
    /// the column of the sweep
    pub column: String,
    /// its statistic
    pub statistic: Statistic,
    /// [-] the largest margin of its interval over the number itself
    pub share: f64,
}

impl Statistic {
    /// The statistic of some numbers; `None` of fewer than two.
    pub fn of(self, values: &[f64]) -> Option<Estimate> {
        if values.len() < 2 {
            return None;
        }
        Some(match self {
            Statistic::Mean => mean(values),
            Statistic::Sd => deviation(values),
            Statistic::Percentile(percent) => {
                let mut sorted = values.to_vec();
                sorted.sort_by(f64::total_cmp);
                quantile(&sorted, 0.01 * percent)
            }
        })
    }
}

impl Rule {
    /// Reads `2% of p99 COLUMN`; the statistic is `mean`, `sd` or `p` and a percentage.
    ///
    /// # Errors
    /// The text, and what is expected.
    pub fn parse(text: &str) -> Result<Self, StudyError> {
        let read = || {
            let (margin, rest) = text.split_once(" of ")?;
            let percent: f64 = margin.trim().strip_suffix('%')?.trim().parse().ok()?;
            let (statistic, column) = rest.trim().split_once(' ')?;
            let statistic = match statistic {
                "mean" => Statistic::Mean,
                "sd" => Statistic::Sd,
                other => {
                    Statistic::Percentile(other.strip_prefix('p')?.parse().ok().filter(|p| *p > 0.0 && *p < 100.0)?)
                }
            };
            let rule = Rule { column: column.trim().to_owned(), statistic, share: 0.01 * percent };
            (percent > 0.0 && percent.is_finite() && !rule.column.is_empty()).then_some(rule)
        };
        read().ok_or_else(|| {
            StudyError::Usage(format!(
                "--until {text}: expected \"2% of p99 COLUMN\", where p99 may be any percentile, mean or sd"
            ))
        })
    }

    /// How well the statistic is known: the margin of its interval over its size; `None` where there is no interval.
    pub fn reached(&self, values: &[f64]) -> Option<f64> {
        let estimate = self.statistic.of(values)?;
        Some(estimate.margin()? / estimate.value.abs()).filter(|share| share.is_finite())
    }

    /// Whether these numbers are enough.
    pub fn met(&self, values: &[f64]) -> bool {
        self.reached(values).is_some_and(|share| share <= self.share)
    }
}

impl fmt::Display for Statistic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Statistic::Mean => f.write_str("mean"),
            Statistic::Sd => f.write_str("sd"),
            Statistic::Percentile(percent) => write!(f, "p{percent}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_as_typed() {
        let rule = Rule::parse("2% of p99 riser.tension.peak").expect("a rule");
        let expected = (Statistic::Percentile(99.0), 0.02, "riser.tension.peak".to_owned());
        assert_eq!((rule.statistic, rule.share, rule.column), expected);
        assert_eq!(Rule::parse("0.5 % of sd x").expect("a rule").statistic, Statistic::Sd);
        for text in ["2 of p99 x", "2% of x", "2% of p100 x", "0% of mean x", "2% p99 x", "2% of p99 "] {
            let error = Rule::parse(text).expect_err(text).to_string();
            assert!(error.contains(text) && error.contains("p99 COLUMN"), "{error}");
        }
    }

    /// The 99th percentile has an interval from 368 numbers on, whatever they are.
    #[test]
    fn a_percentile_needs_its_numbers() {
        let rule = Rule::parse("50% of p99 x").expect("a rule");
        let values = |n: usize| (0..n).map(|i| 100.0 + i as f64 / n as f64).collect::<Vec<f64>>();
        assert!(!rule.met(&values(367)) && rule.met(&values(368)));
    }
}
