//! Newton's iteration with the tensions of springs as unknowns beside the positions: for stiff springs, slack ones, and
//! states far from the solution.
//!
//! A trial step that moves a node across a spring by d makes it longer by d^2/(2 l). Newton's iteration on positions
//! takes this for a tension k d^2/(2 l), and its next tangent is far too stiff across the spring. The mixed iteration
//! keeps the tension t that its last linear step expects, and eliminates it again spring by spring, so matrix, pattern
//! and solution stay (mixed integration points: Magisano, Leonetti & Garcea 2017). With the taut tension T and its
//! slope k at x, and y = T above its least value:
//!
//! ```text
//! both ways    (W + sum k n n^T + t/l (I - n n^T)) dx = -r(x),                        t <- T + k n . dx
//! one-sided    t >= 0, s >= 0, t s = 0, s = (t - y)/k:   primal-dual interior point with t s = mu -> 0
//!              k' = k t/(t + k s),   dt = k' (n . dx + (y - t)/k + mu/t),   ds = (mu - t s - s dt)/t
//! ```
//! A spring that acts both ways has its own t in the matrix if that is positive definite, and else max(t, 0). The
//! product mu falls by the predictor and corrector of Mehrotra (1992), two solves a factor. A step is cut only where
//! it would make none of these smaller: the forces out of balance (with the tensions t), the errors of the tensions,
//! and the products. First tensions are those at the start of the step. Stresses of membranes are unknowns in the same
//! way as tensions of springs that act both ways.

mod stresses;
mod tensions;

use super::forcing::Forcing;
use super::newton::{Convergence, ConvergenceCriteria, HIDING, Newton, NewtonReport};
use super::problem::NonlinearProblem;
use super::{Accuracy, LinearError};
use tensions::Shares;
pub(super) use tensions::Tensions;

/// How one-sided springs are solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sides {
    /// taut or slack as they are at an iterate, with the tangents of their laws
    AsTheyAre,
    /// by interior points
    Interior,
    /// the same with all springs one-sided, from tensions of the size of the loads: for an equilibrium that may be far.
    /// Springs that act both ways do so once it is found.
    Loaded,
}

/// Iterations after which it gives up if it need not be the last try: with one-sided springs as they are.
const FEW: u32 = 10;
/// The same for an equilibrium: a net that folds, without bending stiffness, has many that are almost one.
const MANY: u32 = 400;
/// [-] Errors of lengths over the lengths, and products t s over loads and lengths, with which springs may act both
/// ways.
const LOADED: f64 = 1e-9;
/// Halvings of a step.
const HALVINGS: u32 = 4;

/// Sizes of what is left.
#[derive(Clone, Copy)]
struct Left {
    /// [N] forces with the tensions t
    forces: f64,
    /// [m] errors of the tensions over stiffnesses
    lengths: f64,
    /// [N m] mean product t s
    product: f64,
}

impl Left {
    fn is_worse_than(self, other: Left) -> bool {
        !(self.forces < other.forces || self.lengths < other.lengths || self.product < other.product)
    }
}

/// Iterates from `z` `[n]`, whose residual is in `newton.r`. Returns `None` if it does not converge, or if the problem
/// has no springs; `z` is then undefined.
///
/// # Errors
/// A linear system that cannot be solved.
pub(super) fn solve(
    newton: &mut Newton,
    problem: &mut dyn NonlinearProblem,
    z: &mut [f64],
    (criteria, sides): (ConvergenceCriteria, Sides),
) -> Result<Option<NewtonReport>, LinearError> {
    let mut tensions = std::mem::take(&mut newton.tensions);
    let found = Iteration { newton, problem, tensions: &mut tensions, criteria }.run(z, sides);
    newton.tensions = tensions;
    found
}

struct Iteration<'a> {
    newton: &'a mut Newton,
    problem: &'a mut dyn NonlinearProblem,
    tensions: &'a mut Tensions,
    criteria: ConvergenceCriteria,
}

