//! The loop of pseudo-transient continuation: solve with the weight mu, then lower it where that was easy and raise it
//! where it was not.

use super::failure::StaticFailure;
use super::proximal::{Proximal, cautious_weight};
use super::unknowns::Dofs;
use super::{Equilibrium, Residual, SearchProgress, StaticSpec, Watcher, diagnosis};
use crate::integrate::Counters;
use crate::integrate::tangents::Tangents;
use crate::model::point::Point;
use crate::model::spring_state::SpringState;
use crate::model::stop::Stop;
use crate::scene::Scene;
use crate::solve::newton::{Newton, NewtonFailure, NewtonReport, NewtonSpec, NonlinearProblem, Scales, Strategy};
use crate::solve::quasi_newton::FactorHistory;

/// [-] A solve leaves this share of the residual that it began with: the next one continues anyway.
const INNER: f64 = 0.1;
/// Iterations of a solve; one that needs more is made with a larger weight.
const INNER_ITERATIONS: u32 = 12;
/// Iterations of a solve up to which the weight is lowered.
const EASY: u32 = 4;
/// The same up to which it is lowered a little, by this factor [-].
const FAIR: u32 = 9;
const LOWER_A_LITTLE: f64 = 0.3;
/// [-] Factors of the weight after an easy solve, at most, and after one that failed.
const LOWER: f64 = 0.1;
const RAISE: f64 = 10.0;
/// [-] Share of the scene's size that the first solve may move a node.
const FIRST_MOVE: f64 = 0.25;
/// [-] Share of the scene's size that a last move may have.
const SETTLED: f64 = 1e-8;
/// Solves with a small residual after which a part that still creeps is taken as it is.
const CREEPS: u32 = 20;
/// [-] Weights above this multiple of the first are of no use.
const HEAVIEST: f64 = 1e12;
/// [-] Weight over the first with which a state is looked for from tensions of the size of the loads.
const LIGHTEST: f64 = 1e-8;
/// [-] Cosine of the largest angle by which a spring may turn there.
const TURNED: f64 = -0.5;
/// [-] A node that is farther from its start than this many sizes of the scene has left it.
const LEFT: f64 = 1e3;

/// What a search works with, and where it begins.
pub(super) struct SearchStart<'a> {
    pub stop: Stop<'a>,
    pub watcher: Watcher<'a>,
    pub tangents: Tangents,
    pub at: Point,
    pub counters: Counters,
}

/// A search in progress.
pub(super) struct Continuation<'a> {
    pub scene: &'a dyn Scene,
    pub spec: StaticSpec,
    pub stop: Stop<'a>,
    watcher: Watcher<'a>,
    pub dofs: Dofs,
    /// the best state so far
    pub at: Point,
    /// where the search began
    pub start: Point,
    tangents: Tangents,
    trial: Point,
    newton: Newton,
    z: Vec<f64>,
    all: Vec<f64>,
    counters: Counters,
    pseudo_steps: u32,
    dropped: u32,
    pub load_steps: u32,
    /// [-] share of the loads that is applied
    pub level: f64,
}

impl<'a> Continuation<'a> {
    pub(super) fn new(scene: &'a dyn Scene, spec: StaticSpec, start: SearchStart<'a>) -> Self {
        let SearchStart { stop, watcher, tangents, at, counters } = start;
        let unknowns = tangents.dof.len();
        let newton = NewtonSpec { relative: INNER, max_iterations: INNER_ITERATIONS, strategy: Strategy::Full };
        Continuation {
            scene,
            spec,
            stop,
            watcher,
            dofs: Dofs::of(scene),
            start: at.clone(),
            trial: at.clone(),
            tangents,
            newton: Newton::new(newton, unknowns, scene.workers()),
            z: vec![0.0; unknowns],
            all: vec![0.0; at.state.x.len()],
            at,
            counters,
            pseudo_steps: 0,
            dropped: 0,
            load_steps: 0,
            level: 1.0,
        }
    }

    /// Goes back to the start.
    pub(super) fn restart(&mut self) {
        self.at.copy_from(&self.start);
    }

    /// Evaluates the forces again, after loads have changed.
    pub(super) fn refresh(&mut self) {
        self.counters.evaluate(self.scene, self.at.state.as_ref(), &mut self.at.forces);
    }

