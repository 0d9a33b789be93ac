//! How far nodes may move before something touches: node by node, so that one contact does not stop a whole canopy.
//!
//! Every pair keeps a share of its distance beyond the thickness. A pair that would not shortens the ways of its nodes,
//! which may bring another one too close, so pairs with such nodes are looked at again, until all keep their share.
//! From the second round on a pair halves ways at least: a sheet that presses on another would need many rounds
//! otherwise, in each of which some pairs come too close by a little. If some still do after all rounds, all nodes go
//! the share of their ways that is free for all; where an obstacle moves in the step, that is no more than a guess.
//!
//! A round takes the shares that the one before left, so that they do not depend on the order of the pairs.

use super::bodies::{Contact, Contacts, Other};
use super::impact::{Approach, free_share};
use super::near::{Candidate, Form, NO_NODE, Near, Places, points};
use super::patches::Moved;
use super::search::Search;
use crate::mesh::box_tree::Bounds;
use nalgebra::Vector3;

/// [-] Share of its distance beyond the thickness that a pair keeps.
const KEPT: f64 = 0.1;
/// [-] The same after the first round, so that what it shortened is not shortened again by rounding.
const KEPT_AT_LEAST: f64 = 0.05;
/// [-] The same of a pair that counts as touching.
const CLOSED: f64 = 1e-3;
/// Rounds over all pairs.
const ROUNDS: usize = 12;
/// How many boxes a search for pairs on the ways may look at, by element that may touch.
const LOOKS: u64 = 100;
/// How often ways are halved that lead past more.
const HALVES: usize = 10;

