//! `canopy-fem check` of a case without a `time` section, or with `--static`: what `canopy-fem static` costs, and what
//! is determined, by a search within a time. It writes no files.

use super::check::{describe_terms, notes};
use super::check_contact::{contacts, describe_contacts};
use super::check_json::Totals;
use super::check_system::{describe_size, describe_system};
use super::{CheckArgs, CliError};
use crate::case::Case;
use crate::drive::observer::ObserveError;
use crate::format_number::{counted, figures};
use crate::model::stop::Stop;
use crate::process::Stopwatch;
use crate::scene::Scene;
use crate::simulation::{build_scene, check_solver, idle_loads, static_spec, warnings_at_rest};
use crate::statics::{self, Equilibrium, Stability, StaticFailure, Watcher};
use serde_json::json;
use std::fmt::Write;
use std::sync::atomic::{AtomicBool, Ordering};

/// [s] Time on the clock after which a search is given up.
const SEARCH: f64 = 2.0;

/// What a search has shown.
struct Trial {
    found: Equilibrium,
    /// [s] on the clock
    seconds: f64,
    /// whether it was given up
    given_up: bool,
}

impl Trial {
    fn of(scene: &dyn Scene, spec: statics::StaticSpec) -> Self {
        let (clock, stop) = (Stopwatch::default(), AtomicBool::new(false));
        let watch = |_| stop.store(clock.seconds() > SEARCH, Ordering::Relaxed);
        let found = statics::find_watched(scene, spec, Stop::on(&stop), Watcher(&watch));
        let given_up = found.failure == Some(StaticFailure::Interrupted);
        Trial { found, seconds: clock.seconds(), given_up }
    }

    /// "found", "not found" or "not known".
    fn answer(&self) -> &'static str {
        match (&self.found.failure, self.given_up) {
            (None, _) => "found",
            (_, true) => "not known",
            _ => "not found",
        }
    }

    /// Whether there is an equilibrium, what it takes, and what is determined, in lines.
    fn describe(&self) -> String {
        let Trial { found, seconds, given_up } = self;
        let iterations = found.counters.newton_iterations;
        let each = seconds / iterations.max(1) as f64;
        let searched =
            format!("{} in {} s", counted(iterations, "Newton iteration", "Newton iterations"), figures(*seconds, 2));
        let answer = match &found.failure {
            None => format!("found, after {searched}; canopy-fem static does the same and writes it"),
            Some(_) if *given_up => format!(
                "not known: given up after {searched}, {} s each, with {} N of {} N left; canopy-fem static goes on",
                figures(each, 2),
                figures(found.residual.force, 2),
                figures(found.residual.scale, 2)
            ),
            Some(failure) => format!("not found: {failure}\n  advice          {}", failure.advice()),
        };
        let mut text = format!("  equilibrium     {answer}\n");
        if let Some(linear) = &found.linear {
            let factor = linear.factor_nonzeros.map_or_else(String::new, |n| format!(", {n} in its factor"));
            let entries = counted(linear.matrix_nonzeros as u64, "entry", "entries");
            let _ = writeln!(text, "  matrix          {entries}{factor} ({})", linear.name);
        }
        let stability = match found.stability {
            _ if found.failure.is_some() => return text,
            Some(Stability::Stable) => "all free nodes; stable",
            Some(Stability::Neutral) => "not all of it: some motion meets no resistance",
            Some(Stability::Unstable) => "unstable: a small disturbance grows",
            None => "not judged: the tangent is not symmetric",
        };
        let slack = found.findings.iter().any(|finding| finding.kind == statics::FindingKind::Slack);
        let stability =
            if slack && found.stability == Some(Stability::Stable) { "all but what is slack" } else { stability };
        let _ = writeln!(text, "  determined      {stability}");
        found.findings.iter().for_each(|finding| _ = writeln!(text, "                  {}", finding.text));
        text
    }
}

pub(super) fn run(args: &CheckArgs, case: Case) -> Result<String, CliError> {
    let (mut problem, source) = case.split();
    let groups = problem.group_totals();
    let system = problem.take_system();
    let totals = Totals::of(&system);
    let size = describe_size(&system, totals.mass) + &describe_contacts(&contacts(&system, &problem.case_json), &[]);
    let mut tables = String::new();
    describe_system(&mut tables, &system, &groups);
    let scene = build_scene(system.with_real_masses(), args.threads.get())?;
    check_solver(&problem, &*scene, &source)?;
    describe_terms(&mut tables, &*scene);
    let at = args.at.unwrap_or(0.0);
    let trial = Trial::of(&*scene, static_spec(&problem, at, 1));
    let idle = idle_loads(&problem, &*scene, at);
    let warnings: Vec<String> = warnings_at_rest(&problem).map(ToString::to_string).collect();
    let acknowledged: Vec<String> = problem.acknowledged.iter().map(ToString::to_string).collect();
    if args.print.json {
        let Trial { found, seconds, .. } = &trial;
        let report = json!({
            "name": problem.name,
            "method": "static",
            "unknowns": scene.inverse_mass().iter().filter(|m| **m > 0.0).count(),
            "nodes": scene.reference().len(),
            "mass": totals.mass,
            "groups": groups,
            "symmetric": scene.symmetric(),
            "equilibrium": trial.answer(),
            "seconds": seconds,
            "newton_iterations": found.counters.newton_iterations,
            "load_steps": found.load_steps,
            "at": at,
            "idle_loads": idle,
            "matrix_nonzeros": found.linear.map(|linear| linear.matrix_nonzeros),
            "factor_nonzeros": found.linear.and_then(|linear| linear.factor_nonzeros),
            "stability": found.stability,
            "findings": found.findings,
            "failure": found.failure.as_ref().filter(|_| !trial.given_up).map(ToString::to_string),
            "warnings": warnings,
            "acknowledged": acknowledged,
            "version": env!("CARGO_PKG_VERSION"),
        });
        let write = |e: serde_json::Error| ObserveError::Write { path: "standard output".to_owned(), source: e.into() };
        return Ok(serde_json::to_string_pretty(&report).map_err(write)? + "\n");
    }
    if args.print.quiet {
        return Ok(String::new());
    }
    let mut text = super::check::heading(&problem, &warnings) + &trial.describe();
    idle.iter().for_each(|load| _ = writeln!(text, "  not acting      {load}"));
    text.push_str(&size);
    text.push_str(&notes(args, "--all: the model", [&acknowledged, &warnings]));
    if args.all {
        let _ = writeln!(text, "\n{}", tables.trim_end());
    }
    Ok(text)
}
