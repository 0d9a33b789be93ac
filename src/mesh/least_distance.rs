//! The least distance between cloth and lines that share no node.

use super::box_tree::{Bounds, BoxTree};
use nalgebra::Vector3;

/// [-] Pairs of boxes that a search may compare, for each part.
const LOOKS: u64 = 10_000;

/// A triangle, or an edge by its two nodes.
#[derive(Clone, Copy, Debug)]
enum Part {
    Triangle([u32; 3]),
    Edge([u32; 2]),
}

impl Part {
    fn nodes(&self) -> &[u32] {
        match self {
            Part::Triangle(nodes) => nodes,
            Part::Edge(nodes) => nodes,
        }
    }

    fn sides(&self) -> Vec<[u32; 2]> {
        match *self {
            Part::Triangle([a, b, c]) => vec![[a, b], [b, c], [c, a]],
            Part::Edge(nodes) => vec![nodes],
        }
    }
}

/// [m] The least distance between two of these triangles and edges that share no node, at these places [m]; 0 where
/// one passes through the other. `None` where all share nodes, or where the search would take too long. The search is
/// for what is near: it widens its boxes until it finds a pair.
pub fn least_distance(positions: &[[f64; 3]], triangles: &[[u32; 3]], edges: &[[u32; 2]]) -> Option<f64> {
    let parts = triangles.iter().map(|t| Part::Triangle(*t)).chain(edges.iter().map(|e| Part::Edge(*e)));
    let parts: Vec<Part> = parts.collect();
    let at = |node: u32| Vector3::from(positions[node as usize]);
    let bounds: Vec<Bounds> =
        parts.iter().map(|part| Bounds::of(part.nodes().iter().map(|&node| &positions[node as usize]))).collect();
    let size = bounds.iter().copied().fold(Bounds::EMPTY, Bounds::joined).extent();
    if parts.len() < 2 || !(size > 0.0 && size.is_finite()) {
        return None;
    }
    let mut looks = LOOKS * parts.len() as u64;
    let mut near = 1e-3 * size;
    loop {
        let grown: Vec<Bounds> = bounds.iter().map(|bounds| bounds.grown(0.5 * near)).collect();
        let mut least = f64::INFINITY;
        BoxTree::new(&grown).pairs(&mut looks, |a, b, _| {
            let least_of_boxes = apart(&bounds[a as usize], &bounds[b as usize]);
            let [a, b] = [&parts[a as usize], &parts[b as usize]];
            if least_of_boxes < least && !a.nodes().iter().any(|node| b.nodes().contains(node)) {
                least = least.min(between(a, b, &at));
            }
        });
        if looks == 0 {
            return None;
        }
        // What is farther than the boxes were grown may have a nearer pair that was not looked at.
        if least <= near || near > 2.0 * size {
            return Some(least).filter(|least| least.is_finite());
        }
        near *= 2.0;
    }
}

/// [m] The distance of two boxes.
fn apart(a: &Bounds, b: &Bounds) -> f64 {
    let gap = |k: usize| (a.low[k] - b.high[k]).max(b.low[k] - a.high[k]).max(0.0);
    Vector3::new(gap(0), gap(1), gap(2)).norm()
}

fn between(a: &Part, b: &Part, at: &dyn Fn(u32) -> Vector3<f64>) -> f64 {
    let (of_a, of_b) = (a.sides(), b.sides());
    let pairs = of_a.iter().flat_map(|s| of_b.iter().map(move |t| (s, t)));
    let sides = pairs.map(|(s, t)| of_segments(s.map(at), t.map(at))).fold(f64::INFINITY, f64::min);
    let above = [(a, b), (b, a)].into_iter().filter_map(|(triangle, other)| match triangle {
        Part::Triangle(corners) => Some(of_triangle(corners.map(at), other, at)),
        Part::Edge(_) => None,
    });
    above.fold(sides, f64::min)
}

/// [m] The least distance of nodes above a triangle, 0 if a side passes through it; infinite if there are neither.
fn of_triangle(corners: [Vector3<f64>; 3], other: &Part, at: &dyn Fn(u32) -> Vector3<f64>) -> f64 {
    let [a, b, c] = corners;
    let normal = (b - a).cross(&(c - a));
    let area = normal.norm();
    if area == 0.0 {
        return f64::INFINITY;
    }
    let normal = normal / area;
    let inside =
        |x: Vector3<f64>| [[a, b], [b, c], [c, a]].iter().all(|[p, q]| (q - p).cross(&(x - p)).dot(&normal) >= 0.0);
    let height = |x: Vector3<f64>| (x - a).dot(&normal);
    let above = other.nodes().iter().map(|&node| at(node)).filter(|x| inside(*x)).map(|x| height(x).abs());
    let through = other.sides().iter().any(|side| {
        let [p, q] = side.map(at);
        let [from, to] = [height(p), height(q)];
        from * to < 0.0 && inside(p + (q - p) * (from / (from - to)))
    });
    if through { 0.0 } else { above.fold(f64::INFINITY, f64::min) }
}

/// [m] The distance of two segments (Ericson, *Real-time collision detection*, 2005, section 5.1.9).
fn of_segments([p, p_end]: [Vector3<f64>; 2], [q, q_end]: [Vector3<f64>; 2]) -> f64 {
    let (d, e, r) = (p_end - p, q_end - q, p - q);
    let [dd, ee, de, dr, er] = [d.dot(&d), e.dot(&e), d.dot(&e), d.dot(&r), e.dot(&r)];
    let part = |above: f64, below: f64| if below > 0.0 { (above / below).clamp(0.0, 1.0) } else { 0.0 };
    let s = part(de * er - dr * ee, dd * ee - de * de);
    let t = part(de * s + er, ee);
    // The best place on the first for the place on the second, which may have been held at an end.
    let s = part(de * t - dr, dd);
    (r + d * s - e * t).norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distances of two triangles that are known, and of a triangle from a line.
    #[test]
    fn distances_are_the_known_ones() {
        let flat = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let cases = [
            // Above each other; beside each other; a corner above the inside; a side through the inside.
            ([[0.0, 0.0, 0.3], [1.0, 0.0, 0.3], [0.0, 1.0, 0.3]], 0.3),
            ([[1.5, 0.0, 0.0], [2.5, 0.0, 0.0], [1.5, 1.0, 0.0]], 0.5),
            ([[0.2, 0.2, 0.1], [0.2, 0.2, 5.0], [0.3, 0.2, 5.0]], 0.1),
            ([[0.2, 0.2, -1.0], [0.2, 0.2, 1.0], [0.2, 0.3, 1.0]], 0.0),
        ];
        for (other, distance) in cases {
            let places = [flat, other].concat();
            let found = least_distance(&places, &[[0, 1, 2], [3, 4, 5]], &[]).expect("a distance");
            assert!((found - distance).abs() < 1e-15, "{found} for {distance}");
        }
        let line = [flat.to_vec(), vec![[-1.0, -1.0, 0.4], [1.0, 1.0, 0.4], [0.9, 2.0, 0.0]]].concat();
        assert_eq!(least_distance(&line, &[[0, 1, 2]], &[[3, 4]]), Some(0.4));
        assert_eq!(least_distance(&line, &[[0, 1, 2]], &[[0, 4], [1, 2]]).map(|d| d > 0.0), Some(true));
        assert_eq!(least_distance(&line, &[[0, 1, 2]], &[]), None);
    }
}
