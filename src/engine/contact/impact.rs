//! How far a pair of elements may move before it touches: conservative advancement (Mirtich 1996, "Impulse-based dynamic
//! simulation", section 2.3; Li et al. 2021, "Codimensional incremental potential contact", algorithm 1).
//!
//! Elements are convex and nodes move on lines, x_j + s d_j. Two bounds of the distance say how far it is safe to go on:
//! it falls by no more than s max |d_i - d_j|, over nodes i of the first and j of the second element; and with n the
//! unit vector between the closest points it stays above min n . (x_i - x_j + s (d_i - d_j)), the slab that parts them.
//! The longer of the two ways is gone, again and again, until the distance is down to what is to be left. Differences
//! of displacements alone count: what moves as one is free.

use super::distance::{PairKind, nearest};
use nalgebra::Vector3;

/// [-] Share of the distance to be left that may be left in addition, for an end.
const SLACK: f64 = 0.01;
/// How often it advances at most. Where it ends earlier than it need, the way found so far is free.
const ROUNDS: usize = 1000;
/// [-] Rounding of a distance over the largest difference of coordinates.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// A pair of elements that move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// which elements
    pub kind: PairKind,
    /// [m] their nodes; places beyond the kind's are not read
    pub x: [Vector3<f64>; 4],
    /// [m] displacements of their nodes
    pub d: [Vector3<f64>; 4],
    /// [m] distance that counts as touching
    pub thickness: f64,
}

/// The share [-] of the displacement, in [0, 1], up to which the pair keeps at least `left` [-], above 0 and below 1, of
/// its present distance beyond the thickness; `None` where the whole way is free. A pair that is nearer than the
/// thickness already may part, but not come nearer. At the share the distance is down to 1.01 times what is to be left,
/// unless it took more than 1000 rounds to get there.
pub fn free_share(approach: &Approach, left: f64) -> Option<f64> {
    let pair = Pair::new(approach);
    let distance = nearest(pair.kind, &pair.x).distance;
    let gap = (distance - approach.thickness).max(0.0);
    let target = distance - (1.0 - left) * gap + ROUNDING * pair.size();
    let speed = pair.speed();
    let mut share = 0.0;
    if speed == 0.0 {
        return None;
    }
    for _ in 0..ROUNDS {
        let x = pair.at(share);
        let found = nearest(pair.kind, &x);
        let surplus = found.distance - target;
        let way = (surplus / speed).max(pair.way(&x, &found.normal(), target));
        // One that is infinite ends here; one that is not a number goes no further.
        if share + way > 1.0 {
            return None;
        }
        let arrived = surplus <= SLACK * left * gap;
        let next = share + way;
        if arrived || next.is_nan() || next <= share {
            break;
        }
        share = next;
    }
    Some(share)
}

/// The pair with its motion relative to node 0.
struct Pair {
    kind: PairKind,
    x: [Vector3<f64>; 4],
    d: [Vector3<f64>; 4],
}

impl Pair {
    fn new(approach: &Approach) -> Self {
        let Approach { kind, x, d, .. } = *approach;
        Self { kind, x: x.map(|y| y - x[0]), d: d.map(|e| e - d[0]) }
    }

    fn at(&self, share: f64) -> [Vector3<f64>; 4] {
        std::array::from_fn(|j| self.x[j] + self.d[j] * share)
    }

    /// Differences between nodes of the first and nodes of the second element.
    fn between<'a>(&self, of: &'a [Vector3<f64>; 4]) -> impl Iterator<Item = Vector3<f64>> + 'a {
        let (first, second) = of[..self.kind.nodes()].split_at(self.kind.nodes_of_first());
        first.iter().flat_map(move |a| second.iter().map(move |b| a - b))
    }

    /// [m] The distance falls by no more than this over the whole displacement.
    fn speed(&self) -> f64 {
        self.between(&self.d).map(|d| d.norm_squared()).fold(0.0, f64::max).sqrt()
    }

    /// [m] largest coordinate on the way
    fn size(&self) -> f64 {
        let nodes = self.x.iter().zip(&self.d).take(self.kind.nodes());
        nodes.map(|(x, d)| x.amax() + d.amax()).fold(0.0, f64::max)
    }

    /// The share that the slab normal to `n` allows to go on from `x`, until it is `target` wide.
    fn way(&self, x: &[Vector3<f64>; 4], n: &Vector3<f64>, target: f64) -> f64 {
        let mut way = f64::INFINITY;
        for (x, d) in self.between(x).zip(self.between(&self.d)) {
            let (width, change) = (x.dot(n), d.dot(n));
            if change < 0.0 {
                way = way.min((width - target) / -change);
            } else if width < target {
                return 0.0;
            }
        }
        way
    }
}
