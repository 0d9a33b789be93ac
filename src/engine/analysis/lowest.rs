//! The lowest vibration modes of a scene about a state: K phi = w^2 M phi, with the symmetric part of K.
//!
//! ```text
//! B = M^1/2 (K + s M)^-1 M^1/2,      B q = q/(w^2 + s),      phi = M^-1/2 q
//! ```
//! The largest eigenvalues of B come from a block Lanczos iteration (`krylov`).
//!
//! The shift s is about a tenth of the last w^2 that is asked for, so that its digits are not lost beside modes of
//! frequency 0, and large enough that K + s M is positive definite: so modes that grow (w^2 < 0) are among the lowest.
//! Blocks of vectors find modes that come in pairs, as those of round canopies and hanging lines do. Whether one is
//! missing is known from the number of negative eigenvalues of K - w^2 M just below the last one (a Sturm count).

use super::growing::{GrowingMotion, growing_modes, growing_together};
use super::krylov::{Krylov, Operator};
pub use super::low_mode::{LowMode, ModesError};
use super::pencil::{Factored, Pencil};
use super::vectors::dot;
use crate::model::state::StateRef;
use crate::model::stop::Stop;
use crate::scene::Scene;
use crate::solve::{Cholesky, LinearError};

/// Powers of ten of the shift over the largest ratio of a stiffness to its mass, the smallest and the largest.
const SHIFTS: [i32; 2] = [-12, 6];
/// The last w^2 that is asked for is below this power of ten of that ratio.
const HIGHEST: i32 = 1;
/// [-] Squares w^2 that differ by this share of w^2 + s are counted as one.
const CLUSTER: f64 = 1e-4;
/// [-] The same as a share of that ratio, because of rounding.
const NOISE: f64 = 64.0 * f64::EPSILON;

/// The lowest modes.
#[derive(Clone, Debug, Default)]
pub struct LowModes {
    /// ascending
    pub modes: Vec<LowMode>,
    /// whether K is symmetric; if not, they are those of its symmetric part
    pub symmetric: bool,
    /// motions that grow by themselves, the fastest first: modes, undamped; with a K that is not symmetric what modes
    /// make together with all of K and C
    pub growing: Vec<GrowingMotion>,
}

/// The lowest `count` modes of a scene about a state.
///
/// # Errors
/// See [`ModesError`].
pub fn lowest(scene: &dyn Scene, at: StateRef<'_>, count: usize, stop: Stop<'_>) -> Result<LowModes, ModesError> {
    let pencil = Pencil::of(scene, at)?;
    let (modes, symmetric) = (pencil.lowest(count, stop)?, pencil.symmetric);
    let growing = if symmetric { Some(growing_modes(&modes)) } else { growing_together(scene, at, &modes) };
    Ok(LowModes { growing: growing.ok_or(LinearError::Singular { unknown: None })?, modes, symmetric })
}

impl Pencil {
    /// The lowest `count` modes, ascending.
    ///
    /// # Errors
    /// See [`ModesError`].
    pub(crate) fn lowest(&self, count: usize, stop: Stop<'_>) -> Result<Vec<LowMode>, ModesError> {
        let unknowns = self.unknowns();
        if count > unknowns {
            return Err(ModesError::TooMany { asked: count, unknowns });
        }
        if count == 0 {
            return Ok(Vec::new());
        }
        let (solver, power) = self.power_above(self.solver()?, count, stop)?;
        let mut shifted = Shifted::above(self, solver, power - 1)?;
        let found = Krylov::largest(&mut shifted, unknowns, count, stop)?;
        let mut modes: Vec<LowMode> = found.iter().map(|q| self.mode(q, &shifted.root)).collect();
        modes.sort_by(|a, b| a.omega_squared.total_cmp(&b.omega_squared));
        Ok(modes)
    }

    /// The power of ten, over [`Pencil::fastest`], below which the square of the last of `count` modes is.
    fn power_above(&self, mut solver: Cholesky, count: usize, stop: Stop<'_>) -> Result<(Cholesky, i32), ModesError> {
        let [mut low, mut high] = [SHIFTS[0], HIGHEST];
        while high - low > 1 {
            if stop.asked() {
                return Err(ModesError::Stopped);
            }
            let middle = (low + high).div_euclid(2);
            let square = self.fastest() * 10.0_f64.powi(middle);
            let factored = self.factor_below(solver, square, 0.1 * square)?;
            *(if factored.negatives >= count { &mut high } else { &mut low }) = middle;
            solver = factored.into_solver();
        }
        Ok((solver, high))
    }

