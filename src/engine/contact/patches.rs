//! How far parts of a scene may have come nearer to each other, whatever they do together.
//!
//! The nodes of what may touch are in patches. With the mean m of the displacements of a patch since pairs were looked
//! for, and the largest distance e of one of them from it, no two points of patches A and B have come nearer to each
//! other by more than
//!
//! ```text
//! |m_A - m_B| + e_A + e_B   <=   max(skin, D_AB - gap)
//! ```
//!
//! If that holds for all patches that may touch, no pair can touch which is not near; D_AB is the distance of their
//! boxes then. The box of a patch is that of all elements with a node in it. So a sheet that falls keeps its pairs as
//! long as its patches keep their shapes.
//!
//! Where something turns, patches of the scene are compared as seen from one of them. The pose T of a patch is the
//! rigid motion that fits its nodes best, with turn R; r is the largest distance of one of them from where its own pose
//! has it, c the mean of the nodes and l their largest distance from it when pairs were looked for. No node of patch B
//! is farther from where the pose of A has it than
//!
//! ```text
//! s_B|A = r_B + |T_A(c_B) - T_B(c_B)| + |R_A - R_B| l_B
//! max over N of s_N|A  +  s_B|A   <=   max(skin, D_AB - gap),      N: A, and patches that share an element with it
//! ```
//! A rigid motion keeps distances, so no element with a node in A has come nearer to one with nodes in B by more: all
//! nodes of the first are in patches N, and the inequality holds for every patch with a node of the second. Obstacles
//! do not turn: for them the first form has to hold.

use super::bodies::{Body, Contacts, Other, Plane};
use super::distance::PairKind;
use super::near::{Candidate, Form, Places};
use crate::mesh::box_tree::Bounds;
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::f64::consts::FRAC_1_SQRT_2;

/// Largest number of patches of nodes.
const MOST: usize = 96;
/// Least number of nodes of one.
const NODES: usize = 16;
/// [rad] Accuracy of the turn of a pose, and how many rounds are made for it at most: any turn is right, the best one
/// serves longest.
const TURN: f64 = 1e-6;
const ROUNDS: usize = 20;

/// Displacements since some time.
#[derive(Clone, Debug, Default)]
pub struct Moved {
    /// [m] of the nodes of the scene
    pub nodes: Vec<Vector3<f64>>,
    /// [m] of the obstacle of every contact
    pub obstacles: Vec<Vector3<f64>>,
}

impl Moved {
    /// Of nodes from the second places to the first.
    pub fn fit(
        &mut self,
        (x, from): (&[Vector3<f64>], &[Vector3<f64>]),
        obstacles: impl Iterator<Item = Vector3<f64>>,
    ) {
        self.nodes.clear();
        self.nodes.extend(x.iter().zip(from).map(|(x, from)| x - from));
        self.obstacles.clear();
        self.obstacles.extend(obstacles);
    }

    /// [m] Of a node, or a corner of the obstacle of a contact.
    fn of(&self, contact: u16, node: u32) -> Vector3<f64> {
        self.nodes.get(node as usize).copied().unwrap_or_else(|| self.obstacles[usize::from(contact)])
    }

    /// Differences of displacements between the two sides of a pair.
    fn between(&self, pair: &Candidate) -> impl Iterator<Item = Vector3<f64>> {
        let first = if pair.form == Form::Pair(PairKind::EdgeEdge) { 2 } else { 1 };
        let count = if let Form::Pair(kind) = pair.form { kind.nodes() } else { 2 };
        // Beyond a node above a plane there is no node, which gives the displacement of the plane.
        let of = move |i: usize| self.of(pair.contact, pair.nodes[i]);
        (0..first).flat_map(move |i| (first..count).map(move |j| of(i) - of(j)))
    }

    /// [m] By how much the distance of a pair has fallen at most.
    pub fn nearer(&self, pair: &Candidate) -> f64 {
        self.between(pair).map(|way| way.norm_squared()).fold(0.0, f64::max).sqrt()
    }

    /// [m] The same if every node may have gone any share of its displacement.
    pub fn nearer_by_shares(&self, pair: &Candidate) -> f64 {
        let count = if let Form::Pair(kind) = pair.form { kind.nodes() } else { 2 };
        let of = (0..count).map(|i| self.of(pair.contact, pair.nodes[i]));
        of.chain(self.between(pair)).map(|way| way.norm_squared()).fold(0.0, f64::max).sqrt()
    }
}

/// Where a patch has moved to: a ball around the displacements of its nodes.
#[derive(Clone, Copy, Debug)]
struct Ball {
    centre: Vector3<f64>,
    radius: f64,
}

