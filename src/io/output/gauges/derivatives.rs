//! Derivatives of the quantities of a run with respect to parameters, from those of its gauges at the ends of steps.
//!
//! A peak and a least value are those of a step, so that their derivatives are those of the gauge in that step: the
//! time of a peak moves by whole steps only. Means and values at a time are sums of values with fixed weights.

use super::quantities::Source;
use super::{Gauges, GaugesSpec};
use crate::model::observables::Observables;
use crate::model::point::Point;
use crate::model::quantity::Statistic;
use crate::output::quantity::UnknownQuantity;
use crate::output::statistics::SeriesSoFar;
use crate::sensitivity::difference::{Slope, slope};
use std::convert::Infallible;

/// Why the quantities of a run have no derivatives.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NoDerivative {
    /// There is no such quantity.
    #[error(transparent)]
    Unknown(#[from] UnknownQuantity),
    /// It is there, without a derivative.
    #[error("{name} has no derivative: {why}")]
    Without {
        /// its name
        name: String,
        /// why
        why: &'static str,
    },
}

/// A quantity of a run and its derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantityDerivatives {
    /// its name
    pub name: String,
    /// its unit
    pub unit: &'static str,
    /// its value; `None` where the run did not come to it
    pub value: Option<f64>,
    /// [s] when a peak was reached
    pub peak_time: Option<f64>,
    /// its derivatives with respect to all parameters
    pub slopes: Vec<Slope>,
}

/// The derivatives of a channel with respect to a parameter so far.
#[derive(Clone, Debug, Default)]
struct Track {
    peak: Slope,
    min: Slope,
    last: Slope,
    /// the derivatives as a series of their own
    series: SeriesSoFar,
    switches: bool,
}

/// The gauges of a run, with the derivatives of their channels.
#[derive(Debug)]
pub struct GaugeDerivatives {
    gauges: Gauges,
    /// the series before the last state
    before: Vec<SeriesSoFar>,
    /// of each parameter, each channel
    tracks: Vec<Vec<Track>>,
    /// of each parameter, each quantity that is caught on the way
    caught: Vec<Vec<Option<Slope>>>,
    /// the values of a parameter's scenes at their places, by channel
    values: [Vec<f64>; 4],
    measured: f64,
}

/// The gauges of the quantities that a case asks for.
///
/// # Errors
/// A quantity that is not there or has no derivative.
pub(super) fn with_derivatives(picture: &dyn Observables, spec: &GaugesSpec<'_>) -> Result<Gauges, NoDerivative> {
    let gauges = Gauges::new(picture, spec)?;
    for (name, source, statistic) in gauges.quantities.wanted() {
        let why = match (source, statistic) {
            (_, Statistic::PeakTime) => "it is a time, and falls on steps",
            (Source::Channel(_) | Source::Channels(_), _) => continue,
            (Source::Energy(_), _) => "it is a sum over the steps of the account",
            (Source::Motion, _) => "it is no number",
            (Source::DisplacementEnd, _) => "name a gauge or a probe of the nodes",
            (Source::Landing(_), _) => "the time of the landing moves",
        };
        return Err(NoDerivative::Without { name: name.to_owned(), why });
    }
    Ok(gauges)
}

impl GaugeDerivatives {
    /// Those of the quantities that a case asks for, with respect to some parameters.
    ///
    /// # Errors
    /// A quantity that is not there or has no derivative.
    pub fn new(picture: &dyn Observables, spec: &GaugesSpec<'_>, parameters: usize) -> Result<Self, NoDerivative> {
        let gauges = with_derivatives(picture, spec)?;
        let (channels, found) = (gauges.channels.len(), gauges.quantities.wanted().count());
        Ok(GaugeDerivatives {
            before: gauges.series.clone(),
            tracks: vec![vec![Track::default(); channels]; parameters],
            caught: vec![vec![None; found]; parameters],
            values: [(); 4].map(|()| vec![f64::NAN; channels]),
            measured: f64::NAN,
            gauges,
        })
    }

