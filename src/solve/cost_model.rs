//! Cholesky or conjugate gradients for a W that is kept over many solves, by counted work.
//!
//! The cost of Cholesky is counted on the elimination tree of the nodes, without a symbolic factorisation. The cost of
//! conjugate gradients is the number of iterations that real solves with earlier matrices have taken. For the first
//! matrix a trial solves W x = b for a fixed pseudo-random b; it ends as soon as Cholesky would have been cheaper. So
//! the choice depends on W and on what earlier matrices have shown (`quasi_newton`), which is counted as well: not on
//! the machine.

use super::linear::{
    ASSEMBLY_FLOPS, Accuracy, DENSE_OPERATION, Expected, FACTOR, Inertia, LinearError, LinearSolver, LinearStats,
    SOLVE_FLOPS, SOLVE_SLOWNESS, Work,
};
use super::ordering::{Elimination, fill_reducing};
use super::{Cholesky, ConjugateGradients};
use crate::assembly::Pattern;
use crate::model::workers::Workers;
use crate::startup::{Phase, timed};
use std::sync::Arc;

/// [-] Entries stored of L for one that is counted: supernodes have zeros.
const PADDING: f64 = 1.3;
/// [units of work] of an entry of L in a solve (0.9 ns at 703 nodes); the costs below are in the same unit.
const SOLVE: f64 = SOLVE_SLOWNESS * SOLVE_FLOPS;
/// [units of work] of an entry of W in an iteration of conjugate gradients (1.0 to 1.5 ns).
const ITERATION: f64 = 7.5;
/// [-] Iterations of an average solve over those of the trial: its right-hand side is smoother, and the last solve of a
/// step need not be exact (0.55 to 0.75 on square nets of 10,000 and 90,000 nodes).
const EASIER: f64 = 0.65;
/// [-] What the trial may leave of its right-hand side; to leave its square, as solves may, takes twice as many
/// iterations.
const TRIAL: f64 = 0.0316;
/// [-] The first matrix gets conjugate gradients even if the trial says that they cost so many times the iterations:
/// they cost little to make, and real solves soon tell whether they are dearer, while the cost of a factor that is not
/// needed is lost.
const DOUBT: f64 = 1.3;
/// [units of work] of an entry of W in making conjugate gradients ready.
const READY: f64 = 97.5;
/// [units of work] of an unknown in one iteration around the solve: a force pass and operations on vectors.
const AROUND: f64 = 250.0;
/// [-] Entries of L over those of W from which on a factor takes several times the memory of conjugate gradients, and
/// how much less work it must then be.
const MUCH_MEMORY: f64 = 10.0;
const CLEAR_GAIN: f64 = 1.1;

/// Work of one way to solve, in counted units.
#[derive(Clone, Copy, Debug)]
struct Cost {
    /// of an iteration: a solve and what is around it
    iteration: f64,
    /// of making what a solve needs
    making: f64,
}

impl Cost {
    /// What a useful iteration costs with all that ageing brings. A matrix that is replaced when its age has cost as
    /// many iterations beyond those of a fresh one as a new one costs (`quasi_newton`), c = making/iteration, serves
    /// for u = reuse sqrt(c) useful iterations, since the cost of age grows with its square; these cost u + 2 c
    /// iterations.
    fn with_reuse(self, reuse: f64) -> f64 {
        self.iteration + 2.0 * (self.making * self.iteration).sqrt() / reuse
    }

    /// The work of an iteration with which [`Cost::with_reuse`] comes to `total`.
    fn iteration_for(making: f64, reuse: f64, total: f64) -> f64 {
        let half = making.sqrt() / reuse;
        ((half * half + total).sqrt() - half).powi(2)
    }
}

