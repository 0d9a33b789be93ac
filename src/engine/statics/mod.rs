//! Static equilibrium: positions where all forces on free nodes vanish, f(t, x, 0) = 0, from a start that may be far.
//!
//! ```text
//! x_{n+1}:  F(z) = mu M z - f(t, x_n + z, 0) = 0,      mu -> 0
//! ```
//! Each solve is Newton's iteration of the implicit schemes (`solve/newton`), so a scene with a potential descends in
//! it. The mass term ties a solution to the last one. It makes singular and indefinite tangents regular, and keeps what
//! no force moves where it is. It is a step of backward Euler that begins at rest, with mu = 1/h^2: pseudo-transient
//! continuation (Kelley & Keyes 1998), and for a potential the proximal point method (Rockafellar 1976). The loads are
//! applied at once or in steps (`load_path`). What is found is judged at its tangent (`diagnosis`).

mod continuation;
mod diagnosis;
mod failure;
mod load_path;
mod proximal;
mod resultants;
mod unknowns;
mod watch;

pub use diagnosis::{Finding, FindingKind, Stability};
pub use failure::StaticFailure;
pub use resultants::Loose;
pub use watch::{SearchProgress, Watcher};

use crate::integrate::Counters;
use crate::integrate::tangents::Tangents;
use crate::model::point::Point;
use crate::model::state::State;
use crate::model::stop::Stop;
use crate::scene::{Scene, event_times, pass_events, sample_tables};
use crate::solve::newton::Strategy;
use crate::solve::{LinearChoice, LinearStats};
use continuation::{Continuation, SearchStart};

/// What to find.
#[derive(Clone, Copy, Debug)]
pub struct StaticSpec {
    /// [s] time of the loads, of the wind and of what is held
    pub at: f64,
    /// [-] largest sum of forces left, as a share of the loads and reactions (Euclidean norms)
    pub relative: f64,
    /// iterations of Newton's method in all, after which the search gives up
    pub max_iterations: u32,
    /// [-] number of equal steps in which loads and displacements of supports are applied; 1 applies them at once, and
    /// in steps if that fails
    pub load_steps: u32,
    /// solver of linear equations; conjugate gradients are replaced by a factorisation
    pub linear: LinearChoice,
}

/// What a search has found. On a failure `point` is the best state seen.
#[derive(Debug)]
pub struct Equilibrium {
    /// positions, at rest, with the forces there
    pub point: Point,
    /// sizes of what is left
    pub residual: Residual,
    /// solves of pseudo-transient continuation that were accepted
    pub pseudo_steps: u32,
    /// solves that were dropped
    pub dropped: u32,
    /// load levels that were solved, the full load among them
    pub load_steps: u32,
    /// counted work
    pub counters: Counters,
    /// the linear solver
    pub linear: Option<LinearStats>,
    /// what its tangent says of it; not judged where the tangent is not symmetric
    pub stability: Option<Stability>,
    /// parts that no force keeps in place
    pub findings: Vec<Finding>,
    /// why there is none
    pub failure: Option<StaticFailure>,
}

/// The forces that are left.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Residual {
    /// [N] Euclidean norm of the sums of forces on free degrees of freedom
    pub force: f64,
    /// [N] what it is compared with: the largest norm of loads, internal forces, reactions and tensions at the nodes
    pub scale: f64,
    /// [N] the part of it beyond rounding errors
    pub excess: f64,
    /// degree of freedom with the largest sum of forces
    #[serde(skip)]
    pub worst: usize,
}

impl Residual {
    /// [-] the residual over its scale; 0 without forces
    pub fn relative(&self) -> f64 {
        if self.scale > 0.0 { self.force / self.scale } else { 0.0 }
    }

    /// Whether nothing but rounding and a share of the forces is left.
    fn is_small(&self, relative: f64) -> bool {
        self.force.is_finite() && self.excess <= relative * self.scale
    }
}

/// Finds the equilibrium of a scene from its initial state, or says why it did not.
pub fn find(scene: &dyn Scene, spec: StaticSpec, stop: Stop<'_>) -> Equilibrium {
    find_watched(scene, spec, stop, Watcher::NONE)
}

/// The same, and tells how far it has come.
pub fn find_watched(scene: &dyn Scene, spec: StaticSpec, stop: Stop<'_>, watcher: Watcher<'_>) -> Equilibrium {
    sample_tables(scene, None);
    let events = event_times(scene);
    pass_events(scene, events.partition_point(|event| *event <= spec.at));
    let mut state = scene.initial_state();
    state.t = spec.at;
    put_supports(scene, &mut state, 1.0);
    let mut point = Point { state, forces: scene.new_forces() };
    let mut counters = Counters::default();
    counters.evaluate(scene, point.state.as_ref(), &mut point.forces);
    if scene.inverse_mass().iter().all(|inverse| *inverse == 0.0) {
        let next = events.iter().copied().find(|event| *event > spec.at);
        return Equilibrium::without(point, counters, StaticFailure::AllHeld { at: spec.at, next });
    }
    // A matrix that is made anew in every iteration is factorised.
    let choice = if spec.linear == LinearChoice::Cg { LinearChoice::Auto } else { spec.linear };
    let tangents = match Tangents::new(scene, Strategy::Full, choice) {
        Ok(tangents) => tangents,
        Err(error) => return Equilibrium::without(point, counters, StaticFailure::Solver { error: error.to_string() }),
    };
    let mut search = Continuation::new(scene, spec, SearchStart { stop, watcher, tangents, at: point, counters });
    let unsupported = resultants::unsupported(scene, &search.at, search.dofs.size);
    let failure = match unsupported {
        Some(failure) => Some(failure),
        None => load_path::follow(&mut search).err(),
    };
    search.finish(failure)
}

/// Puts supports where a `share` [-] of their displacement leads, at rest. Returns whether any is moved.
fn put_supports(scene: &dyn Scene, state: &mut State, share: f64) -> bool {
    let moved = scene.events().is_some_and(|events| events.put_supports(state, share));
    state.v.fill(0.0);
    moved
}

impl Equilibrium {
    fn without(point: Point, counters: Counters, failure: StaticFailure) -> Self {
        Equilibrium {
            point,
            residual: Residual::default(),
            pseudo_steps: 0,
            dropped: 0,
            load_steps: 0,
            counters,
            linear: None,
            stability: None,
            findings: Vec::new(),
            failure: Some(failure),
        }
    }
}
