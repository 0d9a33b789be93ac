//! What the tables of a run hold over time: the energy account, steps, gauges; and forces in its frames.

use super::PlotError;
use super::chart::{Marker, Stroke};
use super::curve::{Curve, Plane, Sample, is_constant};
use super::difference::minus;
use super::panel::Panel;
use super::results::Run;
use super::series::joined;
use super::view::{Kind, Results, View};
use crate::model::gauge::{
    NodeGauge, PeakRule, Quantity, REACTION_MAX, REACTION_TOTAL, ReportLine, SpringGauge, TENSION_MAX,
};
use crate::output::gauges::names::for_people;
use crate::output::rows::HistoryRow;
use std::collections::BTreeSet;

/// An entry below this share of the largest one is rounding, and is not drawn.
const ROUNDING: f64 = 1e-12;

/// [-] A series below this share of what it is a part of, as a component of a force, is rounding.
const NOISE: f64 = 1e-8;
/// [deg] What an angle is compared with.
const TURN: f64 = 180.0;

/// A quantity over time.
#[derive(Clone, Debug, Default)]
struct Series {
    /// whose: a gauge by its name for people, or an entry of the account; empty if there is only one
    name: String,
    /// name of the gauge in the files
    gauge: String,
    /// name of its column; those with the same share a chart
    quantity: String,
    /// what it is, for a title
    words: String,
    unit: String,
    /// which of its values is its peak, if that is marked
    peak: Option<PeakRule>,
    /// order among charts of which only some are drawn
    rank: u8,
    /// number in the palette, if it is fixed
    color: Option<usize>,
    samples: Vec<Sample>,
}

/// A column of `history.csv`, or a sum of some.
#[derive(Clone, Copy)]
struct Entry {
    name: &'static str,
    /// for a title
    words: &'static str,
    of: fn(&HistoryRow) -> f64,
}

/// In the order of drawing.
const ENTRIES: [Entry; 7] = [
    Entry {
        name: "kinetic + elastic + gravity",
        words: "kinetic + elastic + gravity energy",
        of: |r| r.ledger.kinetic + r.ledger.elastic + r.ledger.gravity,
    },
    Entry { name: "kinetic", words: "kinetic energy", of: |r| r.ledger.kinetic },
    Entry { name: "elastic", words: "elastic energy", of: |r| r.ledger.elastic },
    Entry { name: "gravity", words: "energy of gravity", of: |r| r.ledger.gravity },
    Entry { name: "external work", words: "external work", of: |r| r.ledger.external_work },
    Entry { name: "dissipated", words: "dissipated energy", of: |r| r.ledger.dissipated },
    Entry { name: "numerical", words: "numerical energy, the error of the scheme", of: |r| r.ledger.numerical },
];

/// Columns about steps that are left out where they are zero in all runs, with their units and whether their peaks are
/// marked.
const STEPS: [(Entry, &str, bool); 3] = [
    (
        Entry {
            name: "newton iterations",
            words: "Newton iterations of a step",
            of: |r| f64::from(r.newton_iterations),
        },
        "-",
        false,
    ),
    (Entry { name: "largest speed", words: "largest speed of a node", of: |r| r.max_speed }, "m/s", true),
    (Entry { name: "largest strain", words: "largest strain of a spring", of: |r| r.max_strain }, "-", true),
];

