//! The values of a key, as `--vary` gives them.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::error::StudyError;

/// Most values of a key.
const MOST: usize = 100_000;
/// Digits after the point of a value within a range: enough for any grid, and 0.3 is not 0.30000000000000004.
const DIGITS: usize = 11;

/// A key and its values.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Vary {
    /// dotted path in the case, as `--set` takes it
    pub key: String,
    /// its values, in the order of the runs; empty where they are drawn
    pub values: Vec<Value>,
    /// whether the values have equal ratios
    pub log: bool,
}

impl Vary {
    /// Reads `KEY=A..B:N`, `KEY=log:A..B:N` or `KEY=a,b,c`; the values of a list are JSON, or plain text.
    ///
    /// # Errors
    /// The text with its fault, and what is allowed.
    pub fn parse(text: &str) -> Result<Self, StudyError> {
        let wrong = |why: &str| StudyError::Usage(format!("--vary {text}: {why}"));
        let (key, given) = text
            .split_once('=')
            .filter(|(key, _)| !key.trim().is_empty())
            .ok_or_else(|| wrong("expected KEY=A..B:N, KEY=log:A..B:N or KEY=a,b,c"))?;
        let (log, rest) = given.strip_prefix("log:").map_or((false, given), |rest| (true, rest));
        let values = match range(rest) {
            Some(range) => range.and_then(|range| range.values(log)).map_err(|why| wrong(&why))?,
            None if log => return Err(wrong("log: needs a range of numbers, log:A..B:N")),
            None => list(rest).map_err(|why| wrong(&why))?,
        };
        let mut known = BTreeSet::new();
        if let Some(twice) = values.iter().find(|value| !known.insert(value.to_string())) {
            return Err(wrong(&format!("the value {twice} is there twice")));
        }
        Ok(Vary { key: key.trim().to_owned(), values, log })
    }

    /// All keys; none may be there twice.
    ///
    /// # Errors
    /// As [`Vary::parse`]; no key; a key that is there twice.
    pub fn parse_all(texts: &[String]) -> Result<Vec<Self>, StudyError> {
        let all = texts.iter().map(|text| Vary::parse(text)).collect::<Result<Vec<_>, _>>()?;
        if all.is_empty() {
            return Err(StudyError::Usage("nothing varies: give --vary KEY=A..B:N or KEY=a,b,c".to_owned()));
        }
        for (i, vary) in all.iter().enumerate() {
            if all[..i].iter().any(|other| other.key == vary.key) {
                return Err(StudyError::Usage(format!("--vary {} is given twice; list its values in one", vary.key)));
            }
        }
        Ok(all)
    }

    /// The values as numbers, if all of them are.
    pub fn numbers(&self) -> Option<Vec<f64>> {
        self.values.iter().map(Value::as_f64).collect()
    }
}

/// N numbers from A to B.
struct Range {
    from: f64,
    to: f64,
    count: usize,
}

/// A range, if the text begins like one; else it is a list.
fn range(text: &str) -> Option<Result<Range, String>> {
    let (from, rest) = text.split_once("..")?;
    let from: f64 = from.trim().parse().ok()?;
    let read = || {
        let (to, count) = rest.split_once(':').ok_or("the number of values is missing: A..B:N")?;
        let to: f64 = to.trim().parse().map_err(|_| format!("\"{to}\" is no number"))?;
        let whole = count.trim().parse::<usize>();
        let count = whole.map_err(|_| format!("\"{count}\" is no number of values; expected a whole number"))?;
        if !from.is_finite() || !to.is_finite() {
            return Err("the ends of a range must be finite".to_owned());
        }
        if !(2..=MOST).contains(&count) {
            return Err(format!("{count} values; a range has 2 to {MOST}"));
        }
        if from == to {
            return Err("both ends of the range are equal".to_owned());
        }
        Ok(Range { from, to, count })
    };
    Some(read())
}

