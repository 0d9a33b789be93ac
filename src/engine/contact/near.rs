//! Pairs that are near: found by trees of boxes, and kept until something may have come near that is not among them.
//!
//! A pair is near if it is closer than its gap and the skin. As long as no node has moved by more than half the skin
//! since then, against the scene as a whole where there is no obstacle, no other pair can touch.

use super::bodies::{Body, Contact, Contacts, Other, Plane, sides};
use super::distance::{PairKind, nearest};
use crate::mesh::box_tree::{Bounds, BoxTree};
use nalgebra::Vector3;
use std::sync::Arc;

/// What a pair is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Form {
    /// a node and the surface of a half-space
    Plane,
    /// two elements
    Pair(PairKind),
}

/// A place among nodes that a pair does not have.
pub const NO_NODE: u32 = u32::MAX;

/// A pair that may touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// which contact it belongs to
    pub contact: u16,
    /// its elements
    pub form: Form,
    /// its nodes, those of the first element first; [`NO_NODE`] beyond them
    pub nodes: [u32; 4],
    /// [N/m] kappa
    pub stiffness: f64,
    /// [m] lengths of two edges at rest, by which parallel ones are known; else 0
    pub lengths: [f64; 2],
    /// [m] how much its distance is above its gap where it was found
    pub beyond: f64,
}

impl Candidate {
    /// By which candidates are in order.
    pub fn key(&self) -> (u16, Form, [u32; 4]) {
        (self.contact, self.form, self.nodes)
    }
}

/// Where nodes are, and corners of obstacles.
#[derive(Clone, Copy, Debug)]
pub struct Places<'a> {
    /// what may touch
    pub contacts: &'a Contacts,
    /// [m] nodes of the scene
    pub x: &'a [Vector3<f64>],
    /// [m, m/s] displacement and velocity of the obstacle of every contact
    pub shifts: &'a [[Vector3<f64>; 2]],
}

impl Places<'_> {
    /// [m] Where a node or a corner is.
    pub fn at(&self, node: u32) -> Vector3<f64> {
        let i = node as usize;
        self.x.get(i).copied().unwrap_or_else(|| {
            let corner = i - self.x.len();
            self.contacts.corners[corner] + self.shifts[usize::from(self.contacts.contact_of[corner])][0]
        })
    }

    /// [m/s] The velocity of a node, with those of the nodes of the scene, or of a corner.
    pub fn velocity(&self, v: &[Vector3<f64>], node: u32) -> Vector3<f64> {
        let i = node as usize;
        v.get(i).copied().unwrap_or_else(|| {
            let corner = i - self.x.len();
            self.shifts[usize::from(self.contacts.contact_of[corner])][1]
        })
    }

    /// The plane of a contact with one, moved.
    pub fn plane(&self, contact: u16) -> Option<Plane> {
        let Other::Plane(plane) = self.contacts.list[usize::from(contact)].other else { return None };
        Some(Plane { point: plane.point + self.shifts[usize::from(contact)][0], ..plane })
    }
}

