//! The study as text: a table to read, a csv file to compute with.

use super::row::AGREES;
use super::{AsGiven, KnownBy, Row, Stability, Status};
use crate::format_number::figures;
use crate::output::sanitize::csv_field;
use std::fmt::Write;

/// `stability.csv`: a row a method. `predicted` and `measured` are seconds; empty: unlimited; `nan`: there is no
/// number. Two words say what each cell is worth: `prediction` is `certified`, `estimate`, `unlimited`, `unknown` or
/// `refused`, `measurement` is `limit`, `none-holds`, `no-limit-found`, `not-settled`, `refused`, `out-of-budget` or
/// `interrupted`.
pub fn csv(rows: &[Row]) -> String {
    let mut text = String::from("method,predicted,measured,prediction,measurement\n");
    for row in rows {
        let (prediction, measurement) = (prediction_word(row), measurement_word(row));
        let cell = |step: Option<f64>, unlimited: bool| match step {
            Some(step) => figures(step, 6),
            None if unlimited => String::new(),
            None => "nan".to_owned(),
        };
        let predicted = cell(row.prediction.step, prediction == "unlimited");
        let measured = cell(row.measured, measurement == "no-limit-found");
        let _ = writeln!(text, "{},{predicted},{measured},{prediction},{measurement}", csv_field(&row.method));
    }
    text
}

fn prediction_word(row: &Row) -> &'static str {
    match (row.status, row.prediction.known_by) {
        (Status::Refused, _) => "refused",
        (_, KnownBy::Certified) => "certified",
        (_, KnownBy::Estimate) => "estimate",
        (_, KnownBy::Unlimited) => "unlimited",
        (_, KnownBy::Unknown) => "unknown",
    }
}

fn measurement_word(row: &Row) -> &'static str {
    match (row.status, row.measured) {
        (Status::Refused, _) => "refused",
        (Status::NotSettled, _) => "not-settled",
        (Status::OutOfBudget, _) => "out-of-budget",
        (Status::Interrupted, _) => "interrupted",
        (Status::Measured, Some(step)) if step > 0.0 => "limit",
        (Status::Measured, Some(_)) => "none-holds",
        (Status::Measured, None) => "no-limit-found",
    }
}

/// The table for standard output, and a sentence for every method whose limits differ.
pub fn table(study: &Stability) -> String {
    let longest = study.methods.iter().map(|row| row.method.len()).max().unwrap_or(0).max(6);
    let mut text = format!("{}: largest stable steps, {} unknowns\n", study.name, study.unknowns);
    let heading = "measured [s]: holds, fails";
    let widest = study.methods.iter().map(|row| measured(row).len()).max().unwrap_or(0).max(heading.len());
    let _ = writeln!(
        text,
        "  {:<longest$}  predicted [s]  known by   {heading:<widest$}  measured/predicted  runs",
        "method"
    );
    for row in &study.methods {
        let predicted = row.prediction.step.map_or_else(|| "-".to_owned(), |step| figures(step, 4));
        let ratio = row.ratio.map_or_else(|| "-".to_owned(), |ratio| figures(ratio, 3));
        let _ = writeln!(
            text,
            "  {:<longest$}  {predicted:<13}  {:<9}  {:<widest$}  {ratio:<18}  {}",
            row.method,
            if row.status == Status::Refused { "-" } else { row.prediction.known_by.word() },
            measured(row),
            row.runs.len()
        );
    }
    let differing = study.methods.iter().filter_map(|row| Some((row, row.explanation.as_ref()?)));
    for (row, why) in differing {
        let _ = writeln!(text, "{}: {why}", row.method);
    }
    for (row, given) in study.methods.iter().filter_map(|row| Some((row, row.as_given?))) {
        let _ = writeln!(text, "{}: {}", row.method, as_given(row, given));
    }
    for (row, why) in study.methods.iter().filter_map(|row| Some((row, row.why.as_ref()?))) {
        let _ = writeln!(text, "{}: {why}", row.method);
    }
    text
}

/// Why small motion was measured.
fn as_given(row: &Row, AsGiven { measured, unstable, settled }: AsGiven) -> String {
    let found = match (measured, unstable) {
        _ if !settled => between([measured, unstable])
            .map_or_else(|| "nothing is settled".to_owned(), |steps| format!("the limit is not settled: {steps}")),
        (Some(held), Some(fails)) if held > 0.0 => {
            format!("runs hold up to {} s and fail at {} s", figures(held, 4), figures(fails, 4))
        }
        (_, Some(fails)) => format!("no run holds, down from {} s", figures(fails, 4)),
        (_, None) => "no run fails".to_owned(),
    };
    let held = row.measured.or(row.tried_up_to).or(row.at_least).unwrap_or(0.0);
    let why = match unstable {
        Some(fails) if fails < (1.0 - AGREES) * held => {
            ", where steps reach beyond the range in which its forces are linear"
        }
        _ => "",
    };
    format!(
        "measured from small motion about the equilibrium, because the scene's own motion is linear; from its own start {found}{why}"
    )
}

fn measured(row: &Row) -> String {
    match (row.status, row.measured, row.unstable, row.tried_up_to) {
        (Status::Refused, ..) => "refused".to_owned(),
        (Status::NotSettled, ..) => {
            known(row).map_or_else(|| "not settled".to_owned(), |steps| format!("not settled: {steps}"))
        }
        (Status::OutOfBudget, ..) => unfinished(row, "budget"),
        (Status::Interrupted, ..) => unfinished(row, "interrupted"),
        (Status::Measured, Some(measured), Some(unstable), _) if measured > 0.0 => {
            format!("{}, {}", figures(measured, 4), figures(unstable, 4))
        }
        (Status::Measured, Some(_), Some(unstable), _) => format!("none, {}", figures(unstable, 4)),
        (Status::Measured, _, _, Some(longest)) => format!("no limit up to {}", figures(longest, 4)),
        (Status::Measured, ..) => "-".to_owned(),
    }
}

/// A measurement that ended before its time.
fn unfinished(row: &Row, why: &str) -> String {
    known(row).map_or_else(|| format!("left out: {why}"), |steps| format!("not settled ({why}): {steps}"))
}

/// What runs know of a limit that is not settled.
fn known(row: &Row) -> Option<String> {
    between([row.at_least, row.at_most])
}

fn between([least, most]: [Option<f64>; 2]) -> Option<String> {
    let least = least.map(|h| format!("at least {}", figures(h, 4)));
    let most = most.map(|h| format!("at most {}", figures(h, 4)));
    let both: Vec<String> = least.into_iter().chain(most).collect();
    (!both.is_empty()).then(|| both.join(", "))
}
