//! The lowest vibration modes of a scene about a state: K phi = w^2 M phi, with the symmetric part of K.
//!
//! ```text
//! B = M^1/2 (K + s M)^-1 M^1/2,      B q = q/(w^2 + s),      phi = M^-1/2 q
//! ```
//! The largest eigenvalues of B come from a block Lanczos iteration with full orthogonalisation and restarts that keep
//! the best vectors (Grimes, Lewis & Simon 1994; Wu & Simon 2000). Blocks find the modes that come in pairs, as those of
//! round canopies and hanging lines do. The shift s is the smallest, in steps of ten, that makes K + s M positive
//! definite: then no mode is missed, not even one that grows (w^2 < 0).

use super::vectors::{add, dot, norm, orthogonalise};
use crate::assembly::{Assembler, PatternError};
use crate::mesh::random::pseudo_random;
use crate::model::state::StateRef;
use crate::model::stop::Stop;
use crate::model::system::Weights;
use crate::scene::Scene;
use crate::solve::{Cholesky, Inertia, LinearError, LinearSolver};
use faer::{Mat, Side};

/// Vectors that are multiplied at a time, which finds modes of this multiplicity.
const BLOCK: usize = 4;
/// [-] Residual of a mode over its eigenvalue of B: the error of the eigenvalue is about its square.
const GOOD: f64 = 1e-8;
/// Multiplications by B after which the iteration gives up, for each mode.
const SOLVES_A_MODE: usize = 200;
/// [-] A vector that orthogonalisation leaves shorter than this share is rounding.
const NOTHING_LEFT: f64 = 1e-10;
/// [-] The first shift over the largest ratio of a stiffness to its mass.
const FIRST_SHIFT: f64 = 1e-12;

/// A mode of vibration.
#[derive(Clone, Debug)]
pub struct LowMode {
    /// [1/s^2] square of the angular frequency; below 0 for a motion that grows
    pub omega_squared: f64,
    /// displacements phi with phi.M phi = 1 kg, `[n_dof]`; the largest component is positive
    pub shape: Vec<f64>,
    /// degree of freedom that moves most
    pub dof: usize,
}

impl LowMode {
    /// [Hz] Frequency; 0 for a motion that grows.
    pub fn frequency(&self) -> f64 {
        self.omega_squared.max(0.0).sqrt() / std::f64::consts::TAU
    }
}

