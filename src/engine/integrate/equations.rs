//! The equations F(z) = 0 of one implicit step, and their tangent.
//!
//! ```text
//! x = x_n + z,   v = cv z + vv v_n + va a_n,   a = ca z + av v_n + aa a_n
//! F = M ((1 - am) a + am a_n) - (1 - af) f(x, v) - af f_n,      W = dF/dz = cm M + cc C + ck K
//! ```

use super::Counters;
use super::balance::{Forces, Sizes, Start, displace, rounding, unbalanced};
use super::factor_cache::Refactor;
use super::factor_cache::{FactorCache, FactorRequest};
use super::stage::StageMap;
use super::tangents::{TangentKind, Tangents};
use crate::assembly::{MixedForm, TangentSystem};
use crate::model::point::Point;
use crate::model::spring_state::{SheetState, SpringState};
use crate::model::system::Weights;
use crate::solve::newton::{Curvature, MixedSprings, NonlinearProblem, Scales};
use crate::solve::{Accuracy, ExpectedUse, Inertia, LinearError};

/// F(z) = 0 of one step. The unknown z is the displacement of the free degrees of freedom [m].
pub(super) struct Equations<'a> {
    pub system: &'a dyn TangentSystem,
    pub map: StageMap,
    pub start: StepStart<'a>,
    /// the end of the step, for the last z
    pub to: &'a mut Point,
    /// the first guess that the iteration begins from
    pub guess: Guess,
    pub dofs: &'a DofData,
    pub workspace: &'a mut Workspace,
    pub linear: &'a mut LinearState,
    pub counters: &'a mut Counters,
}

/// Data of a step known at its start.
pub(super) struct StepStart<'a> {
    pub from: &'a Point,
    /// [m/s^2] accelerations at the step's start `[n_dof]`
    pub a: &'a [f64],
    /// [m/s^2] accelerations at its end, if they change as they did in the step before `[n_dof]`
    pub expected: &'a [f64],
    /// [s] size of the step
    pub h: f64,
    /// [s] end of the run
    pub end: f64,
    /// [m] Largest coordinate in `x` `[n_dof]`., which sets the rounding of positions
    pub largest: f64,
    /// [N] size of the forces at the step's start
    pub force_scale: f64,
}

/// Masses and stiffnesses by degree of freedom.
pub(super) struct DofData {
    /// [kg] `[n_dof]`
    pub mass: Vec<f64>,
    /// [N/m] `[n_dof]`
    pub stiffness: Vec<f64>,
    /// [1/s^2] the largest ratio of stiffness to mass
    pub fastest: f64,
}

impl DofData {
    pub(super) fn of(system: &dyn TangentSystem) -> Self {
        let mut mass = vec![0.0; system.n_dof()];
        system.mass_times(&vec![1.0; system.n_dof()], &mut mass);
        let stiffness = system.nodal_stiffness();
        let fastest = stiffness.iter().zip(system.inverse_mass()).fold(0.0, |most: f64, (k, m)| most.max(k * m));
        DofData { mass, stiffness, fastest }
    }
}

/// Buffers of a step.
pub(super) struct Workspace {
    /// [m/s^2] accelerations at the step's end `[n_dof]`
    pub a_next: Vec<f64>,
    /// displacements, then residuals [N] `[n_dof]`
    pub residual: Vec<f64>,
    /// [N] rounding floors of the residuals `[n_dof]`
    pub floor: Vec<f64>,
    /// the state half way to a first guess
    pub halfway: Point,
    /// [m] positions and displacements of what may touch `[n_dof]`, else empty
    place: Vec<f64>,
    way: Vec<f64>,
}

impl Workspace {
    pub(super) fn new(at: &Point, touches: bool) -> Self {
        let zero = || vec![0.0; at.state.x.len()];
        let zero_if = |needed: bool| if needed { zero() } else { Vec::new() };
        let (place, way) = (zero_if(touches), zero_if(touches));
        Workspace { a_next: zero(), residual: zero(), floor: zero(), halfway: at.clone(), place, way }
    }
}

/// The matrices of a run and their state.
pub(super) struct LinearState {
    pub tangents: Tangents,
    pub cache: FactorCache,
    /// [1/s^2] weight of the mass in the W that is factorised; `None` if the last attempt factorised none
    pub mass_weight: Option<f64>,
}

/// First guesses of the step's displacement, from the most accurate to the most cautious.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Guess {
    /// the scheme's displacement for accelerations that change as in the last step
    Trend,
    /// h v + h^2/2 a: second order, saves an iteration in small steps
    ConstantAcceleration,
    /// h v
    ConstantVelocity,
    /// 0: the first direction is that of the tangent at the step's start
    Rest,
}

