//! Where cloth passes through cloth: edges of triangles that pass through other triangles.
//!
//! An edge crosses a triangle with which it shares no node if its ends are strictly on different sides of the
//! triangle's plane and its line passes strictly through the inside. Signs come from exact predicates (Shewchuk 1997,
//! "Adaptive precision floating-point arithmetic and fast robust geometric predicates"), so cloth that lies in one
//! plane, or touches in a node, along an edge or side by side, does not cross. Neither does what is not deeper than the
//! rounding of coordinates, as where the parts of a folded start lie on each other.

use super::box_tree::{Bounds, BoxTree};
use super::over_plane::{Boundary, lies_over_a_plane};
use super::sides::{Sides, sides_of};
use super::tuples::in_order;
use nalgebra::Vector3;
use robust::{Coord3D, orient3d};

/// [-] Depth over the largest coordinate up to which cloth only touches: some thousand times the rounding of a
/// coordinate.
const TOUCHING: f64 = 1e-12;
/// [-] Pairs of boxes that a search may compare, for each triangle. Cloth that hangs free takes about a hundred, a
/// packed one some thousands.
const LOOKS: u64 = 10_000;
/// [-] Pairs that a search may compare in any case.
const LEAST_LOOKS: u64 = 10_000_000;
/// [-] What a crossing that is found takes of them, which bounds their number.
const LOOKS_OF_CROSSING: u64 = 500;

/// [-] Extent over that at the start from which on cloth is no cloth any more: a run went on past its divergence.
const BLOWN_UP: f64 = 1e3;

/// An edge of cloth that passes through a triangle of cloth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// nodes of the edge, the smaller one first
    pub edge: [u32; 2],
    /// the triangle
    pub triangle: u32,
    /// [m] how far edge or triangle would have to move to part: the least distance of the edge's ends from the plane of
    /// the triangle, and of the place where it passes from the triangle's sides
    pub depth: f64,
}

/// Finds crossings of some triangles with each other, again and again as nodes move. The first search takes O(n log n),
/// any other as long as there are boxes that overlap; cloth over a plane, or in one across an axis, takes a look at
/// each triangle.
#[derive(Clone, Debug)]
pub struct CrossingFinder {
    triangles: Vec<[u32; 3]>,
    /// made by the first search that needs it
    tree: Option<BoxTree>,
    /// made for the first cloth that may lie over a plane
    boundary: Option<Boundary>,
    /// made when the first crossing is marked
    sides: Option<Sides>,
    /// the sides of every triangle that are looked at with it: bit k is that from corner k to the next, and every side
    /// belongs to one triangle
    own: Vec<u8>,
    found: Vec<Crossing>,
    complete: bool,
    /// [m] largest extent at the start; infinite if it is not known
    size: f64,
}

impl CrossingFinder {
    /// Of these triangles; `None` where no two could cross.
    pub fn new(triangles: &[[u32; 3]]) -> Option<Self> {
        can_meet(triangles).then(|| CrossingFinder {
            triangles: triangles.to_vec(),
            tree: None,
            boundary: None,
            sides: None,
            own: Vec::new(),
            found: Vec::new(),
            complete: true,
            size: f64::INFINITY,
        })
    }

    /// The same, which does not search cloth that has grown a thousand times beyond these positions [m].
    pub fn with_start(mut self, positions: &[[f64; 3]]) -> Self {
        self.size = around(positions, self.triangles.as_flattened()).extent();
        self
    }

    /// All crossings at these positions [m] of the nodes, by triangle, then by edge. All are finite.
    pub fn find(&mut self, positions: &[[f64; 3]]) -> &[Crossing] {
        self.found.clear();
        self.complete = true;
        let Self { triangles, found, .. } = self;
        let all @ Bounds { low, high } = around(positions, triangles.as_flattened());
        if all.is_flat() {
            return &self.found;
        }
        if all.extent() > BLOWN_UP * self.size {
            self.complete = false;
            return &self.found;
        }
        if lies_over_a_plane(triangles, positions, &mut self.boundary) {
            return &self.found;
        }
        let bounds = |triangle: u32| around(positions, &triangles[triangle as usize]);
        let tree = match &mut self.tree {
            Some(tree) => {
                tree.refit(bounds);
                tree
            }
            none => {
                self.own = own_sides(triangles);
                none.insert(BoxTree::of(triangles.len(), bounds))
            }
        };
        let largest = low.iter().chain(&high).fold(0.0, |most: f64, x| most.max(x.abs()));
        let cloth = Cloth { triangles, own: &self.own, positions, touching: TOUCHING * largest };
        let mut looks = most_looks(triangles.len());
        tree.pairs(&mut looks, |a, b, looks| {
            let before = found.len();
            cloth.cross([a, b], found);
            *looks = looks.saturating_sub(LOOKS_OF_CROSSING * (found.len() - before) as u64);
        });
        self.complete = looks > 0;
        found.sort_unstable_by_key(|crossing| (crossing.triangle, crossing.edge));
        &self.found
    }

