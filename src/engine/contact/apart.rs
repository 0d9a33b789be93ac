//! How far nodes may move before something touches: node by node, so that one contact does not stop a whole canopy.
//!
//! Every pair keeps a share of its distance beyond the thickness. A pair that would not shortens the ways of its nodes,
//! which may bring another one too close, so pairs are looked at again until all keep their share. If they do not after
//! some rounds, all nodes go the share of their ways that is free for all.

use super::bodies::{Contacts, Other};
use super::impact::{Approach, free_share};
use super::near::{Candidate, Form, NO_NODE, Near, Places, points};
use super::patches::Moved;
use super::search::Search;
use crate::mesh::box_tree::Bounds;
use nalgebra::Vector3;

/// [-] Share of its distance beyond the thickness that a pair keeps.
const KEPT: f64 = 0.1;
/// [-] The same of a pair that counts as touching.
const CLOSED: f64 = 1e-3;
/// Rounds over all pairs.
const ROUNDS: usize = 12;

/// Buffers, and trees that are fitted to the ways of nodes.
#[derive(Clone, Debug, Default)]
pub struct Apart {
    search: Search,
    found: Vec<Candidate>,
    /// [-] of the way of every node
    share: Vec<f64>,
    /// the last round in which it was shortened, counted from 1; 0 if it was not
    shortened: Vec<usize>,
    /// [m] where nodes end
    ends: Vec<Vector3<f64>>,
    /// ways of nodes and obstacles
    ways: Moved,
    /// [m] where nodes that an obstacle or a support pushes go at least
    carried: Vec<Vector3<f64>>,
}

impl Apart {
    /// Overwrites the pairs that may meet on the ways `way` [m] of nodes, or on any shares of them: those that are near
    /// where these cover both ends; `later` is where obstacles are at the end. None if a way is not finite.
    fn find(
        &mut self,
        places: Places<'_>,
        later: &[[Vector3<f64>; 2]],
        way: &[Vector3<f64>],
        (near, shares): (&mut Near, bool),
    ) {
        let Apart { found, ends, ways, search, .. } = self;
        found.clear();
        if !way.iter().flatten().all(|d| d.is_finite()) {
            return;
        }
        ends.clear();
        ends.extend(places.x.iter().zip(way).map(|(x, way)| x + way));
        let end = Places { x: ends, shifts: later, ..places };
        ways.fit((ends, places.x), later.iter().zip(places.shifts).map(|([end, _], [begin, _])| end - begin));
        let covers = |near: &mut Near| match shares {
            true => near.covers_shares([places, end]),
            false => near.covers(&[end], 1.0),
        };
        let covered = covers(near)
            || near.could_cover(ways) && {
                near.look(places, 0.0);
                covers(near)
            };
        if covered && near.covers(&[places], 1.0) {
            // Ways that are short beside the distance need no closer look.
            let meets = |(pair, beyond): &(&Candidate, f64)| {
                let nearer = if shares { ways.nearer_by_shares(pair) } else { ways.nearer(pair) };
                2.0 * nearer > beyond + places.contacts.list[usize::from(pair.contact)].gap
            };
            return found.extend(near.with_distances().filter(meets).map(|(pair, _)| *pair));
        }
        let place = |node: u32| {
            let contact = |corner: usize| usize::from(places.contacts.contact_of[corner]);
            let way = way.get(node as usize).copied();
            let way = way.unwrap_or_else(|| ways.obstacles[contact(node as usize - ways.nodes.len())]);
            Bounds::of([&places.at(node).into(), &(places.at(node) + way).into()])
        };
        search.find(places.contacts, place, 0.0, |_| true, found);
    }

    /// The first pair that touches on the ways of nodes between two places.
    pub fn first_touch(
        &mut self,
        places: Places<'_>,
        later: &[[Vector3<f64>; 2]],
        way: &[Vector3<f64>],
        near: &mut Near,
    ) -> Option<Candidate> {
        self.find(places, later, way, (near, false));
        self.reset(way.len());
        let Apart { share, shortened, carried, .. } = self;
        let pairs = Round { places, later, way, share, shortened, carried };
        let touches = |pair: &&Candidate| pairs.free_share(pair, CLOSED).is_some();
        self.found.iter().find(touches).copied()
    }

    fn reset(&mut self, nodes: usize) {
        self.share.clear();
        self.share.resize(nodes, 1.0);
        self.shortened.clear();
        self.shortened.resize(nodes, 0);
        self.carried.clear();
        self.carried.resize(nodes, Vector3::zeros());
    }

    /// Shortens the ways `way` [m] of nodes from where they are; `later` is where obstacles are at the end. Returns the
    /// share [-] of the ways that is free for all.
    pub fn shorten(
        &mut self,
        places: Places<'_>,
        later: &[[Vector3<f64>; 2]],
        way: &mut [Vector3<f64>],
        near: &mut Near,
    ) -> f64 {
        self.find(places, later, way, (near, false));
        self.reset(way.len());
        let mut least: f64 = 1.0;
        for round in 1..=ROUNDS {
            let Apart { share, shortened, carried, .. } = self;
            let mut pairs = Round { places, later, way, share, shortened, carried };
            let (shortened, free) = pairs.look(&self.found, round);
            if !shortened {
                break;
            }
            if round == 1 {
                least = free;
                // What stops lets others come nearer.
                self.find(places, later, way, (near, true));
            }
            if round == ROUNDS {
                self.share.fill(least);
                self.carried.fill(Vector3::zeros());
            }
        }
        if least < 1.0 {
            for ((way, share), carried) in way.iter_mut().zip(&self.share).zip(&self.carried) {
                *way = carried + (*way - carried) * *share;
            }
        }
        least
    }
}

