//! The tensions of the mixed iteration: their start, their part of the linear step, the way of one-sided springs to
//! t s = 0, and the steps that keep both positive.

use super::Sides;
use super::stresses::Stresses;
use crate::assembly::MixedForm;
use crate::model::spring_state::{SpringState, SpringTangent};
use crate::solve::problem::MixedSprings;
use crate::solve::{Inertia, LinearError};

/// [-] Share of the way to t = 0 or s = 0 that a step goes.
const TO_BOUNDARY: f64 = 0.995;
/// [-] Product t s of a slack or taut spring at the start, over the size of a nodal force times that of a spring.
const FIRST_PRODUCT: f64 = 1e-4;
/// [-] The least share of the mean product that an iteration aims at.
const LEAST_CENTRE: f64 = 1e-3;
/// [-] The least share of tensions below 0 that the next iteration tries.
const LEAST_SHARE: f64 = 1.0 / 1024.0;

/// The tensions, with their buffers; all `[n_springs]`.
#[derive(Clone, Debug, Default)]
pub(in crate::solve) struct Tensions {
    /// how one-sided springs are solved now
    sides: Option<Sides>,
    /// whether there are one-sided springs
    any_one_sided: bool,
    /// [-] share of tensions below 0 that the matrix of the next iteration has, where that is positive definite
    share: f64,
    /// [-] the largest that this iteration tries
    most: f64,
    /// how many of them it has tried
    tried: usize,
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
    /// of membranes
    sheets: Stresses,
    /// forces or displacements of all degrees of freedom `[n_dof]`
    dofs: Vec<f64>,
}

/// [-] Shares of a direction: of positions and slacks, and of one-sided tensions.
#[derive(Clone, Copy)]
pub(super) struct Shares {
    pub x: f64,
    pub t: f64,
}

impl Tensions {
    /// Makes the springs at the start of the step the first tensions. `size` [N] is that of a nodal force.
    pub(super) fn begin(&mut self, springs: &mut dyn MixedSprings, size: f64, sides: Sides) {
        self.sides = Some(sides);
        self.any_one_sided = false;
        self.share = 1.0;
        let [n, triangles] = springs.counts();
        let idle = SpringState::idle([0; 2]);
        self.at.resize(n, idle);
        for numbers in [&mut self.t, &mut self.s, &mut self.dl, &mut self.dt, &mut self.ds, &mut self.product] {
            numbers.resize(n, 0.0);
        }
        self.pull.resize(n, 0.0);
        self.tangents.resize(n, SpringTangent::default());
        springs.measure_start(&mut self.at, self.sheets.resize(triangles));
        self.sheets.begin();
        self.decide();
        self.start(size);
    }