/// Buffers, and trees that are fitted to the ways of nodes.
#[derive(Clone, Debug, Default)]
pub struct Apart {
    search: Search,
    found: Vec<Candidate>,
    /// [-] of the way of every node
    share: Vec<f64>,
    /// [-] the same after the round
    next: Vec<f64>,
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
    /// where these cover both ends; `later` is where obstacles are at the end. None if a way is not finite. Ends early
    /// when `looks`, the number of boxes that may be looked at, is used up. Returns whether they are those of any
    /// shares.
    fn find(
        &mut self,
        Ways { places, later, way }: Ways<'_>,
        (near, shares): (&mut Near, bool),
        looks: &mut u64,
    ) -> bool {
        let Apart { found, ends, ways, search, .. } = self;
        found.clear();
        if !way.iter().flatten().all(|d| d.is_finite()) {
            return true;
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
            || near.could_cover(places.x, ways) && {
                near.look(places, 0.0);
                covers(near)
            };
        if covered && near.covers(&[places], 1.0) {
            // Ways that are short beside the distance need no closer look.
            let meets = |(pair, beyond): &(&Candidate, f64)| {
                let nearer = if shares { ways.nearer_by_shares(pair) } else { ways.nearer(pair) };
                2.0 * nearer > beyond + places.contacts.list[usize::from(pair.contact)].gap
            };
            found.extend(near.with_distances().filter(meets).map(|(pair, _)| *pair));
            return shares;
        }
        let place = |node: u32| {
            let contact = |corner: usize| usize::from(places.contacts.contact_of[corner]);
            let way = way.get(node as usize).copied();
            let way = way.unwrap_or_else(|| ways.obstacles[contact(node as usize - ways.nodes.len())]);
            Bounds::of([&places.at(node).into(), &(places.at(node) + way).into()])
        };
        let reach = |contact: &Contact| contact.thickness + contact.gap;
        search.find(places.contacts, (place, reach), |_, _, _| Some(0.0), looks, found);
        true
    }

    /// The first pair that touches on the ways of nodes between two places.
    pub fn first_touch(
        &mut self,
        places: Places<'_>,
        later: &[[Vector3<f64>; 2]],
        way: &[Vector3<f64>],
        near: &mut Near,
    ) -> Option<Candidate> {
        let ways = Ways { places, later, way };
        self.find(ways, (near, false), &mut { u64::MAX });
        self.reset(way.len());
        let Apart { share, next, shortened, carried, .. } = self;
        let pairs = Round { ways, share, next, shortened, carried };
        let touches = |pair: &&Candidate| pairs.free_share(pair, CLOSED).is_some();
        self.found.iter().find(touches).copied()
    }

    fn reset(&mut self, nodes: usize) {
        for share in [&mut self.share, &mut self.next] {
            share.clear();
            share.resize(nodes, 1.0);
        }
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
        let (whole, any_shares) = self.halve(places, later, way, near);
        self.reset(way.len());
        let mut least = 1.0;
        for round in 1..=ROUNDS {
            let Apart { share, next, shortened, carried, .. } = self;
            next.copy_from_slice(share);
            let ways = Ways { places, later, way };
            let mut pairs = Round { ways, share, next, shortened, carried };
            let Some(free) = pairs.look(&self.found, round) else { break };
            std::mem::swap(&mut self.share, &mut self.next);
            if round == 1 {
                least = free;
            }
            if round == 1 && !any_shares {
                // What stops lets others come nearer.
                self.find(ways, (near, true), &mut { u64::MAX });
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
        whole * least
    }

    /// Finds the pairs that may meet. Ways that lead past very many, as those of a bad first guess, are halved until
    /// they do not. Returns the share that is left of them, and whether the pairs are those of any shares.
    fn halve(
        &mut self,
        places: Places<'_>,
        later: &[[Vector3<f64>; 2]],
        way: &mut [Vector3<f64>],
        near: &mut Near,
    ) -> (f64, bool) {
        let contacts: &Contacts = places.contacts;
        let elements: usize = (0..contacts.list.len()).flat_map(|i| contacts.elements(i)).flatten().sum();
        let mut whole = 1.0;
        for _ in 0..HALVES {
            let mut looks = LOOKS * elements as u64;
            let any_shares = self.find(Ways { places, later, way }, (&mut *near, false), &mut looks);
            if looks > 0 {
                return (whole, any_shares);
            }
            whole *= 0.5;
            let moves = way.iter_mut().zip(&contacts.inverse_mass).filter(|(_, inverse)| **inverse != 0.0);
            moves.for_each(|(way, _)| *way *= 0.5);
        }
        // What moves far is an obstacle or a support, which is not halved.
        (whole, self.find(Ways { places, later, way }, (near, false), &mut { u64::MAX }))
    }
}

/// Ways of nodes and obstacles.
#[derive(Clone, Copy)]
struct Ways<'a> {
    /// where they begin
    places: Places<'a>,
    /// where obstacles are at the end
    later: &'a [[Vector3<f64>; 2]],
    /// [m] of nodes
    way: &'a [Vector3<f64>],
}

/// A round over all pairs.
struct Round<'a> {
    ways: Ways<'a>,
    share: &'a [f64],
    next: &'a mut [f64],
    shortened: &'a mut [usize],
    carried: &'a mut [Vector3<f64>],
}

impl Round<'_> {
    /// Shortens the ways of nodes of pairs that come too close. Returns the least share that is free; `None` where none
    /// is shortened. After the first round only pairs are looked at of which a node was shortened since the last look.
    fn look(&mut self, pairs: &[Candidate], round: usize) -> Option<f64> {
        let mut least = None;
        for pair in pairs {
            let since = |node: &u32| self.shortened.get(*node as usize).is_some_and(|last| last + 1 >= round);
            if !pair.nodes.iter().any(since) {
                continue;
            }
            // What a plane has shortened stays free of it, up to rounding. Where rounding says no, round after round,
            // all nodes go alike at last: a stiff film between plates needs that, as it must not be stretched.
            let (kept, most) = if round == 1 || pair.form == Form::Plane { (KEPT, 1.0) } else { (KEPT_AT_LEAST, 0.5) };
            let Some(free) = self.free_share(pair, kept) else { continue };
            let free = f64::min(free, most);
            let driven = self.driven(pair);
            for &node in pair.nodes.iter().filter(|node| self.ways.places.contacts.is_node(**node)) {
                let i = node as usize;
                if self.ways.places.contacts.inverse_mass[i] == 0.0 {
                    continue;
                }
                least = Some(f64::min(least.unwrap_or(1.0), free));
                self.shortened[i] = round;
                self.next[i] = f64::min(self.next[i], self.share[i] * free);
                if let Some(driven) = driven {
                    self.carried[i] = driven;
                }
            }
        }
        least
    }

    /// [m] The way of a node or a corner so far.
    fn way_of(&self, node: u32) -> Vector3<f64> {
        let i = node as usize;
        match self.ways.way.get(i) {
            Some(way) => self.carried[i] + (way - self.carried[i]) * self.share[i],
            None => self.way_of_obstacle(self.ways.places.contacts.contact_of[i - self.ways.way.len()]),
        }
    }

