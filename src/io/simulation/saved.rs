//! The state of a simulation as bytes, and a simulation that goes on from them.

use super::{Changed, NodeMotion, RunState, Simulation, SimulationError, bind_spec};
use crate::checksum::{self, ChecksumError, RunningChecksum};
use crate::drive::Snapshot;
use crate::drive::clock::{JoinedAt, Step, Tolerance};
use crate::model::state::State;
use crate::model::stop::Stop;
use crate::output::gauges::GaugesSoFar;
use crate::output::live::LiveGauges;
use crate::scene::{ExternalForces, ExternalKind, Load, pass_events};
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
    rest_scales: Vec<f64>,
    /// what gauges have measured, if there are some
    gauges: Option<GaugesSoFar>,
}

/// What a snapshot must fit.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Origin {
    /// method with the values of its parameters
    method: (String, Vec<f64>),
    /// in words: of a fixed size, within a tolerance, or of the sizes that a program gives
    steps: String,
    /// checksums of masses, stiffnesses and start positions
    masses: u32,
    stiffnesses: u32,
    start: u32,
    /// and of the order in which the engine has the nodes
    numbering: u32,
}

impl Origin {
    /// What is another here than there, a phrase each.
    fn differences(&self, now: &Origin) -> Vec<String> {
        let method = |(name, values): &(String, Vec<f64>)| match values.as_slice() {
            [] => name.clone(),
            values => format!("{name} {values:?}"),
        };
        let mut found = Vec::new();
        if self.method != now.method {
            found.push(format!("method {}, now {}", method(&self.method), method(&now.method)));
        }
        if self.steps != now.steps && now.steps != FREE {
            found.push(format!("{}, now {}", self.steps, now.steps));
        }
        let parts = [
            ("masses", self.masses, now.masses),
            ("stiffnesses", self.stiffnesses, now.stiffnesses),
            ("positions at the start", self.start, now.start),
        ];
        found.extend(parts.iter().filter(|(_, then, now)| then != now).map(|(what, ..)| format!("other {what}")));
        found
    }
}

/// Steps whose sizes the program gives: a run of such steps goes on from anywhere.
const FREE: &str = "steps of given sizes";

/// Program and version, at the beginning of a snapshot, and the format of what follows.
const PROGRAM: &str = concat!("canopy-fem state ", env!("CARGO_PKG_VERSION"), " 4");