    /// Newton iterations made.
    pub(super) fn iterations(&self) -> u64 {
        self.counters.newton_iterations
    }

    pub(super) fn residual(&self) -> Residual {
        self.dofs.residual(self.scene, &self.at)
    }

    /// Solves for the present loads, up to `relative` of the forces.
    pub(super) fn settle(&mut self, relative: f64) -> Result<(), StaticFailure> {
        let mut now = self.residual();
        if !now.force.is_finite() {
            return Err(self.not_finite(now));
        }
        if now.force == 0.0 {
            return Ok(());
        }
        let cautious = cautious_weight(self.scene, &self.at, FIRST_MOVE * self.dofs.size);
        let heaviest = HEAVIEST * cautious;
        let mut mu = cautious;
        if self.load(LIGHTEST * cautious, relative) {
            return Ok(());
        }
        // The lightest weight that rounding leaves visible.
        let (mut lightest, mut creeps, mut raised) = (0.0, 0, false);
        loop {
            if self.stop.asked() {
                return Err(StaticFailure::Interrupted);
            }
            if self.counters.newton_iterations >= u64::from(self.spec.max_iterations) {
                return Err(self.not_converged(now));
            }
            let before = now;
            let solved = self.solve(mu, now, relative);
            // A solve that was not finished has gone downhill, or nearer to its solution, so its progress is kept.
            let unfinished = match &solved {
                Err(NewtonFailure::MaxIterations { residual, .. }) => {
                    self.tangents.symmetric() || *residual <= now.force
                }
                _ => false,
            };
            log::debug!(
                "mu = {mu:.2e} 1/s^2: {:.3e} N left of {:.3e} N, solved: {}",
                now.force,
                now.scale,
                solved.is_ok()
            );
            if solved.is_err() && !unfinished {
                self.dropped += 1;
                if matches!(solved, Err(NewtonFailure::Linear { .. })) {
                    lightest = mu * RAISE;
                }
                raised = true;
                mu *= RAISE;
                if mu > heaviest {
                    return Err(self.not_converged(now));
                }
                continue;
            }
            self.pseudo_steps += 1;
            let moved = self.z.iter().fold(0.0, |most: f64, z| most.max(z.abs()));
            self.at.copy_from(&self.trial);
            now = self.residual();
            (self.watcher.0)(SearchProgress {
                iterations: self.iterations(),
                residual: now.force,
                scale: now.scale,
                level: self.level,
            });
            if !self.is_near() {
                return Err(self.left());
            }
            let iterations = solved.map_or(u32::MAX, |report| report.iterations);
            if now.is_small(relative) {
                creeps += 1;
                if moved <= SETTLED * self.dofs.size || creeps > CREEPS || now.force == 0.0 {
                    return Ok(());
                }
            }
            // A weight that was just raised is kept for one solve.
            if !std::mem::take(&mut raised) {
                if iterations <= EASY {
                    mu *= (now.force / before.force).min(LOWER);
                } else if iterations <= FAIR {
                    mu *= LOWER_A_LITTLE;
                }
            }
            mu = mu.max(lightest);
        }
    }

    /// One solve from tensions of the size of the loads, with a weight that holds only what no spring does, if the
    /// equilibrium is far: one linear step would leave the scene. Returns whether it has found it.
    fn load(&mut self, mu: f64, relative: f64) -> bool {
        // Not the scale of all forces: springs that push at the start may be far larger than the loads.
        self.scene.load(self.at.state.as_ref(), &mut self.all);
        let free = self.all.iter().zip(&self.dofs.mass).filter(|(_, mass)| **mass > 0.0);
        let loads = free.map(|(f, _)| f * f).sum::<f64>().sqrt();
        if loads == 0.0 {
            return false;
        }
        let made = self.iterations();
        let (tolerance, scales, far) = (0.5 * relative * loads, self.scales(loads), self.dofs.size);
        if self.scene.mixed().is_none_or(|mixed| mixed.springs() == 0) {
            return false;
        }
        let most = self.spec.max_iterations.saturating_sub(u32::try_from(made).unwrap_or(u32::MAX));
        let Some(loaded) = self.with_problem((mu, true), |newton, problem, z| {
            newton.leaps(problem, z, far).then(|| newton.load(problem, z, (tolerance, scales), most))
        }) else {
            return false;
        };
        self.counters.newton_iterations += u64::from(self.newton.iterations());
        let found = matches!(loaded, Ok(Some(_)))
            && self.dofs.residual(self.scene, &self.trial).is_small(relative)
            && !self.is_turned_over();
        if found {
            self.pseudo_steps += 1;
            self.at.copy_from(&self.trial);
        }
        found
    }

