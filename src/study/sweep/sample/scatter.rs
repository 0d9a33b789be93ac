//! All that a sample says: distributions of the numbers, what makes their scatter, where it lands, and what failed.

use serde::Serialize;

use super::beside::{Beside, Errors};
use super::design::Sampled;
use super::ellipse::Ellipse;
use super::estimate::{Estimate, beyond_largest, deviation, mean, quantile};
use super::indices::{Index, given_data, saltelli};
use crate::error::StudyError;
use crate::format_number::figures;
use crate::row::RowStatus;
use crate::sweep::SweepRow;
use crate::sweep::plan::plain;
use crate::sweep::table::{Quantity, named, quantities};

/// [-] Quantiles that are reported.
const QUANTILES: [f64; 5] = [0.01, 0.05, 0.5, 0.95, 0.99];
/// Columns of a landing.
const LANDING: [&str; 2] = ["landing.x", "landing.y"];
/// Digits of a report.
const DIGITS: usize = 4;

/// What a sample says.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Scatter {
    /// rows that count: all, or those until the rule held
    pub runs: usize,
    /// rows that reached their end
    pub completed: usize,
    /// the rule that ends the sweep, and what it came to
    pub until: Option<Until>,
    /// causes of runs without a result
    pub failed: Vec<Failed>,
    /// the numbers
    pub quantities: Vec<Distribution>,
    /// where runs landed
    pub landing: Option<Landing>,
    /// finer meshes, in words
    pub meshes: Vec<String>,
}

/// What a rule came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Until {
    /// its column
    pub column: String,
    /// its statistic: `p99`
    pub statistic: String,
    /// [-] the margin that was asked for, over the number
    pub asked: f64,
    /// [-] the margin that was reached; `None` where the sample is too small for one
    pub reached: Option<f64>,
    /// whether it was met
    pub met: bool,
}

/// Runs without a result for one reason.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Failed {
    /// how they ended
    pub status: String,
    /// why
    pub cause: String,
    /// their numbers
    pub runs: Vec<usize>,
}

/// A number of one run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Extreme {
    /// the number
    pub value: f64,
    /// the run
    pub run: usize,
}

/// The distribution of one column.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Distribution {
    /// name of the column
    pub name: String,
    /// its unit
    pub unit: String,
    /// runs that have the number
    pub runs: usize,
    /// mean
    pub mean: Estimate,
    /// standard deviation
    pub sd: Estimate,
    /// quantiles, by [-] share
    pub quantiles: Vec<Quantile>,
    /// the smallest
    pub least: Extreme,
    /// the largest
    pub largest: Extreme,
    /// [-] with 95 % probability no more of the distribution is beyond the largest
    pub beyond_largest: f64,
    /// what makes the scatter
    pub indices: Vec<Index>,
    /// what step and mesh add
    pub errors: Errors,
}

/// A quantile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Quantile {
    /// [-] share of the distribution below it
    pub p: f64,
    /// the value
    #[serde(flatten)]
    pub estimate: Estimate,
}

/// The ellipse of two columns.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Landing {
    /// the columns
    pub columns: [String; 2],
    /// the ellipse
    #[serde(flatten)]
    pub ellipse: Ellipse,
}

/// Values of a column, each with the row that has it.
fn column<'r>(quantity: &Quantity, rows: &'r [SweepRow]) -> Vec<(f64, &'r SweepRow)> {
    let completed = rows.iter().filter(|row| row.result.status == RowStatus::Completed);
    completed.filter_map(|row| Some((quantity.of(row)?, row))).collect()
}

fn values(quantity: &Quantity, rows: &[SweepRow]) -> Vec<f64> {
    column(quantity, rows).into_iter().map(|(x, _)| x).collect()
}

