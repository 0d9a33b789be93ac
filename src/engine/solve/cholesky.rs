//! Sparse Cholesky by faer, with LDLT and LBLT for tangents that are not positive definite.
//!
//! Springs in compression make K indefinite. LLT always detects this, early. Unpivoted LDLT completes but may lose
//! digits, so its solution is refined once and checked. If the check fails, the matrix is factorised with pivoting
//! inside supernodes (LBLT).

mod inertia;

use super::linear::{
    Accuracy, Inertia, LinearError, LinearSolver, LinearStats, REUSED_RELATIVE, SolverWork, check_finite,
    check_solution, matrix, symbolic_matrix,
};
use super::mixed_precision::SinglePrecisionFactor;
use super::ordering::{Permutation, fill_reducing};
use crate::assembly::Pattern;
use crate::interrupt;
use crate::mesh::random::pseudo_random;
use crate::model::workers::{ALONE, Workers};
use crate::startup::{Phase, timed};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, IntranodeLbltRef, LdltRef, LltRef, SymbolicCholesky, SymbolicCholeskyRaw,
    SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::{Conj, MatMut, Par, Side};
use std::sync::Arc;

/// faer's threads help only in large supernodes and cost more than they save below a million nodes.
const PAR: Par = Par::Seq;
/// Largest ||b - W x|| / ||b|| that an unpivoted LDLT may leave after one refinement.
const LDLT_RESIDUAL: f64 = 1e-9;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Llt,
    Ldlt,
    Lblt,
}

/// W = L L^T, or L D L^T, or L B L^T, on a lower-triangular pattern analysed once.
pub struct Cholesky {
    pattern: Arc<Pattern>,
    symbolic: SymbolicCholesky<u32>,
    l: Vec<f64>,
    memory: MemBuffer,
    kind: Kind,
    pivoting: Option<Box<Pivoting>>,
    /// the factor of a reused W in single precision, allocated at the first use
    single: Option<Box<SinglePrecisionFactor>>,
    /// whether it is accurate enough for the last W
    single_serves: bool,
    /// accuracy of further solves
    accuracy: Accuracy,
    refinement: Vec<f64>,
    product: Vec<f64>,
    indefinite: u64,
    factorizations: u64,
}

/// Buffers of LBLT, allocated at the first use.
struct Pivoting {
    subdiagonal: Vec<f64>,
    forward: Vec<u32>,
    inverse: Vec<u32>,
    memory: MemBuffer,
}

impl std::fmt::Debug for Cholesky {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Cholesky").field("stats", &self.stats()).field("kind", &self.kind).finish()
    }
}

/// Multiplications and additions of one factorisation, from the supernodes: c columns over r rows below them take
/// c^3/3 + c^2 r + c r^2.
fn operations(symbolic: &SymbolicCholesky<u32>) -> Option<f64> {
    let SymbolicCholeskyRaw::Supernodal(supernodes) = symbolic.raw() else { return None };
    let columns = supernodes.supernode_begin().iter().zip(supernodes.supernode_end());
    let rows = supernodes.col_ptr_for_row_idx().windows(2).map(|w| f64::from(w[1] - w[0]));
    let one = |((begin, end), r): ((&u32, &u32), f64)| {
        let c = f64::from(end - begin);
        c * (c * c / 3.0 + c * r + r * r)
    };
    Some(columns.zip(rows).map(one).sum())
}

fn column(b: &mut [f64]) -> MatMut<'_, f64> {
    let n = b.len();
    MatMut::from_column_major_slice_mut(b, n, 1)
}

impl Cholesky {
    /// Orders a symmetric pattern, on the threads of `workers`, and analyses it.
    ///
    /// # Errors
    /// When the analysis runs out of memory or index range.
    pub fn new(pattern: Arc<Pattern>, workers: &Workers) -> Result<Self, LinearError> {
        let order = timed(Phase::Ordering, || fill_reducing(&pattern, workers)).map(|elimination| elimination.order);
        interrupt::check()?;
        Self::ordered(pattern, order.as_ref())
    }

