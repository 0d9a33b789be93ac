//! What stiffness costs: the best explicit and the best implicit run for an accuracy, from soft to stiff.

use super::parts::{Span, title};
use super::style::entry;
use crate::error::StudyError;
use crate::plot::chart::{Align, Axis, Chart, Line, Marker, Note, Scale, Size, Stroke};
use crate::plot::layout::svg;
use crate::recommendations::{Pick, Recommendations, StiffnessPoint};
use crate::runner::Study;

/// Colours taken in turn; black is left for what is no accuracy.
const COLORS: usize = 6;
/// Marks of explicit and implicit runs, for each turn through the colours.
const MARKERS: [[Marker; 2]; 2] = [[Marker::Dot, Marker::OpenSquare], [Marker::Triangle, Marker::OpenDiamond]];

/// The picture.
///
/// # Errors
/// The drawing library's.
pub(super) fn picture(study: &Study, answers: &Recommendations) -> Result<String, StudyError> {
    let costs = answers.stiffness.iter().flat_map(|p| [&p.explicit, &p.implicit]).flatten().map(|p| p.cpu_seconds);
    let x = Span::of(study.plan.variants.iter().map(|v| v.stiffness_factor)).unwrap_or(Span::EMPTY).with_margin();
    let y = Span::of(costs).unwrap_or(Span::EMPTY).with_margin();
    let mut lines = Vec::new();
    for (number, crossover) in answers.stiffness_crossovers.iter().enumerate() {
        let points: Vec<&StiffnessPoint> =
            answers.stiffness.iter().filter(|point| point.wanted == crossover.wanted).collect();
        let crossing =
            crossover.stiffness_factor.and_then(|factor| cost_at(&points, factor).map(|cost| (factor, cost)));
        let markers = MARKERS.get(number / COLORS % MARKERS.len()).copied().unwrap_or_default();
        lines.extend(pair(&points, markers, number % COLORS));
        lines.extend(crossing.map(|at| Line {
            points: vec![at],
            color: Some(number % COLORS),
            ..entry("", Stroke::None, Marker::Star)
        }));
    }
    let crossed = lines.iter().any(|line: &Line| line.marker == Marker::Star);
    let notes = if lines.is_empty() {
        let text = "no accuracy was reached at any stiffness".to_owned();
        vec![Note { at: (x.middle(), y.middle()), text, align: Align::Above }]
    } else {
        lines.push(entry("explicit", Stroke::Normal, Marker::Dot));
        lines.push(entry("implicit", Stroke::Dashed, Marker::OpenSquare));
        lines.extend(crossed.then(|| entry("equal cost", Stroke::None, Marker::Star)));
        Vec::new()
    };
    Ok(svg(&Chart {
        title: title(study, None, "the best explicit and implicit run"),
        x: Axis { label: "factor on the stiffness [-]".to_owned(), scale: Scale::Log, range: Some(x.ends()) },
        y: Axis { label: "processor time [s]".to_owned(), scale: Scale::Log, range: Some(y.ends()) },
        lines,
        notes,
        size: Size { width: 900, height: 560 },
        ..Chart::default()
    })?)
}

/// The lines of one accuracy: explicit full, implicit dashed.
fn pair(points: &[&StiffnessPoint], markers: [Marker; 2], color: usize) -> [Line; 2] {
    let wanted = points.first().map_or(f64::NAN, |point| point.wanted);
    let line = |of: fn(&StiffnessPoint) -> &Option<Pick>, label: String, stroke: Stroke, marker: Marker| {
        // A stiffness without a run that is good enough interrupts the line.
        let place = |p: &&StiffnessPoint| (p.stiffness_factor, of(p).as_ref().map_or(f64::NAN, |p| p.cpu_seconds));
        Line { points: points.iter().map(place).collect(), color: Some(color), ..entry(&label, stroke, marker) }
    };
    [
        line(|p| &p.explicit, format!("error {wanted:e}"), Stroke::Normal, markers[0]),
        line(|p| &p.implicit, String::new(), Stroke::Dashed, markers[1]),
    ]
}

/// Cost of the best explicit run at a factor, by interpolation of logarithms between its neighbours that both families
/// have.
fn cost_at(points: &[&StiffnessPoint], factor: f64) -> Option<f64> {
    let both = points.iter().filter(|p| p.implicit.is_some());
    let known: Vec<(f64, f64)> =
        both.filter_map(|p| Some((p.stiffness_factor.ln(), p.explicit.as_ref()?.cpu_seconds.ln()))).collect();
    let at = factor.ln();
    let (a, b) = known.windows(2).find_map(|pair| match pair {
        [a, b] if a.0 <= at && at <= b.0 => Some((*a, *b)),
        _ => None,
    })?;
    Some((a.1 + (b.1 - a.1) * (at - a.0) / (b.0 - a.0)).exp()).filter(|cost| cost.is_finite())
}