/// How many of these rows count: those up to the first batch after which the rule holds, if all of them were made.
///
/// # Errors
/// A rule for a column that is not there.
pub(in crate::sweep) fn counted(sampled: &Sampled, rows: &[SweepRow]) -> Result<usize, StudyError> {
    for end in sampled.batches() {
        let batch = rows.get(..end).filter(|batch| batch.iter().all(|row| row.result.status != RowStatus::NotRun));
        let Some(batch) = batch else { break };
        if until(sampled, batch)?.is_some_and(|until| until.met) {
            return Ok(end);
        }
    }
    Ok(rows.len())
}

/// What the rule came to with these rows; `None` without one.
pub(in crate::sweep) fn until(sampled: &Sampled, rows: &[SweepRow]) -> Result<Option<Until>, StudyError> {
    let Some(rule) = &sampled.until else { return Ok(None) };
    let all = quantities(rows);
    let completed = rows.iter().any(|row| row.result.status == RowStatus::Completed);
    // No run has told yet which columns there are.
    let found = if completed { values(named(&all, "--until", &rule.column)?, rows) } else { Vec::new() };
    Ok(Some(Until {
        column: rule.column.clone(),
        statistic: rule.statistic.to_string(),
        asked: rule.share,
        reached: rule.reached(&found),
        met: rule.met(&found),
    }))
}

impl Scatter {
    /// Of the rows that count, with the runs beside them; `shown` are the columns it is about.
    ///
    /// # Errors
    /// A column for the ellipse or the rule that is not there.
    pub(in crate::sweep) fn of(
        sampled: &Sampled,
        rows: &[SweepRow],
        beside: &[SweepRow],
        shown: &[&Quantity],
    ) -> Result<Self, StudyError> {
        let meshes = beside.iter().filter_map(|row| match &row.job.beside {
            Some(Beside::Mesh(words)) => Some(words.clone()),
            _ => None,
        });
        Ok(Scatter {
            runs: rows.len(),
            completed: rows.iter().filter(|row| row.result.status == RowStatus::Completed).count(),
            until: until(sampled, rows)?,
            failed: failed(rows),
            quantities: shown.iter().filter_map(|quantity| distribution(sampled, rows, beside, quantity)).collect(),
            landing: landing(sampled, rows)?,
            meshes: meshes.collect(),
        })
    }
}

fn failed(rows: &[SweepRow]) -> Vec<Failed> {
    let mut all: Vec<Failed> = Vec::new();
    for row in rows.iter().filter(|row| row.result.status != RowStatus::Completed) {
        let (status, cause) = (row.result.status.word(), row.result.note.as_str());
        match all.iter_mut().find(|failed| failed.status == status && failed.cause == cause) {
            Some(failed) => failed.runs.push(row.job.run),
            None => all.push(Failed { status: status.into(), cause: cause.into(), runs: vec![row.job.run] }),
        }
    }
    all
}

/// The distribution of a column; `None` of fewer than two numbers. In Saltelli's design only the points A and B are a
/// sample of the distributions.
fn distribution(
    sampled: &Sampled,
    rows: &[SweepRow],
    beside: &[SweepRow],
    quantity: &Quantity,
) -> Option<Distribution> {
    let sample: Vec<(f64, &SweepRow)> = column(quantity, rows)
        .into_iter()
        .filter(|(_, row)| !sampled.indices || row.job.run % sampled.group() < 2)
        .collect();
    let mut sorted: Vec<f64> = sample.iter().map(|(x, _)| *x).collect();
    if sorted.len() < 2 {
        return None;
    }
    let (mean, sd) = (mean(&sorted), deviation(&sorted));
    sorted.sort_by(f64::total_cmp);
    let extreme = |(value, row): &(f64, &SweepRow)| Extreme { value: *value, run: row.job.run };
    let by = |a: &&(f64, &SweepRow), b: &&(f64, &SweepRow)| a.0.total_cmp(&b.0).then(b.1.job.run.cmp(&a.1.job.run));
    let ended = |row: &SweepRow| quantity.of(row).filter(|_| row.result.status == RowStatus::Completed);
    Some(Distribution {
        name: quantity.name.clone(),
        unit: quantity.unit.clone(),
        runs: sorted.len(),
        mean,
        sd,
        quantiles: QUANTILES.map(|p| Quantile { p, estimate: quantile(&sorted, p) }).to_vec(),
        least: sample.iter().min_by(by).map(extreme)?,
        largest: sample.iter().max_by(by).map(extreme)?,
        beyond_largest: beyond_largest(sorted.len()),
        indices: indices(sampled, rows, quantity),
        errors: Errors::of(beside, ended, sd.value),
    })
}