/// What a useful iteration would cost each way, its share of making what it needs and of ageing included.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Prediction {
    /// [-] by Cholesky; of these units an entry of L takes 6.4 in a solve
    pub cholesky_work: f64,
    /// [-] by conjugate gradients; where they were given up, with the iterations that made them dearer
    pub cg_work: f64,
    /// iterations of conjugate gradients in an average solve: seen, or foretold by a trial
    pub cg_iterations: u32,
    /// whether they were cheaper; else a trial was given up where Cholesky was
    pub cg_converged: bool,
    /// entries of L
    pub factor_nonzeros: f64,
    /// multiplications and additions of a factorisation
    pub factor_operations: f64,
}

/// Cholesky and conjugate gradients, each made when it is first called for.
#[derive(Debug)]
pub struct AutoSolver {
    pattern: Arc<Pattern>,
    elimination: Option<Elimination>,
    direct: Option<Cholesky>,
    cg: ConjugateGradients,
    /// whether the last matrix was given to conjugate gradients
    iterates: bool,
    /// whether the direct solver has the last matrix
    factored: bool,
    prediction: Option<Prediction>,
    /// what was asked for
    accuracy: Accuracy,
    /// what is expected of a matrix
    expected: Expected,
}

impl AutoSolver {
    /// Orders a symmetric pattern and counts what a factorisation would take.
    ///
    /// # Errors
    /// When the analysis fails, or there is nothing to choose.
    pub fn new(pattern: Arc<Pattern>, workers: &Workers) -> Result<Self, LinearError> {
        let cg = ConjugateGradients::new(pattern.clone(), workers)?;
        let elimination = timed(Phase::Ordering, || fill_reducing(&pattern));
        Ok(AutoSolver {
            pattern,
            elimination,
            direct: None,
            cg,
            iterates: false,
            factored: false,
            prediction: None,
            accuracy: Accuracy::of_reused(),
            expected: Expected::default(),
        })
    }

    fn direct(&mut self) -> Result<&mut Cholesky, LinearError> {
        match &mut self.direct {
            Some(direct) => Ok(direct),
            none => {
                let order = self.elimination.as_ref().map(|e| &e.order);
                Ok(none.insert(Cholesky::ordered(self.pattern.clone(), order)?))
            }
        }
    }

    fn cholesky_cost(&self, e: &Elimination) -> Cost {
        let (n, entries) = (self.pattern.n() as f64, self.pattern.nonzeros() as f64);
        let stored = PADDING * e.nonzeros;
        let gain = if stored > MUCH_MEMORY * entries { CLEAR_GAIN } else { 1.0 };
        let making = DENSE_OPERATION * e.operations + FACTOR * stored + ASSEMBLY_FLOPS * entries;
        Cost { iteration: gain * (SOLVE * stored + AROUND * n), making: gain * making }
    }

    /// Of conjugate gradients that take so many iterations in an average solve; to begin and to end a solve takes as
    /// long as one.
    fn cg_cost(&self, iterations: f64) -> Cost {
        let (n, entries) = (self.pattern.n() as f64, self.pattern.nonzeros() as f64);
        let iteration = ITERATION * entries * (iterations + 1.0) + AROUND * n;
        Cost { iteration, making: (READY + ASSEMBLY_FLOPS) * entries }
    }

    /// Compares the two: by the iterations of earlier solves, or, where there were none, by a trial that lasts as long
    /// as conjugate gradients may be cheaper.
    fn compare(&mut self) -> Result<Option<Prediction>, LinearError> {
        let Some(e) = &self.elimination else { return Ok(None) };
        let cholesky_work = self.cholesky_cost(e).with_reuse(self.expected.reuse);
        let (factor_nonzeros, factor_operations) = (e.nonzeros, e.operations);
        let none = self.cg_cost(0.0);
        let one = self.cg_cost(1.0).iteration - none.iteration;
        let allowed = Cost::iteration_for(none.making, self.expected.reuse, cholesky_work) - none.iteration;
        let known = self.expected.cg_iterations > 0.0;
        let allowed = allowed / one * if known { 1.0 } else { DOUBT };
        let (iterations, cg_converged) = match self.expected.cg_iterations {
            seen if known => (seen, seen <= allowed),
            _ => {
                let twice = 2.0 * EASIER;
                match self.cg.trial_solve(TRIAL, (allowed / twice).clamp(0.0, f64::from(u32::MAX)) as u32) {
                    Ok(iterations) => (twice * f64::from(iterations), true),
                    Err(LinearError::Stalled { iterations, .. }) => (twice * (f64::from(iterations) + 1.0), false),
                    Err(other) => return Err(other),
                }
            }
        };
        let cg_work = self.cg_cost(iterations).with_reuse(self.expected.reuse);
        let cg_iterations = iterations.min(if cg_converged { f64::INFINITY } else { allowed.max(0.0) }).round() as u32;
        Ok(Some(Prediction { cholesky_work, cg_work, cg_iterations, cg_converged, factor_nonzeros, factor_operations }))
    }
}

