//! The distance of two triangles, segments or points.

use crate::contact::distance::{PairKind, nearest};
use nalgebra::Vector3;

/// A point of space.
type Point = Vector3<f64>;

/// [m] The distance of two elements of one, two or three corners; 0 where they cross.
pub(super) fn between([a, b]: [&[Point]; 2]) -> f64 {
    let mut least = f64::INFINITY;
    for [of, to] in [[a, b], [b, a]] {
        least = of.iter().map(|x| from_point(*x, to)).fold(least, f64::min);
        if let &[p, q, r] = to
            && sides(of).any(|side| pierces(side, [p, q, r]))
        {
            return 0.0;
        }
    }
    let pairs = sides(a).flat_map(|[p, q]| sides(b).map(move |[r, s]| [p, q, r, s]));
    pairs.map(|ends| nearest(PairKind::EdgeEdge, &ends).distance).fold(least, f64::min)
}

/// The segments of an element.
fn sides(of: &[Point]) -> impl Iterator<Item = [Point; 2]> + '_ {
    let count = if of.len() == 3 { 3 } else { of.len() / 2 };
    (0..count).map(|k| [of[k], of[(k + 1) % of.len()]])
}

/// [m] The distance of a point from an element.
fn from_point(x: Point, of: &[Point]) -> f64 {
    let (kind, nodes) = match *of {
        [a, b, c] => (PairKind::NodeTriangle, [x, a, b, c]),
        [a, b] => (PairKind::NodeEdge, [x, a, b, b]),
        _ => (PairKind::NodeNode, [x, of.first().copied().unwrap_or(x), x, x]),
    };
    nearest(kind, &nodes).distance
}

/// Whether a segment passes through a triangle.
fn pierces([p, q]: [Point; 2], [a, b, c]: [Point; 3]) -> bool {
    let volume = |x: Point, y: Point, z: Point, w: Point| (x - w).dot(&(y - w).cross(&(z - w)));
    let [one, other] = [p, q].map(|end| volume(a, b, c, end));
    let around = [[a, b], [b, c], [c, a]].map(|[from, to]| volume(from, to, p, q));
    one * other < 0.0 && (around.iter().all(|x| *x > 0.0) || around.iter().all(|x| *x < 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::random::SplitMix64;

    /// Points of an element on a grid of its barycentric coordinates.
    fn points(of: &[Point], n: u32) -> Vec<Point> {
        let share = |i: u32| f64::from(i) / f64::from(n);
        match *of {
            [a, b, c] => {
                let grid = (0..=n).flat_map(|i| (0..=n - i).map(move |j| [i, j]));
                grid.map(|[i, j]| a + (b - a) * share(i) + (c - a) * share(j)).collect()
            }
            [a, b] => (0..=n).map(|i| a + (b - a) * share(i)).collect(),
            _ => of.to_vec(),
        }
    }

    /// The distance is not above that of any two of many points, and by no more than their spacing below the least.
    #[test]
    fn distances_are_those_of_many_points() {
        let mut random = SplitMix64::new(11, 0);
        let n = 48;
        let mut crossed = 0;
        for round in 0..400 {
            let counts = [1 + round % 3, 1 + round / 3 % 3];
            let [a, b] = counts.map(|count| {
                (0..count).map(|_| Point::from([0; 3].map(|_| 2.0 * random.uniform() - 1.0))).collect::<Vec<Point>>()
            });
            let found = between([&a, &b]);
            let (of_a, of_b) = (points(&a, n), points(&b, n));
            let all = of_a.iter().flat_map(|x| of_b.iter().map(move |y| (x - y).norm()));
            let least = all.fold(f64::INFINITY, f64::min);
            let spacing = 2.0 * 2.0 * 3.0_f64.sqrt() / f64::from(n);
            assert!(found <= least + 1e-12 && found >= least - spacing, "{counts:?}: {found} {least}");
            crossed += usize::from(found == 0.0);
        }
        assert!(crossed > 5, "{crossed}");
    }
}