fn indices(sampled: &Sampled, rows: &[SweepRow], quantity: &Quantity) -> Vec<Index> {
    let names = sampled.inputs.iter().map(super::input::Input::name);
    if sampled.indices {
        let ended = |row: &SweepRow| quantity.of(row).filter(|_| row.result.status == RowStatus::Completed);
        // A group counts if all of its runs have the number.
        let groups: Vec<Vec<f64>> =
            rows.chunks_exact(sampled.group()).filter_map(|group| group.iter().map(ended).collect()).collect();
        let found = saltelli(&groups);
        let index = |(i, input): (usize, String)| {
            let of = |kind: usize| found.get(i).map(|both: &[Estimate; 2]| both[kind]);
            Index { input, first: of(0), total: of(1) }
        };
        return names.enumerate().map(index).collect();
    }
    let found = column(quantity, rows);
    let y: Vec<f64> = found.iter().map(|(y, _)| *y).collect();
    let index = |(input, name): (&super::input::Input, String)| {
        let texts: Vec<Vec<String>> = found.iter().map(|(_, row)| texts(&input.keys, row)).collect();
        let numbers: Option<Vec<f64>> = match input.keys.as_slice() {
            [_] => texts.iter().map(|text| text.first()?.parse().ok()).collect(),
            _ => None,
        };
        let first = match numbers {
            Some(numbers) => given_data(&numbers, &y),
            // Words and rows of several keys have no order: they are classes, if each is there often enough.
            None => {
                let mut known: Vec<&Vec<String>> = texts.iter().collect();
                known.sort();
                known.dedup();
                let places: Vec<f64> = texts.iter().map(|text| known.partition_point(|k| *k < text) as f64).collect();
                given_data(&places, &y).filter(|_| known.len() * 5 <= texts.len())
            }
        };
        Index { input: name, first, total: None }
    };
    sampled.inputs.iter().zip(names).map(index).collect()
}

/// The values of some keys of a run.
fn texts(keys: &[String], row: &SweepRow) -> Vec<String> {
    keys.iter().map(|key| row.job.values.get(key).map(plain).unwrap_or_default()).collect()
}

/// Points in a plane, each of a run.
pub(super) struct Points<'r> {
    /// names of both columns
    pub names: [String; 2],
    /// both columns in words, with their units
    pub labels: [String; 2],
    /// a point for each run that has both numbers
    pub points: Vec<([f64; 2], &'r SweepRow)>,
}

/// The points whose ellipse is wanted: where runs landed, or two columns that are asked for.
pub(super) fn landing_points<'r>(sampled: &Sampled, rows: &'r [SweepRow]) -> Result<Option<Points<'r>>, StudyError> {
    let all = quantities(rows);
    let columns = match &sampled.ellipse {
        Some(names) => [named(&all, "--ellipse", &names[0])?, named(&all, "--ellipse", &names[1])?],
        None => match LANDING.map(|name| all.iter().find(|quantity| quantity.name == name)) {
            [Some(x), Some(y)] => [x, y],
            _ => return Ok(None),
        },
    };
    let sample = rows.iter().filter(|row| !sampled.indices || row.job.run % sampled.group() < 2);
    let completed = sample.filter(|row| row.result.status == RowStatus::Completed);
    let points = completed.filter_map(|row| Some(([columns[0].of(row)?, columns[1].of(row)?], row)));
    let of = |text: &dyn Fn(&Quantity) -> String| columns.map(text);
    Ok(Some(Points { names: of(&|q| q.name.clone()), labels: of(&|q| q.label()), points: points.collect() }))
}

