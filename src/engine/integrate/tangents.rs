//! The factorised tangents of an implicit scheme: the exact one of an iterate, and a symmetric one that is reused over
//! many steps. Each is analysed at its first use. If W is symmetric they share their memory, and one overwrites the
//! other.

use std::sync::Arc;

use super::factor_cache::FactorRequest;
use super::{Counters, StepError};
use crate::assembly::{Assembler, MixedForm, MixedSystem, PatternError, TangentSystem};
use crate::interrupt;
use crate::model::state::StateRef;
use crate::model::system::Weights;
use crate::model::workers::Workers;
use crate::solve::newton::{Curvature, Strategy};
use crate::solve::{
    Accuracy, ExpectedUse, Inertia, LinearChoice, LinearError, LinearSolver, LinearStats, SolverWork,
    reusing_solver_for, solver_for,
};

/// A matrix with its solver.
pub struct Factor {
    /// W
    pub assembler: Assembler,
    /// its solver
    pub linear: Box<dyn LinearSolver>,
}

impl Factor {
    fn new(assembler: Assembler, choice: LinearChoice, workers: &Workers) -> Result<Self, LinearError> {
        interrupt::check()?;
        let linear = solver_for(assembler.pattern.clone(), choice, workers)?;
        interrupt::check()?;
        Ok(Factor { assembler, linear })
    }

    fn for_reuse(assembler: Assembler, choice: LinearChoice, workers: &Workers) -> Result<Self, LinearError> {
        interrupt::check()?;
        let linear = reusing_solver_for(assembler.pattern.clone(), choice, workers)?;
        interrupt::check()?;
        Ok(Factor { assembler, linear })
    }

    /// Factorises the assembled matrix; an indefinite one only if it need not be `symmetric` and definite. With an
    /// expected use it may be left to conjugate gradients ([`LinearSolver::factor_once`]).
    fn factorise(
        &mut self,
        symmetric: bool,
        (definite, expected): (bool, Option<ExpectedUse>),
        counters: &mut Counters,
    ) -> Result<Inertia, LinearError> {
        interrupt::check()?;
        let (values, before) = (self.assembler.values(), self.linear.work());
        let made = match expected {
            _ if !symmetric => self.linear.factor(values),
            Some(expected) => self.linear.factor_once(values, definite, expected),
            None => self.linear.factor_definite(values),
        };
        counters.tangent_assemblies += 1;
        count(counters, before, self.linear.work());
        made
    }

    /// Replaces b `[n]` by that of the factorised matrix's inverse.
    fn solve(&mut self, b: &mut [f64], counters: &mut Counters) -> Result<(), LinearError> {
        counters.linear_solves += 1;
        let before = self.linear.work();
        let solved = self.linear.solve(self.assembler.values(), b);
        count(counters, before, self.linear.work());
        solved
    }

    /// [-] Cost of assembly and factorisation in iterations on an existing factor.
    fn cost(&self) -> f64 {
        self.linear.stats().factor_cost(self.assembler.pattern.n())
    }
}

/// The symmetric tangent and its solver if this strategy reuses its factor, else `None`.
///
/// # Errors
/// When the pattern cannot be found or analysed.
pub fn cached_factor(
    system: &dyn TangentSystem,
    strategy: Strategy,
    choice: LinearChoice,
) -> Result<Option<Factor>, StepError> {
    // An explicit choice of LU disables reuse.
    if strategy == Strategy::Full || choice == LinearChoice::Lu {
        return Ok(None);
    }
    let Some(assembler) = system.symmetric_assembler()? else { return Ok(None) };
    let factor = Factor::for_reuse(assembler, choice, system.workers())?;
    // Conjugate gradients are cheap to set up and cheaper to reuse. Cholesky serves the symmetric part of a tangent.
    let by_choice = choice == LinearChoice::Cg || choice == LinearChoice::Cholesky && !system.symmetric();
    let keeps = by_choice || strategy.reuses_factors(factor.cost(), factor.assembler.pattern.n());
    Ok(keeps.then_some(factor))
}

