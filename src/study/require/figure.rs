//! What each change costs in accuracy and saves in work.

use super::combine::Lean;
use super::compare::Comparison;
use super::plan::RequirePlan;
use crate::error::StudyError;
use crate::plot::chart::{Axis, Chart, Line, Marker, Size, Stroke};
use crate::template::PageFigure;

/// [px] The figure on wide and on narrow screens.
const PAGE: [Size; 2] = [Size { width: 900, height: 440 }, Size { width: 460, height: 420 }];
/// [-] Differences below this are drawn here.
const LEAST: f64 = 1e-6;

/// Largest difference and counted work of each change, over those of the full model; none where nothing was compared.
pub(super) fn figure(
    plan: &RequirePlan,
    all: &[Comparison],
    lean: Option<&Lean>,
) -> Result<Option<PageFigure>, StudyError> {
    let point = |one: &Comparison| {
        let shares = one.differences.iter().filter_map(|of| of.share);
        let largest = shares.fold(0.0, |largest: f64, share| largest.max(share.abs()));
        Some((largest.max(LEAST), 1.0 - one.saved.filter(|_| one.harmless.is_some())?))
    };
    let line = |label: &str, marker: Marker, color: usize, runs: &mut dyn Iterator<Item = &Comparison>| {
        let points: Vec<((f64, f64), String)> = runs.filter_map(|one| Some((point(one)?, one.id.clone()))).collect();
        let (points, runs): (Vec<_>, Vec<_>) = points.into_iter().unzip();
        let (label, stroke) = (label.to_owned(), Stroke::None);
        Line { series: label.clone(), label, points, runs, stroke, marker, color: Some(color), ..Line::default() }
    };
    let of = |harmless: bool| move |one: &&Comparison| one.harmless == Some(harmless);
    let lines: Vec<Line> = [
        line("within", Marker::Dot, 2, &mut all.iter().filter(of(true))),
        line("not within", Marker::Cross, 1, &mut all.iter().filter(of(false))),
        line("lean case", Marker::Star, 0, &mut lean.iter().map(|lean| &lean.distance)),
    ]
    .into_iter()
    .filter(|line| !line.points.is_empty())
    .collect();
    if lines.is_empty() {
        return Ok(None);
    }
    let chart = Chart {
        title: format!("{}: changes by one thing", plan.name),
        lines,
        x: Axis::log("largest difference of a quantity over its value [-]"),
        y: Axis::log("counted work over that of the full model [-]"),
        ..Chart::default()
    };
    let caption = format!(
        "Each mark is the case with one change: a dot is within the accuracy, a cross is not, the star is the leanest \
         case. Left is closer to the full model, down is cheaper. Differences below {LEAST:e} stand there."
    );
    Ok(Some(PageFigure::of(&chart, caption, PAGE)?))
}

/// What a mark tells.
pub(super) fn told(one: &Comparison) -> Vec<[String; 2]> {
    let numbers = one.differences.iter().filter_map(|of| Some([of.name.clone(), super::combine::percent(of.share?)]));
    let ends = [["change".to_owned(), one.described.clone()], ["work".to_owned(), super::combine::cost(one)]];
    let [first, last] = ends;
    [first].into_iter().chain(numbers).chain([last]).collect()
}
