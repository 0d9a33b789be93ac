//! Connected parts of a network: nodes joined by springs.

use std::fmt;

use crate::format_number::first_few;
use crate::mesh::components::components;
use crate::model::spec::NetworkSpec;
use crate::warning::{Warning, WarningCode};

/// The parts of a network, named by their smallest nodes.
#[derive(Clone, Debug)]
pub struct Parts {
    /// part of every node
    of_node: Vec<u32>,
    /// by the name of a part: whether a support holds one of its nodes in any direction
    held: Vec<bool>,
    /// by the name of a part: its number of nodes
    size: Vec<u32>,
}

/// Pairs of nodes joined by a spring. Loads on triangles do not connect nodes.
pub(super) fn joined(spec: &NetworkSpec) -> impl Iterator<Item = [u32; 2]> + '_ {
    let edges = spec.springs.iter().flat_map(|group| &group.edges);
    edges.filter_map(|edge| spec.mesh.edges.get(*edge as usize).copied())
}

impl Parts {
    /// Finds the parts.
    pub fn new(spec: &NetworkSpec) -> Self {
        let of_node = components(spec.mesh.nodes.len(), joined(spec));
        let (mut held, mut size) = (vec![false; of_node.len()], vec![0; of_node.len()]);
        for (part, fixed) in of_node.iter().zip(&spec.fixed) {
            held[*part as usize] |= fixed.contains(&true);
            size[*part as usize] += 1;
        }
        Parts { of_node, held, size }
    }

    /// Whether a node belongs to a part of at least two nodes that no support holds.
    pub fn is_free(&self, node: u32) -> bool {
        let part = self.of_node.get(node as usize).map(|part| *part as usize);
        part.is_some_and(|part| !self.held[part] && self.size[part] > 1)
    }

    /// Nodes of all parts of at least two nodes that no support holds, ascending.
    fn free_nodes(&self) -> Vec<u32> {
        (0..self.of_node.len() as u32).filter(|node| self.is_free(*node)).collect()
    }
}

/// Unsupported parts in a scene with supports.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unsupported {
    /// their nodes, ascending
    pub nodes: Vec<u32>,
    /// [-] number of the parts
    pub parts: usize,
}

/// Finds parts of at least two nodes without a support in a scene with supports.
pub fn unsupported(parts: &Parts) -> Option<Unsupported> {
    let nodes = if parts.held.contains(&true) { parts.free_nodes() } else { Vec::new() };
    let named = nodes.iter().filter(|node| parts.of_node.get(**node as usize) == Some(node)).count();
    (!nodes.is_empty()).then_some(Unsupported { nodes, parts: named })
}

impl fmt::Display for Unsupported {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts = match self.parts {
            1 => "they form a separate part".to_owned(),
            n => format!("they form {n} separate parts"),
        };
        write!(
            f,
            "nodes {} are connected to no support, but others are: {parts}, which nothing keeps in place; join them to the rest by springs or shared nodes, or support them",
            first_few(&self.nodes)
        )
    }
}

impl From<Unsupported> for Warning {
    fn from(found: Unsupported) -> Self {
        Warning::new(WarningCode::NoSupport, found.to_string())
    }
}