    /// What the last search found.
    pub fn found(&self) -> &[Crossing] {
        &self.found
    }

    /// Whether the last search found all; cloth that is crumpled beyond all measure has too many pairs.
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// Writes 1 for every triangle that passes through another, 0 for all others.
    pub fn mark(&mut self, flags: &mut [u8]) {
        flags.fill(0);
        if self.found.is_empty() {
            return;
        }
        let sides = self.sides.get_or_insert_with(|| Sides::new(&self.triangles));
        let mut mark = |triangle: u32| {
            if let Some(flag) = flags.get_mut(triangle as usize) {
                *flag = 1;
            }
        };
        for crossing in &self.found {
            let at_edge = sides.find(crossing.edge).map_or(&[][..], |side| sides.at(side));
            at_edge.iter().chain([&crossing.triangle]).for_each(|triangle| mark(*triangle));
        }
    }
}

fn most_looks(triangles: usize) -> u64 {
    LOOKS.saturating_mul(triangles as u64).max(LEAST_LOOKS)
}

/// Whether some of these triangles could pass through each other: a single one cannot.
pub fn can_meet(triangles: &[[u32; 3]]) -> bool {
    triangles.len() > 1
}

/// Every side belongs to the first of its triangles.
fn own_sides(triangles: &[[u32; 3]]) -> Vec<u8> {
    let (mut own, mut before) = (vec![0; triangles.len()], None);
    in_order(sides_of(triangles), |side, number| {
        if before.replace(side) != Some(side) {
            own[number as usize / 3] |= 1 << (number % 3);
        }
    });
    own
}

/// Where the corners of a triangle are to a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    /// all in it
    Neither,
    /// on one side, some perhaps in it
    One,
    /// on both sides
    Both,
}

/// Triangles at the positions of a search.
struct Cloth<'a> {
    triangles: &'a [[u32; 3]],
    own: &'a [u8],
    positions: &'a [[f64; 3]],
    /// [m] depth up to which they only touch
    touching: f64,
}

impl Cloth<'_> {
    /// Adds the crossings of the sides of either triangle with the other.
    fn cross(&self, pair: [u32; 2], found: &mut Vec<Crossing>) {
        let [one, other] = pair;
        let (a, b) = (&self.triangles[one as usize], &self.triangles[other as usize]);
        // Each side of a pair with two common nodes has one of them.
        if a.iter().filter(|node| b.contains(node)).count() > 1 {
            return;
        }
        let sides = [self.sides_near(one, other), self.sides_near(other, one)];
        for (way, sides) in sides.iter().enumerate() {
            // If one triangle is on one side of the other's plane, neither crosses the other.
            if *sides != 0 && self.cross_one(pair[way], *sides, pair[1 - way], found) == Side::One {
                return;
            }
        }
    }

    /// The own sides of a triangle that share no node with another and have a box that overlaps its box.
    fn sides_near(&self, of: u32, with: u32) -> u8 {
        let (nodes, others) = (&self.triangles[of as usize], &self.triangles[with as usize]);
        let bounds = around(self.positions, others);
        let mut sides = 0;
        for k in 0..3 {
            let ends = [nodes[k], nodes[(k + 1) % 3]];
            let may = self.own[of as usize] & 1 << k != 0 && !others.iter().any(|node| ends.contains(node));
            if may && around(self.positions, &ends).overlaps(&bounds) {
                sides |= 1 << k;
            }
        }
        sides
    }

    /// Adds the crossings of some sides of a triangle with another; returns where it lies to the other's plane.
    fn cross_one(&self, of: u32, sides: u8, with: u32, found: &mut Vec<Crossing>) -> Side {
        let nodes = self.triangles[of as usize];
        let triangle = self.triangles[with as usize].map(|node| coordinates(self.positions[node as usize]));
        let corners = nodes.map(|node| coordinates(self.positions[node as usize]));
        let above = corners.map(|corner| sign([triangle[0], triangle[1], triangle[2], corner]));
        if !(above.contains(&1) && above.contains(&-1)) {
            // A triangle without area has no plane.
            return if above == [0; 3] { Side::Neither } else { Side::One };
        }
        for k in (0..3).filter(|k| sides & 1 << k != 0) {
            let next = (k + 1) % 3;
            if above[k] * above[next] >= 0 || !pierces([corners[k], corners[next]], triangle) {
                continue;
            }
            let edge = [nodes[k], nodes[next]];
            let depth = self.depth(edge, with);
            if depth > self.touching {
                let edge = [edge[0].min(edge[1]), edge[0].max(edge[1])];
                found.push(Crossing { edge, triangle: with, depth });
            }
        }
        Side::Both
    }

    /// [m] How deep an edge passes through a triangle.
    fn depth(&self, edge: [u32; 2], triangle: u32) -> f64 {
        let at = |node: u32| Vector3::from(self.positions[node as usize]);
        let [a, b, c] = self.triangles[triangle as usize].map(at);
        let normal = (b - a).cross(&(c - a));
        let [p, q] = edge.map(at);
        let [one, other] = [p, q].map(|end| (end - a).dot(&normal).abs() / normal.norm());
        let place = p + (q - p) * (one / (one + other));
        let beside =
            |from: Vector3<f64>, to: Vector3<f64>| (place - from).cross(&(to - from)).norm() / (to - from).norm();
        [other, beside(a, b), beside(b, c), beside(c, a)].into_iter().fold(one, f64::min)
    }
}

