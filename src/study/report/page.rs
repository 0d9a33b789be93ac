//! `tradeoff.html`: one page that needs nothing beside it. Its words and its layout are those of the template.

use serde::Serialize;

use super::figure::Figure;
use super::{Machine, Rerun};
use crate::study::error::StudyError;
use crate::study::plan::{PROGRAM, Plan};
use crate::study::recommendations::{Recommendations, unfinished};
use crate::study::row::{Row, StepSetting};
use crate::study::runner::Study;
use crate::study::template::render;

/// All that the template shows.
#[derive(Serialize)]
struct Page<'a> {
    version: &'a str,
    command: &'a str,
    machine: &'a Machine,
    plan: &'a Plan,
    case_json: String,
    /// runs without a result, counted
    failures: String,
    /// whether any run has a note
    noted: bool,
    rows: Vec<&'a Row>,
    answers: &'a Recommendations,
    figures: &'a [Figure],
}

/// The page.
///
/// # Errors
/// What the template engine refuses.
pub(super) fn html(
    study: &Study,
    answers: &Recommendations,
    how: &Rerun,
    figures: &[Figure],
) -> Result<String, StudyError> {
    let Study { plan, rows } = study;
    let page = Page {
        version: PROGRAM,
        command: &how.command,
        machine: &how.machine,
        plan,
        case_json: serde_json::to_string_pretty(&plan.case).map_err(|e| StudyError::Page(e.to_string()))?,
        failures: unfinished(rows),
        noted: rows.iter().any(|row| !row.measured.note.is_empty()),
        rows: sorted(rows),
        answers,
        figures,
    };
    render("tradeoff.html", include_str!("../../../assets/report/tradeoff.html"), &page)
}

/// All runs: variant by variant, method by method, fixed steps before adaptive ones, the largest first.
fn sorted(rows: &[Row]) -> Vec<&Row> {
    let key = |row: &Row| {
        let method = rows.iter().position(|other| other.job.method == row.job.method);
        let (adaptive, size) = match row.job.setting {
            StepSetting::Step(h) => (false, h),
            StepSetting::Tolerance(tolerance) => (true, tolerance),
        };
        ((row.job.variant, method, adaptive), size)
    };
    let mut sorted: Vec<_> = rows.iter().map(|row| (key(row), row)).collect();
    sorted.sort_by(|((a, larger), _), ((b, smaller), _)| a.cmp(b).then_with(|| smaller.total_cmp(larger)));
    sorted.into_iter().map(|(_, row)| row).collect()
}
