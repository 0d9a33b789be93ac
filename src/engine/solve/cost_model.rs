//! Chooses between Cholesky and conjugate gradients (CG) by counted work, for a W that is reused over many solves or a
//! large one that is solved with once.
//!
//! The cost of Cholesky is counted on the elimination tree of the nodes, without a symbolic factorisation. The cost of
//! CG is the number of iterations that solves with earlier matrices have taken. For the first matrix a trial solves
//! W x = b for a fixed pseudo-random b; it stops as soon as Cholesky would be cheaper. A trial sees how fast most of a
//! residual falls; a hem or a chain that is far stiffer than the rest keeps the last of it. So CG is not tried on such
//! a W, and no solve may cost more than to factorise W and to solve with the factor. The choice depends on W and on
//! counts of earlier solves (`quasi_newton`), not on the machine.

use super::linear::{Accuracy, ExpectedUse, Inertia, LinearError, LinearSolver, LinearStats, SolverWork};
use super::ordering::{Elimination, fill_reducing};
use super::{Cholesky, ConjugateGradients};
use crate::assembly::Pattern;
use crate::model::workers::Workers;
use crate::startup::{Phase, timed};
use std::sync::Arc;

/// [-] Iterations of an average solve over those of the trial. Its right-hand side is smoother, and the last solve of a
/// step need not be exact: 0.55 to 0.75 on square nets of 10,000 and 90,000 nodes.
const EASIER: f64 = 0.65;
/// [-] Iterations of an average solve over those of the trial where a matrix needs multigrid. There all right-hand
/// sides take about as many.
const MULTIGRID_TRIAL: f64 = 1.7;
/// [-] Iterations of a solve with a matrix that is used once over those of one with a reused matrix. Newton's iteration
/// asks the first to leave 1e-3 of its right-hand side, as of a reused one, and later ones to leave less.
const ONCE: f64 = 1.5;
/// [-] Without multigrid the first matrix gets CG even if the trial predicts this many times the affordable iterations.
/// CG costs little to set up and real solves soon show if it is dearer; the cost of an unneeded factor is lost.
const DOUBT: f64 = 1.3;

/// [-] Diagonal entry of W over the median from which a node is far stiffer than the rest, and how many such nodes make
/// a chain that takes CG about as many iterations. A payload is one node, or four.
const FAR_STIFFER: f64 = 1e3;
const CHAIN: usize = 32;
/// [-] A solve that was given up counts as this many times its iterations: how many it would have taken is not known.
const GIVEN_UP: f64 = 10.0;

/// Costs of solvers in units of work: a multiplication and addition at the speed of memory, about 0.14 ns. The values
/// were fitted to times of nets of 703 to 90,000 nodes on one thread, those of multigrid of 10,000 to 250,000.
#[derive(Clone, Copy, Debug)]
pub(super) struct CostModel {
    /// an entry of L in a solve: 4 flop at 1.6 times the cost of a flop in dense blocks, as a solve waits for memory
    factor_solve: f64,
    /// a multiplication and addition in the dense blocks of a factorisation
    factor_operation: f64,
    /// an entry of L in a factorisation, besides its operations
    factor_entry: f64,
    /// [-] entries of L that are stored for each that is counted: supernodes contain zeros
    padding: f64,
    /// an entry of W in an assembly
    assembly: f64,
    /// an entry of W in an iteration of CG (0.6 to 1.5 ns)
    cg_iteration: f64,
    /// an entry of W in setting up CG without multigrid
    cg_setup: f64,
    /// the same with multigrid (18 to 25 ns)
    multigrid_setup: f64,
    /// an unknown in a Newton iteration outside the solve, compared with CG: force pass and vector operations
    newton: f64,
    /// the same, compared with a factorisation
    newton_on_factor: f64,
    /// [-] entries of L over those of W above which a factor takes several times the memory of CG
    much_memory: f64,
    /// [-] factor by which Cholesky must then be cheaper
    clear_gain: f64,
}