/// A round over all pairs.
struct Round<'a> {
    places: Places<'a>,
    later: &'a [[Vector3<f64>; 2]],
    way: &'a [Vector3<f64>],
    share: &'a mut [f64],
    shortened: &'a mut [usize],
    carried: &'a mut [Vector3<f64>],
}

impl Round<'_> {
    /// Shortens the ways of nodes of pairs that come too close. Returns whether there are any, and the least share that
    /// is free. After the first round only pairs are looked at of which a node was shortened since the last look.
    fn look(&mut self, pairs: &[Candidate], round: usize) -> (bool, f64) {
        let (mut shortened, mut least) = (false, 1.0);
        for pair in pairs {
            let since = |node: &u32| self.shortened.get(*node as usize).is_some_and(|last| last + 1 >= round);
            if !pair.nodes.iter().any(since) {
                continue;
            }
            let Some(free) = self.free_share(pair, KEPT) else { continue };
            least = f64::min(least, free);
            let driven = self.driven(pair);
            for &node in pair.nodes.iter().filter(|node| self.places.contacts.is_node(**node)) {
                let i = node as usize;
                if self.places.contacts.inverse_mass[i] == 0.0 {
                    continue;
                }
                shortened = true;
                self.shortened[i] = round;
                self.share[i] *= free;
                if let Some(driven) = driven {
                    self.carried[i] = driven;
                }
            }
        }
        (shortened, least)
    }

    /// [m] The way of a node or a corner so far.
    fn way_of(&self, node: u32) -> Vector3<f64> {
        let i = node as usize;
        match self.way.get(i) {
            Some(way) => self.carried[i] + (way - self.carried[i]) * self.share[i],
            None => self.way_of_obstacle(self.places.contacts.contact_of[i - self.way.len()]),
        }
    }

    fn way_of_obstacle(&self, contact: u16) -> Vector3<f64> {
        let contact = usize::from(contact);
        self.later[contact][0] - self.places.shifts[contact][0]
    }

    /// [m] The way of what pushes in a pair: a moving obstacle, or a support that moves.
    fn driven(&self, pair: &Candidate) -> Option<Vector3<f64>> {
        let contacts: &Contacts = self.places.contacts;
        if let Other::Plane(_) = contacts.list[usize::from(pair.contact)].other {
            return Some(self.way_of_obstacle(pair.contact)).filter(|way| *way != Vector3::zeros());
        }
        let held = |node: &u32| contacts.inverse_mass.get(*node as usize).is_none_or(|inverse| *inverse == 0.0);
        let ways = pair.nodes.iter().filter(|node| **node != NO_NODE && held(node)).map(|node| self.way_of(*node));
        ways.into_iter().find(|way| *way != Vector3::zeros())
    }

    /// The share of their ways up to which a pair keeps the share `kept` of its distance; `None` if all is free.
    fn free_share(&self, pair: &Candidate, kept: f64) -> Option<f64> {
        let contact = &self.places.contacts.list[usize::from(pair.contact)];
        match (pair.form, self.places.plane(pair.contact)) {
            (Form::Plane, Some(plane)) => {
                let x = self.places.at(pair.nodes[0]) - plane.point;
                let way = self.way_of(pair.nodes[0]) - self.way_of_obstacle(pair.contact);
                let (gap, change) = (plane.normal.dot(&x), plane.normal.dot(&way));
                (gap + change < kept * gap).then(|| (1.0 - kept) * gap / -change)
            }
            (Form::Pair(kind), _) => {
                let [x, d] = [points(pair.nodes, |i| self.places.at(i)), points(pair.nodes, |i| self.way_of(i))];
                free_share(&Approach { kind, x, d, thickness: contact.thickness }, kept)
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bodies::{Body, Contact};
    use super::*;

    /// Two triangles above each other and a point far away: the nodes that would pass through the other triangle stay
    /// on their side, and the point goes its whole way.
    #[test]
    fn only_what_touches_is_shortened() {
        let corner = |x: f64, y: f64, z: f64| Vector3::new(x, y, z);
        let rest = vec![
            corner(0.0, 0.0, 0.0),
            corner(1.0, 0.0, 0.0),
            corner(0.0, 1.0, 0.0),
            corner(0.2, 0.2, 0.1),
            corner(1.2, 0.2, 0.3),
            corner(0.2, 1.2, 0.3),
            corner(5.0, 5.0, 5.0),
        ];
        let body = Body::new(vec![[0, 1, 2], [3, 4, 5]], Vec::new(), vec![6]);
        let contact = Contact { body, other: Other::Itself, thickness: 0.0, gap: 0.01, friction: 0.0, motion: None };
        let contacts = Contacts {
            list: vec![contact],
            stiffness: vec![vec![1.0; 7]],
            inverse_mass: vec![1.0; 7],
            rest: rest.clone(),
            skin: 0.02,
            ..Contacts::default()
        };
        let shifts = [[Vector3::zeros(); 2]];
        let places = Places { contacts: &contacts, t: 0.0, x: &rest, shifts: &shifts };
        let mut way = vec![Vector3::zeros(); 7];
        way[3] = corner(0.0, 0.0, -1.0);
        way[6] = corner(-4.0, 0.0, 0.0);
        let least = Apart::default().shorten(places, &shifts, &mut way, &mut Near::default());
        assert!(least < 0.1 && least > 0.08, "{least}");
        let height = rest[3].z + way[3].z;
        assert!((0.0099..0.03).contains(&height), "{height}");
        assert_eq!(way[6], corner(-4.0, 0.0, 0.0));
    }
}
