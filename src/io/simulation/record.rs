//! A whole run that writes the files of `canopy-fem solve`, and gives its warnings.

use super::{
    RecordError, RunSpec, Simulation, SimulationError, bind, build_scene, check_solver, doubts_at_end, doubts_at_start,
};
use crate::analysis::critical::{CriticalStep, has_limit};
use crate::analysis::taut::WhileSlack;
use crate::analysis::warnings::{limit_at_start, while_slack};
use crate::assembly::write_matrix_market;
use crate::case::Case;
use crate::case::fingerprint::Fingerprint;
use crate::case::spec::Problem;
use crate::drive::at_rest::AtRest;
use crate::drive::cloth_strain::ClothStrain;
use crate::drive::critical_step_monitor::{CriticalStepMonitor, LeastStep, Monitored};
use crate::drive::lost_payload::LostPayload;
use crate::drive::max_displacement::{Displacement, MaxDisplacement};
use crate::drive::observer::{AcceptedStep, ObserveError, Observer, UpcomingStep, Wants};
use crate::drive::{Outcome, Status};
use crate::model::group_totals::GroupTotals;
use crate::model::stop::Stop;
use crate::output::checkpoint::Checkpoint;
use crate::output::folder::{CHECKPOINT, ResultFolder, SUMMARY};
use crate::output::gauges::MeasuredQuantity;
use crate::output::recorder::{CheckpointSpec, Recorder, RecorderSpec};
use crate::output::summary::Summary;
use crate::output::tables::Tables;
use crate::scene::Scene;
use crate::startup::{self, Phase, StartupTimer, timed};
use crate::warning::{Warning, WarningCode};
use std::cell::RefCell;
use std::collections::BTreeMap;
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
    /// folder for M, C and K at t = 0, as MatrixMarket files
    pub matrices: Option<&'a Path>,
}

impl<'a> RecordSettings<'a> {
    /// Results in a folder without earlier ones, on one thread.
    pub fn new(out: &'a Path) -> Self {
        RecordSettings { out, earlier: EarlierResults::Keep, threads: 1, keep_going: false, matrices: None }
    }
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

/// What a program does while [`record_watched`] works.
#[derive(Clone, Copy)]
pub struct RecordWatch<'a> {
    /// called once, before the first file is created or changed: from then on a run should be stopped by its flag only,
    /// so that it leaves a summary
    pub begins: &'a dyn Fn(),
    /// called with each warning of [`Recorded`] as soon as it is known
    pub warned: &'a dyn Fn(&Warning),
}

impl RecordWatch<'_> {
    /// Nothing.
    pub const NONE: RecordWatch<'static> = RecordWatch { begins: &|| (), warned: &|_| () };
}

/// A run with its files.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// what was run
    pub spec: RunSpec,
    /// how it ended
    pub outcome: Outcome,
    /// what `summary.json` holds
    pub summary: Summary,
    /// the quantities of the run
    pub quantities: Vec<MeasuredQuantity>,
    /// warnings of the case, of its scene, of the run and of its end that it does not acknowledge, in this order
    pub warnings: Vec<Warning>,
    /// the critical step at the start
    pub limits: StartLimits,
    /// the smallest critical step after the start, if it is clearly smaller
    pub least: Option<LeastStep>,
    /// the largest displacement at the end
    pub displacement: Displacement,
    /// its node with the groups it belongs to
    pub displaced: String,
    /// [s] time of the last frame
    pub last_frame: Option<f64>,
}

/// The critical step of a run at its start.
#[derive(Clone, Copy, Debug)]
pub struct StartLimits {
    /// with all springs taut
    pub taut: CriticalStep,
    /// springs that are slack, and the longer critical step as long as they are
    pub while_slack: Option<WhileSlack>,
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
    record_watched(case.clone(), how, RecordWatch::NONE, observers, stop)
}

/// The same, and tells on the way what a user should know at once. The mesh of the case is not kept beside the scene.
///
/// # Errors
/// As [`record`].
pub fn record_watched(
    case: Case,
    how: RecordSettings<'_>,
    watch: RecordWatch<'_>,
    observers: &mut [&mut dyn Observer],
    stop: &AtomicBool,
) -> Result<Recorded, RecordError> {
    let asked = Asked { files: Some(how), threads: how.threads, keep_going: how.keep_going };
    Ok(whole(case, asked, watch, observers, stop)?.0)
}

/// How [`record_in_memory`] runs a case.
#[derive(Clone, Copy, Debug)]
pub struct MemorySettings {
    /// threads for the force passes of scenes above 2,000 nodes, at least 1; results do not depend on it
    pub threads: usize,
    /// go on past a divergence until a value stops being finite
    pub keep_going: bool,
}

/// Runs a case as [`record`] does, and keeps the tables in memory instead of the files: with the same values. Frames
/// are not kept, and there is no checkpoint.
///
/// # Errors
/// As [`record`], but for those of files.
pub fn record_in_memory(
    case: &Case,
    how: MemorySettings,
    observers: &mut [&mut dyn Observer],
    stop: &AtomicBool,
) -> Result<(Recorded, Tables), RecordError> {
    let MemorySettings { threads, keep_going } = how;
    whole(case.clone(), Asked { files: None, threads, keep_going }, RecordWatch::NONE, observers, stop)
}