/// The costs that choices are made by.
pub(super) const COSTS: CostModel = CostModel {
    factor_solve: 1.6 * 4.0,
    factor_operation: 0.25,
    factor_entry: 68.0,
    padding: 1.3,
    assembly: 50.0,
    cg_iteration: 7.5,
    cg_setup: 97.5,
    multigrid_setup: 150.0,
    newton: 250.0,
    newton_on_factor: 350.0,
    much_memory: 10.0,
    clear_gain: 1.1,
};

impl CostModel {
    /// [-] Cost of an assembly and a factorisation, in Newton iterations on an existing factor.
    pub(super) fn factor_cost(&self, stats: &LinearStats, unknowns: usize) -> f64 {
        let entries = stats.factor_nonzeros.unwrap_or(stats.matrix_nonzeros) as f64;
        let operations = stats.factor_operations.unwrap_or(0.0);
        // Small factors take the time of their operations; in large ones dense blocks make most of these cheap.
        let factoring = (2.0 * operations).min(self.factor_operation * operations + self.factor_entry * entries);
        let making = factoring + self.assembly * stats.matrix_nonzeros as f64;
        making / (self.factor_solve * entries + self.newton_on_factor * unknowns as f64)
    }

    fn cholesky(&self, pattern: &Pattern, e: &Elimination) -> Cost {
        let (n, entries) = (pattern.n() as f64, pattern.nonzeros() as f64);
        let stored = self.padding * e.nonzeros;
        let gain = if stored > self.much_memory * entries { self.clear_gain } else { 1.0 };
        let setup = self.factor_operation * e.operations + self.factor_entry * stored + self.assembly * entries;
        Cost { iteration: gain * (self.factor_solve * stored + self.newton * n), setup: gain * setup }
    }

    /// Of CG with this many iterations in an average solve, each counted as its cost over one without multigrid.
    /// Starting and finishing a solve cost one iteration more.
    fn cg(&self, pattern: &Pattern, iterations: f64, with_multigrid: bool) -> Cost {
        let (n, entries) = (pattern.n() as f64, pattern.nonzeros() as f64);
        let iteration = self.cg_iteration * entries * (iterations + 1.0) + self.newton * n;
        let setup = if with_multigrid { self.multigrid_setup } else { self.cg_setup };
        Cost { iteration, setup: (setup + self.assembly) * entries }
    }
}

/// Work of one way to solve, in counted units.
#[derive(Clone, Copy, Debug)]
struct Cost {
    /// of a Newton iteration: the solve and everything around it
    iteration: f64,
    /// of the assembly and what else a solve needs once
    setup: f64,
}

impl Cost {
    /// Work of a useful iteration, with its share of setup and of the extra iterations that an old matrix costs. A
    /// matrix is replaced once its age has cost as many extra iterations as a new one costs, c = setup/iteration
    /// (`quasi_newton`). The extra iterations grow with the square of age, so it serves for u = reuse sqrt(c) useful
    /// iterations, which cost u + 2 c iterations; s of them, where the run ends before, cost s + c + s^2/reuse^2.
    fn with_use(self, ExpectedUse { reuse, left, .. }: ExpectedUse) -> f64 {
        let serves = f64::min(reuse * (self.setup / self.iteration).sqrt(), left);
        self.iteration * (1.0 + serves / (reuse * reuse)) + self.setup / serves
    }

    /// The work of an iteration for which [`Cost::with_use`] is `total`.
    fn iteration_for(setup: f64, ExpectedUse { reuse, left, .. }: ExpectedUse, total: f64) -> f64 {
        let half = setup.sqrt() / reuse;
        let whole = ((half * half + total).sqrt() - half).powi(2);
        if reuse * (setup / whole).sqrt() <= left {
            return whole;
        }
        (total - setup / left) / (1.0 + left / (reuse * reuse))
    }
}

