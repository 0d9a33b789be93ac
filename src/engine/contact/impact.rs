//! How far a pair of elements may move before it touches: conservative advancement (Mirtich 1996, "Impulse-based
//! dynamic simulation", section 2.3; Li et al. 2021, "Codimensional incremental potential contact", algorithm 1).
//!
//! Elements are convex and nodes move on lines, x_j + s d_j. Two bounds of the distance say how far it is safe to go
//! on: it falls by no more than s max |d_i - d_j|, over nodes i of the first and j of the second element; and with n
//! the unit vector between the closest points it stays above min n . (x_i - x_j + s (d_i - d_j)), the slab that parts
//! them. The longer of the two ways is gone, again and again, until the distance is down to what is to be left.
//! Differences of displacements alone count: what moves as one is free.

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

/// The share [-] of the displacement, in [0, 1], up to which the pair keeps at least `left` [-], above 0 and below 1,
/// of its present distance beyond the thickness; `None` where the whole way is free. A pair that is nearer than the
/// thickness already may part, but not come nearer. At the share the distance is down to 1.01 times what is to be left,
/// unless it took more than 1000 rounds to get there.
pub fn free_share(approach: &Approach, left: f64) -> Option<f64> {
    let pair = Pair::new(approach);
    let (distance, speed) = (nearest(pair.kind, &pair.x).distance, pair.speed());
    if !pair.is_finite() {
        return Some(0.0);
    }
    if speed == 0.0 {
        return None;
    }
    let gap = (distance - approach.thickness).max(0.0);
    let target = distance - (1.0 - left) * gap;
    let mut share = 0.0;
    for _ in 0..ROUNDS {
        let x = pair.at(share);
        let found = nearest(pair.kind, &x);
        let surplus = found.distance - target;
        let way = ((surplus - pair.rounding) / speed).max(pair.way(&x, &found.normal(), target));
        if share + way > 1.0 {
            return None;
        }
        if surplus <= SLACK * left * gap || share + way <= share {
            break;
        }
        share += way;
    }
    Some(share)
}

/// The pair with its motion relative to node 0.
struct Pair {
    kind: PairKind,
    x: [Vector3<f64>; 4],
    d: [Vector3<f64>; 4],
    /// [m] that of a distance on the way
    rounding: f64,
}

impl Pair {
    fn new(approach: &Approach) -> Self {
        let Approach { kind, x, d, .. } = *approach;
        let (x, d) = (x.map(|y| y - x[0]), d.map(|e| e - d[0]));
        let reach = x.iter().zip(&d).take(kind.nodes()).map(|(x, d)| x.amax() + d.amax());
        Self { kind, x, d, rounding: ROUNDING * reach.fold(0.0, f64::max) }
    }

