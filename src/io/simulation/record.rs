//! A whole run that writes the files of `canopy-fem solve`.

use super::{RunSettings, SetupError, Simulation, SimulationError, bind, build_scene, check_solver, doubts_at_end};
use crate::analysis::warnings::{Planned, limit_at_start, mass_warning, step_warning};
use crate::case::fingerprint::{Fingerprint, FingerprintError};
use crate::case::spec::Problem;
use crate::case::{Case, CaseError};
use crate::drive::at_rest::AtRest;
use crate::drive::cloth_strain::ClothStrain;
use crate::drive::observer::{ObserveError, Observer};
use crate::drive::{Outcome, Status};
use crate::model::stop::Stop;
use crate::output::checkpoint::Checkpoint;
use crate::output::folder::{CHECKPOINT, FolderError, ResultFolder, SUMMARY};
use crate::output::modes::ModesWriteError;
use crate::output::recorder::{CheckpointSpec, Recorder, RecorderError, RecorderSpec};
use crate::output::resume::ResumeError;
use crate::output::summary::Summary;
use crate::scene::Scene;
use crate::startup::{self, Phase, StartupTimer, timed};
use crate::warning::Warning;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// How [`record`] runs a case.
#[derive(Clone, Copy, Debug)]
pub struct RecordSettings<'a> {
    /// folder for the results
    pub out: &'a Path,
    /// what to do with earlier results in the folder
    pub earlier: EarlierResults,
    /// threads for the force passes of scenes above 2,000 nodes, at least 1; results do not depend on it
    pub threads: usize,
    /// go on past a divergence until a value stops being finite
    pub keep_going: bool,
}

/// What becomes of earlier results in a folder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EarlierResults {
    /// they are kept: the run is refused
    #[default]
    Keep,
    /// they are replaced
    Replace,
    /// the run goes on from their checkpoint
    Resume,
}

/// A run with its files.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// how it ended
    pub outcome: Outcome,
    /// what `summary.json` holds
    pub summary: Summary,
    /// warnings of the case, of its scene and of its end that it does not acknowledge
    pub warnings: Vec<Warning>,
}

/// Why a run has no files.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The solver of the case does not fit its scene.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The scene cannot be built.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The run cannot start.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The folder cannot be used.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// There is no checkpoint of this case.
    #[error(transparent)]
    Resume(#[from] ResumeError),
    /// Results cannot be prepared.
    #[error(transparent)]
    Recorder(#[from] RecorderError),
    /// Results cannot be written.
    #[error(transparent)]
    Observe(#[from] ObserveError),
    /// Modes cannot be written.
    #[error(transparent)]
    Modes(#[from] ModesWriteError),
    /// The files that the case names have no checksum.
    #[error(transparent)]
    Fingerprint(#[from] FingerprintError),
}

/// Runs a case to its end, to its failure or until `stop` is set, and writes all files of `canopy-fem solve`, byte for
/// byte but for costs in `summary.json`. More observers may watch.
///
/// # Errors
/// A scene that cannot be built, a folder with earlier results, and what cannot be written. A run that diverges, cannot
/// be solved or is stopped is not an error but an [`Outcome`].
pub fn record(
    case: &Case,
    how: RecordSettings<'_>,
    observers: &mut [&mut dyn Observer],
    stop: &AtomicBool,
) -> Result<Recorded, RecordError> {
    let timer = StartupTimer::open();
    let problem = case.problem();
    let fingerprint = Fingerprint::of(problem)?;
    let scene: Arc<dyn Scene> = timed(Phase::Scene, || build_scene(problem.system.clone(), how.threads))?.into();
    // An unsuitable solver or method is refused before any file is created.
    check_solver(problem, &*scene, case.source())?;
    bind(problem, &*scene)?;
    let (folder, checkpoint) = timed(Phase::Files, || folder(problem, how, &fingerprint))?;
    let step = problem.time.step.fixed().map(|step| step.min(problem.time.end));
    let plan = Planned { scene: &*scene, method: &problem.method, step, end: problem.time.end, stop: Stop::on(stop) };
    let limit = timed(Phase::CriticalStep, || limit_at_start(plan));
    let found = [mass_warning(&*scene), step_warning(plan, limit)].into_iter().flatten();
    let mut warnings: Vec<Warning> = problem.warnings.iter().cloned().chain(problem.sort_out(found).1).collect();
    let recorded = RecorderSpec::of(problem, folder.dir());
    let recorder = match &checkpoint {
        Some(checkpoint) => {
            let spec = problem.run_spec(how.keep_going);
            spec.passes(&*scene, &checkpoint.snapshot).map_err(SimulationError::from)?;
            Recorder::resume(&*scene, &recorded, checkpoint)?
        }
        None => Recorder::new(&*scene, &recorded)?,
    };
    let stopwatch = startup::stopwatch(checkpoint.as_ref().map(|checkpoint| checkpoint.spent).unwrap_or_default());
    let every = problem.output.checkpoint_every;
    // Settings that were derived at the start of the earlier run are kept.
    let fingerprint = checkpoint.as_ref().map_or(fingerprint, |checkpoint| checkpoint.case.clone());
    let case_digest = fingerprint.digest();
    let mut recorder = recorder.with_checkpoints(CheckpointSpec { case: fingerprint, every, stopwatch });
    let resumed_from = checkpoint.as_ref().map(|checkpoint| checkpoint.snapshot.t);
    let settings = RunSettings { keep_going: how.keep_going, ..RunSettings::of_case(problem, how.threads) };
    let mut simulation = match checkpoint {
        Some(Checkpoint { snapshot, .. }) => Simulation::resume(scene.clone(), settings, snapshot)?,
        None => Simulation::of_scene(scene.clone(), settings)?,
    };
    startup::ready();
    let mut rest = problem.time.until_rest.map(|rest| AtRest::new(&*scene, rest, problem.time.end));
    let mut strained = ClothStrain::new(&*scene, problem.time.end);
    let mut all: Vec<&mut dyn Observer> = vec![&mut recorder, &mut strained];
    all.extend(rest.as_mut().map(|rest| rest as &mut dyn Observer));
    all.extend(observers.iter_mut().map(|observer| &mut **observer as &mut dyn Observer));
    let outcome = simulation.run(&mut all, stop)?;
    let summary = Summary::new(problem, &*scene, &outcome, limit.step, stopwatch.read());
    let (peaks, crossings, groups) = (recorder.peaks(), recorder.crossings().cloned(), problem.group_totals());
    let (mass_scaling, startup) = (scene.added_mass(), timer.read());
    let summary = Summary { resumed_from, case_digest, peaks, crossings, groups, startup, mass_scaling, ..summary };
    summary.write(&folder.file(SUMMARY))?;
    // The checkpoint of an interrupt, which the case did not ask for.
    if outcome.status == Status::Completed && every.is_none() {
        folder.remove_checkpoint()?;
    }
    warnings.extend(doubts_at_end(problem, &outcome, &summary, strained.most));
    Ok(Recorded { outcome, summary, warnings })
}

fn folder(
    problem: &Problem,
    how: RecordSettings<'_>,
    fingerprint: &Fingerprint,
) -> Result<(ResultFolder, Option<Checkpoint>), RecordError> {
    if how.earlier != EarlierResults::Resume {
        let replace = how.earlier == EarlierResults::Replace;
        return Ok((ResultFolder::prepare(how.out, &problem.name, replace)?, None));
    }
    let folder = ResultFolder::reopen(how.out, &problem.name)?;
    let checkpoint = Checkpoint::read(&folder.file(CHECKPOINT), fingerprint)?;
    Ok((folder, Some(checkpoint)))
}