/// [-] A guess that changes the forces by more than this share of their size is too far: it may have carried a spring
/// past its anchor, from where Newton finds the mirrored solution.
const FORCE_CHANGE: f64 = 0.5;

/// [-] (w h)^2, from the stiffness and mass of a single unknown, above which a step is long for a spring. A guess may
/// then lie near the mirror image of the solution, where the forces look right again; half way there they do not.
/// Checked only if a spring has turned over, as the mirror image lies behind it.
const LONG_STEP: f64 = 4.0;

impl Equations<'_> {
    pub(super) fn fill(&self, z: &mut [f64]) {
        let (&StepStart { from, a, expected, h, .. }, map, guess) = (&self.start, self.map, self.guess);
        let (v, dof) = (&from.state.v, &*self.linear.tangents.dof);
        let of = |i: usize| match guess {
            Guess::Trend => (expected[i] - map.av * v[i] - map.aa * a[i]) / map.ca,
            Guess::ConstantAcceleration => h * (v[i] + 0.5 * h * a[i]),
            Guess::ConstantVelocity => h * v[i],
            Guess::Rest => 0.0,
        };
        let workers = self.system.workers();
        workers.set(z, |range, z| z.iter_mut().zip(&dof[range]).for_each(|(z, &dof)| *z = of(dof as usize)));
    }

    /// Writes the first guess, where nothing passes through anything else.
    pub(super) fn guess(&mut self, z: &mut [f64]) {
        self.fill(z);
        self.shorten(None, z);
    }

    /// Shortens the displacement `dz` of nodes that would touch others, on the way from `z`, or with all that moves
    /// from the start of the step. Returns the share that is free for all; `None` where nothing may touch.
    fn shorten(&mut self, z: Option<&[f64]>, dz: &mut [f64]) -> Option<f64> {
        let touches = self.system.touches()?;
        let Workspace { place, way, .. } = &mut *self.workspace;
        let (from, times) = (&self.start.from.state, self.system.way_over_unknown());
        let end = from.t + times * (self.to.state.t - from.t);
        place.copy_from_slice(&from.x);
        way.fill(0.0);
        let carried = if z.is_some() { &mut *place } else { &mut *way };
        for &dof in self.system.moved() {
            carried[dof as usize] += times * self.start.h * from.v[dof as usize];
        }
        let dofs = &*self.linear.tangents.dof;
        dofs.iter().zip(z.into_iter().flatten()).for_each(|(&dof, z)| place[dof as usize] += times * z);
        dofs.iter().zip(&*dz).for_each(|(&dof, dz)| way[dof as usize] = times * dz);
        let begun = if z.is_some() { end } else { from.t };
        let least = touches.keep_apart(place, [begun, end], way);
        if least < 1.0 {
            dz.iter_mut().zip(dofs).for_each(|(dz, &dof)| *dz = way[dof as usize] / times);
        }
        Some(least)
    }

    /// Whether forces [N] differ from those at the step's start by more than a share of their size.
    fn is_far(&self, forces: &[f64]) -> bool {
        let before = &self.start.from.forces.total;
        let change = self.system.workers().sum(forces.len(), |range| {
            forces[range.clone()].iter().zip(&before[range]).map(|(a, b)| (a - b).powi(2)).sum()
        });
        change.is_nan() || change.sqrt() > FORCE_CHANGE * self.start.force_scale
    }

    /// The weights of W = dF/dz.
    pub(super) fn weights(&self) -> Weights {
        let new = 1.0 - self.map.af;
        Weights { m: (1.0 - self.map.am) * self.map.ca, c: new * self.map.cv, k: new }
    }

    fn is_long(&self) -> bool {
        self.start.h * self.start.h * self.dofs.fastest > LONG_STEP
    }

    /// Rebuilds the reused factor if an attempt since the last accepted step has overwritten it.
    pub(super) fn rebuild_factor(&mut self) -> Result<(), LinearError> {
        let Some(Refactor { at, w, request }) = self.linear.cache.outdated() else { return Ok(()) };
        let mut spent = Counters::default();
        self.linear.tangents.freeze(self.system, at, w, request, &mut spent)?;
        if self.linear.cache.rebuilt() {
            *self.counters = self.counters.plus(spent);
        }
        Ok(())
    }

    /// Rebuilds the reused matrix from the convex tangent at the same state; `false` if it was convex already.
    fn make_convex(&mut self) -> Result<bool, LinearError> {
        let Some(Refactor { at, w, request }) = self.linear.cache.turn_convex() else { return Ok(false) };
        Ok(self.linear.tangents.freeze(self.system, at, w, request, self.counters)?.is_some())
    }

    fn evaluate_halfway(&mut self) {
        let halfway = &mut self.workspace.halfway;
        let (n, to, half) = (&self.start.from.state, &self.to.state, &mut halfway.state);
        half.t = to.t;
        self.system.workers().both(&mut half.x, &mut half.v, |r, x, v| {
            for (x, (a, b)) in x.iter_mut().zip(n.x[r.clone()].iter().zip(&to.x[r.clone()])) {
                *x = 0.5 * (a + b);
            }
            v.copy_from_slice(&to.v[r]);
        });
        self.counters.evaluate(self.system, halfway.state.as_ref(), &mut halfway.forces);
    }
}

