//! The runs of a sweep.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::result::SweepResult;
use super::sample::Sampled;
use super::sample::beside::{Beside, runs_beside};
use super::vary::Vary;
use crate::case::Case;
use crate::difference::differences;
use crate::error::StudyError;
use crate::output::sanitize::file_stem;
use crate::plan::{FORMAT, PROGRAM};
use crate::planned_runs::CaseJob;
use crate::prepared_case::fingerprint_of;
use crate::store::{StudyJob, StudyPlan};

/// Most runs of a sweep.
const MOST: usize = 100_000;
/// Longest part of a run's identifier that comes from its values.
const LONGEST: usize = 60;

/// A sweep: what varies, and the runs that follow from it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SweepPlan {
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
    /// the case, `--set` included
    pub case: Value,
    /// what varies; the values of the last key follow each other
    pub vary: Vec<Vary>,
    /// what is drawn in place of a grid of values
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sampled: Option<Sampled>,
    /// all runs; those beside a sample come last
    pub jobs: Vec<SweepJob>,
}

/// One run of a sweep, before it is made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SweepJob {
    /// name of its files; unique in the sweep
    pub id: String,
    /// number of the run, from 0
    pub run: usize,
    /// the values of the keys that vary
    pub values: BTreeMap<String, Value>,
    /// what it shows beside a sample, if it is no part of it
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub beside: Option<Beside>,
    /// checksum of its case, with the files that it names
    pub case_digest: String,
}

impl StudyPlan for SweepPlan {
    const COMMAND: &'static str = "sweep";
    type Job = SweepJob;
    type Result = SweepResult;

    fn made_by(&self) -> (u32, &str) {
        (self.format, &self.program)
    }

    fn jobs(&self) -> &[SweepJob] {
        &self.jobs
    }

    fn same_runs(&self, other: &Self) -> bool {
        self.jobs == other.jobs
    }
}

impl StudyJob for SweepJob {
    fn id(&self) -> &str {
        &self.id
    }
}

impl CaseJob for SweepJob {
    const AGAIN: &'static str = "run the sweep again to go on";

    fn run(&self) -> usize {
        self.run
    }

    /// `KEY=VALUE`
    fn described(&self) -> String {
        let words: Vec<String> = self.values.iter().map(|(key, value)| format!("{key}={}", plain(value))).collect();
        words.join(" ")
    }

    fn case_digest(&self) -> &str {
        &self.case_digest
    }
}

impl SweepJob {
    /// What is replaced in the case; a key comes after the keys that hold it.
    pub fn overrides(&self) -> Vec<(String, String)> {
        self.values.iter().map(|(key, value)| (key.clone(), value.to_string())).collect()
    }
}

/// A value without the quotes of a text.
pub(super) fn plain(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

/// What a plan is made from.
pub struct SweepPlanner<'a> {
    /// the case
    pub case: &'a Case,
    /// its file, as typed
    pub case_file: &'a Path,
    /// what varies in a grid
    pub vary: Vec<Vary>,
    /// what is drawn in place of it
    pub sampled: Option<Sampled>,
    /// whether step and mesh are compared with the scatter of a sample
    pub errors: bool,
    /// the command, for reports
    pub command: String,
    /// set when the user interrupts
    pub stop: &'a AtomicBool,
}

