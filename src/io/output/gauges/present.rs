//! What gauges show of a state, for programs that keep the values themselves.

use super::{Channel, Gauges, GaugesSpec};
use crate::case::spec::{GaugeSpec, RowEvery, StagesSpec};
use crate::model::observables::Observables;
use crate::model::point::Point;
use crate::output::quantity::UnknownQuantity;

/// A column of values that gauges of a case have.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChannelName {
    /// name of the gauge
    pub gauge: String,
    /// name of the column
    pub quantity: &'static str,
    /// its unit
    pub unit: &'static str,
}

impl From<&Channel> for ChannelName {
    fn from(channel: &Channel) -> Self {
        let (quantity, unit) = (channel.quantity.name, channel.quantity.unit);
        ChannelName { gauge: channel.name.clone(), quantity, unit }
    }
}

impl Gauges {
    /// Those of a case in a run to `end` [s] and those of its canopies, without quantities and stages.
    pub(in crate::output) fn alone(
        picture: &dyn Observables,
        gauges: &[GaugeSpec],
        history: RowEvery,
        end: f64,
    ) -> Result<Self, UnknownQuantity> {
        let stages = StagesSpec::default();
        Gauges::new(picture, &GaugesSpec { gauges, probes: &[], quantities: &[], stages: &stages, history, end })
    }

    /// The columns that are shown.
    pub(in crate::output) fn names(&self) -> Vec<ChannelName> {
        self.channels().iter().map(ChannelName::from).collect()
    }

    /// The values of these columns in a state.
    pub(in crate::output) fn values_at(&mut self, picture: &dyn Observables, at: &Point) -> &[f64] {
        let [gauges, channels] = self.shown;
        for gauge in self.gauges.iter_mut().take(gauges) {
            gauge.places.measure(picture, at, &mut self.values[gauge.channels.clone()]);
        }
        &self.values[..channels]
    }

    /// The peak of each of these columns so far, and its time [s]; NaN where nothing was measured.
    pub(in crate::output) fn extremes(&self) -> impl Iterator<Item = [f64; 2]> {
        self.series.iter().take(self.shown[1]).map(|series| [series.peak, series.peak_time])
    }
}
