//! `tradeoff.json`: all that is known of a study.

use serde::Serialize;

use super::machine::{Machine, Rerun};
use crate::study::error::StudyError;
use crate::study::plan::{PROGRAM, Plan};
use crate::study::recommendations::Recommendations;
use crate::study::row::Row;
use crate::study::runner::Study;

/// The file; the account of the machine stands last.
#[derive(Serialize)]
struct File<'a> {
    /// version of the program
    version: &'a str,
    /// what was typed
    command: &'a str,
    /// what was asked, the case, its variants with their references, and the list of runs
    plan: &'a Plan,
    /// what came of the runs
    rows: &'a [Row],
    answers: &'a Recommendations,
    machine: &'a Machine,
}

/// The text of the file.
///
/// # Errors
/// What JSON cannot hold.
pub(super) fn tradeoff(study: &Study, answers: &Recommendations, how: &Rerun) -> Result<String, StudyError> {
    let Rerun { command, machine } = how;
    let file = File { version: PROGRAM, command, plan: &study.plan, rows: &study.rows, answers, machine };
    let text = serde_json::to_string_pretty(&file).map_err(|e| StudyError::Page(format!("tradeoff.json: {e}")))?;
    Ok(text + "\n")
}
