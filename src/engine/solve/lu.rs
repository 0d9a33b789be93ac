//! Sparse LU by faer, for tangents that are not symmetric (air, follower pressure, axial dashpots).

use super::linear::{
    Inertia, LinearError, LinearSolver, LinearStats, SolverWork, check_finite, check_solution, matrix, symbolic_matrix,
};
use crate::assembly::Pattern;
use crate::mesh::adjacency::row_starts;
use crate::model::workers::ALONE;
use crate::startup::{Phase, timed};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::lu::{LuRef, NumericLu, SymbolicLu, factorize_symbolic_lu};
use faer::{Conj, MatMut, Par};
use std::sync::Arc;

const PAR: Par = Par::Seq;

/// P W Q = L U with column ordering (COLAMD) analysed once. faer allocates inside a numeric factorisation.
pub struct Lu {
    pattern: Arc<Pattern>,
    /// both triangles of a symmetric pattern: full pattern, and the slot in the given values of every entry
    full: Option<(Pattern, Vec<u32>, Vec<f64>)>,
    symbolic: SymbolicLu<u32>,
    numeric: NumericLu<u32, f64>,
    memory: MemBuffer,
    factored: bool,
    factorizations: u64,
}

impl std::fmt::Debug for Lu {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Lu").field("stats", &self.stats()).finish()
    }
}

/// A lower triangle written out in full.
fn mirror(pattern: &Pattern) -> (Pattern, Vec<u32>, Vec<f64>) {
    let mut entries = Vec::with_capacity(2 * pattern.nonzeros());
    for j in 0..pattern.n() as u32 {
        let first = pattern.col_ptr[j as usize];
        for (k, &i) in pattern.column(j as usize).iter().enumerate() {
            let slot = first + k as u32;
            entries.push((j, i, slot));
            if i != j {
                entries.push((i, j, slot));
            }
        }
    }
    entries.sort_unstable();
    let col_ptr = row_starts(pattern.n(), entries.iter().map(|&(j, ..)| j));
    let row_idx = entries.iter().map(|&(_, i, _)| i).collect();
    let slots: Vec<u32> = entries.iter().map(|&(_, _, s)| s).collect();
    let values = vec![0.0; slots.len()];
    (Pattern { col_ptr, row_idx, symmetric: false, ..pattern.clone() }, slots, values)
}

impl Lu {
    /// Analyses a pattern.
    ///
    /// # Errors
    /// When the analysis runs out of memory or index range.
    pub fn new(pattern: Arc<Pattern>) -> Result<Self, LinearError> {
        let failed = |reason: String| LinearError::Analysis { unknowns: pattern.n(), reason };
        let full = pattern.symmetric.then(|| mirror(&pattern));
        let analysed = full.as_ref().map_or(&*pattern, |(full, ..)| full);
        let symbolic = timed(Phase::Symbolic, || factorize_symbolic_lu(symbolic_matrix(analysed), Default::default()))
            .map_err(|e| failed(format!("{e:?}")))?;
        let scratch = symbolic
            .factorize_numeric_lu_scratch::<f64>(PAR, Default::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, PAR))
            .or(symbolic.solve_transpose_in_place_scratch::<f64>(1, PAR));
        let memory = MemBuffer::try_new(scratch).map_err(|_| failed("out of memory".into()))?;
        Ok(Lu { pattern, full, symbolic, numeric: NumericLu::new(), memory, factored: false, factorizations: 0 })
    }

    fn solve_with(
        &mut self,
        b: &mut [f64],
        solve: impl FnOnce(LuRef<'_, u32, f64>, MatMut<'_, f64>, &mut MemStack),
    ) -> Result<(), LinearError> {
        if !self.factored {
            return Err(LinearError::Singular { unknown: None });
        }
        let (n, lu) = (b.len(), LuRef::new_unchecked(&self.symbolic, &self.numeric));
        solve(lu, MatMut::from_column_major_slice_mut(b, n, 1), MemStack::new(&mut self.memory));
        check_solution(b, &ALONE)
    }
}

impl LinearSolver for Lu {
    fn factor(&mut self, values: &[f64]) -> Result<Inertia, LinearError> {
        self.factorizations += 1;
        check_finite(&self.pattern, values, &ALONE)?;
        self.factored = false;
        let w = match &mut self.full {
            None => matrix(&self.pattern, values),
            Some((full, slots, mirrored)) => {
                for (v, &slot) in mirrored.iter_mut().zip(slots.iter()) {
                    *v = values[slot as usize];
                }
                matrix(full, mirrored)
            }
        };
        let stack = MemStack::new(&mut self.memory);
        let (symbolic, numeric) = (&self.symbolic, &mut self.numeric);
        let made = timed(Phase::Factorization, || {
            symbolic.factorize_numeric_lu(numeric, w, PAR, stack, Default::default()).map(|_| ())
        });
        match made {
            Ok(()) => self.factored = true,
            Err(faer::sparse::linalg::LuError::SymbolicSingular { index }) => {
                return Err(LinearError::Singular { unknown: Some(index) });
            }
            Err(e) => return Err(LinearError::Analysis { unknowns: self.pattern.n(), reason: format!("{e:?}") }),
        }
        Ok(Inertia::Unknown)
    }

    fn solve(&mut self, _values: &[f64], b: &mut [f64]) -> Result<(), LinearError> {
        self.solve_with(b, |lu, b, stack| lu.solve_in_place_with_conj(Conj::No, b, PAR, stack))
    }

    fn solve_transposed(&mut self, _values: &[f64], b: &mut [f64]) -> Result<(), LinearError> {
        self.solve_with(b, |lu, b, stack| lu.solve_transpose_in_place_with_conj(Conj::No, b, PAR, stack))
    }

    fn work(&self) -> SolverWork {
        SolverWork { factorizations: self.factorizations, lu_factorizations: self.factorizations, iterations: 0 }
    }

    fn stats(&self) -> LinearStats {
        LinearStats {
            name: "lu",
            matrix_nonzeros: self.full.as_ref().map_or(self.pattern.nonzeros(), |(full, ..)| full.nonzeros()),
            factor_nonzeros: None,
            factor_operations: None,
            indefinite: 0,
            prediction: None,
        }
    }
}
