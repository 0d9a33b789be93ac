//! Scenes: a spring network or a pendulum, built from a plain specification, ready for any scheme.
//!
//! Inside a network nodes are renumbered for locality ([`numbering`]); everything a person sees goes through
//! [`crate::model::observables::Observables`] and is in the user's numbering again.

mod acting;
mod adjoint;
mod air_pressure;
mod apparent;
mod arrangement;
mod bound;
mod bound_by_triangles;
mod branches;
mod build;
mod build_bending;
mod build_contact;
mod build_drag;
mod build_gas;
mod build_rings;
mod build_surface;
mod canopy_shape;
mod check;
mod check_elements;
mod check_loads;
mod check_values;
mod contact;
mod controls;
mod events;
mod external;
mod graph;
mod links;
mod mass_scaling;
mod mean;
mod mixed;
mod motion;
pub mod network;
pub mod numbering;
mod pendulum;
mod picture;
mod point_canopy;
mod product;
mod reach;
mod stiff_part;
mod stored_tangents;
mod suspect;
mod tangent;
mod triggers;

pub use adjoint::Adjoint;
pub use bound::BoundBuffer;
pub use build::{build_network, build_network_with};
pub use check_values::BuildError;
pub use external::{ExternalForces, ExternalKind, ForceDerivative, NodalForce, PairsChange};
pub use network::Network;
pub use pendulum::Pendulum;
pub use stored_tangents::TangentProducts;

use crate::assembly::{SceneInterfaces, TangentSystem};
use crate::force::law::series::Scale;
use crate::model::abilities::Events;
use crate::model::added_mass::AddedMass;
use crate::model::at_dof::AtDof;
use crate::model::observables::Observables;
use crate::model::state::{State, StateRef};
use crate::model::system::TermInfo;
use std::sync::Arc;

/// What a failure report points at, in the user's numbering.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Suspect {
    /// the node
    pub node: Option<u32>,
    /// the most strained spring at that node
    pub spring: Option<u32>,
    /// the term with the largest force on that node
    pub term: Option<TermInfo>,
}

/// A load of a scene that a program can scale while a simulation runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub enum Load {
    /// the weight of all nodes
    Gravity,
    /// a pressure, by its place in [`NetworkSpec::pressures`](crate::model::spec::NetworkSpec::pressures): the order of
    /// the case file
    Pressure(usize),
    /// forces on nodes, by their place in [`NetworkSpec::forces`](crate::model::spec::NetworkSpec::forces)
    Forces(usize),
}

/// A load with the factor that a program sets.
#[derive(Clone, Debug)]
pub struct ScaledLoad {
    /// which load
    pub load: Load,
    /// [-] its factor
    pub scale: Arc<Scale>,
}

/// What a run needs of a scene besides forces, tangents and output.
pub trait Scene: TangentSystem + Observables {
    /// The interfaces that schemes use.
    fn interfaces(&self) -> SceneInterfaces<'_>;

    /// The same scene for another run, with its own values of all that changes in a run: events that are passed, tables
    /// as steps sample them, the wind, loads and forces that a program sets. At first they are those of this scene. All
    /// else is shared, so that a copy is cheap. Each of two runs that overlap, on one thread or on several, needs its
    /// own, and observers and schemes that of their run.
    fn for_run(&self) -> Box<dyn Scene>;

    /// What happens to it at given times; `None` if nothing can.
    fn events(&self) -> Option<&dyn Events> {
        None
    }

    /// What a program can set, and read of it; `None` if there is nothing.
    fn controls(&self) -> Option<&dyn Controls> {
        None
    }

    /// The same, also what is set for the whole scene at once.
    fn controls_mut(&mut self) -> Option<&mut dyn Controls> {
        None
    }

    /// What an adjoint run needs of it; `None` if it has no nodes and springs of its own.
    fn adjoint(&self) -> Option<&dyn Adjoint> {
        None
    }

    /// What mass scaling has added; `None` where masses are not scaled.
    fn added_mass(&self) -> Option<AddedMass> {
        None
    }

    /// [m] the scene's size: half the largest extent of its nodes at t = 0, or what its rest lengths allow if it is
    /// packed in less: a quarter of the longest path along springs and sheets. 0 for a single node.
    fn size(&self) -> f64;

