//! What a study leaves for its reader: tables, figures, and one page with all of it.
//!
//! Everything is made from the study and its answers alone; only the page's and the JSON file's account of the machine
//! differs from one machine and day to the next.

mod convergence;
mod csv;
mod figure;
mod machine;
mod page;
mod stiffness;
mod style;

use std::fs;
use std::path::{Path, PathBuf};

pub use machine::{Machine, Rerun};

use serde::Serialize;

use super::error::StudyError;
use super::plan::{PROGRAM, Plan};
use super::recommendations::Recommendations;
use super::row::Row;
use super::runner::Study;
use super::store::{remove, system};
use crate::output::atomic::{Durability, replace_shared};

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
    let figures = figure::all(study, answers)?;
    let mut made: Vec<(&str, String)> = vec![
        ("tradeoff.csv", csv::tradeoff(study)),
        ("tradeoff.json", json(study, answers, how)?),
        ("tradeoff.html", page::html(study, answers, how, &figures)?),
    ];
    if study.plan.variants.len() > 1 {
        made.push(("stiffness.csv", csv::stiffness(answers)));
    }
    made.extend(figures.into_iter().map(|figure| (figure.file, figure.svg)));
    fs::create_dir_all(out).map_err(|e| system(out, e))?;
    let mut written = Vec::with_capacity(made.len());
    for file in FILES {
        let path = out.join(file);
        match made.iter().find(|(name, _)| *name == file) {
            Some((_, content)) => {
                replace_shared(&path, content.as_bytes(), Durability::Visible).map_err(|e| system(&path, e))?;
                written.push(path);
            }
            None => remove(&path)?,
        }
    }
    Ok(written)
}

/// `tradeoff.json`: all that is known of a study.
#[derive(Serialize)]
struct Json<'a> {
    version: &'a str,
    command: &'a str,
    plan: &'a Plan,
    rows: &'a [Row],
    answers: &'a Recommendations,
    machine: &'a Machine,
}

fn json(study: &Study, answers: &Recommendations, how: &Rerun) -> Result<String, StudyError> {
    let (Study { plan, rows }, Rerun { command, machine }) = (study, how);
    let text = serde_json::to_string_pretty(&Json { version: PROGRAM, command, plan, rows, answers, machine });
    Ok(text.map_err(|e| StudyError::Page(format!("tradeoff.json: {e}")))? + "\n")
}

/// Removes the report of an earlier study.
///
/// # Errors
/// The system's answer.
pub fn clear(out: &Path) -> Result<(), StudyError> {
    FILES.iter().try_for_each(|file| remove(&out.join(file)))
}
