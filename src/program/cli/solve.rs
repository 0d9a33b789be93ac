//! `canopy-fem solve`: runs a case and writes its results.

use super::interrupt::stop_on_interrupt;
use super::progress::{Display, Progress};
use super::report::{RunNotes, already_done, describe, report};
use super::resume::{self, EarlierRun};
use super::terminal::interject;
use super::warnings::{of_scene, planned};
use super::{CliError, CommandOutput, SolveArgs, complain};
use crate::analysis::critical::{CriticalStep, has_limit};
use crate::analysis::taut::WhileSlack;
use crate::analysis::warnings::{self, limit_at_start};
use crate::assembly::write_matrix_market;
use crate::case::Case;
use crate::case::fingerprint::Fingerprint;
use crate::case::spec::Problem;
use crate::drive::at_rest::AtRest;
use crate::drive::cloth_strain::ClothStrain;
use crate::drive::critical_step_monitor::{CriticalStepMonitor, Monitored};
use crate::drive::max_displacement::MaxDisplacement;
use crate::drive::observer::Observer;
use crate::drive::{Outcome, Status};
use crate::interrupt::heeding;
use crate::model::group_totals::GroupTotals;
use crate::model::stop::Stop;
use crate::output::checkpoint::Checkpoint;
use crate::output::csv::write_fault;
use crate::output::folder::{ResultFolder, SUMMARY};
use crate::output::recorder::{CheckpointSpec, Recorder, RecorderSpec};
use crate::output::sanitize::file_stem;
use crate::output::summary::Summary;
use crate::scene::Scene;
use crate::simulation::{RunSettings, Simulation, bind, build_scene, check_solver, doubts_at_end};
use crate::startup::{self, Phase, StartupTimer, timed};
use crate::warning::WarningCode;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

pub(super) fn run(args: &SolveArgs) -> Result<CommandOutput, CliError> {
    let account = StartupTimer::of_process();
    let (mut problem, source) =
        timed(Phase::Parse, || Case::from_file(&args.case.case, &args.case.overrides()))?.split();
    if !args.print.quiet {
        problem.warnings.iter().for_each(|w| complain(&format!("warning: {w}")));
    }
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from("out").join(file_stem(&problem.name)));
    let fingerprint = Fingerprint::of(&problem)?;
    let earlier = args.resume.then(|| resume::find_earlier_run(&out, &problem, &fingerprint)).transpose()?;
    if let Some(EarlierRun::Done(summary)) = &earlier {
        let text = printed(args, summary, &out, || already_done(summary, &problem, &out))?;
        return Ok(CommandOutput { text, code: 0 });
    }
    let groups = problem.group_totals();
    let scene: Arc<dyn Scene> = timed(Phase::Scene, || build_scene(problem.take_system(), args.threads.get()))?.into();
    check_solver(&problem, &*scene, &source)?;
    // An unsuitable method is refused before any file is created.
    bind(&problem, &*scene)?;
    // Before any file is created, so that no interrupt leaves results without a summary.
    let stop = stop_on_interrupt();
    let (folder, checkpoint) = match earlier {
        Some(EarlierRun::Checkpoint(folder, checkpoint)) => (folder, Some(*checkpoint)),
        _ => (timed(Phase::Files, || ResultFolder::prepare(&out, &problem.name, args.force))?, None),
    };
    let plan = planned(&problem, &*scene, Stop::on(&stop));
    let limit = timed(Phase::CriticalStep, || limit_at_start(plan));
    let mut while_slack = None;
    if !args.print.quiet {
        while_slack = timed(Phase::CriticalStep, || warnings::while_slack(plan, limit));
        let found = timed(Phase::CriticalStep, || of_scene(plan, &problem, limit, &out));
        let (_, warnings) = problem.sort_out(found);
        warnings.iter().for_each(|warning| complain(&format!("warning: {warning}")));
    }
    if let Some(dir) = &args.dump_matrices {
        let state = scene.initial_state();
        write_matrix_market(&*scene, state.as_ref(), dir, &|dof| scene.name_of(dof))?;
    }
    let job =
        PreparedRun { args, problem: &problem, scene: &scene, folder: &folder, limit, while_slack, account, groups };
    let flag = stop.clone();
    // Within an implicit step too, which may be long.
    let (outcome, summary, seen) =
        heeding(move || flag.load(Ordering::Relaxed), || job.integrate(fingerprint, checkpoint, &stop))?;
    if let Some(linear) = &summary.linear {
        log::info!("linear solver at the end: {}, {}", linear.solver, linear.reason);
    }
    if !args.print.quiet {
        let warnings = doubts_at_end(&problem, &outcome, &summary, seen.strained);
        warnings.iter().for_each(|warning| complain(&format!("warning: {warning}")));
    }
    if let Some(failure) = &outcome.failure {
        complain(&describe(failure, outcome.status));
    }
    let text = printed(args, &summary, folder.dir(), || report(&problem, &outcome, &summary, &folder, &seen))?;
    let code = match outcome.status {
        Status::Completed => 0,
        // The summary has its failure, with the cause as far as it is known.
        Status::Diverged | Status::NotConverged if stop.load(Ordering::Relaxed) => 130,
        Status::Diverged | Status::NotConverged => 3,
        Status::Interrupted => 130,
    };
    Ok(CommandOutput { text, code })
}

