//! Strides: several steps on end, of which only the last state is seen.
//!
//! Explicit steps of a small scene copy its nodes to and fro; what is copied once a stride is not copied once a step. Those of a large scene wait for memory. Where all forces follow from positions alone, a node's next step needs no more than the forces around
//! it, so the next step can begin behind the one before while nodes are in cache, and memory is crossed once a stride in place of once a step ("time
//! skewing": Wonnacott 2000; McCalpin & Wonnacott 1999). Of every state on the way there is an account; its bits are those of steps made one by one.

mod kicks;

pub use kicks::{Kicks, Nodes};

use super::bounds::Bounds;
use super::forces::Tally;

/// Steps of a stride at most: so many that what begins and ends one is next to nothing.
pub const LONGEST: usize = 32;

/// What is left of a state within a stride.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Passed {
    /// whether `largest_stretch` is asked for; set by the caller
    pub stretch_wanted: bool,
    /// what its nodes are like
    pub nodes: NodeSums,
    /// [-] largest l^2/l0^2 of all springs, -inf where there is none; told where it is asked for
    pub largest_stretch: f64,
    /// energy of every term, in the order of [`crate::model::system::System::terms`]
    pub tallies: Vec<Tally>,
}

/// What some nodes of a state are like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeSums {
    /// [J] kinetic energy
    pub kinetic: f64,
    /// [m^2/s^2] the largest speed, squared
    pub largest_square: f64,
    /// the box they lie in
    pub bounds: Bounds,
    /// whether all forces are finite, those at fixed degrees of freedom too
    pub finite: bool,
}

/// Of no nodes.
impl Default for NodeSums {
    fn default() -> Self {
        NodeSums { kinetic: 0.0, largest_square: 0.0, bounds: Bounds::default(), finite: true }
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
        }
    }
}

impl Passed {
    /// [m/s] largest speed
    pub fn max_speed(&self) -> f64 {
        self.nodes.largest_square.sqrt()
    }

    /// [-] largest strain of all springs; 0 where there is none. Meaningful where it was asked for.
    pub fn max_strain(&self) -> f64 {
        strain_of(self.largest_stretch)
    }
}

/// [-] strain of a spring by its l^2/l0^2, 0 for -inf: one root for all, which leaves 2e-16 of springs at their rest length.
pub fn strain_of(stretch: f64) -> f64 {
    if stretch == f64::NEG_INFINITY { 0.0 } else { stretch.sqrt() - 1.0 }
}
