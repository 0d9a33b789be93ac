//! Blocks of steps: several steps made at once, of which only the last state is visible.
//!
//! In a small scene the nodes are copied to local buffers once per block of steps, not once per step. The speed of a
//! large scene is limited by memory. A node's next step needs only the forces around it, so the next step can begin
//! behind the one before while nodes are in cache. The nodes are then read from memory once per block ("time skewing":
//! Wonnacott 2000; McCalpin & Wonnacott 1999). Every state within a block has a summary. Its bits are those of steps
//! made one by one.

mod groups;
mod kick_drift;
mod work;

pub use kick_drift::{BoundarySums, KickDriftScheme, Nodes, StepStart, Working};
pub use work::work;

use super::bounds::Bounds;
use super::forces::Tally;

/// Largest number of steps in a block: so many that the start and the end of a block cost almost nothing.
pub const LONGEST: usize = 32;

/// Summary of a step: properties of the state at its end.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepSummary {
    /// [s] its time, at which forces are evaluated; set by the caller
    pub t: f64,
    /// whether `largest_stretch` is wanted; set by the caller
    pub stretch_wanted: bool,
    /// sums over its nodes
    pub nodes: NodeSums,
    /// [-] largest l^2/l0^2 of all springs, -inf where there is none; only if wanted
    pub largest_stretch: f64,
    /// energy or power of every term, in the order of [`crate::model::system::System::terms`]
    pub tallies: Vec<Tally>,
}

/// Sums over some nodes of a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeSums {
    /// [J] kinetic energy
    pub kinetic: f64,
    /// [m^2/s^2] the largest speed, squared
    pub largest_square: f64,
    /// [m] bounding box; computed for the last state of a block, else possibly that of no nodes
    pub bounds: Bounds,
    /// whether all forces are finite, those at fixed degrees of freedom too; computed for the last state of a block. In
    /// the states before, a value that is not finite shows in the kinetic energy, at the latest in the next state
    pub finite: bool,
    /// work in the step that ends here (within a block, the part so far, doubled)
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
    /// The work of external and dissipative forces [N] between two positions [m], with `W` numbers per node: three, and
    /// possibly a fourth that is 0. An empty slice of forces does no work.
    pub fn of<const W: usize>(forces: [&[f64]; 2], from: &[f64], x: &[f64]) -> Self {
        let [external, dissipative] = work::<W, 2>(forces, from, x);
        Work { external, dissipative }
    }

    /// The sum of two works.
    #[must_use]
    pub fn and(self, other: Work) -> Self {
        Work { external: self.external + other.external, dissipative: self.dissipative + other.dissipative }
    }

    /// Half of the work.
    #[must_use]
    pub fn halved(self) -> Self {
        Work { external: 0.5 * self.external, dissipative: 0.5 * self.dissipative }
    }
}

/// The value for no nodes.
impl Default for NodeSums {
    fn default() -> Self {
        let (bounds, work) = (Bounds::default(), Work::default());
        NodeSums { kinetic: 0.0, largest_square: 0.0, bounds, finite: true, work }
    }
}

impl NodeSums {
    /// The sums of these nodes and the following ones.
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

    /// [-] largest strain of all springs; 0 without springs. Valid only if it was wanted.
    pub fn max_strain(&self) -> f64 {
        strain_of(self.largest_stretch)
    }
}

/// [-] strain of a spring by its l^2/l0^2, 0 for -inf: a single root for all springs; its rounding error at rest length
/// is 2e-16.
pub fn strain_of(stretch: f64) -> f64 {
    if stretch == f64::NEG_INFINITY { 0.0 } else { stretch.sqrt() - 1.0 }
}
