//! The cost of one force pass and one tangent of a scene, measured on this machine.

use std::hint::black_box;

use super::work::Work;
use crate::assembly::Assembler;
use crate::costs;
use crate::integrate::implicit::{Factor, SolverSpec, cached_factor};
use crate::model::system::Weights;
use crate::process::Stopwatch;
use crate::scene::Scene;
use crate::solve::{Accuracy, LinearSolver, LinearStats, Prediction, solver_for};

/// [s] Time limit for measuring one cost, unless a single repetition takes longer.
const BUDGET: f64 = 0.01;
/// [s] Shortest sample, far above the resolution of the clock; the work is repeated to reach it.
const SAMPLE: f64 = 20e-6;
/// Samples of which the median is taken.
const SAMPLES: usize = 7;
/// [s] A factorisation is not tried if it is expected to take longer.
const DEAR: f64 = 1.0;

/// One kind of force in a scene.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct TermCost {
    /// e.g. `springs`
    pub name: &'static str,
    /// springs, triangles or nodes it goes over; null for a system without elements
    pub elements: Option<usize>,
    /// [s] a force pass with it alone, which forces share much of, so that together they take less; null where it
    /// cannot be told apart
    pub seconds: Option<f64>,
}

/// What contact costs, measured at the start.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct ContactCost {
    /// [s] its part of a force pass
    pub seconds: f64,
    /// [-] that over the pass without it
    pub share: f64,
    /// [s] a search for pairs that are near, once parts have come nearer to each other by the skin
    pub search_seconds: f64,
    /// pairs that are near
    pub near: usize,
}

/// One force pass.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct ForceCost {
    /// [s] all of it
    pub pass_seconds: f64,
    /// the part of contact; null where nothing may touch
    pub contact: Option<ContactCost>,
    /// its terms, like ones together
    pub terms: Vec<TermCost>,
}

/// The tangent W of an implicit step.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct TangentCost {
    /// whether W is symmetric
    pub symmetric: bool,
    /// rows of W
    pub unknowns: usize,
    /// entries stored of W
    pub matrix_nonzeros: usize,
    /// entries stored of its factor; null where the library does not say
    pub factor_nonzeros: Option<usize>,
    /// `cholesky`, `lu` or `cg`
    pub linear_solver: &'static str,
    /// whether implicit steps keep it, or its symmetric part, over many of them
    pub kept: bool,
    /// [s] ordering and analysis, once a run
    pub analysis_seconds: f64,
    /// [s] one assembly
    pub assembly_seconds: f64,
    /// [s] one factorisation
    pub factorization_seconds: f64,
    /// [s] one solve
    pub solve_seconds: f64,
    /// whether factorisation and solve were measured; else they are estimated from counts
    pub measured: bool,
    /// element blocks that an assembly adds up
    pub blocks: usize,
    /// [flop] of a factorisation; null where the library does not say
    pub factor_operations: Option<f64>,
    /// iterations of the measured solve, of conjugate gradients; 0 of a direct solver
    pub cg_iterations: u64,
    /// what the solver was chosen from; null where there was nothing to choose
    pub prediction: Option<Prediction>,
}

impl TangentCost {
    /// [s] What each kind of work costs nominally; see [`nominal`].
    pub fn nominal(&self) -> Work {
        let &TangentCost { unknowns, matrix_nonzeros, factor_nonzeros, factor_operations, .. } = self;
        let name = if self.cg_iterations > 0 { "cg" } else { "" };
        let (indefinite, prediction) = (0, None);
        let stats = LinearStats { name, matrix_nonzeros, factor_nonzeros, factor_operations, indefinite, prediction };
        nominal(&stats, unknowns)
    }

    /// [s] One Newton iteration without its force pass.
    pub fn iteration_seconds(&self) -> f64 {
        self.assembly_seconds + self.factorization_seconds + self.solve_seconds
    }
}

