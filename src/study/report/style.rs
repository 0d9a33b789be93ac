//! How a method looks in all figures of a study.
//!
//! A method has its own colour and mark (`method_look`). Fixed steps are full lines with filled marks, adaptive
//! steps dashed lines with open ones.

use crate::case::schema::Method;
use crate::integrate::registry::Family;
use crate::method_look::{BLACK, method_colors, method_mark, outline, shapes};
use crate::models::Model;
use crate::plot::chart::{Line, Marker, Stroke};
use crate::row::{Row, RowStatus, StepSetting, labelled};
use crate::runner::Study;

/// The turn whose shapes are left for the cheaper one of two models.
const OF_CHEAPER: usize = 5;

/// All families, in the order of the legend.
const FAMILIES: [(Family, &str); 3] =
    [(Family::Explicit, "explicit"), (Family::MatrixFree, "matrix-free"), (Family::Implicit, "implicit")];

/// The look of a method.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Style {
    pub method: Method,
    pub model: Option<Model>,
    pub family: Family,
    /// number in the palette
    pub color: usize,
    /// marks of runs with fixed and with adaptive steps
    markers: [Marker; 2],
}

impl Style {
    pub(super) fn label(&self) -> String {
        labelled(&self.method, self.model)
    }

    /// Whether a run looks like this.
    pub(super) fn is_of(&self, row: &Row) -> bool {
        row.job.model == self.model && row.job.method == self.method
    }

    /// A line of it, without a name.
    pub(super) fn line(&self, setting: StepSetting, points: Vec<(f64, f64)>) -> Line {
        let (stroke, marker) = match setting {
            StepSetting::Step(_) => (Stroke::Normal, self.markers[0]),
            StepSetting::Tolerance(_) => (Stroke::Dashed, self.markers[1]),
        };
        Line { points, stroke, marker, color: Some(self.color), series: self.label(), ..Line::default() }
    }
}

/// One style a method, family by family, in the order of the plan. Where models are compared, a method has the same
/// colour in both, and marks of another shape with the cheaper one.
pub(super) fn styles(study: &Study) -> Vec<Style> {
    let mut styles: Vec<Style> = Vec::new();
    for (family, _) in FAMILIES {
        for row in study.rows.iter().filter(|row| row.family == family) {
            if !styles.iter().any(|style| style.is_of(row)) {
                let (method, model) = (row.job.method.clone(), row.job.model);
                // A row may be of a method that this program does not have.
                let own = match method_mark(&method.name) {
                    Marker::None => shapes(family, 0),
                    mark => [mark, outline(mark)],
                };
                let markers = if is_cheaper(model) { shapes(family, OF_CHEAPER) } else { own };
                styles.push(Style { method, model, family, color: 0, markers });
            }
        }
    }
    let mut methods: Vec<Method> = Vec::new();
    for style in &styles {
        if !methods.contains(&style.method) {
            methods.push(style.method.clone());
        }
    }
    let colors = method_colors(methods.iter().map(|method| method.name.as_str()));
    for style in &mut styles {
        let color = methods.iter().zip(&colors).find(|(method, _)| **method == style.method);
        style.color = color.map_or(BLACK, |(_, color)| *color);
    }
    styles
}

/// Whether a model is compared with a more accurate one.
fn is_cheaper(model: Option<Model>) -> bool {
    model.is_some_and(|model| model != model.reference())
}

/// The mark of a run without a result. `None` for one that has a result.
pub(crate) fn failure(status: RowStatus) -> Option<Marker> {
    match status {
        RowStatus::Completed => None,
        RowStatus::Diverged => Some(Marker::Cross),
        RowStatus::NotConverged => Some(Marker::Plus),
        RowStatus::Refused => Some(Marker::Tick),
        RowStatus::NotRun => Some(Marker::Bar),
    }
}

/// Entries of the legend: every method under its family, then what the marks mean. They hold no points.
pub(super) fn legend(study: &Study, styles: &[Style]) -> Vec<Line> {
    let mut lines = Vec::new();
    for (family, name) in FAMILIES {
        let members: Vec<&Style> = styles.iter().filter(|style| style.family == family).collect();
        if !members.is_empty() {
            lines.push(entry(name, Stroke::None, Marker::None));
        }
        for style in members {
            let runs = || study.rows.iter().filter(|row| style.is_of(row));
            let only_adaptive = runs().all(|row| matches!(row.job.setting, StepSetting::Tolerance(_)));
            let setting = if only_adaptive { StepSetting::Tolerance(0.0) } else { StepSetting::Step(0.0) };
            lines.push(Line { label: style.label(), ..style.line(setting, Vec::new()) });
        }
    }
    let has = |of: fn(&StepSetting) -> bool| study.rows.iter().any(|row| of(&row.job.setting));
    lines.push(entry("runs", Stroke::None, Marker::None));
    if has(|setting| matches!(setting, StepSetting::Step(_))) {
        lines.push(entry("fixed steps", Stroke::Normal, Marker::Dot));
    }
    if has(|setting| matches!(setting, StepSetting::Tolerance(_))) {
        lines.push(entry("adaptive steps", Stroke::Dashed, Marker::Ring));
    }
    for status in [RowStatus::Diverged, RowStatus::NotConverged, RowStatus::Refused, RowStatus::NotRun] {
        if study.rows.iter().any(|row| row.measured.status == status) {
            lines.push(entry(&status.word().replace('-', " "), Stroke::None, failure(status).unwrap_or_default()));
        }
    }
    lines
}

/// A black entry without points.
pub(super) fn entry(label: &str, stroke: Stroke, marker: Marker) -> Line {
    Line { label: label.to_owned(), stroke, marker, color: Some(BLACK), ..Line::default() }
}
