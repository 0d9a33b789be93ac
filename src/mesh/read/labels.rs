//! Nodes and elements that are known by labels, in sets with names: what the input of finite-element programs has.

use super::cells::Cells;
use std::collections::{BTreeMap, HashMap, HashSet};

/// Nodes, elements and sets of a file.
#[derive(Default)]
pub(super) struct Labelled {
    pub cells: Cells,
    /// the point of each node
    index: HashMap<u64, u64>,
    elements: Vec<Element>,
    /// sets of elements and of nodes, by labels
    pub element_sets: BTreeMap<String, Vec<u64>>,
    pub node_sets: BTreeMap<String, Vec<u64>>,
}

struct Element {
    label: u64,
    nodes: Vec<u64>,
    /// the set that it is listed in, or empty
    set: String,
}

impl Labelled {
    pub(super) fn add_node(&mut self, label: u64, point: [f64; 3]) -> Result<(), String> {
        if self.index.insert(label, self.cells.points.len() as u64).is_some() {
            return Err(format!("node {label} is listed twice"));
        }
        self.cells.points.push(point);
        Ok(())
    }

    /// Adds a line of two nodes, or a face of more.
    pub(super) fn add_element(&mut self, label: u64, nodes: Vec<u64>, set: &str) {
        self.elements.push(Element { label, nodes, set: set.to_owned() });
    }

    /// Takes from the sets of nodes those of the elements in the set of the same name.
    pub(super) fn drop_nodes_of_elements(&mut self) {
        let nodes_of: HashMap<u64, &[u64]> = self.elements.iter().map(|e| (e.label, e.nodes.as_slice())).collect();
        for (name, labels) in &mut self.node_sets {
            let elements = self.element_sets.get(name).into_iter().flatten();
            let own: HashSet<u64> =
                elements.filter_map(|label| nodes_of.get(label)).copied().flatten().copied().collect();
            labels.retain(|label| !own.contains(label));
        }
    }

    /// The cells, once all nodes are known.
    pub(super) fn finish(mut self) -> Result<Cells, String> {
        // Ranges may hold far more numbers than there are elements.
        let mut sets_of: HashMap<u64, Vec<&str>> =
            self.elements.iter().map(|element| (element.label, Vec::new())).collect();
        for (name, labels) in &self.element_sets {
            for label in labels {
                if let Some(sets) = sets_of.get_mut(label).filter(|sets| sets.last() != Some(&name.as_str())) {
                    sets.push(name);
                }
            }
        }
        let known = |label: &u64| self.index.get(label).copied();
        for Element { label, nodes, set } in &self.elements {
            let missing = |node: &u64| format!("element {label} names node {node}, which is not listed");
            let points = nodes.iter().map(|node| known(node).ok_or_else(|| missing(node)));
            let points: Vec<u64> = points.collect::<Result<_, String>>()?;
            if points.len() == 2 {
                self.cells.add_line(&points, false);
            } else {
                self.cells.add_face(&points);
            }
            let named = sets_of.get(label).into_iter().flatten().copied();
            let mut names: Vec<String> =
                named.chain([set.as_str()]).filter(|name| !name.is_empty()).map(str::to_owned).collect();
            names.sort_unstable();
            names.dedup();
            self.cells.name_cells(&names);
        }
        for (name, labels) in &self.node_sets {
            for point in labels.iter().filter_map(known) {
                self.cells.name_point(std::slice::from_ref(name), point);
            }
        }
        Ok(self.cells)
    }
}

/// What is said of elements that are no lines, triangles or quads of first order.
pub(super) fn not_read(kind: &str) -> String {
    format!(
        "holds elements {kind}; only lines, triangles and quads of first order are read. Write the surface mesh alone"
    )
}
