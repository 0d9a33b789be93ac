//! `tradeoff.html`: one page that needs nothing beside it.

use serde::Serialize;

use super::figure::Figure;
use super::machine::{Machine, Rerun};
use super::table::{self, Table, short};
use super::{case, csv};
use crate::format_number::figures;
use crate::integrate::Counters;
use crate::study::error::StudyError;
use crate::study::plan::{PROGRAM, Variant};
use crate::study::recommendations::{Pick, Recommendation, Recommendations, unfinished};
use crate::study::row::RowStatus;
use crate::study::runner::Study;

/// The page's template. Its name ends in html: everything put into it is escaped.
const TEMPLATE: (&str, &str) = ("tradeoff.html", include_str!("page.html"));

/// All that the template shows.
#[derive(Serialize)]
struct Page<'a> {
    name: &'a str,
    version: &'a str,
    case_words: Vec<String>,
    counts: String,
    failures: String,
    variants: Vec<Section>,
    stiffness: Vec<String>,
    figures: Vec<Shown<'a>>,
    runs: Table,
    repeat: u32,
    case_file: &'a str,
    case_json: String,
    command: &'a str,
    machine: Vec<(&'static str, String)>,
    date: Option<&'a str>,
}

/// What is said of a variant.
#[derive(Serialize)]
struct Section {
    /// empty for a study of one variant
    heading: String,
    sentences: Vec<String>,
    crossover: String,
    answers: Vec<[String; 9]>,
    reference: Reference,
    limits: Vec<(String, String)>,
}

/// What the reference is worth.
#[derive(Serialize)]
struct Reference {
    how: String,
    error: String,
    error_max: String,
    cost: String,
    largest: String,
}

/// A figure with its caption.
#[derive(Serialize)]
struct Shown<'a> {
    file: &'a str,
    svg: &'a str,
    caption: &'static str,
}

/// The page.
///
/// # Errors
/// What the template engine refuses.
pub(super) fn html(
    study: &Study,
    answers: &Recommendations,
    how: &Rerun,
    figures: &[Figure],
) -> Result<String, StudyError> {
    let plan = &study.plan;
    let refused = |e: minijinja::Error| StudyError::Page(e.to_string());
    let case_json = serde_json::to_string_pretty(&plan.case).map_err(|e| StudyError::Page(e.to_string()))?;
    let completed = study.rows.iter().filter(|row| row.measured.status == RowStatus::Completed).count();
    let page = Page {
        name: &plan.name,
        version: PROGRAM,
        case_words: case::words(plan),
        counts: format!("{completed} of {} runs reached their end", study.rows.len()),
        failures: unfinished(&study.rows),
        variants: plan.variants.iter().enumerate().map(|(i, variant)| section(study, answers, i, variant)).collect(),
        stiffness: answers.stiffness_crossovers.iter().map(|c| sentence(&c.sentence)).collect(),
        figures: figures.iter().map(|f| Shown { file: f.file, svg: &f.svg, caption: caption(f.file) }).collect(),
        runs: table::runs(study)?,
        repeat: plan.asked.repeat,
        case_file: &plan.case_file,
        case_json,
        command: &how.command,
        machine: account(&how.machine),
        date: how.machine.date.as_deref(),
    };
    let mut templates = minijinja::Environment::new();
    templates.set_undefined_behavior(minijinja::UndefinedBehavior::Strict);
    templates.add_template(TEMPLATE.0, TEMPLATE.1).map_err(refused)?;
    templates.get_template(TEMPLATE.0).and_then(|template| template.render(&page)).map_err(refused)
}

fn section(study: &Study, answers: &Recommendations, number: usize, variant: &Variant) -> Section {
    let own: Vec<&Recommendation> = answers.targets.iter().filter(|a| a.variant == number).collect();
    let mut sentences: Vec<String> = own.iter().map(|a| sentence(&a.sentence)).collect();
    if sentences.is_empty() {
        sentences.push("No run of this study reached an error of 0.1 or less.".to_owned());
    }
    let crossover = answers.crossovers.iter().find(|c| c.variant == number);
    let limits = variant.critical_steps.iter().map(|(method, h)| (method.clone(), short(*h, 4)));
    let heading = match study.plan.variants.len() {
        1 => String::new(),
        _ => format!("{} times the stiffness", figures(variant.stiffness_factor, 4)),
    };
    let account = &variant.reference;
    let reference = Reference {
        how: format!("By {}.", account.how),
        error: short(account.error, 2),
        error_max: short(account.error_max, 2),
        cost: work(&account.counters, account.cpu_seconds),
        largest: figures(account.motion.largest, 3),
    };
    Section {
        heading,
        sentences,
        crossover: crossover.map(|c| sentence(&c.sentence)).unwrap_or_default(),
        answers: own.into_iter().map(|a| answer(a, account.error)).collect(),
        reference,
        limits: limits.collect(),
    }
}

