//! Runs of the shipped cases with other methods and steps: what nodes did, and what it cost.

use canopy_fem::case::Case;
use canopy_fem::drive::Outcome;
use canopy_fem::output::process::cpu_seconds;
use canopy_fem::simulation::{FollowSpec, Seen, follow};
use std::error::Error;
use std::path::Path;

pub type Failed = Box<dyn Error + Send + Sync>;

/// A case of `assets/cases` with values replaced, as `--set` does.
pub fn asset(stem: &str, sets: &[(&str, &str)]) -> Result<Case, Failed> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/cases").join(format!("{stem}.json"));
    Ok(Case::from_file(&path, &owned(sets))?)
}

/// The same case with other values.
pub fn changed(case: &Case, sets: &[(&str, &str)]) -> Result<Case, Failed> {
    Ok(case.with(&owned(sets))?)
}

fn owned(sets: &[(&str, &str)]) -> Vec<(String, String)> {
    sets.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect()
}

/// Runs a case; `watch` sees every accepted state.
pub fn run(case: &Case, watch: impl FnMut(&Seen<'_>)) -> Result<Outcome, Failed> {
    Ok(follow(case.problem(), FollowSpec::default(), watch)?)
}

/// Runs a case past its blow-up, so that both times are known.
pub fn run_to_the_end(case: &Case, watch: impl FnMut(&Seen<'_>)) -> Result<Outcome, Failed> {
    Ok(follow(case.problem(), FollowSpec { keep_going: true, ..Default::default() }, watch)?)
}

/// Mean cost of one run.
pub struct Cost {
    /// [s] processor time, mean of the repeats
    pub cpu: f64,
    /// [-] force passes of one run
    pub evaluations: u64,
    /// steps of one run
    pub steps: u64,
}

/// Repeats a run as the thesis did (10 executions).
pub fn cost(case: &Case, repeats: u32) -> Result<Cost, Failed> {
    let outcome = run(case, |_| {})?;
    let before = cpu_seconds().unwrap_or(0.0);
    for _ in 0..repeats {
        run(case, |_| {})?;
    }
    let cpu = (cpu_seconds().unwrap_or(0.0) - before) / f64::from(repeats);
    Ok(Cost { cpu, evaluations: outcome.counters.force_evaluations, steps: outcome.steps })
}

/// A quantity of one node over time, with its rate.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    pub times: Vec<f64>,
    pub values: Vec<f64>,
    pub rates: Vec<f64>,
}

impl Trace {
    pub fn push(&mut self, t: f64, value: f64, rate: f64) {
        self.times.push(t);
        self.values.push(value);
        self.rates.push(rate);
    }

    pub fn over_time(&self) -> Vec<(f64, f64)> {
        self.times.iter().copied().zip(self.values.iter().copied()).collect()
    }

    pub fn phase(&self) -> Vec<(f64, f64)> {
        self.values.iter().copied().zip(self.rates.iter().copied()).collect()
    }

    /// Largest value, whatever its sign.
    pub fn largest(&self) -> f64 {
        self.values.iter().fold(0.0, |m, v| v.abs().max(m))
    }
}

/// Displacement of one node along one axis.
pub fn displacement(case: &Case, node: usize, axis: usize) -> Result<(Trace, Outcome), Failed> {
    let mut trace = Trace::default();
    let outcome = run(case, |seen| {
        trace.push(seen.t, seen.positions[node][axis] - seen.reference[node][axis], seen.velocities[node][axis]);
    })?;
    Ok((trace, outcome))
}