    /// Analyses a symmetric pattern in a given order.
    ///
    /// # Errors
    /// As [`Cholesky::new`].
    pub fn ordered(pattern: Arc<Pattern>, order: Option<&Permutation>) -> Result<Self, LinearError> {
        let failed = |reason: String| LinearError::Analysis { unknowns: pattern.n(), reason };
        let ordering = match order {
            Some(p) => SymmetricOrdering::Custom(PermRef::new_checked(&p.new_to_old, &p.old_to_new, pattern.n())),
            None => SymmetricOrdering::Amd,
        };
        // By default faer uses the simplicial method at 700 nodes, which is three times slower there.
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let analysed = || factorize_symbolic_cholesky(symbolic_matrix(&pattern), Side::Lower, ordering, params);
        let symbolic = timed(Phase::Symbolic, analysed).map_err(|e| failed(format!("{e:?}")))?;
        let scratch = symbolic
            .factorize_numeric_llt_scratch::<f64>(PAR, Default::default())
            .or(symbolic.factorize_numeric_ldlt_scratch::<f64>(PAR, Default::default()))
            .or(symbolic.solve_in_place_scratch::<f64>(1, PAR));
        let memory = MemBuffer::try_new(scratch).map_err(|_| failed("out of memory".into()))?;
        let l = vec![0.0; symbolic.len_val()];
        let (refinement, product) = (Vec::new(), Vec::new());
        Ok(Cholesky {
            pattern,
            symbolic,
            l,
            memory,
            kind: Kind::Llt,
            pivoting: None,
            single: None,
            single_serves: false,
            accuracy: Accuracy::to(0.0),
            refinement,
            product,
            indefinite: 0,
            factorizations: 0,
        })
    }

    fn factor_pivoting(&mut self, values: &[f64]) -> Result<(), LinearError> {
        let n = self.pattern.n();
        if self.pivoting.is_none() {
            let scratch = self
                .symbolic
                .factorize_numeric_intranode_lblt_scratch::<f64>(PAR, Default::default())
                .or(self.symbolic.solve_in_place_scratch::<f64>(1, PAR));
            let memory = MemBuffer::try_new(scratch)
                .map_err(|_| LinearError::Analysis { unknowns: n, reason: "out of memory".into() })?;
            let (forward, inverse) = (vec![0; n], vec![0; n]);
            self.pivoting = Some(Box::new(Pivoting { subdiagonal: vec![0.0; n], forward, inverse, memory }));
        }
        if let Some(p) = &mut self.pivoting {
            self.symbolic.factorize_numeric_intranode_lblt(
                &mut self.l,
                &mut p.subdiagonal,
                &mut p.forward,
                &mut p.inverse,
                matrix(&self.pattern, values),
                Side::Lower,
                PAR,
                MemStack::new(&mut p.memory),
                Default::default(),
            );
            self.kind = Kind::Lblt;
        }
        Ok(())
    }

    fn solve_once(&mut self, b: &mut [f64]) {
        let stack = MemStack::new(&mut self.memory);
        match (self.kind, &mut self.pivoting) {
            (Kind::Lblt, Some(p)) => {
                let order = PermRef::new_checked(&p.forward, &p.inverse, self.pattern.n());
                let factor = IntranodeLbltRef::new(&self.symbolic, &self.l, &p.subdiagonal, order);
                factor.solve_in_place_with_conj(Conj::No, column(b), PAR, MemStack::new(&mut p.memory));
            }
            (Kind::Ldlt, _) => {
                LdltRef::new(&self.symbolic, &self.l).solve_in_place_with_conj(Conj::No, column(b), PAR, stack);
            }
            _ => LltRef::new(&self.symbolic, &self.l).solve_in_place_with_conj(Conj::No, column(b), PAR, stack),
        }
    }

    /// Solves for b `[n]`, refines once, and returns ||b - W x|| / ||b||; the right-hand side stays in `refinement`.
    fn solve_refined(&mut self, values: &[f64], b: &mut [f64]) -> f64 {
        let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let (mut rhs, mut product) = (std::mem::take(&mut self.refinement), std::mem::take(&mut self.product));
        rhs.clear();
        rhs.extend_from_slice(b);
        product.resize(b.len(), 0.0);
        self.solve_once(b);
        self.pattern.multiply(values, b, &mut product);
        for (p, r) in product.iter_mut().zip(&rhs) {
            *p = r - *p;
        }
        self.solve_once(&mut product);
        for (x, p) in b.iter_mut().zip(&product) {
            *x += p;
        }
        self.pattern.multiply(values, b, &mut product);
        for (p, r) in product.iter_mut().zip(&rhs) {
            *p -= r;
        }
        let relative = norm(&product) / norm(&rhs).max(f64::MIN_POSITIVE);
        (self.refinement, self.product) = (rhs, product);
        relative
    }
}