/// Displacement [m] and velocity [m/s] of the obstacle of every contact at time `t` [s].
pub fn shifts(contacts: &Contacts, t: f64, out: &mut Vec<[Vector3<f64>; 2]>) {
    out.clear();
    out.extend(contacts.list.iter().map(|contact| {
        let moved = |motion: &crate::model::spec::Series<[f64; 3]>| [motion.at(t), motion.slope_after(t)];
        contact.motion.as_ref().map_or([Vector3::zeros(); 2], |motion| moved(motion).map(Vector3::from))
    }));
}

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
    /// Overwrites `found` with all pairs whose boxes, from the boxes of their nodes, are closer than their gaps and
    /// `skin` [m], and that `keep` keeps; in order, each once.
    pub fn find(
        &mut self,
        contacts: &Contacts,
        place: impl Fn(u32) -> Bounds,
        skin: f64,
        keep: impl Fn(&mut Candidate) -> bool,
        found: &mut Vec<Candidate>,
    ) {
        found.clear();
        self.trees.resize_with(contacts.list.len(), Default::default);
        for ((number, contact), trees) in (0_u16..).zip(&contacts.list).zip(&mut self.trees) {
            let mut pairs = Pairs { contacts, number, keep: &keep, found: &mut *found };
            pairs.of(contact, trees, &place, contact.gap + contact.thickness + skin);
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
        let mut looks = u64::MAX;
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
    }

    fn edges(
        &mut self,
        edges: &[[u32; 2]],
        (others, tree): (&[[u32; 2]], &BoxTree),
        place: &impl Fn(u32) -> Bounds,
        reach: f64,
    ) {
        for edge in edges {
            tree.within(&around(edge, place).grown(reach), &mut { u64::MAX }, |i| {
                let other = others[i as usize];
                let [[a, b], [c, d]] = if *edge <= other { [*edge, other] } else { [other, *edge] };
                self.add(Form::Pair(PairKind::EdgeEdge), [a, b, c, d]);
            });
        }
    }

    fn points(
        &mut self,
        points: &[u32],
        (others, tree): (&[u32], &BoxTree),
        place: &impl Fn(u32) -> Bounds,
        reach: f64,
    ) {
        for &node in points {
            tree.within(&place(node).grown(reach), &mut { u64::MAX }, |i| {
                let other = others[i as usize];
                self.add(Form::Pair(PairKind::NodeNode), [node.min(other), node.max(other), NO_NODE, NO_NODE]);
            });
        }
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

/// The pairs that are near, with the state that they were found in.
#[derive(Clone, Debug, Default)]
pub struct Near {
    search: Search,
    list: Arc<[Candidate]>,
    /// [m] nodes of the scene when they were found; empty before the first time
    reference: Vec<Vector3<f64>>,
    /// [m] displacements of obstacles then
    shifts: Vec<Vector3<f64>>,
    found: Vec<Candidate>,
    /// [m] how much distances of the pairs were above their gaps
    beyond: Vec<f64>,
    /// [m] how far every node has moved since at the places that were last asked for, and obstacles
    ways: Vec<f64>,
    pushed: f64,
    /// [m] how far beyond their gaps pairs were looked for
    skin: f64,
    more: f64,
}

impl Near {
    /// The pairs that are near, in order.
    pub fn list(&self) -> &Arc<[Candidate]> {
        &self.list
    }

    /// The pairs that may touch at the places of the last [`Near::refresh`], in order: no node has come so close that
    /// the others could.
    pub fn close(&self) -> impl Iterator<Item = &Candidate> {
        self.with_distances().filter(|(_, beyond)| *beyond <= 0.0).map(|(candidate, _)| candidate)
    }

    /// All pairs that are near, each with how much [m] its distance is above its gap at least, at the places of the
    /// last [`Near::refresh`] or [`Near::covers_now`].
    pub fn with_distances(&self) -> impl Iterator<Item = (&Candidate, f64)> {
        let way = |node: &u32| self.ways.get(*node as usize).copied().unwrap_or(self.pushed);
        let most = move |candidate: &Candidate| candidate.nodes.iter().map(way).fold(self.pushed, f64::max);
        self.list.iter().zip(&self.beyond).map(move |(pair, beyond)| (pair, beyond - 2.0 * most(pair)))
    }

    /// [m] Nodes of the scene when pairs were last looked for, and how far beyond the skin; no node before the first
    /// time.
    pub fn reference(&self) -> (&[Vector3<f64>], f64) {
        (&self.reference, self.more)
    }

    /// Looks for pairs if some may be missing. Returns whether it did.
    pub fn refresh(&mut self, places: Places<'_>) -> bool {
        let missing = self.reference.len() != places.x.len() || self.follow(places, 0.0) > 0.5 * self.skin;
        if missing {
            self.look(places, 0.0);
        }
        missing
    }

    /// The same for all places on the ways `half * v` [m] to both sides of these places.
    pub fn refresh_along(&mut self, places: Places<'_>, v: &[Vector3<f64>], half: f64) -> bool {
        let way = longest_way(places, v, half);
        let missing = self.reference.len() != places.x.len() || self.follow(places, way) > 0.5 * self.skin;
        if missing {
            self.look(places, 2.0 * way);
            self.ways.fill(way);
        }
        missing
    }

    /// [`Near::covers`] with half of the skin, for places on the ways `half * v` to both sides of these, which
    /// [`Near::with_distances`] then belongs to.
    pub fn covers_now(&mut self, places: Places<'_>, (v, half): (&[Vector3<f64>], f64)) -> bool {
        let way = longest_way(places, v, half);
        self.reference.len() == places.x.len() && self.follow(places, way) <= 0.5 * self.skin
    }

    /// Whether no pair can touch at these places that is not among those that are near: nothing has moved by more than
    /// a share of the skin.
    pub fn covers(&self, places: Places<'_>, share: f64) -> bool {
        self.reference.len() == places.x.len() && self.moved(places) <= share * self.skin
    }

    /// Finds how far every node has moved, and `more` [m]. Returns the largest way.
    fn follow(&mut self, places: Places<'_>, more: f64) -> f64 {
        let together = self.together(places);
        let mut most = 0.0;
        self.ways.resize(places.x.len(), 0.0);
        for (to, (x, then)) in self.ways.iter_mut().zip(places.x.iter().zip(&self.reference)) {
            *to = (x - then - together).norm() + more;
            most = if *to <= most { most } else { *to };
        }
        self.pushed = self.way_of_obstacles(places);
        if most.is_nan() { f64::INFINITY } else { most + self.pushed }
    }

    fn together(&self, places: Places<'_>) -> Vector3<f64> {
        let ways = places.x.iter().zip(&self.reference).map(|(x, then)| x - then);
        match places.contacts.is_free() {
            true => ways.sum::<Vector3<f64>>() / places.x.len() as f64,
            false => Vector3::zeros(),
        }
    }

    fn way_of_obstacles(&self, places: Places<'_>) -> f64 {
        let ways = places.shifts.iter().zip(&self.shifts).map(|([now, _], then)| (now - then).norm());
        ways.fold(0.0, f64::max)
    }

    /// [m] How far a node may have moved against another one or an obstacle, over 2.
    fn moved(&self, places: Places<'_>) -> f64 {
        let together = self.together(places);
        let ways = places.x.iter().zip(&self.reference).map(|(x, then)| x - then - together);
        let most = ways.fold(0.0, |most: f64, way| {
            let way = way.norm_squared();
            if way <= most { most } else { way }
        });
        if most.is_nan() { f64::INFINITY } else { most.sqrt() + self.way_of_obstacles(places) }
    }

    /// Looks for pairs, at distances of `more` [m] beyond the skin too.
    pub fn look(&mut self, places: Places<'_>, more: f64) {
        let contacts = places.contacts;
        (self.skin, self.more) = (contacts.skin + more, more);
        let skin = self.skin;
        let place = |node| {
            let x = places.at(node).into();
            Bounds { low: x, high: x }
        };
        let keep = |candidate: &mut Candidate| {
            let contact = &contacts.list[usize::from(candidate.contact)];
            let distance = match (candidate.form, places.plane(candidate.contact)) {
                (Form::Plane, Some(plane)) => plane.normal.dot(&(places.at(candidate.nodes[0]) - plane.point)),
                (Form::Pair(kind), _) => nearest(kind, &points(candidate.nodes, |node| places.at(node))).distance,
                _ => f64::INFINITY,
            };
            candidate.beyond = distance - contact.gap - contact.thickness;
            candidate.beyond < skin
        };
        self.search.find(contacts, place, skin, keep, &mut self.found);
        let same = self.found.len() == self.list.len()
            && self.found.iter().zip(self.list.iter()).all(|(new, old)| new.key() == old.key());
        if !same {
            self.list = Arc::from(self.found.as_slice());
        }
        self.beyond.clear();
        self.beyond.extend(self.found.iter().map(|candidate| candidate.beyond));
        self.ways.clear();
        self.ways.resize(places.x.len(), 0.0);
        self.pushed = 0.0;
        self.reference.clear();
        self.reference.extend_from_slice(places.x);
        self.shifts.clear();
        self.shifts.extend(places.shifts.iter().map(|[shift, _]| *shift));
    }
}

/// [m] A bound on the way `half * v` of nodes against each other and obstacles, over 2.
fn longest_way(places: Places<'_>, v: &[Vector3<f64>], half: f64) -> f64 {
    if half == 0.0 {
        return 0.0;
    }
    let of_nodes = v.iter().map(|v| half * v.norm()).fold(0.0, f64::max);
    of_nodes + places.shifts.iter().map(|[_, v]| half * v.norm()).fold(0.0, f64::max)
}

/// One value for every node of a pair, 0 beyond them.
pub(super) fn points(nodes: [u32; 4], of: impl Fn(u32) -> Vector3<f64>) -> [Vector3<f64>; 4] {
    nodes.map(|node| if node == NO_NODE { Vector3::zeros() } else { of(node) })
}
