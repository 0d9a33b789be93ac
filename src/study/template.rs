//! Text from the templates in `src/study/templates`: pages, tables and reports are laid out there, and only numbers are
//! made here.

use minijinja::{Environment, UndefinedBehavior, Value};
use serde::Serialize;

use super::error::StudyError;
use super::row::RowStatus;
use crate::format_number::figures;
use crate::output::sanitize::csv_field;
use crate::plot::PlotError;
use crate::plot::chart::{Chart, Size};
use crate::plot::layout::svg_page;

/// Pages may extend `page.html` and import from `parts.html`, texts from `parts.txt`.
const SHARED: [(&str, &str); 3] = [
    ("page.html", include_str!("templates/page.html")),
    ("parts.html", include_str!("templates/parts.html")),
    ("parts.txt", include_str!("templates/parts.txt")),
];
/// Digits of what a mark tells: a row of the csv file is found by them.
const TOLD: usize = 6;

/// A figure of a page, drawn for wide and for narrow screens.
#[derive(Clone, Debug, Default, Serialize)]
pub struct PageFigure {
    /// what it shows
    pub caption: String,
    /// the picture for wide screens
    pub wide: String,
    /// the picture for narrow ones
    pub narrow: String,
}

impl PageFigure {
    /// One chart in both sizes.
    ///
    /// # Errors
    /// The drawing library's.
    pub fn of(chart: &Chart, caption: impl Into<String>, [wide, narrow]: [Size; 2]) -> Result<Self, PlotError> {
        let drawn = |size: Size| svg_page(&[Chart { size, ..chart.clone() }], 1);
        Ok(PageFigure { caption: caption.into(), wide: drawn(wide)?, narrow: drawn(narrow)? })
    }
}

/// Runs that ended for the same reason, for the list of reasons of a page.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Reason<'r> {
    /// the reason
    note: &'r str,
    /// how the runs ended
    status: String,
    /// whether they have no result
    failed: bool,
    /// names of the runs
    of: Vec<String>,
}

/// All reasons of some runs, each given as name, status and note.
pub(super) fn reasons<'r>(runs: impl Iterator<Item = (String, RowStatus, &'r str)>) -> Vec<Reason<'r>> {
    let mut all: Vec<Reason<'r>> = Vec::new();
    for (name, status, note) in runs.filter(|(_, _, note)| !note.is_empty()) {
        match all.iter_mut().find(|reason| reason.note == note) {
            Some(known) => known.of.push(name),
            None => all.push(Reason {
                note,
                status: status.word().replace('-', " "),
                failed: status != RowStatus::Completed,
                of: vec![name],
            }),
        }
    }
    all.sort_by_key(|reason| !reason.failed);
    all
}

/// A number as marks of a page tell it; nothing for none.
pub(super) fn told(x: Option<f64>) -> String {
    x.map(|x| figures(x, TOLD)).unwrap_or_default()
}

/// A cell of a csv file as pages tell it: counts and words as they are.
fn told_cell(text: String) -> String {
    match text.parse() {
        Ok(x) if f64::is_finite(x) && text.parse::<i64>().is_err() => told(Some(x)),
        _ => text,
    }
}

/// Fills in a template, which may extend the frame of all pages: `page.html`. What is put into one
/// whose name ends in `.html` is escaped; lines of other ones that hold only a statement leave nothing behind.
///
/// # Errors
/// What the template engine refuses.
pub fn render(name: &str, template: &str, context: &impl Serialize) -> Result<String, StudyError> {
    let text = || {
        let mut templates = Environment::new();
        templates.set_undefined_behavior(UndefinedBehavior::Strict);
        let blocks = !name.ends_with(".html");
        templates.set_trim_blocks(blocks);
        templates.set_lstrip_blocks(blocks);
        templates.set_keep_trailing_newline(blocks);
        templates.add_global("page_style", Value::from_safe_string(include_str!("templates/page.css").to_owned()));
        templates.add_global("page_script", Value::from_safe_string(include_str!("templates/page.js").to_owned()));
        templates.add_filter("figures", figures);
        templates.add_filter("short", short);
        templates.add_filter("fixed", |value: f64, digits: usize| format!("{value:.digits$}"));
        templates.add_filter("scientific", |value: f64, digits: Option<usize>| match digits {
            Some(digits) => format!("{value:.digits$e}"),
            None => format!("{value:e}"),
        });
        templates.add_filter("plain", |value: f64| value.to_string());
        templates.add_filter("number", number);
        templates.add_filter("csv", |text: String| csv_field(&text));
        templates.add_filter("seconds", seconds);
        templates.add_filter("sentence", sentence);
        templates.add_filter("json", |value: Value| serde_json::to_string(&value).unwrap_or_default());
        // Within a script element no text may end it.
        templates.add_filter("embedded", |value: Value| {
            Value::from_safe_string(serde_json::to_string(&value).unwrap_or_default().replace('<', "\\u003c"))
        });
        templates.add_filter("told", told_cell);
        for (name, shared) in SHARED {
            templates.add_template(name, shared)?;
        }
        templates.add_filter("left", |text: String, width: usize| format!("{text:<width$}"));
        templates.add_filter("right", |text: String, width: usize| format!("{text:>width$}"));
        templates.template_from_named_str(name, template)?.render(context)
    };
    text().map_err(|error: minijinja::Error| StudyError::Page(format!("{error:#}")))
}

/// The shortest number that reads back as the same; nothing for none.
fn number(value: Option<f64>) -> String {
    value.filter(|v| v.is_finite()).map(|v| format!("{v:?}")).unwrap_or_default()
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

/// A time [s] in the unit that suits it.
pub(crate) fn seconds(t: f64) -> String {
    let units = [(3600.0, "h"), (1.0, "s"), (1e-3, "ms"), (1e-6, "us")];
    let (unit, name) = units.into_iter().find(|(unit, _)| t >= *unit).unwrap_or((1e-9, "ns"));
    format!("{} {name}", figures(t / unit, 3))
}

/// With a capital letter and a full stop.
fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first: String = letters.next().map(|c| c.to_uppercase().collect()).unwrap_or_default();
    let stop = if text.is_empty() || text.ends_with(['.', '!', '?']) { "" } else { "." };
    format!("{first}{}{stop}", letters.as_str())
}
