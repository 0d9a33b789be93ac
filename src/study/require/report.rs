//! What the study leaves for its reader: a table, a JSON file, one page, and what is printed.

use std::collections::BTreeMap;
use std::path::Path;

use minijinja::{Value, context};
use serde::Serialize;

use super::change::Words;
use super::combine::{Lean, distances, percent, time};
use super::compare::{Comparison, Errors, Number, Shown};
use super::figure::{figure, told as told_of_mark};
use super::plan::RequirePlan;
use super::run::{RequireResult, RequireRow};
use crate::case::Case;
use crate::error::StudyError;
use crate::format_number::figures;
use crate::plan::PROGRAM;
use crate::report::{Machine, Rerun};
use crate::store::{Store, remove, write_files};
use crate::template::{reasons, render};
use crate::verify::Accuracy;

/// All files a report has, beside the leanest case.
pub const FILES: [&str; 3] = ["require.csv", "require.json", "require.html"];

/// Most quantities that have a column each in a terminal.
const COLUMNS: usize = 3;

/// A study and how it is shown.
pub struct RequireReport<'a> {
    /// the plan
    pub plan: &'a RequirePlan,
    /// the full model
    pub base: &'a Case,
    /// all planned runs, in the plan's order: the full model first
    pub rows: &'a [RequireRow],
    /// the leanest case
    pub lean: Option<&'a Lean>,
    /// the accuracy
    pub accuracy: &'a Accuracy,
    /// how it was made
    pub how: &'a Rerun,
}

/// The tables in a terminal: a column a quantity, or, where there are many, the largest difference only.
#[derive(Clone, Debug, Default, Serialize)]
struct Printed {
    /// names of the columns of differences
    names: Vec<String>,
    /// widths of all columns
    widths: Vec<usize>,
    /// rows of changes within the accuracy, and of others
    parts: [Vec<Line>; 2],
    /// the errors side by side
    errors: Vec<ErrorLine>,
}

impl Printed {
    fn of(names: &[&str], parts: &[&[Line]; 2], errors: &[ErrorLine]) -> Self {
        let few = names.len() <= COLUMNS;
        let short = |shares: &[Share]| -> Vec<String> {
            let largest = shares.iter().zip(names).max_by(|a, b| a.0.size.total_cmp(&b.0.size));
            match largest.filter(|_| !few) {
                Some((share, name)) if share.size >= 0.0 => vec![share.words.clone(), (*name).to_owned()],
                Some((share, _)) => vec![share.words.clone(), String::new()],
                None => shares.iter().map(|share| share.words.clone()).collect(),
            }
        };
        let names: Vec<String> = match few {
            true => names.iter().map(|name| (*name).to_owned()).collect(),
            false => ["largest", "in"].map(str::to_owned).to_vec(),
        };
        let parts = parts.map(|lines| {
            let line = |line: &Line| Line { printed: short(&line.shares), ..line.clone() };
            lines.iter().map(line).collect::<Vec<_>>()
        });
        let error = |line: &ErrorLine| ErrorLine { printed: short(&line.shares), ..line.clone() };
        let errors: Vec<ErrorLine> = errors.iter().map(error).collect();
        let lines = parts.iter().flatten().map(|line| (line.described.as_str(), &line.printed));
        let rows: Vec<(&str, &Vec<String>)> =
            lines.chain(errors.iter().map(|line| (line.of, &line.printed))).chain([("", &names)]).collect();
        let width = |of: &dyn Fn(&(&str, &Vec<String>)) -> usize| rows.iter().map(of).max().unwrap_or(0);
        let first = width(&|(described, _)| described.chars().count());
        let column = |i: usize| width(&|(_, cells)| cells.get(i).map_or(0, |cell| cell.chars().count()));
        let widths = [first].into_iter().chain((0..names.len()).map(column)).collect();
        Printed { names, widths, parts, errors }
    }
}

/// A difference in words.
#[derive(Clone, Debug, Default, Serialize)]
struct Share {
    /// in words
    words: String,
    /// [-] its size; below 0 for none
    size: f64,
}

impl Share {
    fn of(share: Option<f64>, words: impl Fn(f64) -> String, none: &str) -> Self {
        Share { words: share.map_or_else(|| none.to_owned(), words), size: share.map_or(-1.0, f64::abs) }
    }
}

/// A row of a printed table.
#[derive(Clone, Debug, Default, Serialize)]
struct Line {
    /// what is changed
    described: String,
    /// the difference of each quantity
    shares: Vec<Share>,
    /// what is saved
    time: String,
    /// the differences in a terminal
    printed: Vec<String>,
}

/// An error beside the others.
#[derive(Clone, Debug, Default, Serialize)]
struct ErrorLine {
    /// of what
    of: &'static str,
    /// in each quantity
    shares: Vec<Share>,
    /// what shows it
    by: String,
    /// the errors in a terminal
    printed: Vec<String>,
}