/// Predicted work of a useful iteration with each solver, including its share of setup and ageing.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Prediction {
    /// [-] by Cholesky; in these units an entry of L takes 6.4 in a solve
    pub cholesky_work: f64,
    /// [-] by CG; if the trial was stopped, with the iterations that made CG dearer
    pub cg_work: f64,
    /// CG iterations in an average solve: counted in earlier solves, or predicted by a trial
    pub cg_iterations: u32,
    /// whether CG is cheaper; otherwise a trial was stopped once Cholesky was
    pub cg_converged: bool,
    /// whether parts of W are far stiffer than others, so that CG was not tried
    pub far_apart: bool,
    /// entries of L
    pub factor_nonzeros: f64,
    /// multiplications and additions of a factorisation
    pub factor_operations: f64,
}

/// Cholesky and CG, each set up at its first use.
#[derive(Debug)]
pub struct AutoSolver {
    pattern: Arc<Pattern>,
    elimination: Option<Elimination>,
    direct: Option<Cholesky>,
    cg: ConjugateGradients,
    /// whether CG solves with the last matrix
    iterates: bool,
    /// whether Cholesky has factorised the last matrix
    factored: bool,
    /// whether CG has given up a solve with it
    given_up: bool,
    /// whether the last matrix is known to be definite, so that what looks otherwise in a solve is rounding
    definite: bool,
    /// the largest diagonal entry of every node, to find the median
    diagonal: Vec<f64>,
    prediction: Option<Prediction>,
    /// what solves may leave of their right-hand sides
    accuracy: Accuracy,
    /// the expected use of a matrix
    expected: ExpectedUse,
}

