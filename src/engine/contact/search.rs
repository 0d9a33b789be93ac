//! Finds the pairs whose boxes are near, with a tree of boxes around the elements of every body.

use super::bodies::{Body, Contact, Contacts, Other, sides};
use super::distance::PairKind;
use super::near::{Candidate, Form, NO_NODE};
use crate::mesh::box_tree::{Bounds, BoxTree};

/// Trees around the elements of a body.
#[derive(Clone, Debug)]
struct Trees {
    triangles: BoxTree,
    /// with half the reach on all sides
    edges: BoxTree,
    lines: BoxTree,
    points: BoxTree,
}

impl Trees {
    fn new(body: &Body, place: &impl Fn(u32) -> Bounds, reach: f64) -> Self {
        fn tree<const N: usize>(elements: &[[u32; N]], place: &impl Fn(u32) -> Bounds, margin: f64) -> BoxTree {
            BoxTree::new(&elements.iter().map(|nodes| around(nodes, place).grown(margin)).collect::<Vec<_>>())
        }
        let points: Vec<[u32; 1]> = body.points.iter().map(|node| [*node]).collect();
        Trees {
            triangles: tree(&body.triangles, place, 0.0),
            edges: tree(&body.edges, place, 0.5 * reach),
            lines: tree(&body.lines, place, 0.0),
            points: tree(&points, place, 0.0),
        }
    }

    fn refit(&mut self, body: &Body, place: &impl Fn(u32) -> Bounds, reach: f64) {
        self.triangles.refit(|i| around(&body.triangles[i as usize], place));
        self.edges.refit(|i| around(&body.edges[i as usize], place).grown(0.5 * reach));
        self.lines.refit(|i| around(&body.lines[i as usize], place));
        self.points.refit(|i| place(body.points[i as usize]));
    }
}

fn around(nodes: &[u32], place: &impl Fn(u32) -> Bounds) -> Bounds {
    nodes.iter().fold(Bounds::EMPTY, |all, node| all.joined(place(*node)))
}

/// Finds pairs whose boxes are near.
#[derive(Clone, Debug, Default)]
pub struct Search {
    /// of both sides of every contact; the second is there if it is another body
    trees: Vec<[Option<Trees>; 2]>,
}

impl Search {
    /// Overwrites `found` with all pairs whose boxes, from the boxes of their nodes, are closer than `reach` [m] of
    /// their contact, and that `keep` keeps: it says by how much [m] their distance is above their gap. In order, each
    /// once. Ends early when `looks`, the number of boxes that may be looked at, is used up.
    pub fn find(
        &mut self,
        contacts: &Contacts,
        (place, reach): (impl Fn(u32) -> Bounds, impl Fn(&Contact) -> f64),
        keep: impl Fn(u16, Form, [u32; 4]) -> Option<f64>,
        looks: &mut u64,
        found: &mut Vec<Candidate>,
    ) {
        found.clear();
        self.trees.resize_with(contacts.list.len(), Default::default);
        for ((number, contact), trees) in (0_u16..).zip(&contacts.list).zip(&mut self.trees) {
            let mut pairs = Pairs { contacts, number, keep: &keep, looks: &mut *looks, found: &mut *found };
            pairs.of(contact, trees, &place, reach(contact));
        }
        found.sort_unstable_by_key(Candidate::key);
        found.dedup_by_key(|candidate| candidate.key());
    }
}

/// Collects the pairs of a contact.
struct Pairs<'a, K> {
    contacts: &'a Contacts,
    number: u16,
    keep: &'a K,
    looks: &'a mut u64,
    found: &'a mut Vec<Candidate>,
}