/// Why a choice of solver does not fit a scene, if it does not.
pub fn refusal(symmetric: bool, strategy: Strategy, choice: LinearChoice) -> Option<LinearError> {
    match choice {
        LinearChoice::Cholesky if !symmetric && strategy == Strategy::Full => Some(LinearError::NotSymmetric),
        LinearChoice::Cg if !symmetric && strategy == Strategy::Full => Some(LinearError::FullNotSymmetric),
        LinearChoice::Lu if matches!(strategy, Strategy::Modified | Strategy::Quasi) => Some(LinearError::NotKept),
        _ => None,
    }
}

fn count(counters: &mut Counters, before: SolverWork, after: SolverWork) {
    counters.factorizations += after.factorizations - before.factorizations;
    counters.lu_factorizations += after.lu_factorizations - before.lu_factorizations;
    counters.cg_iterations += after.iterations - before.iterations;
}

/// Which tangent solves use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TangentKind {
    Exact,
    Frozen,
    /// that of the mixed iteration where W is not symmetric: in the memory of the reused one
    Mixed,
}

/// The rank-one parts of an exact tangent, one after the other (Sherman & Morrison 1950):
/// (W + u g^T)^-1 b = y - z (g . y)/(1 + g . z) with y = W^-1 b and z = W^-1 u, where W has the parts before.
#[derive(Default)]
struct RankOnes {
    parts: Vec<RankOnePart>,
    /// how many of them are not 0
    used: usize,
    /// u and g by degree of freedom
    dofs: [Vec<f64>; 2],
    workers: Workers,
}

/// One of them.
#[derive(Clone, Default)]
struct RankOnePart {
    z: Vec<f64>,
    g: Vec<f64>,
    /// 1 + g . z
    divisor: f64,
}

impl RankOnePart {
    fn correct(&self, workers: &Workers, y: &mut [f64]) {
        let share = workers.dot(&self.g, y) / self.divisor;
        workers.add(y, -share, &self.z);
    }
}

