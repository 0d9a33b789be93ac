//! Runs of the case as a model of the data, and the search from several starts.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use serde::Serialize;

use super::data::{DataSet, DataSource};
use super::estimate::{Estimate, sigma_of, weights};
use super::least_squares::{Ended, LeastSquares, Minimum};
use super::parameter::{Parameter, Range};
use crate::case::Case;
use crate::drive::{Explain, Status};
use crate::error::StudyError;
use crate::experiment::{Experiment, Start};
use crate::model::gauge::Quantity;
use crate::model::stop::Stop;
use crate::output::gauge_rows::{ColumnName, GaugeRows};
use crate::planned_runs::each;
use crate::simulation::build_scene;
use crate::sweep::sample::hypercube;

/// Searches from one start, each with the noise that the one before has shown.
const ROUNDS: usize = 4;
/// [-] Change of the noise of a set below which it is not searched again.
const SAME_NOISE: f64 = 0.01;
/// [-] Difference of two sums of squares below which two starts have come to the same minimum.
const SAME_MINIMUM: f64 = 1e-3;
/// Name of the time offset among the parameters.
pub(super) const OFFSET: &str = "offset";

/// What is fitted to what.
pub struct FitSpec<'a> {
    /// the case
    pub case: &'a Case,
    /// files of data and the gauges that they are held against
    pub data: Vec<DataSource>,
    /// the keys that are fitted
    pub vary: Vec<Parameter>,
    /// [s] range of an offset that is added to the times of all data, and fitted too
    pub offset: Option<Range>,
    /// number of starts: the first is the case itself, others are spread over the ranges
    pub starts: u32,
    /// seed of the other starts
    pub seed: u64,
    /// runs at the same time
    pub threads: usize,
    /// set when the user interrupts
    pub interrupt: &'a AtomicBool,
    /// called before each run with the number of runs made
    pub on_run: &'a (dyn Fn(usize) + Sync),
}

/// What one start came to.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct StartResult {
    /// values at the start
    pub from: Vec<f64>,
    /// values at the minimum; none where the start has no run
    pub to: Option<Vec<f64>>,
    /// sum of the squares of the weighted residuals
    pub sum_of_squares: Option<f64>,
    /// Jacobians made
    pub iterations: usize,
    /// why the search ended
    pub ended: Option<Ended>,
    /// why there is no minimum
    pub note: String,
}

/// A fit.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Fit {
    /// the data
    pub data: Vec<DataSet>,
    /// units of the data
    pub units: Vec<String>,
    /// values and errors at the best minimum
    #[serde(flatten)]
    pub estimate: Estimate,
    /// number of the best start
    pub best: usize,
    /// all starts
    pub starts: Vec<StartResult>,
    /// starts that came to the best minimum
    pub agreeing: usize,
    /// runs made
    pub runs: usize,
    /// runs that did not come to their end, with how the first of them failed
    pub failed: usize,
    /// how the first of them failed
    pub failure: String,
    /// the model at the times of the data, set after set
    #[serde(skip)]
    pub fitted: Vec<f64>,
    /// rows of the run with the fitted values: times [s] and each set's column
    #[serde(skip)]
    pub curves: (Vec<f64>, Vec<Vec<f64>>),
}

/// A run's columns over time.
struct Curves {
    t: Vec<f64>,
    columns: Vec<Vec<f64>>,
    quantities: Vec<Quantity>,
}

/// A minimum and the standard deviations of the sets with which its residuals are weighted.
type Found = (Minimum, Vec<f64>);

struct Model<'a> {
    spec: &'a FitSpec<'a>,
    sets: &'a [DataSet],
    columns: Vec<ColumnName>,
    parameters: Vec<Parameter>,
    /// [s] end of the runs
    end: f64,
    runs: AtomicUsize,
    failed: AtomicUsize,
    failure: Mutex<String>,
}

