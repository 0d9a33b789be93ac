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
//! and the products. First tensions are those at the start of the step.

use super::forcing::Forcing;
use super::newton::{Convergence, ConvergenceCriteria, HIDING, Newton, NewtonReport};
use super::norms::{dot, norm};
use super::problem::{MixedSprings, NonlinearProblem};
use super::{Accuracy, Inertia, LinearError};
use crate::model::spring_state::{SpringState, SpringTangent};

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

/// Iterations after which it gives up.
const MOST: u32 = 80;
/// The same if it need not be the last try: with one-sided springs as they are.
const FEW: u32 = 10;
/// The same for an equilibrium: a net that folds, without bending stiffness, has many that are almost one.
const MANY: u32 = 400;
/// [-] Share of the way to t = 0 or s = 0 that a step goes.
const TO_BOUNDARY: f64 = 0.995;
/// [-] Product t s of a slack or taut spring at the start, over the size of a nodal force times that of a spring.
const FIRST_PRODUCT: f64 = 1e-4;
/// [-] The least share of the mean product that an iteration aims at.
const LEAST_CENTRE: f64 = 1e-3;
/// [-] The least share of tensions below 0 that the next iteration tries.
const LEAST_SHARE: f64 = 1.0 / 1024.0;
/// [-] Errors of lengths over the lengths, and products t s over loads and lengths, with which springs may act both
/// ways.
const LOADED: f64 = 1e-9;
/// Halvings of a step.
const HALVINGS: u32 = 4;

/// The tensions, with their buffers; all `[n_springs]`.
#[derive(Clone, Debug, Default)]
pub(super) struct Tensions {
    /// how one-sided springs are solved now
    sides: Option<Sides>,
    /// whether there are one-sided springs
    any_one_sided: bool,
    /// [-] share of tensions below 0 that the matrix has, where that is positive definite
    share: f64,
    /// which springs act both ways although they are taken as one-sided
    both_ways: Vec<bool>,
    at: Vec<SpringState>,
    /// [N] unknown tensions; above the least ones for one-sided springs
    t: Vec<f64>,
    /// [m] slack of one-sided springs
    s: Vec<f64>,
    tangents: Vec<SpringTangent>,
    /// [m] n . dx
    dl: Vec<f64>,
    /// [N]
    dt: Vec<f64>,
    /// [m]
    ds: Vec<f64>,
    /// [N m] products t s that a direction aims at
    product: Vec<f64>,
    /// [N] what the right-hand side has in place of the tensions
    pull: Vec<f64>,
    /// tensions and slacks before a step
    before: [Vec<f64>; 2],
    /// forces or displacements of all degrees of freedom `[n_dof]`
    dofs: Vec<f64>,
}

/// [-] Shares of a direction: of positions and slacks, and of one-sided tensions.
#[derive(Clone, Copy)]
struct Shares {
    x: f64,
    t: f64,
}

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

impl Tensions {
    /// Makes the springs at the start of the step the first tensions. `size` [N] is that of a nodal force.
    fn begin(&mut self, springs: &mut dyn MixedSprings, size: f64, sides: Sides) {
        self.sides = Some(sides);
        self.any_one_sided = false;
        self.share = 1.0;
        let n = springs.count();
        let idle = SpringState::idle([0; 2]);
        self.at.resize(n, idle);
        for numbers in [&mut self.t, &mut self.s, &mut self.dl, &mut self.dt, &mut self.ds, &mut self.product] {
            numbers.resize(n, 0.0);
        }
        self.pull.resize(n, 0.0);
        self.tangents.resize(n, SpringTangent::default());
        springs.measure_start(&mut self.at);
        self.decide();
        self.start(size);
    }

    /// Makes the measured springs the first tensions. `size` [N] is that of a nodal force, or of the loads.
    fn start(&mut self, size: f64) {
        let length = self.at.iter().map(|spring| spring.length).sum::<f64>() / self.at.len() as f64;
        let mu = FIRST_PRODUCT * size * length;
        for (spring, (t, s)) in self.at.iter().zip(self.t.iter_mut().zip(&mut self.s)) {
            (*t, *s) = match self.sides {
                _ if !spring.is_one_sided() => (spring.tension, 0.0),
                Some(Sides::Loaded) => (size, length),
                _ => central(spring, mu),
            };
        }
    }

