//! The quantities of a run as sums of values at the ends of steps, and the derivatives of these values with respect to
//! the state there: what an adjoint run begins with.

use super::derivatives::{NoDerivative, with_derivatives};
use super::quantities::Source;
use super::{Gauges, GaugesSpec};
use crate::model::point::Point;
use crate::model::quantity::Statistic;
use crate::scene::{Adjoint, Scene};
use crate::sensitivity::Seed;
use std::collections::BTreeMap;
use std::convert::Infallible;

/// A quantity of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct SeededQuantity {
    /// its name
    pub name: String,
    /// its unit
    pub unit: &'static str,
    /// its value; `None` where the run did not come to it
    pub value: Option<f64>,
    /// [s] when a peak was reached
    pub peak_time: Option<f64>,
    channel: usize,
}

/// A quantity that a state has a share in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// which quantity
    pub quantity: usize,
    /// [-] weight of the value at this state in it
    pub weight: f64,
}

/// The shares of states in quantities, by the number of their step.
pub type Shares = BTreeMap<u64, Vec<Share>>;

/// The gauges of a run with all of their values.
#[derive(Debug)]
pub struct GaugeSeeds {
    gauges: Gauges,
    /// number of the step that each measured state is the end of; 0 is the start
    steps: Vec<u64>,
    /// [s]
    times: Vec<f64>,
    /// of each channel
    values: Vec<Vec<f64>>,
}

impl GaugeSeeds {
    /// Those of the quantities that a case asks for.
    ///
    /// # Errors
    /// A quantity that is not there or has no derivative.
    pub fn new(scene: &dyn Scene, spec: &GaugesSpec<'_>) -> Result<Self, NoDerivative> {
        let gauges = with_derivatives(scene, spec)?;
        let values = vec![Vec::new(); gauges.channels.len()];
        Ok(GaugeSeeds { gauges, steps: Vec::new(), times: Vec::new(), values })
    }

    /// Whether the end of a step is measured.
    pub fn wants(&self, step: u64, times: [f64; 2]) -> bool {
        step == 0 || self.gauges.wants(step, times)
    }

    /// Measures the end of step number `step`; 0 is the start.
    pub fn measure(&mut self, scene: &dyn Scene, step: u64, at: &Point) {
        let Ok(()) = self.gauges.step(scene, step, at, true, |_| Ok::<(), Infallible>(()));
        self.keep(step, at.state.t);
    }

    /// Measures the last state, the end of step number `step`, if no step has.
    pub fn measure_last(&mut self, scene: &dyn Scene, step: u64, at: &Point) {
        if self.times.last() != Some(&at.state.t) {
            let Ok(()) = self.gauges.last(scene, at, true, |_| Ok::<(), Infallible>(()));
            self.keep(step, at.state.t);
        }
    }

    fn keep(&mut self, step: u64, t: f64) {
        self.steps.push(step);
        self.times.push(t);
        self.values.iter_mut().zip(&self.gauges.values).for_each(|(all, value)| all.push(*value));
    }

    /// The quantities of the run, and which states have a share in them.
    ///
    /// # Errors
    /// A quantity without value, or whose gauge had none at some time.
    pub fn finish(&self) -> Result<(Vec<SeededQuantity>, Shares), NoDerivative> {
        let (end, measured) = (self.gauges.end, self.gauges.quantities());
        let mut shares = Shares::new();
        let mut quantities = Vec::new();
        for (quantity, (name, source, statistic)) in self.gauges.quantities.wanted().enumerate() {
            let without = |why| NoDerivative::Without { name: name.to_owned(), why };
            let channel = self.gauges.channel_of(source).ok_or_else(|| without("it has no value"))?;
            let (series, values) = (&self.gauges.series[channel], &self.values[channel]);
            if !values.iter().all(|value| value.is_finite()) {
                return Err(without("its gauge has no value at some time of the run"));
            }
            let weights = series.weights(statistic, (&self.times, values), end);
            for (step, &weight) in self.steps.iter().zip(&weights).filter(|(_, weight)| **weight != 0.0) {
                shares.entry(*step).or_default().push(Share { quantity, weight });
            }
            let own = measured.iter().find(|of| of.name == name);
            quantities.push(SeededQuantity {
                name: name.to_owned(),
                unit: own.map_or("", |own| own.unit),
                value: own.and_then(|own| own.value),
                peak_time: (statistic == Statistic::Peak).then_some(series.peak_time),
                channel,
            });
        }
        Ok((quantities, shares))
    }

    /// The derivatives of the value of a quantity at a state, which has a share in it.
    ///
    /// # Errors
    /// A gauge whose derivative is not known.
    pub fn seed(
        &mut self,
        quantity: &SeededQuantity,
        (scene, adjoint): (&dyn Scene, &dyn Adjoint),
        at: &Point,
    ) -> Result<Seed, NoDerivative> {
        let found = self.gauges.gauges.iter_mut().find(|gauge| gauge.channels.contains(&quantity.channel));
        let without = |why| NoDerivative::Without { name: quantity.name.clone(), why };
        let gauge = found.ok_or_else(|| without("it has no gauge"))?;
        let column = quantity.channel - gauge.channels.start;
        gauge.places.seed((scene, adjoint), (column, gauge.channels.len()), at).map_err(without)
    }
}

impl Gauges {
    /// The channel that a quantity is made of, with the largest peak of several.
    pub(super) fn channel_of(&self, source: &Source) -> Option<usize> {
        match source {
            Source::Channel(channel) => Some(*channel),
            Source::Channels(several) => {
                let peak = |channel: &usize| self.series[*channel].peak;
                several.iter().copied().max_by(|a, b| peak(a).total_cmp(&peak(b)))
            }
            _ => None,
        }
    }
}
