//! The distance of two triangles, segments or points.

use nalgebra::Vector3;

/// A point of space.
type Point = Vector3<f64>;

/// [m] The distance of two elements of one, two or three corners; 0 where they cross.
pub(super) fn between([a, b]: [&[Point]; 2]) -> f64 {
    let mut least = f64::INFINITY;
    for [of, to] in [[a, b], [b, a]] {
        least = of.iter().map(|x| (x - nearest(*x, to)).norm()).fold(least, f64::min);
        if let &[p, q, r] = to
            && sides(of).any(|side| pierces(side, [p, q, r]))
        {
            return 0.0;
        }
    }
    let pairs = sides(a).flat_map(|side| sides(b).map(move |other| [side, other]));
    pairs.map(of_segments).fold(least, f64::min)
}

/// The segments of an element.
fn sides(of: &[Point]) -> impl Iterator<Item = [Point; 2]> + '_ {
    let count = if of.len() == 3 { 3 } else { of.len() / 2 };
    (0..count).map(|k| [of[k], of[(k + 1) % of.len()]])
}

/// The point of an element that is nearest to a point.
fn nearest(x: Point, of: &[Point]) -> Point {
    match *of {
        [a, b, c] => {
            let normal = (b - a).cross(&(c - a));
            let within = |from: Point, to: Point| (to - from).cross(&(x - from)).dot(&normal) >= 0.0;
            if normal.norm_squared() > 0.0 && within(a, b) && within(b, c) && within(c, a) {
                return x - normal * ((x - a).dot(&normal) / normal.norm_squared());
            }
            let on_sides = sides(of).map(|side| on_segment(x, side));
            on_sides.reduce(|p, q| if (x - q).norm() < (x - p).norm() { q } else { p }).unwrap_or(a)
        }
        [a, b] => on_segment(x, [a, b]),
        _ => of.first().copied().unwrap_or(x),
    }
}

fn on_segment(x: Point, [from, to]: [Point; 2]) -> Point {
    let along = to - from;
    let share = (x - from).dot(&along) / along.norm_squared();
    // Of a segment without length the share is not a number, and its end is as near as any.
    if share > 0.0 { from + along * share.min(1.0) } else { from }
}

/// [m] The distance of the insides of two segments; infinite where ends are nearer, which other distances tell.
fn of_segments([[p, q], [r, s]]: [[Point; 2]; 2]) -> f64 {
    let (u, v, w) = (q - p, s - r, r - p);
    let normal = u.cross(&v);
    let size = normal.norm_squared();
    let [on_first, on_second] = [w.cross(&v).dot(&normal) / size, w.cross(&u).dot(&normal) / size];
    let inside = |share: f64| (0.0..=1.0).contains(&share);
    if inside(on_first) && inside(on_second) { w.dot(&normal).abs() / size.sqrt() } else { f64::INFINITY }
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
