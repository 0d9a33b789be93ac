//! `tradeoff.csv` and `stiffness.csv`.

use std::fmt::Write;

use crate::output::sanitize::csv_field;
use crate::study::error::StudyError;
use crate::study::recommendations::{Pick, Recommendations, StiffnessPoint};
use crate::study::row::{Pace, Row};
use crate::study::runner::Study;

/// Columns of `tradeoff.csv`; other programs rely on them.
const HEADER: &str = "method,step,tolerance,status,error,error_max,energy_error,cpu_seconds,force_evaluations,tangent_assemblies,factorizations,linear_solves,pareto";
/// Columns of `stiffness.csv`.
const STIFFNESS: &str = "stiffness_factor,wanted,explicit,explicit_cpu_seconds,implicit,implicit_cpu_seconds";

/// One row a run, in the plan's order; the factor on the stiffness goes before it where there are several.
///
/// # Errors
/// A method that cannot be written as JSON, which those of a plan can.
pub(super) fn tradeoff(study: &Study) -> Result<String, StudyError> {
    let sweep = study.plan.variants.len() > 1;
    let mut text = format!("{}{HEADER}\n", if sweep { "stiffness_factor," } else { "" });
    for row in &study.rows {
        if sweep {
            let factor = study.plan.variant_of(&row.job).map(|v| v.stiffness_factor);
            text.push_str(&number(factor));
            text.push(',');
        }
        text.push_str(&line(row)?);
        text.push('\n');
    }
    Ok(text)
}

fn line(row: &Row) -> Result<String, StudyError> {
    let (step, tolerance) = match row.job.pace {
        Pace::Step(h) => (Some(h), None),
        Pace::Tolerance(t) => (None, Some(t)),
    };
    let m = &row.measured;
    let c = &m.counters;
    Ok([
        csv_field(&method(row)?),
        number(step),
        number(tolerance),
        m.status.word().to_owned(),
        number(m.error),
        number(m.error_max),
        number(m.energy_error),
        number(row.cpu_seconds),
        c.force_evaluations.to_string(),
        c.tangent_assemblies.to_string(),
        c.factorizations.to_string(),
        c.linear_solves.to_string(),
        row.pareto.to_string(),
    ]
    .join(","))
}

/// A method as `--method` takes it: its name, or a JSON object where parameters were given.
pub(super) fn method(row: &Row) -> Result<String, StudyError> {
    let method = &row.job.method;
    if method.parameters.is_empty() {
        return Ok(method.name.clone());
    }
    serde_json::to_string(method).map_err(|e| StudyError::Page(format!("{}: {e}", method.name)))
}

/// The shortest number that reads back as the same; nothing for none.
fn number(value: Option<f64>) -> String {
    value.filter(|v| v.is_finite()).map(|v| format!("{v:?}")).unwrap_or_default()
}

/// One row an accuracy and factor.
pub(super) fn stiffness(answers: &Recommendations) -> String {
    let mut text = format!("{STIFFNESS}\n");
    for StiffnessPoint { stiffness_factor, wanted, explicit, implicit } in &answers.stiffness {
        let pick = |pick: &Option<Pick>| match pick {
            Some(pick) => format!("{},{}", csv_field(&used(pick)), number(Some(pick.cpu_seconds))),
            None => ",".to_owned(),
        };
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{stiffness_factor:?},{wanted:?},{},{}", pick(explicit), pick(implicit));
    }
    text
}

/// A run in a word: its method and its steps.
pub(super) fn used(pick: &Pick) -> String {
    pick.pace.of(&pick.method)
}
