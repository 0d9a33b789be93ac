//! The energy account over time.

use super::PlotError;
use super::chart::{Axis, Chart, Line, Size, Stroke};
use super::curve::{AxisLimits, Curve, TimedPoint, limits, times};
use super::results::Run;
use super::series::{joined, labels, title};
use super::view::View;
use crate::drive::observer::LedgerRow;

/// An entry below this share of the largest one is rounding, and is not drawn.
const ROUNDING: f64 = 1e-12;
/// Size of a panel if there are several [px].
const PANEL: Size = Size { width: 640, height: 360 };

/// An entry of the account, or a sum of some.
#[derive(Clone, Copy)]
struct Entry {
    name: &'static str,
    of: fn(&LedgerRow) -> f64,
}

/// In the order of drawing.
const ENTRIES: [Entry; 7] = [
    Entry { name: "kinetic + elastic + gravity", of: |r| r.kinetic + r.elastic + r.gravity },
    Entry { name: "kinetic", of: |r| r.kinetic },
    Entry { name: "elastic", of: |r| r.elastic },
    Entry { name: "gravity", of: |r| r.gravity },
    Entry { name: "external work", of: |r| r.external_work },
    Entry { name: "dissipated", of: |r| r.dissipated },
    Entry { name: "numerical", of: |r| r.numerical },
];

/// For a single run, all entries in one chart; for several runs, one chart per entry. Entries that are always zero are
/// left out.
pub(super) fn charts(runs: &[Run], view: &View) -> Result<Vec<Chart>, PlotError> {
    let shown = shown(runs, view);
    if runs.iter().all(|run| run.energies.iter().all(|(t, _)| !view.sees(*t))) {
        return Err(PlotError::NotThere("no row of history.csv is within --from and --to".to_owned()));
    }
    let labels = labels(runs);
    if let [run] = runs {
        let ended = labels.first().map_or("", String::as_str);
        let curves = shown.iter().map(|(_, entry)| curve(run, *entry, view)).collect();
        let names = shown.iter().map(|(color, entry)| (*color, joined(entry.name, ended))).collect();
        return Ok(vec![chart(title(runs, "energy"), curves, names)]);
    }
    let panel = |(_, entry): &(usize, Entry)| {
        let curves = runs.iter().map(|run| curve(run, *entry, view)).collect();
        let names = labels.iter().cloned().enumerate().collect();
        Chart { size: PANEL, ..chart(title(runs, entry.name), curves, names) }
    };
    Ok(shown.iter().map(panel).collect())
}

fn curve(run: &Run, entry: Entry, view: &View) -> Curve {
    let rows = run.energies.iter().filter(|(t, _)| view.sees(*t));
    Curve { ending: run.ending, points: rows.map(|(t, row)| TimedPoint { t: *t, at: (*t, (entry.of)(row)) }).collect() }
}

fn chart(title: String, curves: Vec<Curve>, names: Vec<(usize, String)>) -> Chart {
    let limits = AxisLimits { x: times(&curves), y: limits(&curves, |p| p.1) };
    let lines = curves.iter().zip(&names).map(|(curve, (color, name))| curve.line(name, *color, Stroke::Normal));
    let marks = curves.iter().zip(&names).filter_map(|(curve, (color, _))| curve.end_mark(*color, limits.y));
    let lines: Vec<Line> = lines.chain(marks).collect();
    let x = Axis { range: limits.x, ..Axis::linear("time t [s]") };
    let y = Axis { range: limits.y, ..Axis::linear("energy [J]") };
    Chart { title, x, y, lines, ..Chart::default() }
}

/// The entries that are not zero in some run, with their numbers; the sum only if it has several summands.
fn shown(runs: &[Run], view: &View) -> Vec<(usize, Entry)> {
    // Run by run: compared with the numbers of a diverged run, all of another run would count as rounding.
    let sizes: Vec<[f64; ENTRIES.len()]> = runs.iter().map(|run| sizes(run, view)).collect();
    let largest = |sizes: &[f64]| sizes.iter().copied().fold(0.0, f64::max);
    let counts = |i: usize| sizes.iter().any(|of_run| of_run[i] > ROUNDING * largest(of_run));
    let parts = (1..4).filter(|i| counts(*i)).count();
    let kept = |i: &usize| if *i == 0 { parts > 1 } else { counts(*i) };
    // The sum is black, the last colour of the palette; the others keep theirs if some are left out.
    let entry = |i: usize| ((i + ENTRIES.len() - 1) % ENTRIES.len(), ENTRIES[i]);
    let shown: Vec<_> = (0..ENTRIES.len()).filter(kept).map(entry).collect();
    // A run that is always at rest has an account of zeros, and its chart shows that.
    if shown.is_empty() { vec![entry(0)] } else { shown }
}

/// [J] the largest absolute value of every entry in a run.
fn sizes(run: &Run, view: &View) -> [f64; ENTRIES.len()] {
    let rows = || run.energies.iter().filter(|(t, _)| view.sees(*t)).map(|(_, row)| row);
    ENTRIES.map(|entry| rows().map(|row| (entry.of)(row).abs()).filter(|v| v.is_finite()).fold(0.0, f64::max))
}
