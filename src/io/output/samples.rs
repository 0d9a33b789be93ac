//! A run at given times, written into arrays of a program.
//!
//! A time within a step shows the state [interpolated](super::hermite) there, as frames do, with forces evaluated at it
//! where gauges are kept; the energy account is linear in between. A time at the end of a step, up to rounding, shows
//! that end. What a run does not come to, or comes to in a state that is not
//! [credible](crate::drive::observer::AcceptedStep::credible), keeps the NaN it begins with.

use super::gauges::{ChannelName, Gauges};
use super::hermite::interpolate;
use super::quantity::{UnknownQuantity, energies};
use super::schedule::tolerance;
use crate::case::spec::OutputSpec;
use crate::drive::observer::{AcceptedStep, Energies, ObserveError, Observer, States, UpcomingStep, Wants};
use crate::model::observables::Observables;
use crate::model::point::Point;

/// Names of the columns of an energy account.
pub use super::quantity::ENERGIES;

/// Where samples of a run are kept; an empty slice keeps nothing.
#[derive(Debug, Default)]
pub struct SampleArrays<'o> {
    /// [m] `[n_times * n_nodes * 3]`
    pub positions: &'o mut [f64],
    /// [m/s] `[n_times * n_nodes * 3]`
    pub velocities: &'o mut [f64],
    /// in the units of the columns, `[n_times * n_channels]`
    pub gauges: &'o mut [f64],
    /// [J] in the order of [`ENERGIES`], `[n_times * 6]`
    pub energies: &'o mut [f64],
    /// peaks over all steps, `[n_channels]`
    pub peaks: &'o mut [f64],
    /// [s] their times, `[n_channels]`
    pub peak_times: &'o mut [f64],
}

impl SampleArrays<'_> {
    /// Fills all of them with NaN.
    fn clear(&mut self) {
        let SampleArrays { positions, velocities, gauges, energies, peaks, peak_times } = self;
        [positions, velocities, gauges, energies, peaks, peak_times].into_iter().for_each(|all| all.fill(f64::NAN));
    }
}

/// What is kept of a run.
#[derive(Clone, Copy, Debug)]
pub struct SampleSpec<'a> {
    /// [s] ascending
    pub times: &'a [f64],
    /// nodes of positions and velocities, below the number of nodes; all if empty
    pub nodes: &'a [u32],
    /// gauges of the case
    pub output: &'a OutputSpec,
    /// [s] end of the run
    pub end: f64,
    /// whether the run ends with the first step that reaches the last of the times
    pub ends_run: bool,
}

/// Samples of a run. They hold no scene, which a program may change between two parts of a run.
#[derive(Debug)]
pub struct Samples<'a, 'o> {
    spec: SampleSpec<'a>,
    /// number of the next time
    next: usize,
    /// whether the newest state is credible
    credible: bool,
    gauges: Gauges,
    arrays: SampleArrays<'o>,
    /// account at the start of the next step
    ledger: Energies,
    between: Point,
    /// [m] and [m/s] of all nodes
    trace: [Vec<[f64; 3]>; 2],
}

impl<'a, 'o> Samples<'a, 'o> {
    /// Of a run that has not begun. Arrays have the lengths of [`SampleArrays`], or are empty.
    ///
    /// # Errors
    /// A quantity that is not there.
    pub fn new(
        picture: &dyn Observables,
        spec: SampleSpec<'a>,
        mut arrays: SampleArrays<'o>,
    ) -> Result<Self, UnknownQuantity> {
        arrays.clear();
        let n = picture.reference().len();
        Ok(Samples {
            spec,
            next: 0,
            credible: true,
            gauges: Gauges::alone(picture, &spec.output.gauges, spec.output.history_every, spec.end)?,
            arrays,
            ledger: Energies::default(),
            between: Point { state: picture.initial_state(), forces: picture.new_forces() },
            trace: [(); 2].map(|()| vec![[0.0; 3]; n]),
        })
    }

    /// The columns of the gauges of a case.
    ///
    /// # Errors
    /// As [`Samples::new`].
    pub fn channels(picture: &dyn Observables, output: &OutputSpec) -> Result<Vec<ChannelName>, UnknownQuantity> {
        Ok(Gauges::alone(picture, &output.gauges, output.history_every, 0.0)?.names())
    }

    /// The columns of the gauges.
    pub fn columns(&self) -> Vec<ChannelName> {
        self.gauges.names()
    }