impl Simulation {
    /// Goes on from a snapshot, with a scheme that starts anew and then takes up what it carried.
    pub(super) fn take_up(&mut self, snapshot: Snapshot) -> Result<(), SimulationError> {
        let mut stepper = bind_spec(&self.spec, &*self.scene)?;
        let state = RunState::restore(&*self.scene, &mut stepper, &self.spec, snapshot)?;
        (self.state, self.scheme, self.pending) = (state, Some(stepper.unbind()), None);
        // They are those of the run so far.
        self.tangent = None;
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
            Ok(run.state.snapshot(stepper))
        })?;
        let forces = self.outside().map(ExternalForces::values).unwrap_or_default();
        let (loads, rest_scales) = (self.load_factors(), self.rest_scales());
        let (made_by, wind, gauges) = (self.origin(), self.wind, self.gauges.as_ref().map(LiveGauges::so_far));
        let saved = Saved { made_by, snapshot, forces, wind, loads, rest_scales, gauges };
        let mut bytes = Vec::new();
        postcard::to_io(&(PROGRAM, saved), &mut bytes).map_err(|error| SimulationError::Snapshot(error.to_string()))?;
        checksum::append(&mut bytes);
        Ok(bytes)
    }

    fn origin(&self) -> Origin {
        // The scene as it is before its events: a snapshot may be of another time than the present one.
        let (method, scene) = (&self.spec.method, self.scene.for_run());
        pass_events(&*scene, 0);
        let sum = |numbers: &[f64]| {
            let mut checksum = RunningChecksum::default();
            checksum.add(bytemuck::cast_slice(numbers));
            checksum.mark().crc
        };
        let (masses, stiffness) = (sum(scene.inverse_mass()), scene.nodal_stiffness());
        let State { t, x, v } = scene.initial_state();
        // Numbers in the engine's order, brought into the user's.
        let counted = State { t, x: (0..x.len()).map(|dof| dof as f64).collect(), v };
        let mut order = vec![[0.0; 3]; self.node_count()];
        scene.trace(counted.as_ref(), &mut order, &mut vec![[0.0; 3]; self.node_count()]);
        let steps = match self.spec.step {
            _ if self.spec.free_steps => FREE.to_owned(),
            Step::Fixed(step) => format!("steps of {step:?} s"),
            Step::Adaptive(Tolerance { relative, absolute }) => {
                format!("steps within a tolerance of {relative:?} and {absolute:?} m")
            }
        };
        Origin {
            method: (method.info.name.to_owned(), method.parameters().map(|(_, value)| value).collect()),
            steps,
            masses,
            stiffnesses: sum(&stiffness),
            start: sum(&x),
            // A pendulum has one node and an angle.
            numbering: if counted.x.len() == 3 * order.len() { sum(order.as_flattened()) } else { 0 },
        }
    }

    /// Goes on from the bytes of [`Simulation::snapshot`]. Laws of the program stay as they are, but for those whose
    /// names forces of the snapshot have, and so does what the settings say of the end of the run.
    ///
    /// The scene or run may be another one of the same nodes and connections: with other masses or stiffnesses, another
    /// method or step. The phrases that are returned say in what they differ. The scheme, its steps and the energy
    /// account then begin anew at the state of the snapshot, as with [`Simulation::set_state_at`]. Other tables,
    /// damping or air are not noticed.
    ///
    /// # Errors
    /// Bytes that are damaged or of another version, of a scene with other nodes or connections, or of a time that the
    /// run does not reach; the state is then unchanged.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<Vec<String>, SimulationError> {
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
        let Saved { made_by, snapshot, forces, wind, loads, rest_scales, gauges } = saved;
        let (spec, own, Snapshot { t, x, v, .. }) = (&self.spec, self.origin(), &snapshot);
        let needed = self.scene.n_dof();
        if made_by.numbering != own.numbering || [x.len(), v.len()] != [needed; 2] {
            return Err(unreadable("it is of a scene with other nodes or connections"));
        }
        let differences = made_by.differences(&own);
        let anew = match differences.as_slice() {
            [] => spec.passes(&*self.scene, &snapshot).map(|()| None)?,
            _ => {
                let JoinedAt { step: steps, t } = spec.join(&*self.scene, snapshot.step, *t)?;
                Some((steps, State { t, x: x.clone(), v: v.clone() }))
            }
        };
        for (_, force) in &forces {
            self.check("force of the snapshot", force)?;
        }
        loads.iter().try_for_each(|(load, factor)| self.scale_of(*load, *factor).map(|_| ()))?;
        if rest_scales.len() != self.edges().len() {
            return Err(unreadable("it is of a scene with other edges"));
        }
        self.pending = None;
        self.put_rest_length_factors(rest_scales)?;
        if !forces.is_empty() {
            self.external(ExternalKind::Values)?;
        }
        if let Some(external) = self.outside() {
            external.replace_values(forces);
        }
        for (load, factor) in loads {
            self.scale_of(load, factor)?.set(factor);
        }
        self.scene.air().into_iter().for_each(|air| air.hold_wind(wind));
        self.wind = wind;
        match anew {
            None => self.take_up(snapshot)?,
            Some((steps, state)) => {
                // Supports may differ.
                let NodeMotion { positions, velocities } = self.nodes_of(state.as_ref());
                let controls = self.scene.controls();
                let held = controls.and_then(|controls| controls.state_of(state.t, &positions, &velocities));
                self.begin(steps, held.unwrap_or(state))?;
            }
        }
        self.measure_from_here(gauges.as_ref())?;
        Ok(differences)
    }
}
