//! The pivots of M: those of a relaxed incomplete factorisation without fill, part of which is added to the diagonal
//! instead.
//!
//! ```text
//! P_g = (1 + delta) D_g - sum_j N_gj P_j^-1 N_gj^T - omega_g sym sum_j sum_s N_gj P_j^-1 N_sj^T Y_s Y_g^-1,      j < g,   s > j, s != g
//! ```
//! with Y_g = diag(1/scale), three translations that all nodes share in the scaled W; its inverse is 0 at fixed
//! components. Without the sum over s these are the pivots of D-ILU (Pommerell, in Barrett et al., Templates, SIAM
//! 1994, section 3.4). The dropped fill is added to the diagonal instead (Dupont, Kendall & Rachford, SIAM J. Numer.
//! Anal. 5, 1968; Gustafsson, BIT 18, 1978). So M acts on a translation nearly as W does, and on the smooth modes that
//! need most iterations. omega < 1 keeps pivots away from zero (relaxed: Axelsson & Lindskog, Numer. Math. 48, 1986).
//! It is halved at nodes whose pivot would lose too much, as where stiff springs meet soft ones. delta is a shift
//! (Manteuffel, Math. Comp. 34, 1980). If even the pivot without fill is not positive definite, P_g = D_g. Eisenstat's
//! product (`eisenstat`) costs the same with any pivots, and M is positive definite if they are.

use super::bsr::{BLOCK, Block, ELSEWHERE, NodeBlocks, SymmetricBlock};
use glam::{DMat3, DVec3, Mat3A, Vec3A};

/// [-] omega. On taut nets of 703 to a million nodes 0.9, 0.98 and 1 took as many iterations within an eighth.
pub(super) const RELAXATION: f64 = 0.95;
/// [-] Least share of a pivot that the fill must leave. With 0.8 smooth nets take up to 1.4 times the iterations, with
/// 0.3 as many or 1.2 times.
const LEAST_LEFT: f64 = 0.5;
/// Maximum number of halvings of omega at a node; then it takes no fill.
const HALVINGS: i32 = 3;
/// [-] delta, the share of the diagonal block added to a pivot: without it, a light node on stiff springs loses the
/// digits of single precision.
const SHIFT: f64 = 0.01;
/// Bound on entries of a positive definite matrix scaled by its diagonal, with a margin for rounding.
const LARGEST: f32 = 1.0 + 1e-5;

impl NodeBlocks {
    /// Sets the off-diagonal values of W, scaled by the diagonal; `values` [nonzeros], `scale` `[n]`. Returns whether
    /// all are small enough.
    pub fn begin(&mut self, values: &[f64], scale: &[f64]) -> bool {
        // Until a node is eliminated, these hold what earlier nodes subtract from its pivot, and the fill.
        self.inverse_root.fill(Mat3A::ZERO);
        self.surplus.fill(SymmetricBlock::default());
        let columns = self.unknowns().into_iter().flatten();
        let NodeBlocks { pattern, below, entry, .. } = self;
        let mut entries = entry.iter();
        columns.into_iter().all(|u| {
            let first = pattern.col_ptr[u] as usize;
            let beside = pattern.column(u).iter().zip(&values[first..]).zip(&mut entries);
            // Visits all of the column, so that the next one continues at its own entries.
            beside.fold(true, |small, ((&r, value), &entry)| {
                small & (entry == ELSEWHERE || put(below, entry, value * scale[u] * scale[r as usize]))
            })
        })
    }

    /// Adds what the elimination of a half subtracts from the pivots of this separator.
    pub fn add_elimination_of(&mut self, half: &NodeBlocks) {
        for (own, other) in self.inverse_root.iter_mut().zip(&half.inverse_root[half.nodes()..]) {
            *own += *other;
        }
        for (own, other) in self.surplus.iter_mut().zip(&half.surplus[half.nodes()..]) {
            own.add(&other.matrix());
        }
    }

    /// Copies the pivots of the separator into a half.
    pub fn copy_separator_pivots(&mut self, separator: &NodeBlocks) {
        let own = self.nodes();
        self.inverse_root[own..].copy_from_slice(&separator.inverse_root);
        self.surplus[own..].copy_from_slice(&separator.surplus);
    }

    /// Eliminates all nodes in order, with the share `omega` [-] of the fill in the pivots. Returns whether all
    /// diagonal blocks are positive definite.
    pub fn eliminate(&mut self, values: &[f64], scale: &[f64], omega: f64) -> bool {
        (0..self.nodes()).all(|g| {
            let taken = [self.inverse_root[g], self.surplus[g].matrix()].map(|block| block.as_dmat3());
            let Some(pivot) = Pivot::new(&self.diagonal(g, values, scale), taken, omega) else { return false };
            self.inverse_root[g] = pivot.inverse_root;
            self.surplus[g] = pivot.surplus;
            self.eliminate_node(g, scale);
            true
        })
    }