impl RequireReport<'_> {
    /// Writes the files into a folder; returns what the command prints.
    ///
    /// # Errors
    /// An accuracy in another unit than a quantity's, a page that cannot be made, or the system's answer.
    pub fn write(&self, out: &Path) -> Result<String, StudyError> {
        let full = self.rows.first().map(|row| row.result.clone()).unwrap_or_default();
        let mut all = Vec::with_capacity(self.rows.len());
        for row in self.rows.iter().skip(1) {
            all.push(Comparison::of(row, &full, self.accuracy)?);
        }
        let problem = self.base.problem();
        let errors = Errors::of(&full, &all, &problem.method, problem.time.step);
        // What saves most stands first, and what has no result last.
        all.sort_by(|a, b| {
            let key = |one: &Comparison| one.saved.filter(|_| one.harmless.is_some()).unwrap_or(f64::NEG_INFINITY);
            key(b).total_cmp(&key(a))
        });
        let shown = self.shown(&full, &all, &errors)?;
        let made = [
            ("require.csv", self.csv(&full, &all)?),
            ("require.json", self.json(&all, &errors)?),
            ("require.html", render("require.html", include_str!("../templates/require.html"), &shown)?),
        ];
        let files = write_files(out, &FILES, &made)?;
        text(context! { stage => "done", files, ..shown })
    }

    /// What page and terminal show.
    fn shown(&self, full: &RequireResult, all: &[Comparison], errors: &Errors) -> Result<Value, StudyError> {
        let &RequireReport { plan, lean, accuracy, how: Rerun { command, machine }, .. } = self;
        let part = |harmless: bool| {
            let lines = all.iter().filter(|one| one.harmless == Some(harmless)).map(Line::of);
            lines.collect::<Vec<_>>()
        };
        let (harmless, harmful) = (part(true), part(false));
        let without: Vec<&Comparison> = all.iter().filter(|one| one.harmless.is_none()).collect();
        let names: Vec<&str> = full.numbers.iter().map(|number| number.name.as_str()).collect();
        let values: Vec<String> = full.numbers.iter().map(value_of).collect();
        let error_lines = ErrorLine::all(errors, &names);
        let brief: Vec<[&str; 3]> = without
            .iter()
            .map(|one| {
                let note = one.note.split("; ").next().unwrap_or_default();
                [one.described.as_str(), one.status.word(), note]
            })
            .collect();
        let notes = reasons(without.iter().map(|one| (one.described.clone(), one.status, one.note.as_str())));
        let figure = figure(plan, all, lean)?;
        let printed = Printed::of(&names, &[&harmless, &harmful], &error_lines);
        let marks = all.iter().chain(lean.map(|lean| &lean.distance));
        let told: BTreeMap<&str, Vec<[String; 2]>> = marks.map(|one| (one.id.as_str(), told_of_mark(one))).collect();
        let case_json = serde_json::to_string_pretty(&plan.case).map_err(|e| StudyError::Page(e.to_string()))?;
        let lean = lean.map(|lean| {
            let elsewhere = lean.elsewhere.as_ref().map(|there| {
                let within = there.distance.harmless;
                context! { state => there.described, distances => distances(&there.distance), within,
                time => time(&there.distance), note => there.distance.note }
            });
            let tried: Vec<Value> = lean
                .tried
                .iter()
                .map(|one| context! { added => one.added, kept => one.kept, line => Line::of(&one.distance) })
                .collect();
            context! { changes => lean.changes, distances => distances(&lean.distance), time => time(&lean.distance),
            seconds => lean.distance.cpu_seconds, file => lean.file, differs => lean.file_differs,
            left => lean.left, elsewhere, tried }
        });
        let completed = full.completed();
        Ok(
            context! { version => PROGRAM, plan, accuracy => accuracy.to_string(), full, completed, values, names, printed,
            harmless, harmful, brief, notes, errors => error_lines, lean, figure, told, command, machine, case_json },
        )
    }

    /// `require.csv`: the full model, its variants, and the leanest case.
    fn csv(&self, full: &RequireResult, all: &[Comparison]) -> Result<String, StudyError> {
        let names = || full.numbers.iter().map(|number| number.name.clone());
        let fixed = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
        let head: Vec<String> = fixed(&["change", "from", "to", "cpu_seconds"])
            .into_iter()
            .chain(names())
            .chain(names().map(|name| format!("error_{name}")))
            .chain(fixed(&["saved", "within", "status", "note"]))
            .collect();
        let number = |x: Option<f64>| x.map(|x| format!("{x:?}")).unwrap_or_default();
        let row = |change: [String; 3], one: &Comparison| -> Vec<String> {
            let values = one.differences.iter().map(|of| number(of.value));
            let errors = one.differences.iter().map(|of| number(of.difference));
            let within = one.harmless.map(|within| within.to_string()).unwrap_or_default();
            let end = [number(one.saved), within, one.status.word().to_owned(), one.note.clone()];
            change.into_iter().chain([number(one.cpu_seconds)]).chain(values).chain(errors).chain(end).collect()
        };
        let mut table = vec![head];
        let plain = |text: &str| [text.to_owned(), String::new(), String::new()];
        if let Some(first) = self.rows.first() {
            table.push(row(plain("full model"), &Comparison::of(first, full, self.accuracy)?));
        }
        for one in all {
            let job = self.plan.jobs.iter().find(|job| job.id == one.id);
            let Words { change, from, to, unit } =
                job.and_then(|job| job.variants.first()).map(|of| of.change.words()).unwrap_or_default();
            let change = if unit.is_empty() { change } else { format!("{change} [{unit}]") };
            table.push(row([change, from, to], one));
        }
        if let Some(lean) = self.lean {
            table.push(row(plain(&format!("lean case: {}", lean.changes.join("; "))), &lean.distance));
        }
        render("require.csv", include_str!("../templates/require.csv"), &context! { table })
    }

    /// `require.json`: all that is known.
    fn json(&self, all: &[Comparison], errors: &Errors) -> Result<String, StudyError> {
        #[derive(Serialize)]
        struct Json<'a> {
            version: &'a str,
            command: &'a str,
            within: String,
            plan: &'a RequirePlan,
            rows: &'a [RequireRow],
            changes: &'a [Comparison],
            errors: &'a Errors,
            lean: Option<&'a Lean>,
            machine: &'a Machine,
        }
        let &RequireReport { plan, rows, lean, accuracy, how: Rerun { command, machine }, .. } = self;
        let within = accuracy.to_string();
        let json = Json { version: PROGRAM, command, within, plan, rows, changes: all, errors, lean, machine };
        let text = serde_json::to_string_pretty(&json);
        Ok(text.map_err(|e| StudyError::Page(format!("require.json: {e}")))? + "\n")
    }
}

