//! The equations F(z) = 0 of one implicit step, and their tangent.
//!
//! ```text
//! x = x_n + z,   v = cv z + vv v_n + va a_n,   a = ca z + av v_n + aa a_n
//! F = M ((1 - am) a + am a_n) - (1 - af) f(x, v) - af f_n,      W = dF/dz = cm M + cc C + ck K
//! ```

use super::Counters;
use super::balance::{Forces, Sizes, Start, displace, rounding, unbalanced};
use super::factor_cache::{FactorCache, FactorRequest};
use super::stage::StageMap;
use super::tangents::{Tangents, Which};
use crate::assembly::TangentSystem;
use crate::model::point::Point;
use crate::model::system::Weights;
use crate::solve::newton::{Curvature, NonlinearProblem, Scales};
use crate::solve::norms::norm;
use crate::solve::{Accuracy, Expected, Inertia, LinearError};

/// F(z) = 0 of one step.
pub(super) struct Equations<'a> {
    pub system: &'a dyn TangentSystem,
    pub map: StageMap,
    pub from: &'a Point,
    /// [m/s^2] accelerations at the step's start
    pub a: &'a [f64],
    /// [m/s^2] accelerations at its end, if they go on as they did in the step before
    pub expected: &'a [f64],
    pub to: &'a mut Point,
    pub counters: &'a mut Counters,
    pub tangents: &'a mut Tangents,
    pub cache: &'a mut FactorCache,
    /// [m/s^2] accelerations at the step's end
    pub a_next: &'a mut [f64],
    /// [kg] by degree of freedom
    pub mass: &'a [f64],
    /// room for vectors over all degrees of freedom
    pub wide: [&'a mut [f64]; 2],
    /// [N/m] by degree of freedom
    pub stiffness: &'a [f64],
    /// [1/s^2] the largest of that over its mass
    pub fastest: f64,
    /// [s] size of the step
    pub h: f64,
    /// [m] largest coordinate, which sets the rounding of positions
    pub largest: f64,
    /// [N] size of the forces at the step's start
    pub force_scale: f64,
    pub guess: Guess,
    pub halfway: &'a mut Point,
    pub mass_weight: &'a mut Option<f64>,
}

/// First guesses for the step's displacement, from the best to the most cautious.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Guess {
    /// what the scheme makes of accelerations that go on as they did
    Trend,
    /// h v + h^2/2 a: of second order, saves an iteration in small steps
    ConstantAcceleration,
    /// h v
    ConstantVelocity,
    /// 0: the tangent of the state the step starts from decides where to go
    Rest,
}

/// [-] A guess that changes the forces by more than this share of their size has left the neighbourhood in which it
/// means anything: it may have carried a spring past its anchor, from where Newton finds the mirrored solution.
const FORCE_CHANGE: f64 = 0.5;

/// [-] (w h)^2, with the stiffness and mass of a single unknown, above which a step is long for a spring: a guess may
/// then lie near the mirror image of its end, where the forces look right again. Half way there they do not. Looked at
/// only where a spring has turned over: the mirror image lies behind it.
const LONG_STEP: f64 = 4.0;

impl Equations<'_> {
    pub fn fill(&self, z: &mut [f64]) {
        let (h, v, map) = (self.h, &self.from.state.v, self.map);
        for (&dof, z) in self.tangents.dof.iter().zip(z) {
            let i = dof as usize;
            *z = match self.guess {
                Guess::Trend => (self.expected[i] - map.av * v[i] - map.aa * self.a[i]) / map.ca,
                Guess::ConstantAcceleration => h * (v[i] + 0.5 * h * self.a[i]),
                Guess::ConstantVelocity => h * v[i],
                Guess::Rest => 0.0,
            };
        }
    }

    /// Whether forces differ from those at the step's start by more than a share of their size.
    fn is_far(&self, forces: &[f64]) -> bool {
        let change: f64 = forces.iter().zip(&self.from.forces.total).map(|(a, b)| (a - b).powi(2)).sum();
        change.is_nan() || change.sqrt() > FORCE_CHANGE * self.force_scale
    }

    /// Of W = dF/dz.
    pub fn weights(&self) -> Weights {
        let new = 1.0 - self.map.af;
        Weights { m: (1.0 - self.map.am) * self.map.ca, c: new * self.map.cv, k: new }
    }

    fn is_long(&self) -> bool {
        self.h * self.h * self.fastest > LONG_STEP
    }

    /// Makes the kept factor again where another has taken its place since the last accepted step.
    pub fn rebuild_factor(&mut self) -> Result<(), LinearError> {
        let Some((at, w, make)) = self.cache.to_rebuild() else { return Ok(()) };
        let mut spent = Counters::default();
        self.tangents.freeze(self.system, at, w, make, &mut spent)?;
        if self.cache.rebuilt() {
            *self.counters = self.counters.plus(spent);
        }
        Ok(())
    }

    /// Makes the kept matrix again where it was made, of the convex tangent; `false` if it was of that.
    fn make_convex(&mut self) -> Result<bool, LinearError> {
        let Some((at, w, make)) = self.cache.turn_convex() else { return Ok(false) };
        Ok(self.tangents.freeze(self.system, at, w, make, self.counters)?.is_some())
    }

    fn evaluate_halfway(&mut self) {
        let (n, to, half) = (&self.from.state, &self.to.state, &mut self.halfway.state);
        half.t = to.t;
        for (half, (a, b)) in half.x.iter_mut().zip(n.x.iter().zip(&to.x)) {
            *half = 0.5 * (a + b);
        }
        half.v.copy_from_slice(&to.v);
        self.counters.evaluate(self.system, self.halfway.state.as_ref(), &mut self.halfway.forces);
    }
}