/// The columns of `history.csv` to draw, the same for all runs.
struct Columns {
    /// entries of the account, with their colours
    entries: Vec<(usize, Entry)>,
    /// whether they share one chart
    one_chart: bool,
    steps: Vec<(Entry, &'static str, bool)>,
}

/// The panels of a kind: one for every quantity. Colours and labels are the same in all of them.
pub(super) fn panels(results: &Results, view: &View, kind: Kind) -> Result<Vec<Panel>, PlotError> {
    let tables = tables(results, view, kind)?;
    let all = || tables.iter().flatten();
    let several = all().any(|series| all().next().is_some_and(|first| first.name != series.name));
    let own = |series: &Series| if several { series.name.clone() } else { String::new() };
    let looks = results.looks().filter(|_| !several);
    let (mut known, mut panels): (Vec<String>, Vec<(&str, Panel)>) = (Vec::new(), Vec::new());
    for (number, ((table, run), ended)) in tables.iter().zip(&results.runs).zip(results.labels()).enumerate() {
        let look = looks.as_ref().and_then(|looks| looks.get(number)).copied();
        for series in table {
            let label = joined(&own(series), &ended);
            let color = known.iter().position(|known| *known == label).unwrap_or(known.len());
            if color == known.len() {
                known.push(label.clone());
            }
            let (of_run, marker) = look.unwrap_or((color, Marker::None));
            let (color, samples) = (series.color.unwrap_or(of_run), series.samples.clone());
            let (ending, peak) = (run.ending, series.peak);
            let curve = Curve { ending, label, color, stroke: Stroke::Normal, marked: true, marker, peak, samples };
            if let Some((_, panel)) = panels.iter_mut().find(|(quantity, _)| *quantity == series.quantity) {
                panel.curves.push(curve);
                continue;
            }
            let mut sharing = all().filter(|other| other.quantity == series.quantity);
            let alone = sharing.all(|other| other.name == series.name);
            let subject = if alone && !series.name.is_empty() { format!(" ({})", series.name) } else { String::new() };
            let title = results.title(&format!("{}{subject}", series.words));
            let axes = ["time t [s]".to_owned(), results.axis(&series.label())];
            let (unit, rank, plane, curves) = (series.unit(), series.rank, Plane::Time, vec![curve]);
            panels.push((&series.quantity, Panel { title, axes, unit, rank, plane, cubic: true, curves }));
        }
    }
    Ok(panels.into_iter().map(|(_, panel)| panel).collect())
}

impl Series {
    fn unit(&self) -> String {
        self.unit.replace("^2", "²").replace("^3", "³")
    }

    /// The quantity with its unit.
    fn label(&self) -> String {
        let unit = self.unit();
        if unit.is_empty() { self.words.clone() } else { format!("{} [{unit}]", self.words) }
    }

