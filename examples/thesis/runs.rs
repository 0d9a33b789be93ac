//! Runs of the shipped cases with other methods and steps: what nodes did, and what it cost.

use canopy_fem::case::Case;
use canopy_fem::drive::Outcome;
use canopy_fem::process::cpu_seconds;
use canopy_fem::simulation::{FollowSpec, FollowedState, follow};
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
pub fn run(case: &Case, watch: impl FnMut(&FollowedState<'_>)) -> Result<Outcome, Failed> {
    Ok(follow(case.problem(), FollowSpec::default(), watch)?)
}

/// Runs a case past its blow-up, so that both times are known.
pub fn run_to_the_end(case: &Case, watch: impl FnMut(&FollowedState<'_>)) -> Result<Outcome, Failed> {
    Ok(follow(case.problem(), FollowSpec { keep_going: true, ..Default::default() }, watch)?)
}

/// Runs of which the thesis takes the mean.
const REPEATS: u32 = 10;

/// Mean cost of one run.
struct Cost {
    /// [s] processor time, mean of the repeats
    cpu: f64,
    /// [-] force passes a step
    passes: f64,
}

fn cost(case: &Case) -> Result<Cost, Failed> {
    let outcome = run(case, |_| {})?;
    let before = cpu_seconds().unwrap_or(0.0);
    for _ in 0..REPEATS {
        run(case, |_| {})?;
    }
    let cpu = (cpu_seconds().unwrap_or(0.0) - before) / f64::from(REPEATS);
    // One pass is the start's.
    let passes = (outcome.counters.force_evaluations - 1) as f64 / outcome.steps as f64;
    Ok(Cost { cpu, passes })
}

/// Head of [`cost_rows`].
pub const COST_HEADS: [&str; 6] =
    ["scheme", "thesis CPU [s]", "to Euler", "our CPU [s]", "to Euler", "force passes a step"];

/// A row a method (name, method, the thesis' seconds or none): its cost beside the thesis', both also over the first
/// row's.
pub fn cost_rows(methods: &[(&str, &str, f64)], base: &Case) -> Result<Vec<Vec<String>>, Failed> {
    let mut first = None;
    let mut rows = Vec::new();
    for (name, method, thesis) in methods {
        let cost = cost(&changed(base, &[("time.method", method)])?)?;
        let (thesis_first, cpu_first) = *first.get_or_insert((*thesis, cost.cpu));
        let seconds = |value: f64, first: f64| match value.is_nan() {
            true => ["-".to_owned(), "-".to_owned()],
            false => [format!("{value:.4}"), format!("{:.2}", value / first)],
        };
        let [a, b] = seconds(*thesis, thesis_first);
        let [c, d] = seconds(cost.cpu, cpu_first);
        rows.push(vec![(*name).to_owned(), a, b, c, d, format!("{:.1}", cost.passes)]);
    }
    Ok(rows)
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
