//! What a study is asked to try: flags of the command, the `study` section of the case, or the study's own choice.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::error::StudyError;
use super::prepared_case::choice;
use super::step_grid::{decades, series};
use crate::case::schema::{ClothModel, Method, Study};
use crate::model::quantity::read_names;

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
    /// models of the cloth, each once; empty: the cloth as the case has it
    #[serde(default)]
    pub models: Vec<ClothModel>,
    /// quantities that runs are ranked by, each once; empty: the motion
    #[serde(default)]
    pub quantities: Vec<String>,
}

/// What was typed.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct TypedOptions {
    /// Methods, separated by commas: newmark,rk4,'{"hht": {"alpha": -0.2}}' [default: all]
    #[arg(long, value_name = "LIST", conflicts_with_all = ["shard", "merge"])]
    pub methods: Option<String>,
    /// Fixed steps [s]: 1e-3,5e-4 or 1e-5..1e-1 (1, 2, 5 times powers of ten) or none [default: chosen around the
    /// scene's periods]
    #[arg(long, value_name = "LIST", allow_hyphen_values = true, conflicts_with_all = ["shard", "merge"])]
    pub steps: Option<String>,
    /// Relative tolerances of adaptive steps, in the same way (powers of ten) [default: 1e-2..1e-6, if no steps are
    /// given]
    #[arg(long, value_name = "LIST", allow_hyphen_values = true, conflicts_with_all = ["shard", "merge"])]
    pub tolerances: Option<String>,
    /// Number of times each run is made; its cost is their median [default: 3]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1000), conflicts_with_all = ["shard", "merge"])]
    pub repeat: Option<u32>,
    /// Repeat the study with the stiffness of all springs times these factors: 1,10,100 or 1..1e4
    #[arg(long, value_name = "LIST", allow_hyphen_values = true, conflicts_with_all = ["shard", "merge"])]
    pub stiffness_sweep: Option<String>,
    /// Models of the cloth to compare, separated by commas; errors are distances from the solution with membranes, so
    /// that they hold what the net costs in accuracy
    #[arg(long, value_name = "LIST", value_delimiter = ',', conflicts_with_all = ["shard", "merge"])]
    pub models: Option<Vec<ClothModel>>,
}