impl RankOnes {
    /// Finds those of a tangent whose other parts have just been factorised.
    fn find(
        &mut self,
        (system, count): (&dyn TangentSystem, usize),
        (at, w): (StateRef<'_>, Weights),
        dof: &[u32],
        factor: &mut Factor,
        counters: &mut Counters,
    ) -> Result<(), LinearError> {
        self.parts.resize(count, RankOnePart::default());
        self.used = 0;
        self.workers = system.workers().clone();
        for which in 0..count {
            let [u, g] = &mut self.dofs;
            u.resize(system.n_dof(), 0.0);
            g.resize(system.n_dof(), 0.0);
            system.rank_one(which, at, w, u, g);
            let (before, [part, ..]) = self.parts.split_at_mut(self.used) else { return Ok(()) };
            let picked = |from: &[f64], to: &mut Vec<f64>| {
                to.clear();
                to.extend(dof.iter().map(|&dof| from[dof as usize]));
            };
            picked(g, &mut part.g);
            if part.g.iter().all(|g| *g == 0.0) {
                continue;
            }
            picked(u, &mut part.z);
            factor.solve(&mut part.z, counters)?;
            before.iter().for_each(|earlier| earlier.correct(&self.workers, &mut part.z));
            part.divisor = 1.0 + self.workers.dot(&part.g, &part.z);
            if part.divisor == 0.0 || !part.divisor.is_finite() {
                return Err(LinearError::Singular { unknown: None });
            }
            self.used += 1;
        }
        Ok(())
    }

    fn correct(&self, y: &mut [f64]) {
        self.parts.iter().take(self.used).for_each(|part| part.correct(&self.workers, y));
    }
}

/// The exact and the reused tangent.
pub(crate) struct Tangents {
    /// of the exact one, and of the reused one
    rank_ones: RankOnes,
    kept_parts: RankOnes,
    /// [-] solves that every reused matrix serves for kept parts beside those of the mass
    coupled: f64,
    symmetric: bool,
    choice: LinearChoice,
    /// the same for the reused tangent
    reused_choice: LinearChoice,
    exact: Option<Factor>,
    frozen: Option<Factor>,
    /// the factor that solves use
    current: TangentKind,
    /// iterations of reused matrices, if those that are solved with once may be left to conjugate gradients
    expected: Option<ExpectedUse>,
    /// accuracy of solves
    accuracy: Accuracy,
    /// degree of freedom of every unknown
    pub dof: Arc<[u32]>,
}

impl Tangents {
    /// # Errors
    /// When patterns cannot be found or analysed, or the choice of solver does not fit.
    pub(crate) fn new(system: &dyn TangentSystem, strategy: Strategy, choice: LinearChoice) -> Result<Self, StepError> {
        refusal(system.symmetric(), strategy, choice).map_or(Ok(()), Err)?;
        let frozen = cached_factor(system, strategy, choice)?;
        let exact = match &frozen {
            Some(_) => None,
            None => {
                let assembler = system.assembler()?;
                let by_nodes = matches!(choice, LinearChoice::Cholesky | LinearChoice::Cg);
                if by_nodes && system.symmetric() && !assembler.pattern.symmetric {
                    return Err(LinearError::NotByNodes.into());
                }
                Some(Factor::new(assembler, choice, system.workers())?)
            }
        };
        // A pendulum's pattern is not marked symmetric.
        let symmetric = system.symmetric() && exact.as_ref().is_none_or(|f| f.assembler.pattern.symmetric);
        let dof = frozen.iter().chain(&exact).map(|f| Arc::from(&*f.assembler.pattern.dof)).next().unwrap_or_default();
        // If the symmetric part does not converge, only LU is left.
        let reused_choice = choice;
        let symmetric_only = matches!(choice, LinearChoice::Cg | LinearChoice::Cholesky);
        let choice = if symmetric_only && !symmetric { LinearChoice::Auto } else { choice };
        Ok(Tangents {
            rank_ones: RankOnes::default(),
            kept_parts: RankOnes::default(),
            coupled: (system.kept_parts() - system.mass_parts()) as f64,
            symmetric,
            choice,
            reused_choice,
            exact,
            frozen,
            current: TangentKind::Exact,
            expected: None,
            accuracy: Accuracy::of_reused(),
            dof,
        })
    }

    /// Whether parts of the scene have come near each other that have no place in the pattern.
    pub(super) fn outgrown(&self, system: &dyn TangentSystem) -> bool {
        self.frozen.iter().chain(&self.exact).any(|factor| system.outgrown(&factor.assembler))
    }

    /// Gives the matrices a pattern with a place for all pairs that are near at the last evaluated state.
    fn fit(&mut self, system: &dyn TangentSystem) -> Result<(), LinearError> {
        if !self.outgrown(system) {
            return Ok(());
        }
        let unknowns = self.dof.len();
        let failed = |e: PatternError| LinearError::Analysis { unknowns, reason: e.to_string() };
        if let Some(frozen) = &mut self.frozen
            && let Some(assembler) = system.symmetric_assembler().map_err(failed)?
        {
            *frozen = Factor::for_reuse(assembler, self.reused_choice, system.workers())?;
        }
        if let Some(exact) = &mut self.exact {
            *exact = Factor::new(system.assembler().map_err(failed)?, self.choice, system.workers())?;
        }
        self.set_accuracy(self.accuracy);
        Ok(())
    }

    /// [-] Cost of a factorisation in iterations without one.
    pub(crate) fn factor_cost(&self) -> f64 {
        self.frozen.as_ref().map_or(0.0, Factor::cost)
    }

    /// Whether a matrix is reused over many solves.
    pub(crate) fn reuses_factors(&self) -> bool {
        self.frozen.is_some()
    }