impl FitSpec<'_> {
    /// Reads the data and searches from all starts.
    ///
    /// # Errors
    /// Files, keys or gauges that are not there; more values than data; data beyond the run; no start with a run; an
    /// interrupt.
    pub fn run(&self) -> Result<Fit, StudyError> {
        let sets: Vec<DataSet> = self.data.iter().map(DataSource::read).collect::<Result<_, _>>()?;
        let offset = self.offset.map(|range| Parameter { key: OFFSET.to_owned(), range });
        let parameters: Vec<Parameter> = self.vary.iter().cloned().chain(offset).collect();
        let points: usize = sets.iter().map(|set| set.t.len()).sum();
        if parameters.is_empty() {
            return Err(StudyError::Usage("nothing is fitted: give --vary KEY=A..B".to_owned()));
        }
        if points < parameters.len() {
            let n = parameters.len();
            return Err(StudyError::Usage(format!("{points} points of data cannot determine {n} values")));
        }
        let end = self.end(&sets)?;
        let model = Model {
            spec: self,
            sets: &sets,
            columns: self.data.iter().map(|source| source.column.clone()).collect(),
            parameters,
            end,
            runs: AtomicUsize::new(0),
            failed: AtomicUsize::new(0),
            failure: Mutex::new(String::new()),
        };
        model.fit()
    }

    /// [s] The end of the runs: that of the data.
    fn end(&self, sets: &[DataSet]) -> Result<f64, StudyError> {
        let (low, high) = self.offset.map_or((0.0, 0.0), |range| (range.low, range.high));
        let end = self.case.problem().time.end;
        let mut last = 0.0_f64;
        for set in sets {
            let (first, own) = (set.t.first().copied().unwrap_or(0.0), set.t.last().copied().unwrap_or(0.0));
            if first + low < 0.0 || own + high > end {
                return Err(StudyError::Usage(format!(
                    "{}: its times, with --offset, reach from {} to {} s; the run goes from 0 to {end} s: set time.end \
                     with --end, or shift the data with --offset",
                    set.file,
                    first + low,
                    own + high
                )));
            }
            last = last.max(own + high);
        }
        Ok(last)
    }
}