/// Why modes cannot be found.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
pub enum ModesError {
    /// A scene without nodes.
    #[error("modes are those of a network, and this scene is none")]
    NoNetwork,
    /// More modes than the scene has.
    #[error("{asked} modes were asked for, but the scene has {unknowns} free degrees of freedom")]
    TooMany {
        /// modes
        asked: usize,
        /// unknowns
        unknowns: usize,
    },
    /// The matrix has no pattern.
    #[error(transparent)]
    Pattern(#[from] PatternError),
    /// The matrix cannot be factorised.
    #[error(transparent)]
    Linear(#[from] LinearError),
    /// The iteration has reached its bound.
    #[error("{found} of {asked} modes were found in {solves} solves; ask for fewer")]
    NotConverged {
        /// modes that are accurate
        found: usize,
        /// modes
        asked: usize,
        /// solves made
        solves: usize,
    },
    /// It was stopped.
    #[error("the search for modes was interrupted")]
    Stopped,
}

/// K and M of a scene at a state, over its unknowns.
pub(crate) struct Pencil {
    pub assembler: Assembler,
    /// [kg] `[n]`
    mass: Vec<f64>,
    n_dof: usize,
    /// [N/m] sum of the stiffnesses at every unknown, at rest `[n]`
    pub stiffness: Vec<f64>,
    /// slot of the diagonal entry of every unknown
    diagonal: Vec<usize>,
}

impl Pencil {
    /// # Errors
    /// A scene without nodes, or with too many entries.
    pub fn of(scene: &dyn Scene, at: StateRef<'_>) -> Result<Self, ModesError> {
        let mut assembler = scene.symmetric_assembler()?.ok_or(ModesError::NoNetwork)?;
        scene.assemble_symmetric(at, Weights { m: 0.0, c: 0.0, k: 1.0 }, false, &mut assembler);
        let pattern = &assembler.pattern;
        let by_unknown = |of: &[f64]| -> Vec<f64> { pattern.dof.iter().map(|&dof| of[dof as usize]).collect() };
        let mut mass = vec![0.0; scene.n_dof()];
        scene.mass_times(&vec![1.0; scene.n_dof()], &mut mass);
        let (mass, stiffness) = (by_unknown(&mass), by_unknown(&scene.nodal_stiffness()));
        let diagonal = (0..pattern.n() as u32).filter_map(|i| Some(pattern.slot(i, i)? as usize)).collect();
        Ok(Pencil { mass, stiffness, diagonal, n_dof: scene.n_dof(), assembler })
    }

    /// [N/m] The diagonal of K `[n]`.
    pub fn diagonal(&self) -> Vec<f64> {
        self.diagonal.iter().map(|&slot| self.assembler.values()[slot]).collect()
    }

    /// Adds springs to the ground [N/m] `[n]`.
    pub fn add_diagonal(&mut self, stiffness: impl Iterator<Item = f64>) {
        let values = self.assembler.values_mut();
        self.diagonal.iter().zip(stiffness).for_each(|(&slot, k)| values[slot] += k);
    }

    /// Whether K + s M is positive definite; then `solver` has its factor.
    fn definite(&self, solver: &mut Cholesky, s: f64) -> Result<(bool, Vec<f64>), LinearError> {
        let mut values = self.assembler.values().to_vec();
        self.diagonal.iter().zip(&self.mass).for_each(|(&slot, m)| values[slot] += s * m);
        Ok((solver.factor_definite(&values)? == Inertia::Definite, values))
    }

    /// Number of unknowns.
    pub fn unknowns(&self) -> usize {
        self.mass.len()
    }

    /// Whether K is positive definite.
    pub fn is_definite(&self) -> bool {
        let solver = Cholesky::new(self.assembler.pattern.clone());
        solver.is_ok_and(|mut solver| self.definite(&mut solver, 0.0).is_ok_and(|(definite, _)| definite))
    }

    /// [1/s^2] The largest ratio of a stiffness to its mass; 1 without any.
    pub fn fastest(&self) -> f64 {
        let ratios = self.stiffness.iter().zip(&self.mass).filter(|(_, m)| **m > 0.0).map(|(k, m)| k / m);
        Some(ratios.fold(0.0, f64::max)).filter(|fastest| *fastest > 0.0).unwrap_or(1.0)
    }

    /// The lowest `count` modes, ascending.
    ///
    /// # Errors
    /// See [`ModesError`].
    pub fn lowest(&self, count: usize, stop: Stop<'_>) -> Result<Vec<LowMode>, ModesError> {
        let unknowns = self.mass.len();
        if count > unknowns {
            return Err(ModesError::TooMany { asked: count, unknowns });
        }
        let mut solver = Cholesky::new(self.assembler.pattern.clone())?;
        let mut shift = FIRST_SHIFT * self.fastest();
        let values = loop {
            match self.definite(&mut solver, shift)? {
                (true, values) => break values,
                (false, _) if shift > 1e6 * self.fastest() => {
                    return Err(LinearError::Singular { unknown: None }.into());
                }
                (false, _) => shift *= 10.0,
            }
        };
        let root: Vec<f64> = self.mass.iter().map(|m| m.sqrt()).collect();
        let mut krylov = Krylov { basis: Vec::new(), images: Vec::new(), count };
        let mut failed = None;
        let mut times = |q: &[f64]| {
            let mut y: Vec<f64> = q.iter().zip(&root).map(|(q, root)| q * root).collect();
            if let Err(error) = solver.solve(&values, &mut y) {
                failed.get_or_insert(error);
            }
            y.iter_mut().zip(&root).for_each(|(y, root)| *y *= root);
            y
        };
        let found = krylov.largest(unknowns, stop, &mut times);
        match failed {
            Some(error) => Err(error.into()),
            None => Ok(found?.into_iter().map(|ritz| self.mode(&ritz, shift, &root)).collect()),
        }
    }

    fn mode(&self, (theta, q): &(f64, Vec<f64>), shift: f64, root: &[f64]) -> LowMode {
        let mut shape = vec![0.0; self.n_dof];
        for ((&dof, q), root) in self.assembler.pattern.dof.iter().zip(q).zip(root) {
            shape[dof as usize] = q / root;
        }
        let dof = (0..shape.len()).max_by(|a, b| shape[*a].abs().total_cmp(&shape[*b].abs())).unwrap_or(0);
        if shape.get(dof).is_some_and(|largest| *largest < 0.0) {
            shape.iter_mut().for_each(|x| *x = -*x);
        }
        LowMode { omega_squared: 1.0 / theta - shift, shape, dof }
    }
}

/// The lowest `count` modes of a scene about a state, ascending.
///
/// # Errors
/// See [`ModesError`].
pub fn lowest(scene: &dyn Scene, at: StateRef<'_>, count: usize, stop: Stop<'_>) -> Result<Vec<LowMode>, ModesError> {
    Pencil::of(scene, at)?.lowest(count, stop)
}

/// An orthonormal basis with its images.
struct Krylov {
    basis: Vec<Vec<f64>>,
    images: Vec<Vec<f64>>,
    count: usize,
}

impl Krylov {
    /// Ritz pairs of the largest eigenvalues of a symmetric positive definite operator, descending.
    fn largest(
        &mut self,
        n: usize,
        stop: Stop<'_>,
        times: &mut impl FnMut(&[f64]) -> Vec<f64>,
    ) -> Result<Vec<(f64, Vec<f64>)>, ModesError> {
        let asked = self.count;
        let most = (3 * asked + 8 * BLOCK).min(n);
        let bound = SOLVES_A_MODE * (asked + BLOCK);
        let seeds = (0..BLOCK.min(n)).map(|k| (0..n).map(|i| pseudo_random(i + k * n)).collect());
        let mut block: Vec<Vec<f64>> = Vec::new();
        seeds.for_each(|seed| self.take(seed, &mut block));
        let (mut solves, mut found) = (0, 0);
        while solves < bound {
            if stop.asked() {
                return Err(ModesError::Stopped);
            }
            solves += block.len();
            let images: Vec<Vec<f64>> = block.iter().map(|q| times(q)).collect();
            self.basis.append(&mut block);
            for image in &images {
                self.take(image.clone(), &mut block);
            }
            self.images.extend(images);
            if self.basis.len() < asked && !block.is_empty() {
                continue;
            }
            let ritz = self.ritz()?;
            found = ritz.iter().take(asked).filter(|one| one.residual <= GOOD * one.value.abs()).count();
            if found == asked || block.is_empty() {
                return Ok(ritz.into_iter().take(asked).map(|one| (one.value, one.vector)).collect());
            }
            if self.basis.len() + block.len() > most {
                let kept = ritz.into_iter().take(asked + BLOCK);
                (self.basis, self.images) = kept.map(|one| (one.vector, one.image)).unzip();
            }
        }
        Err(ModesError::NotConverged { found, asked, solves })
    }

    /// Appends a vector to a block, made orthogonal to the basis and to the block, if something is left of it.
    fn take(&self, mut q: Vec<f64>, block: &mut Vec<Vec<f64>>) {
        let whole = norm(&q);
        let mut left = whole;
        // A second time, because each set disturbs what the other has made.
        for _ in 0..2 {
            orthogonalise(&mut q, &self.basis, |_, _| {});
            left = orthogonalise(&mut q, block, |_, _| {});
        }
        if left > NOTHING_LEFT * whole && left.is_finite() {
            q.iter_mut().for_each(|q| *q /= left);
            block.push(q);
        }
    }

    /// All Ritz pairs, the largest first; vectors and residuals of the first ones only.
    fn ritz(&self) -> Result<Vec<Ritz>, ModesError> {
        let m = self.basis.len();
        let projected = Mat::from_fn(m, m, |i, j| dot(&self.basis[i.max(j)], &self.images[i.min(j)]));
        let eigen = projected.self_adjoint_eigen(Side::Lower).map_err(|_| LinearError::Singular { unknown: None })?;
        let pick = |k: usize| {
            let value = eigen.S().column_vector()[k];
            let n = self.basis.first().map_or(0, Vec::len);
            let (mut vector, mut image) = (vec![0.0; n], vec![0.0; n]);
            for (i, (q, of_q)) in self.basis.iter().zip(&self.images).enumerate() {
                add(&mut vector, eigen.U()[(i, k)], q);
                add(&mut image, eigen.U()[(i, k)], of_q);
            }
            let left: f64 = image.iter().zip(&vector).map(|(y, q)| (y - value * q).powi(2)).sum();
            Ritz { value, vector, image, residual: left.sqrt() }
        };
        Ok((0..m).rev().take(self.count + BLOCK).map(pick).collect())
    }
}

/// An approximate eigenpair.
struct Ritz {
    value: f64,
    vector: Vec<f64>,
    /// the operator times the vector
    image: Vec<f64>,
    /// norm of image - value vector
    residual: f64,
}
