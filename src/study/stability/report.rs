//! The study as text: a table to read, a csv file to compute with.

use super::{KnownBy, Row, Stability, Status};
use crate::figures::figures;
use crate::output::names::csv_field;
use std::fmt::Write;

/// `stability.csv`: a row a method, seconds; empty: without limit, `nan`: not known.
pub fn csv(rows: &[Row]) -> String {
    let mut text = String::from("method,predicted,measured\n");
    for row in rows {
        let predicted = match (row.prediction.step, row.prediction.known_by) {
            (Some(step), _) => figures(step, 6),
            (None, KnownBy::Unlimited) if row.status != Status::Refused => String::new(),
            (None, _) => "nan".to_owned(),
        };
        let measured = match (row.measured, row.status) {
            (Some(step), _) => figures(step, 6),
            (None, Status::Measured) => String::new(),
            (None, _) => "nan".to_owned(),
        };
        let _ = writeln!(text, "{},{predicted},{measured}", csv_field(&row.method));
    }
    text
}

/// The table for standard output, and a sentence for every method whose limits differ.
pub fn table(study: &Stability) -> String {
    let longest = study.methods.iter().map(|row| row.method.len()).max().unwrap_or(0).max(6);
    let mut text = format!("{}: largest stable steps, {} unknowns\n", study.name, study.unknowns);
    let _ = writeln!(
        text,
        "  {:<longest$}  predicted [s]  known by   measured [s]: holds, fails  measured/predicted  runs",
        "method"
    );
    for row in &study.methods {
        let predicted = row.prediction.step.map_or_else(|| "-".to_owned(), |step| figures(step, 4));
        let ratio = row.ratio.map_or_else(|| "-".to_owned(), |ratio| figures(ratio, 3));
        let _ = writeln!(
            text,
            "  {:<longest$}  {predicted:<13}  {:<9}  {:<26}  {ratio:<18}  {}",
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
    for (row, why) in study.methods.iter().filter_map(|row| Some((row, row.why.as_ref()?))) {
        let _ = writeln!(text, "{}: {why}", row.method);
    }
    text
}

fn measured(row: &Row) -> String {
    match (row.status, row.measured, row.unstable, row.tried_up_to) {
        (Status::Refused, ..) => "refused".to_owned(),
        (Status::OutOfBudget, ..) => "left out: budget".to_owned(),
        (Status::Interrupted, ..) => "left out: interrupted".to_owned(),
        (Status::Measured, Some(measured), Some(unstable), _) if measured > 0.0 => {
            format!("{}, {}", figures(measured, 4), figures(unstable, 4))
        }
        (Status::Measured, Some(_), Some(unstable), _) => format!("none, {}", figures(unstable, 4)),
        (Status::Measured, _, _, Some(longest)) => format!("no limit up to {}", figures(longest, 4)),
        (Status::Measured, ..) => "-".to_owned(),
    }
}