    fn way_of_obstacle(&self, contact: u16) -> Vector3<f64> {
        let contact = usize::from(contact);
        self.ways.later[contact][0] - self.ways.places.shifts[contact][0]
    }

    /// [m] The way of what pushes in a pair: a moving obstacle, or a support that moves.
    fn driven(&self, pair: &Candidate) -> Option<Vector3<f64>> {
        let contacts: &Contacts = self.ways.places.contacts;
        if let Other::Plane(_) = contacts.list[usize::from(pair.contact)].other {
            return Some(self.way_of_obstacle(pair.contact)).filter(|way| *way != Vector3::zeros());
        }
        let held = |node: &u32| contacts.inverse_mass.get(*node as usize).is_none_or(|inverse| *inverse == 0.0);
        let ways = pair.nodes.iter().filter(|node| **node != NO_NODE && held(node)).map(|node| self.way_of(*node));
        ways.into_iter().find(|way| *way != Vector3::zeros())
    }

    /// The share of their ways up to which a pair keeps the share `kept` of its distance; `None` if all is free.
    fn free_share(&self, pair: &Candidate, kept: f64) -> Option<f64> {
        let contact = &self.ways.places.contacts.list[usize::from(pair.contact)];
        match (pair.form, self.ways.places.plane(pair.contact)) {
            (Form::Plane, Some(plane)) => {
                let x = self.ways.places.at(pair.nodes[0]) - plane.point;
                let way = self.way_of(pair.nodes[0]) - self.way_of_obstacle(pair.contact);
                let (gap, change) = (plane.normal.dot(&x), plane.normal.dot(&way));
                (gap + change < kept * gap).then(|| (1.0 - kept) * gap / -change)
            }
            (Form::Pair(kind), _) => {
                let [x, d] = [points(pair.nodes, |i| self.ways.places.at(i)), points(pair.nodes, |i| self.way_of(i))];
                free_share(&Approach { kind, x, d, thickness: contact.thickness }, kept)
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bodies::Body;
    use super::*;
    use crate::mesh::random::SplitMix64;

    /// Contact of a body with itself, whose nodes are at `rest` [m].
    fn with_itself(body: Body, rest: &[Vector3<f64>]) -> Contacts {
        let contact = Contact { body, other: Other::Itself, thickness: 0.0, gap: 0.01, friction: 0.0, motion: None };
        Contacts {
            list: vec![contact],
            stiffness: vec![vec![1.0; rest.len()]],
            inverse_mass: vec![1.0; rest.len()],
            rest: rest.to_vec(),
            skin: 0.02,
            ..Contacts::default()
        }
    }

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
        let contacts = with_itself(body, &rest);
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

    /// Many triangles that fly through each other: nothing touches on the shortened ways, nor on any part of the share
    /// that is free for all.
    #[test]
    fn nothing_touches_on_what_is_left_of_the_ways() {
        let mut random = SplitMix64::new(7, 0);
        let mut shortened = 0;
        for _ in 0..200 {
            let mut point = |size: f64| Vector3::from_fn(|_, _| size * (2.0 * random.uniform() - 1.0));
            let middles: Vec<Vector3<f64>> = (0..12).map(|_| point(0.8)).collect();
            let rest: Vec<Vector3<f64>> =
                middles.iter().flat_map(|middle| [0; 3].map(|_| middle + point(0.15))).collect();
            let way: Vec<Vector3<f64>> =
                middles.iter().flat_map(|_| [point(1.5); 3].map(|way| way + point(0.1))).collect();
            let body = Body::new((0..12).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(), Vec::new(), Vec::new());
            let contacts = with_itself(body, &rest);
            let shifts = [[Vector3::zeros(); 2]];
            let places = Places { contacts: &contacts, t: 0.0, x: &rest, shifts: &shifts };
            let touches =
                |way: &[Vector3<f64>]| Apart::default().first_touch(places, &shifts, way, &mut Near::default());
            let mut left = way.clone();
            let least = Apart::default().shorten(places, &shifts, &mut left, &mut Near::default());
            let of_all: Vec<Vector3<f64>> = way.iter().map(|way| way * least).collect();
            assert_eq!(touches(&left), None);
            assert_eq!(touches(&of_all), None);
            shortened += usize::from(least < 1.0);
        }
        assert!(shortened > 100, "{shortened}");
    }
}
