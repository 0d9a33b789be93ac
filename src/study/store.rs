//! The files of a study: its plan, its references, and one file a run, so that any number of processes may work on it.
//!
//! ```text
//! DIR/tradeoff/plan.json               the list of runs; that of a sweep is DIR/sweep/plan.json
//! DIR/tradeoff/reference-0.bin         frames of the reference of variant 0
//! DIR/tradeoff/runs/ID.json            result of a run
//! DIR/tradeoff/runs/ID.part            snapshot of an unfinished run
//! ```
//! Every file appears whole, by a rename. Processes that make the same run write the same result, and the last one
//! stays. A file of another study is an error, except a `.part`, whose run begins again.

use std::fs;
use std::io;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::error::StudyError;
use super::frames::Distance;
use super::plan::{FORMAT, PROGRAM, Plan};
use super::reference::Reference;
use super::row::{Job, RunResult};
use crate::checksum;
use crate::drive::Snapshot;
use crate::input_file;
use crate::output::atomic::{Durability, replace_shared};
use crate::output::largest::LargestSoFar;

/// The plan of a study as its files need it.
pub trait StudyPlan: Serialize + DeserializeOwned {
    /// the command, and the folder of the study's files
    const COMMAND: &'static str;
    /// a run before it is made
    type Job: StudyJob;
    /// what comes of a run
    type Result: Clone + Serialize + DeserializeOwned;

    /// Layout of the file, and version of the program.
    fn made_by(&self) -> (u32, &str);

    /// All runs.
    fn jobs(&self) -> &[Self::Job];

    /// Whether both plans have the same runs of the same cases.
    fn same_runs(&self, other: &Self) -> bool;
}

/// A run before it is made.
pub trait StudyJob: Clone + PartialEq + Serialize + DeserializeOwned {
    /// Name of its files.
    fn id(&self) -> &str;
}

impl StudyPlan for Plan {
    const COMMAND: &'static str = "tradeoff";
    type Job = Job;
    type Result = RunResult;

    fn made_by(&self) -> (u32, &str) {
        (self.format, &self.program)
    }

    fn jobs(&self) -> &[Job] {
        &self.jobs
    }

    fn same_runs(&self, other: &Self) -> bool {
        let cases = |plan: &Self| plan.variants.iter().map(|v| v.fingerprint.clone()).collect::<Vec<_>>();
        self.jobs == other.jobs && cases(self) == cases(other)
    }
}

impl StudyJob for Job {
    fn id(&self) -> &str {
        &self.id
    }
}

/// A study's folder.
#[derive(Clone, Debug)]
pub struct Store<P = Plan> {
    dir: PathBuf,
    plan: PhantomData<P>,
}

/// What a tradeoff study has measured of an unfinished run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ComparedSoFar {
    /// how far its frames are from the reference
    pub distance: Distance,
    /// its quantities, if any are measured
    pub quantities: Option<LargestSoFar>,
}

/// An unfinished run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Unfinished<D = ComparedSoFar> {
    /// the run
    pub snapshot: Snapshot,
    /// what the study has measured of it
    pub measured: D,
    /// [s] processor time so far
    pub spent: f64,
}

/// The result of a run, with what it belongs to.
#[derive(Serialize, Deserialize)]
struct Finished<J, R> {
    format: u32,
    program: String,
    #[serde(flatten)]
    job: J,
    #[serde(flatten)]
    measured: R,
}

impl<P: StudyPlan> Store<P> {
    /// In `out`.
    pub fn in_folder(out: &Path) -> Self {
        Store { dir: out.join(P::COMMAND), plan: PhantomData }
    }

    /// The error for a folder without a plan.
    pub fn no_plan(folder: &Path) -> StudyError {
        StudyError::NoPlan { folder: folder.to_owned(), command: P::COMMAND }
    }

    /// Path of the plan.
    pub fn plan_path(&self) -> PathBuf {
        self.dir.join("plan.json")
    }

    fn run_path(&self, job: &P::Job, ending: &str) -> PathBuf {
        self.dir.join("runs").join(format!("{}.{ending}", job.id()))
    }

    /// The plan, if there is one.
    ///
    /// # Errors
    /// A file that is no plan of this program.
    pub fn plan(&self) -> Result<Option<P>, StudyError> {
        let path = self.plan_path();
        let Some(bytes) = read(&path)? else { return Ok(None) };
        let bad = |what: String| StudyError::BadFile { path: path.clone(), what };
        let plan: P = serde_json::from_slice(&bytes).map_err(|e| bad(format!("this is no plan: {e}")))?;
        if plan.made_by() != (FORMAT, PROGRAM) {
            let (format, program) = plan.made_by();
            return Err(bad(format!(
                "it was made by version {program} (format {format}), this is version {PROGRAM} (format {FORMAT})"
            )));
        }
        Ok(Some(plan))
    }

    /// Stores the plan, after its references.
    pub fn keep_plan(&self, plan: &P) -> Result<(), StudyError> {
        self.write_json(&self.plan_path(), plan)
    }

    /// Removes all that belongs to a study.
    pub fn clear(&self) -> Result<(), StudyError> {
        gone(&self.dir, fs::remove_dir_all(&self.dir))
    }

    /// The result of a run, if it was made; a file of another run is an error.
    pub(super) fn measured(&self, job: &P::Job) -> Result<Option<P::Result>, StudyError> {
        let path = self.run_path(job, "json");
        let Some(bytes) = read(&path)? else { return Ok(None) };
        let bad = |what: String| StudyError::BadFile { path: path.clone(), what };
        let found: Finished<P::Job, P::Result> =
            serde_json::from_slice(&bytes).map_err(|e| bad(format!("this is no result of a run: {e}")))?;
        if found.format != FORMAT || found.program != PROGRAM || found.job != *job {
            return Err(bad("it belongs to another study".to_owned()));
        }
        Ok(Some(found.measured))
    }

