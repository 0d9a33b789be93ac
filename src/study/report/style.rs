//! How a method looks in all figures of a study.
//!
//! The shape of its marks shows its family: discs and triangles for explicit methods, stars for those without a
//! matrix, squares and diamonds for implicit ones. Fixed steps are full lines with filled marks, adaptive steps dashed
//! lines with open ones.

use crate::case::schema::Method;
use crate::integrate::registry::{Family, methods};
use crate::models::Model;
use crate::plot::chart::{Line, Marker, Stroke};
use crate::row::{Row, RowStatus, StepSetting, labelled};
use crate::runner::Study;

/// Number of colours that methods and curves take, each its own as long as they suffice: those of the palette without
/// black, which is left for what is no method.
const COLORS: usize = 15;
/// Black.
pub(crate) const BLACK: usize = 6;
/// Methods of a family that have the same shape of marks.
const SHAPE: usize = 6;
/// The turn whose shapes are left for the cheaper one of two models.
const OF_CHEAPER: usize = 5;

/// The colour of a curve by its number.
pub(crate) fn curve_color(number: usize) -> usize {
    let color = number % COLORS;
    if color < BLACK { color } else { color + 1 }
}

/// The number in the palette of a method's colour, which is the same in all charts of all pages.
///
/// ```
/// use canopy_fem_study::report::method_color;
/// assert_ne!(method_color("newmark"), method_color("energy-momentum"));
/// ```
pub fn method_color(name: &str) -> usize {
    methods().iter().find(|method| method.name == name).map_or(BLACK, |method| curve_color(method.color))
}

/// Colours of the methods of a study. One whose colour is taken, such as a second HHT with other parameters, has the
/// first free one.
pub(crate) fn method_colors<'m>(names: impl Iterator<Item = &'m str> + Clone) -> Vec<usize> {
    let own: Vec<usize> = names.map(method_color).collect();
    let mut taken: Vec<usize> = Vec::with_capacity(own.len());
    for color in &own {
        let free = || (0..COLORS).map(curve_color).find(|free| !own.contains(free) && !taken.contains(free));
        let color = if taken.contains(color) { free().unwrap_or(*color) } else { *color };
        taken.push(color);
    }
    taken
}
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
        let first = styles.len();
        for row in study.rows.iter().filter(|row| row.family == family) {
            if !styles.iter().any(|style| style.is_of(row)) {
                let others = styles.iter().skip(first).filter(|style| !is_cheaper(style.model)).count();
                let turn = if is_cheaper(row.job.model) { OF_CHEAPER } else { others / SHAPE };
                let method = row.job.method.clone();
                let model = row.job.model;
                styles.push(Style { method, model, family, color: 0, markers: markers(family, turn) });
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

/// A family takes another shape after every six methods.
fn markers(family: Family, turn: usize) -> [Marker; 2] {
    let explicit = [
        [Marker::Dot, Marker::Ring],
        [Marker::Triangle, Marker::OpenTriangle],
        [Marker::TriangleDown, Marker::OpenTriangleDown],
    ];
    let implicit = [[Marker::Square, Marker::OpenSquare], [Marker::Diamond, Marker::OpenDiamond]];
    let shapes: &[[Marker; 2]] = match family {
        Family::Explicit => &explicit,
        Family::MatrixFree => &[[Marker::Star, Marker::OpenStar]],
        Family::Implicit => &implicit,
    };
    shapes.get(turn % shapes.len().max(1)).copied().unwrap_or_default()
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Families have their own marks, so a colour and a mark belong to one method.
    #[test]
    fn methods_of_a_family_have_different_colours() {
        for (i, method) in methods().iter().enumerate() {
            assert!(method.color < COLORS, "{}", method.name);
            let alike = methods()[..i].iter().find(|m| (m.family, m.color) == (method.family, method.color));
            assert!(alike.is_none(), "{} looks like {}", method.name, alike.map_or("", |m| m.name));
        }
    }
}
