//! Joins nodes that lie at one place.

use nalgebra::Vector3;
use std::collections::HashMap;

/// For each point its own number, or that of the earlier point that it is joined to: the nearest one that is kept and
/// at most `distance` [m] away, the earliest of several. Joined points are never farther than that from the kept one.
pub(crate) fn joined(points: &[[f64; 3]], distance: f64) -> Vec<u32> {
    let mut grid = Grid { cell: 2.0 * distance, cells: HashMap::new(), next: Vec::with_capacity(points.len()) };
    let mut kept = Vec::with_capacity(points.len());
    for (number, point) in points.iter().enumerate() {
        let near = grid.near(points, Vector3::from(*point), distance);
        match near {
            Some(earlier) => {
                grid.next.push(NONE);
                kept.push(earlier);
            }
            None => {
                grid.keep(number as u32, point);
                kept.push(number as u32);
            }
        }
    }
    kept
}

const NONE: u32 = u32::MAX;

/// The points that are kept, in cells of twice the distance, so that what is near a point lies in eight of them.
struct Grid {
    /// [m] edge of a cell
    cell: f64,
    /// the latest point of each cell
    cells: HashMap<[u64; 3], u32>,
    /// the point before each in its cell
    next: Vec<u32>,
}

impl Grid {
    /// A cell by its lower corner; without a distance every place is a cell of its own.
    fn key(&self, point: &[f64; 3]) -> [f64; 3] {
        if self.cell > 0.0 { point.map(|x| (x / self.cell).floor() + 0.0) } else { point.map(|x| x + 0.0) }
    }

    fn keep(&mut self, number: u32, point: &[f64; 3]) {
        let key = self.key(point).map(f64::to_bits);
        self.next.push(self.cells.insert(key, number).unwrap_or(NONE));
    }

    fn near(&self, points: &[[f64; 3]], point: Vector3<f64>, distance: f64) -> Option<u32> {
        let home = self.key(&point.into());
        // The nearer neighbour along each axis.
        let beside: [f64; 3] = std::array::from_fn(|k| if point[k] / self.cell - home[k] < 0.5 { -1.0 } else { 1.0 });
        let mut best: Option<(f64, u32)> = None;
        for corner in 0..if self.cell > 0.0 { 8 } else { 1 } {
            // A point at the same place is the only one there.
            if best.is_some_and(|(away, _)| away == 0.0) {
                break;
            }
            let step = |k: usize| if corner >> k & 1 == 1 { beside[k] } else { 0.0 };
            let key: [u64; 3] = std::array::from_fn(|k| (home[k] + step(k) + 0.0).to_bits());
            let mut at = self.cells.get(&key).copied().unwrap_or(NONE);
            while let Some(other) = points.get(at as usize).filter(|_| at != NONE) {
                let away = (Vector3::from(*other) - point).norm();
                if away <= distance && best.is_none_or(|best| (away, at) < best) {
                    best = Some((away, at));
                }
                at = self.next.get(at as usize).copied().unwrap_or(NONE);
            }
        }
        best.map(|(_, number)| number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against all pairs, for points on both sides of cells and of zero.
    #[test]
    fn joins_as_a_search_of_all_pairs_does() {
        let mut seed = 7_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) as f64 / (1_u64 << 31) as f64 - 0.5
        };
        let points: Vec<[f64; 3]> = (0..400).map(|_| [random(), random(), 0.1 * random()]).collect();
        for distance in [0.0, 0.01, 0.05, 0.2] {
            let mut slow: Vec<u32> = Vec::new();
            for (i, p) in points.iter().enumerate() {
                let kept = (0..i).filter(|j| slow[*j] == *j as u32);
                let away = |j: usize| (Vector3::from(points[j]) - Vector3::from(*p)).norm();
                let near = kept.filter(|j| away(*j) <= distance).min_by(|a, b| away(*a).total_cmp(&away(*b)));
                slow.push(near.unwrap_or(i) as u32);
            }
            assert_eq!(joined(&points, distance), slow, "{distance}");
        }
        assert_eq!(joined(&[[0.0; 3], [-0.0; 3], [1e-300, 0.0, 0.0]], 0.0), [0, 0, 2]);
    }
}
