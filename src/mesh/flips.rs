//! A triangulation that follows moving nodes by edge flips (Lawson 1977), far cheaper than a new triangulation.

use super::sides::{edge_keys, sides_of};
use super::tuples::in_order;
use nalgebra::Vector2;

/// No triangle beyond this side.
const NONE: u32 = u32::MAX;
/// [-] sine of the least excess over 180 degrees of the two angles opposite an edge that is flipped; without it,
/// rounding could flip the edges of a square for ever
const EXCESS: f64 = 1e-9;

/// Triangles with their neighbours.
#[derive(Clone, Debug, Default)]
pub(super) struct Flips {
    triangles: Vec<[u32; 3]>,
    /// triangle beyond the side that starts at each corner
    beyond: Vec<[u32; 3]>,
    /// whether that side must stay
    kept: Vec<[bool; 3]>,
}

impl Flips {
    /// Takes over a triangulation; `constraints` are edges that must stay.
    pub(crate) fn new(triangles: Vec<[u32; 3]>, constraints: &[[usize; 2]]) -> Self {
        let fixed = edge_keys(constraints);
        let mut beyond = vec![[NONE; 3]; triangles.len()];
        let mut kept = vec![[false; 3]; triangles.len()];
        let mut before = ([NONE; 2], 0);
        in_order(sides_of(&triangles), |side, number| {
            let (same, other) = std::mem::replace(&mut before, (side, number));
            if same == side {
                let stays = fixed.binary_search(&side).is_ok();
                for [here, there] in [[number, other], [other, number]] {
                    let (t, s) = (here as usize / 3, here as usize % 3);
                    (beyond[t][s], kept[t][s]) = (there / 3, stays);
                }
            }
        });
        Self { triangles, beyond, kept }
    }

    /// The triangles, counter-clockwise.
    pub(crate) fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Calls `visit` with the edges, each once.
    pub(crate) fn each_edge(&self, mut visit: impl FnMut([u32; 2])) {
        for ((t, corners), beyond) in (0..).zip(&self.triangles).zip(&self.beyond) {
            for side in 0..3 {
                // No triangle has the largest number.
                if t < beyond[side] {
                    visit([corners[side], corners[(side + 1) % 3]]);
                }
            }
        }
    }

    /// Flips edges until the triangulation is Delaunay again; false if a triangle has turned over, or the flips do
    /// not end, and a new triangulation is needed.
    pub(crate) fn follow(&mut self, points: &[Vector2<f64>]) -> bool {
        let at = |node: u32| points[node as usize];
        let upright = |&[a, b, c]: &[u32; 3]| (at(b) - at(a)).perp(&(at(c) - at(a))) > 0.0;
        if self.triangles.is_empty() || !self.triangles.iter().all(upright) {
            return false;
        }
        // Far more flips than a small movement needs.
        let (mut left, mut stack) = (10 * self.triangles.len() + 100, Vec::new());
        for t in 0..self.triangles.len() as u32 {
            // Sides towards triangles before this one were tested from there, and again after every flip beside them.
            let mut flipped = self.flip_first(t, t, points);
            while let Some(pair) = flipped {
                stack.extend(pair);
                left -= 1;
                if left == 0 {
                    return false;
                }
                flipped = None;
                while flipped.is_none() {
                    let Some(changed) = stack.pop() else { break };
                    flipped = self.flip_first(changed, 0, points);
                }
            }
        }
        true
    }

    /// Flips the first side of a triangle that wants it and has a triangle beyond it that is not before `least`;
    /// returns both triangles.
    fn flip_first(&mut self, t: u32, least: u32, points: &[Vector2<f64>]) -> Option<[u32; 2]> {
        let beyond = self.beyond[t as usize];
        let side = (0..3).find(|&side| beyond[side] >= least && self.wants_flip(t, side, points))?;
        Some([t, self.flip(t, side)])
    }

    /// The index of neighbour `t` in `of`.
    fn side_towards(&self, of: u32, t: u32) -> usize {
        self.beyond[of as usize].iter().position(|&n| n == t).unwrap_or(0)
    }

