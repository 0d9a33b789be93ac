//! When what is given over time changes: loads, wind, base, rest lengths, canopies, and events.

use super::{NetworkSpec, Series};

impl NetworkSpec {
    /// [s] Times at which a force has a corner or a jump in time, ascending: rows of tables, begin, peak and end of
    /// gusts and begin and end of the stages of canopies, and events. The peak is there for steps as long as a gust.
    pub fn corners(&self) -> Vec<f64> {
        let gusts = self.stream.iter().flat_map(|stream| &stream.gusts);
        let gusts = gusts.flat_map(|gust| [0.0, 0.5, 1.0].map(|share| gust.start + share * gust.duration));
        let stages = self.stages().flatten();
        let rows =
            self.factors().flat_map(|factor| &factor.t).chain(self.vectors().flat_map(|table| &table.t)).copied();
        super::ascending(rows.chain(gusts).chain(stages).chain(self.events()).collect())
    }

    /// [s] Beginnings and ends of all changes; they are equal for an event.
    pub fn changing(&self) -> Vec<[f64; 2]> {
        let gusts = self.stream.iter().flat_map(|stream| &stream.gusts);
        let gusts = gusts.map(|gust| [gust.start, gust.start + gust.duration]);
        let moved = self.motions.iter().flat_map(|motion| motion.displacement.changing());
        let factors = self.factors().flat_map(Series::changing);
        let tables = self.vectors().flat_map(Series::changing).chain(factors).chain(moved);
        tables.chain(gusts).chain(self.stages()).chain(self.divisions().into_iter().map(|t| [t, t])).collect()
    }

    /// Tables of factors of loads and of rest lengths.
    fn factors(&self) -> impl Iterator<Item = &Series<f64>> {
        let loads = self.pressures.iter().map(|load| &load.factor).chain(self.forces.iter().map(|load| &load.factor));
        loads.flatten().chain(self.springs.iter().filter_map(|group| group.rest_scale.as_ref()))
    }

    /// Tables of the wind and of the base.
    fn vectors(&self) -> impl Iterator<Item = &Series<[f64; 3]>> {
        let winds = self.air.iter().map(|air| &air.wind).chain(self.stream.iter().map(|stream| &stream.wind));
        winds.chain(&self.base_acceleration)
    }

    /// [s] Beginnings and ends of the stages of canopies.
    fn stages(&self) -> impl Iterator<Item = [f64; 2]> {
        let stages = self.canopies.iter().flat_map(|canopy| canopy.air.stages());
        stages.map(|stage| [stage.start, stage.start + stage.duration])
    }
}
