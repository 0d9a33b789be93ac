//! What the report's figures share: titles, ranges of axes, and runs that have no place in a chart.

use super::style::{Style, failure};
use crate::format_number::figures;
use crate::method_look::BLACK;
use crate::plan::Variant;
use crate::plot::chart::{MarginPanel, Marker, PanelMark, PanelSide};
use crate::row::Row;
use crate::runner::Study;

/// What a range of an axis leaves free at either end, in decades, at least.
const MARGIN: f64 = 0.15;
/// Longest title.
const LONGEST: usize = 60;

/// Rows of a variant.
pub(super) fn rows(study: &Study, variant: usize) -> impl Iterator<Item = &Row> {
    study.rows.iter().filter(move |row| row.job.variant == variant)
}

/// Name and error of every model whose solution differs from the reference.
pub(super) fn model_errors(variant: Option<&Variant>) -> impl Iterator<Item = (String, f64)> + '_ {
    let models = variant.into_iter().flat_map(|variant| &variant.models);
    models.filter_map(|report| Some((format!("error of the {}", report.model.words()), report.error.as_ref()?.error)))
}

/// All runs of a variant that have no place in its chart; `at` says so, and which place they have along the strip.
pub(super) fn margin_panel(
    study: &Study,
    styles: &[Style],
    number: usize,
    side: PanelSide,
    at: impl Fn(&Row) -> Option<Option<f64>>,
) -> Option<MarginPanel> {
    let mark = |row: &Row| {
        let color = styles.iter().find(|s| s.is_of(row)).map_or(BLACK, |s| s.color);
        let marker = failure(row.measured.status).unwrap_or(Marker::Cross);
        let (series, run) = (row.label(), row.job.id.clone());
        Some(PanelMark { at: at(row)?.filter(|at| *at > 0.0), marker, color, series, run })
    };
    let marks: Vec<PanelMark> = rows(study, number).filter_map(mark).collect();
    (!marks.is_empty()).then(|| MarginPanel { side, label: "no result".to_owned(), marks })
}

/// The case's name, the variant's factor, and what is shown.
pub(super) fn title(study: &Study, variant: Option<&Variant>, what: &str) -> String {
    // XML has no place for these.
    let plain = |c: char| if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') { ' ' } else { c };
    let mut name: String = study.plan.name.chars().map(plain).take(LONGEST).collect();
    if study.plan.name.chars().count() > LONGEST {
        name.push('…');
    }
    match variant.map(|v| v.stiffness_factor).filter(|_| study.plan.variants.len() > 1) {
        Some(factor) => format!("{name}, {} × the stiffness", figures(factor, 4)),
        None => format!("{name}: {what}"),
    }
}

/// What a chart without points says.
pub(super) fn nothing(study: &Study) -> String {
    if study.rows.is_empty() { "no runs".to_owned() } else { "no run reached its end".to_owned() }
}

/// A range of a logarithmic axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    /// logarithm of the lower end
    low: f64,
    /// logarithm of the upper end
    high: f64,
}

impl Span {
    /// For axes without a number.
    pub(super) const EMPTY: Span = Span { low: -6.0, high: 0.0 };

    /// Around numbers above 0; nothing for none.
    pub(super) fn of(values: impl Iterator<Item = f64>) -> Option<Self> {
        let logs = values.filter(|v| *v > 0.0 && v.is_finite()).map(f64::log10);
        logs.fold(None, |span, v| match span {
            None => Some(Span { low: v, high: v }),
            Some(Span { low, high }) => Some(Span { low: low.min(v), high: high.max(v) }),
        })
    }

    /// Wide enough for another number, unless that is more than `far` decades off.
    pub(super) fn reaching(self, value: f64, far: f64) -> Self {
        let v = value.log10();
        if !v.is_finite() || v < self.low - far || v > self.high + far {
            return self;
        }
        Span { low: self.low.min(v), high: self.high.max(v) }
    }

    pub(super) fn with_margin(self) -> Self {
        let margin = (0.04 * (self.high - self.low)).max(MARGIN);
        Span { low: self.low - margin, high: self.high + margin }
    }

    /// A number, or the nearest end for one that is off the axis.
    pub(super) fn held(self, value: f64) -> f64 {
        // A hair inside, where rounding does not lose it.
        let hair = 1e-9 * (self.high - self.low);
        10f64.powf(value.log10().max(self.low + hair).min(self.high - hair))
    }

    pub(super) fn has(self, value: f64) -> bool {
        (self.low..=self.high).contains(&value.log10())
    }

    pub(super) fn ends(self) -> (f64, f64) {
        (10f64.powf(self.low), 10f64.powf(self.high))
    }

    pub(super) fn middle(self) -> f64 {
        10f64.powf(f64::midpoint(self.low, self.high))
    }
}