/// Wanted accuracy; method, pace, error (not shown below `floor`) and cost of the best; the next one and its factor;
/// the best of each family.
fn answer(answer: &Recommendation, floor: f64) -> [String; 9] {
    let Recommendation { wanted, best, next, explicit, implicit, .. } = answer;
    let factor = |pick: &Pick| format!("{} ×", figures(pick.cpu_seconds / best.cpu_seconds, 2));
    let told = |pick: &Option<Pick>| pick.as_ref().map(csv::used).unwrap_or_else(|| "–".to_owned());
    let cost = |pick: &Option<Pick>| match pick {
        Some(pick) => format!("{}: {} s", csv::used(pick), short(pick.cpu_seconds, 2)),
        None => "none".to_owned(),
    };
    let (kind, value) = match best.pace {
        crate::study::row::Pace::Step(h) => ("step", short(h, 4)),
        crate::study::row::Pace::Tolerance(t) => ("tolerance", short(t, 4)),
    };
    [
        format!("{wanted:e}"),
        best.method.clone(),
        format!("{kind} {value}"),
        if best.error < floor { format!("<{}", short(floor, 2)) } else { short(best.error, 2) },
        short(best.cpu_seconds, 2),
        told(next),
        next.as_ref().map(factor).unwrap_or_default(),
        cost(explicit),
        cost(implicit),
    ]
}

/// With a capital letter and a full stop.
fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first: String = letters.next().map(|c| c.to_uppercase().collect()).unwrap_or_default();
    let stop = if text.is_empty() || text.ends_with(['.', '!', '?']) { "" } else { "." };
    format!("{first}{}{stop}", letters.as_str())
}

fn work(counters: &Counters, seconds: Option<f64>) -> String {
    let Counters { force_evaluations, factorizations, .. } = counters;
    let seconds = seconds.map(|s| format!("{} s of processor time, ", short(s, 2))).unwrap_or_default();
    let matrices = if *factorizations > 0 { format!(", {factorizations} factorisations") } else { String::new() };
    format!("{seconds}{force_evaluations} force evaluations{matrices}")
}

fn account(machine: &Machine) -> Vec<(&'static str, String)> {
    let gib = |bytes: u64| format!("{:.1} GiB", bytes as f64 / 1024f64.powi(3));
    let vectors = Some(machine.vectors.join(", ")).filter(|v| !v.is_empty());
    let known = [
        ("processor", machine.processor.clone()),
        ("vector instructions", vectors),
        ("threads at once", machine.cores.map(|n| n.to_string())),
        ("memory", machine.memory_bytes.map(gib)),
        ("system", Some(machine.system.clone()).filter(|s| !s.is_empty())),
    ];
    known.into_iter().filter_map(|(name, value)| Some((name, value?))).collect()
}

fn caption(file: &str) -> &'static str {
    match file {
        "tradeoff.svg" => {
            "Work-precision diagram. Left is more accurate, down is cheaper. The staircase is the Pareto front: no run is below it. \
             Errors are not told below that of the reference. Runs without a result stand in the strip at the right, at what they \
             had cost when they ended; those that cost nothing (refused, not run) stand below its line."
        }
        "work.svg" => {
            "The same against force evaluations, which repeat exactly on any machine. They leave out what implicit steps spend on \
             matrices: compare methods of one family."
        }
        "convergence.svg" => {
            "Error against step, for fixed steps. Grey lines have slopes 1, 2 and 4, the orders of methods. Ticks on the lower edge \
             are the stability limits at the start of the run, in the colour of their methods. Runs without a result stand in the \
             strip above, at their step. Between the ends of a step frames are cubic in time, so that methods of order 5 and above \
             show their order only in steps that meet the frames."
        }
        "stiffness.svg" => {
            "Cheapest explicit and cheapest implicit run for an accuracy against the factor on the stiffness. Stars mark where both \
             cost the same, by interpolation."
        }
        _ => "",
    }
}
