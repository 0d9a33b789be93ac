//! Seam allowances: sides of a polygon are moved inwards, each by a width of its own.
//!
//! Crates that offset polygons, as `cavalier_contours` or `i_overlay`, move all sides by one width.

use nalgebra::Vector2;

/// [-] Sine of the angle up to which sides are parallel.
const PARALLEL: f64 = 1e-6;
/// Most sides that are tested against each other; the filling of more finds crossings too.
const MOST_TESTED: usize = 5000;

/// The polygon, counter-clockwise, whose sides are moved inwards; side i leads from point i to the next one. Points
/// keep their order.
///
/// # Errors
/// The number of the side that cannot be moved, and why.
pub(super) fn inset(points: &[Vector2<f64>], widths: &[f64]) -> Result<Vec<Vector2<f64>>, (usize, &'static str)> {
    let n = points.len();
    let along = |i: usize| (points[(i + 1) % n] - points[i]).normalize();
    let mut moved = Vec::with_capacity(n);
    for i in 0..n {
        let before = (i + n - 1) % n;
        let [d, e] = [along(before), along(i)];
        let [w, v] = [widths[before], widths[i]];
        let side = if v > 0.0 { i } else { before };
        let (sine, inwards) = (d.perp(&e), |d: Vector2<f64>| Vector2::new(-d.y, d.x));
        if w == v && d.dot(&e) > 0.0 && sine.abs() <= PARALLEL {
            moved.push(points[i] + w * inwards(e));
        } else if sine.abs() <= PARALLEL {
            return Err((side, "its end is no corner"));
        } else {
            // Where the two moved lines cross.
            let [p, q] = [points[i] + w * inwards(d), points[i] + v * inwards(e)];
            moved.push(p + (q - p).perp(&e) / sine * d);
        }
    }
    let turned = |i: usize| (moved[(i + 1) % n] - moved[i]).dot(&along(i)) <= 0.0;
    if let Some(i) = (0..n).find(|i| turned(*i)) {
        return Err((i, "nothing is left of the outline"));
    }
    match (n <= MOST_TESTED).then(|| crossed(&moved)).flatten() {
        Some(i) => Err((i, "the seam line crosses the outline on the other side")),
        None => Ok(moved),
    }
}

/// The first side that crosses another one which is not its neighbour.
fn crossed(points: &[Vector2<f64>]) -> Option<usize> {
    let n = points.len();
    let side = |i: usize| [points[i], points[(i + 1) % n]];
    let left = |[a, b]: [Vector2<f64>; 2], p: Vector2<f64>| (b - a).perp(&(p - a)) > 0.0;
    let apart = |s: [Vector2<f64>; 2], t: [Vector2<f64>; 2]| left(s, t[0]) == left(s, t[1]);
    (0..n).find(|&i| {
        let others = (i + 2..n).filter(|j| (j + 1) % n != i);
        others.into_iter().any(|j| !apart(side(i), side(j)) && !apart(side(j), side(i)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Vec<Vector2<f64>> {
        [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]].map(Vector2::from).to_vec()
    }

    #[test]
    fn each_side_moves_by_its_own_width() {
        let moved = inset(&square(), &[0.0, 1.0, 0.5, 0.25]).expect("inset");
        assert_eq!(moved, [[0.25, 0.0], [3.0, 0.0], [3.0, 2.5], [0.25, 2.5]].map(Vector2::from));
    }

    #[test]
    fn too_wide_allowances_are_refused() {
        assert_eq!(inset(&square(), &[0.0, 2.0, 0.0, 2.0]), Err((0, "nothing is left of the outline")));
        let mut halves = square();
        halves.insert(1, Vector2::new(2.0, 0.0));
        assert_eq!(inset(&halves, &[0.0, 0.1, 0.0, 0.0, 0.0]), Err((1, "its end is no corner")));
        // A waist narrower than both allowances.
        let waist = [
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 2.0],
            [2.2, 2.5],
            [4.0, 3.0],
            [4.0, 5.0],
            [0.0, 5.0],
            [0.0, 3.0],
            [1.8, 2.5],
            [0.0, 2.0],
        ];
        let waist = waist.map(Vector2::from);
        let why = "the seam line crosses the outline on the other side";
        assert_eq!(inset(&waist, &[0.3; 10]).map_err(|(_, why)| why), Err(why));
    }
}
