//! Pairs that are near: found by trees of boxes, and kept until something may have come near that is not among them.
//!
//! A pair is near if it is closer than its gap and the skin. As long as no two patches have come nearer to each other
//! by more than they may ([`super::patches`]), no other pair can touch.

use super::bodies::{Contact, Contacts, Other, Plane};
use super::distance::{PairKind, is_beyond, nearest};
use super::patches::{Moved, Patches};
use super::search::Search;
use crate::mesh::box_tree::Bounds;
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
    /// [s] when
    pub t: f64,
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

/// The pairs that are near, with the state that they were found in.
#[derive(Clone, Debug, Default)]
pub struct Near {
    search: Search,
    patches: Patches,
    list: Arc<[Candidate]>,
    /// [m] nodes of the scene when they were found; empty before the first time
    reference: Vec<Vector3<f64>>,
    /// [s] when that was
    time: f64,
    /// [m] displacements of obstacles then
    shifts: Vec<Vector3<f64>>,
    found: Vec<Candidate>,
    /// [m] how much distances of the pairs were above their gaps
    beyond: Vec<f64>,
    /// displacements since, at the places that were last asked for: one state, or two ends
    moved: [Moved; 2],
    ends: usize,
    /// [m] how far beyond their gaps and the skin pairs were looked for
    more: f64,
}

impl Near {
    /// The pairs that are near, in order.
    pub fn list(&self) -> &Arc<[Candidate]> {
        &self.list
    }

    /// The pairs that may touch at the places of the last [`Near::refresh`], in order: their nodes have come so close
    /// that they could.
    pub fn close(&self) -> impl Iterator<Item = &Candidate> {
        self.with_distances().filter(|(_, beyond)| *beyond <= 0.0).map(|(candidate, _)| candidate)
    }

    /// All pairs that are near, each with how much [m] its distance is above its gap at least, at the places of the
    /// last [`Near::refresh`] or [`Near::covers`].
    pub fn with_distances(&self) -> impl Iterator<Item = (&Candidate, f64)> {
        let ends = &self.moved[..self.ends];
        let nearer = move |pair: &Candidate| ends.iter().map(|moved| moved.nearer(pair)).fold(0.0, f64::max);
        self.list.iter().zip(&self.beyond).map(move |(pair, beyond)| (pair, beyond - nearer(pair)))
    }

    /// [s] When pairs were last looked for, [m] nodes of the scene then, and how far beyond the skin; no node before
    /// the first time.
    pub fn reference(&self) -> (f64, &[Vector3<f64>], f64) {
        (self.time, &self.reference, self.more)
    }

    /// Looks for pairs if some may be missing.
    pub fn refresh(&mut self, places: Places<'_>) {
        if !self.covers(&[places], 1.0) {
            self.look(places, 0.0);
        }
    }

    /// The same for all places on the ways `half * v` [m] to both sides of these places, between the two `ends`.
    pub fn refresh_along(&mut self, places: Places<'_>, ends: [Places<'_>; 2]) {
        if !self.covers(&ends, 1.0) {
            let most = |ways: &mut dyn Iterator<Item = Vector3<f64>>| ways.map(|way| way.norm()).fold(0.0, f64::max);
            let [_, end] = ends;
            let nodes = most(&mut end.x.iter().zip(places.x).map(|(end, x)| end - x));
            let obstacles = most(&mut end.shifts.iter().zip(places.shifts).map(|([end, _], [shift, _])| end - shift));
            self.look(places, 2.0 * f64::max(nodes, obstacles));
            self.follow(&ends);
        }
    }

    /// Whether no pair can touch at these places, which are those of one state or of two ends of ways, that is not
    /// among those that are near: nothing has come nearer by more than a share of what it may.
    pub fn covers(&mut self, ends: &[Places<'_>], share: f64) -> bool {
        self.follow(ends) && self.patches.cover(&self.reference, &self.moved[..self.ends], share)
    }

    /// The same where every node goes any share of its way between two ends.
    pub fn covers_shares(&mut self, ends: [Places<'_>; 2]) -> bool {
        self.follow(&ends) && self.patches.cover_shares(&self.reference, &self.moved)
    }

    /// Whether such ways from places `x` [m] are short enough to be covered by a look there, by that of the last one.
    pub fn could_cover(&mut self, x: &[Vector3<f64>], ways: &Moved) -> bool {
        self.patches.cover(x, std::slice::from_ref(ways), 1.0)
    }

    /// Finds displacements of nodes and obstacles since pairs were looked for. Returns whether they ever were.
    fn follow(&mut self, ends: &[Places<'_>]) -> bool {
        self.ends = ends.len();
        for (moved, end) in self.moved.iter_mut().zip(ends) {
            if self.reference.len() != end.x.len() {
                return false;
            }
            moved.fit((end.x, &self.reference), end.shifts.iter().zip(&self.shifts).map(|([now, _], then)| now - then));
        }
        true
    }

    /// Looks for pairs, at distances of `more` [m] beyond the skin too.
    pub fn look(&mut self, places: Places<'_>, more: f64) {
        let contacts = places.contacts;
        (self.time, self.more) = (places.t, more);
        let skin = contacts.skin + more;
        let place = |node| {
            let x = places.at(node).into();
            Bounds { low: x, high: x }
        };
        let keep = |number: u16, form: Form, nodes: [u32; 4]| {
            let contact = &contacts.list[usize::from(number)];
            let touching = contact.gap + contact.thickness;
            let distance = match form {
                Form::Plane => {
                    let plane = places.plane(number)?;
                    plane.normal.dot(&(places.at(nodes[0]) - plane.point))
                }
                Form::Pair(kind) => {
                    let x = points(nodes, |node| places.at(node));
                    if is_beyond(kind, &x, touching + skin) {
                        return None;
                    }
                    nearest(kind, &x).distance
                }
            };
            Some(distance - touching).filter(|beyond| *beyond < skin)
        };
        let reach = |contact: &Contact| contact.gap + contact.thickness + skin;
        self.search.find(contacts, (place, reach), keep, &mut { u64::MAX }, &mut self.found);
        self.patches.look(places, skin);
        let same = self.found.len() == self.list.len()
            && self.found.iter().zip(self.list.iter()).all(|(new, old)| new.key() == old.key());
        if !same {
            self.list = Arc::from(self.found.as_slice());
        }
        self.beyond.clear();
        self.beyond.extend(self.found.iter().map(|candidate| candidate.beyond));
        self.reference.clear();
        self.reference.extend_from_slice(places.x);
        self.shifts.clear();
        self.shifts.extend(places.shifts.iter().map(|[shift, _]| *shift));
        self.follow(&[places]);
    }
}

/// One value for every node of a pair, 0 beyond them.
pub(super) fn points(nodes: [u32; 4], of: impl Fn(u32) -> Vector3<f64>) -> [Vector3<f64>; 4] {
    nodes.map(|node| if node == NO_NODE { Vector3::zeros() } else { of(node) })
}
