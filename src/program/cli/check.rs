//! `canopy-fem check`: lists all faults, or recommends a method for an accuracy, by trial runs, and says what the case
//! itself costs and whether it is stable; with `--all` the model, each method's critical step and predicted run, too.
//! It writes no files.

use super::check_contact::{self, contact_limit, contacts, describe_contacts};
use super::check_json::{self, Report, Totals};
use super::check_system::{describe_canopies, describe_events, describe_size, describe_system, filled_canopies};
use super::known_models::KnownModels;
use super::{CheckArgs, CliError, check_static};
use crate::analysis::contact::surveys;
use crate::analysis::critical::{Confidence, CriticalStep, ElementBounds, outside_filter};
use crate::analysis::later::{LaterLimit, later_warning, least_later};
use crate::analysis::spectrum::Spectrum;
use crate::analysis::taut::{AllTaut, WhileSlack};
use crate::case::Case;
use crate::case::spec::{Problem, SystemSpec};
use crate::drive::clock::{Step, Tolerance};
use crate::format_number::{counted, figures};
use crate::integrate::registry::{Family, MethodChoice};
use crate::mesh::canopy::Canopy;
use crate::mesh::parachute::ParachuteParameters;
use crate::model::abilities::SpringDamping;
use crate::model::state::State;
use crate::model::stop::Stop;
use crate::output::largest::LargestValues;
use crate::process::{Stopwatch, cpu_seconds};
use crate::scene::{Scene, pass_events, place_with_groups};
use crate::simulation::{build_scene, check_solver, doubts_at_start};
use crate::study::StudyError;
use crate::study::accuracy::Accuracy;
use crate::study::forecast::memory::Baseline;
use crate::study::forecast::nominal::Budget;
use crate::study::forecast::{Candidate, ForecastSpec, describe, describe_answer, forecast, searches};
use crate::warning::Warning;
use serde::Deserialize;
use std::fmt::Write;

/// [-] Accuracy to recommend a run for, if neither the command nor the case has one.
const ACCURACY: f64 = 0.01;

