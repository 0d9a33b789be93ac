//! Nodes and elements that are known by labels, in sets with names: what the input of finite-element programs has.

use super::cells::Cells;
use super::statements::LeftOut;
use super::{MOST_MADE, MOST_MEMBERS};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Labels of a set as ranges: the first, the last and the step.
#[derive(Clone, Debug, Default)]
pub(super) struct Labels(Vec<[u64; 3]>);

impl Labels {
    pub(super) fn push(&mut self, label: u64) {
        match self.0.last_mut() {
            // Sets mostly count up.
            Some([_, last, 1]) if label.checked_sub(1) == Some(*last) => *last = label,
            _ => self.0.push([label, label, 1]),
        }
    }

    pub(super) fn push_range(&mut self, [first, last, step]: [u64; 3]) {
        if first <= last {
            self.0.push([first, last, step.max(1)]);
        }
    }

    /// Adds the labels of another set, each moved by `offset`.
    pub(super) fn extend(&mut self, other: &Labels, offset: u64) {
        let moved = other
            .0
            .iter()
            .map(|[first, last, step]| [first.saturating_add(offset), last.saturating_add(offset), *step]);
        self.0.extend(moved);
        // A set of sets that hold each other grows no further.
        self.0.sort_unstable();
        self.0.dedup();
    }

    /// Number of ranges.
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// Those of some labels, ascending with their positions, that are in the set. `visits` counts them.
    pub(super) fn among<'a>(&self, known: &'a [(u64, u32)], visits: &mut u64) -> Result<Vec<&'a (u64, u32)>, String> {
        let mut ranges = self.0.clone();
        ranges.sort_unstable();
        let mut found = Vec::new();
        let mut until: Option<u64> = None;
        for [first, last, step] in ranges {
            // What an earlier range of step 1 held already is not looked at again.
            let from = match until {
                Some(until) if step == 1 => first.max(until.saturating_add(1)),
                _ => first,
            };
            let begin = known.partition_point(|(label, _)| *label < from);
            let end = known.partition_point(|(label, _)| *label <= last);
            let listed = known.get(begin..end).unwrap_or_default();
            *visits = visits.saturating_add(listed.len() as u64);
            let most = MOST_MEMBERS + 8 * known.len() as u64;
            if *visits > most {
                return Err(format!("has sets of more than {most} members; write smaller ones"));
            }
            found.extend(listed.iter().filter(|(label, _)| (label - first).is_multiple_of(step)));
            if step == 1 {
                until = until.max(Some(last));
            }
        }
        Ok(found)
    }
}

/// Nodes, elements and sets of a file.
#[derive(Clone, Debug, Default)]
pub(super) struct Labelled {
    pub cells: Cells,
    /// the point of each node
    index: HashMap<u64, u64>,
    elements: Vec<Element>,
    /// the element of each label, of those that were asked for first
    element_of: HashMap<u64, u32>,
    indexed: usize,
    /// nodes and elements that one statement made of another
    made: u64,
    /// sets of elements and of nodes, by labels
    pub element_sets: BTreeMap<String, Labels>,
    pub node_sets: BTreeMap<String, Labels>,
    /// sets of nodes that hold the nodes of sets of elements
    pub nodes_of_elements: Vec<(String, Labels)>,
    /// whether a set of nodes also lists those of the elements in the set of the same name, which are no group
    pub nodes_repeat_elements: bool,
}

#[derive(Clone, Debug)]
struct Element {
    label: u64,
    nodes: Vec<u64>,
}

impl Labelled {
    pub(super) fn add_node(&mut self, label: u64, point: [f64; 3]) -> Result<(), String> {
        if self.index.insert(label, self.cells.points.len() as u64).is_some() {
            return Err(format!("node {label} is listed twice"));
        }
        self.cells.points.push(point);
        Ok(())
    }

    /// The place of a node.
    pub(super) fn node(&self, label: u64) -> Option<[f64; 3]> {
        self.cells.points.get(*self.index.get(&label)? as usize).copied()
    }

    /// Adds a line of two nodes, or a face of more, to a set unless its name is empty.
    pub(super) fn add_element(&mut self, label: u64, nodes: Vec<u64>, set: &str) {
        self.elements.push(Element { label, nodes });
        if !set.is_empty() {
            set_of(&mut self.element_sets, set).push(label);
        }
    }

    /// The nodes of an element.
    pub(super) fn nodes_of(&mut self, label: u64) -> Option<&[u64]> {
        for (element, at) in self.elements.iter().zip(0..).skip(self.indexed) {
            self.element_of.insert(element.label, at);
        }
        self.indexed = self.elements.len();
        Some(&self.elements[*self.element_of.get(&label)? as usize].nodes)
    }

    /// Number of nodes and elements.
    pub(super) fn size(&self) -> u64 {
        (self.index.len() + self.elements.len()) as u64
    }

    /// Counts nodes or elements that a statement makes.
    pub(super) fn count_made(&mut self, count: u64) -> Result<(), String> {
        self.made = self.made.saturating_add(count);
        if self.made > MOST_MADE {
            return Err(format!("makes more than {MOST_MADE} nodes and elements; write them out"));
        }
        Ok(())
    }

