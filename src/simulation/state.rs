//! What a program reads from a simulation and changes in it.

use super::{Arc, NodalForce, RunState, Simulation, SimulationError};
use crate::checksum::{self, ChecksumError};
use crate::drive::Snapshot;
use crate::drive::observer::{LedgerRow, Point};
use crate::integrate::Counters;
use crate::scene::{ExternalForces, Scene};
use serde::{Deserialize, Serialize};

/// Where nodes are and how they move, in the numbering of the mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeMotion {
    /// [m] `[n_nodes][3]`
    pub positions: Vec<[f64; 3]>,
    /// [m/s] `[n_nodes][3]`
    pub velocities: Vec<[f64; 3]>,
}

/// What [`Simulation::snapshot`] writes.
#[derive(Serialize, Deserialize)]
struct Saved {
    snapshot: Snapshot,
    /// [N] forces that are fixed values
    forces: Vec<(String, Vec<[f64; 3]>)>,
    /// [m/s]
    wind: Option<[f64; 3]>,
}

/// Program and version, at the beginning of a snapshot.
const PROGRAM: &str = concat!("canopy-fem state ", env!("CARGO_PKG_VERSION"));

impl Simulation {
    /// [s] Time of the present state.
    pub fn time(&self) -> f64 {
        self.state.from.state.t
    }

    /// [-] Accepted steps so far.
    pub fn step_count(&self) -> u64 {
        self.state.steps
    }

    /// [-] Number of nodes.
    pub fn node_count(&self) -> usize {
        self.scene.reference().len()
    }

    /// [m] Positions before any displacement, `[n_nodes][3]`.
    pub fn reference(&self) -> &[[f64; 3]] {
        self.scene.reference()
    }

    /// Node pairs, `[n_edges]`.
    pub fn edges(&self) -> &[[u32; 2]] {
        self.scene.edges()
    }

    /// [m] Positions, `[n_nodes][3]`. A copy.
    pub fn positions(&self) -> Vec<[f64; 3]> {
        self.nodes(&self.state.from).positions
    }

    /// [m/s] Velocities, `[n_nodes][3]`. A copy.
    pub fn velocities(&self) -> Vec<[f64; 3]> {
        self.nodes(&self.state.from).velocities
    }

    /// Positions and velocities at the end of the attempted step; `None` without one.
    pub fn attempted(&self) -> Option<NodeMotion> {
        self.pending.as_ref().map(|pending| match pending {
            super::Pending::Fixed(_) => self.nodes(&self.state.to),
            super::Pending::Adaptive(_) => self.nodes(&self.state.from),
        })
    }

    /// [N] Reactions, `[n_nodes][3]`: what supports exert on the scene; 0 in free directions. Those at the end of the
    /// last step: a force that was set since is not in them.
    pub fn reactions(&self) -> Vec<[f64; 3]> {
        let mut out = vec![[0.0; 3]; self.node_count()];
        self.scene.node_reactions(&self.state.from.forces, &mut out);
        out
    }

    /// [N] Tension of every edge, `[n_edges]`, with its axial dashpot; NaN where an edge has no spring.
    pub fn tensions(&self) -> Vec<f64> {
        let n = self.edges().len();
        let (mut tension, mut strain) = (vec![0.0; n], vec![0.0; n]);
        let at = self.state.from.state.as_ref();
        self.scene.edge_tension(at, &mut tension, &mut strain);
        self.scene.add_axial_damping(at, &mut tension);
        tension
    }

    /// [J] The energy account at the present state.
    pub fn energies(&self) -> LedgerRow {
        self.state.row
    }

    /// Work done so far.
    pub fn counters(&self) -> Counters {
        self.state.counters
    }

    /// The scene, for observers that draw or measure it.
    pub fn scene(&self) -> Arc<dyn Scene> {
        self.scene.clone()
    }

    fn nodes(&self, at: &Point) -> NodeMotion {
        let n = self.node_count();
        let mut nodes = NodeMotion { positions: vec![[0.0; 3]; n], velocities: vec![[0.0; 3]; n] };
        self.scene.trace(at.state.as_ref(), &mut nodes.positions, &mut nodes.velocities);
        nodes
    }

    fn check(&self, what: &'static str, rows: &[[f64; 3]]) -> Result<(), SimulationError> {
        let (found, needed) = (rows.len(), self.node_count());
        if found != needed {
            return Err(SimulationError::Shape { what, found, needed });
        }
        match rows.iter().position(|row| row.iter().any(|value| !value.is_finite())) {
            None => Ok(()),
            Some(row) => Err(SimulationError::NotFinite { what, row }),
        }
    }

    /// Replaces positions [m] and velocities [m/s], each `[n_nodes][3]`; velocities of held directions are taken as 0.
    /// Time and step count go on. The energy account begins anew, and so do the scheme and adaptive steps.
    ///
    /// # Errors
    /// Slices of another length, numbers that are not finite, a pendulum, or a step that was attempted and waits.
    pub fn set_state(&mut self, positions: &[[f64; 3]], velocities: &[[f64; 3]]) -> Result<(), SimulationError> {
        self.idle()?;
        self.check("positions", positions)?;
        self.check("velocities", velocities)?;
        let state = self.scene.state_of(self.time(), positions, velocities);
        let state = state.ok_or(SimulationError::Unsupported("positions that can be set"))?;
        let mut stepper = self.settings.stepper(&*self.scene)?;
        let (steps, counters) = (self.state.steps, self.state.counters);
        let spec = self.settings.spec();
        let mut begun = RunState::start(&*self.scene, &mut stepper, spec, state)?;
        (begun.steps, begun.counters) = (steps, counters);
        self.state = begun;
        self.scheme = Some(stepper.unbind());
        self.hold_wind();
        Ok(())
    }