fn landing(sampled: &Sampled, rows: &[SweepRow]) -> Result<Option<Landing>, StudyError> {
    let Some(Points { names, points, .. }) = landing_points(sampled, rows)? else { return Ok(None) };
    let points: Vec<[f64; 2]> = points.into_iter().map(|(point, _)| point).collect();
    Ok(Ellipse::of(&points).map(|ellipse| Landing { columns: names, ellipse }))
}

/// A table of the report, whose first row is its head.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(in crate::sweep) struct Table {
    title: String,
    rows: Vec<Vec<String>>,
    /// widths of the columns, for text
    widths: Vec<usize>,
    note: String,
}

impl Table {
    fn new(title: &str, rows: Vec<Vec<String>>, note: String) -> Self {
        let width = |i: usize| rows.iter().filter_map(|row| Some(row.get(i)?.chars().count())).max().unwrap_or(0);
        let widths = (0..rows.first().map_or(0, Vec::len)).map(width).collect();
        Table { title: title.to_owned(), rows, widths, note }
    }
}

fn number(x: f64) -> String {
    figures(x, DIGITS)
}

fn maybe(x: Option<f64>) -> String {
    x.map_or_else(|| "-".to_owned(), number)
}

/// A number with its interval in words.
fn told(estimate: Estimate) -> String {
    let Estimate { value, low, high } = estimate;
    let within = match (low, high) {
        (Some(low), Some(high)) => format!(" ({} to {})", number(low), number(high)),
        (Some(low), None) => format!(" (above {})", number(low)),
        (None, Some(high)) => format!(" (below {})", number(high)),
        (None, None) => String::new(),
    };
    number(value) + &within
}

/// A line of a table: a name and a cell for each quantity.
type TableLine<'a> = (&'a str, &'a dyn Fn(&Distribution) -> String);

impl Scatter {
    fn lines(&self, title: &str, lines: &[TableLine<'_>], note: String) -> Table {
        let unit = |q: &Distribution| if q.unit.is_empty() { String::new() } else { format!(" [{}]", q.unit) };
        let cells = |(name, cell): &TableLine<'_>| {
            [(*name).to_owned()].into_iter().chain(self.quantities.iter().map(cell)).collect::<Vec<String>>()
        };
        let head: TableLine<'_> = ("", &|q| q.name.clone() + &unit(q));
        Table::new(title, [&head].into_iter().chain(lines).map(cells).collect(), note)
    }

    /// What is printed and shown on the page.
    pub(in crate::sweep) fn tables(&self, sampled: &Sampled) -> Vec<Table> {
        let mut all = Vec::new();
        let Some(first) = self.quantities.first() else { return all };
        let at = |i: usize| move |q: &Distribution| q.quantiles.get(i).map(|q| told(q.estimate)).unwrap_or_default();
        let run = |extreme: Extreme| format!("{} (run {})", number(extreme.value), extreme.run);
        let beyond = number(100.0 * first.beyond_largest);
        let note = format!(
            "In brackets: intervals of 95 % for independent runs; Latin hypercubes and Sobol' points are mostly closer. Of \
             {} runs, at most {beyond} % of the distribution is beyond the largest, with 95 % probability.",
            first.runs
        );
        let lines: [TableLine<'_>; 10] = [
            ("runs", &|q| q.runs.to_string()),
            ("mean", &|q| told(q.mean)),
            ("standard deviation", &|q| told(q.sd)),
            ("smallest", &|q| run(q.least)),
            ("1st percentile", &at(0)),
            ("5th percentile", &at(1)),
            ("median", &at(2)),
            ("95th percentile", &at(3)),
            ("99th percentile", &at(4)),
            ("largest", &|q| run(q.largest)),
        ];
        all.push(self.lines("Distributions", &lines, note));
        if self.quantities.iter().any(|q| q.errors.median.is_some()) {
            let meshes = if self.meshes.is_empty() { "no finer mesh".to_owned() } else { self.meshes.join(", ") };
            let note = format!(
                "Step and mesh: errors of the run at the medians, from runs with other steps, and with {meshes}. -: not known."
            );
            let lines: [TableLine<'_>; 5] = [
                ("at the medians", &|q| maybe(q.errors.median)),
                ("scatter (standard deviation)", &|q| number(q.sd.value)),
                ("error by the step", &|q| maybe(q.errors.step)),
                ("error by the mesh", &|q| maybe(q.errors.mesh)),
                ("largest", &|q| q.errors.largest.unwrap_or("-").to_owned()),
            ];
            all.push(self.lines("Scatter, step and mesh", &lines, note));
        }
        all.push(self.index_table("What makes the scatter: first-order indices", |index| index.first, sampled));
        if sampled.indices {
            all.push(self.index_table("Total indices", |index| index.total, sampled));
        }
        all.extend(self.landing.as_ref().map(Landing::table));
        all
    }

