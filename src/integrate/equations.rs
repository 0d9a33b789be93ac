//! The equations F(z) = 0 of one implicit step, and their tangent.
//!
//! ```text
//! x = x_n + z,   v = cv z + vv v_n + va a_n,   a = ca z + av v_n + aa a_n
//! F = M ((1 - am) a + am a_n) - (1 - af) f(x, v) - af f_n,      W = dF/dz = cm M + cc C + ck K
//! ```

use super::Counters;
use super::kept::Kept;
use super::stage::StageMap;
use super::tangents::{Tangents, Which};
use crate::model::point::Point;
use crate::model::system::{TangentSystem, Weights};
use crate::solve::newton::{Curvature, NonlinearProblem, Scales, norm};
use crate::solve::{Accuracy, Inertia, LinearError};

/// F(z) = 0 of one step.
pub(super) struct Equations<'a> {
    pub system: &'a dyn TangentSystem,
    pub map: StageMap,
    pub from: &'a Point,
    pub a: &'a [f64],
    pub to: &'a mut Point,
    pub counters: &'a mut Counters,
    pub tangents: &'a mut Tangents,
    pub kept: &'a mut Kept,
    pub a_next: &'a mut [f64],
    /// (1 - am) a_{n+1} + am a_n
    pub weighted: &'a mut [f64],
    /// M times that
    pub inertia: &'a mut [f64],
    /// [N/m] by degree of freedom
    pub stiffness: &'a [f64],
    /// [s]
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
    /// h v + h^2/2 a: of second order, saves an iteration in small steps
    ConstantAcceleration,
    /// h v
    ConstantVelocity,
    /// 0: the tangent of the state the step starts from decides where to go
    Rest,
}

/// A guess that changes the forces by more than this share of their size has left the neighbourhood in which it means
/// anything: it may have carried a spring past its anchor, from where Newton finds the mirrored solution.
const FORCE_CHANGE: f64 = 0.5;

/// [-] (w h)^2, with the stiffness and mass of a single unknown, above which a step is long for a spring: a guess may then
/// lie near the mirror image of its end, where the forces look right again. Half way there they do not.
const LONG_STEP: f64 = 4.0;

impl Equations<'_> {
    pub fn fill(&self, z: &mut [f64]) {
        let (h, v) = (self.h, &self.from.state.v);
        for (&dof, z) in self.tangents.dof.iter().zip(z) {
            let i = dof as usize;
            *z = match self.guess {
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
        let rates = self.stiffness.iter().zip(self.system.inverse_mass()).map(|(k, m)| k * m);
        self.h * self.h * rates.fold(0.0, f64::max) > LONG_STEP
    }

    /// Makes the kept factor again where another has taken its place since the last accepted step.
    pub fn recall(&mut self) -> Result<(), LinearError> {
        let Some((at, w, convex)) = self.kept.missing() else { return Ok(()) };
        let mut spent = Counters::default();
        self.tangents.freeze(self.system, at, w, convex, &mut spent)?;
        if self.kept.recalled() {
            *self.counters = self.counters.plus(spent);
        }
        Ok(())
    }

    /// Makes the kept matrix again where it was made, of the convex tangent; `false` if it was of that.
    fn make_convex(&mut self) -> Result<bool, LinearError> {
        let Some((at, w)) = self.kept.turn_convex() else { return Ok(false) };
        Ok(self.tangents.freeze(self.system, at, w, true, self.counters)?.is_some())
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
        let (n, map) = (&self.from.state, self.map);
        for (&dof, z) in self.tangents.dof.iter().zip(z) {
            let i = dof as usize;
            self.to.state.x[i] = n.x[i] + z;
            self.to.state.v[i] = map.cv * z + map.vv * n.v[i] + map.va * self.a[i];
            self.a_next[i] = map.ca * z + map.av * n.v[i] + map.aa * self.a[i];
            self.weighted[i] = (1.0 - map.am) * self.a_next[i] + map.am * self.a[i];
        }
        self.counters.evaluate(self.system, self.to.state.as_ref(), &mut self.to.forces);
        self.system.mass_times(self.weighted, self.inertia);
        let (f, f_n) = (&self.to.forces.total, &self.from.forces.total);
        // Positions are rounded to eps |x|, which springs turn into force; inertia is a difference of terms as large as
        // M v/(beta h).
        let moved = map.av.abs();
        for ((&dof, r), floor) in self.tangents.dof.iter().zip(r).zip(floor) {
            let i = dof as usize;
            let force = (1.0 - map.af) * f[i] + map.af * f_n[i];
            *r = self.inertia[i] - force;
            let mass = if self.weighted[i] != 0.0 { (self.inertia[i] / self.weighted[i]).abs() } else { 0.0 };
            let inertia = self.inertia[i].abs() + mass * moved * n.v[i].abs();
            *floor = 4.0 * f64::EPSILON * (self.stiffness[i] * self.largest + force.abs() + inertia);
        }
    }

    fn retreat(&mut self, z: &mut [f64]) -> bool {
        if self.guess == Guess::Rest {
            return false;
        }
        let mut too_far = self.is_far(&self.to.forces.total);
        if !too_far && self.is_long() {
            self.evaluate_halfway();
            too_far = self.is_far(&self.halfway.forces.total);
        }
        self.guess = match self.guess {
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
        self.kept.is_lost(self.tangents.symmetric());
        self.tangents.factor(self.system, self.to.state.as_ref(), w, curvature, self.counters)
    }

    fn freeze(&mut self) -> Result<bool, LinearError> {
        let w = self.weights();
        for convex in [false, true] {
            match self.tangents.freeze(self.system, self.to.state.as_ref(), w, convex, self.counters)? {
                None => return Ok(false),
                Some(Inertia::Indefinite) => {}
                Some(_) => {
                    self.kept.take(self.to.state.as_ref(), w, convex);
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    fn take_frozen(&mut self) {
        *self.mass_weight = Some(self.kept.weights().m);
        self.tangents.take(Which::Frozen);
    }

    fn keeps(&self) -> bool {
        self.tangents.keeps()
    }

    fn ask(&mut self, accuracy: Accuracy) {
        self.tangents.ask(accuracy);
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
        // A start without any force: what moves is compared with the force that would stop it within the step.
        system.mass_times(&from.state.v, product);
        residual = norm(product) * (map.ca / map.cv).abs();
    }
    let increment = norm(&from.state.v) / map.cv.abs().max(f64::MIN_POSITIVE);
    Scales { residual, increment, increment_floor: 4.0 * f64::EPSILON * norm(&from.state.x) }
}
