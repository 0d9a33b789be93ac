//! What the tables of a run hold over time: the energy account, steps, gauges; and forces in its frames.

use super::PlotError;
use super::chart::Stroke;
use super::curve::{Curve, Plane, Sample};
use super::difference::minus;
use super::panel::Panel;
use super::results::Run;
use super::series::joined;
use super::view::{Kind, Results, View};
use crate::model::gauge::{NodeGauge, Quantity, REACTION_MAX, REACTION_TOTAL, SpringGauge, TENSION_MAX};
use crate::output::rows::HistoryRow;

/// An entry below this share of the largest one is rounding, and is not drawn.
const ROUNDING: f64 = 1e-12;

/// A quantity over time.
#[derive(Clone, Debug)]
struct Series {
    /// whose: a gauge, or an entry of the account; empty if there is only one
    name: String,
    /// title of its chart; those with the same share one
    quantity: String,
    unit: String,
    /// number in the palette, if it is fixed
    color: Option<usize>,
    samples: Vec<Sample>,
}

/// A column of `history.csv`, or a sum of some.
#[derive(Clone, Copy)]
struct Entry {
    name: &'static str,
    of: fn(&HistoryRow) -> f64,
}

/// In the order of drawing.
const ENTRIES: [Entry; 7] = [
    Entry { name: "kinetic + elastic + gravity", of: |r| r.ledger.kinetic + r.ledger.elastic + r.ledger.gravity },
    Entry { name: "kinetic", of: |r| r.ledger.kinetic },
    Entry { name: "elastic", of: |r| r.ledger.elastic },
    Entry { name: "gravity", of: |r| r.ledger.gravity },
    Entry { name: "external work", of: |r| r.ledger.external_work },
    Entry { name: "dissipated", of: |r| r.ledger.dissipated },
    Entry { name: "numerical", of: |r| r.ledger.numerical },
];

/// Columns about steps that are left out where they are zero in all runs, with their units.
const STEPS: [(Entry, &str); 3] = [
    (Entry { name: "newton iterations", of: |r| f64::from(r.newton_iterations) }, ""),
    (Entry { name: "largest speed", of: |r| r.max_speed }, "m/s"),
    (Entry { name: "largest strain", of: |r| r.max_strain }, "-"),
];