impl StudyOptions {
    /// Flags win over the case's section.
    ///
    /// # Errors
    /// A list that cannot be read, or a number out of range.
    pub fn of(typed: &TypedOptions, section: Option<&Study>) -> Result<Self, StudyError> {
        let section = section.cloned().unwrap_or_default();
        let fraction = |x: f64| (x > 0.0 && x < 1.0).then_some(()).ok_or("above 0 and below 1");
        let positive = |x: f64| (x > 0.0 && x.is_finite()).then_some(()).ok_or("above 0");
        let list = |flag: &str, typed: &Option<String>, of: fn(f64, f64) -> Vec<f64>, allowed: &dyn Fn(f64) -> _| {
            typed.as_deref().map(|text| numbers(flag, text, of, allowed)).transpose()
        };
        let methods = typed.methods.as_deref().map(methods).transpose()?;
        let mut models = typed.models.clone().or(section.models).unwrap_or_default();
        models.sort_unstable();
        models.dedup();
        let stiffness_sweep =
            list("--stiffness-sweep", &typed.stiffness_sweep, decades, &positive)?.unwrap_or_default();
        if !models.is_empty() && !stiffness_sweep.is_empty() {
            let why = "models are compared at one stiffness: give --stiffness-sweep or models, not both";
            return Err(StudyError::Usage(why.to_owned()));
        }
        let quantities = read_names(&section.quantities.unwrap_or_default());
        let quantities = quantities.map_err(|why| StudyError::Usage(why.to_string()))?;
        Ok(StudyOptions {
            quantities: quantities.into_iter().map(|name| name.text).collect(),
            methods: methods.or(section.methods),
            steps: list("--steps", &typed.steps, series, &positive)?.or(section.steps),
            tolerances: list("--tolerances", &typed.tolerances, decades, &fraction)?.or(section.tolerances),
            repeat: typed.repeat.or(section.repeat).unwrap_or(REPEAT),
            stiffness_sweep,
            models,
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

/// The methods of a list, each once, with parameters in range.
fn methods(text: &str) -> Result<Vec<Method>, StudyError> {
    let mut once: Vec<Method> = Vec::new();
    for method in method_list(text).map_err(|why| StudyError::Usage(format!("--methods: {why}")))? {
        choice(&method)?;
        if !once.contains(&method) {
            once.push(method);
        }
    }
    Ok(once)
}

/// Names and JSON objects, separated by commas; or a JSON list.
///
/// # Errors
/// The entry that is neither.
pub fn method_list(text: &str) -> Result<Vec<Method>, String> {
    let inner = text.trim();
    let mut rest = inner.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')).unwrap_or(inner).trim_start();
    let mut found = Vec::new();
    loop {
        let wrong = |why: &str| {
            format!(
                "\"{rest}\" is no method ({why}): expected a name, or JSON such as {{\"hht\": {{\"alpha\": -0.2}}}}"
            )
        };
        let after = if rest.starts_with(['{', '"']) {
            let mut methods = serde_json::Deserializer::from_str(rest).into_iter::<Method>();
            let method = methods.next().ok_or_else(|| wrong("no method"))?;
            found.push(method.map_err(|why| wrong(&why.to_string()))?);
            rest.get(methods.byte_offset()..).unwrap_or_default()
        } else {
            let (name, after) = rest.split_at(rest.find(',').unwrap_or(rest.len()));
            let name = name.trim_end().to_owned();
            if name.is_empty() {
                return Err(wrong("a name is missing"));
            }
            found.push(Method { name, parameters: BTreeMap::new() });
            after
        };
        match after.trim_start().split_at_checked(1) {
            Some((",", next)) => rest = next.trim_start(),
            None => return Ok(found),
            Some(_) => return Err(wrong("a comma is missing")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_as_typed() {
        let typed = TypedOptions {
            methods: Some(r#"newmark, {"hht": {"alpha": -0.2}},rk4"#.to_owned()),
            steps: Some("1e-3..1e-2".to_owned()),
            tolerances: Some("1e-2..1e-4,3e-5".to_owned()),
            ..TypedOptions::default()
        };
        let options = StudyOptions::of(&typed, None).expect("good");
        let names: Vec<String> = options.methods.expect("given").iter().map(super::super::row::label).collect();
        assert_eq!(names, ["newmark", "hht(alpha=-0.2)", "rk4"]);
        assert_eq!(options.steps, Some(vec![1e-2, 5e-3, 2e-3, 1e-3]));
        assert_eq!(options.tolerances, Some(vec![1e-2, 1e-3, 1e-4, 3e-5]));
        assert_eq!((options.repeat, options.stiffness_sweep), (3, vec![]));
        assert_eq!(method_list(r#"["rk4", {"newmark": {"beta": 0.3, "gamma": 0.6}}]"#).map(|list| list.len()), Ok(2));
        assert!(["rk4,,hht", "{rk4", "", "{\"hht\": {}} rk4"].into_iter().all(|text| method_list(text).is_err()));
        assert!(numbers("--steps", "3e-3..4e-3", series, &|_| Ok(())).is_err(), "no round number lies there");
    }

    #[test]
    fn flags_win_over_the_case_and_none_means_none() {
        let section =
            Study { steps: Some(vec![0.1]), tolerances: Some(vec![0.1]), repeat: Some(7), ..Study::default() };
        let typed = TypedOptions { steps: Some("none".to_owned()), ..TypedOptions::default() };
        let options = StudyOptions::of(&typed, Some(&section)).expect("good");
        assert_eq!((options.steps, options.tolerances, options.repeat), (Some(vec![]), Some(vec![0.1]), 7));
    }
}