impl AutoSolver {
    /// Orders a symmetric pattern and counts the work of a factorisation.
    ///
    /// # Errors
    /// If the pattern is not symmetric or the analysis fails.
    pub fn new(pattern: Arc<Pattern>, workers: &Workers) -> Result<Self, LinearError> {
        let mut cg = ConjugateGradients::new(pattern.clone(), workers)?;
        let elimination = timed(Phase::Ordering, || fill_reducing(&pattern, workers));
        // Where a factor takes less than multigrid, it is never better.
        let dear = |e: &Elimination| COSTS.cholesky(&pattern, e).setup > COSTS.cg(&pattern, 0.0, true).setup;
        cg.allow_multigrid(elimination.as_ref().is_none_or(dear));
        Ok(AutoSolver {
            pattern,
            elimination,
            direct: None,
            cg,
            iterates: false,
            factored: false,
            given_up: false,
            definite: false,
            diagonal: Vec::new(),
            prediction: None,
            accuracy: Accuracy::of_reused(),
            expected: ExpectedUse::default(),
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

    /// [-] Work of a useful iteration by Cholesky, and the iterations of CG in an average solve that are as much work.
    fn allowed(&self, elimination: &Elimination, with_multigrid: bool, expected: ExpectedUse) -> [f64; 2] {
        let cholesky_work = COSTS.cholesky(&self.pattern, elimination).with_use(expected);
        let [none, one] = [0.0, 1.0].map(|iterations| COSTS.cg(&self.pattern, iterations, with_multigrid));
        let one = one.iteration - none.iteration;
        let allowed = Cost::iteration_for(none.setup, expected, cholesky_work) - none.iteration;
        [cholesky_work, allowed / one]
    }

    /// Of CG with this many iterations, with or without multigrid as for the last matrix.
    fn cg_cost_of(&self, iterations: f64) -> Cost {
        COSTS.cg(&self.pattern, iterations, self.cg.with_multigrid())
    }

    /// Iterations of CG that are as much work as to factorise W and to solve with the factor.
    fn worth_a_factor(&self, elimination: &Elimination) -> u32 {
        let Cost { iteration, setup } = COSTS.cholesky(&self.pattern, elimination);
        let [none, one] = [0.0, 1.0].map(|iterations| self.cg_cost_of(iterations).iteration);
        ((setup + iteration) / ((one - none) * self.cg.cg_cost())).clamp(1.0, f64::from(u32::MAX)) as u32
    }

    /// Whether some chain of nodes is far stiffer than the rest.
    fn stiffnesses_far_apart(&mut self, values: &[f64]) -> bool {
        let Pattern { col_ptr, node_start, .. } = &*self.pattern;
        // Of a column of the lower triangle the diagonal is the first entry.
        let largest = |unknowns: &[u32]| {
            let columns = unknowns[0] as usize..unknowns[1] as usize;
            col_ptr[columns].iter().map(|&first| values[first as usize]).fold(0.0, f64::max)
        };
        self.diagonal.clear();
        self.diagonal.extend(node_start.windows(2).map(largest).filter(|entry| *entry > 0.0));
        let middle = self.diagonal.len() / 2;
        if self.diagonal.len() <= 2 * CHAIN {
            return false;
        }
        let (_, &mut median, above) = self.diagonal.select_nth_unstable_by(middle, f64::total_cmp);
        above.iter().filter(|entry| **entry > FAR_STIFFER * median).count() >= CHAIN
    }

    /// Compares Cholesky with CG, which is set up unless it is known to be dearer: by the iterations of earlier solves
    /// or, without any, by a trial that runs as long as CG may be cheaper. Solves take `harder` [-] times as many
    /// iterations as with a reused matrix.
    ///
    /// # Errors
    /// An indefinite W, or as [`LinearSolver::factor`].
    fn compare(
        &mut self,
        values: &[f64],
        expected: ExpectedUse,
        harder: f64,
    ) -> Result<Option<Prediction>, LinearError> {
        let counted = |solver: &Self, with_multigrid| {
            solver.elimination.as_ref().map(|e| (solver.allowed(e, with_multigrid, expected), e.nonzeros, e.operations))
        };
        let found = counted(self, expected.multigrid);
        let seen = Some(harder * expected.cg_iterations).filter(|seen| *seen > 0.0);
        let far_apart = found.is_some() && self.stiffnesses_far_apart(values);
        let dearer = far_apart || seen.zip(found).is_some_and(|(seen, ([_, allowed], ..))| seen > allowed);
        if !dearer && self.cg.factor(values)? == Inertia::Indefinite {
            return Err(LinearError::Indefinite { iterations: 0 });
        }
        // Now it is known whether multigrid is needed.
        let with_multigrid = if dearer { expected.multigrid } else { self.cg.with_multigrid() };
        let counted = counted(self, with_multigrid);
        let Some(([cholesky_work, mut allowed], factor_nonzeros, factor_operations)) = counted else {
            return Ok(None);
        };
        let cost = ConjugateGradients::cost(with_multigrid);
        let (iterations, cg_converged) = match seen {
            Some(seen) => (seen, !dearer),
            None if far_apart => (allowed, false),
            None => {
                // A trial asks for half the digits.
                let of_solve = if with_multigrid { MULTIGRID_TRIAL * cost } else { 2.0 * EASIER };
                let each = harder * of_solve;
                let others_follow = expected.left > 1.0;
                allowed *= if !with_multigrid && others_follow { DOUBT } else { 1.0 };
                match self.cg.trial_solve((allowed / each).clamp(0.0, f64::from(u32::MAX)) as u32) {
                    Ok(iterations) => (each * f64::from(iterations), true),
                    Err(LinearError::Stalled { iterations, .. }) => (each * (f64::from(iterations) + 1.0), false),
                    Err(other) => {
                        self.cg.indefinite += u64::from(matches!(other, LinearError::Indefinite { .. }));
                        return Err(other);
                    }
                }
            }
        };
        let cg_work = COSTS.cg(&self.pattern, iterations, with_multigrid).with_use(expected);
        let shown = iterations.min(if cg_converged { f64::INFINITY } else { allowed.max(0.0) });
        let cg_iterations = (shown / cost).round() as u32;
        Ok(Some(Prediction {
            cholesky_work,
            cg_work,
            cg_iterations,
            cg_converged,
            far_apart,
            factor_nonzeros,
            factor_operations,
        }))
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

    fn factor_once(&mut self, values: &[f64], definite: bool, expected: ExpectedUse) -> Result<Inertia, LinearError> {
        // Small factors take little, and where rounding is all that is left, rounding also looks like an indefinite W.
        if !self.cg.multigrid_is_allowed() || self.accuracy.checked {
            return self.factor_definite(values);
        }
        (self.iterates, self.factored, self.given_up, self.definite) = (false, false, false, definite);
        self.cg.set_expected_use(expected);
        let once = ExpectedUse { reuse: f64::INFINITY, left: 1.0, ..expected };
        match self.compare(values, once, ONCE) {
            Err(LinearError::Indefinite { .. }) if !definite => return Ok(Inertia::Indefinite),
            Err(error @ LinearError::Interrupted(_)) => return Err(error),
            found => self.iterates = found.is_ok_and(|found| found.is_some_and(|p| p.cg_converged)),
        }
        if self.iterates { Ok(Inertia::Unknown) } else { self.factor_definite(values) }
    }

    fn choose(&mut self, values: &[f64]) -> Result<Inertia, LinearError> {
        let before = (self.iterates, self.prediction.is_some());
        (self.iterates, self.factored, self.given_up, self.definite) = (false, false, false, false);
        match self.compare(values, self.expected, 1.0) {
            Err(LinearError::Indefinite { .. }) => return Ok(Inertia::Indefinite),
            found => self.prediction = found?,
        }
        self.iterates = self.prediction.is_some_and(|p| p.cg_converged);
        if let Some(Prediction { cholesky_work, cg_work, .. }) = self.prediction {
            let level = if before == (self.iterates, true) { log::Level::Debug } else { log::Level::Info };
            let name = if self.iterates { "conjugate gradients" } else { "Cholesky" };
            log::log!(
                level,
                "linear solver {name}: counted work {cg_work:.2e} by gradients, {cholesky_work:.2e} by Cholesky"
            );
        }
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
            if !self.given_up {
                let most = self.elimination.as_ref().map_or(u32::MAX, |e| self.worth_a_factor(e));
                self.cg.set_accuracy(self.accuracy);
                match self.cg.solve_within(most, values, b) {
                    // This right-hand side is harder than that of the trial.
                    Err(LinearError::Stalled { .. } | LinearError::Singular { .. }) => self.given_up = true,
                    Err(LinearError::Indefinite { .. }) if self.definite => self.given_up = true,
                    solved => return solved,
                }
            }
            if !self.factored && self.direct()?.prepare(values)? == Inertia::Indefinite {
                return Err(LinearError::Indefinite { iterations: 0 });
            }
            self.factored = true;
        }
        let accuracy = self.accuracy;
        let direct = self.direct()?;
        direct.set_accuracy(accuracy);
        direct.solve(values, b)
    }

    fn set_accuracy(&mut self, accuracy: Accuracy) {
        self.accuracy = accuracy;
    }

    fn set_expected_use(&mut self, expected: ExpectedUse) {
        self.cg.set_expected_use(expected);
        self.expected = expected;
    }

    fn prefers_other_solver(&self, expected: ExpectedUse) -> bool {
        let seen = expected.cg_iterations;
        let (Some(e), true, true) = (&self.elimination, seen > 0.0, self.iterates) else { return false };
        COSTS.cholesky(&self.pattern, e).with_use(expected) < self.cg_cost_of(seen).with_use(expected)
    }

    fn with_multigrid(&self) -> bool {
        self.iterates && self.cg.with_multigrid()
    }

    fn cg_cost(&self) -> f64 {
        self.cg.cg_cost() * if self.given_up { GIVEN_UP } else { 1.0 }
    }

    fn work(&self) -> SolverWork {
        let factorizations = self.direct.as_ref().map_or(0, |direct| direct.work().factorizations);
        SolverWork { factorizations, ..self.cg.work() }
    }

    fn stats(&self) -> LinearStats {
        let prediction = self.prediction;
        match (&self.direct, self.iterates) {
            (_, true) => LinearStats { prediction, ..self.cg.stats() },
            (Some(direct), false) => LinearStats { prediction, ..direct.stats() },
            (None, false) => LinearStats {
                name: "cholesky",
                factor_nonzeros: self.elimination.as_ref().map(|e| (COSTS.padding * e.nonzeros) as usize),
                factor_operations: self.elimination.as_ref().map(|e| e.operations),
                prediction,
                ..self.cg.stats()
            },
        }
    }
}