impl Iteration<'_> {
    fn run(&mut self, z: &mut [f64], sides: Sides) -> Result<Option<NewtonReport>, LinearError> {
        let root = (z.len() as f64).sqrt();
        let size = self.criteria.scales.residual * if sides == Sides::Loaded { root } else { 1.0 / root };
        let Some(springs) = self.problem.mixed() else { return Ok(None) };
        self.tensions.begin(springs, size, sides);
        let (mut forcing, spent) = (Forcing::default(), self.newton.spent);
        self.newton.workers.copy(&mut self.newton.r_trial, &self.newton.r);
        let mut left = self.left();
        let most = match sides {
            // Nothing would be another with interior points.
            Sides::Interior if !self.tensions.has_one_sided() => return Ok(None),
            Sides::AsTheyAre if self.tensions.has_one_sided() => FEW,
            Sides::Loaded => MANY,
            _ => u32::MAX,
        };
        let most = most.min(self.newton.most_iterations());
        // In a motion, more than that would be lost of the forces that the next step takes over.
        let hidden = if sides == Sides::Loaded { f64::INFINITY } else { HIDING * self.criteria.scales.residual };
        for made in 1..=most {
            self.newton.spent = spent + made;
            let before = self.newton.workers.norm(&self.newton.r);
            self.problem.set_accuracy(Accuracy::to(forcing.next(before, self.criteria.tolerance)));
            let Some(shares) = self.linear_step()? else { return Ok(None) };
            self.newton.keep_apart(self.problem, z);
            left = match self.step(z, shares, left) {
                Some(left) => left,
                None => return Ok(None),
            };
            let residual = self.newton.workers.norm(&self.newton.r);
            log::debug!(
                "mixed iteration {made}: {:.2e} N left with the tensions, {residual:.2e} N without, product {:.2e} N m",
                left.forces,
                left.product
            );
            if self.tensions.pushes_later() && self.is_loaded(left) {
                self.tensions.let_push();
                left = self.left();
                continue;
            }
            let ended = match self.newton.convergence(z, self.criteria, shares.x * residual / before) {
                Convergence::Converged => true,
                // The tensions tell what lengths cannot.
                Convergence::Rounding => left.forces <= self.criteria.tolerance && residual <= hidden,
                Convergence::NotConverged => false,
            };
            if ended {
                let report =
                    NewtonReport { iterations: self.newton.spent, residual: self.criteria.over_scale(residual) };
                return Ok(Some(report));
            }
        }
        Ok(None)
    }

    /// Whether tensions balance the loads, and all springs that they leave slack are.
    fn is_loaded(&self, left: Left) -> bool {
        let (length, mean) = self.tensions.lengths();
        let root = (self.newton.r.len() as f64).sqrt();
        left.forces <= self.criteria.tolerance
            && left.lengths <= LOADED * length
            && left.product <= LOADED * self.criteria.scales.residual * root * mean
    }

    /// The direction with as much of the tensions below 0 in the matrix as keeps it positive definite; `None` if it
    /// never is.
    fn linear_step(&mut self) -> Result<Option<Shares>, LinearError> {
        self.tensions.begin_iteration();
        loop {
            let linearised = self.problem.mixed().map(|springs| self.tensions.linearise(springs)).transpose()?;
            if linearised != Some(true) {
                return Ok(None);
            }
            match self.direction() {
                // Without a factorisation only the solve shows it.
                Err(LinearError::Indefinite { .. }) => {}
                found => return found.map(Some),
            }
        }
    }

    /// The changes of all unknowns; of positions in `newton.dz`.
    fn direction(&mut self) -> Result<Shares, LinearError> {
        self.tensions.predict();
        let shares = self.solve()?;
        let Some(now) = self.tensions.mean_product() else { return Ok(shares) };
        self.tensions.correct(now, shares);
        self.solve()
    }

    /// One solve for the present products.
    fn solve(&mut self) -> Result<Shares, LinearError> {
        self.tensions.set_pull();
        let Newton { r, dz, workers, .. } = &mut *self.newton;
        workers.copy(dz, r);
        if let Some(springs) = self.problem.mixed() {
            self.tensions.add_pull(springs, dz, false);
        }
        self.problem.solve(dz)?;
        workers.negate(dz);
        let springs = self.problem.mixed();
        Ok(springs.map_or(Shares { x: 1.0, t: 1.0 }, |springs| self.tensions.follow(springs, dz)))
    }

    /// Takes the step, or a shorter one. Returns what is left; `None` if no step is finite.
    fn step(&mut self, z: &mut [f64], shares: Shares, before: Left) -> Option<Left> {
        self.tensions.remember();
        let mut cut = 1.0;
        for halving in 0..=HALVINGS {
            let taken = Shares { x: cut * shares.x, t: cut * shares.t };
            self.newton.evaluate_at(self.problem, z, taken.x, 0.0);
            self.tensions.take(taken);
            let left = self.left();
            let finite = left.forces.is_finite() && left.lengths.is_finite();
            if finite && (halving == HALVINGS || !left.is_worse_than(before)) {
                self.newton.accept_trial(z);
                return Some(left);
            }
            cut *= 0.5;
        }
        None
    }

    /// Measures the springs at the last evaluated residual, and what is left there. Forces are those of the trial.
    fn left(&mut self) -> Left {
        let Some(springs) = self.problem.mixed() else { return Left { forces: 0.0, lengths: 0.0, product: 0.0 } };
        self.tensions.measure(springs);
        let Newton { correction: forces, r_trial, workers, .. } = &mut *self.newton;
        workers.copy(forces, r_trial);
        self.tensions.add_pull(springs, forces, true);
        let product = self.tensions.mean_product().unwrap_or(0.0);
        Left { forces: workers.norm(forces), lengths: self.tensions.errors(), product }
    }
}