pub(super) fn run(args: &CheckArgs) -> Result<String, CliError> {
    let case = Case::from_file_at_rest(&args.case.case, &args.case.with_quantities(&args.quantity))?;
    if args.expand {
        return check_json::expanded(&case);
    }
    if args.at_rest || case.is_at_rest() {
        return check_static::run(args, case);
    }
    if args.at.is_some() {
        let why = "--at is for --static, and for cases without a time section";
        return Err(StudyError::Usage(why.to_owned()).into());
    }
    let (models, mut problem, source) = KnownModels::of(case);
    let groups = problem.group_totals();
    let system = problem.take_system();
    let totals = Totals::of(&system);
    let size = describe_size(&system, totals.mass) + &describe_events(&system);
    let contacts = contacts(&system, &problem.case_json);
    let filled = filled_canopies(&system);
    let mut tables = String::new();
    describe_system(&mut tables, &system, &groups);
    describe_parachute(&mut tables, &problem, &system);
    totals.canopies.iter().for_each(|(name, sizes)| tables.push_str(&format!("  {name:<16}{sizes}\n")));
    // From here on the scene owns the data of the network.
    let scene = build_scene(system, args.threads.get())?;
    let (baseline, clock) = (Baseline::now(), Stopwatch::default());
    let built = cpu_seconds().unwrap_or(0.0);
    let scene = &*scene;
    let canopies = describe_canopies(scene, &filled);
    check_solver(&problem, scene, &source)?;
    // A quantity that is not there is a fault, even where no run is made that could measure it.
    LargestValues::new(scene, &problem.output, problem.time.end, None)
        .map_err(|why| StudyError::Usage(why.to_string()))?;
    describe_terms(&mut tables, scene);
    describe_method(&mut tables, &problem);
    let surveys = surveys(scene);
    let state = scene.initial_state();
    let budget = &Budget::of(scene, &problem, args.all || args.within.is_some());
    let all_taut = AllTaut::of(scene);
    let before = clock.seconds();
    let mut limits = Limits::of(scene, &state, budget);
    let searching = clock.seconds() - before;
    let candidates = candidates(&problem, scene, &mut limits);
    let run = problem.run_spec();
    let plan = run.planned(scene, Stop::NEVER);
    let limit = limits.critical_step(&problem.method);
    let allowed = || budget.affords_search(scene);
    let search = matches!(limits, Limits::Searched(_)).then_some(&allowed as &dyn Fn() -> bool);
    let later = least_later(plan, limit, search);
    drop(all_taut);
    let while_slack = WhileSlack::find(scene, state.as_ref(), limit, || {
        Limits::of(scene, &state, budget).critical_step(&problem.method)
    });
    let own = problem.time.step.tolerance().map(|tolerance| tolerance.relative);
    let accuracy = args.within.clone().unwrap_or(Accuracy::Relative(own.unwrap_or(ACCURACY)));
    let accuracy = &accuracy;
    let own_limit = candidates.iter().find(|c| c.method.info.name == problem.method.info.name);
    let searched = own_limit.is_some_and(|own| searches(scene, own, problem.time.step));
    let startup = built + if searched { searching } else { 0.0 };
    let fields = (&problem.output).into();
    let (candidates, all) = (&candidates[..], args.all);
    let spec = ForecastSpec { scene, problem: &problem, fields, candidates, accuracy, all, baseline, startup, budget };
    let forecast = forecast(&spec);
    // Trial runs have passed events.
    pass_events(scene, 0);
    let mut found = doubts_at_start(plan, &problem, limit, Some(&models.folder));
    found.extend(later_warning(plan, limit, later));
    let (acknowledged, warnings) = problem.sort_out(found);
    let words = |early: &[Warning], late: &[Warning]| early.iter().chain(late).map(Warning::to_string).collect();
    let acknowledged: Vec<String> = words(&problem.acknowledged, &acknowledged);
    let warnings: Vec<String> = words(&problem.warnings, &warnings);
    let own = candidates.iter().find(|candidate| candidate.method.info.name == problem.method.info.name);
    // A run that was too expensive to try is not one that fails.
    let fails = forecast.refused.as_deref().is_some_and(|why| why.starts_with("fails "));
    let linear_only = problem.method.info.linear.linear_only;
    let limit = own.and_then(|own| own.limit);
    let contact_limit = contact_limit(&problem.method, candidates, &surveys);
    let switching = undamped_switching(scene, plan.step, candidates);
    let stable = Stability { step: plan.step, limit, later, while_slack, fails, linear_only, switching }.answer();
    if args.print.json {
        return Report {
            problem: &problem,
            scene,
            candidates,
            stable: stable.0,
            later,
            while_slack,
            contacts: check_contact::in_json(&contacts, &surveys, (&problem.method, candidates)),
            contact_limit,
            forecast,
            totals,
            groups,
            models: models.answers,
            warnings,
            acknowledged,
        }
        .to_json();
    }
    if args.print.quiet {
        return Ok(String::new());
    }
    let stable = format!("{}: {}", stable.0, stable.1);
    let mut text = heading(&problem, &warnings)
        + &describe_answer(&problem, scene, &forecast, accuracy, &stable)?
        + &size
        + &describe_contacts(&contacts, &surveys)
        + &check_contact::describe_cost(forecast.force.contact)
        + &check_contact::describe_limit(contact_limit.as_ref(), &contacts, args.all)
        + &canopies
        + &problem.taken.iter().map(|what| format!("  taken           {what}\n")).collect::<String>()
        + &scene.added_mass().map_or_else(String::new, |added| format!("  mass scaling    {}\n", added.text()))
        + &models.describe(&args.case.case);
    let more = "--all: the model, its cost, and every method with its critical step";
    text.push_str(&notes(args, more, [&acknowledged, &warnings]));
    if args.all {
        tables.push_str(&describe(&problem, &forecast)?);
        describe_limits(&mut tables, &problem, scene, &limits, candidates);
        describe_later(&mut tables, &problem, scene, later);
        let _ = writeln!(text, "\n{}", tables.trim_end());
    }
    Ok(text)
}

