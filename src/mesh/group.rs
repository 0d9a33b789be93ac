//! Named parts of a mesh.
//!
//! A group mostly has members of one kind. Asked for another kind, it gives what follows from its members: the nodes
//! of its edges and triangles, and the edges of its triangles. It gives no edges for nodes, because edges between
//! selected nodes are seldom what is meant.

use super::{Mesh, MeshError};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Groups by name.
pub type Groups = BTreeMap<String, Group>;

/// Name of the arrays of a .vtu file, on cells and on points, with the numbers of groups.
pub(crate) const GROUP: &str = "group";
/// Name of the cell array of a frame that tells triangles, their sides and other edges apart.
pub const KIND: &str = "kind";
/// What the name of the field array of a group of triangles and edges begins with.
pub(super) const CELL_GROUP: &str = "group ";
/// The same of a group of nodes.
pub(super) const NODE_GROUP: &str = "node group ";

/// [-] largest number of characters of a group's name
pub(super) const LONGEST_NAME: usize = 200;

/// The members of a group; every list is ascending.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Group {
    /// [-] node numbers, counted from 0
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub nodes: Vec<u32>,
    /// [-] edge numbers, counted from 0
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub edges: Vec<u32>,
    /// [-] triangle numbers, counted from 0
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub triangles: Vec<u32>,
}

impl Group {
    /// A group of nodes.
    pub fn of_nodes(nodes: impl IntoIterator<Item = u32>) -> Self {
        Self { nodes: ascending(nodes), ..Self::default() }
    }

    /// A group of edges.
    pub fn of_edges(edges: impl IntoIterator<Item = u32>) -> Self {
        Self { edges: ascending(edges), ..Self::default() }
    }

    /// Its nodes, ascending: those it lists, else those of its edges and triangles.
    pub fn select_nodes(&self, mesh: &Mesh) -> Vec<u32> {
        if !self.nodes.is_empty() {
            return self.nodes.clone();
        }
        let edges = self.edges.iter().filter_map(|&e| mesh.edges.get(e as usize)).flatten();
        let triangles = self.triangles.iter().filter_map(|&t| mesh.triangles.get(t as usize)).flatten();
        ascending(edges.chain(triangles).copied())
    }

    /// Its edges, ascending: those it lists, else the edges of its triangles; none if it lists nodes only.
    pub fn select_edges(&self, mesh: &Mesh) -> Vec<u32> {
        if !self.edges.is_empty() || self.triangles.is_empty() {
            return self.edges.clone();
        }
        let key = |a: u32, b: u32| (a.min(b), a.max(b));
        let corners = self.triangles.iter().filter_map(|&t| mesh.triangles.get(t as usize));
        let sides: BTreeSet<_> = corners.flat_map(|&[a, b, c]| [key(a, b), key(b, c), key(c, a)]).collect();
        let numbered = mesh.edges.iter().zip(0..);
        numbered.filter(|([a, b], _)| sides.contains(&key(*a, *b))).map(|(_, edge)| edge).collect()
    }

    /// [m] Length of the edges that it lists.
    pub fn length(&self, mesh: &Mesh) -> f64 {
        self.edges.iter().filter_map(|&edge| mesh.cut_length(edge)).sum()
    }

    /// [m^2] Area of the triangles that it lists.
    pub fn area(&self, mesh: &Mesh) -> f64 {
        let corners = self.triangles.iter().filter_map(|&triangle| mesh.cut_corners(triangle));
        corners.map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm()).sum()
    }

    /// Its members in words: "12 nodes, 24 edges".
    pub fn describe(&self) -> String {
        let lists = [(&self.nodes, "node"), (&self.edges, "edge"), (&self.triangles, "triangle")];
        let count = |list: &[u32], one: &str| format!("{} {one}{}", list.len(), if list.len() == 1 { "" } else { "s" });
        let parts = lists.into_iter().filter(|(list, _)| !list.is_empty()).map(|(list, one)| count(list, one));
        parts.collect::<Vec<_>>().join(", ")
    }
}

/// The numbers in ascending order, each once.
fn ascending(numbers: impl IntoIterator<Item = u32>) -> Vec<u32> {
    let mut numbers: Vec<u32> = numbers.into_iter().collect();
    numbers.sort_unstable();
    numbers.dedup();
    numbers
}

/// One line for each group: its name, the counts of its members, the length of its edges, the area of its triangles.
pub fn describe_groups(mesh: &Mesh) -> Vec<String> {
    let describe = |(name, group): (&String, &Group)| {
        let mut text = format!("{name}: {}", group.describe());
        if !group.edges.is_empty() {
            text += &format!(", {:.6} m", group.length(mesh));
        }
        if !group.triangles.is_empty() {
            text += &format!(", {:.6} m^2", group.area(mesh));
        }
        text
    };
    mesh.groups.iter().map(describe).collect()
}