/// [s] What an assembly, a factorisation, a solve and in it an iteration of conjugate gradients cost nominally, by
/// counts alone.
pub fn nominal(of: &LinearStats, unknowns: usize) -> Work {
    let (n, entries) = (unknowns as f64, of.factor_nonzeros.unwrap_or(0) as f64);
    let assembly = costs::ASSEMBLY * of.matrix_nonzeros as f64;
    if of.name == "cg" {
        // Nothing is factorised; beginning and ending a solve takes as long as an iteration.
        let iteration = costs::CG_ITERATION * of.matrix_nonzeros as f64;
        return Work {
            tangent_assemblies: assembly + costs::CG_READY * of.matrix_nonzeros as f64,
            linear_solves: iteration,
            cg_iterations: iteration,
            ..Work::default()
        };
    }
    let [factorizations, linear_solves] = match of.factor_operations {
        Some(operations) => [operations / costs::OPERATIONS + costs::FACTOR * entries, costs::SOLVE * entries],
        None => [costs::LU * n.powf(1.5), costs::LU * n],
    };
    Work { tangent_assemblies: assembly, factorizations, linear_solves, ..Work::default() }
}
/// Measures a force pass, and one with each term alone, at the start of a scene.
pub fn force_cost(scene: &dyn Scene) -> ForceCost {
    let (state, mut forces) = (scene.initial_state(), scene.new_forces());
    let pass_seconds = median_seconds(BUDGET, || scene.evaluate(state.as_ref(), black_box(&mut forces)));
    let mut terms: Vec<TermCost> = Vec::new();
    for (index, info) in scene.terms().iter().enumerate() {
        let f = &mut forces.total;
        let elements = scene.term_alone(index, state.as_ref(), f);
        let seconds = elements.map(|_| {
            median_seconds(BUDGET, || {
                black_box(scene.term_alone(index, state.as_ref(), black_box(&mut *f)));
            })
        });
        match terms.iter_mut().find(|term| term.name == info.name) {
            Some(term) => {
                term.elements = term.elements.zip(elements).map(|(a, b)| a + b);
                term.seconds = term.seconds.zip(seconds).map(|(a, b)| a + b);
            }
            None => terms.push(TermCost { name: info.name, elements, seconds }),
        }
    }
    ForceCost { pass_seconds, contact: contact_cost(scene, pass_seconds), terms }
}

/// What contact takes of a pass of so many seconds, and a search for pairs.
fn contact_cost(scene: &dyn Scene, pass_seconds: f64) -> Option<ContactCost> {
    let (touches, state) = (scene.touches()?, scene.initial_state());
    let mut near = 0;
    let search_seconds = median_seconds(BUDGET, || {
        near = black_box(touches.survey(state.as_ref())).iter().map(|contact| contact.near).sum();
    });
    let mut f = vec![0.0; scene.n_dof()];
    let seconds = median_seconds(BUDGET, || touches.press(state.as_ref(), black_box(&mut f)));
    // Both are measured, and the part may come out as the larger one on a scene of a few nodes.
    let share = seconds / f64::max(pass_seconds - seconds, 1e-3 * seconds);
    Some(ContactCost { seconds, share, search_seconds, near })
}