    /// Stores the result of a run and removes what was kept of its unfinished part.
    pub(super) fn keep_measured(&self, job: &P::Job, measured: &P::Result) -> Result<(), StudyError> {
        let finished =
            Finished { format: FORMAT, program: PROGRAM.to_owned(), job: job.clone(), measured: measured.clone() };
        self.write_json(&self.run_path(job, "json"), &finished)?;
        remove(&self.run_path(job, "part"))
    }

    /// Where an earlier process left a run; `None` if it was not begun, or by another program, or is damaged.
    pub(super) fn unfinished<D: DeserializeOwned>(&self, job: &P::Job) -> Option<Unfinished<D>> {
        decode(&read(&self.run_path(job, "part")).ok()??)
    }

    /// Stores where a run has come to.
    pub(super) fn keep_unfinished<D: Serialize>(
        &self,
        job: &P::Job,
        unfinished: &Unfinished<D>,
    ) -> Result<(), StudyError> {
        self.write_binary(&self.run_path(job, "part"), unfinished)
    }

    /// Copies the finished runs of the same study from another folder; another study there is an error.
    pub fn take_from(&self, other: &Self, plan: &P) -> Result<(), StudyError> {
        let theirs = other.plan()?.ok_or_else(|| Self::no_plan(&other.dir))?;
        if !theirs.same_runs(plan) {
            let difference = "its runs are not those of the plan".to_owned();
            return Err(StudyError::OtherStudy { folder: other.dir.clone(), difference });
        }
        for job in plan.jobs() {
            if let (None, Some(measured)) = (self.measured(job)?, other.measured(job)?) {
                self.keep_measured(job, &measured)?;
            }
        }
        Ok(())
    }

    fn write_json(&self, path: &Path, value: &impl Serialize) -> Result<(), StudyError> {
        let text = serde_json::to_string_pretty(value).map_err(|e| system(path, e.into()))? + "\n";
        self.write(path, text.as_bytes())
    }

    fn write_binary(&self, path: &Path, value: &impl Serialize) -> Result<(), StudyError> {
        let invalid = |e: postcard::Error| system(path, io::Error::new(io::ErrorKind::InvalidData, e));
        let mut bytes = postcard::to_stdvec(&(FORMAT, PROGRAM, value)).map_err(invalid)?;
        checksum::append(&mut bytes);
        self.write(path, &bytes)
    }

    fn write(&self, path: &Path, bytes: &[u8]) -> Result<(), StudyError> {
        let folder = path.parent().unwrap_or(&self.dir);
        fs::create_dir_all(folder).map_err(|e| system(folder, e))?;
        replace_shared(path, bytes, Durability::Synced).map_err(|e| system(path, e))
    }
}

impl Store {
    fn reference_path(&self, variant: usize) -> PathBuf {
        self.dir.join(format!("reference-{variant}.bin"))
    }

    /// Stores the reference of a variant.
    pub fn keep_reference(&self, variant: usize, reference: &Reference) -> Result<(), StudyError> {
        self.write_binary(&self.reference_path(variant), reference)
    }

    /// The reference of a variant.
    pub(super) fn reference(&self, variant: usize) -> Result<Reference, StudyError> {
        let path = self.reference_path(variant);
        let bytes = read(&path)?.ok_or_else(|| Self::no_plan(&self.dir))?;
        decode(&bytes).ok_or_else(|| StudyError::BadFile {
            path: self.plan_path(),
            what: format!("its {} is damaged", path.file_name().unwrap_or_default().display()),
        })
    }
}

/// A binary file of this program that is whole.
fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    let content = checksum::verified(bytes).ok()?;
    // The head first: the rest of another format may not be what it looks like.
    let (head, _): ((u32, String), &[u8]) = postcard::take_from_bytes(content).ok()?;
    if head.0 != FORMAT || head.1 != PROGRAM {
        return None;
    }
    let (_, _, value): (u32, String, T) = postcard::from_bytes(content).ok()?;
    Some(value)
}

fn read(path: &Path) -> Result<Option<Vec<u8>>, StudyError> {
    match input_file::read(path) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(e) => Err(system(path, e)),
    }
}

/// Writes the files of a report into a folder, in the order of `all`, and removes those of `all` that were not made;
/// returns the paths of those written.
pub(super) fn write_files(out: &Path, all: &[&str], made: &[(&str, String)]) -> Result<Vec<PathBuf>, StudyError> {
    fs::create_dir_all(out).map_err(|e| system(out, e))?;
    let mut written = Vec::with_capacity(made.len());
    for file in all {
        let path = out.join(file);
        match made.iter().find(|(name, _)| name == file) {
            Some((_, content)) => {
                replace_shared(&path, content.as_bytes(), Durability::Visible).map_err(|e| system(&path, e))?;
                written.push(path);
            }
            None => remove(&path)?,
        }
    }
    Ok(written)
}

/// Removes a file, if it is there.
pub(super) fn remove(path: &Path) -> Result<(), StudyError> {
    gone(path, fs::remove_file(path))
}

fn gone(path: &Path, removed: io::Result<()>) -> Result<(), StudyError> {
    match removed {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(system(path, e)),
        _ => Ok(()),
    }
}

/// An error of the system about a file.
pub(super) fn system(path: &Path, source: io::Error) -> StudyError {
    StudyError::System { path: path.to_owned(), source }
}
