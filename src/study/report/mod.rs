//! What a study leaves for its reader: tables, figures, one page with all of it, and what the command prints.
//!
//! Everything is made from the study and its answers alone; only the page's and the JSON file's account of the machine
//! differs from one machine and day to the next. Words and layout are those of the templates in `src/study/templates`.

mod convergence;
mod figure;
mod machine;
mod parts;
mod stiffness;
pub(super) mod style;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use minijinja::{Value, context};
use serde::Serialize;

pub use crate::method_look::method_color;
pub use machine::{Machine, Rerun};

use super::error::StudyError;
use super::plan::{PROGRAM, Plan};
use super::ranking::{Ranking, ReferenceQuantity};
use super::recommendations::{Recommendations, unfinished};
use super::row::{Row, RunResult, StepSetting};
use super::runner::Study;
use super::store::{Store, remove, write_files};
use super::template::{reasons, render, told};
use crate::format_number::figures;

/// All files a report may have; those that a study has nothing for are removed, so that none is left of an earlier one.
pub const FILES: [&str; 8] = [
    "tradeoff.csv",
    "tradeoff.json",
    "tradeoff.svg",
    "work.svg",
    "convergence.svg",
    "stiffness.csv",
    "stiffness.svg",
    "tradeoff.html",
];

/// Writes the report of a study into a folder; returns the files.
///
/// # Errors
/// A picture or a page that cannot be made, or the system's answer.
pub fn write(out: &Path, study: &Study, answers: &Recommendations, how: &Rerun) -> Result<Vec<PathBuf>, StudyError> {
    let Study { plan, rows } = study;
    let figures = figure::all(study, answers)?;
    let table = include_str!("../templates/tradeoff.csv");
    let mut made: Vec<(&str, String)> = vec![
        ("tradeoff.csv", render("tradeoff.csv", table, &context! { plan, rows, quantities => names(plan) })?),
        ("tradeoff.json", json(study, answers, how)?),
        ("tradeoff.html", html(study, answers, how, &figures)?),
    ];
    if plan.variants.len() > 1 {
        let table = include_str!("../templates/stiffness.csv");
        made.push(("stiffness.csv", render("stiffness.csv", table, &context! { answers })?));
    }
    made.extend(figures.into_iter().map(|figure| (figure.file, figure.svg)));
    write_files(out, &FILES, &made)
}

/// The names of the quantities of a study.
fn names(plan: &Plan) -> Vec<&str> {
    plan.quantities().iter().map(|quantity| quantity.name.as_str()).collect()
}

/// What the reference of each variant knows of quantities, with how it knows it.
fn known(plan: &Plan) -> Vec<Vec<Value>> {
    let of = |quantity: &ReferenceQuantity| {
        context! { how => quantity.error_by.words(), ..Value::from_serialize(quantity) }
    };
    plan.variants.iter().map(|variant| variant.reference.quantities.iter().map(of).collect()).collect()
}

/// What the runs of each variant are ranked by.
fn rankings(plan: &Plan) -> Vec<Value> {
    let of = |number| {
        let ranking = Ranking::of(plan, number);
        let unknown: Vec<&str> = ranking.unknown().iter().map(|quantity| quantity.name.as_str()).collect();
        context! { bound => ranking.bound(), names => ranking.names(), unknown }
    };
    (0..plan.variants.len()).map(of).collect()
}

/// `tradeoff.json`: all that is known of a study.
fn json(study: &Study, answers: &Recommendations, how: &Rerun) -> Result<String, StudyError> {
    #[derive(Serialize)]
    struct Json<'a> {
        version: &'a str,
        command: &'a str,
        plan: &'a Plan,
        rows: &'a [Row],
        answers: &'a Recommendations,
        machine: &'a Machine,
    }
    let (Study { plan, rows }, Rerun { command, machine }) = (study, how);
    let text = serde_json::to_string_pretty(&Json { version: PROGRAM, command, plan, rows, answers, machine });
    Ok(text.map_err(|e| StudyError::Page(format!("tradeoff.json: {e}")))? + "\n")
}

/// `tradeoff.html`: one page that needs nothing beside it.
fn html(study: &Study, answers: &Recommendations, how: &Rerun, drawn: &[figure::Figure]) -> Result<String, StudyError> {
    let (Study { plan, rows }, Rerun { command, machine }) = (study, how);
    let case_json = serde_json::to_string_pretty(&plan.case).map_err(|e| StudyError::Page(e.to_string()))?;
    let named = |row: &Row| match row.job.setting {
        StepSetting::Step(h) => format!("{} {} s", row.label(), figures(h, 4)),
        StepSetting::Tolerance(tolerance) => format!("{} tolerance {tolerance:e}", row.label()),
    };
    let failures = unfinished(rows);
    let (told, legend) = (told_of(study), figure::page_legend(study));
    let (version, rows) = (PROGRAM, sorted(rows));
    let notes = reasons(rows.iter().map(|row| (named(row), row.measured.status, row.measured.note.as_str())));
    let page = context! {
        version, command, machine, plan, case_json, failures, notes, rows, answers, figures => drawn, told, legend,
        quantities => names(plan), known => known(plan), rankings => rankings(plan),
    };
    render("tradeoff.html", include_str!("../templates/tradeoff.html"), &page)
}