impl NonlinearProblem for Equations<'_> {
    fn residual(&mut self, z: &[f64], r: &mut [f64], floor: &mut [f64]) {
        let (map, n) = (self.map, &self.from.state);
        let [wide, floors] = &mut self.wide;
        wide.fill(0.0);
        for (&dof, z) in self.tangents.dof.iter().zip(z) {
            wide[dof as usize] = *z;
        }
        let (workers, start) = (self.system.workers(), Start { x: &n.x, v: &n.v, a: self.a });
        displace(workers, map, wide, start, (&mut self.to.state.x, &mut self.to.state.v));
        self.counters.evaluate(self.system, self.to.state.as_ref(), &mut self.to.forces);
        let forces = Forces { f_n: &self.from.forces.total, f: &self.to.forces.total, mass: self.mass };
        unbalanced(workers, map, start, forces, (self.a_next, wide));
        let sizes = Sizes { stiffness: self.stiffness, largest: self.largest, a: self.a_next };
        rounding(workers, map, start, forces, sizes, floors);
        let (wide, floors, dof) = (&**wide, &**floors, &*self.tangents.dof);
        workers.both((r, floor), |range, r, floor| {
            for ((&dof, r), floor) in dof[range].iter().zip(r).zip(floor) {
                (*r, *floor) = (wide[dof as usize], floors[dof as usize]);
            }
        });
    }

    fn retreat(&mut self, z: &mut [f64]) -> bool {
        if self.guess == Guess::Rest {
            return false;
        }
        let mut too_far = self.is_far(&self.to.forces.total);
        if !too_far && self.is_long() && self.system.turns_over(&self.from.state.x, &self.to.state.x) {
            self.evaluate_halfway();
            too_far = self.is_far(&self.halfway.forces.total);
        }
        self.guess = match self.guess {
            Guess::Trend if too_far => Guess::ConstantAcceleration,
            Guess::ConstantAcceleration if too_far => Guess::ConstantVelocity,
            Guess::ConstantVelocity if too_far => Guess::Rest,
            _ => return false,
        };
        self.fill(z);
        true
    }

    fn conservative(&self) -> bool {
        self.tangents.symmetric()
    }

    fn linearise(&mut self, curvature: Curvature) -> Result<Inertia, LinearError> {
        let w = self.weights();
        *self.mass_weight = Some(w.m);
        // Where W is symmetric the two share their room.
        self.cache.discard(self.tangents.symmetric());
        self.tangents.factor(self.system, self.to.state.as_ref(), w, curvature, self.counters)
    }

    fn freeze(&mut self, expected: Expected) -> Result<bool, LinearError> {
        let w = self.weights();
        for make in [false, true].map(|convex| FactorRequest { convex, expected }) {
            match self.tangents.freeze(self.system, self.to.state.as_ref(), w, make, self.counters)? {
                None => return Ok(false),
                Some(Inertia::Indefinite) => {}
                Some(_) => {
                    self.cache.store(self.to.state.as_ref(), w, make);
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    fn prefers_another(&self, expected: Expected) -> bool {
        self.tangents.prefers_another(expected)
    }

    fn cg_iterations(&self) -> u64 {
        self.counters.cg_iterations
    }

    fn take_frozen(&mut self) {
        *self.mass_weight = Some(self.cache.weights().m);
        self.tangents.take(Which::Frozen);
    }

    fn keeps(&self) -> bool {
        self.tangents.keeps()
    }

    fn ask(&mut self, accuracy: Accuracy) {
        self.tangents.ask(accuracy);
    }

    fn stopping_force(&mut self) -> f64 {
        stopping_force(self.system, self.from, self.map, self.wide[0])
    }

    fn factor_cost(&self) -> f64 {
        self.tangents.factor_cost()
    }

    fn solve(&mut self, b: &mut [f64]) -> Result<(), LinearError> {
        match self.tangents.solve(b, self.counters) {
            // Of a kept matrix that was not factorised this shows only here.
            Err(LinearError::Indefinite { .. })
                if self.tangents.solves_with(Which::Frozen) && self.make_convex()? =>
            {
                self.tangents.solve(b, self.counters)
            }
            solved => solved,
        }
    }
}

/// The sizes at the step's start that residuals and increments are compared with.
pub(super) fn scales(
    system: &dyn TangentSystem,
    from: &Point,
    a: &[f64],
    map: StageMap,
    product: &mut [f64],
) -> Scales {
    system.mass_times(a, product);
    let mut residual = system.force_scale(&from.forces).max(norm(product));
    if residual == 0.0 {
        // A start without any force.
        residual = stopping_force(system, from, map, product);
    }
    let increment = norm(&from.state.v) / map.cv.abs().max(f64::MIN_POSITIVE);
    Scales { residual, increment, increment_floor: 4.0 * f64::EPSILON * norm(&from.state.x) }
}

/// [N] The force that would stop what moves within the step.
fn stopping_force(system: &dyn TangentSystem, from: &Point, map: StageMap, product: &mut [f64]) -> f64 {
    system.mass_times(&from.state.v, product);
    norm(product) * (map.ca / map.cv).abs()
}
