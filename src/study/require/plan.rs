//! The runs of a study of what a scene requires.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::change::{Variant, changed};
use super::run::RequireResult;
use super::variants::Variants;
use crate::case::{Case, CaseError};
use crate::difference::differences;
use crate::error::StudyError;
use crate::output::gauges::MeasuredQuantity;
use crate::output::largest::LargestValues;
use crate::output::sanitize::file_stem;
use crate::plan::{FORMAT, PROGRAM};
use crate::planned_runs::CaseJob;
use crate::prepared_case::fingerprint_of;
use crate::simulation::build_scene;
use crate::store::{StudyJob, StudyPlan};

/// Longest part of a run's identifier that comes from its change.
const LONGEST: usize = 40;
/// Quantities of a case that reports no numbers.
const WITHOUT_GAUGES: [&str; 2] = ["displacement_end", "max_displacement"];

/// A study of what a scene requires.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RequirePlan {
    /// layout of the file
    pub format: u32,
    /// version of the program
    pub program: String,
    /// name of the case
    pub name: String,
    /// the command that planned it
    pub command: String,
    /// case file, as it was typed; paths in the case count from its folder
    pub case_file: String,
    /// the case, with its quantities and `--set`
    pub case: Value,
    /// the accuracy, as it was typed
    pub within: String,
    /// what cannot be changed, and why
    pub kept: Vec<String>,
    /// the full model, then each variant of it
    pub jobs: Vec<RequireJob>,
}

/// One run, before it is made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RequireJob {
    /// name of its files; unique in the study
    pub id: String,
    /// number of the run, from 0; that of a combination is 0
    pub run: usize,
    /// what is changed; nothing in the full model
    pub variants: Vec<Variant>,
    /// checksum of its case, with the files that it names; empty for a case that is refused
    pub case_digest: String,
    /// why the case is refused
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refused: Option<String>,
}

impl StudyPlan for RequirePlan {
    const COMMAND: &'static str = "require";
    type Job = RequireJob;
    type Result = RequireResult;

    fn made_by(&self) -> (u32, &str) {
        (self.format, &self.program)
    }

    fn jobs(&self) -> &[RequireJob] {
        &self.jobs
    }

    fn same_runs(&self, other: &Self) -> bool {
        self.jobs == other.jobs
    }
}

impl StudyJob for RequireJob {
    fn id(&self) -> &str {
        &self.id
    }
}

impl CaseJob for RequireJob {
    const AGAIN: &'static str = "run the command again to go on";

    fn run(&self) -> usize {
        self.run
    }

    fn described(&self) -> String {
        match self.variants.as_slice() {
            [] => "full model".to_owned(),
            all => all.iter().map(|variant| variant.change.to_string()).collect::<Vec<_>>().join("; "),
        }
    }

    fn case_digest(&self) -> &str {
        &self.case_digest
    }
}

impl RequireJob {
    /// Whether it makes the discretisation finer.
    pub fn finer(&self) -> bool {
        self.variants.iter().any(|variant| variant.change.finer())
    }
}

/// What a plan is made from.
pub struct RequirePlanner<'a> {
    /// the case
    pub case: &'a Case,
    /// its file, as typed
    pub case_file: &'a Path,
    /// the accuracy, as typed
    pub within: String,
    /// the command, for reports
    pub command: String,
    /// set when the user interrupts
    pub stop: &'a AtomicBool,
}