/// What the mark of a run tells, by the run's identifier.
fn told_of(study: &Study) -> BTreeMap<&str, Vec<[String; 2]>> {
    let of = |row: &Row| {
        let count = |n: u64| if n > 0 { n.to_string() } else { String::new() };
        let (setting, size) = match row.job.setting {
            StepSetting::Step(h) => ("step [s]", h),
            StepSetting::Tolerance(tolerance) => ("tolerance [-]", tolerance),
        };
        let RunResult { status, error, error_max, quantities, energy_error, counters, note, .. } = &row.measured;
        let factor = study.plan.variant_of(&row.job).map(|v| v.stiffness_factor);
        let mut all = vec![
            ("method", row.label()),
            ("stiffness [-]", told(factor.filter(|_| study.plan.variants.len() > 1))),
            (setting, told(Some(size))),
            ("status", status.word().replace('-', " ")),
            ("error [-]", told(*error)),
            ("largest error [-]", told(*error_max)),
            ("energy error [-]", told(*energy_error)),
            ("CPU [s]", told(row.cpu_seconds)),
            ("force evaluations", count(counters.force_evaluations)),
            ("factorisations", count(counters.factorizations)),
            ("note", note.clone()),
        ];
        all.retain(|(_, text)| !text.is_empty());
        let of_motion = all.into_iter().map(|(name, text)| [name.to_owned(), text]);
        let of_quantities = study.plan.quantities().iter().filter_map(|of| {
            let error = quantities.get(&of.name)?.error?;
            let unit = if of.scale.is_some() { "-" } else { &of.unit };
            Some([format!("error of {} [{unit}]", of.name), told(Some(error))])
        });
        of_motion.chain(of_quantities).collect()
    };
    study.rows.iter().map(|row| (row.job.id.as_str(), of(row))).collect()
}

/// All runs: variant by variant, model by model, method by method, fixed steps before adaptive ones, the largest first.
fn sorted(rows: &[Row]) -> Vec<&Row> {
    let key = |row: &Row| {
        let method = rows.iter().position(|other| other.job.method == row.job.method);
        let (adaptive, size) = match row.job.setting {
            StepSetting::Step(h) => (false, h),
            StepSetting::Tolerance(tolerance) => (true, tolerance),
        };
        ((row.job.variant, row.job.model, method, adaptive), size)
    };
    let mut sorted: Vec<_> = rows.iter().map(|row| (key(row), row)).collect();
    sorted.sort_by(|((a, larger), _), ((b, smaller), _)| a.cmp(b).then_with(|| smaller.total_cmp(larger)));
    sorted.into_iter().map(|(_, row)| row).collect()
}

/// What `canopy-fem tradeoff` prints of a finished study and its files.
///
/// # Errors
/// What the template engine refuses.
pub fn summary(study: &Study, answers: &Recommendations, files: &[PathBuf]) -> Result<String, StudyError> {
    let Study { plan, rows } = study;
    let failures = unfinished(rows);
    // The least accurate first, as the table of the front has them.
    let worst = |row: &Row| Ranking::of(plan, row.job.variant).measured(row);
    let mut rows: Vec<(Option<f64>, &Row)> = rows.iter().map(|row| (worst(row), row)).collect();
    rows.sort_by(|a, b| b.0.unwrap_or(0.0).total_cmp(&a.0.unwrap_or(0.0)));
    let labelled = |(worst, row): (Option<f64>, &Row)| {
        context! { label => row.label(), worst, ..Value::from_serialize(row) }
    };
    let rows: Vec<Value> = rows.into_iter().map(labelled).collect();
    let (known, rankings) = (known(plan), rankings(plan));
    text(context! { stage => "done", plan, rows, answers, failures, files, known, rankings })
}

/// What it prints of a plan.
///
/// # Errors
/// What the template engine refuses.
pub fn planned(plan: &Plan, store: &Store) -> Result<String, StudyError> {
    let path = store.plan_path();
    let out = path.parent().and_then(Path::parent).unwrap_or(Path::new(""));
    text(context! { stage => "planned", plan, path, out, known => known(plan) })
}

fn text(context: Value) -> Result<String, StudyError> {
    render("tradeoff.txt", include_str!("../templates/tradeoff.txt"), &context)
}

/// Removes the report of an earlier study.
///
/// # Errors
/// The system's answer.
pub fn clear(out: &Path) -> Result<(), StudyError> {
    FILES.iter().try_for_each(|file| remove(&out.join(file)))
}
