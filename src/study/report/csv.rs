//! `tradeoff.csv` and `stiffness.csv`.

use crate::case::schema::Method;
use crate::output::sanitize::csv_field;
use crate::study::recommendations::{Pick, Recommendations};
use crate::study::row::{Row, StepSetting};
use crate::study::runner::Study;

/// Columns of `tradeoff.csv`, with the text of a run's cell; other programs rely on them.
type Column = (&'static str, fn(&Row) -> String);
const COLUMNS: [Column; 13] = [
    ("method", |row| csv_field(&typed(&row.job.method))),
    ("step", |row| match row.job.setting {
        StepSetting::Step(h) => number(Some(h)),
        StepSetting::Tolerance(_) => String::new(),
    }),
    ("tolerance", |row| match row.job.setting {
        StepSetting::Step(_) => String::new(),
        StepSetting::Tolerance(tolerance) => number(Some(tolerance)),
    }),
    ("status", |row| row.measured.status.word().to_owned()),
    ("error", |row| number(row.measured.error)),
    ("error_max", |row| number(row.measured.error_max)),
    ("energy_error", |row| number(row.measured.energy_error)),
    ("cpu_seconds", |row| number(row.cpu_seconds)),
    ("force_evaluations", |row| row.measured.counters.force_evaluations.to_string()),
    ("tangent_assemblies", |row| row.measured.counters.tangent_assemblies.to_string()),
    ("factorizations", |row| row.measured.counters.factorizations.to_string()),
    ("linear_solves", |row| row.measured.counters.linear_solves.to_string()),
    ("pareto", |row| row.pareto.to_string()),
];

/// Columns of `stiffness.csv`.
const STIFFNESS: &str = "stiffness_factor,wanted,explicit,explicit_cpu_seconds,implicit,implicit_cpu_seconds";

/// One row a run, in the plan's order; the factor on the stiffness goes before it where there are several.
pub(super) fn tradeoff(study: &Study) -> String {
    let sweep = study.plan.variants.len() > 1;
    let head = sweep.then_some("stiffness_factor").into_iter().chain(COLUMNS.map(|(name, _)| name));
    let mut text = head.collect::<Vec<_>>().join(",") + "\n";
    for row in &study.rows {
        let factor = sweep.then(|| number(study.plan.variant_of(&row.job).map(|v| v.stiffness_factor)));
        let cells = factor.into_iter().chain(COLUMNS.map(|(_, cell)| cell(row)));
        text += &(cells.collect::<Vec<_>>().join(",") + "\n");
    }
    text
}

/// A method as `--method` takes it: its name, or a JSON object where parameters were given.
fn typed(method: &Method) -> String {
    if method.parameters.is_empty() { method.name.clone() } else { serde_json::json!(method).to_string() }
}

/// The shortest number that reads back as the same; nothing for none.
fn number(value: Option<f64>) -> String {
    value.filter(|v| v.is_finite()).map(|v| format!("{v:?}")).unwrap_or_default()
}

/// One row an accuracy and factor.
pub(super) fn stiffness(answers: &Recommendations) -> String {
    let pick = |pick: &Option<Pick>| match pick {
        Some(pick) => format!("{},{}", csv_field(&pick.setting.of(&pick.method)), number(Some(pick.cpu_seconds))),
        None => ",".to_owned(),
    };
    let lines = answers.stiffness.iter().map(|point| {
        let (explicit, implicit) = (pick(&point.explicit), pick(&point.implicit));
        format!("{:?},{:?},{explicit},{implicit}\n", point.stiffness_factor, point.wanted)
    });
    format!("{STIFFNESS}\n") + &lines.collect::<String>()
}
