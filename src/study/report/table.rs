//! The table of all runs, cell by cell, as the page shows it.

use serde::Serialize;

use super::csv;
use crate::format_number::figures;
use crate::integrate::registry::Family;
use crate::study::error::StudyError;
use crate::study::row::{Pace, Row, RowStatus};
use crate::study::runner::Study;

/// A table of the page.
#[derive(Serialize)]
pub(super) struct Table {
    pub head: Vec<Head>,
    pub rows: Vec<Line>,
}

/// A column's name, and what it means.
#[derive(Serialize)]
pub(super) struct Head {
    pub name: &'static str,
    pub title: &'static str,
}

/// A row.
#[derive(Serialize)]
pub(super) struct Line {
    /// `front`, `failed` or nothing
    pub class: &'static str,
    pub cells: Vec<Cell>,
}

/// A cell: what is read, and what it is sorted by.
#[derive(Default, Serialize)]
pub(super) struct Cell {
    pub text: String,
    /// a number for numbers, else nothing
    pub sort: Option<f64>,
}

const COLUMNS: [(&str, &str); 18] = [
    ("method", "as --methods takes it"),
    (
        "family",
        "explicit: forces only; matrix-free: forces and the spring graph; implicit: tangents and a factorisation",
    ),
    ("step [s]", "fixed step"),
    ("tolerance", "relative tolerance of adaptive steps"),
    ("status", "how the run ended"),
    ("front", "on the Pareto front: no other run is both cheaper and more accurate"),
    ("error", "root mean square distance to the reference over that of its motion"),
    ("largest error", "largest distance to the reference over the largest motion"),
    ("energy error", "largest numerical energy over the largest energy exchanged"),
    ("CPU [s]", "processor time, median of the repeats"),
    ("spread [s]", "processor time of the cheapest and the dearest repeat"),
    ("steps", "accepted steps"),
    ("rejected", "attempts of adaptive steps that were dropped"),
    ("forces", "force evaluations"),
    ("tangents", "tangent assemblies"),
    ("factorisations", "factorisations of the matrix"),
    ("solves", "linear solves"),
    ("Newton", "Newton iterations"),
];

/// All runs: variant by variant, method by method, the largest step first.
///
/// # Errors
/// A method that cannot be written.
pub(super) fn runs(study: &Study) -> Result<Table, StudyError> {
    let sweep = study.plan.variants.len() > 1;
    let noted = study.rows.iter().any(|row| !row.measured.note.is_empty());
    let mut head: Vec<Head> = Vec::new();
    if sweep {
        head.push(Head { name: "stiffness", title: "factor on the stiffness of all springs" });
    }
    head.extend(COLUMNS.map(|(name, title)| Head { name, title }));
    if noted {
        head.push(Head { name: "note", title: "why, and what to do" });
    }
    let mut sorted: Vec<(Place, &Row)> = study.rows.iter().map(|row| (Place::of(study, row), row)).collect();
    sorted.sort_by(|(a, _), (b, _)| a.group.cmp(&b.group).then_with(|| b.pace.total_cmp(&a.pace)));
    let rows = sorted.into_iter().map(|(_, row)| {
        let mut cells = Vec::new();
        if sweep {
            cells.push(number(study.plan.variant_of(&row.job).map(|v| v.stiffness_factor), 4));
        }
        cells.extend(self::cells(row)?);
        if noted {
            cells.push(text(&row.measured.note));
        }
        let class = match (row.pareto, row.measured.status) {
            (true, _) => "front",
            (false, RowStatus::Completed) => "",
            (false, _) => "failed",
        };
        Ok::<Line, StudyError>(Line { class, cells })
    });
    let rows = rows.collect::<Result<Vec<_>, _>>()?;
    Ok(Table { head, rows })
}

/// Where a run stands in the table.
struct Place {
    /// variant, method, and whether steps are adaptive
    group: (usize, usize, bool),
    /// step or tolerance
    pace: f64,
}

impl Place {
    fn of(study: &Study, row: &Row) -> Self {
        let method = study.rows.iter().position(|other| other.job.method == row.job.method).unwrap_or(0);
        let (adaptive, pace) = match row.job.pace {
            Pace::Step(h) => (false, h),
            Pace::Tolerance(t) => (true, t),
        };
        Place { group: (row.job.variant, method, adaptive), pace }
    }
}

fn cells(row: &Row) -> Result<[Cell; COLUMNS.len()], StudyError> {
    let (step, tolerance) = match row.job.pace {
        Pace::Step(h) => (Some(h), None),
        Pace::Tolerance(t) => (None, Some(t)),
    };
    let m = &row.measured;
    let c = &m.counters;
    Ok([
        text(&csv::method(row)?),
        text(family(row.family)),
        number(step, 5),
        number(tolerance, 5),
        text(&m.status.word().replace('-', " ")),
        text(if row.pareto { "●" } else { "" }),
        number(m.error, 3),
        number(m.error_max, 3),
        number(m.energy_error, 3),
        number(row.cpu_seconds, 3),
        spread(&m.repeats),
        count(m.steps),
        count(m.rejected_steps),
        count(c.force_evaluations),
        count(c.tangent_assemblies),
        count(c.factorizations),
        count(c.linear_solves),
        count(c.newton_iterations),
    ])
}

pub(super) fn family(family: Family) -> &'static str {
    match family {
        Family::Explicit => "explicit",
        Family::MatrixFree => "matrix-free",
        Family::Implicit => "implicit",
    }
}

pub(super) fn text(text: &str) -> Cell {
    Cell { text: text.to_owned(), sort: None }
}

/// Nothing, or a number with so many digits.
pub(super) fn number(value: Option<f64>, digits: usize) -> Cell {
    match value.filter(|v| v.is_finite()) {
        Some(v) => Cell { text: short(v, digits), sort: Some(v) },
        None => Cell::default(),
    }
}

/// Tables read better with a power of ten from a thousandth down.
pub(super) fn short(value: f64, digits: usize) -> String {
    if value != 0.0 && value.abs() < 1e-2 {
        let rounded: f64 = format!("{value:.*e}", digits.saturating_sub(1)).parse().unwrap_or(value);
        return format!("{rounded:e}");
    }
    figures(value, digits)
}

/// Counters are shown to the digit: they repeat exactly.
fn count(value: u64) -> Cell {
    Cell { text: value.to_string(), sort: Some(value as f64) }
}

fn spread(repeats: &[f64]) -> Cell {
    let ends = repeats
        .iter()
        .fold(None, |ends: Option<(f64, f64)>, &s| Some(ends.map_or((s, s), |(low, high)| (low.min(s), high.max(s)))));
    match ends.filter(|_| repeats.len() > 1) {
        Some((low, high)) => Cell { text: format!("{} – {}", short(low, 3), short(high, 3)), sort: Some(high - low) },
        None => Cell::default(),
    }
}