/// Where a patch has moved to, turned: see the [module](self).
#[derive(Clone, Copy, Debug)]
struct Pose {
    /// [m] c, and where it is now
    from: Vector3<f64>,
    to: Vector3<f64>,
    /// [m] l
    extent: f64,
    /// [-] R
    turn: Matrix3<f64>,
    /// [m] r
    rest: f64,
}

impl Pose {
    /// Of nodes at these places when pairs were looked for, with several displacements since.
    fn fit(nodes: &[u32], reference: &[Vector3<f64>], moved: &[Moved]) -> Self {
        let each = || nodes.iter().map(|i| reference[*i as usize]);
        let ends = || moved.iter().flat_map(|moved| nodes.iter().map(|i| (*i as usize, moved.nodes[*i as usize])));
        let count = nodes.len() as f64;
        let from = each().sum::<Vector3<f64>>() / count;
        let to = from + ends().map(|(_, d)| d).sum::<Vector3<f64>>() / (count * moved.len() as f64);
        let arms = || ends().map(|(i, d)| (reference[i] - from, reference[i] + d - to));
        let product: Matrix3<f64> = arms().map(|(before, now)| now * before.transpose()).sum();
        let turn = turn_of(&product);
        let square = arms().map(|(before, now)| (now - turn * before).norm_squared()).fold(0.0, f64::max);
        let extent = each().map(|x| (x - from).norm_squared()).fold(0.0, f64::max).sqrt();
        // The largest of numbers that are none is not one of them.
        let finite = to.iter().all(|x| x.is_finite());
        Pose { from, to, extent, turn, rest: if finite { square.sqrt() } else { f64::NAN } }
    }

    /// [m] s_B|A of another patch B.
    fn strays(&self, other: &Pose) -> f64 {
        let centre = self.to + self.turn * (other.from - self.from) - other.to;
        // The largest stretch of a difference of two rotations.
        let turn = (self.turn - other.turn).norm() * FRAC_1_SQRT_2;
        other.rest + centre.norm() + turn * other.extent
    }
}

/// How far two patches, by number, may come nearer.
#[derive(Clone, Copy, Debug)]
struct Limit {
    patches: [u16; 2],
    /// [m]
    most: f64,
}

/// The patches of a scene: those of nodes, then one for the obstacle of every contact.
#[derive(Clone, Debug, Default)]
pub struct Patches {
    /// nodes, patch by patch
    nodes: Vec<u32>,
    /// where the nodes of every patch end
    ends: Vec<usize>,
    /// the patch of every node of the scene that may touch
    of_node: Vec<u16>,
    /// patches that share an element, ascending
    neighbours: Vec<[u16; 2]>,
    limits: Vec<Limit>,
    balls: Vec<Ball>,
    poses: Vec<Pose>,
    /// [m] the largest s_N|A of every patch A
    around: Vec<f64>,
}

impl Patches {
    /// Divides the nodes that may touch into patches, by where they are at rest.
    fn divide(&mut self, contacts: &Contacts) {
        let bodies = contacts.list.iter().flat_map(|contact| [Some(&contact.body), contact.other.body()]);
        let mut nodes: Vec<u32> = bodies.flatten().flat_map(|body| &body.nodes).copied().collect();
        nodes.retain(|node| contacts.is_node(*node));
        nodes.sort_unstable();
        nodes.dedup();
        self.of_node = vec![0; contacts.rest.len()];
        self.ends.clear();
        let most = nodes.len().div_ceil(MOST).max(NODES);
        split(&mut nodes, contacts, most, &mut |patch| {
            patch.sort_unstable();
            patch.iter().for_each(|node| self.of_node[*node as usize] = self.ends.len() as u16);
            self.ends.push(self.ends.last().map_or(0, |end| *end) + patch.len());
        });
        self.nodes = nodes;
        self.neighbours.clear();
        for body in contacts.list.iter().flat_map(|contact| [Some(&contact.body), contact.other.body()]).flatten() {
            let sides = body.edges.iter().filter(|edge| edge.iter().all(|node| contacts.is_node(*node)));
            let patches = sides.map(|edge| edge.map(|node| self.of_node[node as usize]));
            self.neighbours.extend(patches.filter(|[a, b]| a != b).map(|[a, b]| [a.min(b), a.max(b)]));
        }
        self.neighbours.sort_unstable();
        self.neighbours.dedup();
    }

