//! What a study is asked to try: flags of the command, the `study` section of the case, or the study's own choice.

use serde::{Deserialize, Serialize};

use super::error::StudyError;
use super::step_grid::{decades, series};
use crate::case::schema::{Method, Study};

/// Times a run is repeated to measure its cost, if nobody says.
const REPEAT: u32 = 3;

/// What is asked for. A list that is not given is chosen; an empty one means none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StudyOptions {
    /// methods
    pub methods: Option<Vec<Method>>,
    /// [s] fixed steps
    pub steps: Option<Vec<f64>>,
    /// [-] tolerances of adaptive steps
    pub tolerances: Option<Vec<f64>>,
    /// times every run is made
    pub repeat: u32,
    /// [-] factors on the stiffness of all springs; empty: the case as it is
    pub stiffness_sweep: Vec<f64>,
}

/// What was typed.
#[derive(Clone, Copy, Debug, Default)]
pub struct TypedOptions<'a> {
    /// `--methods`
    pub methods: Option<&'a str>,
    /// `--steps`
    pub steps: Option<&'a str>,
    /// `--tolerances`
    pub tolerances: Option<&'a str>,
    /// `--repeat`
    pub repeat: Option<u32>,
    /// `--stiffness-sweep`
    pub stiffness_sweep: Option<&'a str>,
}

impl StudyOptions {
    /// Flags win over the case's section.
    ///
    /// # Errors
    /// A list that cannot be read, or a number out of range.
    pub fn of(typed: TypedOptions<'_>, section: Option<&Study>) -> Result<Self, StudyError> {
        let section = section.cloned().unwrap_or_default();
        let fraction = |x: f64| (x > 0.0 && x < 1.0).then_some(()).ok_or("above 0 and below 1");
        let positive = |x: f64| (x > 0.0 && x.is_finite()).then_some(()).ok_or("above 0");
        let list = |flag: &str, typed: Option<&str>, of: fn(f64, f64) -> Vec<f64>, allowed: &dyn Fn(f64) -> _| {
            typed.map(|text| numbers(flag, text, of, allowed)).transpose()
        };
        let methods = typed.methods.map(methods).transpose()?;
        Ok(StudyOptions {
            methods: methods.or(section.methods),
            steps: list("--steps", typed.steps, series, &positive)?.or(section.steps),
            tolerances: list("--tolerances", typed.tolerances, decades, &fraction)?.or(section.tolerances),
            repeat: typed.repeat.or(section.repeat).unwrap_or(REPEAT),
            stiffness_sweep: list("--stiffness-sweep", typed.stiffness_sweep, decades, &positive)?.unwrap_or_default(),
        })
    }
}

/// `1e-3,2e-3`, `1e-5..1e-1` or `none`, in descending order, each number once.
fn numbers(
    flag: &str,
    text: &str,
    series: fn(f64, f64) -> Vec<f64>,
    allowed: &dyn Fn(f64) -> Result<(), &'static str>,
) -> Result<Vec<f64>, StudyError> {
    let wrong = |why: String| StudyError::Usage(format!("{flag} {text}: {why}"));
    if text.trim() == "none" {
        return Ok(Vec::new());
    }
    let number = |word: &str| {
        let word = word.trim();
        let x: f64 = word
            .parse()
            .map_err(|_| wrong(format!("\"{word}\" is no number; expected 1e-3,2e-3 or 1e-5..1e-1 or none")))?;
        allowed(x).map_err(|range| wrong(format!("{word} must be {range}")))?;
        Ok::<f64, StudyError>(x)
    };
    let mut found = Vec::new();
    for part in text.split(',') {
        match part.split_once("..") {
            None => found.push(number(part)?),
            Some((a, b)) => {
                let (a, b) = (number(a)?, number(b)?);
                let some = series(a.min(b), a.max(b));
                if some.is_empty() {
                    return Err(wrong(
                        "there is no round number in this range; list the numbers themselves".to_owned(),
                    ));
                }
                found.extend(some);
            }
        }
    }
    found.sort_by(|a, b| b.total_cmp(a));
    found.dedup();
    Ok(found)
}

/// Names and JSON objects, parted by commas; or a JSON list.
fn methods(text: &str) -> Result<Vec<Method>, StudyError> {
    let wrong = |part: &str, why: String| StudyError::Usage(format!("--methods: {part}: {why}"));
    let parse = |part: &str| -> Result<Method, StudyError> {
        let part = part.trim();
        let json = if part.starts_with(['{', '"']) { part.to_owned() } else { format!("{part:?}") };
        let method: Method = serde_json::from_str(&json).map_err(|e| wrong(part, e.to_string()))?;
        super::bench::choice(&method)?;
        Ok(method)
    };
    let inner = text.trim();
    let inner = inner.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')).unwrap_or(inner);
    let (mut depth, mut from, mut found) = (0_u32, 0, Vec::new());
    for (i, c) in inner.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth = depth.saturating_sub(1),
            ',' if depth == 0 => {
                found.push(parse(inner.get(from..i).unwrap_or_default())?);
                from = i + 1;
            }
            _ => {}
        }
    }
    found.push(parse(inner.get(from..).unwrap_or_default())?);
    let mut once: Vec<Method> = Vec::with_capacity(found.len());
    for method in found {
        if !once.contains(&method) {
            once.push(method);
        }
    }
    Ok(once)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_as_typed() {
        let typed = TypedOptions {
            methods: Some(r#"newmark, {"hht": {"alpha": -0.2}},rk4"#),
            steps: Some("1e-3..1e-2"),
            tolerances: Some("1e-2..1e-4,3e-5"),
            ..TypedOptions::default()
        };
        let options = StudyOptions::of(typed, None).expect("good");
        let names: Vec<String> = options.methods.expect("given").iter().map(super::super::row::label).collect();
        assert_eq!(names, ["newmark", "hht(alpha=-0.2)", "rk4"]);
        assert_eq!(options.steps, Some(vec![1e-2, 5e-3, 2e-3, 1e-3]));
        assert_eq!(options.tolerances, Some(vec![1e-2, 1e-3, 1e-4, 3e-5]));
        assert_eq!((options.repeat, options.stiffness_sweep), (3, vec![]));
    }

    #[test]
    fn flags_win_over_the_case_and_none_means_none() {
        let section =
            Study { steps: Some(vec![0.1]), tolerances: Some(vec![0.1]), repeat: Some(7), ..Study::default() };
        let typed = TypedOptions { steps: Some("none"), ..TypedOptions::default() };
        let options = StudyOptions::of(typed, Some(&section)).expect("good");
        assert_eq!((options.steps, options.tolerances, options.repeat), (Some(vec![]), Some(vec![0.1]), 7));
    }

    #[test]
    fn bad_lists_are_refused_with_a_reason() {
        for (flag, text) in [
            ("steps", "0"),
            ("steps", "1e-3,x"),
            ("steps", "3e-3..4e-3"),
            ("tolerances", "1"),
            ("methods", "rk5"),
            ("methods", "rk4,,hht"),
            ("methods", r#"{"hht": {"alpha": 0.2}}"#),
        ] {
            let mut typed = TypedOptions::default();
            match flag {
                "steps" => typed.steps = Some(text),
                "tolerances" => typed.tolerances = Some(text),
                _ => typed.methods = Some(text),
            }
            let why = StudyOptions::of(typed, None).expect_err(text).to_string();
            assert!(why.len() > 20, "{text}: {why}");
        }
    }
}