impl Model<'_> {
    fn fit(&self) -> Result<Fit, StudyError> {
        let mut best: Option<(usize, Minimum, Vec<f64>)> = None;
        let mut starts = Vec::new();
        for (number, from) in self.starts().into_iter().enumerate() {
            let (result, found) = self.search(&from)?;
            starts.push(result);
            let sum = |minimum: &Minimum, taken: &[f64]| self.plain_sum(minimum, taken);
            if let Some((minimum, taken)) = found {
                let better = best.as_ref().is_none_or(|(_, other, before)| sum(&minimum, &taken) < sum(other, before));
                if better {
                    best = Some((number, minimum, taken));
                }
            }
        }
        let Some((number, minimum, taken)) = best else {
            let why = self.failure.lock().unwrap_or_else(PoisonError::into_inner).clone();
            return Err(StudyError::Usage(format!(
                "no start has a run that came to its end: {why}; give narrower ranges, or more --starts"
            )));
        };
        let found = |start: &StartResult| start.sum_of_squares;
        let least = starts.get(number).and_then(found).unwrap_or_default();
        let agrees = |start: &&StartResult| found(start).is_some_and(|sum| sum <= least * (1.0 + SAME_MINIMUM));
        let curves = self.curves(&minimum.u)?.ok_or_else(|| StudyError::Usage("the fitted run failed".to_owned()))?;
        Ok(Fit {
            estimate: Estimate::of(&minimum, &self.parameters, self.sets, &taken),
            best: number,
            agreeing: starts.iter().filter(agrees).count(),
            starts,
            runs: self.runs.load(Ordering::Relaxed),
            failed: self.failed.load(Ordering::Relaxed),
            failure: self.failure.lock().unwrap_or_else(PoisonError::into_inner).clone(),
            fitted: self.at_data(&minimum.u, &curves),
            units: curves.quantities.iter().map(|quantity| quantity.unit.to_owned()).collect(),
            curves: (curves.t, curves.columns),
            data: self.sets.to_vec(),
        })
    }

    /// Searches from a start; where noise is not given, again with the noise that the residuals have shown. Returns the
    /// minimum and the standard deviations with which its residuals are weighted.
    fn search(&self, from: &[f64]) -> Result<(StartResult, Option<Found>), StudyError> {
        let values = |u: &[f64]| -> Vec<f64> { self.values(u).collect() };
        let mut result = StartResult { from: values(from), ..StartResult::default() };
        let mut taken: Vec<f64> = self.sets.iter().map(DataSet::scale).collect();
        // The weight of a single set changes nothing.
        let rounds = if self.sets.len() > 1 && self.sets.iter().any(|set| set.sigma.is_empty()) { ROUNDS } else { 1 };
        let mut u = from.to_vec();
        let mut found = None;
        for round in 0..rounds {
            let weights = weights(self.sets, &taken);
            let problem = LeastSquares {
                residuals: &|points| self.residuals(points, &weights),
                change: &|i, u| self.parameters.get(i).map_or(0.0, |parameter| parameter.range.change(u)),
            };
            let Some(minimum) = problem.search(&u)? else {
                result.note = self.failure.lock().unwrap_or_else(PoisonError::into_inner).clone();
                return Ok((result, None));
            };
            result.iterations += minimum.iterations;
            let sigma = sigma_of(self.sets, &taken, &minimum.residuals, self.parameters.len());
            u.clone_from(&minimum.u);
            let same = sigma.iter().zip(&taken).all(|(new, old)| (new / old - 1.0).abs() < SAME_NOISE);
            found = Some((minimum, taken.clone()));
            if same || round + 1 == rounds {
                break;
            }
            taken = sigma;
        }
        if let Some((minimum, taken)) = &found {
            result.to = Some(values(&minimum.u));
            result.sum_of_squares = Some(self.plain_sum(minimum, taken));
            result.ended = Some(minimum.ended);
        }
        Ok((result, found))
    }

    /// The sum of squares that starts are compared by: residuals over the given noise, else over the set's scale.
    fn plain_sum(&self, minimum: &Minimum, taken: &[f64]) -> f64 {
        let scales: Vec<f64> = self.sets.iter().map(DataSet::scale).collect();
        let both = weights(self.sets, &scales).into_iter().zip(weights(self.sets, taken));
        minimum.residuals.iter().zip(both).map(|(r, (plain, own))| (r * plain / own).powi(2)).sum()
    }

    /// The case itself, as far as it is in the ranges, then a Latin hypercube: each start is in another part of each
    /// range.
    fn starts(&self) -> Vec<Vec<f64>> {
        let (spec, problem) = (self.spec, self.spec.case.problem());
        let place = |parameter: &Parameter| {
            let value = if parameter.key == OFFSET { Some(0.0) } else { parameter.in_case(&problem.case_json) };
            value.and_then(|value| parameter.range.place(value)).unwrap_or(0.5)
        };
        let mut starts = vec![self.parameters.iter().map(place).collect()];
        starts.extend(hypercube(spec.seed, 0, 0..spec.starts.saturating_sub(1) as usize, self.parameters.len()));
        starts
    }

    fn values(&self, u: &[f64]) -> impl Iterator<Item = f64> {
        self.parameters.iter().zip(u).map(|(parameter, u)| parameter.range.value(*u))
    }

    /// Weighted residuals at points, one run a thread.
    fn residuals(&self, points: &[Vec<f64>], weights: &[f64]) -> Result<Vec<Option<Vec<f64>>>, StudyError> {
        let found = Mutex::new(BTreeMap::new());
        let numbered: Vec<(usize, &Vec<f64>)> = points.iter().enumerate().collect();
        each(&numbered, self.spec.threads, |&(number, u)| {
            let curves = self.curves(u)?;
            let residuals = curves.map(|curves| self.weighted(u, &curves, weights));
            found.lock().unwrap_or_else(PoisonError::into_inner).insert(number, residuals);
            Ok(())
        })?;
        Ok(found.into_inner().unwrap_or_else(PoisonError::into_inner).into_values().collect())
    }

    fn weighted(&self, u: &[f64], curves: &Curves, weights: &[f64]) -> Vec<f64> {
        let data = self.sets.iter().flat_map(|set| &set.value);
        let model = self.at_data(u, curves);
        model.iter().zip(data).zip(weights).map(|((model, data), weight)| (model - data) * weight).collect()
    }

    /// The model at the times of the data, set after set, interpolated linearly between steps.
    fn at_data(&self, u: &[f64], curves: &Curves) -> Vec<f64> {
        let of = self.parameters.iter().position(|parameter| parameter.key == OFFSET);
        let offset = of.and_then(|i| self.values(u).nth(i)).unwrap_or(0.0);
        let sets = self.sets.iter().zip(&curves.columns);
        sets.flat_map(|(set, column)| set.t.iter().map(move |t| at(&curves.t, column, t + offset))).collect()
    }

    /// Makes the run of a point; `None` if it does not come to its end.
    fn curves(&self, u: &[f64]) -> Result<Option<Curves>, StudyError> {
        let spec = self.spec;
        if spec.interrupt.load(Ordering::Relaxed) {
            return Err(StudyError::Interrupted);
        }
        (spec.on_run)(self.runs.fetch_add(1, Ordering::Relaxed));
        let overrides = self.overrides(self.values(u));
        let described = || overrides.iter().map(|(key, value)| format!("{key}={value}")).collect::<Vec<_>>().join(" ");
        let varied = |source| StudyError::Varied { values: described(), source };
        let mut problem = spec.case.with(&overrides).map_err(varied)?.into_problem();
        let scene = match build_scene(problem.take_system(), 1) {
            Ok(scene) => scene,
            Err(why) => return Ok(self.fails(&described(), &why.to_string())),
        };
        let experiment = Experiment {
            interrupt: Stop::on(spec.interrupt),
            explain: Explain::Nothing,
            ..Experiment::new(&*scene, &problem.method, problem.solver, problem.time.step, self.end)
        };
        let mut rows = GaugeRows::new(&*scene, &problem.output, self.end, &self.columns)
            .map_err(|why| StudyError::Usage(format!("--data {why}")))?;
        let mut stepper = match experiment.stepper() {
            Ok(stepper) => stepper,
            Err(why) => return Err(StudyError::Usage(why.to_string())),
        };
        let stop = AtomicBool::new(false);
        let made = experiment.observed(&mut stepper, Start::Initial, &mut [&mut rows], &stop);
        if spec.interrupt.load(Ordering::Relaxed) {
            return Err(StudyError::Interrupted);
        }
        match made {
            Ok(outcome) if outcome.status == Status::Completed => {
                let quantities = rows.quantities();
                Ok(Some(Curves { t: rows.t, columns: rows.values, quantities }))
            }
            Ok(outcome) => {
                let why = outcome.failure.map_or_else(String::new, |failure| failure.cause);
                Ok(self.fails(&described(), &format!("at t = {:.4} s {why}", outcome.t_end)))
            }
            Err(why) => Ok(self.fails(&described(), &why.to_string())),
        }
    }

    fn overrides(&self, values: impl Iterator<Item = f64>) -> Vec<(String, String)> {
        let all = self.parameters.iter().zip(values).filter(|(parameter, _)| parameter.key != OFFSET);
        all.map(|(parameter, value)| (parameter.key.clone(), format!("{value:?}"))).collect()
    }

    fn fails(&self, values: &str, why: &str) -> Option<Curves> {
        self.failed.fetch_add(1, Ordering::Relaxed);
        let mut first = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        if first.is_empty() {
            *first = format!("with {values}, {why}");
        }
        None
    }
}

/// A column at a time [s], linear between rows.
fn at(t: &[f64], column: &[f64], time: f64) -> f64 {
    let next = t.partition_point(|row| *row < time);
    let value = |i: usize| column.get(i).copied().unwrap_or(f64::NAN);
    match (next.checked_sub(1).and_then(|i| t.get(i)), t.get(next)) {
        (Some(from), Some(to)) => value(next - 1) + (value(next) - value(next - 1)) * (time - from) / (to - from),
        (None, _) => value(0),
        // Rounding of the last time.
        (_, None) => column.last().copied().unwrap_or(f64::NAN),
    }
}
