//! What a program reads from a simulation and changes in it.

use super::{Arc, Changed, NodalForce, RunState, Simulation, SimulationError, bind_spec};
use crate::drive::Snapshot;
use crate::drive::ledger::Elastic;
use crate::drive::observer::{Energies, Point};
use crate::force::law::series::Scale;
use crate::integrate::Counters;
use crate::model::state::{State, StateRef};
use crate::model::stop::Stop;
use crate::scene::{ExternalForces, ExternalKind, Load, PairsChange, ScaledLoad, Scene, loads};
use std::sync::atomic::AtomicBool;

/// Where nodes are and how they move, in the numbering of the mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeMotion {
    /// [m] `[n_nodes][3]`
    pub positions: Vec<[f64; 3]>,
    /// [m/s] `[n_nodes][3]`
    pub velocities: Vec<[f64; 3]>,
}

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

    /// Writes positions [m] and velocities [m/s] into slices of the program, each `[n_nodes][3]`.
    ///
    /// # Errors
    /// Slices of another length.
    pub fn read_nodes(&self, positions: &mut [[f64; 3]], velocities: &mut [[f64; 3]]) -> Result<(), SimulationError> {
        let needed = self.node_count();
        for (what, found) in [("positions", positions.len()), ("velocities", velocities.len())] {
            if found != needed {
                return Err(SimulationError::Shape { what, found, needed });
            }
        }
        self.scene.trace(self.state.from.state.as_ref(), positions, velocities);
        Ok(())
    }

    /// [s] End of the run.
    pub fn end(&self) -> f64 {
        self.spec.end
    }

    /// Positions and velocities at the end of the attempted step; `None` without one.
    pub fn attempted(&self) -> Option<NodeMotion> {
        self.attempted_point().map(|end| self.nodes(end))
    }

    /// [s] Time at the end of the attempted step; `None` without one.
    pub fn attempted_time(&self) -> Option<f64> {
        self.attempted_point().map(|end| end.state.t)
    }

    fn attempted_point(&self) -> Option<&Point> {
        self.pending.as_ref().map(|pending| match pending {
            super::Pending::Fixed(_) => &self.state.to,
            super::Pending::Adaptive(_) => &self.state.from,
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
        self.scene.springs().into_iter().for_each(|springs| springs.add_axial_damping(at, &mut tension));
        tension
    }

    /// [J] The energy account at the present state, with what loads and rest lengths that were set since the last step
    /// have given or taken at once.
    pub fn energies(&self) -> Energies {
        let changed = self.changed_point();
        changed.map_or(self.state.row, |at| self.state.changed_account(&*self.scene, &at, Elastic::FromOutside).1)
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
        self.nodes_of(at.state.as_ref())
    }

    pub(super) fn nodes_of(&self, at: StateRef<'_>) -> NodeMotion {
        let n = self.node_count();
        let mut nodes = NodeMotion { positions: vec![[0.0; 3]; n], velocities: vec![[0.0; 3]; n] };
        self.scene.trace(at, &mut nodes.positions, &mut nodes.velocities);
        nodes
    }

    pub(super) fn check(&self, what: &'static str, rows: &[[f64; 3]]) -> Result<(), SimulationError> {
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
        self.set_state_at(self.time(), positions, velocities)
    }

    /// The same at another time `t` [s]. Fixed steps count from t = 0: [`Simulation::step_count`] is then the number of
    /// the last that ends there or before, and the next is shorter where `t` lies within one. Events of the scene up to
    /// then are passed, later ones come again.
    ///
    /// # Errors
    /// As [`Simulation::set_state`]; also a time before 0 or beyond the end.
    pub fn set_state_at(
        &mut self,
        t: f64,
        positions: &[[f64; 3]],
        velocities: &[[f64; 3]],
    ) -> Result<(), SimulationError> {
        self.idle()?;
        self.check("positions", positions)?;
        self.check("velocities", velocities)?;
        let joined = self.spec.join(&*self.scene, self.state.steps, t)?;
        let controls = self.scene.controls();
        let state = controls.and_then(|controls| controls.state_of(joined.t, positions, velocities));
        let state = state.ok_or(SimulationError::Unsupported("positions that can be set"))?;
        self.begin(joined.step, state)?;
        self.measure_from_here(None)
    }

    /// Begins anew from a state after `steps` steps; counted work stays.
    pub(super) fn begin(&mut self, steps: u64, state: State) -> Result<(), SimulationError> {
        let mut stepper = bind_spec(&self.spec, &*self.scene)?;
        let (spec, counters) = (&self.spec, self.state.counters);
        let mut begun = RunState::start(&*self.scene, &mut stepper, spec, state)?;
        (begun.steps, begun.counters) = (steps, counters);
        self.state = begun;
        self.scheme = Some(stepper.unbind());
        self.changed = Changed::Nothing;
        Ok(())
    }

    /// Sets the force [N] of this name, `[n_nodes][3]`. It acts from the present state on until it is set again, and
    /// counts as external in the energy account. A law of the same name is removed.
    ///
    /// # Errors
    /// A slice of another length, numbers that are not finite, a pendulum, or a step that was attempted and waits; also
    /// the first external force of a scene that is in use elsewhere.
    pub fn set_force(&mut self, name: &str, force: &[[f64; 3]]) -> Result<(), SimulationError> {
        self.idle()?;
        self.check("force", force)?;
        let had_derivatives = self.has_derivatives(name);
        if self.external(ExternalKind::Values)?.set_values(name, force) {
            self.note(if had_derivatives { Changed::Pattern } else { Changed::Values });
        }
        Ok(())
    }

    /// Sets a force that the program computes ([`NodalForce`]). It is not part of snapshots. From the first one on
    /// every step is made alone: explicit methods then take 2 to 5 times as long, where steps were made in blocks
    /// before. A force that changes seldom is better set as values ([`Simulation::set_force`]), which cost 1.2 to
    /// 1.5 times.
    ///
    /// # Errors
    /// As [`Simulation::set_force`]; also pairs of nodes that do not exist.
    pub fn set_force_law(&mut self, name: &str, law: Arc<dyn NodalForce>) -> Result<(), SimulationError> {
        self.idle()?;
        let (pairs, nodes) = (law.pairs(), self.node_count());
        let unknown = |(place, pair): (usize, &[u32; 2])| {
            let node = pair.iter().copied().find(|&node| node as usize >= nodes)?;
            Some(SimulationError::NoNode { what: "pair", place, node, nodes })
        };
        pairs.iter().enumerate().find_map(unknown).map_or(Ok(()), Err)?;
        let kind = ExternalKind::Law { velocity_dependent: law.velocity_dependent() };
        let changed = match self.external(kind)?.set_law(name, law, pairs) {
            PairsChange::None => Changed::Values,
            PairsChange::Same => Changed::Loads,
            PairsChange::Other => Changed::Pattern,
        };
        self.note(changed);
        Ok(())
    }

    /// Removes an external force; `false` if there is none of this name.
    ///
    /// # Errors
    /// When an attempted step waits.
    pub fn remove_force(&mut self, name: &str) -> Result<bool, SimulationError> {
        self.idle()?;
        let other_pattern = self.has_derivatives(name);
        let removed = self.outside().is_some_and(|external| external.remove(name));
        if removed {
            self.note(if other_pattern { Changed::Pattern } else { Changed::Values });
        }
        Ok(removed)
    }

    /// Names and values [N] `[n_nodes][3]` of the external forces that are values, in the order in which they came.
    pub fn acting_forces(&self) -> Vec<(String, Vec<[f64; 3]>)> {
        self.outside().map(ExternalForces::values).unwrap_or_default()
    }

    fn has_derivatives(&self, name: &str) -> bool {
        self.outside().is_some_and(|external| external.has_derivatives(Some(name)))
    }

    /// From now on, no cause is sought for a step that fails while `flag` is set, which can take longer than many
    /// steps: for a force that has failed for a reason of its own, and fills its forces with NaN.
    pub fn stop_on(&mut self, flag: Arc<AtomicBool>) {
        self.stop = Some(flag);
    }

    /// Replaces the wind by a constant velocity [m/s] from the present state on, or goes back to the given table.
    ///
    /// # Errors
    /// A scene without air, numbers that are not finite, or a step that was attempted and waits.
    pub fn set_wind(&mut self, wind: Option<[f64; 3]>) -> Result<(), SimulationError> {
        self.idle()?;
        if wind == self.wind {
            return Ok(());
        }
        if wind.is_some_and(|wind| wind.iter().any(|value| !value.is_finite())) {
            return Err(SimulationError::NotFinite { what: "wind", row: 0 });
        }
        let air = self
            .scene
            .air()
            .filter(|air| !air.winds(0.0).is_empty())
            .ok_or(SimulationError::Unsupported("air, and so no wind"))?;
        air.hold_wind(wind);
        self.wind = wind;
        self.note(Changed::Loads);
        Ok(())
    }

    /// The loads that can be scaled, with their factors [-].
    pub fn load_factors(&self) -> Vec<(Load, f64)> {
        loads(&*self.scene).iter().map(|ScaledLoad { load, scale }| (*load, scale.get())).collect()
    }

    /// Multiplies a load by `factor` [-] from the present state on, besides its own factor over time: 1 as given, 0 to
    /// switch it off, below 0 to turn it round. Energy that the weight gains or loses at once is entered as external
    /// work.
    ///
    /// # Errors
    /// A load that the scene does not have, a factor that is not finite, or a step that was attempted and waits.
    pub fn set_load_factor(&mut self, load: Load, factor: f64) -> Result<(), SimulationError> {
        self.idle()?;
        let scale = self.scale_of(load, factor)?;
        if scale.get() != factor {
            scale.set(factor);
            self.note(Changed::Loads);
        }
        Ok(())
    }

    pub(super) fn scale_of(&self, load: Load, factor: f64) -> Result<&Scale, SimulationError> {
        if !factor.is_finite() {
            return Err(SimulationError::NotFinite { what: "load factor", row: 0 });
        }
        let found = loads(&*self.scene).iter().find(|other| other.load == load);
        found.map(|found| &*found.scale).ok_or(SimulationError::NoLoad(load))
    }

    /// The edges that have a spring, ascending.
    pub fn spring_edges(&self) -> Vec<u32> {
        self.scene.springs().map_or_else(Vec::new, |springs| springs.spring_edges())
    }

    /// [-] Factors of the rest lengths as given, `[n_edges]`; 1 where none was set.
    pub fn rest_scales(&self) -> Vec<f64> {
        match self.rest_scales.as_slice() {
            [] => vec![1.0; self.edges().len()],
            set => set.to_vec(),
        }
    }

    /// Makes the rest lengths of the springs on these edges `factor` [-] times those given, from the present state on:
    /// below 1 to reef a line, above 1 to let it out. Energy that the springs gain or lose at once is entered as
    /// external work. Slack limits [m] stay, and bars of the program's own laws keep their rest lengths.
    ///
    /// # Errors
    /// An edge without a spring, a factor that is not finite or not above 0, or a step that was attempted and waits;
    /// also a scene that is in use elsewhere. Nothing is changed then.
    pub fn set_rest_scale(&mut self, edges: &[u32], factor: f64) -> Result<(), SimulationError> {
        self.idle()?;
        let springs = self.spring_edges.get_or_init(|| self.spring_edges());
        for &edge in edges {
            springs.binary_search(&edge).map_err(|_| SimulationError::NoSpring { edge })?;
        }
        let now = |edge: u32| self.rest_scales.get(edge as usize).copied().unwrap_or(1.0);
        if edges.iter().all(|&edge| now(edge) == factor) {
            return Ok(());
        }
        let mut factors = self.rest_scales();
        edges.iter().for_each(|&edge| factors[edge as usize] = factor);
        self.put_rest_length_factors(factors)
    }

    pub(super) fn put_rest_length_factors(&mut self, factors: Vec<f64>) -> Result<(), SimulationError> {
        if factors != self.rest_scales() {
            check_factors(&factors)?;
            let scene = Arc::get_mut(&mut self.scene).ok_or(SimulationError::SceneInUse)?;
            scene.controls_mut().into_iter().for_each(|controls| controls.set_rest_length_factors(&factors));
            self.rest_scales = factors;
            self.note(Changed::RestLengths);
        }
        Ok(())
    }

    /// Before the next step forces are found again, and what follows from them.
    fn note(&mut self, changed: Changed) {
        self.changed = self.changed.max(changed);
    }

    /// The forces from outside, once they have a place.
    pub(super) fn outside(&self) -> Option<&ExternalForces> {
        self.scene.controls()?.external()
    }

    /// The place of external forces of a kind, which is made when first needed.
    pub(super) fn external(&mut self, kind: ExternalKind) -> Result<&ExternalForces, SimulationError> {
        if !self.outside().is_some_and(|external| external.takes(kind)) {
            Arc::get_mut(&mut self.scene).ok_or(SimulationError::SceneInUse)?;
            let snapshot = self.at_work(Stop::NEVER, |run, stepper| {
                // Forces of the last step do not fit the scene any more, and are found again at their velocities.
                run.state.keep_over_change(run.scene, stepper);
                Ok(Snapshot { forces: None, ..run.state.snapshot(stepper) })
            })?;
            let scene = Arc::get_mut(&mut self.scene).ok_or(SimulationError::SceneInUse)?;
            scene.controls_mut().ok_or(SimulationError::Unsupported("forces from outside"))?.enable_external(kind);
            self.take_up(snapshot).inspect_err(|_| self.scheme = None)?;
        }
        self.outside().ok_or(SimulationError::Unsupported("forces from outside"))
    }
}

/// Factors of rest lengths are numbers above 0.
fn check_factors(factors: &[f64]) -> Result<(), SimulationError> {
    for (row, &factor) in factors.iter().enumerate() {
        if !factor.is_finite() {
            return Err(SimulationError::NotFinite { what: "factor of a rest length", row });
        }
        if factor <= 0.0 {
            return Err(SimulationError::NotPositive { factor });
        }
    }
    Ok(())
}