/// The box around some nodes.
#[inline]
fn around(positions: &[[f64; 3]], nodes: &[u32]) -> Bounds {
    Bounds::of(nodes.iter().map(|node| &positions[*node as usize]))
}

fn coordinates([x, y, z]: [f64; 3]) -> Coord3D<f64> {
    Coord3D { x, y, z }
}

/// On which side of the plane of the first three points the fourth is: 1, -1, or 0 in the plane; exact.
fn sign([a, b, c, d]: [Coord3D<f64>; 4]) -> i8 {
    let volume = orient3d(a, b, c, d);
    i8::from(volume > 0.0) - i8::from(volume < 0.0)
}

/// Whether the line through two points passes strictly through the inside of a triangle.
fn pierces([p, q]: [Coord3D<f64>; 2], [a, b, c]: [Coord3D<f64>; 3]) -> bool {
    let first = sign([p, q, a, b]);
    first != 0 && sign([p, q, b, c]) == first && sign([p, q, c, a]) == first
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix64;
    use std::collections::BTreeSet;

    /// Six times the volume of a tetrahedron with whole coordinates.
    fn volume([a, b, c, d]: [[i128; 3]; 4]) -> i128 {
        let [u, v, w] = [a, b, c].map(|x| [x[0] - d[0], x[1] - d[1], x[2] - d[2]]);
        u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) + u[2] * (v[0] * w[1] - v[1] * w[0])
    }

    /// All edges with all triangles in whole numbers.
    fn all_with_all(nodes: &[[i128; 3]], triangles: &[[u32; 3]]) -> BTreeSet<(u32, [u32; 2])> {
        let edges = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let edges: BTreeSet<[u32; 2]> = edges.map(|[a, b]| [a.min(b), a.max(b)]).collect();
        let at = |node: u32| nodes[node as usize];
        let mut found = BTreeSet::new();
        for (number, triangle) in (0..).zip(triangles) {
            for edge in edges.iter().filter(|edge| !edge.iter().any(|node| triangle.contains(node))) {
                let ([p, q], [a, b, c]) = (edge.map(at), triangle.map(at));
                let ends = [p, q].map(|end| volume([a, b, c, end]).signum());
                let around = [[a, b], [b, c], [c, a]].map(|[a, b]| volume([p, q, a, b]).signum());
                if ends[0] * ends[1] < 0 && around[0] != 0 && around == [around[0]; 3] {
                    found.insert((number, *edge));
                }
            }
        }
        found
    }

    /// A sheet of 2 n^2 triangles.
    fn sheet(n: u32) -> Vec<[u32; 3]> {
        let node = |i: u32, j: u32| i * (n + 1) + j;
        let cells = (0..n).flat_map(|i| (0..n).map(move |j| [i, j]));
        let halves = |[i, j]: [u32; 2]| {
            let [a, b, c, d] = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
            [[a, b, c], [a, c, d]]
        };
        cells.flat_map(halves).collect()
    }

    /// Crumpled sheets with whole coordinates, so that many things touch: crossings are those of all with all.
    #[test]
    fn crossings_are_those_of_all_with_all() {
        let mut random = SplitMix64::new(3, 0);
        let mut total = 0;
        for (n, range) in [(1, 3.0), (2, 2.0), (3, 4.0), (5, 3.0), (6, 20.0), (8, 1000.0)] {
            let triangles = sheet(n);
            let mut finder = CrossingFinder::new(&triangles).expect("two triangles or more");
            for _ in 0..60 {
                let nodes = (0..(n + 1).pow(2)).map(|_| [0; 3].map(|_| (range * random.signed()).floor() as i128));
                let nodes: Vec<[i128; 3]> = nodes.collect();
                let right = all_with_all(&nodes, &triangles);
                let positions: Vec<[f64; 3]> = nodes.iter().map(|x| x.map(|x| x as f64)).collect();
                let found = finder.find(&positions).iter().map(|crossing| (crossing.triangle, crossing.edge));
                assert!(found.eq(right.iter().copied()), "{n}, {range}");
                assert!(finder.is_complete(), "{n}, {range}: {} crossings", right.len());
                total += right.len();
            }
        }
        assert!(total > 10_000, "{total}");
    }

    /// Two sheets that cross along a line, by how deep: both are marked where they do, and a sheet that only lies on
    /// the other, in its plane or along a fold, is not.
    #[test]
    fn sheets_cross_and_touch() {
        let square = sheet(4);
        let both: Vec<[u32; 3]> = square.iter().copied().chain(square.iter().map(|t| t.map(|n| n + 25))).collect();
        let flat = |k: usize| [(k / 5) as f64, (k % 5) as f64, 0.0];
        let placed = |map: &dyn Fn([f64; 3]) -> [f64; 3]| {
            let nodes: Vec<[f64; 3]> = (0..25).map(flat).chain((0..25).map(|k| map(flat(k)))).collect();
            let mut finder = CrossingFinder::new(&both).expect("two sheets");
            let crossings = finder.find(&nodes).to_vec();
            let mut flags = vec![2; both.len()];
            finder.mark(&mut flags);
            (crossings, flags)
        };
        // An upright sheet, of which a row of squares reaches from 0.75 m below the first sheet to 0.25 m above it. Its
        // upright edges pass at (0.4, 0.3) of squares, which is 0.1/sqrt(2) from their diagonals.
        let (crossings, flags) = placed(&|[x, y, _]| [1.4, y + 0.3, x - 1.75]);
        assert!(crossings.len() > 8 && crossings.iter().all(|c| c.depth <= 1.0), "{crossings:?}");
        let deepest = crossings.iter().filter(|c| c.triangle < 32).map(|c| c.depth).fold(0.0, f64::max);
        assert!((deepest - 0.1 / 2.0_f64.sqrt()).abs() < 1e-12, "{deepest}");
        // The lowest row of squares of the second sheet that reaches the first, and the row of the first at x = 1 to 2.
        let marked: Vec<usize> = (0..64).filter(|t| flags[*t] == 1).collect();
        assert!(marked.iter().all(|t| (8..16).contains(t) || (40..48).contains(t)), "{marked:?}");
        assert!(flags.iter().all(|flag| *flag < 2));
        let turned = |by: f64, [x, y, z]: [f64; 3]| [x * by.cos() - z * by.sin(), y, x * by.sin() + z * by.cos()];
        for (what, map) in [
            ("doubled", &(|x| x) as &dyn Fn([f64; 3]) -> [f64; 3]),
            ("shifted in its plane", &|[x, y, z]| [x + 0.3, y + 0.2, z]),
            ("folded along a line of nodes", &|x| turned(1.0, x)),
            ("folded, with rounding", &|[x, y, z]| turned(1.0, [x, y + 0.1 - 0.1, z + 1e-16])),
            ("upright on it", &|[x, y, _]| [1.4, y, x]),
            ("apart", &|[x, y, z]| [x, y, z + 1e-6]),
        ] {
            let (crossings, flags) = placed(map);
            assert!(crossings.is_empty() && flags == vec![0; both.len()], "{what}: {crossings:?}");
        }
    }

    /// A strip that winds one and a half times around an axis: all its triangles have one orientation from above, and
    /// it covers the plane twice in places. Where its end rises through its beginning it crosses, and that is found.
    #[test]
    fn a_strip_that_covers_a_plane_twice_is_searched() {
        let n = 24;
        let at = |k: u32, rise: f64| {
            let (i, j) = (f64::from(k / (n + 1)), f64::from(k % (n + 1)));
            let (angle, r) = (3.1 * std::f64::consts::PI * j / f64::from(n), 100.0 * (10.0 + i));
            // Inner nodes rise, outer ones sink, so that the second turn passes through the first.
            [(r * angle.cos()).round(), (r * angle.sin()).round(), (rise * j * (0.6 - i / f64::from(n))).round()]
        };
        let triangles = sheet(n);
        let nodes: Vec<[f64; 3]> = (0..(n + 1) * (n + 1)).map(|k| at(k, 100.0)).collect();
        assert!(crosses_as_all_with_all(&triangles, &nodes) > 10);
    }

    /// Number of crossings, which are those of all with all.
    fn crosses_as_all_with_all(triangles: &[[u32; 3]], nodes: &[[f64; 3]]) -> usize {
        let whole: Vec<[i128; 3]> = nodes.iter().map(|x| x.map(|x| x as i128)).collect();
        let mut finder = CrossingFinder::new(triangles).expect("a sheet");
        let found: Vec<_> = finder.find(nodes).iter().map(|one| (one.triangle, one.edge)).collect();
        assert!(found.iter().copied().eq(all_with_all(&whole, triangles)));
        found.len()
    }

    /// A strip in steps along the axes that covers its beginning again, far from the origin: its sides lie on each
    /// other there. A small sheet that passes through the middle of a large one, all in one orientation from above: the
    /// boundaries do not meet. A sheet that is folded over within its boundary.
    #[test]
    fn what_is_nearly_over_a_plane_is_searched() {
        // Cells around a square, and three more over the first three, which pass through them.
        let cells = [[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1], [0, 0], [1, 0], [2, 0]];
        let (mut nodes, mut strip): (Vec<[f64; 3]>, Vec<[u32; 3]>) = (Vec::new(), Vec::new());
        let mut before: Vec<([i32; 2], u32)> = Vec::new();
        for (i, [x, y]) in cells.into_iter().enumerate() {
            let over = i >= 8;
            let corners = [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]].map(|corner| {
                let shared = before.iter().find(|(other, _)| *other == corner).map(|(_, node)| *node);
                let node = shared.unwrap_or_else(|| {
                    let height = if over { [-1.0, 2.0][corner[0] as usize % 2] } else { 0.0 };
                    nodes.push([f64::from(corner[0]), f64::from(corner[1]), height]);
                    nodes.len() as u32 - 1
                });
                (corner, node)
            });
            let [a, b, c, d] = corners.map(|(_, node)| node);
            strip.extend(if over { [[a, b, d], [b, c, d]] } else { [[a, b, c], [a, c, d]] });
            before = corners.to_vec();
        }
        let crossings = crosses_as_all_with_all(&strip, &nodes);
        let far = 2.0_f64.powi(30);
        let moved: Vec<[f64; 3]> = nodes.iter().map(|x| [x[0] + far, x[1] + far, x[2]]).collect();
        assert!(crossings > 0, "{crossings}");
        assert_eq!(crosses_as_all_with_all(&strip, &moved), crossings);

        let n = 8;
        let one = (n + 1) * (n + 1);
        let second = sheet(n).into_iter().map(|t| t.map(|k| k + one));
        let two: Vec<[u32; 3]> = sheet(n).into_iter().chain(second).collect();
        let place = |k: u32| {
            let (x, y) = (f64::from(k % one / (n + 1)), f64::from(k % one % (n + 1)));
            if k < one { [10.0 * x, 10.0 * y, 0.0] } else { [33.0 + x, 33.0 + y, 3.0 * x - 10.0] }
        };
        let nodes: Vec<[f64; 3]> = (0..2 * one).map(place).collect();
        assert!(crosses_as_all_with_all(&two, &nodes) > 0);

        // The middle of the sheet is drawn far aside, through what lies there.
        let drawn = |k: u32| {
            let [x, y, z] = place(k);
            let middle = (3.0..6.0).contains(&(x / 10.0)) && (3.0..6.0).contains(&(y / 10.0));
            if middle { [x + 37.0, y + 3.0, 5.0] } else { [x, y, z + x % 20.0] }
        };
        let nodes: Vec<[f64; 3]> = (0..one).map(drawn).collect();
        assert!(crosses_as_all_with_all(&sheet(n), &nodes) > 0);
    }

    /// Cloth over a plane is not searched: steep hills, a hole, one orientation or the other, over another plane; a
    /// sheet that is bent over a rounded edge is, and two sheets above each other.
    #[test]
    fn cloth_over_a_plane_takes_no_tree() {
        let n = 20;
        let hole =
            |t: &[u32; 3]| t.iter().all(|k| (8..12).contains(&(k / (n + 1))) && (8..12).contains(&(k % (n + 1))));
        let whole = sheet(n);
        let with_hole: Vec<[u32; 3]> = whole.iter().copied().filter(|t| !hole(t)).collect();
        let turned: Vec<[u32; 3]> = with_hole.iter().map(|&[a, b, c]| [a, c, b]).collect();
        let second = whole.iter().map(|t| t.map(|k| k + (n + 1) * (n + 1)));
        let two: Vec<[u32; 3]> = whole.iter().copied().chain(second).collect();
        let hills = |k: u32| {
            let (x, y) = (f64::from(k / (n + 1)), f64::from(k % (n + 1)));
            [x, y, 30.0 * (0.7 * x).sin() * (0.5 * y + 1.0).cos()]
        };
        let aside = |[x, y, z]: [f64; 3]| [z, x, y];
        let over_edge = |k: u32| {
            let [x, y, _] = hills(k);
            [6.0 * (0.2 * x).sin(), y, 6.0 * (0.2 * x).cos()]
        };
        let twice = |k: u32| {
            let [x, y, z] = hills(k % ((n + 1) * (n + 1)));
            [x, y, z + f64::from(k / ((n + 1) * (n + 1)))]
        };
        let nodes = |count: u32, place: &dyn Fn(u32) -> [f64; 3]| (0..count).map(place).collect::<Vec<_>>();
        let one = (n + 1) * (n + 1);
        for (what, triangles, positions, searched) in [
            ("hills", &whole, nodes(one, &hills), false),
            ("a hole", &with_hole, nodes(one, &hills), false),
            ("turned around", &turned, nodes(one, &hills), false),
            ("over another plane", &with_hole, nodes(one, &|k| aside(hills(k))), false),
            ("over an edge", &whole, nodes(one, &over_edge), true),
            ("two sheets", &two, nodes(2 * one, &twice), true),
        ] {
            let mut finder = CrossingFinder::new(triangles).expect("a sheet");
            assert!(finder.find(&positions).is_empty() && finder.is_complete(), "{what}");
            assert_eq!(finder.tree.is_some(), searched, "{what}");
        }
    }

    /// A flat sheet that is turned in space has rounding errors across its plane, and no crossings.
    #[test]
    fn a_turned_plane_does_not_cross_itself() {
        let n = 12;
        let triangles = sheet(n);
        let (u, v) = (Vector3::new(0.6, 0.64, 0.48), Vector3::new(-0.8, 0.48, 0.36));
        // Folded back and forth in the plane, so that layers lie on each other.
        let fold = |i: u32| f64::from(if i % 6 < 3 { i % 6 } else { 6 - i % 6 });
        let place = |k: u32| (u * fold(k / (n + 1)) + v * (f64::from(k % (n + 1)) * 0.37)).into();
        let nodes: Vec<[f64; 3]> = (0..(n + 1) * (n + 1)).map(place).collect();
        let mut finder = CrossingFinder::new(&triangles).expect("a sheet");
        assert_eq!(finder.find(&nodes), []);
    }

    /// Cloth in which all overlaps all is searched with a bound, and said to be.
    #[test]
    fn a_crumpled_heap_is_not_searched_for_ever() {
        let mut random = SplitMix64::new(9, 0);
        let n = 60;
        let triangles = sheet(n);
        let nodes: Vec<[f64; 3]> = (0..(n + 1) * (n + 1)).map(|_| [0; 3].map(|_| random.signed())).collect();
        let mut finder = CrossingFinder::new(&triangles).expect("a sheet");
        let found = finder.find(&nodes).len() as u64;
        let most = most_looks(triangles.len()) / LOOKS_OF_CROSSING;
        assert!(!finder.is_complete() && found > most / 10 && found <= most + 6, "{found} of {most}");
        assert!(CrossingFinder::new(&triangles[..1]).is_none());
    }
}
