//! Finds the pairs whose boxes are near, with a tree of boxes around the elements of every body.

use super::bodies::{Body, Contact, Contacts, Other, sides};
use super::distance::PairKind;
use super::near::{Candidate, Form, NO_NODE};
use crate::mesh::box_tree::{Bounds, BoxTree};

/// Trees around the elements of a body.
#[derive(Clone, Debug)]
struct Trees {
    triangles: BoxTree,
    edges: BoxTree,
    lines: BoxTree,
    points: BoxTree,
}

impl Trees {
    fn new(body: &Body, place: &impl Fn(u32) -> Bounds) -> Self {
        fn tree<const N: usize>(elements: &[[u32; N]], place: &impl Fn(u32) -> Bounds) -> BoxTree {
            BoxTree::new(&elements.iter().map(|nodes| around(nodes, place)).collect::<Vec<_>>())
        }
        let points: Vec<[u32; 1]> = body.points.iter().map(|node| [*node]).collect();
        Trees {
            triangles: tree(&body.triangles, place),
            edges: tree(&body.edges, place),
            lines: tree(&body.lines, place),
            points: tree(&points, place),
        }
    }

    fn refit(&mut self, body: &Body, place: &impl Fn(u32) -> Bounds) {
        self.triangles.refit(|i| around(&body.triangles[i as usize], place));
        self.edges.refit(|i| around(&body.edges[i as usize], place));
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
    /// their contact, and that `keep` keeps; in order, each once. Ends early when `looks`, the number of boxes that
    /// may be looked at, is used up.
    pub fn find(
        &mut self,
        contacts: &Contacts,
        (place, reach): (impl Fn(u32) -> Bounds, impl Fn(&Contact) -> f64),
        keep: impl Fn(&mut Candidate) -> bool,
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

impl<K: Fn(&mut Candidate) -> bool> Pairs<'_, K> {
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
            Some(trees) => trees.refit(body, place),
            None => *trees = Some(Trees::new(body, place)),
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
                self.edges(&body.edges, (&body.edges, &own.edges), place, reach);
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
        let alone = std::ptr::eq(edges, others);
        let mut looks = *self.looks;
        for edge in edges {
            tree.within(&around(edge, place).grown(reach), &mut looks, |i| {
                let other = others[i as usize];
                let [[a, b], [c, d]] = match *edge <= other {
                    true => [*edge, other],
                    // The other edge finds this one.
                    false if alone => return,
                    false => [other, *edge],
                };
                self.add(Form::Pair(PairKind::EdgeEdge), [a, b, c, d]);
            });
        }
        *self.looks = looks;
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
        let (stiffness, lengths) = match form {
            Form::Plane => (contacts.stiffness_of(usize::from(contact), [&nodes[..1], &[]]), [0.0; 2]),
            Form::Pair(kind) => {
                let [first, second] = sides(kind, &nodes);
                if first.iter().any(|node| second.contains(node)) {
                    return;
                }
                let length = |side: &[u32]| match side {
                    &[a, b] => (contacts.at_rest(a) - contacts.at_rest(b)).norm(),
                    _ => 0.0,
                };
                let lengths = [length(first), length(second)];
                (contacts.stiffness_of(usize::from(contact), [first, second]), lengths)
            }
        };
        let mut candidate = Candidate { contact, form, nodes, stiffness, lengths, beyond: 0.0 };
        if stiffness > 0.0 && (self.keep)(&mut candidate) {
            self.found.push(candidate);
        }
    }
}