    /// Largest magnitude of its values.
    fn size(&self) -> f64 {
        self.samples.iter().map(|sample| sample.value.abs()).filter(|v| v.is_finite()).fold(0.0, f64::max)
    }
}

/// Leaves out quantities that say nothing in any run: constants, and what is rounding beside the other columns of its
/// gauge with the same unit. Where all say nothing, all stay.
fn leave_out_noise(tables: &mut [Vec<Series>]) {
    let says = |table: &[Series], series: &Series| {
        let alike = |other: &&Series| other.gauge == series.gauge && other.unit == series.unit;
        let scale = table.iter().filter(alike).map(Series::size).fold(0.0, f64::max);
        let scale = if series.unit == "deg" { TURN } else { scale };
        !is_constant(&series.samples) && series.size() > NOISE * scale
    };
    let which = |series: &Series| (series.gauge.clone(), series.quantity.clone());
    let telling =
        |table: &Vec<Series>| table.iter().filter(|series| says(table, series)).map(which).collect::<Vec<_>>();
    let kept: BTreeSet<(String, String)> = tables.iter().flat_map(telling).collect();
    if !kept.is_empty() {
        tables.iter_mut().for_each(|table| table.retain(|series| kept.contains(&which(series))));
    }
}

/// What each run holds of a kind at the times of a view, less what the run to subtract holds.
fn tables(results: &Results, view: &View, kind: Kind) -> Result<Vec<Vec<Series>>, PlotError> {
    let entries = shown(&results.runs, view);
    let rows = || results.runs.iter().chain(&results.base).flat_map(|run| &run.history);
    let steps = STEPS.into_iter().filter(|(entry, ..)| rows().any(|row| (entry.of)(row) != 0.0)).collect();
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
    // The account has its own rule; of a difference, nothing is what one looks for.
    if !matches!(kind, Kind::Energy | Kind::Ledger) && results.base.is_none() {
        leave_out_noise(&mut tables);
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
    let column = |entry: Entry, unit: &str| {
        let value = |row: &HistoryRow| Sample { t: row.t, value: (entry.of)(row), rate: f64::NAN };
        let samples = run.history.iter().map(value).collect();
        let (quantity, words, unit) = (entry.name.to_owned(), entry.words.to_owned(), unit.to_owned());
        Series { quantity, words, unit, samples, ..Series::default() }
    };
    let in_one_chart = |&(color, entry): &(usize, Entry)| {
        let (name, what) = (entry.name.to_owned(), "energy".to_owned());
        Series { name, quantity: what.clone(), words: what, color: Some(color), ..column(entry, "J") }
    };
    let entries = &history.entries;
    Ok(match kind {
        Kind::Energy if history.one_chart => entries.iter().map(in_one_chart).collect(),
        Kind::Energy | Kind::Ledger => entries.iter().map(|&(_, entry)| column(entry, "J")).collect(),
        Kind::Steps => {
            let columns = history.steps.iter().map(|&(entry, unit, marked)| {
                let peak = marked.then_some(PeakRule::Largest);
                Series { peak, rank: u8::from(!marked), ..column(entry, unit) }
            });
            std::iter::once(Series { rank: 1, ..step_size(run) }).chain(columns).collect()
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
    let name = "step size".to_owned();
    Series { quantity: name.clone(), words: name, unit: "s".to_owned(), samples, ..Series::default() }
}

/// The rank of what the report does not tell.
const LAST: u8 = 5;

/// The order of quantities of which only some are drawn: loads first, what the report does not tell last.
fn rank(line: Option<ReportLine>) -> u8 {
    match line {
        Some(ReportLine::Drag) => 0,
        Some(ReportLine::Peak(_)) => 1,
        Some(ReportLine::Descent) => 2,
        Some(ReportLine::Told(_)) => 3,
        Some(ReportLine::Ratio { .. }) => 4,
        None => LAST,
    }
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
    let labels = for_people(run.gauges.iter().map(|gauge| gauge.name.as_str()));
    let of_gauge = |gauge: &super::results::GaugePath| {
        let known = Quantity::named(&gauge.quantity);
        Series {
            name: labels.get(gauge.name.as_str()).copied().unwrap_or(&gauge.name).to_owned(),
            gauge: gauge.name.clone(),
            quantity: gauge.quantity.clone(),
            words: known.map_or_else(|| gauge.quantity.replace('_', " "), |known| known.words()),
            unit: gauge.unit.clone(),
            peak: Some(known.map_or(PeakRule::LargestMagnitude, |known| known.peak)),
            rank: known.map_or(LAST, |known| rank(known.line)),
            color: None,
            samples: gauge.values.iter().map(|&(t, value)| Sample { t, value, rate: f64::NAN }).collect(),
        }
    };
    let mut all: Vec<Series> = run.gauges.iter().map(of_gauge).collect();
    if let Some((array, _)) = only.filter(|(array, _)| run.fields.iter().any(|field| field == array)) {
        all.extend(in_frames(run, kind, array)?);
    }
    let called = |series: &Series, name: &String| series.name == *name || series.gauge == *name;
    if let Some(name) = view.gauges.iter().find(|name| all.iter().all(|series| !called(series, name))) {
        let mut names: Vec<&str> = all.iter().map(|series| series.name.as_str()).collect();
        names.dedup();
        let (folder, there) = (run.folder.display(), if names.is_empty() { "none".into() } else { names.join(", ") });
        return Err(PlotError::NotThere(format!("{folder}: no gauge is called \"{name}\"; there are: {there}")));
    }
    all.retain(|series| view.gauges.is_empty() || view.gauges.iter().any(|name| called(series, name)));
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
    let series = |name: &str, column: Quantity, place: usize| {
        let samples = found.iter().map(|(t, of)| Sample { t: *t, value: of[place], rate: f64::NAN }).collect();
        let (name, quantity, unit) = (name.to_owned(), column.name.to_owned(), column.unit.to_owned());
        let (words, peak, rank) = (column.words(), Some(column.peak), rank(column.line));
        Series { gauge: name.clone(), name, quantity, words, unit, peak, rank, samples, color: None }
    };
    Ok(match kind {
        Kind::Reaction => {
            vec![
                series("all supports, in frames", REACTION_TOTAL, 0),
                series("all supports, in frames", REACTION_MAX, 1),
            ]
        }
        _ => vec![series("all springs, in frames", TENSION_MAX, 1)],
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
