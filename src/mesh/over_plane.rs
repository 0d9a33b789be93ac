//! Cloth that lies over a plane, and so cannot pass through itself.
//!
//! A surface whose triangles all have the same orientation in a plane covers a point of it as often as its boundary
//! winds around that point: the sides between triangles cancel. If the loops of the boundary neither cross nor touch
//! there, each of them winds around what it encloses, an outer one once, a hole once the other way. With a single outer
//! one that is once at most (for one loop: Volino and Magnenat-Thalmann 1994, "Efficient self-collision detection on
//! smoothly discretized surface animations using geometrical shape regularity"). Where triangles lie and whether loops
//! meet is told by exact signs (Shewchuk 1997); where the area of a loop is unclear, the cloth is not said to lie over
//! a plane.

use super::box_tree::{Bounds, BoxTree};
use super::sides::sides_of;
use super::tuples::in_order;
use robust::{Coord, orient2d};

/// [-] Share of the boundary's extent by which boxes around its sides are larger, as flat boxes overlap nothing; and
/// share of the square of the extent that twice the area of a hole must have.
const NEAR: f64 = 1e-9;
/// [-] Pairs of boxes that may be compared, for each side of the boundary and a thousand more.
const LOOKS: u64 = 1000;

/// The sides that are left where those in opposite directions cancel, in the direction in which a triangle has them.
#[derive(Clone, Debug, Default)]
pub(super) struct Boundary {
    /// empty where two of them begin at one node, as where neighbours have not the same orientation, and without any
    loops: Vec<Vec<u32>>,
}

/// A plane across an axis, with the side from which areas are positive.
#[derive(Clone, Copy)]
struct Plane {
    axis: usize,
    /// 1 or -1
    side: f64,
}

impl Plane {
    /// That in which triangles have the largest area together.
    fn of(triangles: &[[u32; 3]], positions: &[[f64; 3]]) -> Self {
        let mut sum = [0.0_f64; 3];
        for corners in triangles {
            let [a, b, c] = corners.map(|node| positions[node as usize]);
            for (k, sum) in sum.iter_mut().enumerate() {
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                *sum += (b[i] - a[i]) * (c[j] - a[j]) - (b[j] - a[j]) * (c[i] - a[i]);
            }
        }
        let axis = (1..3).fold(0, |most, k| if sum[k].abs() > sum[most].abs() { k } else { most });
        Plane { axis, side: sum[axis].signum() }
    }

    fn point(self, x: [f64; 3]) -> Coord<f64> {
        Coord { x: x[(self.axis + 1) % 3], y: x[(self.axis + 2) % 3] }
    }

    /// Twice the area of a triangle, of exact sign.
    fn area(self, [a, b, c]: [[f64; 3]; 3]) -> f64 {
        self.side * orient2d(self.point(a), self.point(b), self.point(c))
    }
}

/// Whether triangles at these positions lie over a plane. `boundary` is made when it is needed first.
pub(super) fn lies_over_a_plane(
    triangles: &[[u32; 3]],
    positions: &[[f64; 3]],
    boundary: &mut Option<Boundary>,
) -> bool {
    if boundary.as_ref().is_some_and(|boundary| boundary.loops.is_empty()) {
        return false;
    }
    let plane = Plane::of(triangles, positions);
    let at = |node: u32| positions[node as usize];
    triangles.iter().all(|corners| plane.area(corners.map(at)) > 0.0)
        && boundary.get_or_insert_with(|| Boundary::of(triangles)).winds_once(plane, positions)
}

impl Boundary {
    fn of(triangles: &[[u32; 3]]) -> Self {
        let directed = |number: u32| {
            let (corners, k) = (triangles[number as usize / 3], number as usize % 3);
            [corners[k], corners[(k + 1) % 3]]
        };
        let (mut open, mut before): (Vec<[u32; 2]>, Option<[u32; 2]>) = (Vec::new(), None);
        // A side is followed by the same one in the other direction, or is of the boundary.
        in_order(sides_of(triangles), |_, number| {
            let side = directed(number);
            match before.take() {
                Some([a, b]) if side == [b, a] => {}
                last => {
                    open.extend(last);
                    before = Some(side);
                }
            }
        });
        open.extend(before);
        open.sort_unstable();
        Boundary { loops: loops(&open).unwrap_or_default() }
    }

