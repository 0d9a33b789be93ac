//! The pivots of M: those of an incomplete factorisation of W without any fill, of which part comes to the diagonal instead.
//!
//! ```text
//! P_g = (1 + delta) D_g - sum_j N_gj P_j^-1 N_gj^T - omega_g sym sum_j sum_s N_gj P_j^-1 N_sj^T Y_s Y_g^-1,      j < g,   s > j, s != g
//! ```
//! with Y_g = diag(1/scale), three translations that all nodes share in the numbers of a scaled W. Without the sum over s these are the pivots of Dupont,
//! Kendall & Rachford (SIAM J. Numer. Anal. 5, 1968). The fill in it would stand beside the diagonal; put on it as here (Gustafsson, BIT 18, 1978), a
//! translation meets M as it meets W, and so nearly do the smooth motions that take conjugate gradients longest. omega < 1 keeps pivots away from zero
//! (relaxed: Axelsson & Lindskog, Numer. Math. 48, 1986), and is halved at nodes whose pivot would lose too much, which are those where stiff springs meet
//! soft ones. The product of Eisenstat (`eisenstat`) costs the same with any pivots, and M is positive definite if they are.

use super::blocks::{BLOCK, Block, NodeBlocks, SymmetricBlock};
use glam::{DMat3, DVec3, Mat3A, Vec3A};
use std::sync::Arc;

/// [-] omega. On eleven nets of 703 to a million nodes 0.9 takes up to an eighth more iterations, and 0.99 leaves pivots below zero.
const RELAXATION: f64 = 0.95;
/// [-] What fill must leave of a pivot.
const LEAST_LEFT: f64 = 0.5;
/// Times that omega is halved for it before a node takes no fill.
const HALVINGS: i32 = 3;
/// [-] delta: what pivots have more of their block than elimination leaves: without it, a light node on stiff springs costs single precision its digits.
const SHIFT: f64 = 0.01;
/// Entries of a positive definite matrix stay below the root of the diagonal's; one that does not is more than rounding.
const LARGEST: f32 = 1.0 + 1e-5;

impl NodeBlocks {
    /// Takes the values of W; whether the blocks on its diagonal are positive definite, and those beside them no larger than that allows.
    pub fn fill(&mut self, values: &[f64]) -> bool {
        let pattern = Arc::clone(&self.pattern);
        for (scale, &first) in self.scale.iter_mut().zip(&pattern.col_ptr) {
            // Rows ascend from the diagonal.
            *scale = values[first as usize].sqrt().recip();
        }
        // Until a node's turn comes: what the nodes before it take from its pivot, and the fill.
        self.inverse_root.fill(Mat3A::ZERO);
        self.surplus.fill(SymmetricBlock::default());
        let mut small = true;
        for g in 0..self.nodes() {
            let diagonal = self.take(g, values, &mut small);
            let taken = [self.inverse_root[g], self.surplus[g].matrix()].map(|block| block.as_dmat3());
            let Some(pivot) = Pivot::new(&diagonal, taken) else { return false };
            self.inverse_root[g] = pivot.inverse_root;
            self.surplus[g] = pivot.surplus;
            self.eliminate(g);
        }
        small && self.scale_rows()
    }

    /// Takes the values of a node's columns, scaled by the diagonal; returns the lower half of its block on the diagonal. `small` falls where an entry beside
    /// it is too large.
    fn take(&mut self, g: usize, values: &[f64], small: &mut bool) -> DMat3 {
        let pattern = &self.pattern;
        let unknowns = pattern.node_start[g]..pattern.node_start[g + 1];
        let mut diagonal = DMat3::IDENTITY;
        for u in unknowns.start as usize..unknowns.end as usize {
            let slots = pattern.col_ptr[u] as usize..pattern.col_ptr[u + 1] as usize;
            for ((&r, value), &entry) in pattern.column(u).iter().zip(&values[slots.clone()]).zip(&self.entry[slots]) {
                let scaled = value * self.scale[u] * self.scale[r as usize];
                if r < unknowns.end {
                    diagonal.col_mut((pattern.dof[u] % 3) as usize)[(pattern.dof[r as usize] % 3) as usize] = scaled;
                } else {
                    *small &= scaled.abs() <= f64::from(LARGEST);
                    let (block, within) = ((entry / BLOCK) as usize, (entry % BLOCK) as usize);
                    self.below[block].0[within] = scaled as f32;
                }
            }
        }
        diagonal
    }

