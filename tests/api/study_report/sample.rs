//! Studies made by hand: rows as a run would leave them, from made-up laws of cost and error.

use canopy_fem::case::schema::Method;
use canopy_fem::integrate::Counters;
use canopy_fem::integrate::registry::Family;
use canopy_fem::study::Study;
use canopy_fem::study::pareto::mark_front;
use canopy_fem::study::plan::{Plan, Variant};
use canopy_fem::study::ranking::Ranking;
use canopy_fem::study::reference::ReferenceReport;
use canopy_fem::study::row::{Job, Row, RowStatus, RunResult, StepSetting, label};

/// What decides a made-up method's rows.
pub struct Law {
    pub method: Method,
    pub family: Family,
    pub order: i32,
    /// [s] stability limit
    pub limit: f64,
    /// [s] a step
    pub cost: f64,
}

pub fn method(name: &str, parameters: &[(&str, f64)]) -> Method {
    Method { name: name.to_owned(), parameters: parameters.iter().map(|(k, v)| ((*k).to_owned(), *v)).collect() }
}

/// The methods of the program with about their orders and limits.
pub fn laws() -> Vec<Law> {
    let explicit = [
        ("explicit-euler", 1, 2e-4, 1.0),
        ("euler-cromer", 1, 2e-3, 1.0),
        ("euler-richardson", 2, 1e-3, 2.0),
        ("improved-euler", 2, 1e-3, 2.1),
        ("improved-euler-pec", 2, 1.1e-3, 1.3),
        ("velocity-verlet", 2, 2e-3, 1.05),
        ("beeman", 3, 1.7e-3, 1.1),
        ("rk4", 4, 2.8e-3, 4.0),
        ("dormand-prince", 5, 3.3e-3, 6.0),
        ("dop853", 8, 6.1e-3, 12.0),
    ];
    let implicit = [("newmark", 2), ("backward-euler", 1), ("generalized-alpha", 2)];
    let mut laws: Vec<Law> = explicit
        .map(|(name, order, limit, cost)| Law {
            method: method(name, &[]),
            family: Family::Explicit,
            order,
            limit,
            cost: 1e-5 * cost,
        })
        .into();
    let unlimited = |method, family, order, cost| Law { method, family, order, limit: f64::INFINITY, cost };
    laws.push(unlimited(method("kang", &[]), Family::MatrixFree, 1, 4e-5));
    laws.extend(implicit.map(|(name, order)| unlimited(method(name, &[]), Family::Implicit, order, 8e-4)));
    laws.push(unlimited(method("hht", &[("alpha", -0.2)]), Family::Implicit, 2, 9e-4));
    laws
}

/// The rows of a study with these methods on springs so many times as stiff.
pub fn rows(laws: &[Law], variant: usize, factor: f64, status: Option<RowStatus>) -> Vec<Row> {
    let mut rows = Vec::new();
    for law in laws {
        let limit = law.limit / factor.sqrt();
        let first = if limit.is_finite() { 2.0 * limit } else { 0.04 };
        let fixed = (0..6).map(|k| StepSetting::Step(first * 0.5f64.powi(k)));
        let adaptive = (2..7).filter(|_| law.order > 1).map(|k| StepSetting::Tolerance(10f64.powi(-k)));
        for (number, setting) in fixed.chain(adaptive).enumerate() {
            let h = match setting {
                StepSetting::Step(h) => h,
                StepSetting::Tolerance(t) => (0.9 * limit).min(0.05 * t.powf(1.0 / f64::from(law.order))),
            };
            let ended = status.unwrap_or(if h > limit { RowStatus::Diverged } else { RowStatus::Completed });
            rows.push(row(
                law,
                Job {
                    id: format!("v{variant}-{}-{number}", label(&law.method)),
                    variant,
                    model: None,
                    method: law.method.clone(),
                    setting,
                },
                h,
                ended,
            ));
        }
    }
    rows
}

