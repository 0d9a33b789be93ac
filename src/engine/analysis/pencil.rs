//! K and M of a scene at rest over its unknowns, and K + s M with the number of its negative eigenvalues.
//!
//! K is the whole stiffness, that of pressures and air included; where it is not symmetric, its symmetric part.
//! Parts u g^T that couple nodes of the whole scene stay beside the sparse matrix S:
//! ```text
//! A = S + s M,    K + s M = A + U C U^T,    U = [u g],    C^-1 = [0 2; 2 0]     for every part
//! (A + U C U^T)^-1 = A^-1 - A^-1 U G^-1 U^T A^-1,    G = C^-1 + U^T A^-1 U
//! ```
//! By Sylvester's law of inertia the number of eigenvalues of K phi = w^2 M phi below -s is that of the negative pivots
//! of A, plus the positive eigenvalues of G, less one for every part (Haynsworth 1968).

use super::low_mode::ModesError;
use super::vectors::{add, dot, norm};
use crate::assembly::{Assembler, Pattern};
use crate::model::state::StateRef;
use crate::model::system::Weights;
use crate::model::workers::ALONE;
use crate::scene::Scene;
use crate::solve::{Cholesky, LinearError, LinearSolver};
use faer::{Mat, Side};
use std::sync::Arc;

/// [-] A difference between K and its transpose below this share of its largest entry is rounding.
const SYMMETRIC: f64 = 1e-12;
/// K alone.
const STIFFNESS: Weights = Weights { m: 0.0, c: 0.0, k: 1.0 };

/// K and M of a scene at a state, over its unknowns.
pub(crate) struct Pencil {
    /// of the lower triangle
    pub pattern: Arc<Pattern>,
    /// [N/m] its symmetric part, without the couplings
    values: Vec<f64>,
    /// u and g of the parts u g^T `[n]`
    couplings: Vec<[Vec<f64>; 2]>,
    /// [kg] `[n]`
    pub mass: Vec<f64>,
    pub n_dof: usize,
    /// [N/m] sum of the stiffnesses at every unknown, at rest `[n]`
    pub stiffness: Vec<f64>,
    /// slot of the diagonal entry of every unknown
    diagonal: Vec<usize>,
    /// whether K is symmetric here
    pub symmetric: bool,
}

impl Pencil {
    /// # Errors
    /// A scene without nodes, or with too many entries.
    pub(crate) fn of(scene: &dyn Scene, at: StateRef<'_>) -> Result<Self, ModesError> {
        if scene.n_dof() != 3 * scene.reference().len() {
            return Err(ModesError::NoNetwork);
        }
        let mut assembler = scene.assembler()?;
        scene.assemble(at, STIFFNESS, &mut assembler);
        let (pattern, values, skew) = symmetric_part(&assembler);
        let by_unknown = |of: &[f64]| -> Vec<f64> { pattern.dof.iter().map(|&dof| of[dof as usize]).collect() };
        let mut mass = vec![0.0; scene.n_dof()];
        scene.mass_times(&vec![1.0; scene.n_dof()], &mut mass);
        let largest = values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        let mut couplings = Vec::new();
        for which in scene.mass_parts()..scene.rank_ones() {
            let [mut u, mut g] = [vec![0.0; scene.n_dof()], vec![0.0; scene.n_dof()]];
            scene.rank_one(which, at, STIFFNESS, &mut u, &mut g);
            couplings.push([by_unknown(&u), by_unknown(&g)]);
        }
        couplings.retain(|[u, g]| norm(u) * norm(g) > SYMMETRIC * largest);
        let parallel = |[u, g]: &[Vec<f64>; 2]| dot(u, g).abs() >= (1.0 - SYMMETRIC) * norm(u) * norm(g);
        Ok(Pencil {
            symmetric: skew <= SYMMETRIC * largest && couplings.iter().all(parallel),
            mass: by_unknown(&mass),
            stiffness: by_unknown(&scene.nodal_stiffness()),
            diagonal: (0..pattern.n() as u32).filter_map(|i| Some(pattern.slot(i, i)? as usize)).collect(),
            n_dof: scene.n_dof(),
            pattern: Arc::new(pattern),
            values,
            couplings,
        })
    }

    /// Number of unknowns.
    pub(crate) fn unknowns(&self) -> usize {
        self.mass.len()
    }

    /// [N/m] The diagonal of K `[n]`.
    pub(crate) fn diagonal(&self) -> Vec<f64> {
        let of_couplings = |i: usize| self.couplings.iter().map(|[u, g]| u[i] * g[i]).sum::<f64>();
        self.diagonal.iter().enumerate().map(|(i, &slot)| self.values[slot] + of_couplings(i)).collect()
    }

    /// Adds springs to the ground [N/m] `[n]`.
    pub(crate) fn add_diagonal(&mut self, stiffness: impl Iterator<Item = f64>) {
        self.diagonal.iter().zip(stiffness).for_each(|(&slot, k)| self.values[slot] += k);
    }

    /// [1/s^2] The largest ratio of a stiffness to its mass; 1 without any.
    pub(crate) fn fastest(&self) -> f64 {
        let ratios = self.stiffness.iter().zip(&self.mass).filter(|(_, m)| **m > 0.0).map(|(k, m)| k / m);
        Some(ratios.fold(0.0, f64::max)).filter(|fastest| *fastest > 0.0).unwrap_or(1.0)
    }

