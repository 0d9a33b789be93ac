//! What a program sees of a simulation besides its nodes: accelerations, gauges, and their peaks so far.

use super::{Changed, Simulation, SimulationError};
use crate::case::spec::OutputSpec;
use crate::drive::observer::{AcceptedStep, Observer, Point};
use crate::model::gauge::NodeQuantity;
use crate::output::gauges::{ChannelName, GaugesSoFar, Peak};
use crate::output::live::LiveGauges;
use std::borrow::Cow;

/// What a gauge shows.
#[derive(Clone, Debug, PartialEq)]
pub struct GaugeValue {
    /// gauge, column and unit
    pub of: ChannelName,
    /// the value, in that unit
    pub value: f64,
}

impl Simulation {
    /// [m/s^2] Accelerations, `[n_nodes][3]`: of the forces that act now; 0 in held directions.
    pub fn accelerations(&self) -> Vec<[f64; 3]> {
        let at = self.present();
        let all = 0..self.node_count() as u32;
        all.map(|node| self.scene.node_value(NodeQuantity::Acceleration, &at, node)).collect()
    }

    /// Measures the gauges of a case, and those of canopies, from the present state on. Gauges of the case look at
    /// every step; steps are then not made in blocks. Peaks begin anew with [`Simulation::set_state`], and are part of
    /// snapshots.
    ///
    /// # Errors
    /// A gauge that measures what the scene does not have.
    pub fn measure(&mut self, output: &OutputSpec) -> Result<(), SimulationError> {
        let start = (&self.state.from, self.state.row);
        self.gauges = Some(LiveGauges::new(&*self.scene, output, self.spec.end, start)?);
        Ok(())
    }

    /// The columns of the gauges; none before [`Simulation::measure`].
    pub fn channels(&self) -> Vec<ChannelName> {
        self.gauges.as_ref().map(LiveGauges::channels).unwrap_or_default()
    }

    /// What the gauges show of the present state, with the forces that act now.
    pub fn gauges(&mut self) -> Vec<GaugeValue> {
        let changed = self.changed_point();
        let (scene, at) = (&*self.scene, changed.as_ref().unwrap_or(&self.state.from));
        let Some(gauges) = &mut self.gauges else { return Vec::new() };
        let values = gauges.values_at(scene, at);
        gauges.channels().into_iter().zip(values).map(|(of, value)| GaugeValue { of, value }).collect()
    }

    /// The peaks of the gauges so far, over all steps since [`Simulation::measure`].
    pub fn peaks(&self) -> Vec<Peak> {
        self.gauges.as_ref().map(LiveGauges::peaks).unwrap_or_default()
    }

    /// The present point, with the forces that act now.
    fn present(&self) -> Cow<'_, Point> {
        self.changed_point().map_or(Cow::Borrowed(&self.state.from), Cow::Owned)
    }

    /// The same, where values were changed since the last step.
    pub(super) fn changed_point(&self) -> Option<Point> {
        if self.changed == Changed::Nothing {
            return None;
        }
        let mut at = Point { state: self.state.from.state.clone(), forces: self.scene.new_forces() };
        self.scene.evaluate(at.state.as_ref(), &mut at.forces);
        Some(at)
    }

    /// Gauges begin anew at the present state, or go on from what was measured up to it.
    pub(super) fn measure_from_here(&mut self, so_far: Option<&GaugesSoFar>) -> Result<(), SimulationError> {
        let Simulation { gauges, scene, state, .. } = self;
        Ok(gauges.as_mut().map_or(Ok(()), |gauges| gauges.begin(&**scene, (&state.from, state.row), so_far))?)
    }

    /// Measures the step that was accepted, which began at `from` [s].
    pub(super) fn measure_step(&mut self, from: f64) {
        let Simulation { gauges, scene, state, .. } = self;
        let Some(gauges) = gauges else { return };
        let (step, end) = (state.steps, &state.from);
        let accepted = AcceptedStep {
            step,
            from,
            t: end.state.t,
            ledger: state.row,
            end: Some(end),
            credible: true,
            ..AcceptedStep::default()
        };
        // Gauges write nothing, so nothing fails.
        let _ = gauges.observing(&**scene).accepted(accepted);
    }

    /// Makes steps with the gauges among the observers, and one more.
    pub(super) fn watched<R>(
        &mut self,
        observers: &mut [&mut dyn Observer],
        more: Option<&mut dyn Observer>,
        act: impl FnOnce(&mut Self, &mut [&mut dyn Observer]) -> R,
    ) -> R {
        let (mut gauges, scene) = (self.gauges.take(), self.scene.clone());
        let mut observing = gauges.as_mut().map(|gauges| gauges.observing(&*scene));
        let mut all: Vec<&mut dyn Observer> = observers.iter_mut().map(|o| &mut **o as &mut dyn Observer).collect();
        all.extend(observing.as_mut().map(|observing| observing as &mut dyn Observer));
        all.extend(more.map(|more| more as &mut dyn Observer));
        let done = act(self, &mut all);
        drop(all);
        self.gauges = gauges;
        done
    }
}