    /// Makes the measured springs the first tensions. `size` [N] is that of a nodal force, or of the loads.
    fn start(&mut self, size: f64) {
        let (_, length) = self.lengths();
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

    pub(super) fn has_one_sided(&self) -> bool {
        self.any_one_sided
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
    pub(super) fn mean_product(&self) -> Option<f64> {
        self.mean(|i| self.t[i] * self.s[i])
    }

    /// Aims at products of 0.
    pub(super) fn predict(&mut self) {
        self.product.fill(0.0);
    }

    /// Measures the springs at the last evaluated residual; `pull` [N] is then what its tensions exceed those of the
    /// iterate by.
    pub(super) fn measure(&mut self, springs: &mut dyn MixedSprings) {
        springs.measure(&mut self.at, self.sheets.state());
        self.decide();
        for i in 0..self.at.len() {
            self.pull[i] = self.at[i].tension - self.tension(i);
        }
    }

    /// [m] All lengths together, and their mean.
    pub(super) fn lengths(&self) -> (f64, f64) {
        let sum = self.at.iter().map(|spring| spring.length).sum::<f64>();
        (sum, sum / self.at.len() as f64)
    }

    /// [m] Norm of the errors of the tensions over the stiffnesses.
    pub(super) fn errors(&self) -> f64 {
        let springs = (0..self.at.len()).map(|i| self.error(i).powi(2)).sum::<f64>();
        (springs + self.sheets.errors_squared()).sqrt()
    }

    pub(super) fn begin_iteration(&mut self) {
        (self.most, self.tried) = (self.share, 0);
    }

    /// Factorises the matrix at the last evaluated residual with less of the tensions below 0 than before in this
    /// iteration, but as much as keeps it positive definite; `false` if it never is.
    pub(super) fn linearise(&mut self, springs: &mut dyn MixedSprings) -> Result<bool, LinearError> {
        let most = self.most;
        while let Some(&share) = [most, 0.5 * most, 0.0].get(self.tried) {
            self.tried += 1;
            self.set_tangents(share);
            let sheets = self.sheets.set_tangents(share);
            let (convex, definite) = (share < 1.0, share == 0.0);
            let form = MixedForm { springs: &self.tangents, sheets, convex, definite, symmetric: false };
            match springs.linearise(form) {
                Ok(Inertia::Indefinite) | Err(LinearError::Indefinite { .. }) => {}
                made => {
                    self.share = if share < most { share.max(LEAST_SHARE) } else { 0.5 * (1.0 + share) };
                    return made.map(|_| true);
                }
            }
        }
        Ok(false)
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
    pub(super) fn set_pull(&mut self) {
        // For springs both ways `tension` may be below the least one: it is what the residual has.
        for i in 0..self.at.len() {
            self.pull[i] = self.at[i].tension - (self.tension(i) + self.own_change(i));
        }
    }

    /// Finds the changes of all tensions, slacks and stresses for displacements `dz` `[n]`, and the shares that keep
    /// tensions and slacks positive.
    pub(super) fn follow(&mut self, springs: &dyn MixedSprings, dz: &[f64]) -> Shares {
        self.stretch(springs, dz);
        self.sheets.follow(&self.dofs);
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

    /// Aims at the corrector's products, after a predictor with these shares and a mean product of `now` [N m].
    pub(super) fn correct(&mut self, now: f64, shares: Shares) {
        let after = self.mean(|i| (self.t[i] + shares.t * self.dt[i]) * (self.s[i] + shares.x * self.ds[i]));
        let after = after.unwrap_or(0.0);
        let centre = (after / now).powi(3).clamp(LEAST_CENTRE, 1.0);
        let both = shares.x.min(shares.t);
        for i in 0..self.at.len() {
            self.product[i] = centre * now - both * self.dt[i] * self.ds[i];
        }
    }

    /// Takes shares of the changes, from the values before.
    pub(super) fn take(&mut self, shares: Shares) {
        self.sheets.take(shares.x);
        let [t, s] = &self.before;
        for i in 0..self.at.len() {
            let share = if self.at[i].is_one_sided() { shares.t } else { shares.x };
            self.t[i] = t[i] + share * self.dt[i];
            self.s[i] = s[i] + shares.x * self.ds[i];
        }
    }

    /// Whether displacements from the start `[n]` push a spring by more than its length.
    pub(in crate::solve) fn is_pushed_over(&mut self, springs: &mut dyn MixedSprings, dz: &[f64]) -> bool {
        self.begin(springs, 0.0, Sides::Loaded);
        self.stretch(springs, dz);
        self.at.iter().zip(&self.dl).any(|(spring, dl)| -dl > spring.length)
    }

    /// Whether springs that act both ways are taken as one-sided.
    pub(super) fn pushes_later(&self) -> bool {
        self.sides == Some(Sides::Loaded) && self.both_ways.contains(&true)
    }

    /// Lets the springs that act both ways push again, with the same tensions.
    pub(super) fn let_push(&mut self) {
        self.sides = Some(Sides::Interior);
        let both_ways = self.both_ways.iter().zip(&mut self.s);
        both_ways.filter(|(both_ways, _)| **both_ways).for_each(|(_, s)| *s = 0.0);
    }

    /// Adds the forces of the tensions `pull` to a residual [N] `[n]`; if `sheets`, also what the stresses of membranes
    /// have more than those of their strains.
    pub(super) fn add_pull(&mut self, springs: &dyn MixedSprings, r: &mut [f64], sheets: bool) {
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
        if sheets {
            self.sheets.add_pull(weight, &mut self.dofs);
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

    pub(super) fn remember(&mut self) {
        self.sheets.remember();
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