impl Mesh {
    /// Checks the groups: a name and at least one member each, numbers in range and ascending.
    pub(super) fn check_groups(&self) -> Result<(), MeshError> {
        for (name, group) in &self.groups {
            let refuse = |reason: String| Err(MeshError::Group { name: name.clone(), reason });
            let length = name.chars().count();
            if name.trim() != name || length == 0 || length > LONGEST_NAME || name.chars().any(char::is_control) {
                return refuse(format!(
                    "a name has 1 to {LONGEST_NAME} characters, none of them a control character, and no blank at its ends"
                ));
            }
            let lists = [
                ("node", &group.nodes, self.nodes.len()),
                ("edge", &group.edges, self.edges.len()),
                ("triangle", &group.triangles, self.triangles.len()),
            ];
            for (what, list, count) in lists {
                if let Some(number) = list.iter().find(|&&i| i as usize >= count) {
                    return refuse(format!(
                        "it names {what} {number}, but the mesh has {count} {what}s, numbered from 0"
                    ));
                }
                if let Some(pair) = list.windows(2).find(|pair| pair[0] >= pair[1]) {
                    return refuse(format!(
                        "list its {what}s in ascending order, each once: {} is before {}",
                        pair[0], pair[1]
                    ));
                }
            }
            if *group == Group::default() {
                return refuse("it has no members; give it some or leave it out".to_owned());
            }
        }
        Ok(())
    }
}

/// Group membership as files store it: one number for each cell and node, and for each group the numbers of its
/// members.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GroupNumbers {
    /// of each cell, triangles before edges; 0 = in no group
    pub cells: Vec<i32>,
    /// of each node; 0 = in no group
    pub nodes: Vec<i32>,
    /// name of each group with triangles or edges, and the numbers its cells have
    pub cell_groups: Vec<(String, Vec<i32>)>,
    /// the same for nodes
    pub node_groups: Vec<(String, Vec<i32>)>,
}

impl GroupNumbers {
    /// The numbers of groups in a mesh of so many nodes, triangles and edges: members of the same groups have the same
    /// number.
    pub fn new(groups: &Groups, [nodes, triangles, edges]: [usize; 3]) -> Self {
        let first = triangles as u32;
        let of_cells = |g: &Group| g.triangles.iter().copied().chain(g.edges.iter().map(|e| first + e)).collect();
        let (cells, cell_groups) = numbered(groups, triangles + edges, of_cells);
        let (nodes, node_groups) = numbered(groups, nodes, |g: &Group| g.nodes.clone());
        Self { cells, nodes, cell_groups, node_groups }
    }

    /// The cell array with its name; none without groups of triangles and edges.
    pub fn cell_array(&self) -> Option<(&str, &[i32])> {
        (!self.cell_groups.is_empty()).then_some((GROUP, &self.cells))
    }

    /// The point array with its name; none without groups of nodes.
    pub fn point_array(&self) -> Option<(&str, &[i32])> {
        (!self.node_groups.is_empty()).then_some((GROUP, &self.nodes))
    }

    /// The arrays of the file as a whole that name the groups of each number.
    pub fn field_arrays(&self) -> Vec<(String, Vec<i32>)> {
        let named = |prefix: &str, list: &[(String, Vec<i32>)]| {
            list.iter().map(|(name, numbers)| (format!("{prefix}{name}"), numbers.clone())).collect::<Vec<_>>()
        };
        [named(CELL_GROUP, &self.cell_groups), named(NODE_GROUP, &self.node_groups)].concat()
    }
}

/// The number of each of `count` members, and the numbers of each group.
fn numbered(
    groups: &Groups,
    count: usize,
    members: impl Fn(&Group) -> Vec<u32>,
) -> (Vec<i32>, Vec<(String, Vec<i32>)>) {
    let mut numbers = vec![0; count];
    // Each group in turn splits every class of members that it contains a part of.
    let mut classes: Vec<Vec<usize>> = vec![Vec::new()];
    for (index, group) in groups.values().enumerate() {
        let mut split: HashMap<i32, i32> = HashMap::new();
        for member in members(group) {
            let Some(number) = numbers.get_mut(member as usize) else { continue };
            *number = *split.entry(*number).or_insert_with(|| {
                let mut class = classes.get(*number as usize).cloned().unwrap_or_default();
                class.push(index);
                classes.push(class);
                classes.len() as i32 - 1
            });
        }
    }
    // A class that was split off as a whole leaves its number unused.
    let used: BTreeSet<i32> = numbers.iter().copied().chain([0]).collect();
    let dense: BTreeMap<i32, i32> = used.into_iter().zip(0..).collect();
    numbers.iter_mut().for_each(|number| *number = dense.get(number).copied().unwrap_or_default());
    let holding = |index: usize| {
        let held = dense.iter().filter(|(class, _)| classes.get(**class as usize).is_some_and(|c| c.contains(&index)));
        held.map(|(_, number)| *number).collect::<Vec<i32>>()
    };
    let named = groups.keys().enumerate().map(|(i, name)| (name.clone(), holding(i)));
    let named = named.filter(|(_, numbers)| !numbers.is_empty()).collect();
    (numbers, named)
}