    /// Whether the angles opposite a side add up to more than 180 degrees.
    fn wants_flip(&self, t: u32, side: usize, points: &[Vector2<f64>]) -> bool {
        let other = self.beyond[t as usize][side];
        if other == NONE || self.kept[t as usize][side] {
            return false;
        }
        let corners = self.triangles[t as usize];
        let [a, b, c] = [corners[side], corners[(side + 1) % 3], corners[(side + 2) % 3]];
        // The corner beyond the side: exclusive or takes a and b away from the three.
        let far = self.triangles[other as usize].into_iter().fold(a ^ b, |rest, node| rest ^ node);
        let at = |node: u32| points[node as usize];
        let (a, b, c, d) = (at(a), at(b), at(c), at(far));
        let (ca, cb, da, db) = (a - c, b - c, a - d, b - d);
        // Sine of the sum of the angles at c and d, times the four lengths.
        let sine = ca.perp(&cb) * da.dot(&db) + ca.dot(&cb) * db.perp(&da);
        // The sum of the squares bounds the product of lengths from above, without square roots.
        sine < -EXCESS * (ca.norm_squared() * cb.norm_squared() + da.norm_squared() * db.norm_squared())
    }

    /// Replaces the side a-b of triangles abc and bad by c-d; returns the other triangle.
    fn flip(&mut self, t: u32, side: usize) -> u32 {
        let other = self.beyond[t as usize][side];
        let across = self.side_towards(other, t);
        let (ti, oi) = (t as usize, other as usize);
        let next = |s: usize| (s + 1) % 3;
        let last = |s: usize| (s + 2) % 3;
        let (a, b, c) = (self.triangles[ti][side], self.triangles[ti][next(side)], self.triangles[ti][last(side)]);
        let d = self.triangles[oi][last(across)];
        // Sides of t: a-b, b-c, c-a; of other: b-a, a-d, d-b.
        let (bc, ca) = (self.beyond[ti][next(side)], self.beyond[ti][last(side)]);
        let (ad, db) = (self.beyond[oi][next(across)], self.beyond[oi][last(across)]);
        let (keep_bc, keep_ca) = (self.kept[ti][next(side)], self.kept[ti][last(side)]);
        let (keep_ad, keep_db) = (self.kept[oi][next(across)], self.kept[oi][last(across)]);
        for (neighbour, from, to) in [(bc, t, other), (ad, other, t)] {
            if neighbour != NONE {
                let at = self.side_towards(neighbour, from);
                self.beyond[neighbour as usize][at] = to;
            }
        }
        self.triangles[ti] = [c, a, d];
        self.beyond[ti] = [ca, ad, other];
        self.kept[ti] = [keep_ca, keep_ad, false];
        self.triangles[oi] = [d, b, c];
        self.beyond[oi] = [db, bc, t];
        self.kept[oi] = [keep_db, keep_bc, false];
        other
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix64;

    /// After movements that need many flips no side is left that wants one.
    #[test]
    fn nothing_is_left_to_flip() {
        const N: u32 = 12;
        let at = |i: u32| Vector2::new(f64::from(i % N), f64::from(i / N));
        let cells = (0..N * N).filter(|i| i % N < N - 1 && i / N < N - 1);
        let triangles: Vec<[u32; 3]> = cells.flat_map(|i| [[i, i + 1, i + N + 1], [i, i + N + 1, i + N]]).collect();
        let (mut random, mut followed, mut changed) = (SplitMix64::new(7, 0), 0, 0);
        for round in 0..4000 {
            // Rows are sheared, and nodes moved.
            let (shear, noise) = (0.6 * f64::from(round % 4), 0.2 + 0.03 * f64::from(round % 10));
            let mut moved = |i: u32| {
                let noise = Vector2::new(random.signed(), random.signed()) * noise;
                at(i) + Vector2::new(shear * at(i).y, 0.0) + noise
            };
            let points: Vec<Vector2<f64>> = (0..N * N).map(&mut moved).collect();
            let mut flips = Flips::new(triangles.clone(), &[]);
            if !flips.follow(&points) {
                continue;
            }
            followed += 1;
            changed += flips.triangles().iter().zip(&triangles).filter(|(now, before)| now != before).count();
            for t in 0..triangles.len() as u32 {
                assert!((0..3).all(|side| !flips.wants_flip(t, side, &points)), "round {round}, triangle {t}");
            }
        }
        assert!(followed > 300 && changed > 10_000, "{followed} followed, {changed} triangles changed");
    }
}