    fn index_table(&self, title: &str, of: fn(&Index) -> Option<Estimate>, sampled: &Sampled) -> Table {
        let cell = |q: &Distribution, i: usize| q.indices.get(i).and_then(of).map_or_else(|| "-".to_owned(), told);
        let head = [String::new()].into_iter().chain(self.quantities.iter().map(|q| q.name.clone())).collect();
        let line = |(i, input): (usize, &super::input::Input)| {
            [input.name()].into_iter().chain(self.quantities.iter().map(move |q| cell(q, i))).collect::<Vec<String>>()
        };
        let rows: Vec<Vec<String>> = [head].into_iter().chain(sampled.inputs.iter().enumerate().map(line)).collect();
        let note = if sampled.indices {
            "By Saltelli's design and Jansen's estimators, with intervals of 95 % by resampling."
        } else {
            "Share of the variance that each makes alone, from the rows as they are, with intervals of 95 % by resampling. \
             -: too few rows."
        };
        Table::new(title, rows, note.to_owned())
    }
}

impl Landing {
    fn table(&self) -> Table {
        let Landing { columns, ellipse } = self;
        let line = |name: &str, value: String| vec![name.to_owned(), value];
        let rows = vec![
            line("", columns.join(", ")),
            line("mean", ellipse.centre.map(number).join(", ")),
            line("half axes of the 95 % ellipse", ellipse.half_axes.map(number).join(", ")),
            line("direction of the longer one, from the first column [deg]", number(ellipse.angle)),
            line("points within it [%]", number(100.0 * ellipse.within)),
            line("radius that holds half of the points", number(ellipse.half_radius)),
        ];
        Table::new(
            "Ellipse",
            rows,
            "The ellipse holds 95 % of a normal distribution with the same covariance.".to_owned(),
        )
    }
}

/// Runs of the same cause, for texts: their count, cause and first numbers.
impl Failed {
    pub(in crate::sweep) fn words(&self) -> String {
        const FIRST: usize = 6;
        let numbers: Vec<String> = self.runs.iter().take(FIRST).map(usize::to_string).collect();
        let more = if self.runs.len() > FIRST { ", …" } else { "" };
        let cause = if self.cause.is_empty() { String::new() } else { format!(": {}", self.cause) };
        format!("{} {} (run {}{more}){cause}", self.runs.len(), self.status, numbers.join(", "))
    }
}

impl Sampled {
    /// How the rows were chosen, in words.
    pub(in crate::sweep) fn words(&self) -> String {
        let design = if self.indices { "points of Saltelli's design" } else { "samples" };
        format!("{} {design} ({}, seed {})", self.samples, self.sampling.words(), self.seed)
    }
}

impl Until {
    /// In words.
    pub(in crate::sweep) fn words(&self) -> String {
        let percent = |x: f64| figures(100.0 * x, 3);
        let reached = self.reached.map_or_else(|| "no interval yet".to_owned(), |x| format!("± {} %", percent(x)));
        let met = if self.met { "is known within" } else { "is not yet known within" };
        format!("{} of {} {met} {} %: {reached}", self.statistic, self.column, percent(self.asked))
    }
}
