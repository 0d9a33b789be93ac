//! The leanest case: harmless changes together, each combination measured.

use std::path::{Path, PathBuf};

use serde::Serialize;
use serde_json::{Value, json};

use super::change::{Variant, edited};
use super::compare::Comparison;
use super::plan::{RequireJob, RequirePlan};
use super::run::{RequireRow, RequireRunner};
use super::variants::Variants;
use crate::accuracy::Accuracy;
use crate::case::Case;
use crate::error::StudyError;
use crate::format_number::figures;
use crate::output::atomic::{Durability, replace_shared};
use crate::output::sanitize::file_stem;
use crate::planned_runs::CaseJob;
use crate::prepared_case::fingerprint_of;
use crate::row::RowStatus;
use crate::store::system;

/// [-] Share of the counted work that a change saves at least: for less no difference is worth it.
const LEAST: f64 = 0.05;
/// [-] Share of a value below which a difference is nothing.
const NOTHING: f64 = 1e-8;
/// [-] How many times the initial speed and the mass of the payload, where the leanest case is looked at again.
const ELSEWHERE: f64 = 1.2;

/// Makes combinations.
pub struct Combiner<'a> {
    /// makes runs
    pub runner: &'a RequireRunner<'a>,
    /// the full model
    pub base: &'a Case,
    /// what came of the planned runs
    pub rows: &'a [RequireRow],
    /// the accuracy
    pub accuracy: &'a Accuracy,
}

/// The leanest case that was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Lean {
    /// its changes, in words
    pub changes: Vec<String>,
    /// how far it is from the full model
    pub distance: Comparison,
    /// combinations in the order they were made, and whether the last change of each was kept
    pub tried: Vec<Tried>,
    /// its file
    pub file: PathBuf,
    /// why the run of the file is not that of the combination, if it is not
    pub file_differs: Option<String>,
    /// full and lean model at another speed, with another payload
    pub elsewhere: Option<Elsewhere>,
    /// why not all combinations were made
    pub left: Option<String>,
}

/// A combination.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tried {
    /// the change that is new in it
    pub added: String,
    /// whether it was kept
    pub kept: bool,
    /// how far the combination is from the full model
    pub distance: Comparison,
}

/// The leanest case from another state.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Elsewhere {
    /// the state, in words
    pub described: String,
    /// [s] processor time of the full model there
    pub full_seconds: Option<f64>,
    /// how far the lean model is from the full one there
    pub distance: Comparison,
}

impl Combiner<'_> {
    fn plan(&self) -> &RequirePlan {
        self.runner.plan
    }

    /// Adds harmless changes in the order of the work that they save, measures each combination, and keeps what stays
    /// within the accuracy and is less work. The result is written as a case into `out`, run from that file, and run
    /// from another speed and with another payload. `None` if no change is harmless and saves work.
    ///
    /// # Errors
    /// An interrupt, or files that cannot be read or written.
    pub fn lean(&self, out: &Path) -> Result<Option<Lean>, StudyError> {
        let candidates = self.candidates()?;
        let Some((first, rest)) = candidates.split_first() else { return Ok(None) };
        let (mut best, mut runs, mut left) = ((*first).clone(), vec![first.job.run], None);
        let mut tried = Vec::new();
        for row in rest {
            let Some(new) = row.job.variants.first() else { continue };
            if best.job.variants.iter().any(|kept| kept.excludes(new)) {
                continue;
            }
            let variants: Vec<Variant> = best.job.variants.iter().chain([new]).cloned().collect();
            let made = self.combined(&[&runs[..], &[row.job.run]].concat(), variants)?;
            if made.result.status == RowStatus::NotRun {
                left = Some(made.result.note);
                break;
            }
            let distance = self.distance(&made)?;
            let kept = distance.harmless == Some(true) && made.result.work < best.result.work;
            tried.push(Tried { added: new.change.to_string(), kept, distance });
            if kept {
                runs.push(row.job.run);
                best = made;
            }
        }
        let distance = self.distance(&best)?;
        let file = self.write(out, &best, &distance)?;
        let file_differs = if left.is_none() { self.file_differs(&file, &best)? } else { None };
        let elsewhere = if left.is_none() { self.elsewhere(&runs, &best)? } else { None };
        let changes = best.job.variants.iter().map(|variant| variant.change.to_string()).collect();
        Ok(Some(Lean { changes, distance, tried, file, file_differs, elsewhere, left }))
    }

    /// Single changes to something simpler that are harmless and save work, the most first.
    fn candidates(&self) -> Result<Vec<&RequireRow>, StudyError> {
        let mut all = Vec::new();
        for row in self.rows.iter().filter(|row| row.job.variants.len() == 1 && !row.job.finer()) {
            let distance = self.distance(row)?;
            if let (Some(true), Some(saved)) = (distance.harmless, distance.saved.filter(|saved| *saved > LEAST)) {
                all.push((saved, row));
            }
        }
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        Ok(all.into_iter().map(|(_, row)| row).collect())
    }

    fn distance(&self, row: &RequireRow) -> Result<Comparison, StudyError> {
        let full = self.rows.first().map(|row| row.result.clone()).unwrap_or_default();
        Comparison::of(row, &full, self.accuracy)
    }

    fn combined(&self, runs: &[usize], variants: Vec<Variant>) -> Result<RequireRow, StudyError> {
        self.runner.row(self.base, self.plan().job(self.base, named("lean", runs), variants)?)
    }

    /// Writes the case.
    fn write(&self, out: &Path, best: &RequireRow, distance: &Comparison) -> Result<PathBuf, StudyError> {
        let plan = self.plan();
        let path = out.join(format!("{}-lean.json", file_stem(&plan.name)));
        let mut case = edited(&plan.case, &best.job.variants);
        rebase(&mut case, &plan.folder());
        let told = format!(
            "{} with {}. Measured against it: {}, {}.",
            plan.case_file,
            best.job.described(),
            distances(distance),
            cost(distance)
        );
        let description = match case.get("description").and_then(Value::as_str) {
            Some(own) => format!("{told} Of the full case: {own}"),
            None => told,
        };
        if let Some(map) = case.as_object_mut() {
            // A schema of an editor lies beside the full case.
            map.remove("$schema");
            map.insert("name".to_owned(), json!(format!("{}-lean", plan.name)));
            map.insert("description".to_owned(), json!(description));
        }
        let text = serde_json::to_string_pretty(&case).map_err(|e| StudyError::Page(e.to_string()))? + "\n";
        std::fs::create_dir_all(out).map_err(|e| system(out, e))?;
        replace_shared(&path, text.as_bytes(), Durability::Visible).map_err(|e| system(&path, e))?;
        Ok(path)
    }

    /// Runs the file that was written; says how it differs from the combination that it stands for.
    fn file_differs(&self, file: &Path, best: &RequireRow) -> Result<Option<String>, StudyError> {
        let problem = Case::from_file(file, &[])?.into_problem();
        let case_digest = fingerprint_of(&problem)?.digest();
        let id = format!("file-{}", best.job.id);
        let job = RequireJob { id, case_digest, ..best.job.clone() };
        let RequireRow { result, .. } = self.runner.row_as(job, problem)?;
        Ok(match result.status {
            RowStatus::NotRun => Some(result.note),
            _ if result.numbers == best.result.numbers => None,
            status => Some(format!("the run of the file ended as {} with other numbers", status.word())),
        })
    }

    /// Full and lean model from another state; `None` where the case has none, or the budget was spent before it.
    fn elsewhere(&self, runs: &[usize], best: &RequireRow) -> Result<Option<Elsewhere>, StudyError> {
        let state = Variants::elsewhere(&self.plan().case, ELSEWHERE);
        if state.is_empty() {
            return Ok(None);
        }
        let full = self.plan().job(self.base, "elsewhere-full".to_owned(), state.clone())?;
        let full = self.runner.row(self.base, full)?;
        let variants = best.job.variants.iter().chain(&state).cloned().collect();
        let lean = self.plan().job(self.base, named("elsewhere", runs), variants)?;
        let lean = self.runner.row(self.base, lean)?;
        if [&full, &lean].iter().any(|row| row.result.status == RowStatus::NotRun) {
            return Ok(None);
        }
        Ok(Some(Elsewhere {
            described: full.job.described(),
            full_seconds: full.result.cpu_seconds,
            distance: Comparison::of(&lean, &full.result, self.accuracy)?,
        }))
    }
}