/// A run that is ready to start.
struct PreparedRun<'a> {
    args: &'a SolveArgs,
    problem: &'a Problem,
    scene: &'a Arc<dyn Scene>,
    folder: &'a ResultFolder,
    limit: CriticalStep,
    while_slack: Option<WhileSlack>,
    account: StartupTimer,
    groups: BTreeMap<String, GroupTotals>,
}

impl<'a> PreparedRun<'a> {
    /// Runs from the start or from the checkpoint, and writes all files.
    fn integrate(
        &self,
        case: Fingerprint,
        checkpoint: Option<Checkpoint>,
        stop: &AtomicBool,
    ) -> Result<(Outcome, Summary, RunNotes<'a>), CliError> {
        let &PreparedRun { args, problem, folder, limit, .. } = self;
        let scene = &**self.scene;
        let spec = problem.run_spec(args.keep_going);
        let recorded = RecorderSpec::of(problem, folder.dir());
        let recorder = match &checkpoint {
            Some(checkpoint) => {
                spec.passes(scene, &checkpoint.snapshot)?;
                timed(Phase::Files, || Recorder::resume(scene, &recorded, checkpoint))?
            }
            None => timed(Phase::Files, || Recorder::new(scene, &recorded))?,
        };
        let stopwatch = startup::stopwatch(checkpoint.as_ref().map(|checkpoint| checkpoint.spent).unwrap_or_default());
        let every = problem.output.checkpoint_every;
        // Settings that were derived at the start of the earlier run are kept.
        let case = checkpoint.as_ref().map_or(case, |checkpoint| checkpoint.case.clone());
        let case_digest = case.digest();
        let mut recorder = recorder.with_checkpoints(CheckpointSpec { case, every, stopwatch });
        let display = if args.print.quiet { Display::Quiet } else { Display::Terminal };
        let unwatched = args.print.quiet || problem.acknowledges(WarningCode::StepAboveCritical);
        let (mut progress, mut farthest) = (
            Progress::new(spec.end, display).acknowledging(problem.acknowledges(WarningCode::EnergyMade)),
            MaxDisplacement::new(scene),
        );
        let tell = |text: &str| {
            if !unwatched {
                interject(&format!("warning: {text}"));
            }
        };
        // Adaptive steps become smaller where a scene stiffens, so no monitor is needed.
        let mut monitor = spec.step.fixed().and_then(|step| {
            let (method, start, stop) = (&problem.method, limit, Stop::on(stop));
            CriticalStepMonitor::of(Monitored { scene, method, start, step, tell: &tell, stop }, has_limit(method))
        });
        let mut strained = ClothStrain::new(scene, spec.end);
        let mut observers: Vec<&mut dyn Observer> = vec![&mut recorder, &mut progress, &mut farthest, &mut strained];
        let mut rest = problem.time.until_rest.map(|rest| AtRest::new(scene, rest, spec.end));
        observers.extend(rest.as_mut().map(|rest| rest as &mut dyn Observer));
        observers.extend(monitor.as_mut().map(|monitor| monitor as &mut dyn Observer));
        let observers = &mut observers[..];
        let resumed_from = checkpoint.as_ref().map(|checkpoint| checkpoint.snapshot.t);
        let settings = RunSettings { keep_going: args.keep_going, ..RunSettings::of_case(problem, args.threads.get()) };
        let outcome = match checkpoint {
            Some(Checkpoint { snapshot, .. }) => Simulation::resume(self.scene.clone(), settings, snapshot)?,
            None => Simulation::of_scene(self.scene.clone(), settings)?,
        }
        .run(observers, stop)?;
        let summary = Summary::new(problem, scene, &outcome, limit.step, stopwatch.read());
        let (peaks, crossings) = (recorder.peaks(), recorder.crossings().cloned());
        let groups = self.groups.clone();
        let (mass_scaling, startup) = (scene.added_mass(), self.account.read());
        let summary = Summary { resumed_from, case_digest, peaks, crossings, groups, startup, mass_scaling, ..summary };
        summary.write(&folder.file(SUMMARY))?;
        // The checkpoint of an interrupt, which the case did not ask for.
        if outcome.status == Status::Completed && every.is_none() {
            folder.remove_checkpoint()?;
        }
        let least = monitor.and_then(|monitor| monitor.least());
        let (strained, while_slack) = (strained.most, self.while_slack);
        let last_frame = recorder.shown();
        Ok((outcome, summary, RunNotes { limit, while_slack, least, farthest, strained, last_frame }))
    }
}

/// What goes to standard output: the summary as it is in the file, the report, or nothing.
fn printed(
    args: &SolveArgs,
    summary: &Summary,
    folder: &Path,
    report: impl FnOnce() -> String,
) -> Result<String, CliError> {
    match (args.print.json, args.print.quiet) {
        (true, _) => Ok(summary.to_json().map_err(|e| write_fault(&folder.join(SUMMARY), e.into()))?),
        (false, true) => Ok(String::new()),
        (false, false) => Ok(report()),
    }
}
