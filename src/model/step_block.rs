//! Blocks of steps: several steps in one go, of which only the last state is seen.
//!
//! In a small scene the nodes of a block of steps are copied to local buffers once, not once a step. A large scene
//! waits for memory: a node's next step needs only the forces around it, so the next step can begin behind the one
//! before while nodes are in cache, and memory is crossed once a block ("time skewing": Wonnacott 2000; McCalpin &
//! Wonnacott 1999). Every state within a block has a summary. Its bits are those of steps made one by one.

mod kick_drift;
mod work;

pub use kick_drift::{KickDriftScheme, Nodes, StepStart, Working};
pub use work::work;

use super::bounds::Bounds;
use super::forces::Tally;

/// Steps of a block at most: so many that the beginning and the end of a block cost next to nothing.
pub const LONGEST: usize = 32;

/// Summary of a step: what is known of the state at its end.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepSummary {
    /// [s] its time, at which forces are found; set by the caller
    pub t: f64,
    /// whether `largest_stretch` is asked for; set by the caller
    pub stretch_wanted: bool,
    /// what its nodes are like
    pub nodes: NodeSums,
    /// [-] largest l^2/l0^2 of all springs, -inf where there is none; only where it was asked for
    pub largest_stretch: f64,
    /// energy or power of every term, in the order of [`crate::model::system::System::terms`]
    pub tallies: Vec<Tally>,
}

/// What some nodes of a state are like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeSums {
    /// [J] kinetic energy
    pub kinetic: f64,
    /// [m^2/s^2] the largest speed, squared
    pub largest_square: f64,
    /// [m] bounding box; known of the last state of a block, else possibly that of no nodes
    pub bounds: Bounds,
    /// whether all forces are finite, those at fixed degrees of freedom too; told of a block's last state: in those
    /// before what is not finite shows in the kinetic energy, of the next state at the latest
    pub finite: bool,
    /// what was done in the step that ends here (within a block, what was done of it so far, doubled)
    pub work: Work,
}

/// Work in a step, 1/2 (f_n + f_{n+1}) . (x_{n+1} - x_n).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work {
    /// [J] of external forces
    pub external: f64,
    /// [J] of dissipative forces: below zero where they take energy
    pub dissipative: f64,
}

impl Work {
    /// Of external and dissipative forces [N] along the way between positions [m] of `W` numbers a node, three and
    /// perhaps one that is 0. An empty slice of forces does no work.
    pub fn of<const W: usize>(forces: [&[f64]; 2], from: &[f64], x: &[f64]) -> Self {
        let [external, dissipative] = work::<W, 2>(forces, from, x);
        Work { external, dissipative }
    }

    /// The work of two pieces, or in two halves.
    #[must_use]
    pub fn and(self, other: Work) -> Self {
        Work { external: self.external + other.external, dissipative: self.dissipative + other.dissipative }
    }

    /// Half of it.
    #[must_use]
    pub fn halved(self) -> Self {
        Work { external: 0.5 * self.external, dissipative: 0.5 * self.dissipative }
    }
}

/// Of no nodes.
impl Default for NodeSums {
    fn default() -> Self {
        let (bounds, work) = (Bounds::default(), Work::default());
        NodeSums { kinetic: 0.0, largest_square: 0.0, bounds, finite: true, work }
    }
}

impl NodeSums {
    /// With those of the nodes that follow.
    #[must_use]
    pub fn and(self, next: NodeSums) -> Self {
        NodeSums {
            kinetic: self.kinetic + next.kinetic,
            largest_square: self.largest_square.max(next.largest_square),
            bounds: self.bounds.and(next.bounds),
            finite: self.finite && next.finite,
            work: self.work.and(next.work),
        }
    }
}

impl StepSummary {
    /// [m/s] largest speed
    pub fn max_speed(&self) -> f64 {
        self.nodes.largest_square.sqrt()
    }

    /// [-] largest strain of all springs; 0 where there is none. Meaningful where it was asked for.
    pub fn max_strain(&self) -> f64 {
        strain_of(self.largest_stretch)
    }
}

/// [-] strain of a spring by its l^2/l0^2, 0 for -inf: one root for all, which leaves 2e-16 of springs at their rest
/// length.
pub fn strain_of(stretch: f64) -> f64 {
    if stretch == f64::NEG_INFINITY { 0.0 } else { stretch.sqrt() - 1.0 }
}
