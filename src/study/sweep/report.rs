//! What a sweep leaves for its reader: a table, a JSON file, a figure, one page with all of it, and what is printed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use minijinja::{Value, context};
use serde::Serialize;

use super::figure::{across, charts, chosen, named};
use super::plan::{SweepPlan, plain};
use super::run::SweepRow;
use super::sample::Sampled;
use super::sample::figure::{Figure, figures};
use super::sample::scatter::{Failed, Scatter, Until, counted};
use super::table::{Quantity, cells, header, quantities};
use crate::error::StudyError;
use crate::plan::PROGRAM;
use crate::planned_runs::CaseJob;
use crate::plot::chart::{Chart, Size};
use crate::plot::layout::{legend_samples, svg_grid};
use crate::report::{Machine, Rerun};
use crate::row::RowStatus;
use crate::store::{Store, remove, write_files};
use crate::template::{PageFigure, reasons, render, told};

/// All files a report has.
pub const FILES: [&str; 4] = ["sweep.csv", "sweep.json", "sweep.svg", "sweep.html"];
/// Rows that are printed.
const PRINTED: usize = 40;
/// [px] Charts of the page, on wide and on narrow screens.
const PAGE: [Size; 2] = [Size { width: 900, height: 480 }, Size { width: 460, height: 420 }];

/// Columns of a landing, which are told of every sample.
const LANDING: &str = "landing.";

/// A sample as it is shown.
struct Sample<'a> {
    sampled: &'a Sampled,
    scatter: Scatter,
    figures: Vec<Figure>,
    /// the runs beside it
    beside: &'a [SweepRow],
}

/// What the page is made from.
struct Page<'a> {
    /// columns that are drawn
    shown: &'a [&'a Quantity],
    all: &'a [Quantity],
    /// names of the columns of the table
    head: &'a [String],
    table: &'a [Vec<String>],
    sample: Option<&'a Sample<'a>>,
}

/// A sweep and how it is shown.
#[derive(Clone, Copy)]
pub struct SweepReport<'a> {
    /// the plan
    pub plan: &'a SweepPlan,
    /// all runs, in its order
    pub rows: &'a [SweepRow],
    /// columns that are drawn; empty: the first peaks
    pub plot: &'a [String],
    /// how it was made
    pub how: &'a Rerun,
}