/// Measures one tangent, its factorisation and a solve at the start of a scene; `weight` [1/s^2] is that of the mass,
/// 4/h^2 for Newmark.
///
/// # Errors
/// What an implicit method would be refused with.
pub fn tangent_cost(scene: &dyn Scene, spec: SolverSpec, weight: f64) -> Result<TangentCost, String> {
    let clock = Stopwatch::default();
    let before = clock.seconds();
    let (mut assembler, mut solver, kept) =
        match cached_factor(scene, spec.newton.strategy, spec.linear).map_err(|e| e.to_string())? {
            Some(Factor { assembler, linear }) => (assembler, linear, true),
            None => {
                let assembler = scene.assembler().map_err(|e| e.to_string())?;
                let solver =
                    solver_for(assembler.pattern.clone(), spec.linear, scene.workers()).map_err(|e| e.to_string())?;
                (assembler, solver, false)
            }
        };
    let analysis_seconds = clock.seconds() - before;
    let state = scene.initial_state();
    let weights = Weights { m: weight, c: 2.0 * weight.sqrt(), k: 1.0 };
    let assembly_seconds = median_seconds(BUDGET, || match kept {
        true => scene.assemble_symmetric(state.as_ref(), weights, false, black_box(&mut assembler)),
        false => scene.assemble(state.as_ref(), weights, black_box(&mut assembler)),
    });
    // The solver for a kept matrix is chosen once its values are known.
    let before = clock.seconds();
    if kept {
        solver.choose(assembler.values()).map_err(|e| e.to_string())?;
    }
    let choice_seconds = clock.seconds() - before;
    let stats = solver.stats();
    let unknowns = assembler.pattern.n();
    let expected = expected(&stats, unknowns);
    let measured = expected <= DEAR;
    let ([factorization_seconds, solve_seconds], cg_iterations) = match measured {
        // Conjugate gradients are ready once they are chosen.
        true if kept && stats.name == "cg" => {
            let (solve_seconds, iterations) = solve(&mut *solver, &assembler);
            ([choice_seconds, solve_seconds], iterations)
        }
        true => {
            let factorization_seconds = factorization(&mut *solver, &assembler, kept);
            let (solve_seconds, iterations) = solve(&mut *solver, &assembler);
            ([factorization_seconds, solve_seconds], iterations)
        }
        false => ([expected, expected / (unknowns as f64).sqrt()], 0),
    };
    Ok(TangentCost {
        symmetric: scene.symmetric(),
        unknowns,
        matrix_nonzeros: stats.matrix_nonzeros,
        factor_nonzeros: stats.factor_nonzeros,
        linear_solver: stats.name,
        kept,
        analysis_seconds,
        assembly_seconds,
        factorization_seconds,
        solve_seconds,
        measured,
        blocks: assembler.blocks(),
        factor_operations: stats.factor_operations,
        cg_iterations,
        prediction: stats.prediction,
    })
}

/// [s] A factorisation by counts; nothing where there is none.
fn expected(stats: &LinearStats, unknowns: usize) -> f64 {
    match (stats.name, stats.factor_operations) {
        ("cg", _) => 0.0,
        (_, Some(operations)) => operations / costs::OPERATIONS,
        (_, None) => costs::LU * (unknowns as f64).powf(1.5),
    }
}

/// [s] Cost of a factorisation. A W that is singular at the start is no failure of the run; the time spent counts.
fn factorization(solver: &mut dyn LinearSolver, assembler: &Assembler, kept: bool) -> f64 {
    let values = assembler.values();
    median_seconds(BUDGET, || {
        black_box(if kept { solver.prepare(values).is_ok() } else { solver.factor(values).is_ok() });
    })
}

/// [s] A solve, and its iterations of conjugate gradients.
fn solve(solver: &mut dyn LinearSolver, assembler: &Assembler) -> (f64, u64) {
    let mut b = vec![1.0; assembler.pattern.n()];
    solver.set_accuracy(Accuracy::of_reused());
    let (mut solves, before) = (0, solver.work().iterations);
    let seconds = median_seconds(BUDGET, || {
        b.fill(1.0);
        solves += 1;
        black_box(solver.solve(assembler.values(), &mut b).is_ok());
    });
    (seconds, (solver.work().iterations - before).div_ceil(solves.max(1)))
}

/// [s] Cost of a piece of work after a first repetition: the median of a few samples. If the first repetition takes
/// `budget` [s] or more, its cost is returned.
pub fn median_seconds(budget: f64, mut work: impl FnMut()) -> f64 {
    let clock = Stopwatch::default();
    let mut sample = |repeats: u32| {
        let before = clock.seconds();
        (0..repeats).for_each(|_| work());
        (clock.seconds() - before) / f64::from(repeats)
    };
    let first = sample(1);
    if first >= budget {
        return first;
    }
    let warm = sample(1).max(1e-9);
    let repeats = (SAMPLE / warm).ceil().clamp(1.0, 1e6);
    let affordable = (budget / (repeats * warm)) as usize;
    let mut samples: Vec<f64> = (0..affordable.clamp(1, SAMPLES)).map(|_| sample(repeats as u32)).collect();
    samples.sort_by(f64::total_cmp);
    samples[samples.len() / 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Work is done a bounded number of times, and dear work once.
    #[test]
    fn dear_work_is_done_once() {
        let mut count = 0u64;
        assert!(median_seconds(0.0, || count += 1) >= 0.0);
        assert_eq!(count, 1);
        let mut count = 0u64;
        median_seconds(1e-3, || count = std::hint::black_box(count + 1));
        assert!((2..100_000_000).contains(&count), "{count}");
    }
}
