//! Stability regions, and the scene's own motions in them.
//!
//! The plane of z = h lambda: an oscillation of frequency w and damping ratio zeta has lambda = w (-zeta +- i sqrt(1 -
//! zeta^2)). A method is stable where the spectral radius of one real step of its code on that oscillator is at most 1;
//! the boundary is sought along rays of equal zeta from the imaginary axis (undamped) to the real one (zeta = 1). What
//! a scheme that treats x and v differently does to a motion damped more than critically is no matter of z alone: such
//! motions are left out of its panel. Methods without a region are named in the legend, with what was measured of them.

use super::{KnownBy, Row, Stability, Status};
use crate::analysis::critical::has_limit;
use crate::analysis::limit::critical_step;
use crate::analysis::rates::Rates;
use crate::analysis::spectrum::Spectrum;
use crate::format_number::figures;
use crate::integrate::registry::MethodChoice;
use crate::method_look::{BLACK, method_colors, method_mark, outline};
use crate::plot::PlotError;
use crate::plot::chart::{Axis, Chart, Line, Marker, Size, Stroke};
use crate::plot::layout::svg_grid;
use crate::scene::Scene;
use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;

/// Rays from the imaginary to the real axis.
const RAYS: u32 = 90;
/// [-] size of z at which a ray that never becomes unstable is drawn to end; beyond all limits that are sought.
const FARTHEST: f64 = 8.0;
/// Panels in a row.
const COLUMNS: usize = 3;
/// Of a panel; the legend takes its column from the picture's width.
const PANEL: Size = Size { width: 400, height: 470 };

/// [px] width of a picture of one panel, with room for the legend's words.
const ALONE: u32 = 660;

/// A panel for every method with a limit; empty if there is none.
pub(super) fn panels(scene: &dyn Scene, methods: &[MethodChoice], study: &Stability) -> Vec<Chart> {
    let state = scene.initial_state();
    // Whoever has asked for the end does not wait for another search.
    let interrupted = study.methods.iter().any(|row| row.status == Status::Interrupted);
    let motions = if interrupted { Vec::new() } else { Spectrum::of(scene, state.as_ref()).outer_modes() };
    let colors = method_colors(methods.iter().map(|method| method.info.name));
    let rows = methods.iter().zip(&study.methods).zip(colors).filter(|((_, row), _)| row.status != Status::Refused);
    let limited = rows.filter(|((method, _), _)| has_limit(method));
    limited.map(|((method, row), color)| panel(method, row, &motions, color)).collect()
}

/// All panels as SVG, with what there is to say of methods without a limit; `None` if there is no panel.
pub(super) fn picture(
    mut charts: Vec<Chart>,
    methods: &[MethodChoice],
    study: &Stability,
) -> Result<Option<String>, PlotError> {
    // The title of a panel says whose marks and colour they are.
    let mut told = BTreeSet::new();
    for line in charts.iter_mut().flat_map(|chart| &mut chart.lines) {
        if !told.insert(line.label.clone()) {
            line.label.clear();
        }
    }
    let Some(first) = charts.first_mut() else { return Ok(None) };
    let rows = methods.iter().zip(&study.methods).filter(|(_, row)| row.status != Status::Refused);
    for (_, row) in rows.filter(|(method, _)| !has_limit(method)) {
        first.lines.push(Line { label: without_region(row), stroke: Stroke::None, ..Line::default() });
    }
    if charts.len() == 1 {
        charts.iter_mut().for_each(|chart| chart.size.width = ALONE);
    }
    svg_grid(&charts, COLUMNS).map(Some)
}

/// What there is to say of a method that has a limit on no oscillator.
fn without_region(row: &Row) -> String {
    let name = &row.method;
    match (row.status, row.measured, row.tried_up_to) {
        (Status::Measured, Some(measured), _) if measured > 0.0 => {
            format!("{name}: measured {} s", figures(measured, 3))
        }
        (Status::Measured, Some(_), _) => format!("{name}: no step held"),
        (Status::Measured, None, Some(_)) if row.prediction.known_by == KnownBy::Unlimited => {
            format!("no limit: {name}")
        }
        (Status::Measured, None, Some(longest)) => format!("{name}: holds up to {} s", figures(longest, 3)),
        _ => format!("{name}: not measured"),
    }
}

/// The boundary in the upper half plane, from the imaginary to the real axis.
pub(super) fn boundary(method: &MethodChoice) -> Vec<(f64, f64)> {
    let ray = |i: u32| {
        let zeta = (FRAC_PI_2 * f64::from(i) / f64::from(RAYS)).sin();
        let size = critical_step(method, Rates { frequency: 1.0, damping: 2.0 * zeta, ..Rates::default() });
        let size = size.min(FARTHEST);
        (-zeta * size, (1.0 - zeta * zeta).max(0.0).sqrt() * size)
    };
    (0..=RAYS).map(ray).collect()
}

/// h lambda of both motions with these rates; two real ones where damping is more than critical.
fn places(rates: &Rates, h: f64) -> [(f64, f64); 2] {
    let (w, half) = (h * rates.frequency, 0.5 * h * rates.damping);
    let square = w * w - half * half;
    let root = square.abs().sqrt();
    if square >= 0.0 { [(-half, root), (-half, -root)] } else { [(-half - root, 0.0), (-half + root, 0.0)] }
}

fn panel(method: &MethodChoice, row: &Row, motions: &[Rates], color: usize) -> Chart {
    let upper = boundary(method);
    let lower = upper.iter().rev().map(|(re, im)| (*re, -*im));
    let closed: Vec<(f64, f64)> = upper.iter().copied().chain(lower).chain(upper.first().copied()).collect();
    let oscillates = |rates: &&Rates| rates.frequency > 0.5 * rates.damping;
    let split = method.partitioned();
    let drawn: Vec<&Rates> = motions.iter().filter(|rates| !split || oscillates(rates)).collect();
    let title = match drawn.len() < motions.len() {
        true => format!("{} (oscillations only)", row.method),
        false => row.method.clone(),
    };
    let reach = |part: fn(&(f64, f64)) -> f64| upper.iter().map(part).fold(0.5, f64::max);
    let (left, high) = (1.12 * reach(|z| -z.0), 1.12 * reach(|z| z.1));
    let at = |h: Option<f64>| h.map_or_else(Vec::new, |h| drawn.iter().flat_map(|rates| places(rates, h)).collect());
    let mark = |label: &str, h: Option<f64>, marker: Marker, color: usize| {
        let points = at(h);
        let runs = vec![row.method.clone(); points.len()];
        Line {
            label: label.to_owned(),
            points,
            stroke: Stroke::None,
            marker,
            color: Some(color),
            runs,
            ..Line::default()
        }
    };
    let filled = method_mark(method.info.name);
    let region = Line {
        label: "stable".to_owned(),
        points: closed,
        stroke: Stroke::Filled,
        color: Some(color),
        ..Line::default()
    };
    Chart {
        title,
        x: Axis { label: "Re hλ [-]".to_owned(), range: Some((-left, 0.2 * left)), ..Axis::default() },
        y: Axis { label: "Im hλ [-]".to_owned(), range: Some((-high, high)), ..Axis::default() },
        lines: vec![
            region,
            mark("scene, predicted limit (filled)", row.prediction.step, filled, color),
            mark("scene, measured limit (outline)", row.measured.filter(|h| *h > 0.0), outline(filled), BLACK),
        ],
        equal_units: true,
        size: PANEL,
        ..Chart::default()
    }
}