/// How a case is run; into memory without `files`.
#[derive(Clone, Copy)]
struct Asked<'a> {
    files: Option<RecordSettings<'a>>,
    threads: usize,
    keep_going: bool,
}

fn whole(
    case: Case,
    asked: Asked<'_>,
    watch: RecordWatch<'_>,
    observers: &mut [&mut dyn Observer],
    stop: &AtomicBool,
) -> Result<(Recorded, Tables), RecordError> {
    let timer = StartupTimer::open();
    let (mut problem, source) = case.split();
    let told = Told::of(&problem, watch);
    let case = Fingerprint::of(&problem)?;
    if let Some(how) = asked.files.filter(|how| how.earlier == EarlierResults::Keep) {
        ResultFolder::check(how.out, &problem.name)?;
    }
    let resumed = asked.files.filter(|how| how.earlier == EarlierResults::Resume);
    let earlier = resumed.map(|how| reopen(&problem, how.out, &case)).transpose()?;
    let (groups, system) = (problem.group_totals(), problem.take_system());
    let scene: Arc<dyn Scene> = timed(Phase::Scene, || build_scene(system, asked.threads))?.into();
    // An unsuitable solver or method is refused before any file is created.
    check_solver(&problem, &*scene, &source)?;
    bind(&problem, &*scene)?;
    (watch.begins)();
    let (folder, checkpoint) = match earlier {
        Some((folder, checkpoint)) => (Some(folder), Some(checkpoint)),
        None => {
            let prepare = |how: RecordSettings<'_>| {
                let replace = how.earlier == EarlierResults::Replace;
                timed(Phase::Files, || ResultFolder::prepare(how.out, &problem.name, replace))
            };
            (asked.files.map(prepare).transpose()?, None)
        }
    };
    let Asked { files, threads, keep_going } = asked;
    let ends_by_event = problem.time.to_ground;
    let spec = RunSpec { keep_going, threads, ends_by_event, ..problem.run_spec() };
    let prepared = Prepared { problem, scene, spec, folder, case, groups, timer, stop, told };
    let limits = timed(Phase::CriticalStep, || prepared.limits());
    if let Some(dir) = files.and_then(|how| how.matrices) {
        let scene = &*prepared.scene;
        write_matrix_market(scene, scene.initial_state().as_ref(), dir, &|dof| scene.name_of(dof))?;
    }
    prepared.run(limits, checkpoint, observers)
}

/// A run that is ready to start.
struct Prepared<'a> {
    problem: Problem,
    scene: Arc<dyn Scene>,
    spec: RunSpec,
    /// none for a run in memory
    folder: Option<ResultFolder>,
    case: Fingerprint,
    groups: BTreeMap<String, GroupTotals>,
    timer: StartupTimer,
    stop: &'a AtomicBool,
    told: Told<'a>,
}