    /// The lower triangle of a node's diagonal block, scaled.
    fn diagonal(&self, g: usize, values: &[f64], scale: &[f64]) -> DMat3 {
        let (pattern, unknowns) = (&self.pattern, self.unknowns_of(g));
        let mut diagonal = DMat3::IDENTITY;
        for u in unknowns.clone() {
            let first = pattern.col_ptr[u] as usize;
            for (r, value) in (u..unknowns.end).zip(&values[first..]) {
                diagonal.col_mut(self.direction(u))[self.direction(r)] = value * scale[u] * scale[r];
            }
        }
        diagonal
    }

    /// Scales a node's column from the right and subtracts its elimination from the pivots of its neighbours.
    fn eliminate_node(&mut self, g: usize, scale: &[f64]) {
        let right = self.inverse_root[g].transpose();
        let mut all = Mat3A::ZERO;
        for k in self.column(g) {
            let block = self.below[k].matrix() * right;
            self.below[k] = Block(block.to_cols_array());
            let inverse = self.scale_of(self.row[k] as usize, scale);
            let translation = Vec3A::select(inverse.cmpgt(Vec3A::ZERO), inverse.recip(), Vec3A::ZERO);
            all += scale_columns(block.transpose(), translation);
        }
        for k in self.column(g) {
            let row = self.row[k] as usize;
            let block = self.below[k].matrix();
            let own = block * block.transpose();
            let fill = block * scale_columns(all, self.scale_of(row, scale)) - own;
            self.inverse_root[row] += own;
            self.surplus[row].add(&((fill + fill.transpose()) * 0.5));
        }
    }

    /// Scales of a node's three components, 0 at fixed ones.
    fn scale_of(&self, place: usize, scale: &[f64]) -> Vec3A {
        self.node_vector(place, |u| scale[u] as f32)
    }

    /// Scales all rows from the left. Returns whether entries are as small as in a positive definite W.
    pub fn scale_rows(&mut self) -> bool {
        let mut small = true;
        for g in 0..self.nodes() {
            let own = (self.surplus[g].diagonal() + 1.0) * (LARGEST * LARGEST);
            for k in self.column(g) {
                let row = self.row[k] as usize;
                let block = self.inverse_root[row] * self.below[k].matrix();
                self.below[k] = Block(block.to_cols_array());
                let other = self.surplus[row].diagonal() + 1.0;
                for (column, own) in [block.x_axis, block.y_axis, block.z_axis].into_iter().zip(own.to_array()) {
                    // False for NaN.
                    small &= (column * column).cmple(other * own).all();
                }
            }
        }
        small
    }
}

/// Stores a scaled value of W. Returns whether it is as small as in a positive definite matrix.
#[inline(always)]
fn put(below: &mut [Block], entry: u32, scaled: f64) -> bool {
    let small = scaled.abs() <= f64::from(LARGEST);
    if small {
        below[(entry / BLOCK) as usize].0[(entry % BLOCK) as usize] = scaled as f32;
    }
    small
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
    /// From the lower triangle of D, what eliminations have subtracted, and their fill. `None` if no pivot is positive
    /// definite.
    fn new(lower: &DMat3, [taken, fill]: [DMat3; 2], omega: f64) -> Option<Self> {
        let [x, y, z] = [lower.x_axis, lower.y_axis, lower.z_axis];
        let block = DMat3::from_cols(x, DVec3::new(x.y, y.y, y.z), DVec3::new(x.z, y.z, z.z));
        let pivot = less_fill(&(block * (1.0 + SHIFT) - taken), &(fill * omega));
        Pivot::of(&pivot, &block).or_else(|| Pivot::of(&block, &block))
    }

    /// `None` if the pivot is not positive definite.
    fn of(pivot: &DMat3, block: &DMat3) -> Option<Self> {
        let inverse_root = single(&inverse_root(pivot)?);
        // Uses the rounded root: rounding then changes M, not W.
        let root = inverse_root.as_dmat3();
        let surplus = root * *block * root.transpose() - DMat3::IDENTITY;
        Some(Pivot { inverse_root, surplus: SymmetricBlock::of(&single(&surplus)) })
    }
}

/// A pivot less its share of the fill, halved until enough of the pivot is left.
fn less_fill(pivot: &DMat3, fill: &DMat3) -> DMat3 {
    let most = *pivot * (1.0 - LEAST_LEFT);
    let shares = (0..=HALVINGS).map(|i| *fill * 0.5_f64.powi(i));
    shares.into_iter().find(|share| inverse_root(&(most - *share)).is_some()).map_or(*pivot, |share| *pivot - share)
}

fn single(m: &DMat3) -> Mat3A {
    Mat3A::from_cols(m.x_axis.as_vec3a(), m.y_axis.as_vec3a(), m.z_axis.as_vec3a())
}

/// E^-1 of a block E E^T; reads the lower triangle. `None` if it is not positive definite.
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
