//! The static equilibrium of a case, with the files of `canopy-fem static`.

use super::{EarlierResults, RecordError, build_scene, check_solver, idle_loads};
use crate::analysis::cloth::too_soft;
use crate::analysis::lowest::{LowMode, LowModes, ModesError, lowest};
use crate::case::Case;
use crate::case::fingerprint::Fingerprint;
use crate::case::spec::{Problem, SystemSpec};
use crate::drive::ledger::Ledger;
use crate::drive::observer::Observer;
use crate::drive::{Failure, Outcome, Status};
use crate::model::forces::Role;
use crate::model::stop::Stop;
use crate::output::at_rest::AtRest;
use crate::output::crossings::CrossingReport;
use crate::output::folder::{ResultFolder, SUMMARY};
use crate::output::frame::Fields;
use crate::output::modes::write_modes;
use crate::output::recorder::{Recorder, RecorderSpec};
use crate::output::summary::{EquilibriumReport, Summary};
use crate::process::Cost;
use crate::scene::Scene;
use crate::startup;
use crate::statics::{self, Equilibrium, StaticFailure, StaticSpec, Watcher};
use crate::warning::{Warning, WarningCode};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// How [`record_static`] finds an equilibrium.
#[derive(Clone, Copy, Debug)]
pub struct StaticSettings<'a> {
    /// folder for the results
    pub out: &'a Path,
    /// what to do with earlier results in the folder; they cannot be resumed
    pub earlier: EarlierResults,
    /// threads for the force passes of scenes above 2,000 nodes, at least 1; results do not depend on it
    pub threads: usize,
    /// [s] time of the loads, of the wind and of what is held
    pub at: f64,
    /// [-] number of equal steps in which loads are applied; 1 applies them at once, and in steps if that fails
    pub load_steps: u32,
    /// [-] number of vibration modes to find about the equilibrium
    pub modes: usize,
}

/// An equilibrium with its files.
#[derive(Debug)]
pub struct RecordedStatic {
    /// what was found
    pub equilibrium: Equilibrium,
    /// its modes
    pub modes: LowModes,
    /// why there are none
    pub without_modes: Option<ModesError>,
    /// what `summary.json` holds
    pub summary: Summary,
    /// warnings of the case that it does not acknowledge
    pub warnings: Vec<Warning>,
}

/// Warnings that tell of steps and motion.
const OF_A_RUN: [WarningCode; 12] = [
    WarningCode::BrakedRotation,
    WarningCode::EventAtStart,
    WarningCode::EventBeyondEnd,
    WarningCode::FillingBeyondEnd,
    WarningCode::LongStep,
    WarningCode::LostMotion,
    WarningCode::ShortPulse,
    WarningCode::SlackOpening,
    WarningCode::StepAboveCritical,
    WarningCode::StepBeyondEnd,
    WarningCode::StepDashpot,
    WarningCode::TightCloth,
];

/// [-] Iterations of a search over those that the case allows an implicit step.
const STEPS_WORTH: u32 = 100;

/// Finds the equilibrium of a case and writes its files: one frame, `summary.json`, gauges and probes, and its modes.
///
/// # Errors
/// A scene that cannot be built, a folder with earlier results, and what cannot be written. A scene without equilibrium
/// is not an error but a failure in [`Equilibrium`] and in the summary.
pub fn record_static(case: &Case, how: StaticSettings<'_>, stop: &AtomicBool) -> Result<RecordedStatic, RecordError> {
    record_static_watched(case, how, stop, Watcher::NONE)
}

