//! What the groups of a network have in all: members, length, area, mass.

use super::spec::NetworkSpec;
use crate::mesh::Group;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The totals of a group.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GroupTotals {
    /// [-] nodes that it lists
    pub nodes: usize,
    /// [-] edges that it lists
    pub edges: usize,
    /// [-] triangles that it lists
    pub triangles: usize,
    /// [m] rest lengths of the springs on these edges
    pub rest_length: f64,
    /// [m^2] area of these triangles on the mesh as given
    pub area: f64,
    /// [kg] mass of its nodes, or of the nodes of its edges and triangles if it lists none; a node counts in each of
    /// its groups
    pub mass: f64,
}

/// The totals of each group by its name.
pub fn group_totals(spec: &NetworkSpec) -> BTreeMap<String, GroupTotals> {
    let mesh = &spec.mesh;
    if mesh.groups.is_empty() {
        return BTreeMap::new();
    }
    let mut rest_length = vec![0.0; mesh.edges.len()];
    for springs in &spec.springs {
        for (&edge, length) in springs.edges.iter().zip(&springs.rest_length) {
            if let Some(sum) = rest_length.get_mut(edge as usize) {
                *sum += length;
            }
        }
    }
    let totals = |group: &Group| {
        let Group { nodes, edges, triangles } = group;
        let on_edges = edges.iter().filter_map(|&edge| rest_length.get(edge as usize));
        let held = group.select_nodes(mesh);
        GroupTotals {
            nodes: nodes.len(),
            edges: edges.len(),
            triangles: triangles.len(),
            rest_length: on_edges.sum(),
            area: group.area(mesh),
            mass: held.iter().filter_map(|&node| spec.mass.get(node as usize)).sum(),
        }
    };
    mesh.groups.iter().map(|(name, group)| (name.clone(), totals(group))).collect()
}
