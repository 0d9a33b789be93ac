//! Order along Hilbert's curve (1891): points near each other in the plane mostly follow each other in the order, and
//! in memory.

use nalgebra::Vector2;

/// Number of cells per side, as a power of two: finer than the edges of any mesh that fits into memory.
const BITS: u32 = 16;

/// The place of a point on the curve that fills the square [-half, half]^2 [m].
pub(super) fn place(point: Vector2<f64>, half: f64) -> u32 {
    let cells = f64::from(1_u32 << BITS);
    // The conversion clamps values outside, and turns NaN into 0.
    let cell = |c: f64| ((0.5 + 0.5 * c / half) * cells).min(cells - 1.0) as u32;
    let (mut x, mut y, mut along) = (cell(point.x), cell(point.y), 0);
    for bit in (0..BITS).rev() {
        let (right, upper) = (x >> bit & 1, y >> bit & 1);
        along = along << 2 | (3 * right) ^ upper;
        // The first and last quarters are turned, so that each quarter begins where the one before ends.
        if upper == 0 {
            let last = (1 << bit) - 1;
            if right == 1 {
                (x, y) = (!x & last, !y & last);
            }
            (x, y) = (y, x);
        }
    }
    along
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All cells of a grid are on the curve once, and neighbours on it are neighbours in the plane.
    #[test]
    fn it_fills_a_grid_by_steps_to_a_neighbour() {
        let n = 32;
        let centre = |i: i32| (f64::from(i) + 0.5) / f64::from(n) * 2.0 - 1.0;
        let mut cells: Vec<(u32, [i32; 2])> =
            (0..n * n).map(|i| (place(Vector2::new(centre(i % n), centre(i / n)), 1.0), [i % n, i / n])).collect();
        cells.sort_unstable();
        for pair in cells.windows(2) {
            let [(a, [x, y]), (b, [u, v])] = [pair[0], pair[1]];
            assert!(a < b, "two cells at {a}");
            assert_eq!((x - u).abs() + (y - v).abs(), 1, "{pair:?}");
        }
    }
}