impl Prepared<'_> {
    /// Finds the critical step at the start, and tells what is doubtful there.
    fn limits(&self) -> StartLimits {
        let plan = self.spec.planned(&*self.scene, Stop::on(self.stop));
        let taut = limit_at_start(plan);
        let while_slack = while_slack(plan, taut);
        let doubts = doubts_at_start(plan, &self.problem, taut, self.folder.as_ref().map(ResultFolder::dir));
        doubts.into_iter().for_each(|warning| self.told.tell(warning));
        StartLimits { taut, while_slack }
    }

    /// Runs from the start or from the checkpoint, and writes all files.
    fn run(
        self,
        limits: StartLimits,
        checkpoint: Option<Checkpoint>,
        observers: &mut [&mut dyn Observer],
    ) -> Result<(Recorded, Tables), RecordError> {
        let Prepared { problem, scene, spec, stop, told, .. } = &self;
        let spent = checkpoint.as_ref().map(|checkpoint| checkpoint.spent).unwrap_or_default();
        let (stopwatch, every) = (startup::stopwatch(spent), problem.output.checkpoint_every);
        // Settings that were derived at the start of the earlier run are kept.
        let case = checkpoint.as_ref().map_or_else(|| self.case.clone(), |checkpoint| checkpoint.case.clone());
        let (case_digest, resumed_from) = (case.digest(), checkpoint.as_ref().map(|c| c.snapshot.t));
        let mut recorder = timed(Phase::Files, || self.recorder(checkpoint.as_ref()))?;
        if self.folder.is_some() {
            recorder = recorder.with_checkpoints(CheckpointSpec { case, every, stopwatch });
        }
        let (mut farthest, mut strained) = (MaxDisplacement::new(&**scene), ClothStrain::new(&**scene, spec.end));
        let mut rest = problem.time.until_rest.map(|rest| AtRest::new(&**scene, rest, spec.end));
        let tell = |warning| told.tell(warning);
        // Adaptive steps become smaller where a scene stiffens, so no monitor is needed.
        let mut monitor = spec.step.fixed().and_then(|step| {
            let (scene, method, start, stop) = (&**scene, &spec.method, limits.taut, Stop::on(stop));
            CriticalStepMonitor::of(Monitored { scene, method, start, step, tell: &tell, stop }, has_limit(method))
        });
        let mut doubtful = told;
        let mut all: Vec<&mut dyn Observer> = vec![&mut recorder, &mut farthest, &mut strained, &mut doubtful];
        all.extend(rest.as_mut().map(|rest| rest as &mut dyn Observer));
        all.extend(monitor.as_mut().map(|monitor| monitor as &mut dyn Observer));
        all.extend(observers.iter_mut().map(|observer| &mut **observer as &mut dyn Observer));
        let mut simulation = match checkpoint {
            Some(Checkpoint { snapshot, .. }) => Simulation::resume_own(scene.clone(), spec.clone(), snapshot)?,
            None => Simulation::of_own(scene.clone(), spec.clone())?,
        };
        startup::ready();
        let outcome = simulation.run(&mut all, stop)?;
        let summary = Summary {
            resumed_from,
            case_digest,
            peaks: recorder.peaks(),
            stages: recorder.stages(),
            crossings: recorder.crossings().cloned(),
            groups: self.groups.clone(),
            startup: self.timer.read(),
            mass_scaling: scene.added_mass(),
            payload_lost: LostPayload::find(&**scene, &problem.output.stages.payload, &outcome.fired),
            failure_groups: outcome.failure.as_ref().map(|failure| failure.groups(scene.parts())).unwrap_or_default(),
            ..Summary::new(problem, &**scene, &outcome, limits.taut.step, stopwatch.read())
        };
        let quantities = recorder.quantities();
        let summary = summary.with_quantities(&quantities);
        if let Some(folder) = &self.folder {
            summary.write(&folder.file(SUMMARY))?;
            // The checkpoint of an interrupt, which the case did not ask for.
            if outcome.status == Status::Completed && every.is_none() {
                folder.remove_checkpoint()?;
            }
        }
        if let Some(linear) = &summary.linear {
            log::info!("linear solver at the end: {}, {}", linear.solver, linear.reason);
        }
        let strained = strained.most.map(|strained| strained.text(scene.parts()));
        doubts_at_end(problem, &outcome, &summary, strained).into_iter().for_each(tell);
        let (spec, warnings) = (spec.clone(), told.all.take());
        let least = monitor.and_then(|monitor| monitor.least());
        let (displacement, last_frame) = (farthest.found, recorder.shown());
        let displaced = scene.node_in_words(displacement.node as u32);
        let tables = recorder.take_tables();
        let recorded = Recorded {
            spec,
            outcome,
            summary,
            quantities,
            warnings,
            limits,
            least,
            displacement,
            displaced,
            last_frame,
        };
        Ok((recorded, tables))
    }

    fn recorder(&self, checkpoint: Option<&Checkpoint>) -> Result<Recorder<'_>, RecordError> {
        let scene = &*self.scene;
        let Some(folder) = &self.folder else {
            return Ok(Recorder::in_memory(scene, &RecorderSpec::of(&self.problem, Path::new("")))?);
        };
        let recorded = RecorderSpec::of(&self.problem, folder.dir());
        let Some(checkpoint) = checkpoint else { return Ok(Recorder::new(scene, &recorded)?) };
        self.spec.passes(scene, &checkpoint.snapshot).map_err(SimulationError::from)?;
        Ok(Recorder::resume(scene, &recorded, checkpoint)?)
    }
}

/// The folder of an earlier run of the case and its checkpoint; changes nothing.
fn reopen(problem: &Problem, out: &Path, case: &Fingerprint) -> Result<(ResultFolder, Checkpoint), RecordError> {
    let folder = ResultFolder::reopen(out, &problem.name)?;
    let checkpoint = Checkpoint::read(&folder.file(CHECKPOINT), case)?;
    Ok((folder, checkpoint))
}

/// Warnings that were told; as an observer it tells those of the run.
struct Told<'a> {
    watch: RecordWatch<'a>,
    acknowledge: Vec<WarningCode>,
    all: RefCell<Vec<Warning>>,
}

impl<'a> Told<'a> {
    /// Begins with the warnings of the case.
    fn of(problem: &Problem, watch: RecordWatch<'a>) -> Self {
        let told = Told { watch, acknowledge: problem.acknowledge.clone(), all: RefCell::default() };
        problem.warnings.iter().for_each(|warning| told.tell(warning.clone()));
        told
    }

    /// Tells a warning, unless the case acknowledges its kind.
    fn tell(&self, warning: Warning) {
        if !self.acknowledge.contains(&warning.code) {
            (self.watch.warned)(&warning);
            self.all.borrow_mut().push(warning);
        }
    }
}

impl Observer for &Told<'_> {
    fn wants(&self, _step: UpcomingStep) -> Wants {
        Wants::ACCOUNT
    }

    fn accepted(&mut self, _step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        Ok(())
    }

    fn warned(&mut self, warning: &str) {
        self.tell(Warning::new(WarningCode::EnergyMade, warning));
    }
}
