//! Cholesky or conjugate gradients for a W that is kept over many solves, by counted work.
//!
//! The cost of Cholesky is counted on the elimination tree of the nodes, without a symbolic factorisation. The cost of conjugate gradients is
//! the number of iterations that they take to solve W x = b for a fixed pseudo-random b; this trial ends as soon as Cholesky would have been
//! cheaper. So the choice depends on W alone: not on the machine, nor on what was solved before.

use super::linear::{
    ASSEMBLY_FLOPS, Accuracy, Inertia, KEPT_RELATIVE, LinearError, LinearSolver, LinearStats, SOLVE_FLOPS,
    SOLVE_SLOWNESS, Work,
};
use super::ordering::{Elimination, fill_reducing};
use super::{Cholesky, ConjugateGradients};
use crate::assembly::Pattern;
use crate::model::workers::Workers;
use crate::startup::{Phase, timed};
use std::sync::Arc;

/// [solves] that a factor serves before it is made anew (cloths of 703 nodes in steps of 1 and 10 ms: 17 to 60), and that a matrix of
/// conjugate gradients serves (11 to 500).
const SERVED: [f64; 2] = [20.0, 16.0];
/// [-] Entries stored of L for one that is counted: supernodes have zeros.
const PADDING: f64 = 1.3;
/// [units of work] of an entry of L in a solve (0.9 ns at 703 nodes); the costs below are in the same unit.
const SOLVE: f64 = SOLVE_SLOWNESS * SOLVE_FLOPS;
/// [units of work] of an operation in a factorisation, where dense blocks make it cheap.
const OPERATION: f64 = 0.25;
/// [units of work] of an entry of L in a factorisation, besides the operations.
const FACTOR: f64 = 68.0;
/// [units of work] of an entry of W in an iteration of conjugate gradients (1.0 to 1.5 ns).
const ITERATION: f64 = 7.5;
/// [units of work] of an entry of W in making conjugate gradients ready.
const READY: f64 = 97.5;
/// [units of work] of an unknown in one iteration around the solve: a force pass and operations on vectors.
const AROUND: f64 = 250.0;
/// [-] Iterations around the solves when these are by conjugate gradients, over those around exact solves (1 to 2).
const MORE: f64 = 1.2;

/// What a solve would cost each way, its share of making what it needs and the iteration around it included.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Prediction {
    /// [-] by Cholesky; of these units an entry of L takes 6.4 in a solve
    pub cholesky_work: f64,
    /// [-] by conjugate gradients; where they were given up, with the one iteration more that made them dearer
    pub cg_work: f64,
    /// iterations of conjugate gradients
    pub cg_iterations: u32,
    /// whether they came to an end; else they were given up where Cholesky was cheaper
    pub cg_converged: bool,
    /// entries of L
    pub factor_nonzeros: f64,
    /// multiplications and additions of a factorisation
    pub factor_operations: f64,
}

/// Cholesky and conjugate gradients, each made when it is first called for.
#[derive(Debug)]
pub struct Weighed {
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
}

impl Weighed {
    /// Orders a symmetric pattern and counts what a factorisation would take.
    ///
    /// # Errors
    /// When the analysis fails, or there is nothing to choose.
    pub fn new(pattern: Arc<Pattern>, workers: &Workers) -> Result<Self, LinearError> {
        let cg = ConjugateGradients::new(pattern.clone(), workers)?;
        let elimination = timed(Phase::Ordering, || fill_reducing(&pattern));
        Ok(Weighed {
            pattern,
            elimination,
            direct: None,
            cg,
            iterates: false,
            factored: false,
            prediction: None,
            accuracy: Accuracy::kept(),
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

    /// Counted work of a solve by Cholesky, and by conjugate gradients that make no iteration.
    fn fixed_costs(&self, e: &Elimination) -> [f64; 2] {
        let (n, entries) = (self.pattern.n() as f64, self.pattern.nonzeros() as f64);
        let stored = PADDING * e.nonzeros;
        let factor = OPERATION * e.operations + FACTOR * stored;
        let making = [factor + ASSEMBLY_FLOPS * entries, (READY + ASSEMBLY_FLOPS) * entries];
        let cholesky = SOLVE * stored + making[0] / SERVED[0] + AROUND * n;
        // To begin and to end a solve takes as long as an iteration.
        [cholesky, MORE * (ITERATION * entries + making[1] / SERVED[1] + AROUND * n)]
    }

    /// Tries conjugate gradients on W, as long as they may be cheaper.
    fn weigh(&mut self) -> Result<Option<Prediction>, LinearError> {
        let Some(e) = &self.elimination else { return Ok(None) };
        let [cholesky_work, none] = self.fixed_costs(e);
        let (factor_nonzeros, factor_operations) = (e.nonzeros, e.operations);
        let one = MORE * ITERATION * self.pattern.nonzeros() as f64;
        let most = ((cholesky_work - none) / one).clamp(0.0, f64::from(u32::MAX)) as u32;
        let (cg_iterations, cg_converged) = match self.cg.rehearse(KEPT_RELATIVE, most) {
            Ok(iterations) => (iterations, true),
            Err(LinearError::Stalled { iterations, .. }) => (iterations, false),
            Err(other) => return Err(other),
        };
        let made = f64::from(cg_iterations) + if cg_converged { 0.0 } else { 1.0 };
        let cg_work = none + one * made;
        Ok(Some(Prediction { cholesky_work, cg_work, cg_iterations, cg_converged, factor_nonzeros, factor_operations }))
    }
}

impl LinearSolver for Weighed {
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
        match self.weigh() {
            Err(LinearError::Indefinite { .. }) => return Ok(Inertia::Indefinite),
            weighed => self.prediction = weighed?,
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
