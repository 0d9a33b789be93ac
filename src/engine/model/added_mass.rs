//! What mass scaling has done to a scene.

use crate::format_number::{counted, figures};
use serde::{Deserialize, Serialize};

/// Mass that was added for longer steps. Only inertia is added: weight and damping by mass are those of the real
/// masses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AddedMass {
    /// [s] step of central differences that the elements allow with it, by their bound
    pub step: f64,
    /// [kg] what was added in all
    pub added: f64,
    /// [-] the same over the mass of all nodes that can move
    pub share: f64,
    /// nodes that got some
    pub nodes: u64,
    /// [-] what was added over the mass that these nodes have
    pub share_of_nodes: f64,
    /// [-] largest inertia of a node over its mass
    pub largest_factor: f64,
    /// the node which has that, in the user's numbering
    pub largest_at: u32,
}

impl AddedMass {
    /// One line of a report.
    pub fn text(&self) -> String {
        let AddedMass { step, added, share, nodes, share_of_nodes, largest_factor, largest_at } = *self;
        let [share, share_of_nodes] = [share, share_of_nodes].map(|share| figures(100.0 * share, 2));
        format!(
            "{} kg added for steps of {} s: {share} % of all that moves; {share_of_nodes} % on the {} that got some, \
             {} times its own mass at most (node {largest_at})",
            figures(added, 3),
            figures(step, 4),
            counted(nodes, "node", "nodes"),
            figures(largest_factor, 3),
        )
    }
}