    /// Scales a node's column from the right, and takes from the pivots of its neighbours what its elimination takes.
    fn eliminate(&mut self, g: usize) {
        let right = self.inverse_root[g].transpose();
        let mut all = Mat3A::ZERO;
        for k in self.column(g) {
            let block = self.below[k].matrix() * right;
            self.below[k] = Block(block.to_cols_array());
            let scale = self.scale_of(self.row[k] as usize);
            let translation = Vec3A::select(scale.cmpgt(Vec3A::ZERO), scale.recip(), Vec3A::ZERO);
            all += scale_columns(block.transpose(), translation);
        }
        for k in self.column(g) {
            let row = self.row[k] as usize;
            let block = self.below[k].matrix();
            let own = block * block.transpose();
            let fill = block * scale_columns(all, self.scale_of(row)) - own;
            self.inverse_root[row] += own;
            self.surplus[row].add(&((fill + fill.transpose()) * 0.5));
        }
    }

    /// Scales of a node's three places, 0 where they are idle.
    fn scale_of(&self, g: usize) -> Vec3A {
        let unknowns = self.pattern.node_start[g] as usize..self.pattern.node_start[g + 1] as usize;
        let single = |u: usize| self.scale[u] as f32;
        if unknowns.len() == 3 {
            return Vec3A::new(single(unknowns.start), single(unknowns.start + 1), single(unknowns.start + 2));
        }
        let mut scale = Vec3A::ZERO;
        unknowns.for_each(|u| scale[self.direction(u)] = single(u));
        scale
    }

    /// Scales all rows from the left; whether entries are as small as a positive definite W has them.
    fn scale_rows(&mut self) -> bool {
        let mut largest = Vec3A::ZERO;
        for g in 0..self.nodes() {
            let own = self.surplus[g].diagonal() + 1.0;
            for k in self.column(g) {
                let row = self.row[k] as usize;
                let block = self.inverse_root[row] * self.below[k].matrix();
                self.below[k] = Block(block.to_cols_array());
                let other = self.surplus[row].diagonal() + 1.0;
                for (column, own) in [block.x_axis, block.y_axis, block.z_axis].into_iter().zip(own.to_array()) {
                    largest = largest.max(column * column / (other * own));
                }
            }
        }
        largest.max_element() <= LARGEST * LARGEST
    }
}

fn scale_columns(m: Mat3A, by: Vec3A) -> Mat3A {
    Mat3A::from_cols(m.x_axis * by.x, m.y_axis * by.y, m.z_axis * by.z)
}

/// A pivot P = E E^T of a block D = E (I + J) E^T.
struct Pivot {
    /// E^-1
    inverse_root: Mat3A,
    /// J
    surplus: SymmetricBlock,
}

impl Pivot {
    /// From the lower half of D, what eliminations have taken from it, and their fill. `None` where D is not positive definite.
    fn new(lower: &DMat3, [taken, fill]: [DMat3; 2]) -> Option<Self> {
        let [x, y, z] = [lower.x_axis, lower.y_axis, lower.z_axis];
        let block = DMat3::from_cols(x, DVec3::new(x.y, y.y, y.z), DVec3::new(x.z, y.z, z.z));
        let pivot = less_fill(&(block * (1.0 + SHIFT) - taken), &fill);
        Pivot::of(&pivot, &block).or_else(|| Pivot::of(&block, &block))
    }

    /// `None` where the pivot is not positive definite.
    fn of(pivot: &DMat3, block: &DMat3) -> Option<Self> {
        let root = inverse_root(pivot)?;
        let surplus = root * *block * root.transpose() - DMat3::IDENTITY;
        Some(Pivot { inverse_root: single(&root), surplus: SymmetricBlock::of(&single(&surplus)) })
    }
}

/// A pivot after its fill, as much of it as leaves enough.
fn less_fill(pivot: &DMat3, fill: &DMat3) -> DMat3 {
    let most = *pivot * (1.0 - LEAST_LEFT);
    let shares = (0..=HALVINGS).map(|i| *fill * (RELAXATION * 0.5_f64.powi(i)));
    shares.into_iter().find(|share| inverse_root(&(most - *share)).is_some()).map_or(*pivot, |share| *pivot - share)
}

fn single(m: &DMat3) -> Mat3A {
    Mat3A::from_cols(m.x_axis.as_vec3a(), m.y_axis.as_vec3a(), m.z_axis.as_vec3a())
}