impl RequirePlanner<'_> {
    /// Lists the variants and checks the case of every one of them.
    ///
    /// # Errors
    /// A case that cannot be run, a quantity without a value, or an interrupt.
    pub fn make(&self) -> Result<RequirePlan, StudyError> {
        let case = with_numbers(self.case)?;
        let Variants { all, kept } = Variants::of(&case);
        let mut plan = RequirePlan {
            format: FORMAT,
            program: PROGRAM.to_owned(),
            name: case.problem().name.clone(),
            command: self.command.clone(),
            case_file: self.case_file.display().to_string(),
            case: case.problem().case_json.clone(),
            within: self.within.clone(),
            kept,
            jobs: Vec::with_capacity(all.len() + 1),
        };
        for (run, variant) in std::iter::once(None).chain(all.into_iter().map(Some)).enumerate() {
            if self.stop.load(Ordering::Relaxed) {
                return Err(StudyError::Interrupted);
            }
            let words = variant.as_ref().map_or_else(|| "full".to_owned(), |variant| variant.change.to_string());
            let stem: String = file_stem(&words).chars().take(LONGEST).collect();
            let job = plan.job(&case, format!("{run:03}-{stem}"), variant.into_iter().collect())?;
            plan.jobs.push(RequireJob { run, ..job });
        }
        Ok(plan)
    }
}

/// The case with quantities that have values: where it reports none, those of the whole scene.
fn with_numbers(case: &Case) -> Result<Case, StudyError> {
    let mut problem = case.problem().clone();
    let scene = build_scene(problem.take_system(), 1)?;
    let largest = LargestValues::new(&*scene, &problem.output, problem.time.end, None);
    let quantities = largest.map_err(|why| StudyError::Usage(why.to_string()))?.quantities();
    let wanted: Vec<&MeasuredQuantity> = quantities.iter().filter(|quantity| quantity.wanted).collect();
    let motion = wanted.iter().any(|quantity| quantity.is_motion());
    match (motion, problem.output.quantities.is_empty()) {
        (false, _) => Ok(case.clone()),
        (true, true) => {
            let landing = wanted.iter().filter(|quantity| quantity.is_of_landing()).map(|quantity| quantity.name.as_str());
            let names: Vec<&str> = WITHOUT_GAUGES.into_iter().chain(landing).collect();
            let names = serde_json::json!(names).to_string();
            Ok(case.with(&[("study.quantities".to_owned(), names)])?)
        }
        (true, false) => Err(StudyError::Usage(
            "motion is compared node by node, and other meshes have other nodes: name numbers with --quantity, such as \
             max_displacement or tip.z@0.5"
                .to_owned(),
        )),
    }
}

impl RequirePlan {
    /// The full model.
    ///
    /// # Errors
    /// Those of a case; only where the files it names have changed.
    pub fn base(&self) -> Result<Case, StudyError> {
        Ok(Case::from_text(self.case.to_string(), &self.case_file, self.folder(), &[])?)
    }

    /// The folder from which paths in the case count.
    pub fn folder(&self) -> PathBuf {
        Path::new(&self.case_file).parent().unwrap_or(Path::new("")).to_owned()
    }

    /// A run of some variants. A case that is refused is a run that says so.
    ///
    /// # Errors
    /// A case that cannot be summed up, or a full model that is refused.
    pub(super) fn job(&self, base: &Case, id: String, variants: Vec<Variant>) -> Result<RequireJob, StudyError> {
        let (case_digest, refused) = match changed(base, &variants) {
            Ok(case) => (fingerprint_of(case.problem())?.digest(), None),
            Err(why) if variants.is_empty() => return Err(why.into()),
            Err(why) => (String::new(), Some(briefly(&why))),
        };
        Ok(RequireJob { id, run: 0, variants, case_digest, refused })
    }

    /// How another plan of the same folder differs; `None` if it does not.
    pub fn difference(&self, now: &RequirePlan) -> Option<String> {
        if self.case != now.case {
            let keys = differences(&self.case, &now.case);
            return Some(format!("its case is not {} as given now: {keys}", now.case_file));
        }
        let changed = self.jobs.iter().zip(&now.jobs).find(|(was, is)| was != is);
        changed.map(|(_, is)| format!("a file that its case names is not what it was, with {}", is.described()))
    }
}

/// The first fault of a case in one line.
pub(super) fn briefly(error: &CaseError) -> String {
    match error.faults().first() {
        Some(fault) => format!("{}; expected {}", fault.heading(), fault.allowed),
        None => error.to_string(),
    }
}
