//! One real step of a scheme on the linearised scene as a linear map of (x, v), and whether it grows.
//!
//! For schemes that treat positions and velocities differently the map is no function of the scene's roots alone once
//! damping couples the modes; it is stepped instead, and its outer eigenvalues are estimated by Arnoldi's iteration.

use super::arnoldi::Krylov;
use super::linearised::{norm, rough};
use crate::assembly::{Assembler, Pattern, PatternError};
use crate::integrate::Counters;
use crate::integrate::implicit::SolverSpec;
use crate::integrate::registry::MethodChoice;
use crate::integrate::stepper::{Attempt, Stepper};
use crate::model::forces::{Forces, Role, Tally};
use crate::model::point::Point;
use crate::model::state::{State, StateRef};
use crate::model::system::{Abilities, System, TangentSystem, TermInfo, Weights};
use crate::scene::Scene;
use std::sync::Arc;

static TERMS: [TermInfo; 1] = [TermInfo { name: "tangent", role: Role::Elastic }];

/// Ritz values with a larger residual are not yet eigenvalues of the map.
const CONVERGED: f64 = 0.02;

/// Steps made for one radius; what grows beyond a limit stands far from all that is stable, so it shows soon.
const PRODUCTS: usize = 40;

/// M a = -K x - C v over the unknowns.
pub(super) struct LinearScene {
    assembler: Assembler,
    pattern: Arc<Pattern>,
    k: Vec<f64>,
    c: Vec<f64>,
    inverse_mass: Vec<f64>,
    damped: bool,
}

impl LinearScene {
    /// `None` where the matrix cannot be numbered.
    pub fn of(scene: &dyn Scene, at: StateRef<'_>) -> Option<Self> {
        let mut assembler = scene.assembler().ok()?;
        let mut values = |c: f64, k: f64| {
            scene.assemble(at, Weights { m: 0.0, c, k }, &mut assembler);
            assembler.values().to_vec()
        };
        let (c, k) = (values(1.0, 0.0), values(0.0, 1.0));
        let pattern = Arc::clone(&assembler.pattern);
        let inverse = scene.inverse_mass();
        let inverse_mass = pattern.dof.iter().map(|&dof| inverse.get(dof as usize).copied().unwrap_or(0.0)).collect();
        Some(LinearScene { assembler, pattern, k, c, inverse_mass, damped: scene.velocity_dependent() })
    }

    /// The eigenvalue of the step map that is largest in size, and the degree of freedom that moves most in it. `unit` [1/s]
    /// makes positions and velocities comparable.
    pub fn radius(&self, method: &MethodChoice, h: f64, unit: f64) -> Option<(f64, usize)> {
        let n = self.inverse_mass.len();
        let abilities = Abilities { system: self, tangent: self, graph: None };
        let mut stepper = Stepper::bind(method.scheme(SolverSpec::default()), abilities).ok()?;
        let mut from = Point { state: self.initial_state(), forces: self.new_forces() };
        let mut to = from.clone();
        stepper.start(&from).ok()?;
        let mut failed = false;
        let root: Vec<f64> = self.inverse_mass.iter().map(|m| m.sqrt()).collect();
        let times = |q: &[f64], y: &mut [f64]| {
            for (i, root) in root.iter().enumerate() {
                (from.state.x[i], from.state.v[i]) = (q[i] * root / unit, q[n + i] * root);
            }
            self.evaluate(from.state.as_ref(), &mut from.forces);
            let stepped = stepper.attempt(Attempt { from: &from, h, t_next: h }, &mut to, &mut Counters::default());
            failed |= stepped.is_err();
            for (i, root) in root.iter().enumerate() {
                (y[i], y[n + i]) = (to.state.x[i] / root * unit, to.state.v[i] / root);
            }
        };
        let start: Vec<f64> = (0..2 * n).map(rough).collect();
        let krylov = Krylov::of(start, PRODUCTS, times)?;
        let size = |re: f64, im: f64| norm(&[re, im]);
        let settled = krylov.values.iter().filter(|z| z.residual <= CONVERGED * size(z.re, z.im));
        let largest = settled.max_by(|a, b| size(a.re, a.im).total_cmp(&size(b.re, b.im)))?;
        if failed {
            return None;
        }
        let parts = krylov.parts(*largest);
        let moves = |i: usize| (parts[i] + parts[n + i]) * self.inverse_mass[i];
        let most = (0..n).max_by(|&a, &b| moves(a).total_cmp(&moves(b)))?;
        Some((size(largest.re, largest.im), self.pattern.dof[most] as usize))
    }
}

impl System for LinearScene {
    fn n_dof(&self) -> usize {
        self.inverse_mass.len()
    }

    fn initial_state(&self) -> State {
        State { t: 0.0, x: vec![0.0; self.n_dof()], v: vec![0.0; self.n_dof()] }
    }

    fn terms(&self) -> &[TermInfo] {
        &TERMS
    }

    fn new_forces(&self) -> Forces {
        // The room of the dissipative forces, which this system does not tell apart, holds K x.
        let n = self.n_dof();
        Forces { total: vec![0.0; n], dissipative: vec![0.0; n], tallies: vec![Tally::default()], ..Forces::default() }
    }

    fn evaluate(&self, at: StateRef<'_>, out: &mut Forces) {
        self.pattern.multiply(&self.k, at.x, &mut out.dissipative);
        self.pattern.multiply(&self.c, at.v, &mut out.total);
        for (f, kx) in out.total.iter_mut().zip(&out.dissipative) {
            *f = -(*f + kx);
        }
    }

    fn inverse_mass(&self) -> &[f64] {
        &self.inverse_mass
    }

    fn mass_times(&self, a: &[f64], out: &mut [f64]) {
        for ((out, a), inverse) in out.iter_mut().zip(a).zip(&self.inverse_mass) {
            *out = a / inverse;
        }
    }

    fn kinetic_energy(&self, v: &[f64]) -> f64 {
        v.iter().zip(&self.inverse_mass).map(|(v, inverse)| 0.5 * v * v / inverse).sum()
    }

    fn velocity_dependent(&self) -> bool {
        self.damped
    }
}

impl TangentSystem for LinearScene {
    fn symmetric(&self) -> bool {
        self.pattern.symmetric
    }

    fn assembler(&self) -> Result<Assembler, PatternError> {
        Ok(self.assembler.clone())
    }

    fn assemble(&self, _at: StateRef<'_>, w: Weights, assembler: &mut Assembler) {
        let values = assembler.values_mut();
        for ((value, c), k) in values.iter_mut().zip(&self.c).zip(&self.k) {
            *value = w.c * c + w.k * k;
        }
        for (i, inverse) in (0..).zip(&self.inverse_mass) {
            if let Some(value) = self.pattern.slot(i, i).and_then(|slot| values.get_mut(slot as usize)) {
                *value += w.m / inverse;
            }
        }
    }

    fn nodal_stiffness(&self) -> Vec<f64> {
        vec![0.0; self.n_dof()]
    }

    fn force_scale(&self, forces: &Forces) -> f64 {
        norm(&forces.total)
    }
}