impl SweepReport<'_> {
    /// Writes the files into a folder; returns what the command prints.
    ///
    /// # Errors
    /// A column that is not there, a picture or a page that cannot be made, or the system's answer.
    pub fn write(&self, out: &Path) -> Result<String, StudyError> {
        let (rows, beside) = self.rows.split_at(self.plan.rows().min(self.rows.len()));
        match &self.plan.sampled {
            Some(sampled) => {
                let rows = rows.get(..counted(sampled, rows)?).unwrap_or(rows);
                SweepReport { rows, ..*self }.write_rows(out, beside)
            }
            None => SweepReport { rows, ..*self }.write_rows(out, beside),
        }
    }

    /// The same of the rows that count.
    fn write_rows(&self, out: &Path, beside: &[SweepRow]) -> Result<String, StudyError> {
        let &SweepReport { plan, rows, .. } = self;
        let all = quantities(rows);
        let mut shown = chosen(&all, (plan, rows), self.plot)?;
        let mut sample = None;
        if let Some(sampled) = &plan.sampled {
            if self.plot.is_empty() {
                let landing = all.iter().filter(|column| column.name.starts_with(LANDING));
                let more: Vec<&Quantity> =
                    landing.filter(|column| shown.iter().all(|other| other.name != column.name)).collect();
                shown.extend(more);
            }
            let scatter = Scatter::of(sampled, rows, beside, &shown)?;
            let figures = figures(plan, sampled, rows, &shown, &scatter)?;
            sample = Some(Sample { sampled, scatter, figures, beside });
        }
        let table: Vec<Vec<String>> = rows.iter().map(|row| cells(plan, &all, row)).collect();
        let head = header(plan, &all);
        let csv = context! { head, rows => table };
        let size = Size { width: if shown.len() > 1 { 640 } else { 900 }, height: 440 };
        let drawn: Vec<Chart> = match &sample {
            Some(sample) if !sample.figures.is_empty() => {
                sample.figures.iter().map(|figure| Chart { size, ..figure.chart.clone() }).collect()
            }
            _ => charts(plan, rows, &shown, size),
        };
        let page = Page { shown: &shown, all: &all, head: &head, table: &table, sample: sample.as_ref() };
        let made = [
            ("sweep.csv", render("sweep.csv", include_str!("../templates/sweep.csv"), &csv)?),
            ("sweep.json", self.json(&all, sample.as_ref())?),
            ("sweep.svg", svg_grid(&drawn, 2)?),
            ("sweep.html", self.html(&page)?),
        ];
        let files = write_files(out, &FILES, &made)?;
        match &sample {
            Some(sample) => self.text_of(sample, &files),
            None => self.text(&shown, &files),
        }
    }

    /// What the command prints of a sample.
    fn text_of(&self, sample: &Sample<'_>, files: &[PathBuf]) -> Result<String, StudyError> {
        let scatter = &sample.scatter;
        text(context! {
            stage => "sample", plan => self.plan, files, words => sample.sampled.words(),
            runs_of_sample => scatter.runs,
            completed => scatter.completed, tables => scatter.tables(sample.sampled),
            until => scatter.until.as_ref().map(Until::words),
            failed => scatter.failed.iter().take(PRINTED).map(Failed::words).collect::<Vec<_>>(),
        })
    }

    /// `sweep.json`: all that is known of a sweep.
    fn json(&self, all: &[Quantity], sample: Option<&Sample<'_>>) -> Result<String, StudyError> {
        #[derive(Serialize)]
        struct Json<'a> {
            version: &'a str,
            command: &'a str,
            plan: &'a SweepPlan,
            units: BTreeMap<&'a str, &'a str>,
            rows: &'a [SweepRow],
            #[serde(skip_serializing_if = "Option::is_none")]
            scatter: Option<&'a Scatter>,
            #[serde(skip_serializing_if = "Option::is_none")]
            beside: Option<&'a [SweepRow]>,
            machine: &'a Machine,
        }
        let &SweepReport { plan, rows, how: Rerun { command, machine }, .. } = self;
        let units = all.iter().filter(|q| !q.unit.is_empty()).map(|q| (q.name.as_str(), q.unit.as_str())).collect();
        let (scatter, beside) = (sample.map(|sample| &sample.scatter), sample.map(|sample| sample.beside));
        let json = Json { version: PROGRAM, command, plan, units, rows, scatter, beside, machine };
        let text = serde_json::to_string_pretty(&json);
        Ok(text.map_err(|e| StudyError::Page(format!("sweep.json: {e}")))? + "\n")
    }

    /// `sweep.html`: one page that needs nothing beside it.
    fn html(&self, page: &Page<'_>) -> Result<String, StudyError> {
        let &Page { shown, all, head, table, sample } = page;
        let &SweepReport { plan, rows, how: Rerun { command, machine }, .. } = self;
        let mut figures = Vec::new();
        for Figure { chart, caption } in sample.iter().flat_map(|sample| &sample.figures) {
            figures.push(PageFigure::of(chart, caption.as_str(), PAGE)?);
        }
        for quantity in shown.iter().filter(|_| sample.is_none()) {
            for chart in charts(plan, rows, &[quantity], Size::default()) {
                let caption = format!("{} over {}.", quantity.words(), across(plan).map_or("", |vary| &vary.key));
                figures.push(PageFigure::of(&chart, caption, PAGE)?);
            }
        }
        let first = charts(plan, rows, shown.get(..1).unwrap_or_default(), Size::default());
        let legend =
            first.first().filter(|_| sample.is_none()).map(|chart| legend_samples(&chart.lines)).unwrap_or_default();
        let case_json = serde_json::to_string_pretty(&plan.case).map_err(|e| StudyError::Page(e.to_string()))?;
        let told = self.told(all, shown);
        let notes = reasons(rows.iter().map(|row| (named(plan, row, ""), row.result.status, row.result.note.as_str())));
        let label = |name: &String| all.iter().find(|q| q.name == *name).map_or_else(|| name.clone(), Quantity::label);
        let head: Vec<String> = head.iter().map(label).collect();
        let scatter = sample.map(|sample| {
            context! {
                words => sample.sampled.words(), tables => sample.scatter.tables(sample.sampled),
                until => sample.scatter.until.as_ref().map(Until::words), completed => sample.scatter.completed,
                failed => sample.scatter.failed.iter().map(Failed::words).collect::<Vec<_>>(),
                inputs => sample.sampled.inputs.iter().map(|f| [f.name(), f.law.words()]).collect::<Vec<_>>(),
            }
        });
        let failures = self.failures();
        let failed: Vec<bool> = rows.iter().map(|row| row.result.status != RowStatus::Completed).collect();
        let page = context! {
            version => PROGRAM, command, machine, plan, case_json, told, figures, legend, head, table, failures,
            failed, notes, scatter,
        };
        render("sweep.html", include_str!("../templates/sweep.html"), &page)
    }

    /// What a mark of a run shows, by the run's identifier.
    fn told(&self, all: &[Quantity], shown: &[&Quantity]) -> BTreeMap<&str, Vec<[String; 2]>> {
        let of = |row: &SweepRow| {
            let values = row.job.values.iter().map(|(key, value)| [key.clone(), plain(value)]);
            let status = ["status".to_owned(), row.result.status.word().to_owned()];
            let numbers = shown.iter().map(|quantity| [quantity.label(), told(quantity.of(row))]);
            let always = ["energy_error", "cpu_seconds"].map(|name| all.iter().find(|quantity| quantity.name == name));
            let always = always.into_iter().flatten().filter(|one| shown.iter().all(|other| other.name != one.name));
            let more = always.map(|quantity| [quantity.label(), told(quantity.of(row))]);
            let note = ["note".to_owned(), row.result.note.clone()];
            let every = values.chain([status]).chain(numbers).chain(more).chain([note]);
            every.filter(|[_, text]| !text.is_empty()).collect()
        };
        self.rows.iter().map(|row| (row.job.id.as_str(), of(row))).collect()
    }

    /// How many runs have no result, and why.
    fn failures(&self) -> String {
        let count = |status: RowStatus| self.rows.iter().filter(|row| row.result.status == status).count();
        let kinds = [RowStatus::Diverged, RowStatus::NotConverged, RowStatus::Refused, RowStatus::NotRun];
        let words = kinds.into_iter().map(|s| (count(s), s)).filter(|(n, _)| *n > 0);
        words.map(|(n, s)| format!("{n} {}", s.word())).collect::<Vec<_>>().join(", ")
    }

    fn text(&self, shown: &[&Quantity], files: &[PathBuf]) -> Result<String, StudyError> {
        let &SweepReport { plan, rows, .. } = self;
        let columns = |row: &SweepRow| -> Vec<String> {
            let values = plan.vary.iter().map(|vary| row.job.values.get(&vary.key).map(plain).unwrap_or_default());
            let status = [row.result.status.word().to_owned()];
            values.chain(status).chain(shown.iter().map(|quantity| told(quantity.of(row)))).collect()
        };
        let keys = plan.vary.iter().map(|vary| vary.key.clone());
        let head: Vec<String> =
            keys.chain(["status".to_owned()]).chain(shown.iter().map(|quantity| quantity.label())).collect();
        let mut table = vec![head];
        table.extend(rows.iter().take(PRINTED).map(columns));
        let width = |column: usize| table.iter().filter_map(|row| Some(row.get(column)?.chars().count())).max();
        let widths: Vec<usize> = (0..table.first().map_or(0, Vec::len)).filter_map(width).collect();
        let notes: Vec<Value> = rows
            .iter()
            .filter(|row| row.result.status != RowStatus::Completed && !row.result.note.is_empty())
            .take(PRINTED)
            .map(|row| context! { run => row.job.described(), note => row.result.note })
            .collect();
        let more = rows.len().saturating_sub(PRINTED);
        let failures = self.failures();
        text(context! { stage => "done", plan, table, widths, notes, more, failures, files })
    }
}

/// What the command prints of a plan.
///
/// # Errors
/// What the template engine refuses.
pub fn planned(plan: &SweepPlan, store: &Store<SweepPlan>) -> Result<String, StudyError> {
    let path = store.plan_path();
    let out = path.parent().and_then(Path::parent).unwrap_or(Path::new("")).to_owned();
    text(context! { stage => "planned", plan, path, out })
}

fn text(context: Value) -> Result<String, StudyError> {
    render("sweep.txt", include_str!("../templates/sweep.txt"), &context)
}

/// Removes the report of an earlier sweep.
///
/// # Errors
/// The system's answer.
pub fn clear(out: &Path) -> Result<(), StudyError> {
    FILES.iter().try_for_each(|file| remove(&out.join(file)))
}