    fn is_finite(&self) -> bool {
        let mut nodes = self.x.iter().zip(&self.d).take(self.kind.nodes());
        nodes.all(|(x, d)| x.iter().chain(d).all(|number| number.is_finite()))
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

    /// The share that the slab normal to `n` allows to go on from `x`, until it is `target` wide.
    fn way(&self, x: &[Vector3<f64>; 4], n: &Vector3<f64>, target: f64) -> f64 {
        let mut way = f64::INFINITY;
        for (x, d) in self.between(x).zip(self.between(&self.d)) {
            let (width, change) = (x.dot(n), d.dot(n));
            if change < 0.0 {
                way = way.min((width - self.rounding - target) / -change);
            } else if width < target - self.rounding {
                return 0.0;
            }
        }
        way
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::random::SplitMix64;

    const KINDS: [PairKind; 4] = [PairKind::NodeNode, PairKind::NodeEdge, PairKind::NodeTriangle, PairKind::EdgeEdge];

    fn random(draw: &mut SplitMix64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| 2.0 * draw.uniform() - 1.0)
    }

    /// Elements that fly towards each other, turn, and are sometimes thin, far away or fast.
    fn approach(draw: &mut SplitMix64, n: usize) -> Approach {
        let (apart, towards) = (random(draw) * 2.0, -2.5 * draw.uniform());
        let first = KINDS[n % 4].nodes_of_first();
        let of_first = |j: usize, v: Vector3<f64>| if j < first { v } else { Vector3::zeros() };
        let size = [1.0, 0.3, 1e-3][n / 4 % 3];
        let drift = random(draw) * [0.0, 10.0][n / 12 % 2];
        let x = std::array::from_fn(|j| random(draw) * size + of_first(j, apart));
        let d = std::array::from_fn(|j| random(draw) * size + of_first(j, apart * towards) + drift);
        Approach { kind: KINDS[n % 4], x, d, thickness: [0.0, 1e-3, 0.05][n / 24 % 3] }
    }

    fn distance(approach: &Approach, share: f64) -> f64 {
        let x = std::array::from_fn(|j| approach.x[j] + approach.d[j] * share);
        nearest(approach.kind, &x).distance
    }

    /// On the way the distance stays what it should, and at its end it is down to that: it neither overshoots nor stops
    /// early.
    #[test]
    fn the_share_is_free_and_the_longest_one() {
        let mut draw = SplitMix64::of_seed(1);
        let (mut free, mut met, mut near) = (0, 0, 0);
        for n in 0..100_000 {
            let approach = approach(&mut draw, n);
            let gap = distance(&approach, 0.0) - approach.thickness;
            if gap <= 0.0 {
                near += 1;
                continue;
            }
            let left = [0.2, 0.5, 0.01][n / 7 % 3];
            let share = free_share(&approach, left);
            let target = approach.thickness + left * gap;
            let end = share.unwrap_or(1.0);
            let samples = 8;
            for i in 0..=samples {
                let at = distance(&approach, end * i as f64 / samples as f64);
                assert!(at >= target * (1.0 - 1e-9), "{at} at {i} of {end}, {target} to be left: {approach:?}");
            }
            match share {
                None => free += 1,
                Some(share) => {
                    met += 1;
                    let there = distance(&approach, share);
                    let most = target + 0.0101 * left * gap;
                    assert!(share > 0.0 && there <= most, "{there} at {share}, {target} to be left: {approach:?}");
                }
            }
        }
        assert!(free > 10_000 && met > 10_000 && near < 10_000, "{free} {met} {near}");
    }

    /// A node that falls by 4 m on a triangle 1 m below, which it reaches after a quarter of the way.
    fn falls(thickness: f64) -> Approach {
        let x = [[0.1, 0.2, 1.0], [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]].map(Vector3::from);
        let down = Vector3::new(0.0, 0.0, -4.0);
        let d = [down, Vector3::zeros(), Vector3::zeros(), Vector3::zeros()];
        Approach { kind: PairKind::NodeTriangle, x, d, thickness }
    }

    #[test]
    fn a_fall_ends_where_the_closed_form_says() {
        for (thickness, left) in [(0.0, 0.2), (0.1, 0.2), (0.1, 0.001)] {
            let share = free_share(&falls(thickness), left).expect("it meets");
            let expected = (1.0 - left) * (1.0 - thickness) / 4.0;
            assert!(share <= expected && share > expected - 1e-13, "{share} for {expected}");
        }
    }

    #[test]
    fn what_moves_as_one_or_parts_is_free() {
        let mut approach = falls(0.1);
        approach.d = [Vector3::new(3.0, -1.0, -50.0); 4];
        assert_eq!(free_share(&approach, 0.2), None);
        // Nearer than the thickness: it may part, not come nearer.
        let mut parts = falls(2.0);
        assert_eq!(free_share(&parts, 0.2), Some(0.0));
        parts.d[0] *= -1.0;
        assert_eq!(free_share(&parts, 0.2), None);
    }

    #[test]
    fn what_touches_or_is_no_number_goes_nowhere() {
        let mut approach = falls(0.0);
        approach.x[0].z = 0.0;
        assert_eq!(free_share(&approach, 0.2), Some(0.0));
        approach.x[3].z = f64::NAN;
        assert_eq!(free_share(&approach, 0.2), Some(0.0));
        let mut approach = falls(0.0);
        approach.d[2].x = f64::INFINITY;
        assert_eq!(free_share(&approach, 0.2), Some(0.0));
    }
}
