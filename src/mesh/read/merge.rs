//! Joins nodes that lie at one place.

use nalgebra::Vector3;
use std::hash::{BuildHasher, RandomState};

/// For each point its own number, or that of the earlier point that it is joined to: the nearest one that is kept and
/// at most `distance` [m] away, the earliest of several. Joined points are never farther than that from the kept one.
pub(crate) fn joined(points: &[[f64; 3]], distance: f64) -> Vec<u32> {
    let cells = Cells { distance, size: CELL * distance };
    let mut kept = Table::for_items(points.len());
    let mut of_point = Vec::with_capacity(points.len());
    for (point, number) in points.iter().zip(0..) {
        // The distance of the best so far, and its number.
        let mut best: Option<(f64, u32)> = None;
        cells.around(point, |key| {
            for other in kept.items(key) {
                let place = &points[other as usize];
                let away = (Vector3::from(*place) - Vector3::from(*point)).norm();
                let near = if distance > 0.0 { away <= distance } else { place == point };
                if near && best.is_none_or(|best| (away, other) < best) {
                    best = Some((away, other));
                }
            }
        });
        if best.is_none() {
            kept.insert(cells.home(point), number);
        }
        of_point.push(best.map_or(number, |(_, earlier)| earlier));
    }
    of_point
}

/// [-] Edge of a cell over the distance within which points are joined. A larger one holds more points, a smaller one
/// has more neighbours to be looked into.
const CELL: f64 = 4.3;

/// Cells of space.
struct Cells {
    /// [m] within which neighbours are wanted
    distance: f64,
    /// [m] edge; without one every place is a cell of its own
    size: f64,
}

impl Cells {
    fn along(&self, x: f64) -> u64 {
        // The half keeps what lies in a plane of coordinates away from the sides of cells.
        let cell = if self.size > 0.0 { floor(x / self.size + 0.5) } else { x };
        // Adding zero turns -0 into 0.
        (cell + 0.0).to_bits()
    }

    fn home(&self, point: &[f64; 3]) -> [u64; 3] {
        point.map(|x| self.along(x))
    }

    /// Calls `visit` with each cell that may hold a point near this one.
    fn around(&self, point: &[f64; 3], mut visit: impl FnMut([u64; 3])) {
        // More than the rounding of a distance.
        let reach = self.distance * (1.0 + 1e-9);
        let low = point.map(|x| self.along(x - reach));
        let high = point.map(|x| self.along(x + reach));
        let choices = |k: usize| if low[k] == high[k] { 1 } else { 2 };
        for x in &[low[0], high[0]][..choices(0)] {
            for y in &[low[1], high[1]][..choices(1)] {
                for z in &[low[2], high[2]][..choices(2)] {
                    visit([*x, *y, *z]);
                }
            }
        }
    }
}

/// The largest whole number that is not above a number: without a call, which `f64::floor` is on many machines.
fn floor(x: f64) -> f64 {
    const WHOLE: f64 = (1_u64 << 52) as f64;
    let cut = x as i64 as f64;
    match x.abs() < WHOLE {
        true if cut > x => cut - 1.0,
        true => cut,
        // It has no other digits, or is no number.
        false => x,
    }
}

/// Numbers in lists by keys. Keys are not kept: a list may have numbers of other keys too.
pub(super) struct Table {
    /// the latest number of each list; their number is a power of two
    heads: Vec<u32>,
    /// each number, and the place of the one before it in its list
    items: Vec<[u32; 2]>,
    /// a bit for each of [`Table::BITS`] times as many keys: whether one of them has numbers. They stay in the caches
    /// where the lists do not.
    used: Vec<u64>,
    /// differs from table to table, so that no file can put all into one list
    seed: u64,
}

/// No place.
const END: u32 = u32::MAX;

impl Table {
    const BITS: usize = 16;

    /// A table that is fast up to about so many items.
    pub(super) fn for_items(count: usize) -> Self {
        let seed = RandomState::new().hash_one(count) | 1;
        let lists = count.next_power_of_two();
        let used = vec![0; (Self::BITS * lists).div_ceil(64)];
        Table { heads: vec![END; lists], items: Vec::new(), used, seed }
    }

    /// The list of a key, and its bit.
    fn list(&self, key: [u64; 3]) -> (usize, usize) {
        let mixed = |all: u64, word: u64| {
            let product = u128::from(all ^ word) * u128::from(self.seed);
            product as u64 ^ (product >> 64) as u64
        };
        let mix = mixed(key.into_iter().fold(self.seed >> 32, mixed), 0x9e37_79b9_7f4a_7c15) as usize;
        (mix & (self.heads.len() - 1), mix & (64 * self.used.len() - 1))
    }

    pub(super) fn insert(&mut self, key: [u64; 3], item: u32) {
        let (list, bit) = self.list(key);
        self.items.push([item, self.heads[list]]);
        self.heads[list] = self.items.len() as u32 - 1;
        self.used[bit / 64] |= 1 << (bit % 64);
    }

    /// The numbers of a key, the latest first, among others.
    pub(super) fn items(&self, key: [u64; 3]) -> impl Iterator<Item = u32> {
        let (list, bit) = self.list(key);
        let is_used = self.used[bit / 64] >> (bit % 64) & 1 == 1;
        let mut at = if is_used { self.heads[list] } else { END };
        std::iter::from_fn(move || {
            let [item, before] = *self.items.get(at as usize)?;
            at = before;
            Some(item)
        })
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
