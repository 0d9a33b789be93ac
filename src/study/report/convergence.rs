//! Error against step: which order a method shows, and where it stops being stable.

use super::figure::MOTION;
use super::parts::{Span, margin_panel, model_errors, nothing, rows, title};
use super::style::{Style, entry};
use crate::format_number::figures;
use crate::method_look::BLACK;
use crate::plan::Variant;
use crate::plot::chart::{Align, Axis, Chart, Line, Marker, Note, PanelSide, Scale, Stroke};
use crate::ranking::Ranking;
use crate::row::{Row, StepSetting};
use crate::runner::Study;

/// Slopes drawn as a guide.
const SLOPES: [f64; 3] = [1.0, 2.0, 4.0];
/// A limit or a bound is part of the picture if it is at most so many decades off.
const FAR: f64 = 1.0;

/// Where a guide that leaves the picture below has its name, as a share of the height.
const NAMED: f64 = 0.06;

/// Whether any run took fixed steps.
pub(super) fn has_runs(study: &Study) -> bool {
    study.rows.iter().any(|row| step(row).is_some())
}

fn step(row: &Row) -> Option<f64> {
    match row.job.setting {
        StepSetting::Step(h) => Some(h),
        StepSetting::Tolerance(_) => None,
    }
}

/// One line a method, the limits of stability as ticks on the lower edge.
pub(super) fn chart(study: &Study, styles: &[Style], number: usize) -> Chart {
    let variant = study.plan.variants.get(number);
    let ranking = Ranking::motion(variant);
    let bound = ranking.bound();
    let place = |row: &Row| Some((step(row)?, ranking.error(row)?));
    let points: Vec<(f64, f64)> = rows(study, number).filter_map(place).collect();
    let steps = Span::of(rows(study, number).filter_map(step)).unwrap_or(Span::EMPTY);
    let limits = limits(variant, styles);
    let x = limits.iter().fold(steps, |span, (_, limit)| span.reaching(*limit, FAR)).with_margin();
    let y = Span::of(points.iter().map(|p| p.1)).unwrap_or(Span::EMPTY).reaching(bound, FAR).with_margin();
    let mut lines = Vec::new();
    let mut notes = Vec::new();
    if points.is_empty() {
        notes.push(Note { at: (x.middle(), y.middle()), text: nothing(study), align: Align::Above });
    } else {
        guides([x, y], &mut lines, &mut notes);
    }
    for style in styles {
        let own = rows(study, number).filter(|row| style.is_of(row));
        let mut runs: Vec<((f64, f64), &Row)> =
            own.filter_map(|row| place(row).map(|(h, error)| ((h, y.held(error)), row))).collect();
        runs.sort_by(|a, b| b.0.0.total_cmp(&a.0.0));
        if !runs.is_empty() {
            let (points, of) = runs.into_iter().map(|(at, row)| (at, row.job.id.clone())).unzip();
            lines.push(Line { runs: of, ..style.line(StepSetting::Step(0.0), points) });
        }
    }
    let named = std::iter::once(("reference".to_owned(), bound)).chain(model_errors(variant));
    for (name, error) in named.filter(|(_, error)| y.has(*error)) {
        let (low, high) = x.ends();
        let points = vec![(low, error), (high, error)];
        lines.push(Line { points, ..entry(&name, Stroke::Dashed, Marker::None) });
        let text = format!("{name} {}", figures(error, 2));
        notes.push(Note { at: (high, error), text, align: Align::Left });
    }
    for (number, (style, limit)) in limits.iter().filter(|(_, limit)| x.has(*limit)).enumerate() {
        let label = if number == 0 { "stability limit" } else { "" };
        let (points, color, series) = (vec![(*limit, y.ends().0)], Some(style.color), style.label());
        lines.push(Line { points, color, series, ..entry(label, Stroke::None, Marker::Tick) });
    }
    Chart {
        title: title(study, variant, "error against step"),
        x: Axis { label: "step [s]".to_owned(), scale: Scale::Log, range: Some(x.ends()) },
        y: Axis { label: MOTION.to_owned(), scale: Scale::Log, range: Some(y.ends()) },
        lines,
        notes,
        margin_panel: margin_panel(study, styles, number, PanelSide::Top, |row| {
            let h = step(row)?;
            place(row).is_none().then_some(Some(h))
        }),
        ..Chart::default()
    }
}

/// Style and critical step of every method that has one.
fn limits<'s>(variant: Option<&Variant>, styles: &'s [Style]) -> Vec<(&'s Style, f64)> {
    let limit = |style: &Style| variant?.critical_steps.get(&style.label()).copied();
    styles.iter().filter_map(|style| Some((style, limit(style).filter(|h| *h > 0.0)?))).collect()
}

/// Straight lines of whole orders through the upper right corner, with their names where they leave the picture.
fn guides([x, y]: [Span; 2], lines: &mut Vec<Line>, notes: &mut Vec<Note>) {
    let ((left, right), (bottom, top)) = (x.ends(), y.ends());
    for slope in SLOPES {
        let at_left = top * (left / right).powf(slope);
        let at = |height: f64| (right * (height / top).powf(1.0 / slope), height);
        // Names stand clear of the ticks on the lower edge.
        let (end, named) = if at_left >= bottom {
            ((left, at_left), (left, at_left))
        } else {
            (at(bottom), at(bottom * (top / bottom).powf(NAMED)))
        };
        let points = vec![(right, top), end];
        lines.push(Line { points, stroke: Stroke::Thin, color: Some(BLACK), ..Line::default() });
        notes.push(Note { at: named, text: format!("slope {slope}"), align: Align::RightBelow });
    }
}
