//! A matrix on its pattern, as faer's factorisations read it.

use crate::assembly::Pattern;
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};

/// The pattern without values.
pub(super) fn symbolic_matrix(pattern: &Pattern) -> SymbolicSparseColMatRef<'_, u32> {
    SymbolicSparseColMatRef::new_checked(pattern.n(), pattern.n(), &pattern.col_ptr, None, &pattern.row_idx)
}

/// The pattern with a value for each of its entries.
pub(super) fn matrix<'a>(pattern: &'a Pattern, values: &'a [f64]) -> SparseColMatRef<'a, u32, f64> {
    SparseColMatRef::new(symbolic_matrix(pattern), values)
}
