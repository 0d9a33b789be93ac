//! The largest values of a run, measured without any file.

use serde::{Deserialize, Serialize};

use super::gauges::{Gauges, GaugesSoFar, GaugesSpec, MeasuredQuantity, Peak};
use super::quantity::UnknownQuantity;
use super::schedule::Schedule;
use crate::case::spec::OutputSpec;
use crate::drive::event::Fired;
use crate::drive::observer::{AcceptedStep, Energies, ObserveError, Observer, Point, States, UpcomingStep, Wants};
use crate::model::observables::Observables;

/// What is kept from step to step; part of a snapshot.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LargestSoFar {
    /// [m/s] largest speed of a node
    pub speed: f64,
    /// [-] largest strain of a spring
    pub strain: f64,
    /// those of the gauges
    gauges: GaugesSoFar,
}

/// The observer that measures the gauges of a case, the largest speed and the largest strain. Only credible states
/// count.
pub struct LargestValues<'a> {
    picture: &'a dyn Observables,
    gauges: Gauges,
    /// the frames of the case, at which a run may be saved
    frames: Schedule,
    frames_every: Option<f64>,
    speed: f64,
    strain: f64,
    failed: bool,
    /// whether the largest speed and strain are measured
    of_scene: bool,
}

impl<'a> LargestValues<'a> {
    /// Of a run to `end` [s]; `so_far` is what an earlier part of it has measured.
    ///
    /// # Errors
    /// A quantity of the case that is not there.
    pub fn new(
        picture: &'a dyn Observables,
        output: &OutputSpec,
        end: f64,
        so_far: Option<&LargestSoFar>,
    ) -> Result<Self, UnknownQuantity> {
        let mut gauges = Gauges::new(picture, &GaugesSpec::of(output, end))?;
        let LargestSoFar { speed, strain, gauges: kept } = so_far.cloned().unwrap_or_default();
        gauges.take_up(&kept);
        let frames_every = output.frames_every;
        let frames = Schedule::new(frames_every, 0.0);
        Ok(LargestValues { picture, gauges, frames, frames_every, speed, strain, failed: false, of_scene: true })
    }

    /// For quantities alone: without the largest speed and strain, and without the states at frames.
    ///
    /// # Errors
    /// As [`LargestValues::new`].
    pub fn of_quantities(
        picture: &'a dyn Observables,
        output: &OutputSpec,
        end: f64,
        so_far: Option<&LargestSoFar>,
    ) -> Result<Self, UnknownQuantity> {
        let all = LargestValues::new(picture, output, end, so_far)?;
        Ok(LargestValues { frames: Schedule::new(None, 0.0), frames_every: None, of_scene: false, ..all })
    }

    /// What was measured so far.
    pub fn so_far(&self) -> LargestSoFar {
        LargestSoFar { speed: self.speed, strain: self.strain, gauges: self.gauges.kept() }
    }

    /// The peaks of the gauges.
    pub fn peaks(&self) -> Vec<Peak> {
        self.gauges.peaks()
    }

    /// The quantities of the run.
    pub fn quantities(&self) -> Vec<MeasuredQuantity> {
        self.gauges.quantities()
    }

    fn note(&mut self, speed: f64, strain: f64) {
        self.speed = self.speed.max(speed);
        self.strain = self.strain.max(strain);
    }
}

impl Observer for LargestValues<'_> {
    fn started(&mut self, at: &Point, ledger: Energies) -> Result<(), ObserveError> {
        let state = at.state.as_ref();
        self.note(self.picture.max_speed(state), self.picture.max_strain(state));
        self.gauges.skip(state.t);
        self.gauges.account(state.t, ledger);
        self.gauges.step(self.picture, 0, at, true, |_| Ok(()))
    }

    fn resumed(&mut self, at: &Point, _ledger: Energies) -> Result<(), ObserveError> {
        self.frames = Schedule::new(self.frames_every, at.state.t);
        self.gauges.skip(at.state.t);
        Ok(())
    }

    fn wants(&self, step: UpcomingStep) -> Wants {
        let frame = self.frames.states(step) != States::None;
        let measured = self.gauges.wants(step.step, [step.from, step.t]);
        Wants { strain: self.of_scene, ..Wants::end_if(frame || measured) }
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        while self.frames.next_in(step.from, step.t).is_some() {}
        if step.credible && self.of_scene {
            self.note(step.max_speed(self.picture), step.max_strain(self.picture));
        }
        self.gauges.accepted(self.picture, step, |_| Ok(()))
    }

    fn event(&mut self, event: &Fired) -> Result<(), ObserveError> {
        self.gauges.event(event);
        Ok(())
    }

    fn failed(&mut self) -> Result<(), ObserveError> {
        self.failed = true;
        Ok(())
    }

    fn finished(&mut self, last: &Point) -> Result<(), ObserveError> {
        self.gauges.last(self.picture, last, !self.failed, |_| Ok(()))
    }
}