    /// Takes one-sided springs as taut or slack as they are, unless they are solved by interior points.
    fn decide(&mut self) {
        let any = self.one_sided().next().is_some();
        self.any_one_sided |= any;
        match self.sides {
            Some(Sides::Interior) => return,
            Some(Sides::Loaded) => {
                self.both_ways.clear();
                for spring in &mut self.at {
                    self.both_ways.push(spring.least == f64::NEG_INFINITY);
                    if spring.least == f64::NEG_INFINITY {
                        spring.least = 0.0;
                    }
                }
                return;
            }
            _ => {}
        }
        for (spring, t) in self.at.iter_mut().zip(&mut self.t).filter(|(spring, _)| spring.is_one_sided()) {
            *t = t.max(spring.least);
            if spring.taut < spring.least {
                spring.stiffness = 0.0;
            }
            (spring.taut, spring.least) = (spring.tension, f64::NEG_INFINITY);
        }
    }

    fn one_sided(&self) -> impl Iterator<Item = usize> {
        (0..self.at.len()).filter(|&i| self.at[i].is_one_sided())
    }

    /// Mean of a number of one-sided springs; `None` without any.
    fn mean(&self, of: impl Fn(usize) -> f64) -> Option<f64> {
        let (sum, count) = self.one_sided().fold((0.0, 0), |(sum, n), i| (sum + of(i), n + 1));
        (count > 0).then(|| sum / f64::from(count))
    }

    /// [N m] Mean product t s; `None` without one-sided springs.
    fn mean_product(&self) -> Option<f64> {
        self.mean(|i| self.t[i] * self.s[i])
    }

    /// [N] Tension of spring i, with the least one of a one-sided spring.
    fn tension(&self, i: usize) -> f64 {
        let spring = &self.at[i];
        self.t[i] + if spring.is_one_sided() { spring.least } else { 0.0 }
    }

    /// [m] Error of spring i: (t - y)/k - s.
    fn error(&self, i: usize) -> f64 {
        let spring = &self.at[i];
        if spring.is_one_sided() {
            (self.t[i] - (spring.taut - spring.least)) / spring.stiffness - self.s[i]
        } else if spring.stiffness > 0.0 {
            (self.t[i] - spring.taut) / spring.stiffness
        } else {
            0.0
        }
    }

    /// What the matrix has of the springs, with this share [-] of tensions below 0.
    fn set_tangents(&mut self, share: f64) {
        for (i, tangent) in self.tangents.iter_mut().enumerate() {
            let (spring, t) = (&self.at[i], self.t[i]);
            let (tension, stiffness) = if spring.is_one_sided() {
                (t + spring.least, spring.stiffness * t / (t + spring.stiffness * self.s[i]))
            } else {
                (t, spring.stiffness.max(0.0))
            };
            *tangent = SpringTangent { tension: if tension < 0.0 { share * tension } else { tension }, stiffness };
        }
    }

    /// [N] Change of the tension of spring i without the part of dx.
    fn own_change(&self, i: usize) -> f64 {
        let (spring, t) = (&self.at[i], self.t[i]);
        if spring.is_one_sided() {
            let free = (spring.taut - spring.least - t) / spring.stiffness + self.product[i] / t;
            self.tangents[i].stiffness * free
        } else {
            spring.taut - t
        }
    }

    /// What a direction with these products puts in the place of the tensions: `pull` [N] is the difference.
    fn set_pull(&mut self) {
        // For springs both ways `tension` may be below the least one: it is what the residual has.
        for i in 0..self.at.len() {
            self.pull[i] = self.at[i].tension - (self.tension(i) + self.own_change(i));
        }
    }