    /// Takes places, and the skin [m], as those of the last look for pairs.
    pub fn look(&mut self, places: Places<'_>, skin: f64) {
        let contacts = places.contacts;
        if self.of_node.len() != contacts.rest.len() {
            self.divide(contacts);
        }
        let mut limits = std::mem::take(&mut self.limits);
        limits.clear();
        for (number, contact) in (0_u16..).zip(&contacts.list) {
            let own = self.boxes(&contact.body, number, places);
            let (obstacle, reach) = (self.ends.len() as u16 + number, contact.gap + contact.thickness);
            let mut limit = |a: u16, b: u16, distance: f64| {
                limits.push(Limit { patches: [a, b], most: f64::max(skin, distance - reach) });
            };
            match (&contact.other, places.plane(number)) {
                (Other::Plane(_), plane) => own.iter().for_each(|(a, bounds)| {
                    limit(*a, obstacle, plane.map_or(0.0, |plane| lowest(bounds, &plane)));
                }),
                (Other::Itself, _) => own.iter().enumerate().for_each(|(i, (a, bounds))| {
                    own[i..].iter().for_each(|(b, other)| limit(*a, *b, bounds.distance(other)));
                }),
                (Other::Body(body), _) => {
                    let others = self.boxes(body, number, places);
                    for (a, bounds) in &own {
                        others.iter().for_each(|(b, other)| limit(*a, *b, bounds.distance(other)));
                    }
                }
            }
        }
        self.limits = limits;
    }

    /// The patches of a body with their boxes.
    fn boxes(&self, body: &Body, contact: u16, places: Places<'_>) -> Vec<(u16, Bounds)> {
        let mut boxes = vec![Bounds::EMPTY; self.ends.len() + places.contacts.list.len()];
        let mut surround = |element: &[u32]| {
            let around = |all: Bounds, node: &u32| {
                let x = places.at(*node).into();
                all.joined(Bounds { low: x, high: x })
            };
            let bounds = element.iter().fold(Bounds::EMPTY, around);
            for node in element {
                let patch = self.of_node.get(*node as usize).copied().unwrap_or(self.ends.len() as u16 + contact);
                let all = &mut boxes[usize::from(patch)];
                *all = all.joined(bounds);
            }
        };
        body.triangles.iter().for_each(|element| surround(element));
        body.lines.iter().for_each(|element| surround(element));
        body.points.iter().for_each(|node| surround(&[*node]));
        (0..).zip(boxes).filter(|(_, bounds)| *bounds != Bounds::EMPTY).collect()
    }

    /// Whether no two patches have come nearer by more than a share of what they may, at any of these displacements
    /// from the places `reference` [m].
    pub fn cover(&mut self, reference: &[Vector3<f64>], ends: &[Moved], share: f64) -> bool {
        ends.iter().all(|moved| self.keep(reference, std::slice::from_ref(moved), share))
    }

    /// The same where every node has gone any share of its way between two displacements.
    pub fn cover_shares(&mut self, reference: &[Vector3<f64>], ends: &[Moved; 2]) -> bool {
        self.keep(reference, ends, 1.0)
    }

    fn keep(&mut self, reference: &[Vector3<f64>], moved: &[Moved], share: f64) -> bool {
        self.follow(moved);
        let keeps = |Limit { patches, most }: &Limit| {
            let [a, b] = patches.map(|patch| self.balls[usize::from(patch)]);
            (a.centre - b.centre).norm() + a.radius + b.radius <= share * most
        };
        let count = self.ends.len();
        let of_scene = |limit: &Limit| limit.patches.iter().all(|patch| usize::from(*patch) < count);
        match self.limits.iter().filter(|limit| !keeps(limit)).map(of_scene).reduce(|a, b| a & b) {
            None => true,
            Some(false) => false,
            Some(true) => self.keep_turned(reference, moved, share),
        }
    }

    /// The same of patches of the scene, as seen from each of them.
    fn keep_turned(&mut self, reference: &[Vector3<f64>], moved: &[Moved], share: f64) -> bool {
        let Patches { nodes, ends, neighbours, limits, poses, around, .. } = self;
        poses.clear();
        let starts = std::iter::once(0).chain(ends.iter().copied());
        poses.extend(starts.zip(&*ends).map(|(start, end)| Pose::fit(&nodes[start..*end], reference, moved)));
        around.clear();
        around.extend(poses.iter().map(|pose| pose.rest));
        for [a, b] in neighbours.iter().flat_map(|&[a, b]| [[a, b], [b, a]]).map(|pair| pair.map(usize::from)) {
            around[a] = f64::max(around[a], poses[a].strays(&poses[b]));
        }
        limits.iter().all(|Limit { patches, most }| {
            let [a, b] = patches.map(usize::from);
            let keeps = |a: usize, b: usize| around[a] + poses[a].strays(&poses[b]) <= share * most;
            a.max(b) >= poses.len() || keeps(a, b) && keeps(b, a)
        })
    }