impl Cholesky {
    /// Copies the factor to single precision. Returns whether a solve with it is accurate enough for a fixed right-hand
    /// side of pseudo-random signs.
    fn try_single(&mut self, values: &[f64]) -> bool {
        let single = match &mut self.single {
            Some(single) => single,
            none => match SinglePrecisionFactor::new(&self.symbolic) {
                Some(single) => none.insert(Box::new(single)),
                None => return false,
            },
        };
        if !single.set_values(&self.l) {
            return false;
        }
        let (mut x, mut product) = (std::mem::take(&mut self.refinement), std::mem::take(&mut self.product));
        x.clear();
        x.extend((0..self.pattern.n()).map(|i| pseudo_random(i).signum()));
        product.resize(x.len(), 0.0);
        single.solve(&mut x);
        self.pattern.multiply(values, &x, &mut product);
        let left: f64 = product.iter().enumerate().map(|(i, p)| (p - pseudo_random(i).signum()).powi(2)).sum();
        let serves = left <= REUSED_RELATIVE * REUSED_RELATIVE * x.len() as f64;
        (self.refinement, self.product) = (x, product);
        serves
    }
}

impl LinearSolver for Cholesky {
    fn prepare(&mut self, values: &[f64]) -> Result<Inertia, LinearError> {
        let made = self.factor_definite(values)?;
        self.single_serves = made == Inertia::Definite && self.try_single(values);
        Ok(made)
    }

    fn factor_definite(&mut self, values: &[f64]) -> Result<Inertia, LinearError> {
        self.factorizations += 1;
        self.single_serves = false;
        check_finite(&self.pattern, values, &ALONE)?;
        let llt = timed(Phase::Factorization, || {
            self.symbolic.factorize_numeric_llt(
                &mut self.l,
                matrix(&self.pattern, values),
                Side::Lower,
                Default::default(),
                PAR,
                MemStack::new(&mut self.memory),
                Default::default(),
            )
        });
        if llt.is_ok() {
            self.kind = Kind::Llt;
            return Ok(Inertia::Definite);
        }
        self.indefinite += 1;
        Ok(Inertia::Indefinite)
    }

    fn factor(&mut self, values: &[f64]) -> Result<Inertia, LinearError> {
        if self.factor_definite(values)? == Inertia::Definite {
            return Ok(Inertia::Definite);
        }
        let w = matrix(&self.pattern, values);
        let stack = MemStack::new(&mut self.memory);
        let ldlt = self.symbolic.factorize_numeric_ldlt(
            &mut self.l,
            w,
            Side::Lower,
            Default::default(),
            PAR,
            stack,
            Default::default(),
        );
        if ldlt.is_ok() {
            self.kind = Kind::Ldlt;
            return Ok(Inertia::Indefinite);
        }
        self.factor_pivoting(values)?;
        Ok(Inertia::Indefinite)
    }

    fn solve(&mut self, values: &[f64], b: &mut [f64]) -> Result<(), LinearError> {
        let single = self.single.as_mut().filter(|_| self.single_serves && self.accuracy.allows_single());
        if let Some(single) = single {
            single.solve(b);
        } else if self.kind == Kind::Llt {
            self.solve_once(b);
        } else {
            let too_large = |relative: f64| relative.is_nan() || relative > LDLT_RESIDUAL;
            let mut relative = self.solve_refined(values, b);
            if too_large(relative) && self.kind == Kind::Ldlt {
                self.factor_pivoting(values)?;
                b.copy_from_slice(&self.refinement);
                relative = self.solve_refined(values, b);
            }
            if too_large(relative) {
                return Err(LinearError::Singular { unknown: None });
            }
        }
        check_solution(b, &ALONE)
    }

    fn set_accuracy(&mut self, accuracy: Accuracy) {
        self.accuracy = accuracy;
    }

    fn work(&self) -> SolverWork {
        SolverWork { factorizations: self.factorizations, ..SolverWork::default() }
    }

    fn stats(&self) -> LinearStats {
        LinearStats {
            name: "cholesky",
            matrix_nonzeros: self.pattern.nonzeros(),
            factor_nonzeros: Some(self.symbolic.len_val()),
            factor_operations: operations(&self.symbolic),
            indefinite: self.indefinite,
            prediction: None,
        }
    }
}