    /// [m] half the largest extent of the nodes in a state.
    fn extent(&self, at: StateRef<'_>) -> f64;

    /// The likely cause of a failure at a degree of freedom of a state.
    fn suspect(&self, at: StateRef<'_>, dof: usize) -> Suspect;

    /// Node (user's number) and axis of a degree of freedom.
    fn name_of(&self, dof: usize) -> (u32, &'static str);

    /// Writes into `f` [N] `[n_dof]` the loads in a state: gravity, pressure and air, without springs and dampers.
    /// Allocates.
    fn load(&self, at: StateRef<'_>, f: &mut [f64]) {
        let mut forces = self.new_forces();
        self.evaluate(at, &mut forces);
        f.copy_from_slice(&forces.total);
    }

    /// Writes into `f` [N] `[n_dof]` the force of one of the [terms](crate::model::system::System::terms), fixed
    /// degrees of freedom included. Returns the number of its elements; `None` if the terms are not separate.
    fn term_alone(&self, term: usize, at: StateRef<'_>, f: &mut [f64]) -> Option<usize> {
        let _ = (term, at, f);
        None
    }

    /// y = (c C + k K) p at a state, matrix-free, all `[n_dof]`; zero at fixed degrees of freedom.
    fn tangent_times(&self, at: StateRef<'_>, w: crate::model::system::Weights, p: &[f64], y: &mut [f64]);

    /// The same products at one state, prepared for many of them, until an event passes; `None` where that gains
    /// nothing. It may use all threads of the scene.
    fn tangent_products<'a>(&'a self, at: StateRef<'a>) -> Option<Box<dyn TangentProducts + 'a>> {
        let _ = at;
        None
    }

    /// Upper bound on the largest eigenvalue of M^-1 (c C + k K) at a state, from one pass over the elements, and the
    /// degree of freedom where it is reached. Proved for symmetric scenes and weights of at least 0; else a measure
    /// that grows with the eigenvalue.
    fn rate_bound(&self, at: StateRef<'_>, w: crate::model::system::Weights, buffer: &mut BoundBuffer) -> AtDof;

    /// The same bound from several passes, mostly sharper.
    fn sharper_rate_bound(&self, at: StateRef<'_>, w: crate::model::system::Weights) -> AtDof {
        self.rate_bound(at, w, &mut BoundBuffer::default())
    }
}

/// What a program sets while a simulation runs.
pub trait Controls {
    /// The loads that a program can scale, with their factors.
    fn loads(&self) -> &[ScaledLoad];

    /// Fills gases in closed volumes with a `share` [-] of their pressure above the ambient one in the volume at the
    /// start, or of their amount above that volume: 1 but for steps of a load. Returns whether there is any gas.
    fn fill_gases(&self, share: f64) -> bool;

    /// The forces from outside, once they are enabled.
    fn external(&self) -> Option<&ExternalForces>;

    /// Gives the scene a place for forces from outside. Forces that were sized before do not fit it any more.
    fn enable_external(&mut self, kind: ExternalKind);

    /// Multiplies the rest lengths of springs as given by factors, `[n_edges]` in the user's numbering.
    fn set_rest_length_factors(&mut self, factors: &[f64]);

    /// The state at time `t` [s] with these positions [m] and velocities [m/s], each `[n_nodes][3]` in the user's
    /// numbering; held directions have the velocity of their support, and what a support moves is where it moves it.
    /// `None` if slices have another length.
    fn state_of(&self, t: f64, positions: &[[f64; 3]], velocities: &[[f64; 3]]) -> Option<State>;
}

/// [s] The [events](Events::event_times) of a scene.
pub fn event_times(scene: &dyn Scene) -> &[f64] {
    scene.events().map_or(&[], |events| events.event_times())
}

/// [Passes events](Events::pass_events) of a scene, if it can have any; none that waits for a state has happened then.
pub fn pass_events(scene: &dyn Scene, passed: usize) -> bool {
    scene.events().is_some_and(|events| {
        let other = !events.named().is_empty() && events.set_happened(&[]);
        events.pass_events(passed) | other
    })
}

/// [Samples the tables](Events::sample_tables) of a scene, if it can have any.
pub fn sample_tables(scene: &dyn Scene, h: Option<f64>) {
    scene.events().into_iter().for_each(|events| events.sample_tables(h));
}

/// The [loads](Controls::loads) of a scene.
pub fn loads(scene: &dyn Scene) -> &[ScaledLoad] {
    scene.controls().map_or(&[], |controls| controls.loads())
}

/// The node of a degree of freedom, and the fastest spring at it, in words.
pub fn place_of(scene: &dyn Scene, dof: usize) -> String {
    let node = scene.name_of(dof).0;
    fastest_spring(scene, dof).map_or_else(|| format!("node {node}"), |spring| format!("node {node}, spring {spring}"))
}

/// The same with the groups that they belong to.
pub fn place_with_groups(scene: &dyn Scene, dof: usize) -> String {
    let node = scene.node_in_words(scene.name_of(dof).0);
    match fastest_spring(scene, dof) {
        Some(spring) => format!("{node}, {}", scene.spring_in_words(spring)),
        None => node,
    }
}

/// The spring (user's number) with the largest stiffness over the masses at its ends, at the node of a degree of
/// freedom.
pub fn fastest_spring(scene: &dyn Scene, dof: usize) -> Option<u32> {
    scene.springs()?.fastest_spring(dof)
}
