//! `solve --resume` of a run that has ended already.

use crate::case::fingerprint::Fingerprint;
use crate::case::spec::Problem;
use crate::drive::Status;
use crate::output::folder::{ResultFolder, SUMMARY};
use crate::output::summary::Summary;
use std::path::Path;

/// The summary of an earlier run in the folder, if the same case has reached the same end; changes nothing. `None` also
/// where the folder cannot be used, which the run that is made then says.
pub(super) fn finished_run(dir: &Path, problem: &Problem) -> Option<Summary> {
    let folder = ResultFolder::reopen(dir, &problem.name).ok()?;
    let summary = Summary::read(&folder.file(SUMMARY))?;
    let done = summary.status == Status::Completed
        && (summary.t_end == problem.time.end
            || summary.at_rest == Some(true)
            || (problem.time.to_ground && summary.landing.is_some()))
        && summary.version == env!("CARGO_PKG_VERSION")
        && summary.case_digest == Fingerprint::of(problem).ok()?.digest();
    done.then_some(summary)
}
