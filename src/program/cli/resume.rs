//! `solve --resume`: finds the run to continue.

use super::CliError;
use crate::case::fingerprint::Fingerprint;
use crate::case::spec::Problem;
use crate::drive::Status;
use crate::output::checkpoint::Checkpoint;
use crate::output::folder::{CHECKPOINT, ResultFolder, SUMMARY};
use crate::output::summary::Summary;
use std::path::Path;

/// An earlier run of a case in a folder.
pub(super) enum EarlierRun {
    /// a run that has reached the requested end
    Done(Box<Summary>),
    /// a run to continue
    Checkpoint(ResultFolder, Box<Checkpoint>),
}

/// Finds the earlier run in the folder; changes nothing.
pub(super) fn find_earlier_run(dir: &Path, problem: &Problem, case: &Fingerprint) -> Result<EarlierRun, CliError> {
    let folder = ResultFolder::reopen(dir, &problem.name)?;
    if let Some(summary) = Summary::read(&folder.file(SUMMARY)).filter(|summary| is_done(summary, problem, case)) {
        return Ok(EarlierRun::Done(Box::new(summary)));
    }
    let checkpoint = Checkpoint::read(&folder.file(CHECKPOINT), case)?;
    Ok(EarlierRun::Checkpoint(folder, Box::new(checkpoint)))
}

/// Whether the same case has reached the same end.
fn is_done(summary: &Summary, problem: &Problem, case: &Fingerprint) -> bool {
    summary.status == Status::Completed
        && (summary.t_end == problem.time.end || summary.at_rest == Some(true))
        && summary.version == env!("CARGO_PKG_VERSION")
        && summary.case_digest == case.digest()
}