impl Line {
    fn of(one: &Comparison) -> Self {
        Line {
            described: one.described.clone(),
            shares: one.differences.iter().map(|of| Share::of(of.share, percent, "no value")).collect(),
            time: time(one),
            printed: Vec::new(),
        }
    }
}

impl ErrorLine {
    /// The errors of step, mesh and model.
    fn all(errors: &Errors, names: &[&str]) -> Vec<ErrorLine> {
        let Errors { step, mesh, harmless, harmful } = errors;
        let plus_minus = |share: f64| format!("± {} %", figures(100.0 * share.abs(), 2));
        let parts: [(&'static str, &[Shown], &dyn Fn(f64) -> String); 4] = [
            ("step", step, &plus_minus),
            ("mesh", mesh, &plus_minus),
            ("model, may be left out", harmless, &percent),
            ("model, may not", harmful, &percent),
        ];
        let line = |(of, shown, words): (&'static str, &[Shown], &dyn Fn(f64) -> String)| {
            let share = |name: &&str| shown.iter().find(|one| one.name == **name).map(|one| one.share);
            let mut by: Vec<&str> = shown.iter().map(|one| one.by.as_str()).collect();
            by.sort_unstable();
            by.dedup();
            ErrorLine {
                of,
                shares: names.iter().map(|name| Share::of(share(name), words, "-")).collect(),
                by: if by.is_empty() { "no run shows it".to_owned() } else { by.join("; ") },
                printed: Vec::new(),
            }
        };
        parts.into_iter().map(line).collect()
    }
}

/// `opening_load = 4939 N`.
fn value_of(number: &Number) -> String {
    let value = number.value.map_or_else(|| "none".to_owned(), |value| figures(value, 4));
    let unit = if number.unit == "-" { String::new() } else { format!(" {}", number.unit) };
    format!("{} = {value}{unit}", number.name)
}

/// What the command prints of a plan.
///
/// # Errors
/// What the template engine refuses.
pub fn planned(plan: &RequirePlan, store: &Store<RequirePlan>) -> Result<String, StudyError> {
    let path = store.plan_path();
    let out = path.parent().and_then(Path::parent).unwrap_or(Path::new("")).to_owned();
    text(context! { stage => "planned", plan, path, out })
}

fn text(context: Value) -> Result<String, StudyError> {
    render("require.txt", include_str!("../templates/require.txt"), &context)
}

/// Removes the report of an earlier study.
///
/// # Errors
/// The system's answer.
pub fn clear(out: &Path) -> Result<(), StudyError> {
    FILES.iter().try_for_each(|file| remove(&out.join(file)))
}
