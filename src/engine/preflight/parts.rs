//! Connected parts of a network: nodes joined by springs, membranes and bending.

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

/// Pairs of nodes joined by a spring, a membrane or a bending stiffness. Loads on triangles do not connect nodes.
pub(super) fn joined(spec: &NetworkSpec) -> impl Iterator<Item = [u32; 2]> + '_ {
    let edges = spec.springs.iter().flat_map(|group| &group.edges);
    let springs = edges.filter_map(|edge| spec.mesh.edges.get(*edge as usize).copied());
    let triangles = spec.membranes.iter().flat_map(|membrane| &membrane.triangles);
    let triangles = triangles.filter_map(|triangle| spec.mesh.triangles.get(*triangle as usize));
    let membranes = triangles.flat_map(|&[a, b, c]| [[a, b], [b, c]]);
    let hinges = spec.bending.iter().flat_map(|bending| &bending.hinges);
    let hinges = hinges.flat_map(|&[a, b, c, d]| [[a, b], [b, c], [c, d]]);
    let chains = spec.bending.iter().flat_map(|bending| &bending.chains).flat_map(|&[a, b, c]| [[a, b], [b, c]]);
    springs.chain(membranes).chain(hinges).chain(chains)
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

/// A canopy whose lines end beside it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LooseLines {
    /// a node where its lines meet
    pub confluence: u32,
    /// a node of its skirt
    pub skirt: u32,
}

/// Finds a canopy with lines at its confluence of which no spring leads to its skirt.
pub fn loose_lines(spec: &NetworkSpec, parts: &Parts) -> Option<LooseLines> {
    let part = |node: u32| parts.of_node.get(node as usize).copied();
    spec.canopies.iter().find_map(|canopy| {
        let &skirt = canopy.skirt.first()?;
        let hangs = |node: u32| canopy.skirt.iter().any(|skirt| part(*skirt) == part(node));
        let lines = |node: u32| part(node).is_some_and(|part| parts.size[part as usize] > 1);
        let &confluence = canopy.confluence.iter().find(|node| lines(**node) && !hangs(**node))?;
        Some(LooseLines { confluence, skirt })
    })
}

impl fmt::Display for LooseLines {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let LooseLines { confluence, skirt } = self;
        write!(
            f,
            "the lines at node {confluence}, the confluence, are not joined to the canopy, whose skirt has node {skirt}: give \
             lines and cloth common nodes (\"merge\" does for a mesh file), and the lines springs"
        )
    }
}

impl From<LooseLines> for Warning {
    fn from(found: LooseLines) -> Self {
        Warning::new(WarningCode::LooseLines, found.to_string())
    }
}