fn named(what: &str, runs: &[usize]) -> String {
    let runs: Vec<String> = runs.iter().map(usize::to_string).collect();
    format!("{what}-{}", runs.join("-"))
}

/// A share in per cent, with its sign; what solvers leave over is nothing.
pub(super) fn percent(share: f64) -> String {
    if share.abs() < NOTHING {
        return "0 %".to_owned();
    }
    format!("{}{} %", if share > 0.0 { "+" } else { "" }, figures(100.0 * share, 2))
}

/// All distances in a line.
pub(super) fn distances(of: &Comparison) -> String {
    let word = |of: &super::compare::Difference| {
        format!("{} {}", of.name, of.share.map_or_else(|| "without a value".to_owned(), percent))
    };
    of.differences.iter().map(word).collect::<Vec<_>>().join(", ")
}

/// What a run saves, in words.
pub(super) fn work(of: &Comparison) -> String {
    match of.saved {
        Some(saved) if saved.abs() < NOTHING => "the same work".to_owned(),
        // Almost all is not all.
        Some(saved) if saved > 0.95 => format!("{} % less work", figures(100.0 * saved, 3)),
        Some(saved) if saved > 0.0 => format!("{} % less work", figures(100.0 * saved, 2)),
        Some(saved) => format!("{} % more work", figures(-100.0 * saved, 2)),
        None => "no work".to_owned(),
    }
}

/// The same with the processor time that it took.
pub(super) fn cost(of: &Comparison) -> String {
    let seconds = of.cpu_seconds.map_or_else(String::new, |seconds| format!(", {} s", figures(seconds, 2)));
    work(of) + &seconds
}

/// Makes the paths of a case count from anywhere.
fn rebase(case: &mut Value, folder: &Path) {
    let whole = |path: &str| std::path::absolute(folder.join(path)).map(|path| path.display().to_string());
    let mut at: Vec<String> = ["mesh/file", "aero/wind/file", "initial/from", "initial/from/frame"]
        .map(|key| format!("/system/network/{key}"))
        .to_vec();
    let winds = case.pointer("/system/network/aero/wind/sum").and_then(Value::as_array).map_or(0, Vec::len);
    at.extend((0..winds).map(|i| format!("/system/network/aero/wind/sum/{i}/file")));
    for at in at {
        if let Some(value) = case.pointer_mut(&at)
            && let Some(Ok(path)) = value.as_str().map(whole)
        {
            *value = path.into();
        }
    }
}