    /// Whether the end of a step is measured.
    pub fn wants(&self, step: u64, times: [f64; 2]) -> bool {
        step == 0 || self.gauges.wants(step, times)
    }

    /// Measures the end of step number `step`; 0 is the start.
    pub fn measure(&mut self, picture: &dyn Observables, step: u64, at: &Point) {
        self.before.clone_from(&self.gauges.series);
        let Ok(()) = self.gauges.step(picture, step, at, true, |_| Ok::<(), Infallible>(()));
        self.measured = at.state.t;
    }

    /// Measures the last state, if no step has; returns whether it did.
    pub fn measure_last(&mut self, picture: &dyn Observables, at: &Point) -> bool {
        if self.measured == at.state.t {
            return false;
        }
        self.before.clone_from(&self.gauges.series);
        let Ok(()) = self.gauges.last(picture, at, true, |_| Ok::<(), Infallible>(()));
        self.measured = at.state.t;
        true
    }

    /// Measures one of the four states along a derivative of the state that was measured last.
    pub fn measure_at(&mut self, place: usize, picture: &dyn Observables, at: &Point) {
        let Some(values) = self.values.get_mut(place) else { return };
        for gauge in &mut self.gauges.gauges {
            gauge.places.measure(picture, at, &mut values[gauge.channels.clone()]);
        }
    }

    /// Adds the derivatives from these four states, `h` apart.
    pub fn note(&mut self, parameter: usize, h: f64) {
        let (Some(tracks), Some(caught)) = (self.tracks.get_mut(parameter), self.caught.get_mut(parameter)) else {
            return;
        };
        let (t, end) = (self.measured, self.gauges.end);
        for (number, track) in tracks.iter_mut().enumerate() {
            let (value, after, before) =
                (self.gauges.values[number], &self.gauges.series[number], &self.before[number]);
            if !value.is_finite() {
                continue;
            }
            let found = slope(self.values.each_ref().map(|values| values[number]), value, h);
            for ((_, source, statistic), caught) in self.gauges.quantities.wanted().zip(caught.iter_mut()) {
                if let Statistic::At(time) = statistic
                    && *source == Source::Channel(number)
                    && caught.is_none()
                    && time <= t
                {
                    let value = track.series.at(time, t, found.value);
                    let sides = if time == t { found.sides } else { [value; 2] };
                    *caught = Some(Slope { value, sides, ..found });
                }
            }
            if after.peak_time == t && before.peak_time != t {
                track.peak = found;
            }
            if after.min == value && before.min != value {
                track.min = found;
            }
            track.last = found;
            track.switches |= found.switches;
            track.series.note(t, found.value, self.gauges.channels[number].quantity.peak, end);
        }
    }

    /// All quantities with their derivatives.
    pub fn results(&self) -> Vec<QuantityDerivatives> {
        let end = self.gauges.end;
        let of = |(number, (name, source, statistic)): (usize, (&str, &Source, Statistic))| {
            let channel = self.gauges.channel_of(source)?;
            let series = self.gauges.series.get(channel)?;
            let slopes = self.tracks.iter().zip(&self.caught).map(|(tracks, caught)| {
                let track = &tracks[channel];
                let Track { peak, min, series, switches, .. } = track;
                match statistic {
                    Statistic::Peak | Statistic::PeakTime => *peak,
                    Statistic::Min => *min,
                    Statistic::At(_) => caught[number].unwrap_or(Slope::smooth(f64::NAN)),
                    Statistic::Last => track.last,
                    other => {
                        let value = series.statistic(other, end).unwrap_or(f64::NAN);
                        Slope { switches: *switches, ..Slope::smooth(value) }
                    }
                }
            });
            let measured = self.gauges.quantities().into_iter().find(|quantity| quantity.name == name)?;
            Some(QuantityDerivatives {
                name: name.to_owned(),
                unit: measured.unit,
                value: measured.value,
                peak_time: (statistic == Statistic::Peak).then_some(series.peak_time),
                slopes: slopes.collect(),
            })
        };
        self.gauges.quantities.wanted().enumerate().filter_map(of).collect()
    }
}