    /// [s] The times.
    pub fn times(&self) -> &'a [f64] {
        self.spec.times
    }

    /// Shows them the state at which the run begins. Times before it are passed over.
    pub(crate) fn begin(&mut self, picture: &dyn Observables, at: &Point, ledger: Energies) {
        let t = at.state.t;
        self.ledger = ledger;
        let slack = tolerance(t, t);
        self.next = self.spec.times.partition_point(|time| *time < t - slack);
        if self.measures() {
            self.gauges.skip(t);
            // Nothing is written, so nothing fails.
            let _: Result<(), ObserveError> = self.gauges.step(picture, 0, at, true, |_| Ok(()));
        }
        while self.spec.times.get(self.next).is_some_and(|time| *time <= t + slack) {
            self.keep(picture, at, ledger);
        }
    }

    /// The observer of a part of the run.
    pub(crate) fn observing<'s>(&'s mut self, picture: &'s dyn Observables) -> Sampling<'s, 'a, 'o> {
        Sampling { samples: self, picture }
    }

    /// Whether gauges look at every step.
    fn measures(&self) -> bool {
        !self.arrays.peaks.is_empty() || !self.arrays.peak_times.is_empty()
    }

    /// Writes the row of the next time.
    fn keep(&mut self, picture: &dyn Observables, at: &Point, ledger: Energies) {
        let Samples { spec, next, gauges, arrays, trace: [positions, velocities], .. } = self;
        let (number, times) = (*next, spec.times.len());
        let SampleArrays { positions: to_x, velocities: to_v, gauges: to_gauges, energies: to_energies, .. } = arrays;
        if !to_x.is_empty() || !to_v.is_empty() {
            picture.trace(at.state.as_ref(), positions, velocities);
        }
        for (to, from) in [(to_x, &*positions), (to_v, &*velocities)] {
            let rows = row_of(to, number, times).as_chunks_mut::<3>().0.iter_mut();
            match spec.nodes {
                [] => rows.zip(from).for_each(|(to, from)| *to = *from),
                nodes => rows.zip(nodes).for_each(|(to, node)| *to = from[*node as usize]),
            }
        }
        if !to_gauges.is_empty() {
            row_of(to_gauges, number, times).copy_from_slice(gauges.values_at(picture, at));
        }
        if !to_energies.is_empty() {
            row_of(to_energies, number, times).copy_from_slice(&energies(ledger));
        }
        *next += 1;
    }

    /// Writes the row of the next time, at a share of the step between two points.
    fn keep_between(&mut self, picture: &dyn Observables, [start, end]: [&Point; 2], fraction: f64, ledger: Energies) {
        // Moved out and back, because `keep` needs the rest of `self`.
        let mut between = std::mem::take(&mut self.between);
        interpolate(start.state.as_ref(), end.state.as_ref(), fraction, &mut between.state);
        if !self.arrays.gauges.is_empty() {
            picture.evaluate(between.state.as_ref(), &mut between.forces);
        }
        self.keep(picture, &between, ledger);
        self.between = between;
    }
}

/// A row of an array of `rows` rows.
fn row_of(all: &mut [f64], number: usize, rows: usize) -> &mut [f64] {
    let size = all.len() / rows.max(1);
    &mut all[number * size..(number + 1) * size]
}

/// Whether a time lies at the end of a step, up to rounding.
fn at_end(time: f64, from: f64, to: f64) -> bool {
    time >= to - tolerance(from, to)
}

/// Keeps samples of a part of a run.
pub struct Sampling<'s, 'a, 'o> {
    samples: &'s mut Samples<'a, 'o>,
    picture: &'s dyn Observables,
}

impl Observer for Sampling<'_, '_, '_> {
    fn wants(&self, next: UpcomingStep) -> Wants {
        let (UpcomingStep { step, from, t }, samples) = (next, &*self.samples);
        let due = samples.spec.times.get(samples.next).filter(|time| **time <= t + tolerance(from, t));
        let sampled = match due {
            None => States::None,
            Some(time) if at_end(*time, from, t) => States::End,
            Some(_) => States::BothEnds,
        };
        let measured = Wants::end_if(samples.measures() && samples.gauges.wants(step, [from, t]));
        Wants { states: sampled.max(measured.states), strain: false }
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        let Sampling { samples, picture } = self;
        if samples.measures() {
            samples.gauges.accepted(*picture, step, |_| Ok(()))?;
        }
        let (from, to, before) = (step.from, step.t, std::mem::replace(&mut samples.ledger, step.ledger));
        samples.credible = step.credible;
        let due = |samples: &Samples<'_, '_>| {
            let time = samples.spec.times.get(samples.next).copied();
            time.filter(|time| *time <= to + tolerance(from, to))
        };
        while let Some(time) = due(samples) {
            match (step.start, step.end) {
                (_, Some(end)) if step.credible && at_end(time, from, to) => samples.keep(*picture, end, step.ledger),
                (Some(start), Some(end)) if step.credible => {
                    let fraction = ((time - from) / (to - from)).clamp(0.0, 1.0);
                    let ledger = between(before, step.ledger, fraction);
                    samples.keep_between(*picture, [start, end], fraction, ledger);
                }
                // The run gives every state that is wanted, so this one is not credible.
                _ => samples.next += 1,
            }
        }
        Ok(())
    }

    fn ends_run(&self) -> bool {
        // A run that is about to fail goes on until it is known why.
        let Samples { spec, next, credible, .. } = &*self.samples;
        spec.ends_run && *credible && *next >= spec.times.len()
    }

    fn finished(&mut self, _last: &Point) -> Result<(), ObserveError> {
        let Samples { gauges, arrays: SampleArrays { peaks, peak_times, .. }, .. } = &mut *self.samples;
        for (number, [peak, t]) in gauges.extremes().enumerate() {
            peaks.get_mut(number).into_iter().for_each(|to| *to = peak);
            peak_times.get_mut(number).into_iter().for_each(|to| *to = t);
        }
        Ok(())
    }
}

/// The account at a share of a step.
fn between(before: Energies, after: Energies, share: f64) -> Energies {
    let part = |of: fn(&Energies) -> f64| of(&before) + share * (of(&after) - of(&before));
    Energies {
        kinetic: part(|of| of.kinetic),
        elastic: part(|of| of.elastic),
        gravity: part(|of| of.gravity),
        external_work: part(|of| of.external_work),
        dissipated: part(|of| of.dissipated),
        numerical: part(|of| of.numerical),
    }
}
