//! What `canopy-fem tradeoff` prints.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use crate::format_number::figures;
use crate::study::plan::Plan;
use crate::study::recommendations::{Recommendation, Recommendations, unfinished, used};
use crate::study::row::{Row, RowStatus};
use crate::study::store::Store;
use crate::study::{Shard, Study};

pub(super) fn planned(plan: &Plan, store: &Store) -> String {
    let mut text = format!("{}: {} planned\n", plan.name, counted(plan.jobs.len(), "run"));
    references(&mut text, plan);
    let _ = writeln!(text, "  plan            {}", store.plan_path().display());
    let out = store.plan_path().parent().and_then(Path::parent).unwrap_or(Path::new("")).display().to_string();
    let _ = writeln!(
        text,
        "  next            canopy-fem tradeoff --out {out} --shard 1/8 ... 8/8, on any machines that share the folder"
    );
    let _ = writeln!(text, "                  canopy-fem tradeoff --out {out} --merge");
    text
}

pub(super) fn shard_done(shard: Shard, rows: &[Row], out: &Path) -> String {
    let finished = rows.iter().filter(|r| r.measured.status != RowStatus::NotRun).count();
    format!(
        "shard {}/{} done; {finished} of {} runs of the study are finished in {}\n",
        shard.part,
        shard.of,
        rows.len(),
        out.display()
    )
}

/// `1 run`, `2 runs`
fn counted(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

fn references(text: &mut String, plan: &Plan) {
    for variant in &plan.variants {
        let account = &variant.reference;
        let stiff = match variant.stiffness_factor {
            1.0 => String::new(),
            factor => format!(" ({factor} times as stiff)"),
        };
        let _ = writeln!(
            text,
            "  reference{stiff}       {}; they differ by {} of the motion (largest {})",
            account.how,
            figures(account.error, 2),
            figures(account.error_max, 2)
        );
    }
}

pub(super) fn written(files: &[PathBuf]) -> String {
    let names = files.iter().map(|file| file.display().to_string()).collect::<Vec<_>>();
    format!("\n  written         {}\n", names.join("\n                  "))
}

/// The text for the terminal.
pub(super) fn summary(study: &Study, answers: &Recommendations) -> String {
    let Study { plan, rows } = study;
    let mut text = format!(
        "{}: {} to t = {} s",
        plan.name,
        counted(rows.len(), "run"),
        plan.variants.first().map_or(0.0, |v| v.end)
    );
    let ended = unfinished(rows);
    let _ = writeln!(text, "{}", if ended.is_empty() { String::new() } else { format!("; {ended}") });
    if rows.iter().any(|row| row.measured.status == RowStatus::NotRun) {
        let _ = writeln!(
            text,
            "  not-run         the budget ended before these runs (give the same command again to make them), or their shards have not made them yet"
        );
    }
    references(&mut text, plan);
    for (number, variant) in plan.variants.iter().enumerate() {
        if plan.variants.len() > 1 {
            let _ = writeln!(text, "\n  {} times as stiff", variant.stiffness_factor);
        }
        front(&mut text, rows, (number, variant.reference.error));
        text.push('\n');
        let all: Vec<&Recommendation> = answers.targets.iter().filter(|a| a.variant == number).collect();
        // One line for accuracies with the same answer.
        for same in all.chunk_by(|a, b| advice(a) == advice(b)) {
            if let (Some(first), Some(last)) = (same.first(), same.last()) {
                let range = if first == last { String::new() } else { format!(" to {:e}", last.wanted) };
                let _ = writeln!(text, "  for {:e}{range} {}", first.wanted, advice(first));
            }
        }
        for crossover in answers.crossovers.iter().filter(|c| c.variant == number) {
            let _ = writeln!(text, "  {}", crossover.sentence);
        }
        let _ = writeln!(
            text,
            "  nothing is ranked below the reference's error of {}",
            figures(variant.reference.error, 2)
        );
    }
    for crossover in &answers.stiffness_crossovers {
        let _ = writeln!(text, "  {}", crossover.sentence);
    }
    text
}

/// A recommendation without its accuracy.
fn advice(answer: &Recommendation) -> &str {
    answer.sentence.find("use ").and_then(|at| answer.sentence.get(at..)).unwrap_or(&answer.sentence)
}

/// The Pareto front of a variant, whose reference has the error `floor`.
fn front(text: &mut String, rows: &[Row], (variant, floor): (usize, f64)) {
    let mut front: Vec<&Row> = rows.iter().filter(|r| r.pareto && r.job.variant == variant).collect();
    front.sort_by(|a, b| b.measured.error.unwrap_or(0.0).total_cmp(&a.measured.error.unwrap_or(0.0)));
    let _ = writeln!(
        text,
        "\n  on the front                               error     largest   CPU [s]   force passes  factorisations"
    );
    for row in front {
        let m = &row.measured;
        let number = |x: Option<f64>| match x {
            Some(x) if x < floor => format!("<{floor:.1e}"),
            Some(x) => format!("{x:.1e}"),
            None => String::new(),
        };
        let _ = writeln!(
            text,
            "  {:<42} {:<9} {:<9} {:<9} {:<13} {}",
            used(row),
            number(m.error),
            number(m.error_max),
            row.cpu_seconds.map_or_else(String::new, |s| figures(s, 3)),
            m.counters.force_evaluations,
            m.counters.factorizations
        );
    }
}
