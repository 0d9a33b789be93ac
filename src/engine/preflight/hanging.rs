//! Nodes on the edge of a triangle that they do not belong to.

use crate::mesh::hanging::{describe, hanging_nodes};
use crate::mesh::{Mesh, Topology};
use crate::warning::{Warning, WarningCode};

/// A warning for nodes that lie on the edges of cloth without being joined to it.
pub fn hanging(mesh: &Mesh, topology: &Topology) -> Option<Warning> {
    Some(Warning::new(WarningCode::HangingNode, describe(&hanging_nodes(mesh, topology))?))
}