/// What `--all` adds if it is not given, and the warnings.
pub(super) fn notes(args: &CheckArgs, more: &str, [acknowledged, warnings]: [&[String]; 2]) -> String {
    let mut text = if args.all { String::new() } else { format!("  more            {more}\n") };
    acknowledged.iter().for_each(|warning| text.push_str(&format!("acknowledged: {warning}\n")));
    warnings.iter().for_each(|warning| text.push_str(&format!("warning: {warning}\n")));
    text
}

/// The first line.
pub(super) fn heading(problem: &Problem, warnings: &[String]) -> String {
    let found = match warnings.len() {
        0 => String::new(),
        n => format!(", {} below", counted(n as u64, "warning", "warnings")),
    };
    format!("{}: no faults{found}\n", problem.name)
}

/// What is known of the stability of the case's step.
struct Stability {
    /// [s] `None` for adaptive steps
    step: Option<f64>,
    /// at the start; `None` where it is not known
    limit: Option<CriticalStep>,
    later: Option<LaterLimit>,
    while_slack: Option<WhileSlack>,
    /// whether the trial of the case's own run failed
    fails: bool,
    /// whether the method is known to be stable on linear scenes only, where it has no limit
    linear_only: bool,
    /// [rad] w h of the fastest motion, where springs go slack and nothing damps them
    switching: Option<f64>,
}

/// [rad] w h of the fastest motion of a scene whose springs go slack, with nothing that damps them, where a step jumps
/// over it. Verlet's limit is w h = 2.
fn undamped_switching(scene: &dyn Scene, step: Option<f64>, candidates: &[Candidate]) -> Option<f64> {
    let springs = scene.springs()?;
    if springs.damping() != SpringDamping::None || !springs.has_branches() {
        return None;
    }
    let verlet = candidates.iter().find(|candidate| candidate.method.info.name == "velocity-verlet")?;
    let wh = 2.0 * step? / verlet.limit?.step;
    (wh > 1.0 && wh.is_finite()).then_some(wh)
}

impl Stability {
    /// "yes", "no", "on linear scenes" or "not known", and why.
    fn answer(&self) -> (&'static str, String) {
        let Some(CriticalStep { step: critical, .. }) = self.limit else {
            let why = "the method is made for linear springs; other forces of this scene are outside of it";
            return ("not known", why.to_owned());
        };
        if critical == 0.0 {
            return ("no", "the method's energy grows at every step where nothing damps".to_owned());
        }
        if critical.is_infinite() {
            if let (false, true, Some(wh)) = (self.fails, self.linear_only, self.switching) {
                let why = format!(
                    "the method has no largest stable step there; springs go slack here, nothing damps them, and w h = {} for \
                     the fastest: expect it to make energy, which time.method=backward-euler does not",
                    figures(wh, 3)
                );
                return ("on linear scenes", why);
            }
            let (answer, why) = match (self.fails, self.linear_only) {
                (true, _) => ("no", "the trial run fails"),
                (false, true) => (
                    "on linear scenes",
                    "the method has no largest stable step there; where springs go slack or parts turn it may make energy",
                ),
                (false, false) => ("yes", "no largest stable step was found for this method"),
            };
            return (answer, why.to_owned());
        }
        let later = self.later.map(|LaterLimit { t, limit }| (limit.step, format!("from t = {} s on", figures(t, 4))));
        let at_start = match &self.while_slack {
            Some(slack) => format!("with all springs taut ({} while {} are slack)", slack.step(), slack.springs()),
            None => "at the start".to_owned(),
        };
        let (least, when) = match later {
            Some((step, when)) if step < critical => (step, when),
            _ => (critical, at_start),
        };
        let least_text = format!("the critical step, {} s {when}", figures(least, 3));
        match self.step {
            None if self.fails => ("no", format!("the trial run fails; {least_text}")),
            None => ("yes", format!("adaptive steps stay below {least_text}")),
            Some(step) if step > least => {
                ("no", format!("the step is {} times {least_text}", figures(step / least, 3)))
            }
            Some(step) => {
                let used = format!("the step is {} % of {least_text}", figures(100.0 * step / least, 2));
                if self.fails { ("no", format!("the trial run fails, although {used}")) } else { ("yes", used) }
            }
        }
    }
}

