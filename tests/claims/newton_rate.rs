//! Newton's iteration near the solution: every force term has the exact tangent, so that the residual of an implicit
//! step falls quadratically, |r_{k+1}| ~ C |r_k|^2 (Dennis & Schnabel 1983, Theorem 5.2.1), wherever no spring changes
//! between taut and slack. A wrong or missing entry of a tangent gives order 1.
//!
//! The residuals are those of the program's own iteration: a step that is refused after k iterations says what it
//! reached.

use crate::claim::Claim;
use crate::common::run::{asset, case_of, follow};
use crate::newton_cases::trials;
use canopy_fem::case::Case;
use canopy_fem::drive::Status;
use canopy_fem::integrate::stepper::Attempt;
use canopy_fem::integrate::{Counters, StepError};
use canopy_fem::model::point::Point;
use canopy_fem::simulation::{bind, build_scene};
use canopy_fem::solve::newton::NewtonFailure;

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    for trial in trials() {
        let case = case_of(&trial.case(), &[FULL]);
        let order = order(&residuals(&case, trial.step));
        // C differs between directions, which bends the estimate by some tenths.
        claims.push(Claim::between(format!("{}: order of the last three residuals", trial.name), order, 1.8, 2.3));
        claims.push(counts(trial.name, &case, trial.record));
    }
    for (name, record) in CLOTHS {
        let case = asset(name, &[("time.method", "newmark"), ("time.step", "1e-2"), ("time.end", "0.1"), FULL]);
        claims.push(counts(name, &case, record));
    }
    claims
}

/// Exact tangents.
const FULL: (&str, &str) = ("solver.newton.strategy", "full");

/// Newton iterations of ten steps of 10 ms, a digit a step: a change is a change of cost that somebody meant to make.
const CLOTHS: [(&str, &str); 4] = [
    ("cloth-k100", "2222222222"),
    ("cloth-k1000", "3322222222"),
    ("cloth-k10000", "3333233333"),
    ("cloth-k100000", "3333333333"),
];

fn counts(name: &str, case: &Case, record: &str) -> Claim {
    let mut found = String::new();
    let outcome = follow(case, |seen| {
        if seen.t > 0.0 {
            found += &seen.newton_iterations.to_string();
        }
    });
    assert_eq!(outcome.status, Status::Completed, "{name}");
    let differ = found.bytes().zip(record.bytes()).filter(|(a, b)| a != b).count() + found.len().abs_diff(record.len());
    let from_record = if differ == 0 { String::new() } else { format!(" (here {found})") };
    let what = format!("{name}: steps that do not take the Newton iterations on record, {record}{from_record}");
    Claim::absolute(what, differ as f64, 0.0, 0.0)
}

/// [N] norms of the residual of the first step at the first guess and after 1, 2, ... iterations, as long as they are
/// more than rounding.
fn residuals(case: &Case, h: f64) -> Vec<f64> {
    let mut problem = case.problem().clone();
    let scene = build_scene(problem.take_system(), 1).expect("the case is good");
    let mut start = Point { state: scene.initial_state(), forces: scene.new_forces() };
    scene.evaluate(start.state.as_ref(), &mut start.forces);
    let mut residuals = Vec::new();
    problem.solver.newton.relative = 0.0;
    for k in 0..20 {
        problem.solver.newton.max_iterations = k;
        let mut stepper = bind(&problem, &*scene).expect("the method fits the scene");
        stepper.start(&start).expect("a small scene");
        let attempt = Attempt { from: &start, h, t_next: h };
        match stepper.attempt(attempt, &mut start.clone(), &mut Counters::default()) {
            Ok(_) => break,
            Err(StepError::Newton(NewtonFailure::MaxIterations { residual, .. })) => residuals.push(residual),
            Err(error) => panic!("{error}"),
        }
    }
    let first = residuals.first().copied().unwrap_or(0.0);
    residuals.retain(|r| *r > ROUNDING * first);
    residuals
}

/// [-] Share of the first residual that may be rounding.
const ROUNDING: f64 = 1e-13;

/// log(r3/r2)/log(r2/r1) of the last three residuals, the first guess's not among them: it has its error elsewhere.
fn order(residuals: &[f64]) -> f64 {
    match residuals {
        [_, .., r1, r2, r3] => (r3 / r2).ln() / (r2 / r1).ln(),
        _ => f64::NAN,
    }
}
