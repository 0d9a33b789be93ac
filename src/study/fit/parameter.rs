//! What is fitted: a key of the case within a range.

use serde::Serialize;
use serde_json::Value;

use crate::error::StudyError;

/// [-] Part of a parameter's size, or of its range if that is smaller, by which it is changed for a derivative.
const CHANGE: f64 = 1e-3;

/// The range of a parameter; least squares moves a number u in [0, 1] across it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Range {
    /// lowest value
    pub low: f64,
    /// highest value
    pub high: f64,
    /// whether equal steps of u are equal ratios of values, not equal differences
    pub log: bool,
}

/// A parameter.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Parameter {
    /// dotted path in the case, as `--set` takes it
    pub key: String,
    /// where it may be
    pub range: Range,
}

impl Parameter {
    /// Reads `KEY=A..B` or `KEY=log:A..B`.
    ///
    /// # Errors
    /// The text with its fault.
    pub fn parse(text: &str) -> Result<Self, StudyError> {
        let wrong = |why: &str| StudyError::Usage(format!("--vary {text}: {why}"));
        let form = "expected KEY=A..B or KEY=log:A..B, the range in which the value is searched";
        let (key, given) = text.split_once('=').filter(|(key, _)| !key.trim().is_empty()).ok_or_else(|| wrong(form))?;
        Ok(Parameter { key: key.trim().to_owned(), range: Range::parse(given).map_err(wrong)? })
    }

    /// All parameters; none may be there twice.
    ///
    /// # Errors
    /// As [`Parameter::parse`]; a key that is there twice.
    pub fn parse_all(texts: &[String]) -> Result<Vec<Self>, StudyError> {
        let all = texts.iter().map(|text| Parameter::parse(text)).collect::<Result<Vec<_>, _>>()?;
        for (i, one) in all.iter().enumerate() {
            if all.iter().take(i).any(|other| other.key == one.key) {
                return Err(StudyError::Usage(format!("--vary {} is given twice", one.key)));
            }
        }
        Ok(all)
    }

    /// The number that a case has for it.
    pub(super) fn in_case(&self, case: &Value) -> Option<f64> {
        case.pointer(&format!("/{}", self.key.replace('.', "/")))?.as_f64()
    }
}

impl Range {
    /// Reads `A..B` or `log:A..B`.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(text: &str) -> Result<Self, &'static str> {
        let (log, rest) = text.trim().strip_prefix("log:").map_or((false, text.trim()), |rest| (true, rest));
        let (low, high) = rest.split_once("..").ok_or("expected A..B or log:A..B, the range that is searched")?;
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
        let (low, high) = number(low).zip(number(high)).ok_or("the ends of the range must be numbers")?;
        if low >= high {
            return Err("the first end of the range must be below the second");
        }
        if log && low <= 0.0 {
            return Err("log: needs a range above 0");
        }
        Ok(Range { low, high, log })
    }

    /// The value at u.
    pub(super) fn value(&self, u: f64) -> f64 {
        let &Range { low, high, log } = self;
        if u >= 1.0 {
            high
        } else if u <= 0.0 {
            low
        } else if log {
            low * (high / low).powf(u)
        } else {
            low + u * (high - low)
        }
    }

    /// The u of a value; `None` outside of the range.
    pub(super) fn place(&self, value: f64) -> Option<f64> {
        let &Range { low, high, log } = self;
        let inside = (low..=high).contains(&value);
        inside.then(|| if log { (value / low).ln() / (high / low).ln() } else { (value - low) / (high - low) })
    }

    /// d value/du at u.
    pub(super) fn slope(&self, u: f64) -> f64 {
        let &Range { low, high, log } = self;
        if log { self.value(u) * (high / low).ln() } else { high - low }
    }

    /// By how much u is changed for a derivative at u.
    pub(super) fn change(&self, u: f64) -> f64 {
        let (size, range) = (self.value(u).abs(), self.slope(u));
        (CHANGE * size / range).clamp(1e-2 * CHANGE, CHANGE)
    }
}
