//! What the study leaves for its reader: a table, a JSON file, one page, and what is printed.

use std::collections::BTreeMap;
use std::path::Path;

use minijinja::{Value, context};
use serde::Serialize;

use super::change::{Change, Variant, Words};
use super::combine::{Lean, cost, distances, percent, work};
use super::compare::{Comparison, Difference, Errors, Number, Shown};
use super::figure::{figure, told as told_of_mark};
use super::lines::{ErrorLine, Line, Printed};
use super::plan::{RequireJob, RequirePlan};
use super::run::{RequireResult, RequireRow};
use crate::accuracy::{Accuracy, measure_of};
use crate::case::Case;
use crate::error::StudyError;
use crate::format_number::figures;
use crate::plan::PROGRAM;
use crate::report::{Machine, Rerun};
use crate::store::{Store, remove, write_files};
use crate::template::{reasons, render};

/// All files a report has, beside the leanest case.
pub const FILES: [&str; 3] = ["require.csv", "require.json", "require.html"];

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
        let doubts = self.doubts(full, errors)?;
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
                cost => cost(&there.distance), note => there.distance.note }
            });
            let tried: Vec<Value> = lean
                .tried
                .iter()
                .map(|one| context! { added => one.added, kept => one.kept, line => Line::of(&one.distance) })
                .collect();
            context! { changes => lean.changes, distances => distances(&lean.distance), work => work(&lean.distance),
            seconds => lean.distance.cpu_seconds, file => lean.file, differs => lean.file_differs,
            left => lean.left, elsewhere, tried }
        });
        let completed = full.completed();
        let point = self.point(all);
        Ok(
            context! { version => PROGRAM, plan, accuracy => accuracy.to_string(), full, completed, values, names, printed, doubts,
            harmless, harmful, point, brief, notes, errors => error_lines, lean, figure, told, command, machine, case_json },
        )
    }

    /// What the whole parachute as one mass is enough for, where it is for something.
    fn point(&self, all: &[Comparison]) -> Option<Value> {
        let is_point = |job: &&RequireJob| matches!(&job.variants[..], [Variant { change: Change::Point, .. }]);
        let job = self.plan.jobs.iter().find(is_point)?;
        let one = all.iter().find(|one| one.id == job.id && one.harmless.is_some())?;
        let parts = |of: &dyn Fn(&Difference) -> bool| -> Vec<String> {
            let words = |of: &Difference| match of.share {
                Some(share) => format!("{} {}", of.name, percent(share)),
                None => of.name.clone(),
            };
            one.differences.iter().filter(|difference| of(difference)).map(words).collect()
        };
        let enough = parts(&|of| of.within);
        let (beyond, without) = (parts(&|of| !of.within && of.value.is_some()), parts(&|of| of.value.is_none()));
        (!enough.is_empty()).then(|| context! { enough, beyond, without, cost => cost(one) })
    }

    /// Where the full model itself is not within the accuracy.
    fn doubts(&self, full: &RequireResult, errors: &Errors) -> Result<Vec<String>, StudyError> {
        let mut all = Vec::new();
        for (of, shown) in [("step", &errors.step), ("mesh", &errors.mesh)] {
            let mut beyond = Vec::new();
            for Shown { name, share, .. } in shown {
                let Some(number) = full.number(name) else { continue };
                let scale = number.value.map_or(1.0, |value| measure_of(value, number.largest));
                if share.abs() * scale > self.accuracy.allowed(name, &number.unit, scale)? {
                    beyond.push(format!("{name} ± {} %", figures(100.0 * share.abs(), 2)));
                }
            }
            if !beyond.is_empty() {
                all.push(format!("by its {of}, {}", beyond.join(", ")));
            }
        }
        Ok(all)
    }

    /// `require.csv`: the full model, its variants, and the leanest case.
    fn csv(&self, full: &RequireResult, all: &[Comparison]) -> Result<String, StudyError> {
        let names = || full.numbers.iter().map(|number| number.name.clone());
        let fixed = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
        let head: Vec<String> = fixed(&["change", "from", "to", "cpu_seconds"])
            .into_iter()
            .chain(names())
            .chain(names().map(|name| format!("error_{name}")))
            .chain(fixed(&["work", "saved", "within", "status", "note"]))
            .collect();
        let number = |x: Option<f64>| x.map(|x| format!("{x:?}")).unwrap_or_default();
        let row = |change: [String; 3], one: &Comparison| -> Vec<String> {
            let values = one.differences.iter().map(|of| number(of.value));
            let errors = one.differences.iter().map(|of| number(of.difference));
            let within = one.harmless.map(|within| within.to_string()).unwrap_or_default();
            let end = [number(one.work), number(one.saved), within, one.status.word().to_owned(), one.note.clone()];
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
