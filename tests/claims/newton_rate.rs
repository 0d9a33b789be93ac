//! Newton's iteration near the solution: every force term has the exact tangent, so that the residual of an implicit step falls
//! quadratically, |r_{k+1}| ~ C |r_k|^2 (Dennis & Schnabel 1983, Theorem 5.2.1), wherever no spring changes between taut and
//! slack. A wrong or missing entry of a tangent gives order 1.
//!
//! The residuals are those of the program's own iteration: a step that is refused after k iterations says what it reached.

use crate::claim::Claim;
use crate::common::run::{asset, case_of, follow};
use canopy_fem::case::Case;
use canopy_fem::drive::Status;
use canopy_fem::integrate::stepper::Attempt;
use canopy_fem::integrate::{Counters, StepError};
use canopy_fem::model::point::Point;
use canopy_fem::simulation::{bind, build_scene};
use canopy_fem::solve::newton::NewtonFailure;
use serde_json::{Value, json};

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    for (name, case) in cases() {
        let residuals = residuals(&case_of(&case, &[]));
        claims.push(Claim::between(format!("{name}: order of the last three residuals"), order(&residuals), 1.8, 2.3));
    }
    for (name, recorded) in CLOTHS {
        let case = asset(name, &[("time.method", "newmark"), ("time.step", "1e-2"), ("time.end", "0.1")]);
        claims.push(counts(name, &case, recorded));
    }
    assert_eq!(cases().len(), SHEETS.len());
    for ((name, case), recorded) in cases().into_iter().zip(SHEETS) {
        claims.push(counts(name, &case_of(&case, &[("time.step", "0.01"), ("time.end", "0.1")]), recorded));
    }
    claims
}

/// Newton iterations of ten steps of 10 ms, a digit a step: a change is a change of cost that somebody meant to make.
const CLOTHS: [(&str, &str); 4] = [
    ("cloth-k100", "2222222222"),
    ("cloth-k1000", "3222222222"),
    ("cloth-k10000", "3333233333"),
    ("cloth-k100000", "3333333333"),
];

/// The same for the sheets of [`cases`], in their order.
const SHEETS: [&str; 15] = [
    "2222222232",
    "2222222222",
    "2222222222",
    "1111111111",
    "2222222332",
    "2222222222",
    "2222222222",
    "2222222222",
    "2222222222",
    "2222222222",
    "2222222222",
    "2222222222",
    "2222222222",
    "2222222232",
    "2222222222",
];

fn counts(name: &str, case: &Case, recorded: &str) -> Claim {
    let mut found = String::new();
    let outcome = follow(case, |seen| {
        if seen.t > 0.0 {
            found += &seen.newton_iterations.to_string();
        }
    });
    assert_eq!(outcome.status, Status::Completed, "{name}");
    let differ =
        found.bytes().zip(recorded.bytes()).filter(|(a, b)| a != b).count() + found.len().abs_diff(recorded.len());
    let what = format!("{name}: iterations of ten steps {found}, steps off the record");
    Claim::absolute(what, differ as f64, 0.0, 0.0)
}

/// A sheet of 3 x 3 nodes with diagonals, held at a corner and bent out of its plane by up to a fifth of its springs' length.
fn sheet(step: f64, system: Value) -> Value {
    let wave = |i: i32, c: i32| 0.1 * (f64::from(7 * i + 5 * c)).sin();
    let displacement: Vec<Value> = (0..9).map(|i| json!([wave(i, 0), wave(i, 1), 2.0 * wave(i, 2)])).collect();
    let velocity: Vec<Value> = (0..9).map(|i| json!([5.0 * wave(i, 3), 5.0 * wave(i, 4), 5.0 * wave(i, 5)])).collect();
    let mut network = json!({
        "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": 2, "rows": 2}},
        "mass": {"nodal": [0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.65, 0.7]},
        "initial": {"displacement": displacement, "velocity": velocity}
    });
    for (key, value) in system.as_object().expect("sections") {
        network[key] = value.clone();
    }
    json!({
        "name": "sheet",
        "system": {"network": network},
        "time": {"end": 1.0, "method": "newmark", "step": step}
    })
}