/// The columns of `history.csv` to draw, the same for all runs.
struct Columns {
    /// entries of the account, with their colours
    entries: Vec<(usize, Entry)>,
    /// whether they share one chart
    one_chart: bool,
    steps: Vec<(Entry, &'static str)>,
}

/// The panels of a kind: one for every quantity. Colours and labels are the same in all of them.
pub(super) fn panels(results: &Results, view: &View, kind: Kind) -> Result<Vec<Panel>, PlotError> {
    let tables = tables(results, view, kind)?;
    let all = || tables.iter().flatten();
    let several = all().any(|series| all().next().is_some_and(|first| first.name != series.name));
    let own = |series: &Series| if several { series.name.clone() } else { String::new() };
    let (mut known, mut panels): (Vec<String>, Vec<(&str, Panel)>) = (Vec::new(), Vec::new());
    for ((table, run), ended) in tables.iter().zip(&results.runs).zip(results.labels()) {
        for series in table {
            let label = joined(&own(series), &ended);
            let color = known.iter().position(|known| *known == label).unwrap_or(known.len());
            if color == known.len() {
                known.push(label.clone());
            }
            let (color, samples) = (series.color.unwrap_or(color), series.samples.clone());
            let curve = Curve { ending: run.ending, label, color, stroke: Stroke::Normal, marked: true, samples };
            if let Some((_, panel)) = panels.iter_mut().find(|(quantity, _)| *quantity == series.quantity) {
                panel.curves.push(curve);
                continue;
            }
            let mut sharing = all().filter(|other| other.quantity == series.quantity);
            let alone = sharing.all(|other| other.name == series.name);
            let subject = if alone { own(series) } else { String::new() };
            let title = results.title(format!("{subject} {}", series.quantity).trim_start());
            let axes = ["time t [s]".to_owned(), results.axis(&series.label())];
            panels
                .push((&series.quantity, Panel { title, axes, plane: Plane::Time, cubic: true, curves: vec![curve] }));
        }
    }
    Ok(panels.into_iter().map(|(_, panel)| panel).collect())
}

impl Series {
    /// The quantity with its unit.
    fn label(&self) -> String {
        let unit = self.unit.replace("^2", "²").replace("^3", "³");
        if unit.is_empty() { self.quantity.clone() } else { format!("{} [{unit}]", self.quantity) }
    }
}

/// What each run holds of a kind at the times of a view, less what the run to subtract holds.
fn tables(results: &Results, view: &View, kind: Kind) -> Result<Vec<Vec<Series>>, PlotError> {
    let entries = shown(&results.runs, view);
    let rows = || results.runs.iter().chain(&results.base).flat_map(|run| &run.history);
    let steps = STEPS.into_iter().filter(|(entry, _)| rows().any(|row| (entry.of)(row) != 0.0)).collect();
    let history = Columns { entries, one_chart: results.runs.len() == 1, steps };
    let mut tables = Vec::new();
    let mut missing = None;
    for run in &results.runs {
        match series(run, view, kind, &history) {
            Err(error @ PlotError::NotHeld { .. }) => {
                missing = Some(error);
                tables.push(Vec::new());
            }
            table => tables.push(table?),
        }
    }
    // Where some run holds something of it, the others may lack it.
    if let Some(error) = missing.filter(|_| tables.iter().all(Vec::is_empty)) {
        return Err(error);
    }
    if let Some(base) = &results.base {
        let table = series(base, view, kind, &history)?;
        for series in tables.iter_mut().flatten() {
            let same = |other: &&Series| other.name == series.name && other.quantity == series.quantity;
            let other = table.iter().find(same).ok_or_else(|| unmatched(base, series, &table))?;
            series.samples = minus(std::mem::take(&mut series.samples), &other.samples);
        }
    }
    for series in tables.iter_mut().flatten() {
        series.samples.retain(|sample| view.sees(sample.t));
    }
    Ok(tables)
}

fn unmatched(base: &Run, series: &Series, table: &[Series]) -> PlotError {
    let called = |series: &Series| joined(&series.name, &series.quantity);
    PlotError::Unmatched {
        folder: base.folder.clone(),
        missing: format!("\"{}\"", called(series)),
        there: table.iter().map(called).collect(),
        choose: "--gauge or --kind",
    }
}

/// What a run holds of a kind.
fn series(run: &Run, view: &View, kind: Kind, history: &Columns) -> Result<Vec<Series>, PlotError> {
    let column = |entry: Entry, name: &str, quantity: &str, unit: &str, color| {
        let value = |row: &HistoryRow| Sample { t: row.t, value: (entry.of)(row), rate: f64::NAN };
        let samples = run.history.iter().map(value).collect();
        Series { name: name.to_owned(), quantity: quantity.to_owned(), unit: unit.to_owned(), color, samples }
    };
    let entries = &history.entries;
    Ok(match kind {
        Kind::Energy if history.one_chart => {
            entries.iter().map(|&(color, entry)| column(entry, entry.name, "energy", "J", Some(color))).collect()
        }
        Kind::Energy | Kind::Ledger => {
            entries.iter().map(|&(_, entry)| column(entry, "", entry.name, "J", None)).collect()
        }
        Kind::Steps => {
            let columns = history.steps.iter().map(|&(entry, unit)| column(entry, "", entry.name, unit, None));
            std::iter::once(step_size(run)).chain(columns).collect()
        }
        _ => gauges(run, view, kind)?,
    })
}

/// [s] Sizes of the steps, their mean where several lie between two rows.
fn step_size(run: &Run) -> Series {
    let size = |rows: &[HistoryRow]| match rows {
        [a, b] if b.step > a.step => {
            let count = (b.step - a.step) as f64;
            let mean = (b.t - a.t) / count;
            let rounding = 8.0 * f64::EPSILON * b.t.abs() / count;
            let value = run.step.filter(|step| (mean - step).abs() <= rounding).unwrap_or(mean);
            Some(Sample { t: b.t, value, rate: f64::NAN })
        }
        _ => None,
    };
    let samples = run.history.windows(2).filter_map(size).collect();
    Series { name: String::new(), quantity: "step size".to_owned(), unit: "s".to_owned(), color: None, samples }
}

/// The gauges of a view; of those kinds that are about a force, with its largest value in the frames.
fn gauges(run: &Run, view: &View, kind: Kind) -> Result<Vec<Series>, PlotError> {
    let (only, what, add): (Option<(&str, &[Quantity])>, _, _) = match kind {
        Kind::Tension => {
            let only = ("tension", SpringGauge::Tension.columns().all());
            (Some(only), "no gauge and no frame has tensions", "a gauge or a field of tension")
        }
        Kind::Reaction => {
            let only = ("reaction", NodeGauge::REACTION.columns.all());
            (Some(only), "no gauge and no frame has reactions", "a gauge or a field of reaction")
        }
        _ => (None, "nothing was measured", "gauges"),
    };
    let of_gauge = |gauge: &super::results::GaugePath| Series {
        name: gauge.name.clone(),
        quantity: gauge.quantity.clone(),
        unit: gauge.unit.clone(),
        color: None,
        samples: gauge.values.iter().map(|&(t, value)| Sample { t, value, rate: f64::NAN }).collect(),
    };
    let mut all: Vec<Series> = run.gauges.iter().map(of_gauge).collect();
    if let Some((array, _)) = only.filter(|(array, _)| run.fields.iter().any(|field| field == array)) {
        all.extend(in_frames(run, kind, array)?);
    }
    if let Some(name) = view.gauges.iter().find(|name| all.iter().all(|series| series.name != **name)) {
        let mut names: Vec<&str> = all.iter().map(|series| series.name.as_str()).collect();
        names.dedup();
        let (folder, there) = (run.folder.display(), if names.is_empty() { "none".into() } else { names.join(", ") });
        return Err(PlotError::NotThere(format!("{folder}: no gauge is called \"{name}\"; there are: {there}")));
    }
    all.retain(|series| view.gauges.is_empty() || view.gauges.contains(&series.name));
    if let Some((_, columns)) = only {
        all.retain(|series| columns.iter().any(|column| column.name == series.quantity));
    }
    if all.is_empty() { Err(PlotError::NotHeld { folder: run.folder.clone(), what, add }) } else { Ok(all) }
}

/// The largest tension of all springs; the sum and the largest reaction of all supports.
fn in_frames(run: &Run, kind: Kind, array: &str) -> Result<Vec<Series>, PlotError> {
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::NEG_INFINITY, f64::max);
    let size = |[x, y, z]: [f64; 3]| x.hypot(y).hypot(z);
    let found: Vec<(f64, [f64; 2])> = run.over_frames(array, |values| {
        let vectors = || values.as_chunks::<3>().0.iter().copied();
        match kind {
            Kind::Reaction => {
                let sum = vectors().fold([0.0; 3], |[a, b, c], [x, y, z]| [a + x, b + y, c + z]);
                [size(sum), largest(&mut vectors().map(size))]
            }
            _ => [f64::NAN, largest(&mut values.iter().copied())],
        }
    })?;
    let series = |name: &str, Quantity { name: quantity, unit, .. }: Quantity, place: usize| {
        let samples = found.iter().map(|(t, of)| Sample { t: *t, value: of[place], rate: f64::NAN }).collect();
        Series { name: name.into(), quantity: quantity.into(), unit: unit.into(), color: None, samples }
    };
    Ok(match kind {
        Kind::Reaction => {
            vec![series("all supports (frames)", REACTION_TOTAL, 0), series("all supports (frames)", REACTION_MAX, 1)]
        }
        _ => vec![series("all springs (frames)", TENSION_MAX, 1)],
    })
}

/// The entries of the account that are not zero in some run, with their colours; the sum only if it has several
/// summands.
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
    let rows = || run.history.iter().filter(|row| view.sees(row.t));
    ENTRIES.map(|entry| rows().map(|row| (entry.of)(row).abs()).filter(|v| v.is_finite()).fold(0.0, f64::max))
}