    /// Whether a spring of the trial has turned by more than 120 degrees: a bar that stood hangs.
    fn is_turned_over(&self) -> bool {
        let Some(mixed) = self.scene.mixed() else { return false };
        let [from, to] = [&self.at, &self.trial].map(|point| {
            let mut springs = vec![SpringState::idle([0; 2]); mixed.springs()];
            mixed.measure(point.state.as_ref(), 0.0, &mut springs);
            springs
        });
        from.iter().zip(&to).any(|(from, to)| from.n.dot(&to.n) < TURNED)
    }

    fn scales(&self, residual: f64) -> Scales {
        Scales {
            residual,
            increment: self.dofs.size * (self.z.len().max(1) as f64).sqrt(),
            increment_floor: 4.0 * f64::EPSILON * self.scene.workers().norm(&self.at.state.x),
        }
    }

    /// One solve into `trial` and `z`.
    fn solve(&mut self, mu: f64, now: Residual, relative: f64) -> Result<NewtonReport, NewtonFailure> {
        let wanted = (0.5 * relative * now.scale).max(f64::MIN_POSITIVE);
        let scales = self.scales(now.force.max(wanted / INNER));
        // Loads that turn with a surface may have balances that no motion comes to.
        let solved = self.with_problem((mu, false), |newton, problem, z| {
            let solved = newton.solve(problem, z, scales, &mut FactorHistory::default());
            if matches!(solved, Err(NewtonFailure::MaxIterations { .. })) {
                // The last trial need not be the last state that was accepted.
                let (mut r, mut floor) = (vec![0.0; z.len()], vec![0.0; z.len()]);
                problem.residual(z, &mut r, &mut floor);
            }
            solved
        });
        let made = solved.as_ref().map_or_else(NewtonFailure::iterations, |report| report.iterations);
        // At least one, so that the loop around is bounded.
        self.counters.newton_iterations += u64::from(made.max(1));
        solved
    }

    /// Solves the equations with the weight mu [1/s^2] from z = 0, with the tensions of springs as unknowns if `mixed`.
    fn with_problem<T>(
        &mut self,
        (mu, mixed): (f64, bool),
        solve: impl FnOnce(&mut Newton, &mut Proximal<'_>, &mut [f64]) -> T,
    ) -> T {
        self.z.fill(0.0);
        let mut problem = Proximal {
            scene: self.scene,
            dofs: &self.dofs,
            tangents: &mut self.tangents,
            counters: &mut self.counters,
            from: &self.at,
            to: &mut self.trial,
            mu,
            all: &mut self.all,
            stop: self.stop,
            mixed,
        };
        solve(&mut self.newton, &mut problem, &mut self.z)
    }

    /// Whether all nodes are where a scene of this size could be.
    fn is_near(&self) -> bool {
        let moved = self.at.state.x.iter().zip(&self.start.state.x).map(|(x, start)| (x - start).abs());
        moved.fold(0.0, f64::max) <= LEFT * self.dofs.size
    }

    /// The result, judged.
    pub(super) fn finish(self, failure: Option<StaticFailure>) -> Equilibrium {
        let residual = self.residual();
        let judged = match failure {
            None => diagnosis::judge(self.scene, &self.dofs, &self.at, self.stop),
            Some(_) => diagnosis::Judged::default(),
        };
        Equilibrium {
            residual,
            pseudo_steps: self.pseudo_steps,
            dropped: self.dropped,
            load_steps: self.load_steps,
            counters: self.counters,
            linear: self.tangents.stats(),
            stability: judged.stability,
            findings: judged.findings,
            failure,
            point: self.at,
        }
    }
}