    /// y = K p `[n]`
    pub(crate) fn times(&self, p: &[f64], y: &mut [f64]) {
        self.pattern.multiply(&self.values, p, y);
        for [u, g] in &self.couplings {
            let along = [dot(g, p), dot(u, p)];
            add(y, 0.5 * along[0], u);
            add(y, 0.5 * along[1], g);
        }
    }

    /// A solver for [`Pencil::factor`].
    ///
    /// # Errors
    /// When the analysis of the pattern runs out of memory or index range.
    pub(crate) fn solver(&self) -> Result<Cholesky, LinearError> {
        Cholesky::new(self.pattern.clone(), &ALONE)
    }

    /// Factorises K + s M.
    ///
    /// # Errors
    /// When it is singular.
    pub(crate) fn factor<'a>(&'a self, mut solver: Cholesky, s: f64) -> Result<Factored<'a>, LinearError> {
        let mut values = self.values.clone();
        self.diagonal.iter().zip(&self.mass).for_each(|(&slot, m)| values[slot] += s * m);
        let pivots = solver.factor_with_inertia(&values)?;
        let columns: Vec<&[f64]> = self.couplings.iter().flatten().map(Vec::as_slice).collect();
        let mut solved = Vec::new();
        for column in &columns {
            let mut x = column.to_vec();
            solver.solve(&values, &mut x)?;
            solved.push(x);
        }
        let m = columns.len();
        let between = |i: usize, j: usize| 0.5 * (dot(columns[i], &solved[j]) + dot(columns[j], &solved[i]));
        let pair = |i: usize, j: usize| if i != j && i / 2 == j / 2 { 2.0 } else { 0.0 };
        let g = Mat::from_fn(m, m, |i, j| pair(i, j) + between(i, j));
        let (mut inverse, mut positive) = (Mat::zeros(m, m), 0);
        if m > 0 {
            let eigen = g.self_adjoint_eigen(Side::Lower).map_err(|_| LinearError::Singular { unknown: None })?;
            for (k, &value) in eigen.S().column_vector().iter().enumerate() {
                positive += usize::from(value > 0.0);
                inverse += eigen.U().col(k) * eigen.U().col(k).transpose() * faer::Scale(1.0 / value);
            }
        }
        let negatives = (pivots + positive).saturating_sub(m / 2);
        Ok(Factored { pencil: self, solver, values, solved, inverse, negatives })
    }

    /// Whether K is positive definite.
    pub(crate) fn is_definite(&self) -> bool {
        self.solver().and_then(|solver| self.factor(solver, 0.0)).is_ok_and(|factored| factored.negatives == 0)
    }
}

/// A factor of K + s M.
pub(crate) struct Factored<'a> {
    pencil: &'a Pencil,
    solver: Cholesky,
    values: Vec<f64>,
    /// A^-1 U, by columns
    solved: Vec<Vec<f64>>,
    /// G^-1
    inverse: Mat<f64>,
    /// number of its negative eigenvalues: that of the squares w^2 below -s
    pub negatives: usize,
}

impl Factored<'_> {
    /// Solves for b `[n]`.
    ///
    /// # Errors
    /// When it is too close to singular.
    pub(crate) fn solve(&mut self, b: &mut [f64]) -> Result<(), LinearError> {
        self.solver.solve(&self.values, b)?;
        let along: Vec<f64> = self.pencil.couplings.iter().flatten().map(|column| dot(column, b)).collect();
        for (i, x) in self.solved.iter().enumerate() {
            let share: f64 = along.iter().enumerate().map(|(j, along)| self.inverse[(i, j)] * along).sum();
            add(b, -share, x);
        }
        Ok(())
    }

    /// The solver, for another factor.
    pub(crate) fn into_solver(self) -> Cholesky {
        self.solver
    }
}

/// The symmetric part of a matrix on the lower triangle, and the largest entry of the other part.
fn symmetric_part(of: &Assembler) -> (Pattern, Vec<f64>, f64) {
    let pattern = &*of.pattern;
    if pattern.symmetric {
        return (pattern.clone(), of.values().to_vec(), 0.0);
    }
    let columns = (0..pattern.n() as u32).flat_map(|j| pattern.column(j as usize).iter().map(move |&i| (i, j)));
    let halves = columns.zip(of.values()).map(|((i, j), value)| ((i.min(j), i.max(j)), i > j, 0.5 * value));
    let mut halves: Vec<_> = halves.collect();
    halves.sort_unstable_by_key(|&(place, below, _)| (place, below));
    let mut lower = Pattern { symmetric: true, col_ptr: vec![0], row_idx: Vec::new(), ..pattern.clone() };
    let (mut values, mut skew) = (Vec::new(), 0.0_f64);
    for entry in halves.chunk_by(|a, b| a.0 == b.0) {
        let (j, i) = entry[0].0;
        while lower.col_ptr.len() <= j as usize {
            lower.col_ptr.push(values.len() as u32);
        }
        let both: f64 = entry.iter().map(|(.., value)| value).sum();
        lower.row_idx.push(i);
        values.push(if i == j { 2.0 * both } else { both });
        let difference: f64 = entry.iter().map(|&(_, below, value)| if below { value } else { -value }).sum();
        skew = skew.max(if i == j { 0.0 } else { difference.abs() });
    }
    lower.col_ptr.resize(pattern.n() + 1, values.len() as u32);
    (lower, values, skew)
}