    /// Whether its loops neither cross nor touch in a plane, and one alone is an outer one.
    fn winds_once(&self, plane: Plane, positions: &[[f64; 3]]) -> bool {
        let at = |node: u32| plane.point(positions[node as usize]);
        let sides: Vec<[u32; 2]> = self.loops.iter().flat_map(|nodes| sides_of_loop(nodes)).collect();
        // Far from the origin the margin of boxes would be lost in rounding; what meets still does.
        let Some(origin) = sides.first().map(|side| at(side[0])) else { return false };
        let flat = |node: u32| [at(node).x - origin.x, at(node).y - origin.y, 0.0];
        let around = |side: &[u32; 2]| Bounds::of(&side.map(flat));
        let extent = sides.iter().map(around).fold(Bounds::EMPTY, Bounds::joined).extent();
        let outer = |nodes: &&Vec<u32>| {
            let start = at(nodes[0]);
            let twice = sides_of_loop(nodes).map(|side| {
                let [a, b] = side.map(|node| [at(node).x - start.x, at(node).y - start.y]);
                a[0] * b[1] - a[1] * b[0]
            });
            let is_hole = plane.side * twice.sum::<f64>() < -NEAR * extent * extent;
            !is_hole
        };
        if self.loops.iter().filter(outer).count() != 1 {
            return false;
        }
        let tree = BoxTree::of(sides.len(), |side| around(&sides[side as usize]).grown(NEAR * extent));
        let (mut looks, mut meet) = (LOOKS * (1000 + sides.len() as u64), false);
        tree.pairs(&mut looks, |a, b, looks| {
            if !apart([sides[a as usize], sides[b as usize]], at) {
                (meet, *looks) = (true, 0);
            }
        });
        !meet && looks > 0
    }
}

/// Sides in loops, by the nodes of each; `None` if two begin at a node, or one ends where none begins.
fn loops(sides: &[[u32; 2]]) -> Option<Vec<Vec<u32>>> {
    if sides.windows(2).any(|pair| pair[0][0] == pair[1][0]) {
        return None;
    }
    let (mut seen, mut loops) = (vec![false; sides.len()], Vec::new());
    for first in 0..sides.len() {
        let (mut nodes, mut side) = (Vec::new(), first);
        while !std::mem::replace(&mut seen[side], true) {
            let [from, to] = sides[side];
            nodes.push(from);
            side = sides.binary_search_by_key(&to, |side| side[0]).ok()?;
        }
        if !nodes.is_empty() {
            loops.push(nodes);
        }
    }
    Some(loops)
}

fn sides_of_loop(nodes: &[u32]) -> impl Iterator<Item = [u32; 2]> {
    nodes.iter().zip(nodes.iter().cycle().skip(1)).map(|(a, b)| [*a, *b])
}

/// Whether two sides have no point in common, but for a node that both have. Collinear ones count as not apart.
fn apart([[a, b], [c, d]]: [[u32; 2]; 2], at: impl Fn(u32) -> Coord<f64>) -> bool {
    let sign = |nodes: [u32; 3]| {
        let [p, q, r] = nodes.map(&at);
        let area = orient2d(p, q, r);
        i8::from(area > 0.0) - i8::from(area < 0.0)
    };
    if b == c || a == d {
        let [before, node, after] = if b == c { [a, b, d] } else { [c, a, b] };
        let [p, x, q] = [before, node, after].map(&at);
        // Straight on, but not back.
        return sign([before, node, after]) != 0 || (p.x - x.x) * (q.x - x.x) + (p.y - x.y) * (q.y - x.y) < 0.0;
    }
    sign([a, b, c]) * sign([a, b, d]) > 0 || sign([c, d, a]) * sign([c, d, b]) > 0
}