impl SweepPlanner<'_> {
    /// Lists the runs and checks the case of every one of them.
    ///
    /// # Errors
    /// A value that makes a bad case, too many runs, or an interrupt.
    pub fn make(&self) -> Result<SweepPlan, StudyError> {
        let problem = self.case.problem();
        let drawn = |key: &String| Vary { key: key.clone(), ..Vary::default() };
        let (vary, jobs) = match &self.sampled {
            Some(sampled) => (sampled.keys().map(drawn).collect(), self.drawn(sampled)?),
            None => (self.vary.clone(), self.grid()?),
        };
        Ok(SweepPlan {
            format: FORMAT,
            program: PROGRAM.to_owned(),
            name: problem.name.clone(),
            command: self.command.clone(),
            case_file: self.case_file.display().to_string(),
            case: problem.case_json.clone(),
            vary,
            sampled: self.sampled.clone(),
            jobs,
        })
    }

    /// The runs of a grid.
    fn grid(&self) -> Result<Vec<SweepJob>, StudyError> {
        let sizes = self.vary.iter().map(|vary| vary.values.len());
        let count = sizes.clone().try_fold(1_usize, usize::checked_mul).filter(|count| *count <= MOST);
        let count = count.ok_or_else(|| {
            let sizes: Vec<String> = sizes.map(|n| n.to_string()).collect();
            StudyError::Usage(format!("{} runs; a sweep has at most {MOST}", sizes.join(" times ")))
        })?;
        let at = |run: usize| {
            let mut rest = run;
            let mut values = BTreeMap::new();
            for vary in self.vary.iter().rev() {
                let value = vary.values.get(rest % vary.values.len()).cloned().unwrap_or_default();
                values.insert(vary.key.clone(), value);
                rest /= vary.values.len();
            }
            let words: Vec<String> = self.vary.iter().filter_map(|vary| values.get(&vary.key)).map(plain).collect();
            let stem: String = file_stem(&words.join("-")).chars().take(LONGEST).collect();
            SweepJob { id: format!("{run:05}-{stem}"), run, values, ..SweepJob::default() }
        };
        (0..count).map(|run| self.checked(at(run))).collect()
    }

    /// The rows of a sample, and the runs beside it.
    fn drawn(&self, sampled: &Sampled) -> Result<Vec<SweepJob>, StudyError> {
        let count = sampled.rows();
        if count > MOST {
            return Err(StudyError::Usage(format!("{count} runs; a sweep has at most {MOST}")));
        }
        let mut jobs = Vec::with_capacity(count);
        for (run, point) in sampled.points()?.iter().enumerate() {
            let values = sampled.values(point).into_iter().collect();
            let job = SweepJob { id: format!("{run:05}-sample"), run, values, ..SweepJob::default() };
            jobs.push(self.checked(job)?);
        }
        if !self.errors {
            return Ok(jobs);
        }
        let medians: BTreeMap<String, Value> = sampled.values(&vec![0.5; sampled.inputs.len()]).into_iter().collect();
        let median = SweepJob { values: medians.clone(), ..SweepJob::default() };
        let at_medians = self.case.with(&median.overrides())?;
        let keys: Vec<String> = sampled.keys().cloned().collect();
        for (number, (beside, changes)) in runs_beside(&at_medians, &keys)?.into_iter().enumerate() {
            let mut values = medians.clone();
            values.extend(changes);
            let run = count + number;
            let job =
                SweepJob { id: format!("{run:05}-beside"), run, values, beside: Some(beside), ..SweepJob::default() };
            jobs.push(self.checked(job)?);
        }
        Ok(jobs)
    }

    /// A run with the checksum of its case.
    fn checked(&self, mut job: SweepJob) -> Result<SweepJob, StudyError> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(StudyError::Interrupted);
        }
        let varied = |source| StudyError::Varied { values: job.described(), source };
        let case = self.case.with(&job.overrides()).map_err(varied)?;
        job.case_digest = fingerprint_of(case.problem())?.digest();
        Ok(job)
    }
}

impl SweepPlan {
    /// The case of the sweep.
    ///
    /// # Errors
    /// Those of a case; only where the files it names have changed.
    pub fn base(&self) -> Result<Case, StudyError> {
        let base = Path::new(&self.case_file).parent().unwrap_or(Path::new("")).to_owned();
        Ok(Case::from_text(self.case.to_string(), &self.case_file, base, &[])?)
    }

    /// How many runs are rows of the table; the others are beside a sample.
    pub fn rows(&self) -> usize {
        self.sampled.as_ref().map_or(self.jobs.len(), Sampled::rows).min(self.jobs.len())
    }

    /// How another plan of the same folder differs; `None` if it does not.
    pub fn difference(&self, now: &SweepPlan) -> Option<String> {
        if self.case != now.case {
            return Some(format!(
                "its case is not {} as given now: {}",
                now.case_file,
                differences(&self.case, &now.case)
            ));
        }
        if self.vary != now.vary || self.sampled != now.sampled {
            return Some("other keys or values were varied".to_owned());
        }
        if self.jobs.len() != now.jobs.len() {
            return Some("other runs beside the sample were asked for".to_owned());
        }
        let changed = self.jobs.iter().zip(&now.jobs).find(|(was, is)| was != is);
        changed.map(|(_, is)| format!("a file that its case names is not what it was, with {}", is.described()))
    }
}