    /// A factor of K - w^2 M, whose negative eigenvalues are counted. A square that the scene has makes it singular;
    /// then one `step` below serves.
    fn factor_below(&self, solver: Cholesky, square: f64, step: f64) -> Result<Factored<'_>, LinearError> {
        match self.factor(solver, -square) {
            Err(LinearError::Singular { .. }) => self.factor(self.solver()?, step - square),
            other => other,
        }
    }

    fn mode(&self, q: &[f64], root: &[f64]) -> LowMode {
        let phi: Vec<f64> = q.iter().zip(root).map(|(q, root)| q / root).collect();
        let (mut left, mut shape) = (vec![0.0; phi.len()], vec![0.0; self.n_dof]);
        self.times(&phi, &mut left);
        let omega_squared = dot(&phi, &left);
        let inertia = phi.iter().zip(&self.mass).map(|(phi, m)| omega_squared * m * phi);
        left.iter_mut().zip(inertia).for_each(|(left, inertia)| *left -= inertia);
        let residual: f64 = left.iter().zip(&self.mass).map(|(left, m)| left * left / m).sum();
        let energy: f64 = phi.iter().zip(&self.stiffness).map(|(phi, k)| k * phi * phi).sum();
        for (&dof, phi) in self.pattern.dof.iter().zip(&phi) {
            shape[dof as usize] = *phi;
        }
        let dof = (0..shape.len()).max_by(|a, b| shape[*a].abs().total_cmp(&shape[*b].abs())).unwrap_or(0);
        if shape.get(dof).is_some_and(|largest| *largest < 0.0) {
            shape.iter_mut().for_each(|x| *x = -*x);
        }
        LowMode { omega_squared, error: residual.sqrt() + 8.0 * f64::EPSILON * energy, shape, dof }
    }
}

/// B, and what proves its largest eigenvalues complete.
struct Shifted<'a> {
    pencil: &'a Pencil,
    /// of K + s M; none only if a factorisation has failed
    factored: Option<Factored<'a>>,
    /// [1/s^2] s
    shift: f64,
    /// [kg^1/2] of M^1/2 `[n]`
    root: Vec<f64>,
}

impl<'a> Shifted<'a> {
    /// With the smallest power of ten from `power` on that makes K + s M positive definite.
    fn above(pencil: &'a Pencil, mut solver: Cholesky, power: i32) -> Result<Self, ModesError> {
        for power in power.max(SHIFTS[0])..=SHIFTS[1] {
            let shift = pencil.fastest() * 10.0_f64.powi(power);
            let factored = pencil.factor(solver, shift)?;
            if factored.negatives == 0 {
                let root = pencil.mass.iter().map(|m| m.sqrt()).collect();
                return Ok(Shifted { pencil, factored: Some(factored), shift, root });
            }
            solver = factored.into_solver();
        }
        Err(LinearError::Singular { unknown: None }.into())
    }

    /// A square just below the last one, how far it is from the last one, and how many of the others are below it.
    fn just_below(&self, squares: &[f64]) -> (f64, f64, usize) {
        let fastest = self.pencil.fastest();
        let apart = |square: f64| (CLUSTER * (square.abs() + self.shift)).max(NOISE * fastest);
        let mut below = squares.len();
        let mut lowest = squares.last().copied().unwrap_or(0.0);
        while below > 0 && lowest - squares[below - 1] <= apart(lowest) {
            below -= 1;
            lowest = squares[below];
        }
        let beside = 0.5 * apart(lowest);
        (lowest - beside, beside, below)
    }

    fn factored(&mut self) -> Result<&mut Factored<'a>, LinearError> {
        self.factored.as_mut().ok_or(LinearError::Singular { unknown: None })
    }
}

impl Operator for Shifted<'_> {
    fn times(&mut self, q: &[f64]) -> Result<Vec<f64>, LinearError> {
        let mut y: Vec<f64> = q.iter().zip(&self.root).map(|(q, root)| q * root).collect();
        self.factored()?.solve(&mut y)?;
        y.iter_mut().zip(&self.root).for_each(|(y, root)| *y *= root);
        Ok(y)
    }

    fn complete(&mut self, largest: &[f64]) -> Result<bool, LinearError> {
        let squares: Vec<f64> = largest.iter().map(|theta| 1.0 / theta - self.shift).collect();
        let (square, beside, below) = self.just_below(&squares);
        let Some(factored) = self.factored.take() else { return Err(LinearError::Singular { unknown: None }) };
        let counted = self.pencil.factor_below(factored.into_solver(), square, 0.5 * beside)?;
        let complete = counted.negatives <= below;
        if !complete {
            self.factored = Some(self.pencil.factor(counted.into_solver(), self.shift)?);
        }
        Ok(complete)
    }
}
