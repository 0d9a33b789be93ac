//! The pivots of M: those of an incomplete factorisation of W without any fill, of which part comes to the diagonal instead.
//!
//! ```text
//! P_g = (1 + delta) D_g - sum_j N_gj P_j^-1 N_gj^T - omega_g sym sum_j sum_s N_gj P_j^-1 N_sj^T Y_s Y_g^-1,      j < g,   s > j, s != g
//! ```
//! with Y_g = diag(1/scale), three translations that all nodes share in the numbers of a scaled W; its inverse is 0 in idle places. Without the sum over s
//! these are the pivots of D-ILU (Pommerell, in Barrett et al., Templates, SIAM 1994, section 3.4). The fill in it would stand beside the diagonal; put on it
//! as here (Dupont, Kendall & Rachford, SIAM J. Numer. Anal. 5, 1968; Gustafsson, BIT 18, 1978), a translation meets M nearly as it meets W, and so do the
//! smooth motions that take conjugate gradients longest. omega < 1 keeps pivots away from zero (relaxed: Axelsson & Lindskog, Numer. Math. 48, 1986), and
//! is halved at nodes whose pivot would lose too much, as where stiff springs meet soft ones; delta is a shift (Manteuffel, Math. Comp. 34, 1980). Where even a
//! pivot without fill is not positive definite, P_g = D_g. The product of Eisenstat (`eisenstat`) costs the same with any pivots, and M is positive definite if
//! they are.

use super::blocks::{BLOCK, Block, NodeBlocks, SymmetricBlock};
use glam::{DMat3, DVec3, Mat3A, Vec3A};

/// [-] omega. On taut nets of 703 to a million nodes 0.9, 0.98 and 1 took as many iterations within an eighth.
pub(super) const RELAXATION: f64 = 0.95;
/// [-] What fill must leave of a pivot. With 0.8 smooth nets take up to four tenths more iterations, with 0.3 as many or a fifth more.
const LEAST_LEFT: f64 = 0.5;
/// Times that omega is halved for it before a node takes no fill.
const HALVINGS: i32 = 3;
/// [-] delta: what pivots have more of their block than elimination leaves: without it, a light node on stiff springs costs single precision its digits.
const SHIFT: f64 = 0.01;
/// Entries of a positive definite matrix stay below the root of the product of the two on the diagonal; one that does not by more than this is no rounding.
const LARGEST: f32 = 1.0 + 1e-5;

impl NodeBlocks {
    /// Takes the values of W, with `omega` [-] of the fill in the pivots; whether the blocks on its diagonal are positive definite, and those beside them no larger
    /// than that allows.
    pub fn fill(&mut self, values: &[f64], omega: f64) -> bool {
        for (scale, &first) in self.scale.iter_mut().zip(&self.pattern.col_ptr) {
            // Rows ascend from the diagonal.
            *scale = values[first as usize].sqrt().recip();
        }
        // Until a node's turn comes: what the nodes before it take from its pivot, and the fill.
        self.inverse_root.fill(Mat3A::ZERO);
        self.surplus.fill(SymmetricBlock::default());
        for g in 0..self.nodes() {
            let Some(diagonal) = self.take(g, values) else { return false };
            let taken = [self.inverse_root[g], self.surplus[g].matrix()].map(|block| block.as_dmat3());
            let Some(pivot) = Pivot::new(&diagonal, taken, omega) else { return false };
            self.inverse_root[g] = pivot.inverse_root;
            self.surplus[g] = pivot.surplus;
            self.eliminate(g);
        }
        self.scale_rows()
    }

    /// Takes the values of a node's columns, scaled by the diagonal; returns the lower half of its block on the diagonal, or `None` where an entry beside
    /// it is too large: nothing may reach idle places that is not finite, for nothing is ever written there again.
    fn take(&mut self, g: usize, values: &[f64]) -> Option<DMat3> {
        let pattern = &self.pattern;
        let unknowns = pattern.node_start[g]..pattern.node_start[g + 1];
        let mut diagonal = DMat3::IDENTITY;
        for u in unknowns.start as usize..unknowns.end as usize {
            let slots = pattern.col_ptr[u] as usize..pattern.col_ptr[u + 1] as usize;
            for ((&r, value), &entry) in pattern.column(u).iter().zip(&values[slots.clone()]).zip(&self.entry[slots]) {
                let scaled = value * self.scale[u] * self.scale[r as usize];
                if r < unknowns.end {
                    diagonal.col_mut((pattern.dof[u] % 3) as usize)[(pattern.dof[r as usize] % 3) as usize] = scaled;
                } else if scaled.abs() <= f64::from(LARGEST) {
                    let (block, within) = ((entry / BLOCK) as usize, (entry % BLOCK) as usize);
                    self.below[block].0[within] = scaled as f32;
                } else {
                    return None;
                }
            }
        }
        Some(diagonal)
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
        self.places(g, |u| self.scale[u] as f32)
    }

    /// Scales all rows from the left; whether entries are as small as a positive definite W has them.
    fn scale_rows(&mut self) -> bool {
        let mut small = true;
        for g in 0..self.nodes() {
            let own = (self.surplus[g].diagonal() + 1.0) * (LARGEST * LARGEST);
            for k in self.column(g) {
                let row = self.row[k] as usize;
                let block = self.inverse_root[row] * self.below[k].matrix();
                self.below[k] = Block(block.to_cols_array());
                let other = self.surplus[row].diagonal() + 1.0;
                for (column, own) in [block.x_axis, block.y_axis, block.z_axis].into_iter().zip(own.to_array()) {
                    // Not so for what is no number.
                    small &= (column * column).cmple(other * own).all();
                }
            }
        }
        small
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
    /// From the lower half of D, what eliminations have taken from it, and their fill. `None` where no pivot is positive definite.
    fn new(lower: &DMat3, [taken, fill]: [DMat3; 2], omega: f64) -> Option<Self> {
        let [x, y, z] = [lower.x_axis, lower.y_axis, lower.z_axis];
        let block = DMat3::from_cols(x, DVec3::new(x.y, y.y, y.z), DVec3::new(x.z, y.z, z.z));
        let pivot = less_fill(&(block * (1.0 + SHIFT) - taken), &(fill * omega));
        Pivot::of(&pivot, &block).or_else(|| Pivot::of(&block, &block))
    }

    /// `None` where the pivot is not positive definite.
    fn of(pivot: &DMat3, block: &DMat3) -> Option<Self> {
        let inverse_root = single(&inverse_root(pivot)?);
        // Of the root as it is kept: so what it has been rounded by changes M, not W.
        let root = inverse_root.as_dmat3();
        let surplus = root * *block * root.transpose() - DMat3::IDENTITY;
        Some(Pivot { inverse_root, surplus: SymmetricBlock::of(&single(&surplus)) })
    }
}

/// A pivot after its share of the fill, as much of it as leaves enough.
fn less_fill(pivot: &DMat3, fill: &DMat3) -> DMat3 {
    let most = *pivot * (1.0 - LEAST_LEFT);
    let shares = (0..=HALVINGS).map(|i| *fill * 0.5_f64.powi(i));
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
mod tests;
