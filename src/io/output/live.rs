//! The gauges of a simulation that a program drives: what they show, and their peaks so far.

use super::gauges::{ChannelName, Gauges, GaugesSoFar, Peak};
use super::quantity::UnknownQuantity;
use crate::case::spec::{GaugeSpec, OutputSpec, RowEvery};
use crate::drive::observer::{AcceptedStep, Energies, ObserveError, Observer, UpcomingStep, Wants};
use crate::model::observables::Observables;
use crate::model::point::Point;

/// The gauges of a case. They look at every step, as in `canopy-fem solve`; canopies alone at the rows of the history.
#[derive(Debug)]
pub struct LiveGauges {
    specs: Vec<GaugeSpec>,
    history: RowEvery,
    /// [s] end of the run
    end: f64,
    gauges: Gauges,
}

impl LiveGauges {
    /// Those of a run to `end` [s] that begins at a state.
    ///
    /// # Errors
    /// A quantity that is not there.
    pub fn new(
        picture: &dyn Observables,
        output: &OutputSpec,
        end: f64,
        start: (&Point, Energies),
    ) -> Result<Self, UnknownQuantity> {
        let (specs, history) = (output.gauges.clone(), output.history_every);
        let gauges = Gauges::alone(picture, &specs, history, end)?;
        let mut made = LiveGauges { specs, history, end, gauges };
        made.first(picture, start);
        Ok(made)
    }

    /// Begins anew at a state, or goes on from what was measured up to it.
    ///
    /// # Errors
    /// As [`LiveGauges::new`].
    pub fn begin(
        &mut self,
        picture: &dyn Observables,
        start: (&Point, Energies),
        so_far: Option<&GaugesSoFar>,
    ) -> Result<(), UnknownQuantity> {
        self.gauges = Gauges::alone(picture, &self.specs, self.history, self.end)?;
        self.first(picture, start);
        so_far.into_iter().for_each(|kept| self.gauges.take_up(kept));
        Ok(())
    }

    fn first(&mut self, picture: &dyn Observables, (at, ledger): (&Point, Energies)) {
        self.gauges.skip(at.state.t);
        self.gauges.account(at.state.t, ledger);
        // Nothing is written, so nothing fails.
        let _: Result<(), ObserveError> = self.gauges.step(picture, 0, at, true, |_| Ok(()));
    }

    /// What was measured so far.
    pub fn so_far(&self) -> GaugesSoFar {
        self.gauges.kept()
    }

    /// The columns.
    pub fn channels(&self) -> Vec<ChannelName> {
        self.gauges.names()
    }

    /// Their values in a state.
    pub fn values_at(&mut self, picture: &dyn Observables, at: &Point) -> Vec<f64> {
        self.gauges.values_at(picture, at).to_vec()
    }

    /// The peaks so far.
    pub fn peaks(&self) -> Vec<Peak> {
        self.gauges.peaks()
    }

    /// The observer of a run of this scene.
    pub fn observing<'a>(&'a mut self, picture: &'a dyn Observables) -> Observing<'a> {
        Observing { gauges: &mut self.gauges, picture }
    }
}

/// Measures the steps of a run.
pub struct Observing<'a> {
    gauges: &'a mut Gauges,
    picture: &'a dyn Observables,
}

impl Observer for Observing<'_> {
    fn wants(&self, next: UpcomingStep) -> Wants {
        Wants::end_if(self.gauges.wants(next.step, [next.from, next.t]))
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        self.gauges.accepted(self.picture, step, |_| Ok(()))
    }
}