    /// Finds the changes of tensions and slacks from `dl`, and the shares that keep both positive.
    fn follow(&mut self) -> Shares {
        let mut shares = Shares { x: 1.0, t: 1.0 };
        for i in 0..self.at.len() {
            self.dt[i] = self.own_change(i) + self.tangents[i].stiffness * self.dl[i];
            if self.at[i].is_one_sided() {
                let (t, s) = (self.t[i], self.s[i]);
                self.ds[i] = (self.product[i] - t * s - s * self.dt[i]) / t;
                let room = |value: f64, change: f64| if change < 0.0 { -TO_BOUNDARY * value / change } else { 1.0 };
                shares = Shares { x: shares.x.min(room(s, self.ds[i])), t: shares.t.min(room(t, self.dt[i])) };
            }
        }
        shares
    }

    /// Aims at the corrector's products, after a predictor with these shares.
    fn correct(&mut self, now: f64, shares: Shares) {
        let after = self.mean(|i| (self.t[i] + shares.t * self.dt[i]) * (self.s[i] + shares.x * self.ds[i]));
        let after = after.unwrap_or(0.0);
        let centre = (after / now).powi(3).clamp(LEAST_CENTRE, 1.0);
        let both = shares.x.min(shares.t);
        for i in 0..self.at.len() {
            self.product[i] = centre * now - both * self.dt[i] * self.ds[i];
        }
    }

    /// Takes shares of the changes, from the values before.
    fn take(&mut self, shares: Shares) {
        let [t, s] = &self.before;
        for i in 0..self.at.len() {
            let share = if self.at[i].is_one_sided() { shares.t } else { shares.x };
            self.t[i] = t[i] + share * self.dt[i];
            self.s[i] = s[i] + shares.x * self.ds[i];
        }
    }

    /// Whether displacements from the start `[n]` push a spring by more than its length.
    pub(super) fn is_pushed_over(&mut self, springs: &mut dyn MixedSprings, dz: &[f64]) -> bool {
        self.begin(springs, 0.0, Sides::Loaded);
        self.stretch(springs, dz);
        self.at.iter().zip(&self.dl).any(|(spring, dl)| -dl > spring.length)
    }

    /// Whether springs that act both ways are taken as one-sided.
    fn pushes_later(&self) -> bool {
        self.sides == Some(Sides::Loaded) && self.both_ways.contains(&true)
    }

    /// Lets the springs that act both ways push again, with the same tensions.
    fn let_push(&mut self) {
        self.sides = Some(Sides::Interior);
        let both_ways = self.both_ways.iter().zip(&mut self.s);
        both_ways.filter(|(both_ways, _)| **both_ways).for_each(|(_, s)| *s = 0.0);
    }

    /// Adds the forces of the tensions `pull` to a residual [N] `[n]`.
    fn add_pull(&mut self, springs: &dyn MixedSprings, r: &mut [f64]) {
        let ((dofs, n_dof), weight) = (springs.dofs(), springs.weight());
        self.dofs.clear();
        self.dofs.resize(n_dof, 0.0);
        for (spring, pull) in self.at.iter().zip(&self.pull) {
            let [a, b] = spring.nodes.map(|node| 3 * node as usize);
            for (axis, n) in spring.n.iter().enumerate() {
                self.dofs[a + axis] += weight * pull * n;
                self.dofs[b + axis] -= weight * pull * n;
            }
        }
        r.iter_mut().zip(dofs).for_each(|(r, &dof)| *r += self.dofs[dof as usize]);
    }

    /// Finds n . dx of every spring.
    fn stretch(&mut self, springs: &dyn MixedSprings, dz: &[f64]) {
        let (dofs, n_dof) = springs.dofs();
        self.dofs.clear();
        self.dofs.resize(n_dof, 0.0);
        dofs.iter().zip(dz).for_each(|(&dof, dz)| self.dofs[dof as usize] = *dz);
        for (spring, dl) in self.at.iter().zip(&mut self.dl) {
            let [a, b] = spring.nodes.map(|node| 3 * node as usize);
            *dl = spring.n.iter().enumerate().map(|(axis, n)| n * (self.dofs[b + axis] - self.dofs[a + axis])).sum();
        }
    }

    fn remember(&mut self) {
        let [t, s] = &mut self.before;
        t.clone_from(&self.t);
        s.clone_from(&self.s);
    }
}