impl LinearSolver for AutoSolver {
    fn factor(&mut self, values: &[f64]) -> Result<Inertia, LinearError> {
        (self.iterates, self.factored) = (false, true);
        self.direct()?.factor(values)
    }

    fn factor_definite(&mut self, values: &[f64]) -> Result<Inertia, LinearError> {
        (self.iterates, self.factored) = (false, true);
        self.direct()?.factor_definite(values)
    }

    fn choose(&mut self, values: &[f64]) -> Result<Inertia, LinearError> {
        (self.iterates, self.factored) = (false, false);
        if self.cg.factor(values)? == Inertia::Indefinite {
            return Ok(Inertia::Indefinite);
        }
        match self.compare() {
            Err(LinearError::Indefinite { .. }) => return Ok(Inertia::Indefinite),
            found => self.prediction = found?,
        }
        self.iterates = self.prediction.is_some_and(|p| p.cg_converged);
        Ok(Inertia::Unknown)
    }

    fn prepare(&mut self, values: &[f64]) -> Result<Inertia, LinearError> {
        let inertia = self.choose(values)?;
        if self.iterates || inertia == Inertia::Indefinite {
            return Ok(inertia);
        }
        self.factored = true;
        self.direct()?.prepare(values)
    }

    fn solve(&mut self, values: &[f64], b: &mut [f64]) -> Result<(), LinearError> {
        if self.iterates {
            self.cg.ask(self.accuracy);
            match self.cg.solve(values, b) {
                // This right-hand side is harder than the one that was tried.
                Err(LinearError::Stalled { .. }) => {}
                solved => return solved,
            }
            if !self.factored && self.direct()?.prepare(values)? == Inertia::Indefinite {
                return Err(LinearError::Indefinite { iterations: 0 });
            }
            self.factored = true;
        }
        let accuracy = self.accuracy;
        let direct = self.direct()?;
        direct.ask(accuracy);
        direct.solve(values, b)
    }

    fn ask(&mut self, accuracy: Accuracy) {
        self.accuracy = accuracy;
    }

    fn anticipate(&mut self, expected: Expected) {
        self.expected = expected;
    }

    fn prefers_another(&self, Expected { reuse, cg_iterations }: Expected) -> bool {
        let (Some(e), true, true) = (&self.elimination, cg_iterations > 0.0, self.iterates) else { return false };
        self.cholesky_cost(e).with_reuse(reuse) < self.cg_cost(cg_iterations).with_reuse(reuse)
    }

    fn work(&self) -> Work {
        let factorizations = self.direct.as_ref().map_or(0, |direct| direct.work().factorizations);
        Work { factorizations, iterations: self.cg.work().iterations }
    }

    fn stats(&self) -> LinearStats {
        let prediction = self.prediction;
        match (&self.direct, self.iterates) {
            (_, true) => LinearStats { prediction, ..self.cg.stats() },
            (Some(direct), false) => LinearStats { prediction, ..direct.stats() },
            (None, false) => LinearStats {
                name: "cholesky",
                factor_nonzeros: self.elimination.as_ref().map(|e| (PADDING * e.nonzeros) as usize),
                factor_operations: self.elimination.as_ref().map(|e| e.operations),
                prediction,
                ..self.cg.stats()
            },
        }
    }
}
