//! The text of a forecast: costs of force passes and tangents, runs of all methods, and what is recommended.

use serde::Serialize;

use super::Forecast;
use crate::case::spec::Problem;
use crate::integrate::registry::Family;
use crate::study::StudyError;
use crate::study::template::render;

/// What the template shows.
#[derive(Serialize)]
struct Text<'a> {
    forecast: &'a Forecast,
    /// method of the case
    own: &'a str,
    /// whether that one needs a tangent
    implicit: bool,
    /// [s] end of the case
    end: f64,
}

/// The forecast as text.
///
/// # Errors
/// What the template engine refuses.
pub fn describe(problem: &Problem, forecast: &Forecast) -> Result<String, StudyError> {
    let info = problem.method.info;
    let implicit = info.family == Family::Implicit;
    let text = Text { forecast, own: info.name, implicit, end: problem.time.end };
    render("check.txt", include_str!("../../../assets/report/check.txt"), &text)
}