    /// Whether W is symmetric.
    pub(crate) fn symmetric(&self) -> bool {
        self.symmetric
    }

    /// See [`crate::solve::newton::NonlinearProblem::leave_to_gradients`].
    pub(super) fn leave_to_gradients(&mut self, expected: Option<ExpectedUse>) {
        self.expected = expected;
    }

    /// After a matrix or a solve: if it was factorised (there were `before` factorisations), so are further matrices of
    /// this iteration. Otherwise, if it needed multigrid, these are not tried without.
    fn learn(&mut self, before: u64, counters: &Counters) {
        let multigrid = self.in_use().is_some_and(|factor| factor.linear.with_multigrid());
        self.expected = self.expected.filter(|_| counters.factorizations == before);
        self.expected.iter_mut().for_each(|expected| expected.multigrid |= multigrid);
    }

    /// Makes further solves use this tangent.
    pub(super) fn take(&mut self, which: TangentKind) {
        self.current = which;
    }

    /// Factorises the exact tangent, or its convex part.
    ///
    /// # Errors
    /// A tangent that is not finite or singular, or that cannot be analysed.
    pub(crate) fn factor(
        &mut self,
        system: &dyn TangentSystem,
        at: StateRef<'_>,
        w: Weights,
        curvature: Curvature,
        counters: &mut Counters,
    ) -> Result<Inertia, LinearError> {
        self.fit(system)?;
        self.current = TangentKind::Exact;
        let symmetric = self.symmetric;
        let slot = if symmetric && self.frozen.is_some() { &mut self.frozen } else { &mut self.exact };
        let factor = match slot {
            Some(factor) => factor,
            None => {
                let failed =
                    |e: PatternError| LinearError::Analysis { unknowns: self.dof.len(), reason: e.to_string() };
                slot.insert(Factor::new(system.assembler().map_err(failed)?, self.choice, system.workers())?)
            }
        };
        match curvature {
            Curvature::Exact => system.assemble(at, w, &mut factor.assembler),
            Curvature::Convex => system.assemble_convex(at, w, &mut factor.assembler),
        }
        // Its rank-one parts need exact solves.
        let expected = self.expected.filter(|_| system.rank_ones() == 0);
        let before = counters.factorizations;
        let inertia = factor.factorise(symmetric, (curvature == Curvature::Convex, expected), counters)?;
        self.rank_ones.find((system, system.rank_ones()), (at, w), &self.dof, factor, counters)?;
        self.learn(before, counters);
        Ok(inertia)
    }