impl<K: Fn(u16, Form, [u32; 4]) -> Option<f64>> Pairs<'_, K> {
    fn of(
        &mut self,
        contact: &Contact,
        [own, others]: &mut [Option<Trees>; 2],
        place: &impl Fn(u32) -> Bounds,
        reach: f64,
    ) {
        let body = &contact.body;
        if let Other::Plane(_) = contact.other {
            return body.nodes.iter().for_each(|&node| self.add(Form::Plane, [node, NO_NODE, NO_NODE, NO_NODE]));
        }
        let fitted = |trees: &mut Option<Trees>, body: &Body| match trees {
            Some(trees) => trees.refit(body, place, reach),
            None => *trees = Some(Trees::new(body, place, reach)),
        };
        fitted(own, body);
        let Some(own) = own else { return };
        match &contact.other {
            Other::Body(other) => {
                fitted(others, other);
                let Some(others) = others else { return };
                self.one_way((body, own), (other, others), place, reach);
                self.one_way((other, others), (body, own), place, reach);
                self.edges(&body.edges, (&other.edges, &others.edges), place, reach);
                self.points(&body.points, (&other.points, &others.points), place, reach);
            }
            _ => {
                self.one_way((body, own), (body, own), place, reach);
                self.own_edges(&body.edges, &own.edges);
                self.points(&body.points, (&body.points, &own.points), place, reach);
            }
        }
    }

    /// Nodes of one side with triangles and lines of the other.
    fn one_way(
        &mut self,
        (of, _): (&Body, &Trees),
        (other, trees): (&Body, &Trees),
        place: &impl Fn(u32) -> Bounds,
        reach: f64,
    ) {
        let mut looks = *self.looks;
        for &node in &of.nodes {
            let near = place(node).grown(reach);
            trees.triangles.within(&near, &mut looks, |i| {
                let [a, b, c] = other.triangles[i as usize];
                self.add(Form::Pair(PairKind::NodeTriangle), [node, a, b, c]);
            });
            trees.lines.within(&near, &mut looks, |i| {
                let [a, b] = other.lines[i as usize];
                self.add(Form::Pair(PairKind::NodeEdge), [node, a, b, NO_NODE]);
            });
        }
        *self.looks = looks;
    }

    fn edges(
        &mut self,
        edges: &[[u32; 2]],
        (others, tree): (&[[u32; 2]], &BoxTree),
        place: &impl Fn(u32) -> Bounds,
        reach: f64,
    ) {
        let mut looks = *self.looks;
        for edge in edges {
            tree.within(&around(edge, place).grown(0.5 * reach), &mut looks, |i| {
                self.add_edges(*edge, others[i as usize])
            });
        }
        *self.looks = looks;
    }

    /// Edges of a side with each other.
    fn own_edges(&mut self, edges: &[[u32; 2]], tree: &BoxTree) {
        let mut looks = *self.looks;
        tree.pairs(&mut looks, |i, j, _| self.add_edges(edges[i as usize], edges[j as usize]));
        *self.looks = looks;
    }

    fn add_edges(&mut self, one: [u32; 2], other: [u32; 2]) {
        let [[a, b], [c, d]] = if one <= other { [one, other] } else { [other, one] };
        self.add(Form::Pair(PairKind::EdgeEdge), [a, b, c, d]);
    }

    fn points(
        &mut self,
        points: &[u32],
        (others, tree): (&[u32], &BoxTree),
        place: &impl Fn(u32) -> Bounds,
        reach: f64,
    ) {
        let mut looks = *self.looks;
        for &node in points {
            tree.within(&place(node).grown(reach), &mut looks, |i| {
                let other = others[i as usize];
                self.add(Form::Pair(PairKind::NodeNode), [node.min(other), node.max(other), NO_NODE, NO_NODE]);
            });
        }
        *self.looks = looks;
    }

    /// Adds a pair that shares no node and has something that can move.
    fn add(&mut self, form: Form, nodes: [u32; 4]) {
        let (contacts, contact) = (self.contacts, self.number);
        let [first, second] = match form {
            Form::Plane => [&nodes[..1], &[]],
            Form::Pair(kind) => sides(kind, &nodes),
        };
        if first.iter().any(|node| second.contains(node)) {
            return;
        }
        let stiffness = contacts.stiffness_of(usize::from(contact), [first, second]);
        if stiffness == 0.0 {
            return;
        }
        let Some(beyond) = (self.keep)(contact, form, nodes) else { return };
        let length = |side: &[u32]| match side {
            &[a, b] => (contacts.at_rest(a) - contacts.at_rest(b)).norm(),
            _ => 0.0,
        };
        let lengths = [length(first), length(second)];
        self.found.push(Candidate { contact, form, nodes, stiffness, lengths, beyond });
    }
}