impl Range {
    fn values(&self, log: bool) -> Result<Vec<Value>, String> {
        let &Range { from, to, count } = self;
        if log && (from <= 0.0 || to <= 0.0) {
            return Err("both ends must be above 0 for equal ratios".to_owned());
        }
        let value = |i: usize| {
            let share = i as f64 / (count - 1) as f64;
            match i {
                0 => from,
                i if i + 1 == count => to,
                _ if log => rounded(from * (to / from).powf(share)),
                _ => rounded(from + (to - from) * share),
            }
        };
        Ok((0..count).map(|i| number(value(i))).collect())
    }
}

fn rounded(x: f64) -> f64 {
    format!("{x:.DIGITS$e}").parse().unwrap_or(x)
}

/// As JSON; a whole number is written as one, so that keys that count take it.
pub(super) fn number(x: f64) -> Value {
    const EXACT: f64 = 9.0e15;
    if x.fract() == 0.0 && x.abs() < EXACT { Value::from(x as i64) } else { Value::from(x) }
}

/// Values separated by commas outside of brackets and quotes.
fn list(text: &str) -> Result<Vec<Value>, String> {
    let (mut depth, mut quoted, mut escaped) = (0_i32, false, false);
    let mut parts = vec![String::new()];
    for c in text.chars() {
        match c {
            _ if escaped => escaped = false,
            '\\' if quoted => escaped = true,
            '"' => quoted = !quoted,
            '[' | '{' if !quoted => depth += 1,
            ']' | '}' if !quoted => depth -= 1,
            ',' if !quoted && depth == 0 => {
                parts.push(String::new());
                continue;
            }
            _ => {}
        }
        if let Some(part) = parts.last_mut() {
            part.push(c);
        }
    }
    if parts.len() > MOST {
        return Err(format!("{} values; a list has at most {MOST}", parts.len()));
    }
    parts.iter().map(|part| list_value(part)).collect()
}

/// A value of a list or of a file: JSON, or plain text.
pub(super) fn list_value(text: &str) -> Result<Value, String> {
    match text.trim() {
        "" => Err("a value is missing between two commas".to_owned()),
        text => Ok(serde_json::from_str(text).unwrap_or_else(|_| Value::String(text.to_owned()))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn values(text: &str) -> Value {
        Value::Array(Vary::parse(text).expect("good").values)
    }

    #[test]
    fn values_as_typed() {
        assert_eq!(values("k=1..3:5"), json!([1, 1.5, 2, 2.5, 3]));
        assert_eq!(values("k=0.1..0.5:5"), json!([0.1, 0.2, 0.3, 0.4, 0.5]));
        assert_eq!(values("k=2..-2:3"), json!([2, 0, -2]));
        assert_eq!(values("k=log:1e-2..1e2:5"), json!([0.01, 0.1, 1, 10, 100]));
        assert_eq!(values("k=5"), json!([5]));
        assert_eq!(values("k=rk4,{\"hht\": {\"alpha\": -0.2}},[1,2],\"a,b\""), {
            json!(["rk4", {"hht": {"alpha": -0.2}}, [1, 2], "a,b"])
        });
        assert_eq!(values("file=../a.vtu,../b.vtu"), json!(["../a.vtu", "../b.vtu"]));
        assert!(Vary::parse("k=log:1..8:4").expect("good").log);
    }

    #[test]
    fn what_is_no_list_of_values_says_why() {
        for (text, why) in [
            ("k", "expected KEY="),
            ("=1,2", "expected KEY="),
            ("k=1..2", "number of values is missing"),
            ("k=1..2:1", "2 to 100000"),
            ("k=1..2:x", "whole number"),
            ("k=1..x:3", "no number"),
            ("k=1..1:3", "equal"),
            ("k=log:-1..1:3", "above 0"),
            ("k=log:1,2", "needs a range"),
            ("k=1,,2", "missing between"),
            ("k=1,2,1", "twice"),
        ] {
            let error = Vary::parse(text).expect_err(text).to_string();
            assert!(error.contains(why) && error.contains(text), "{text}: {error}");
        }
        assert!(Vary::parse_all(&["k=1,2".to_owned(), "k=3".to_owned()]).is_err(), "a key is given twice");
        assert!(Vary::parse_all(&[]).is_err());
    }
}