/// The same, and tells how far the search has come.
///
/// # Errors
/// As [`record_static`].
pub fn record_static_watched(
    case: &Case,
    how: StaticSettings<'_>,
    stop: &AtomicBool,
    watcher: Watcher<'_>,
) -> Result<RecordedStatic, RecordError> {
    let stopwatch = startup::stopwatch(Cost::default());
    let problem = case.problem();
    let case_digest = Fingerprint::of(problem)?.digest();
    let replace = how.earlier == EarlierResults::Replace;
    if !replace {
        ResultFolder::check(how.out, &problem.name)?;
    }
    let scene = build_scene(problem.system.clone().with_real_masses(), how.threads)?;
    check_solver(problem, &*scene, case.source())?;
    let folder = ResultFolder::prepare(how.out, &problem.name, replace)?;
    let spec = RecorderSpec::of(problem, folder.dir());
    // What `initial.keep` of a further run takes up.
    let fields = Fields { tension: true, rest_length: true, ..spec.fields };
    let spec = RecorderSpec { frames_every: None, fields, ..spec };
    let mut recorder = Recorder::new(&*scene, &spec)?;
    let asked = static_spec(problem, how.at, how.load_steps);
    let start = scene.initial_state();
    let equilibrium = statics::find_watched(&*scene, asked, Stop::on(stop), watcher);
    let at_rest = match (&equilibrium.failure, &problem.system) {
        (None, SystemSpec::Network(spec)) => {
            let parts = (&spec.springs[..], &spec.membranes[..]);
            AtRest::of(&*scene, start.as_ref(), &equilibrium.point, parts)
        }
        _ => AtRest::default(),
    };
    let outcome = outcome(&*scene, &equilibrium);
    recorder.started(&equilibrium.point, outcome.ledger)?;
    if equilibrium.failure.is_some() {
        recorder.failed()?;
    }
    recorder.finished(&equilibrium.point)?;
    let found = match how.modes {
        count if count > 0 && equilibrium.failure.is_none() => {
            lowest(&*scene, equilibrium.point.state.as_ref(), count, Stop::on(stop))
        }
        _ => Ok(LowModes::default()),
    };
    let (modes, without_modes) = match found {
        Ok(modes) => (modes, None),
        Err(error) => (LowModes::default(), Some(error)),
    };
    write_modes(&*scene, &spec, &equilibrium.point, &modes.modes, replace)?;
    let idle = idle_loads(problem, &*scene, how.at);
    let interrupted = without_modes == Some(ModesError::Stopped);
    let outcome = Outcome { status: if interrupted { Status::Interrupted } else { outcome.status }, ..outcome };
    let summary = Summary {
        method: "static".to_owned(),
        method_parameters: Default::default(),
        peaks: recorder.peaks(),
        crossings: recorder.crossings().cloned(),
        groups: problem.group_totals(),
        events: Vec::new(),
        never_fired: Vec::new(),
        landing: None,
        at_rest: None,
        equilibrium: Some(EquilibriumReport {
            idle_loads: idle,
            ..report(&*scene, (&equilibrium, at_rest), &outcome, &modes)
        }),
        case_digest,
        ..Summary::new(problem, &*scene, &outcome, f64::INFINITY, stopwatch.read())
    };
    summary.write(&folder.file(SUMMARY))?;
    let crossings = problem.sort_out(recorder.crossings().and_then(CrossingReport::warning)).1;
    let warnings = warnings_at_rest(problem).cloned().chain(crossings).collect();
    Ok(RecordedStatic { equilibrium, modes, without_modes, summary, warnings })
}

/// What to find of a case, at a time [s], with the loads in so many steps.
pub fn static_spec(problem: &Problem, at: f64, load_steps: u32) -> StaticSpec {
    let newton = problem.solver.newton;
    StaticSpec {
        at,
        relative: newton.relative,
        max_iterations: newton.max_iterations.saturating_mul(STEPS_WORTH),
        load_steps,
        linear: problem.solver.linear,
    }
}

/// The warnings of a case that matter where it is not run in time.
pub fn warnings_at_rest(problem: &Problem) -> impl Iterator<Item = &Warning> {
    problem.warnings.iter().filter(|warning| !OF_A_RUN.contains(&warning.code))
}

fn outcome(scene: &dyn Scene, found: &Equilibrium) -> Outcome {
    let ledger = Ledger::open(scene, &found.point).first();
    Outcome {
        status: match &found.failure {
            None => Status::Completed,
            Some(StaticFailure::Interrupted) => Status::Interrupted,
            Some(_) => Status::NotConverged,
        },
        steps: u64::from(found.pseudo_steps),
        rejected_steps: u64::from(found.dropped),
        t_end: found.point.state.t,
        counters: found.counters,
        ended_early: false,
        fired: Vec::new(),
        unmet: Vec::new(),
        account_passes: 0,
        energy_error: 0.0,
        energy_made: 0.0,
        doubt: None,
        ledger,
        failure: found.failure.as_ref().filter(|failure| **failure != StaticFailure::Interrupted).map(|failure| {
            let place = failure.place();
            let soft = too_soft(scene, found.point.state.as_ref());
            let soft = soft.map_or_else(String::new, |soft| format!("; {soft}"));
            Failure {
                time: found.point.state.t,
                step: u64::from(found.pseudo_steps) + 1,
                node: place.node,
                spring: place.spring,
                term: place.term.map(|term| term.name.to_owned()),
                cause: format!("{failure}{soft}"),
                advice: failure.advice(),
                ..Failure::default()
            }
        }),
        linear: found.linear,
    }
}

fn report(
    scene: &dyn Scene,
    (found, at_rest): (&Equilibrium, AtRest),
    outcome: &Outcome,
    modes: &LowModes,
) -> EquilibriumReport {
    let conservative = scene.symmetric() && scene.terms().iter().all(|term| term.role != Role::External);
    EquilibriumReport {
        residual: found.residual.force,
        residual_scale: found.residual.scale,
        potential_energy: conservative.then_some(outcome.ledger.elastic + outcome.ledger.gravity),
        load_steps: found.load_steps,
        stability: found.stability,
        findings: found.findings.clone(),
        largest: at_rest.largest,
        reaction_sum: at_rest.reactions,
        slack_springs: at_rest.slack,
        idle_loads: Vec::new(),
        frequencies: modes.modes.iter().map(LowMode::frequency).collect(),
        modes_symmetric: (!modes.modes.is_empty()).then_some(modes.symmetric),
        growing: modes.growing.clone(),
    }
}
