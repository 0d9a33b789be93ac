//! `tradeoff.html`: one page that needs nothing beside it. Its words and its layout are those of the template.

use minijinja::{Environment, UndefinedBehavior, Value};
use serde::Serialize;

use super::figure::Figure;
use super::{Machine, Rerun};
use crate::format_number::figures;
use crate::study::error::StudyError;
use crate::study::plan::{PROGRAM, Plan};
use crate::study::recommendations::{Recommendations, unfinished};
use crate::study::row::{Pace, Row};
use crate::study::runner::Study;

/// The page's template. Its name ends in html: everything put into it is escaped.
const TEMPLATE: (&str, &str) = ("tradeoff.html", include_str!("../../../assets/report/tradeoff.html"));

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
    render(&page).map_err(|e| StudyError::Page(format!("{e:#}")))
}

fn render(page: &Page<'_>) -> Result<String, minijinja::Error> {
    let mut templates = Environment::new();
    templates.set_undefined_behavior(UndefinedBehavior::Strict);
    templates.add_filter("figures", figures);
    templates.add_filter("short", short);
    templates.add_filter("json", |value: Value| serde_json::to_string(&value).unwrap_or_default());
    templates.add_filter("scientific", |value: f64| format!("{value:e}"));
    templates.add_filter("sentence", sentence);
    templates.add_template(TEMPLATE.0, TEMPLATE.1)?;
    templates.get_template(TEMPLATE.0)?.render(page)
}

/// All runs: variant by variant, method by method, fixed steps before adaptive ones, the largest first.
fn sorted(rows: &[Row]) -> Vec<&Row> {
    let key = |row: &Row| {
        let method = rows.iter().position(|other| other.job.method == row.job.method);
        let (adaptive, size) = match row.job.pace {
            Pace::Step(h) => (false, h),
            Pace::Tolerance(tolerance) => (true, tolerance),
        };
        ((row.job.variant, method, adaptive), size)
    };
    let mut sorted: Vec<_> = rows.iter().map(|row| (key(row), row)).collect();
    sorted.sort_by(|((a, larger), _), ((b, smaller), _)| a.cmp(b).then_with(|| smaller.total_cmp(larger)));
    sorted.into_iter().map(|(_, row)| row).collect()
}

/// A number of so many digits, with a power of ten below a hundredth, where tables read better so; nothing for none.
fn short(value: Option<f64>, digits: usize) -> String {
    match value.filter(|v| v.is_finite()) {
        None => String::new(),
        Some(v) if v != 0.0 && v.abs() < 1e-2 => {
            let rounded: f64 = format!("{v:.*e}", digits.saturating_sub(1)).parse().unwrap_or(v);
            format!("{rounded:e}")
        }
        Some(v) => figures(v, digits),
    }
}

/// With a capital letter and a full stop.
fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first: String = letters.next().map(|c| c.to_uppercase().collect()).unwrap_or_default();
    let stop = if text.is_empty() || text.ends_with(['.', '!', '?']) { "" } else { "." };
    format!("{first}{}{stop}", letters.as_str())
}