    /// Sets the force [N] of this name, `[n_nodes][3]`. It acts from the present state on until it is set again, and
    /// counts as external in the energy account.
    ///
    /// The first force of a simulation restarts the scheme.
    ///
    /// # Errors
    /// A slice of another length, numbers that are not finite, a pendulum, or a step that was attempted and waits; also
    /// the first external force of a scene that is in use elsewhere.
    pub fn set_nodal_force(&mut self, name: &str, force: &[[f64; 3]]) -> Result<(), SimulationError> {
        self.idle()?;
        self.check("force", force)?;
        self.external(false)?.set_values(name, force);
        self.changed = true;
        Ok(())
    }

    /// Sets a force that the program computes ([`NodalForce`]). It is not part of snapshots.
    ///
    /// # Errors
    /// As [`Simulation::set_nodal_force`].
    pub fn set_nodal_law(&mut self, name: &str, law: Arc<dyn NodalForce>) -> Result<(), SimulationError> {
        self.idle()?;
        self.external(true)?.set_law(name, law);
        self.changed = true;
        Ok(())
    }

    /// Removes an external force; `false` if there is none of this name.
    ///
    /// # Errors
    /// When an attempted step waits.
    pub fn remove_nodal_force(&mut self, name: &str) -> Result<bool, SimulationError> {
        self.idle()?;
        let removed = self.scene.external().is_some_and(|external| external.remove(name));
        self.changed |= removed;
        Ok(removed)
    }

    /// Replaces the wind by a constant velocity [m/s] from the present state on, or goes back to the given table.
    ///
    /// # Errors
    /// A scene without air, numbers that are not finite, or a step that was attempted and waits.
    pub fn set_wind(&mut self, wind: Option<[f64; 3]>) -> Result<(), SimulationError> {
        self.idle()?;
        if wind.is_some_and(|wind| wind.iter().any(|value| !value.is_finite())) {
            return Err(SimulationError::NotFinite { what: "wind", row: 0 });
        }
        if wind.is_some_and(|wind| !self.scene.hold_wind(wind)) {
            return Err(SimulationError::Unsupported("air, and so no wind"));
        }
        self.wind = wind;
        self.hold_wind();
        self.changed = true;
        Ok(())
    }

    fn hold_wind(&self) {
        match self.wind {
            Some(wind) => _ = self.scene.hold_wind(wind),
            None => self.scene.sample_tables(self.settings.step.fixed()),
        }
    }

    /// The place of external forces, which is made when first needed.
    fn external(&mut self, velocity_dependent: bool) -> Result<&ExternalForces, SimulationError> {
        let depends = self.scene.velocity_dependent();
        if self.scene.external().is_none() || velocity_dependent && !depends {
            let snapshot = self.snapshot_now()?;
            let scene = Arc::get_mut(&mut self.scene).ok_or(SimulationError::SceneInUse)?;
            if !scene.enable_external(velocity_dependent) {
                return Err(SimulationError::Unsupported("forces from outside"));
            }
            self.take_up(snapshot)?;
        }
        self.scene.external().ok_or(SimulationError::Unsupported("forces from outside"))
    }

    fn snapshot_now(&mut self) -> Result<Snapshot, SimulationError> {
        self.at_work(crate::model::stop::Stop::NEVER, |run, stepper| run.state.snapshot(stepper))
    }

    /// Goes on from a snapshot, with a scheme that starts anew and then takes up what it carried.
    pub(super) fn take_up(&mut self, snapshot: Snapshot) -> Result<(), SimulationError> {
        let mut stepper = self.settings.stepper(&*self.scene)?;
        let state = RunState::restore(&*self.scene, &mut stepper, self.settings.spec(), snapshot)?;
        (self.state, self.scheme, self.pending) = (state, Some(stepper.unbind()), None);
        if self.wind.is_some() {
            self.hold_wind();
            self.changed = true;
        }
        Ok(())
    }

    /// The whole state as bytes, with forces and wind that were set. A simulation of the same scene and settings goes
    /// on from it with the same bits.
    ///
    /// # Errors
    /// When an attempted step waits.
    pub fn snapshot(&mut self) -> Result<Vec<u8>, SimulationError> {
        self.idle()?;
        let snapshot = self.snapshot_now()?;
        let forces = self.scene.external().map(ExternalForces::values).unwrap_or_default();
        let saved = Saved { snapshot, forces, wind: self.wind };
        let mut bytes = Vec::new();
        postcard::to_io(&(PROGRAM, saved), &mut bytes).map_err(|error| SimulationError::Snapshot(error.to_string()))?;
        checksum::append(&mut bytes);
        Ok(bytes)
    }

    /// Goes on from the bytes of [`Simulation::snapshot`]. Laws stay as they are.
    ///
    /// # Errors
    /// Bytes that are damaged or of another version or scene; the state is then unchanged.
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
        let Saved { snapshot, forces, wind } = saved;
        self.settings.spec().passes(&*self.scene, &snapshot)?;
        for (_, force) in &forces {
            self.check("force of the snapshot", force)?;
        }
        self.pending = None;
        if !forces.is_empty() {
            self.external(false)?;
        }
        if let Some(external) = self.scene.external() {
            external.clear_values();
            forces.iter().for_each(|(name, force)| external.set_values(name, force));
        }
        self.wind = wind;
        self.take_up(snapshot)
    }
}