    /// Finds the balls of all patches around several displacements.
    fn follow(&mut self, moved: &[Moved]) {
        self.balls.clear();
        let mut start = 0;
        for &end in &self.ends {
            let nodes = &self.nodes[start..end];
            self.balls.push(ball(|| moved.iter().flat_map(|moved| nodes.iter().map(|i| moved.nodes[*i as usize]))));
            start = end;
        }
        let obstacles = moved.first().map_or(0, |moved| moved.obstacles.len());
        self.balls.extend((0..obstacles).map(|i| ball(|| moved.iter().map(move |moved| moved.obstacles[i]))));
    }
}

/// The rotation that is nearest to a matrix, as the sum of products of places after and before a rigid motion (Müller,
/// Bender, Chentanez & Macklin 2016).
fn turn_of(product: &Matrix3<f64>) -> Matrix3<f64> {
    let mut turn = Rotation3::identity();
    for _ in 0..ROUNDS {
        let columns = || turn.matrix().column_iter().zip(product.column_iter());
        let axis: Vector3<f64> = columns().map(|(r, a)| r.cross(&a)).sum();
        let along: f64 = columns().map(|(r, a)| r.dot(&a)).sum();
        let way = axis / along.abs();
        // Also ends where nothing turns, and where a number is none.
        if !(way.norm() > TURN && way.norm().is_finite()) {
            break;
        }
        turn = Rotation3::new(way) * turn;
    }
    turn.into_inner()
}

/// A ball around displacements; not a number if one of them is not.
fn ball<I: Iterator<Item = Vector3<f64>>>(all: impl Fn() -> I) -> Ball {
    let (sum, count) = all().fold((Vector3::zeros(), 0.0), |(sum, count), d| (sum + d, count + 1.0));
    let centre = sum / f64::max(count, 1.0);
    let square = all().map(|d| (d - centre).norm_squared()).fold(0.0, f64::max);
    Ball { centre, radius: if centre.x.is_finite() { square.sqrt() } else { f64::NAN } }
}

/// [m] Height above a plane of the lowest corner of a box.
fn lowest(bounds: &Bounds, plane: &Plane) -> f64 {
    let lower = |k: usize| if plane.normal[k] > 0.0 { bounds.low[k] } else { bounds.high[k] };
    plane.normal.dot(&(Vector3::from_fn(|k, _| lower(k)) - plane.point))
}

/// Halves nodes along the longest axis of their places at rest, until no part has more than `most`.
fn split(nodes: &mut [u32], contacts: &Contacts, most: usize, found: &mut dyn FnMut(&mut [u32])) {
    if nodes.len() <= most {
        if !nodes.is_empty() {
            found(nodes);
        }
        return;
    }
    let bounds = nodes.iter().fold(Bounds::EMPTY, |all, node| {
        let x = contacts.at_rest(*node).into();
        all.joined(Bounds { low: x, high: x })
    });
    let (axis, half) = (bounds.longest_axis(), nodes.len() / 2);
    let place = |node: &u32| contacts.at_rest(*node)[axis];
    nodes.select_nth_unstable_by(half, |a, b| place(a).total_cmp(&place(b)).then(a.cmp(b)));
    let (low, high) = nodes.split_at_mut(half);
    split(low, contacts, most, found);
    split(high, contacts, most, found);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The pose of nodes that only turn and move has no rest, also of nodes on a line or far apart, which leave a part
    /// of the turn open.
    #[test]
    fn poses_follow_rigid_motions() {
        let line = |i: usize| Vector3::new(7.0 * i as f64, 0.0, 0.0);
        let sheet = |i: usize| Vector3::new((i % 4) as f64 * 0.1, (i / 4) as f64 * 0.1, 0.0);
        let nodes: Vec<u32> = (0..16).collect();
        for reference in [(0..16).map(line).collect::<Vec<_>>(), (0..16).map(sheet).collect(), vec![sheet(3); 16]] {
            for angle in [0.0, 1e-3, 0.3, 1.0, 2.0] {
                let turn = Rotation3::new(Vector3::new(0.6, -0.48, 0.64) * angle);
                let moved = |x: &Vector3<f64>| turn * x + Vector3::new(3.0, -2.0, 1.0) - x;
                let moved = Moved { nodes: reference.iter().map(moved).collect(), obstacles: Vec::new() };
                let pose = Pose::fit(&nodes, &reference, &[moved]);
                assert!(pose.rest <= 1e-5 * pose.extent + 1e-12, "{angle}: {pose:?}");
            }
        }
    }
}