impl NonlinearProblem for Equations<'_> {
    fn residual(&mut self, z: &[f64], r: &mut [f64], floor: &mut [f64]) {
        let (map, from, dofs) = (self.map, self.start.from, self.dofs);
        let Workspace { a_next, residual, floor: floors, .. } = &mut *self.workspace;
        let dof = &*self.linear.tangents.dof;
        let workers = self.system.workers();
        workers.set(residual, |range, residual| {
            residual.fill(0.0);
            // Degrees of freedom ascend with the unknowns.
            let [first, last] = [range.start, range.end].map(|end| dof.partition_point(|&dof| (dof as usize) < end));
            for (&dof, z) in dof[first..last].iter().zip(&z[first..last]) {
                residual[dof as usize - range.start] = *z;
            }
        });
        for &dof in self.system.moved() {
            residual[dof as usize] = self.start.h * from.state.v[dof as usize];
        }
        let start = Start { x: &from.state.x, v: &from.state.v, a: self.start.a };
        displace(workers, map, residual, start, &mut self.to.state.x, &mut self.to.state.v);
        for &dof in self.system.moved() {
            self.to.state.v[dof as usize] = from.state.v[dof as usize];
        }
        self.counters.evaluate(self.system, self.to.state.as_ref(), &mut self.to.forces);
        let forces = Forces { f_n: &from.forces.total, f: &self.to.forces.total, mass: &dofs.mass };
        unbalanced(workers, map, start, forces, a_next, residual);
        self.system.with_apparent_mass(self.to.state.as_ref(), residual);
        let sizes = Sizes { stiffness: &dofs.stiffness, largest: self.start.largest, a: a_next };
        rounding(workers, map, start, forces, sizes, floors);
        let (residual, floors) = (&**residual, &**floors);
        workers.both(r, floor, |range, r, floor| {
            for ((&dof, r), floor) in dof[range].iter().zip(r).zip(floor) {
                (*r, *floor) = (residual[dof as usize], floors[dof as usize]);
            }
        });
    }

    fn replace_far_guess(&mut self, z: &mut [f64]) -> bool {
        if self.guess == Guess::Rest {
            return false;
        }
        let mut too_far = self.is_far(&self.to.forces.total);
        if !too_far && self.is_long() && self.system.turns_over(&self.start.from.state.x, &self.to.state.x) {
            self.evaluate_halfway();
            too_far = self.is_far(&self.workspace.halfway.forces.total);
        }
        self.guess = match self.guess {
            Guess::Trend if too_far => Guess::ConstantAcceleration,
            Guess::ConstantAcceleration if too_far => Guess::ConstantVelocity,
            Guess::ConstantVelocity if too_far => Guess::Rest,
            _ => return false,
        };
        self.guess(z);
        true
    }

    fn keep_apart(&mut self, z: &[f64], dz: &mut [f64]) -> Option<f64> {
        self.shorten(Some(z), dz)
    }

    fn presses(&self) -> bool {
        self.system.touches().is_some_and(|touches| touches.presses())
    }

    fn conservative(&self) -> bool {
        self.linear.tangents.symmetric()
    }

    fn leave_to_gradients(&mut self, expected: Option<ExpectedUse>) {
        self.linear.tangents.leave_to_gradients(expected);
    }

    fn linearise(&mut self, curvature: Curvature) -> Result<Inertia, LinearError> {
        let w = self.weights();
        self.linear.mass_weight = Some(w.m);
        // If W is symmetric the two share their memory.
        self.linear.cache.discard(self.linear.tangents.symmetric());
        self.linear.tangents.factor(self.system, self.to.state.as_ref(), w, curvature, self.counters)
    }

    fn freeze(&mut self, expected: ExpectedUse) -> Result<bool, LinearError> {
        let w = self.weights();
        for make in [false, true].map(|convex| FactorRequest { convex, expected }) {
            match self.linear.tangents.freeze(self.system, self.to.state.as_ref(), w, make, self.counters)? {
                None => return Ok(false),
                Some(Inertia::Indefinite) => {}
                Some(_) => {
                    self.linear.cache.store(self.to.state.as_ref(), w, make);
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    fn steps_left(&self) -> f64 {
        f64::max((self.start.end - self.start.from.state.t) / self.start.h, 1.0)
    }

    fn prefers_other_solver(&self, expected: ExpectedUse) -> bool {
        self.linear.tangents.prefers_other_solver(expected)
    }

    fn cg_iterations(&self) -> u64 {
        self.counters.cg_iterations
    }

    fn cg_cost(&self) -> f64 {
        self.linear.tangents.cg_cost()
    }

    fn with_multigrid(&self) -> bool {
        self.linear.tangents.with_multigrid()
    }

    fn take_frozen(&mut self) {
        self.linear.mass_weight = Some(self.linear.cache.weights().m);
        self.linear.tangents.take(TangentKind::Frozen);
    }

    fn reuses_factors(&self) -> bool {
        self.linear.tangents.reuses_factors()
    }

    fn set_accuracy(&mut self, accuracy: Accuracy) {
        self.linear.tangents.set_accuracy(accuracy);
    }

    fn stopping_force(&mut self) -> f64 {
        stopping_force(self.system, self.start.from, self.map, &mut self.workspace.residual)
    }

    fn factor_cost(&self) -> f64 {
        self.linear.tangents.factor_cost()
    }

    fn mixed(&mut self) -> Option<&mut dyn MixedSprings> {
        if self.system.mixed().is_some() { Some(self) } else { None }
    }

    fn solve(&mut self, b: &mut [f64]) -> Result<(), LinearError> {
        match self.linear.tangents.solve(b, self.counters) {
            // A reused matrix that is not factorised shows this only in a solve.
            Err(LinearError::Indefinite { .. })
                if self.linear.tangents.solves_with(TangentKind::Frozen) && self.make_convex()? =>
            {
                self.linear.tangents.solve(b, self.counters)
            }
            solved => solved,
        }
    }
}

impl MixedSprings for Equations<'_> {
    fn counts(&self) -> [usize; 2] {
        self.system.mixed().map_or([0; 2], |mixed| [mixed.springs(), mixed.sheets()])
    }

    fn measure_start(&mut self, springs: &mut [SpringState], sheets: &mut [SheetState]) {
        if let Some(mixed) = self.system.mixed() {
            mixed.measure(self.start.from.state.as_ref(), self.map.cv, springs);
            mixed.measure_sheets(self.start.from.state.as_ref(), self.map.cv, sheets);
        }
    }

    fn measure(&mut self, springs: &mut [SpringState], sheets: &mut [SheetState]) {
        if let Some(mixed) = self.system.mixed() {
            mixed.measure(self.to.state.as_ref(), self.map.cv, springs);
            mixed.measure_sheets(self.to.state.as_ref(), self.map.cv, sheets);
        }
    }

    fn linearise(&mut self, form: MixedForm<'_>) -> Result<Inertia, LinearError> {
        let (w, system) = (self.weights(), self.system);
        let Some(mixed) = system.mixed() else { return Err(LinearError::Singular { unknown: None }) };
        self.linear.mass_weight = Some(w.m);
        self.linear.cache.discard(true);
        let at = (self.to.state.as_ref(), w);
        self.linear.tangents.factor_mixed((system, mixed), at, form, self.counters)
    }

    fn dofs(&self) -> (&[u32], usize) {
        (&self.linear.tangents.dof, self.system.n_dof())
    }

    fn weight(&self) -> f64 {
        self.weights().k
    }
}

/// Scales of residuals and increments, from the step's start. Slices are `[n_dof]`.
pub(super) fn scales(
    system: &dyn TangentSystem,
    from: &Point,
    a: &[f64],
    map: StageMap,
    product: &mut [f64],
) -> Scales {
    let workers = system.workers();
    system.mass_times(a, product);
    let mut residual = system.force_scale(&from.forces).max(workers.norm(product));
    if residual == 0.0 {
        // No force acts at the start.
        residual = stopping_force(system, from, map, product);
    }
    let increment = workers.norm(&from.state.v) / map.cv.abs().max(f64::MIN_POSITIVE);
    Scales { residual, increment, increment_floor: 4.0 * f64::EPSILON * workers.norm(&from.state.x) }
}

/// [N] The force that would stop the motion within the step; `product` `[n_dof]` is overwritten.
fn stopping_force(system: &dyn TangentSystem, from: &Point, map: StageMap, product: &mut [f64]) -> f64 {
    system.mass_times(&from.state.v, product);
    system.workers().norm(product) * (map.ca / map.cv).abs()
}
