//! The number of negative eigenvalues of a symmetric matrix: that of the negative pivots of its factor (Sylvester).

use super::{Cholesky, Kind};
use crate::mesh::random::pseudo_random;
use crate::solve::{Inertia, LinearError, LinearSolver};
use faer::sparse::linalg::cholesky::SymbolicCholeskyRaw;

/// [-] Backward errors of a solve: above the first without pivoting the matrix is factorised with pivoting; above the
/// second with pivoting its pivots say nothing.
const BACKWARD: [f64; 2] = [1e-13, 1e-9];

impl Cholesky {
    /// Factorises W and returns how many of its eigenvalues are negative.
    ///
    /// # Errors
    /// As [`LinearSolver::factor`], and if the factor is not that of a matrix close to W.
    pub fn factor_with_inertia(&mut self, values: &[f64]) -> Result<usize, LinearError> {
        if self.factor(values)? == Inertia::Definite {
            return Ok(0);
        }
        if self.kind == Kind::Ldlt && self.too_far(values, BACKWARD[0]) {
            self.factor_pivoting(values)?;
        }
        if self.kind == Kind::Lblt && self.too_far(values, BACKWARD[1]) {
            return Err(LinearError::Singular { unknown: None });
        }
        self.negative_pivots().ok_or(LinearError::Singular { unknown: None })
    }

    /// Whether a solve leaves more than a share of what rounding in its operands could leave.
    fn too_far(&mut self, values: &[f64], share: f64) -> bool {
        let largest = |of: &[f64]| of.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let b: Vec<f64> = (0..self.pattern.n()).map(pseudo_random).collect();
        let (mut x, mut left) = (b.clone(), vec![0.0; b.len()]);
        self.solve_once(&mut x);
        self.pattern.multiply(values, &x, &mut left);
        left.iter_mut().zip(&b).for_each(|(left, b)| *left -= b);
        let near = largest(&left) <= share * (largest(values) * largest(&x) + largest(&b));
        !(near && x.iter().all(|x| x.is_finite()))
    }

    fn negative_pivots(&self) -> Option<usize> {
        let SymbolicCholeskyRaw::Supernodal(supernodes) = self.symbolic.raw() else { return None };
        let columns = supernodes.supernode_begin().iter().zip(supernodes.supernode_end());
        let places = supernodes.col_ptr_for_val().iter().zip(supernodes.nnz_per_super());
        let mut pivots: Vec<f64> = Vec::with_capacity(self.pattern.n());
        for ((&begin, &end), (&first, &below)) in columns.zip(places) {
            let (wide, tall) = ((end - begin) as usize, (end - begin + below) as usize);
            pivots.extend((0..wide).filter_map(|j| self.l.get(first as usize + j * (tall + 1)).copied()));
        }
        let beside = |i: usize| match (self.kind, &self.pivoting) {
            (Kind::Lblt, Some(pivoting)) => pivoting.subdiagonal.get(i).copied().unwrap_or(0.0),
            _ => 0.0,
        };
        let (mut negatives, mut i) = (0, 0);
        while let Some(&pivot) = pivots.get(i) {
            let off = beside(i);
            if off == 0.0 {
                negatives += usize::from(pivot < 0.0);
                i += 1;
                continue;
            }
            // A block of two by two.
            let next = *pivots.get(i + 1)?;
            let mixed = pivot * next < off * off;
            negatives += if mixed { 1 } else { 2 * usize::from(pivot < 0.0) };
            i += 2;
        }
        (pivots.len() == self.pattern.n()).then_some(negatives)
    }
}
