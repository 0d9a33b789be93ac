//! The state of a simulation as bytes, and a simulation that goes on from them.

use super::{Changed, RunState, Simulation, SimulationError};
use crate::checksum::{self, ChecksumError, RunningChecksum};
use crate::drive::Snapshot;
use crate::model::stop::Stop;
use crate::scene::{ExternalForces, ExternalKind, Load};
use serde::{Deserialize, Serialize};

/// What [`Simulation::snapshot`] writes.
#[derive(Serialize, Deserialize)]
struct Saved {
    made_by: Origin,
    snapshot: Snapshot,
    /// [N] forces that are fixed values
    forces: Vec<(String, Vec<[f64; 3]>)>,
    /// [m/s]
    wind: Option<[f64; 3]>,
    loads: Vec<(Load, f64)>,
    /// `[n_edges]`
    rest_length_factors: Vec<f64>,
}

/// What a snapshot must fit.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Origin {
    /// method with the values of its parameters
    method: (String, Vec<f64>),
    /// checksum of masses, stiffnesses and start positions
    scene: u32,
}

/// Program and version, at the beginning of a snapshot.
const PROGRAM: &str = concat!("canopy-fem state ", env!("CARGO_PKG_VERSION"));

impl Simulation {
    /// Goes on from a snapshot, with a scheme that starts anew and then takes up what it carried.
    pub(super) fn take_up(&mut self, snapshot: Snapshot) -> Result<(), SimulationError> {
        let mut stepper = self.settings.stepper(&*self.scene)?;
        let state = RunState::restore(&*self.scene, &mut stepper, self.settings.spec(), snapshot)?;
        (self.state, self.scheme, self.pending) = (state, Some(stepper.unbind()), None);
        self.changed = Changed::Nothing;
        Ok(())
    }

    /// The whole state as bytes, with forces, factors and wind that were set. A simulation of the same scene and
    /// settings goes on from it with the same bits as this one. A matrix that an implicit method has kept over a change
    /// of wind, loads or rest lengths is not in it: it is made again here and there.
    ///
    /// # Errors
    /// When an attempted step waits.
    pub fn snapshot(&mut self) -> Result<Vec<u8>, SimulationError> {
        self.idle()?;
        let snapshot = self.at_work(Stop::NEVER, |run, stepper| {
            stepper.drop_unsaved();
            run.state.snapshot(stepper)
        })?;
        let forces = self.scene.external().map(ExternalForces::values).unwrap_or_default();
        let (loads, rest_length_factors) = (self.load_factors(), self.rest_length_factors());
        let made_by = self.origin();
        let saved = Saved { made_by, snapshot, forces, wind: self.wind, loads, rest_length_factors };
        let mut bytes = Vec::new();
        postcard::to_io(&(PROGRAM, saved), &mut bytes).map_err(|error| SimulationError::Snapshot(error.to_string()))?;
        checksum::append(&mut bytes);
        Ok(bytes)
    }

    fn origin(&self) -> Origin {
        let method = &self.settings.method;
        let mut checksum = RunningChecksum::default();
        // The scene as it is before its events: a snapshot may be of another time than the present one.
        self.scene.pass_events(0);
        let (stiffness, x) = (self.scene.nodal_stiffness(), self.scene.initial_state().x);
        for numbers in [self.scene.inverse_mass(), &stiffness, &x] {
            checksum.add(bytemuck::cast_slice(numbers));
        }
        self.scene.pass_events(self.state.events_passed());
        Origin {
            method: (method.info.name.to_owned(), method.parameters().map(|(_, value)| value).collect()),
            scene: checksum.mark().crc,
        }
    }

    /// Goes on from the bytes of [`Simulation::snapshot`]. Laws of the program stay as they are, and so does what the
    /// settings say of the end of the run.
    ///
    /// # Errors
    /// Bytes that are damaged, of another version or method, of a scene with other nodes, masses or stiffnesses, or of
    /// a run with another step; the state is then unchanged. Other tables, damping or air are not noticed.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), SimulationError> {
        let unreadable = |why: &str| SimulationError::Snapshot(why.to_owned());
        let content = checksum::verified(bytes).map_err(|error| match error {
            ChecksumError::Missing => unreadable("it is cut short"),
            ChecksumError::Differs { .. } => unreadable("its checksum is wrong"),
        })?;
        let (program, saved): (String, Saved) =
            postcard::from_bytes(content).map_err(|error| unreadable(&error.to_string()))?;
        if program != PROGRAM {
            return Err(unreadable(&format!("it is of \"{program}\", and this is \"{PROGRAM}\"")));
        }
        let Saved { made_by, snapshot, forces, wind, loads, rest_length_factors } = saved;
        self.settings.spec().passes(&*self.scene, &snapshot)?;
        let own = self.origin();
        if made_by.method != own.method {
            let ((theirs, parameters), (name, values)) = (made_by.method, own.method);
            return Err(unreadable(&format!(
                "it is of {theirs} with parameters {parameters:?}, and this simulation has {name} with {values:?}"
            )));
        }
        if made_by.scene != own.scene {
            return Err(unreadable("it is of a scene with other positions, masses or stiffnesses"));
        }
        for (_, force) in &forces {
            self.check("force of the snapshot", force)?;
        }
        loads.iter().try_for_each(|(load, factor)| self.scale_of(*load, *factor).map(|_| ()))?;
        if rest_length_factors.len() != self.edges().len() {
            return Err(unreadable("it is of a scene with other edges"));
        }
        self.pending = None;
        self.put_rest_length_factors(rest_length_factors)?;
        if !forces.is_empty() {
            self.external(ExternalKind::Values)?;
        }
        if let Some(external) = self.scene.external() {
            external.replace_values(forces);
        }
        for (load, factor) in loads {
            self.scale_of(load, factor)?.set(factor);
        }
        self.scene.hold_wind(wind);
        self.wind = wind;
        self.take_up(snapshot)
    }
}