    /// Adds all nodes, elements and sets of another model, with their labels moved by `offset`, at the places that
    /// `place` gives; `name` makes the names of its sets.
    pub(super) fn add_copy(
        &mut self,
        other: &Labelled,
        offset: u64,
        place: impl Fn([f64; 3]) -> [f64; 3],
        name: impl Fn(&str) -> String,
    ) -> Result<(), String> {
        let mut labels: Vec<(u64, u64)> = other.index.iter().map(|(label, point)| (*point, *label)).collect();
        labels.sort_unstable();
        for (point, label) in labels {
            self.add_node(label + offset, place(other.cells.points[point as usize]))?;
        }
        for Element { label, nodes } in &other.elements {
            self.add_element(label + offset, nodes.iter().map(|node| node + offset).collect(), "");
        }
        for (to, from) in [(&mut self.node_sets, &other.node_sets), (&mut self.element_sets, &other.element_sets)] {
            for (set, labels) in from {
                to.entry(name(set)).or_default().extend(labels, offset);
            }
        }
        for (set, labels) in &other.nodes_of_elements {
            let mut moved = Labels::default();
            moved.extend(labels, offset);
            self.nodes_of_elements.push((name(set), moved));
        }
        for (what, count) in &other.cells.remarks {
            *self.cells.remarks.entry(what).or_default() += count;
        }
        Ok(())
    }

    /// The cells, once all nodes are known, with a note of the statements that were left out.
    pub(super) fn finish(mut self, left: &LeftOut) -> Result<Cells, String> {
        let mut visits = 0;
        let mut known: Vec<(u64, u32)> = self.elements.iter().map(|element| element.label).zip(0..).collect();
        known.sort_unstable();
        // Sets by their numbers, which ascend as their names do.
        let names: Vec<&String> = self.element_sets.keys().collect();
        let mut sets_of: Vec<Vec<u32>> = vec![Vec::new(); self.elements.len()];
        for (labels, number) in self.element_sets.values().zip(0..) {
            for (_, at) in labels.among(&known, &mut visits)? {
                let sets = &mut sets_of[*at as usize];
                if sets.last() != Some(&number) {
                    sets.push(number);
                }
            }
        }
        for (name, labels) in &self.nodes_of_elements {
            for (_, at) in labels.among(&known, &mut visits)? {
                for node in &self.elements[*at as usize].nodes {
                    set_of(&mut self.node_sets, name).push(*node);
                }
            }
        }
        let mut repeated: HashMap<&String, HashSet<u64>> = HashMap::new();
        for (name, labels) in self.element_sets.iter().filter(|_| self.nodes_repeat_elements) {
            let elements = labels.among(&known, &mut visits)?;
            let nodes = elements.into_iter().flat_map(|(_, at)| &self.elements[*at as usize].nodes);
            repeated.insert(name, nodes.copied().collect());
        }
        let (mut last, mut last_names) = (Vec::new(), Vec::new());
        for (Element { label, nodes }, sets) in self.elements.iter().zip(sets_of) {
            let (label, nodes_in) = (short(*label), nodes.iter());
            let missing = |node: u64| format!("element {label} names node {}, which is not listed", short(node));
            let points = nodes_in.map(|node| self.index.get(node).copied().ok_or_else(|| missing(*node)));
            let points: Vec<u64> = points.collect::<Result<_, String>>()?;
            if points.len() == 2 {
                self.cells.add_line(&points, false);
            } else {
                self.cells.add_face(&points);
            }
            if sets != last {
                last_names = sets.iter().filter_map(|set| names.get(*set as usize).copied().cloned()).collect();
                last = sets;
            }
            self.cells.name_cells(&last_names);
        }
        let mut known: Vec<(u64, u32)> = self.index.iter().map(|(label, point)| (*label, *point as u32)).collect();
        known.sort_unstable();
        for (name, labels) in &self.node_sets {
            let repeats = |node: &u64| repeated.get(name).is_some_and(|nodes| nodes.contains(node));
            for (_, point) in labels.among(&known, &mut visits)?.into_iter().filter(|(node, _)| !repeats(node)) {
                self.cells.name_point(std::slice::from_ref(name), u64::from(*point));
            }
        }
        self.cells.notes.extend(left.note());
        Ok(self.cells)
    }
}

/// The set of a name.
pub(super) fn set_of<'a>(sets: &'a mut BTreeMap<String, Labels>, name: &str) -> &'a mut Labels {
    sets.entry(name.to_owned()).or_default()
}

/// Labels of further kinds, or of instances, count from multiples of this.
pub(super) const KIND: u64 = 1 << 40;

/// A label as the file has it.
fn short(label: u64) -> u64 {
    label % KIND
}

/// What is said of elements that are no lines, triangles or quads of first order.
pub(super) fn not_read(kind: &str) -> String {
    format!(
        "holds elements {kind}; only lines, triangles and quads of first order are read. Write the surface mesh alone"
    )
}