/// E^-1 of a block E E^T of which the lower triangle is read.
fn inverse_root(block: &DMat3) -> Option<DMat3> {
    let [x, y, z] = [block.x_axis, block.y_axis, block.z_axis];
    let root = |pivot: f64| (pivot > 0.0).then(|| pivot.sqrt());
    let a = root(x.x)?;
    let (b, c) = (x.y / a, x.z / a);
    let d = root(y.y - b * b)?;
    let e = (y.z - c * b) / d;
    let f = root(z.z - c * c - e * e)?;
    let (ia, id, i_f) = (1.0 / a, 1.0 / d, 1.0 / f);
    let below = -b * ia * id;
    let corner = -(c * ia + e * below) * i_f;
    Some(DMat3::from_cols(DVec3::new(ia, below, corner), DVec3::new(0.0, id, -e * id * i_f), DVec3::new(0.0, 0.0, i_f)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly::Pattern;

    /// What node g may move along, of a row of nodes of which some are partly held.
    fn free(g: usize) -> &'static [u32] {
        match g {
            3 => &[0, 2],
            5 => &[1],
            _ => &[0, 1, 2],
        }
    }

    const NODES: usize = 12;

    /// Nodes with three neighbours ahead each, as in a net of triangles.
    fn pattern() -> Pattern {
        let (mut dof, mut node_start) = (Vec::new(), vec![0]);
        for g in 0..NODES {
            dof.extend(free(g).iter().map(|direction| 3 * g as u32 + direction));
            node_start.push(dof.len() as u32);
        }
        let (mut col_ptr, mut row_idx) = (vec![0], Vec::new());
        for g in 0..NODES {
            for u in node_start[g]..node_start[g + 1] {
                row_idx.extend(u..node_start[g + 1]);
                for other in [g + 1, g + 4, g + 5].into_iter().filter(|&other| other < NODES) {
                    row_idx.extend(node_start[other]..node_start[other + 1]);
                }
                col_ptr.push(row_idx.len() as u32);
            }
        }
        let position = vec![[0.0; 3]; NODES];
        Pattern { col_ptr, row_idx, symmetric: true, dof, node_start, position }
    }

    /// Random entries of sizes that differ by powers of ten, made positive definite by the diagonal.
    fn values(pattern: &Pattern, seed: u64) -> Vec<f64> {
        let mut state = seed;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        let size: Vec<f64> = (0..pattern.n()).map(|_| 10_f64.powf(3.0 * random())).collect();
        let (mut values, mut sums) = (vec![0.0; pattern.nonzeros()], vec![0.1; pattern.n()]);
        for u in 0..pattern.n() {
            let beside = pattern.col_ptr[u] as usize + 1..pattern.col_ptr[u + 1] as usize;
            for (value, &r) in values[beside].iter_mut().zip(&pattern.column(u)[1..]) {
                let (entry, r): (f64, usize) = (random(), r as usize);
                *value = entry * size[u] * size[r];
                sums[u] += entry.abs();
                sums[r] += entry.abs();
            }
        }
        for u in 0..pattern.n() {
            values[pattern.col_ptr[u] as usize] = sums[u] * size[u] * size[u];
        }
        values
    }

    /// E (I + J) E^T and E L E^T are the blocks of W, entry by entry, whatever the pivots.
    #[test]
    fn the_blocks_are_those_of_w() {
        let pattern = Arc::new(pattern());
        let mut blocks = NodeBlocks::new(Arc::clone(&pattern));
        for seed in 1..20 {
            let values = values(&pattern, seed);
            assert!(blocks.fill(&values), "seed {seed}");
            assert!(
                (0..NODES).any(|g| blocks.surplus[g].diagonal().max_element() > 0.1),
                "seed {seed}: some pivots lose"
            );
            let root: Vec<DMat3> = blocks.inverse_root.iter().map(|inverse| inverse.as_dmat3().inverse()).collect();
            for g in 0..NODES {
                let own = DMat3::IDENTITY + blocks.surplus[g].matrix().as_dmat3();
                let beside = blocks.column(g).map(|k| (blocks.row[k] as usize, blocks.below[k].matrix().as_dmat3()));
                for (other, block) in beside.chain([(g, own)]) {
                    let found = root[other] * block * root[g].transpose();
                    for u in pattern.node_start[g]..pattern.node_start[g + 1] {
                        for r in (pattern.node_start[other]..pattern.node_start[other + 1]).filter(|&r| r >= u) {
                            let slot = pattern.slot(r, u).expect("a stored entry") as usize;
                            let scales = blocks.scale[u as usize] * blocks.scale[r as usize];
                            let (column, row) = (blocks.direction(u as usize), blocks.direction(r as usize));
                            let off = found.col(column)[row] - values[slot] * scales;
                            assert!(off.abs() < 2e-6, "seed {seed}: entry {r}, {u} is {off:e} off");
                        }
                    }
                }
            }
        }
    }
}