fn row(law: &Law, job: Job, h: f64, status: RowStatus) -> Row {
    let steps = (1.0 / h).ceil();
    let share = if status == RowStatus::Completed { 1.0 } else { 0.03 };
    let ran = matches!(status, RowStatus::Completed | RowStatus::Diverged | RowStatus::NotConverged);
    let seconds = law.cost * steps * share;
    // Beyond a trillionth rounding is all there is.
    let error = ((h / 0.03).powi(law.order) + 3e-12).min(3.0);
    let errors = (status == RowStatus::Completed).then_some(error);
    let implicit = law.family == Family::Implicit;
    let count = if ran { (steps * share) as u64 } else { 0 };
    let counters = Counters {
        force_evaluations: count * (law.cost / 1e-5).min(12.0) as u64,
        tangent_assemblies: if implicit { 3 * count } else { 0 },
        factorizations: if implicit { count } else { 0 },
        lu_factorizations: 0,
        linear_solves: if implicit { 3 * count } else { 0 },
        newton_iterations: if implicit { 3 * count } else { 0 },
        cg_iterations: 0,
        sweeps: 0,
    };
    let measured = RunResult {
        status,
        note: match status {
            RowStatus::Completed => String::new(),
            _ => format!("at t = {:.4e} s: made up; take a smaller step than {h}", 0.03),
        },
        error: errors,
        error_max: errors.map(|e| 1.7 * e),
        energy_error: ran.then_some(0.1 * error),
        repeats: if ran { vec![0.98 * seconds, seconds, 1.1 * seconds] } else { Vec::new() },
        steps: count,
        t_end: share,
        counters,
        ..RunResult::default()
    };
    Row { job, family: law.family, measured, cpu_seconds: ran.then_some(seconds), pareto: false }
}

/// A study of these rows; one variant a factor.
pub fn study(name: &str, factors: &[f64], laws: &[Law], status: Option<RowStatus>) -> Study {
    let mut plan = Plan {
        format: 1,
        program: env!("CARGO_PKG_VERSION").to_owned(),
        name: name.to_owned(),
        case_file: "cases/sample.json".to_owned(),
        case: serde_json::json!({
            "name": name,
            "system": {"network": {"mesh": {"annulus": {"nodes": 703}}, "gravity": [0, 0, -9.81], "springs": [{"on": "all", "stiffness": 1000.0, "slack": "tension-only"}]}},
            "time": {"end": 1.0, "method": "newmark", "step": 0.01}
        }),
        ..Plan::default()
    };
    plan.asked.repeat = 3;
    let mut all = Vec::new();
    for (number, factor) in factors.iter().enumerate() {
        let mut reference = ReferenceReport {
            how: "dop853 at tolerance 1e-13 against dormand-prince at 1e-12".to_owned(),
            error: 2.3e-9,
            error_max: 6e-9,
            cpu_seconds: Some(3.2),
            ..ReferenceReport::default()
        };
        reference.motion.frames = 50;
        reference.motion.largest = 0.37;
        reference.counters.force_evaluations = 240_000;
        let limits = laws.iter().filter(|l| l.limit.is_finite()).map(|l| (label(&l.method), l.limit / factor.sqrt()));
        plan.variants.push(Variant {
            stiffness_factor: *factor,
            every: 0.02,
            end: 1.0,
            critical_steps: limits.collect(),
            reference,
            ..Variant::default()
        });
        all.extend(rows(laws, number, *factor, status));
    }
    plan.jobs = all.iter().map(|row| row.job.clone()).collect();
    for number in 0..factors.len() {
        mark_front(&mut all, number, &Ranking::of(&plan, number));
    }
    Study { plan, rows: all }
}

/// Keeps some rows, with other ends for them.
pub fn with_ends(mut study: Study, ends: &[RowStatus]) -> Study {
    for (row, status) in study.rows.iter_mut().zip(ends) {
        row.measured.status = *status;
        if *status == RowStatus::Completed {
            continue;
        }
        (row.measured.error, row.measured.error_max, row.pareto) = (None, None, false);
        row.measured.note = format!("because of {}", status.word());
        if matches!(status, RowStatus::Refused | RowStatus::NotRun) {
            row.cpu_seconds = None;
            row.measured.repeats.clear();
            row.measured.counters = Default::default();
        }
    }
    study.rows.truncate(ends.len());
    study
}

pub fn some_laws(names: &[&str]) -> Vec<Law> {
    laws().into_iter().filter(|law| names.contains(&law.method.name.as_str())).collect()
}