/// Every term, alone where it is not linear alone, in a state away from all kinks.
fn cases() -> Vec<(&'static str, Value)> {
    let springs = |rest_scale: f64, more: Value| {
        let mut rule = json!({"on": "all", "stiffness": 80.0, "rest_scale": rest_scale});
        for (key, value) in more.as_object().expect("keys") {
            rule[key] = value.clone();
        }
        json!([rule])
    };
    let taut = springs(0.5, json!({}));
    let axial = json!({"axial": {"coefficient": 3.0}});
    let relative = json!({"relative": {"coefficient": 8.0}});
    let air = |law: Value| json!({"wind": [3.0, -2.0, 25.0], "law": law});
    let ergun = json!({"ergun": {"porosity": 0.9, "pore_diameter": 1e-4, "thickness": 1e-4, "air_density": 1.225, "air_viscosity": 1.81e-5}});
    let table = json!([[0.0, 1.0], [1.0, 2.0]]);
    let follower = json!([{"on": "all", "pressure": 600.0, "kind": "follower", "table": table}]);
    let dead = json!([
        {"on": "all", "pressure": 60.0, "kind": "dead", "direction": [0, 0.6, 0.8], "table": table},
        {"on": {"ids": [3]}, "force": [5, -4, 3]}
    ]);
    let rayleigh = json!({"rayleigh": {"mass": 2.0, "stiffness": 0.05}});
    vec![
        ("taut springs", 0.05, json!({"springs": taut})),
        ("tension-only springs, taut", 0.05, json!({"springs": springs(0.5, json!({"slack": "tension-only"}))})),
        ("springs beyond a dead zone", 0.05, json!({"springs": springs(0.5, json!({"slack": {"dead_zone": 0.02}}))})),
        (
            "springs at their compression limit",
            0.12,
            json!({"springs": springs(2.0, json!({"slack": {"compression_limit": 0.1}}))}),
        ),
        (
            "springs pushed within their limit",
            0.06,
            json!({"springs": springs(1.6, json!({"slack": {"compression_limit": 2.0}}))}),
        ),
        ("axial dashpots on springs", 0.05, json!({"springs": springs(0.5, json!({"dashpot": axial}))})),
        (
            "axial dashpots on tension-only springs",
            0.05,
            json!({"springs": springs(0.3, json!({"dashpot": axial, "slack": "tension-only"}))}),
        ),
        ("relative dashpots on springs", 0.1, json!({"springs": springs(0.5, json!({"dashpot": relative}))})),
        ("Rayleigh damping on springs", 0.05, json!({"springs": taut, "damping": rayleigh})),
        ("Ergun air", 0.1, json!({"springs": [], "aero": air(ergun.clone())})),
        (
            "air by permeability",
            0.05,
            json!({"springs": [], "aero": air(json!({"permeable": {"a": 2e4, "b": 5e2, "thickness": 1e-3}}))}),
        ),
        (
            "air by pressure coefficient",
            0.06,
            json!({"springs": [], "aero": air(json!({"pressure_coefficient": {"cp": 1.2, "air_density": 1.225}}))}),
        ),
        ("follower pressure", 0.05, json!({"springs": [], "loads": follower})),
        (
            "dead pressure, force and gravity on springs",
            0.05,
            json!({"springs": taut, "loads": dead, "gravity": [0, 0, -9.81]}),
        ),
        (
            "everything at once",
            0.05,
            json!({
                "springs": [
                    {"on": "boundary", "stiffness": 80.0, "rest_scale": 0.3, "dashpot": axial, "slack": "tension-only"},
                    {"on": "all", "stiffness": 60.0, "rest_scale": 0.5, "dashpot": relative}
                ],
                "aero": air(ergun), "loads": follower, "gravity": [0, 0, -9.81], "damping": rayleigh
            }),
        ),
    ]
    .into_iter()
    .map(|(name, step, system)| (name, sheet(step, system)))
    .collect()
}

/// [N] norms of the residual of the first step at the first guess and after 1, 2, ... iterations, as long as they are more
/// than rounding.
fn residuals(case: &Case) -> Vec<f64> {
    let mut problem = case.problem().clone();
    let scene = build_scene(problem.take_system(), 1).expect("the case is good");
    let mut start = Point { state: scene.initial_state(), forces: scene.new_forces() };
    scene.evaluate(start.state.as_ref(), &mut start.forces);
    let h = problem.time.step;
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

/// log(r3/r2)/log(r2/r1) of the last three residuals.
fn order(residuals: &[f64]) -> f64 {
    match residuals {
        [_, .., r1, r2, r3] => (r3 / r2).ln() / (r2 / r1).ln(),
        _ => f64::NAN,
    }
}