    /// Factorises the matrix of the mixed iteration: symmetric where the scene reuses a factor, else exact.
    ///
    /// # Errors
    /// A tangent that is not finite or singular, or that cannot be analysed.
    pub(crate) fn factor_mixed(
        &mut self,
        (system, mixed): (&dyn TangentSystem, &dyn MixedSystem),
        (at, w): (StateRef<'_>, Weights),
        form: MixedForm<'_>,
        counters: &mut Counters,
    ) -> Result<Inertia, LinearError> {
        self.fit(system)?;
        let reused = self.frozen.is_some() && !self.symmetric;
        self.current = if reused { TangentKind::Mixed } else { TangentKind::Exact };
        let slot = if self.frozen.is_some() { &mut self.frozen } else { &mut self.exact };
        let Some(factor) = slot else { return Err(LinearError::Singular { unknown: None }) };
        mixed.assemble_mixed(at, w, MixedForm { symmetric: reused, ..form }, &mut factor.assembler);
        let (parts, number) = match reused {
            true => (&mut self.kept_parts, system.kept_parts()),
            false => (&mut self.rank_ones, system.rank_ones()),
        };
        let expected = self.expected.filter(|_| number == 0);
        let before = counters.factorizations;
        let inertia = factor.factorise(reused || self.symmetric, (form.definite, expected), counters)?;
        parts.find((system, number), (at, w), &self.dof, factor, counters)?;
        self.learn(before, counters);
        Ok(inertia)
    }

    /// Whether another solver would have been chosen for the reused tangent with this expected use.
    pub(crate) fn prefers_other_solver(&self, expected: ExpectedUse) -> bool {
        let expected = self.with_parts(expected);
        self.frozen.as_ref().is_some_and(|factor| factor.linear.prefers_other_solver(expected))
    }

    /// The use of a matrix that also solves for the kept parts.
    fn with_parts(&self, expected: ExpectedUse) -> ExpectedUse {
        ExpectedUse { reuse: expected.reuse + self.coupled, ..expected }
    }

    /// [-] Cost of an iteration of conjugate gradients with the reused tangent over one without multigrid.
    pub(crate) fn cg_cost(&self) -> f64 {
        self.frozen.as_ref().map_or(1.0, |factor| factor.linear.cg_cost())
    }

    /// Whether the reused tangent is solved with multigrid.
    pub(crate) fn with_multigrid(&self) -> bool {
        self.frozen.as_ref().is_some_and(|factor| factor.linear.with_multigrid())
    }

    /// Factorises the symmetric tangent, or its convex part on request; `None` if the scene reuses none.
    ///
    /// # Errors
    /// A tangent that is not finite.
    pub(super) fn freeze(
        &mut self,
        system: &dyn TangentSystem,
        at: StateRef<'_>,
        w: Weights,
        FactorRequest { convex, expected }: FactorRequest,
        counters: &mut Counters,
    ) -> Result<Option<Inertia>, LinearError> {
        self.fit(system)?;
        let expected = self.with_parts(expected);
        let Some(factor) = &mut self.frozen else { return Ok(None) };
        self.current = TangentKind::Frozen;
        system.assemble_symmetric(at, w, convex, &mut factor.assembler);
        let before = factor.linear.work();
        factor.linear.set_expected_use(expected);
        interrupt::check()?;
        let made = factor.linear.prepare(factor.assembler.values())?;
        counters.tangent_assemblies += 1;
        count(counters, before, factor.linear.work());
        if made == Inertia::Indefinite {
            return Ok(Some(made));
        }
        // The same in a run that goes on from a checkpoint.
        factor.linear.set_accuracy(Accuracy::of_reused());
        self.kept_parts.find((system, system.kept_parts()), (at, w), &self.dof, factor, counters)?;
        Ok(Some(made))
    }

    /// Replaces b `[n]` by W^-1 b.
    ///
    /// # Errors
    /// A solution that is not finite, or no factor.
    pub(crate) fn solve(&mut self, b: &mut [f64], counters: &mut Counters) -> Result<(), LinearError> {
        let Some(factor) = self.in_use() else { return Err(LinearError::Singular { unknown: None }) };
        interrupt::check()?;
        let before = counters.factorizations;
        let solved = factor.solve(b, counters);
        self.learn(before, counters);
        let parts = if self.current == TangentKind::Exact { &self.rank_ones } else { &self.kept_parts };
        parts.correct(b);
        solved
    }

    /// The factor that solves use.
    fn in_use(&mut self) -> Option<&mut Factor> {
        let shared = self.symmetric && self.frozen.is_some();
        if shared || self.current != TangentKind::Exact { self.frozen.as_mut() } else { self.exact.as_mut() }
    }

    /// Whether solves use this tangent.
    pub(super) fn solves_with(&self, which: TangentKind) -> bool {
        self.current == which
    }

    /// Sets the accuracy of further solves.
    pub(crate) fn set_accuracy(&mut self, accuracy: Accuracy) {
        self.accuracy = accuracy;
        for factor in self.frozen.iter_mut().chain(&mut self.exact) {
            factor.linear.set_accuracy(accuracy);
        }
    }

    /// Name and sizes of the solver that works most.
    pub(crate) fn stats(&self) -> Option<LinearStats> {
        self.frozen.as_ref().or(self.exact.as_ref()).map(|f| f.linear.stats())
    }
}