/// Tension above the least one and slack of a one-sided spring, on t s = mu [N m] and (t - y)/k = s.
fn central(spring: &SpringState, mu: f64) -> (f64, f64) {
    let (y, k) = (spring.taut - spring.least, spring.stiffness);
    let root = (y * y + 4.0 * k * mu).sqrt();
    // Of the two forms the one without cancellation.
    let t = if y > 0.0 { 0.5 * (y + root) } else { 2.0 * k * mu / (root - y) };
    (t, mu / t)
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
        self.newton.r_trial.copy_from_slice(&self.newton.r);
        let mut left = self.left();
        let most = match sides {
            // Nothing would be another with interior points.
            Sides::Interior if !self.tensions.any_one_sided => return Ok(None),
            Sides::AsTheyAre if self.tensions.any_one_sided => FEW.min(self.newton.most_iterations()),
            Sides::Loaded => MANY.min(self.newton.most_iterations()),
            _ => MOST.min(self.newton.most_iterations()),
        };
        // In a motion, more than that would be lost of the forces that the next step takes over.
        let hidden = if sides == Sides::Loaded { f64::INFINITY } else { HIDING * self.criteria.scales.residual };
        for made in 1..=most {
            self.newton.spent = spent + made;
            let before = norm(&self.newton.r);
            self.problem.set_accuracy(Accuracy::to(forcing.next(before, self.criteria.tolerance)));
            if !self.linearise()? {
                return Ok(None);
            }
            let shares = self.direction()?;
            left = match self.step(z, shares, left) {
                Some(left) => left,
                None => return Ok(None),
            };
            let residual = norm(&self.newton.r);
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
        let Tensions { at, .. } = &*self.tensions;
        let length: f64 = at.iter().map(|spring| spring.length).sum();
        let root = (self.newton.r.len() as f64).sqrt();
        left.forces <= self.criteria.tolerance
            && left.lengths <= LOADED * length
            && left.product <= LOADED * self.criteria.scales.residual * root * length / at.len() as f64
    }

    /// Factorises the matrix at the last evaluated residual; `false` if it is not positive definite.
    fn linearise(&mut self) -> Result<bool, LinearError> {
        let most = self.tensions.share;
        for share in [most, 0.5 * most, 0.0] {
            self.tensions.set_tangents(share);
            let Some(springs) = self.problem.mixed() else { return Ok(false) };
            match springs.linearise(&self.tensions.tangents, share < 1.0) {
                Ok(Inertia::Indefinite) | Err(LinearError::Indefinite { .. }) => {}
                made => {
                    self.tensions.share = if share < most { share.max(LEAST_SHARE) } else { 0.5 * (1.0 + share) };
                    return made.map(|_| true);
                }
            }
        }
        Ok(false)
    }

    /// The changes of all unknowns; of positions in `newton.dz`.
    fn direction(&mut self) -> Result<Shares, LinearError> {
        self.tensions.product.fill(0.0);
        let shares = self.solve()?;
        let Some(now) = self.tensions.mean_product() else { return Ok(shares) };
        self.tensions.correct(now, shares);
        self.solve()
    }

    /// One solve for the present products.
    fn solve(&mut self) -> Result<Shares, LinearError> {
        self.tensions.set_pull();
        let Newton { r, dz, .. } = &mut *self.newton;
        dz.copy_from_slice(r);
        if let Some(springs) = self.problem.mixed() {
            self.tensions.add_pull(springs, dz);
        }
        self.problem.solve(dz)?;
        dz.iter_mut().for_each(|dz| *dz = -*dz);
        if let Some(springs) = self.problem.mixed() {
            self.tensions.stretch(springs, dz);
        }
        Ok(self.tensions.follow())
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
        springs.measure(&mut self.tensions.at);
        self.tensions.decide();
        for i in 0..self.tensions.at.len() {
            self.tensions.pull[i] = self.tensions.at[i].tension - self.tensions.tension(i);
        }
        let correction = &mut self.newton.correction;
        correction.copy_from_slice(&self.newton.r_trial);
        self.tensions.add_pull(springs, correction);
        let errors = (0..self.tensions.at.len()).map(|i| self.tensions.error(i).powi(2)).sum::<f64>();
        let product = self.tensions.mean_product().unwrap_or(0.0);
        Left { forces: dot(correction, correction).sqrt(), lengths: errors.sqrt(), product }
    }
}
