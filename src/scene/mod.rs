//! Scenes: a spring network or a pendulum, built from a plain specification, ready for any scheme.
//!
//! Inside a network nodes are renumbered for locality ([`numbering`]); everything a person sees goes through
//! [`crate::model::picture::Picture`] and is in the user's numbering again.

mod bound;
mod branches;
mod build;
mod check;
mod graph;
pub mod network;
pub mod numbering;
mod pendulum;
mod picture;
mod suspect;
mod tangent;

pub use bound::BoundRoom;
pub use build::build_network;
pub use check::BuildError;
pub use network::Network;
pub use pendulum::Pendulum;

use crate::assembly::{Abilities, TangentSystem};
use crate::model::picture::Picture;
use crate::model::state::StateRef;
use crate::model::system::TermInfo;

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

/// What a run needs of a scene beyond forces, tangents and looks.
pub trait Scene: TangentSystem + Picture {
    /// What schemes may use.
    fn abilities(&self) -> Abilities<'_>;

    /// [m] the scene's size: half the largest extent of its nodes at t = 0; 0 for a single node.
    fn size(&self) -> f64;

    /// [m] half the largest extent of the nodes in a state.
    fn extent(&self, at: StateRef<'_>) -> f64;

    /// Whether some force changes its law with the state: springs that go slack.
    fn has_branches(&self) -> bool {
        false
    }

    /// `impulse =` what hangs on forces' changes of their law within a step from one state to another, in N s by degree
    /// of freedom: for each force the smaller of what it would have added if it had kept the law that it begins with,
    /// or had had the other from the beginning. Returns where, as a share of the step, the force with the largest part
    /// of it changes first; `None`, and `impulse` means nothing, where none changes.
    fn branch_changes(&self, step: [StateRef<'_>; 2], impulse: &mut [f64]) -> Option<f64> {
        let _ = (step, impulse);
        None
    }

    /// Who is at fault at a degree of freedom of a state.
    fn suspect(&self, at: StateRef<'_>, dof: usize) -> Suspect;

    /// Node (user's number) and axis of a degree of freedom.
    fn name_of(&self, dof: usize) -> (u32, &'static str);

    /// The spring (user's number) that by its stiffness over the masses at its ends is the fastest at a degree of
    /// freedom's node.
    fn fastest_spring(&self, dof: usize) -> Option<u32> {
        let _ = dof;
        None
    }

    /// [N] f = the loads in a state: gravity, pressure, air, without springs and dampers. Allocates.
    fn load(&self, at: StateRef<'_>, f: &mut [f64]) {
        let mut forces = self.new_forces();
        self.evaluate(at, &mut forces);
        f.copy_from_slice(&forces.total);
    }

    /// `f =` the force [N] of one of the [terms](crate::model::system::System::terms) alone, fixed degrees of freedom
    /// included, and says over how many elements it went; `None` where terms cannot be told apart.
    fn term_alone(&self, term: usize, at: StateRef<'_>, f: &mut [f64]) -> Option<usize> {
        let _ = (term, at, f);
        None
    }

    /// y = (c C + k K) p at a state, without a matrix; zero at fixed degrees of freedom.
    fn tangent_times(&self, at: StateRef<'_>, w: crate::model::system::Weights, p: &[f64], y: &mut [f64]);

    /// Upper bound on the largest eigenvalue of M^-1 (c C + k K) at a state, from one pass over the elements, and the
    /// degree of freedom whose node sets it. Proved for symmetric scenes and weights of at least 0; else a measure that
    /// grows as it does.
    fn rate_bound(&self, at: StateRef<'_>, w: crate::model::system::Weights, room: &mut BoundRoom) -> (f64, usize);
}

/// The node of a degree of freedom, and the fastest spring at it, in words.
pub(crate) fn place_of(scene: &dyn Scene, dof: usize) -> String {
    let node = scene.name_of(dof).0;
    scene.fastest_spring(dof).map_or_else(|| format!("node {node}"), |spring| format!("node {node}, spring {spring}"))
}
