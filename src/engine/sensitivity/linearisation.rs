//! The tangents of a stage: M, K and C at its state, and W = M + alpha K + beta C with its factor.

use crate::assembly::{Assembler, PatternError};
use crate::model::state::StateRef;
use crate::model::system::Weights;
use crate::scene::Scene;
use crate::solve::norms::dot;
use crate::solve::{LinearChoice, LinearError, LinearSolver, solver_for};

/// M, C or K: its entries on the pattern, and its parts u g^T beside them.
#[derive(Clone, Debug, Default)]
struct Matrix {
    values: Vec<f64>,
    parts: Vec<[Vec<f64>; 2]>,
}

/// A part of W with z = W^-1 u, where W has the parts before, and 1 + g . z.
struct SolvedPart {
    g: Vec<f64>,
    z: Vec<f64>,
    divisor: f64,
}

/// The tangents of a stage, over the free degrees of freedom.
pub(super) struct Linearisation {
    assembler: Assembler,
    mass: Matrix,
    damping: Matrix,
    stiffness: Matrix,
    whole: Matrix,
    parts: Vec<SolvedPart>,
    solver: Option<Box<dyn LinearSolver>>,
    /// whether W is more than M and its parts
    implicit: bool,
    /// factorisations so far
    pub(super) factorizations: u64,
    dofs: [Vec<f64>; 2],
}

const MASS: Weights = Weights { m: 1.0, c: 0.0, k: 0.0 };
const DAMPING: Weights = Weights { m: 0.0, c: 1.0, k: 0.0 };
const STIFFNESS: Weights = Weights { m: 0.0, c: 0.0, k: 1.0 };

impl Linearisation {
    /// For a scene between two events.
    pub(super) fn new(scene: &dyn Scene) -> Result<Self, PatternError> {
        let [mass, damping, stiffness, whole] = [(); 4].map(|()| Matrix::default());
        let dofs = [(); 2].map(|()| vec![0.0; scene.n_dof()]);
        let assembler = scene.assembler()?;
        let (parts, solver) = (Vec::new(), None);
        Ok(Linearisation {
            assembler,
            mass,
            damping,
            stiffness,
            whole,
            parts,
            solver,
            implicit: false,
            factorizations: 0,
            dofs,
        })
    }

    /// Number of free degrees of freedom.
    pub(super) fn n(&self) -> usize {
        self.assembler.pattern.n()
    }

    /// Picks the free degrees of freedom of a vector.
    pub(super) fn pick(&self, all: &[f64], own: &mut [f64]) {
        own.iter_mut().zip(&self.assembler.pattern.dof).for_each(|(own, &dof)| *own = all[dof as usize]);
    }

    /// Puts them back; others stay.
    pub(super) fn put(&self, own: &[f64], all: &mut [f64]) {
        own.iter().zip(&self.assembler.pattern.dof).for_each(|(own, &dof)| all[dof as usize] = *own);
    }

    /// Finds the tangents at a state, and factorises W with the shares alpha [s^2] and beta [s] of the stage's
    /// acceleration in its state.
    pub(super) fn set(
        &mut self,
        scene: &dyn Scene,
        at: StateRef<'_>,
        [alpha, beta]: [f64; 2],
    ) -> Result<(), LinearError> {
        let mut mass = std::mem::take(&mut self.mass);
        let mut damping = std::mem::take(&mut self.damping);
        let mut stiffness = std::mem::take(&mut self.stiffness);
        let mut whole = std::mem::take(&mut self.whole);
        self.find(scene, at, MASS, &mut mass);
        self.find(scene, at, DAMPING, &mut damping);
        self.find(scene, at, STIFFNESS, &mut stiffness);
        self.implicit = alpha != 0.0 || beta != 0.0;
        self.find(scene, at, Weights { m: 1.0, c: beta, k: alpha }, &mut whole);
        (self.mass, self.damping, self.stiffness, self.whole) = (mass, damping, stiffness, whole);
        if self.implicit {
            let solver = match &mut self.solver {
                Some(solver) => solver,
                None => {
                    let made = solver_for(self.assembler.pattern.clone(), LinearChoice::Auto, scene.workers())?;
                    self.solver.insert(made)
                }
            };
            solver.factor(&self.whole.values)?;
            self.factorizations += 1;
        }
        self.parts.clear();
        for [u, g] in std::mem::take(&mut self.whole.parts) {
            let mut z = u;
            self.solve(&mut z)?;
            let divisor = 1.0 + dot(&g, &z);
            if divisor == 0.0 || !divisor.is_finite() {
                return Err(LinearError::Singular { unknown: None });
            }
            self.parts.push(SolvedPart { g, z, divisor });
        }
        Ok(())
    }

    fn find(&mut self, scene: &dyn Scene, at: StateRef<'_>, weights: Weights, to: &mut Matrix) {
        scene.assemble(at, weights, &mut self.assembler);
        to.values.clear();
        to.values.extend_from_slice(self.assembler.values());
        to.parts.clear();
        let (n, [u, g]) = (self.n(), &mut self.dofs);
        for which in 0..scene.rank_ones() {
            scene.rank_one(which, at, weights, u, g);
            let picked = [&*u, &*g].map(|all| -> Vec<f64> {
                self.assembler.pattern.dof.iter().map(|&dof| all[dof as usize]).take(n).collect()
            });
            if picked.iter().all(|part| part.iter().any(|value| *value != 0.0)) {
                to.parts.push(picked);
            }
        }
    }

    /// out = K x + C v, all `[n]`.
    pub(super) fn forces(&self, x: &[f64], v: &[f64], out: &mut [f64]) {
        let mut other = vec![0.0; out.len()];
        self.times(&self.stiffness, x, out);
        self.times(&self.damping, v, &mut other);
        out.iter_mut().zip(&other).for_each(|(out, other)| *out += other);
    }

    /// out = M y.
    pub(super) fn mass_times(&self, y: &[f64], out: &mut [f64]) {
        self.times(&self.mass, y, out);
    }

    fn times(&self, Matrix { values, parts }: &Matrix, y: &[f64], out: &mut [f64]) {
        self.assembler.pattern.multiply(values, y, out);
        for [u, g] in parts {
            let share = dot(g, y);
            out.iter_mut().zip(u).for_each(|(out, u)| *out += share * u);
        }
    }

    /// Replaces b `[n]` by W^-1 b.
    pub(super) fn solve(&mut self, b: &mut [f64]) -> Result<(), LinearError> {
        self.solve_entries(b)?;
        for SolvedPart { g, z, divisor } in &self.parts {
            let share = dot(g, b) / divisor;
            b.iter_mut().zip(z).for_each(|(b, z)| *b -= share * z);
        }
        Ok(())
    }

    /// The same for the entries of W on the pattern alone.
    fn solve_entries(&mut self, b: &mut [f64]) -> Result<(), LinearError> {
        match (&mut self.solver, self.implicit) {
            (Some(solver), true) => solver.solve(&self.whole.values, b),
            _ => {
                let pattern = &self.assembler.pattern;
                for (i, b) in (0..).zip(b.iter_mut()) {
                    let mass = pattern.slot(i, i).and_then(|slot| self.whole.values.get(slot as usize));
                    *b /= mass.copied().unwrap_or(f64::NAN);
                }
                Ok(())
            }
        }
    }
}