impl Totals {
    pub(super) fn of(system: &SystemSpec) -> Self {
        match system {
            SystemSpec::Network(spec) => {
                let found = Canopy::of_groups(&spec.mesh).into_iter();
                let canopies = found.filter_map(|(name, canopy)| Some((name, canopy.ok()?.sizes()))).collect();
                Totals { mass: spec.mass.iter().sum(), canopies }
            }
            SystemSpec::Pendulum(pendulum) => Totals { mass: pendulum.mass, canopies: Default::default() },
        }
    }
}

/// The source of the critical steps of methods.
enum Limits<'a> {
    Searched(Box<Spectrum<'a>>),
    Bounded(ElementBounds<'a>),
}

impl<'a> Limits<'a> {
    /// Uses a search, if the budget of the forecast allows it.
    fn of(scene: &'a dyn Scene, state: &'a State, budget: &Budget) -> Self {
        // Limits are those of explicit methods, in whose steps contact has a limited stiffness.
        scene.touches().into_iter().for_each(|touches| touches.set_explicit(true));
        match budget.affords_search(scene) {
            true => Limits::Searched(Box::new(Spectrum::of(scene, state.as_ref()))),
            false => Limits::Bounded(ElementBounds::of(scene, state.as_ref())),
        }
    }

    fn critical_step(&mut self, method: &MethodChoice) -> CriticalStep {
        match self {
            Limits::Searched(spectrum) => spectrum.critical_step(method),
            Limits::Bounded(bounds) => bounds.critical_step(method),
        }
    }
}

/// Every method with its critical step at the start; the method of the case has its own parameters.
fn candidates(problem: &Problem, scene: &dyn Scene, limits: &mut Limits<'_>) -> Vec<Candidate> {
    let known = |method: &MethodChoice| {
        let needs_network = method.info.family == Family::MatrixFree && scene.interfaces().graph.is_none();
        !needs_network && !outside_filter(method, scene)
    };
    let mut limit = |method: &MethodChoice| known(method).then(|| limits.critical_step(method));
    // Masses are scaled for explicit methods only.
    let fits = |method: &MethodChoice| scene.added_mass().is_none() || method.info.family == Family::Explicit;
    problem.method.among_all().filter(fits).map(|method| Candidate { limit: limit(&method), method }).collect()
}

/// The sizes of a mesh that is a generated parachute.
fn describe_parachute(text: &mut String, problem: &Problem, system: &SystemSpec) {
    let section = problem.case_json.pointer("/system/network/mesh/parachute");
    let parameters = section.and_then(|section| ParachuteParameters::deserialize(section).ok());
    if let (Some(parameters), SystemSpec::Network(spec)) = (parameters, system)
        && let Ok(lines) = parameters.describe_sizes(&spec.mesh)
    {
        lines.iter().for_each(|(what, line)| text.push_str(&format!("  {what:<16}{line}\n")));
    }
}

pub(super) fn describe_terms(text: &mut String, scene: &dyn Scene) {
    let mut names: Vec<&str> = Vec::new();
    for term in scene.terms() {
        if !names.contains(&term.name) {
            names.push(term.name);
        }
    }
    let _ = writeln!(text, "  forces          {}", names.join(", "));
}

fn describe_method(text: &mut String, problem: &Problem) {
    let _ = writeln!(
        text,
        "  method          {}, order {}, {}",
        problem.method.info.name,
        problem.method.order(),
        match problem.time.step {
            Step::Fixed(step) => format!("step {} s", figures(step, 12)),
            Step::Adaptive(Tolerance { relative, absolute }) =>
                format!("adaptive steps, tolerance {relative:e} of the motion and {absolute:e}"),
        }
    );
}

fn describe_limits(
    text: &mut String,
    problem: &Problem,
    scene: &dyn Scene,
    limits: &Limits<'_>,
    candidates: &[Candidate],
) {
    describe_rates(text, scene, limits);
    text.push_str("\n  critical steps [s], and the case's step over them:\n");
    text.push_str("  method             critical  step/critical  known by        set by\n");
    for Candidate { method, limit } in candidates {
        let name = method.info.name;
        if method.info.family == Family::MatrixFree && scene.interfaces().graph.is_none() {
            let _ = writeln!(text, "  {name:<19}needs a network");
            continue;
        }
        let mark = if name == problem.method.info.name { '*' } else { ' ' };
        let limit = match limit {
            Some(limit) => describe_limit(*limit, problem.time.step, scene),
            None => "not known: the method is made for linear springs; other forces of this scene are outside of it"
                .to_owned(),
        };
        let _ = writeln!(text, "{mark} {name:<19}{limit}");
    }
    text.push_str(
        "  (* the method of this case; all at t = 0 with slack springs taken as taut; certified: proved to be at most the true limit, and below it by no more than the width)\n\n",
    );
}

/// The critical step after an event, if it is smaller.
fn describe_later(text: &mut String, problem: &Problem, scene: &dyn Scene, later: Option<LaterLimit>) {
    let Some(LaterLimit { t, limit }) = later else { return };
    let _ = writeln!(
        text,
        "  from t = {} s on   {} (nodes where they are at t = 0)\n",
        figures(t, 6),
        describe_limit(limit, problem.time.step, scene)
    );
}

fn describe_rates(text: &mut String, scene: &dyn Scene, limits: &Limits<'_>) {
    let spectrum = match limits {
        Limits::Searched(spectrum) => spectrum,
        Limits::Bounded(ElementBounds { rates, .. }) => {
            let at = place_with_groups(scene, rates.frequency_dof);
            let _ = writeln!(
                text,
                "  fastest motion  w below {:.4e} rad/s around {at}, at t = 0, by bounds from the elements",
                rates.frequency
            );
            text.push_str(
                "                  (bounds only: a search would cost too large a part of the run; true limits may be longer)\n",
            );
            return;
        }
    };
    let rates = spectrum.rates();
    let bound = match spectrum.frequency_bound() {
        Some(bound) if bound <= rates.frequency * 1.0001 => "rad/s (proved)".to_owned(),
        Some(bound) => format!("to {bound:.4e} rad/s (proved)"),
        None => "rad/s (an estimate)".to_owned(),
    };
    let at = place_with_groups(scene, rates.frequency_dof);
    let _ = writeln!(text, "  fastest motion  w = {:.4e} {bound} around {at}, at t = 0", rates.frequency);
    if rates.damping > 0.0 {
        let at = place_with_groups(scene, rates.damping_dof);
        let _ = writeln!(text, "  most damped     {:.4e} 1/s (an estimate) around {at}", rates.damping);
    }
}

fn describe_limit(limit: CriticalStep, step: Step, scene: &dyn Scene) -> String {
    if limit.step.is_infinite() {
        return "none found".to_owned();
    }
    if limit.step == 0.0 {
        return "0: grows at every step without damping".to_owned();
    }
    let known = match (limit.confidence, limit.width()) {
        (Confidence::Certified { .. }, Some(width)) => format!("certified {:.1} %", 100.0 * width),
        _ => "estimate".to_owned(),
    };
    let used = step.fixed().map_or_else(
        || "adaptive".to_owned(),
        |step| figures(step / limit.step, 3) + if step > limit.step { " too large" } else { "" },
    );
    format!("{:<9.3e} {used:<14} {known:<15} {}", limit.step, place_with_groups(scene, limit.dof))
}
