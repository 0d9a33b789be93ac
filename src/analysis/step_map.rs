//! One real step of a scheme on the linearised scene as a linear map of (x, v), and whether it grows.
//!
//! For schemes that treat positions and velocities differently the map is no function of the scene's roots alone once
//! damping couples the modes; it is stepped instead, and its outer eigenvalues are estimated by Arnoldi's iteration.

use super::arnoldi::Krylov;
use super::linearised::{Linearised, norm, rough};
use super::matrices::Matrices;
use crate::assembly::{Assembler, PatternError};
use crate::integrate::Counters;
use crate::integrate::implicit::SolverSpec;
use crate::integrate::registry::MethodChoice;
use crate::integrate::stepper::{Attempt, Stepper};
use crate::model::forces::{Forces, Role, Tally};
use crate::model::point::Point;
use crate::model::state::{State, StateRef};
use crate::model::system::{Abilities, System, TangentSystem, TermInfo, Weights};
use std::sync::Arc;

static TERMS: [TermInfo; 1] = [TermInfo { name: "tangent", role: Role::Elastic }];

/// Ritz values with a larger residual are not yet eigenvalues of the map.
const CONVERGED: f64 = 0.02;

/// Steps made for one radius; what grows beyond a limit stands far from all that is stable, so it shows soon.
const PRODUCTS: usize = 40;

/// M a = -K x - C v.
pub(super) struct LinearScene {
    matrices: Arc<Matrices>,
    assembler: Assembler,
    inverse_mass: Vec<f64>,
    root: Vec<f64>,
    damped: bool,
}

impl LinearScene {
    /// `None` where the scene has no matrices.
    pub fn of(linear: &Linearised<'_>) -> Option<Self> {
        Some(LinearScene {
            matrices: Arc::clone(linear.matrices.as_ref()?),
            assembler: linear.scene.assembler().ok()?,
            inverse_mass: linear.scene.inverse_mass().to_vec(),
            root: linear.root.clone(),
            damped: linear.scene.velocity_dependent(),
        })
    }

    /// The eigenvalue of the step map that is largest in size, and the degree of freedom that moves most in it. `unit` [1/s]
    /// makes positions and velocities comparable.
    pub fn radius(&self, method: &MethodChoice, h: f64, unit: f64) -> Option<(f64, usize)> {
        let root = &self.root;
        let n = root.len();
        let abilities = Abilities { system: self, tangent: self, graph: None };
        let mut stepper = Stepper::bind(method.scheme(SolverSpec::default()), abilities).ok()?;
        let mut from = Point { state: self.initial_state(), forces: self.new_forces() };
        let mut to = from.clone();
        stepper.start(&from).ok()?;
        let mut failed = false;
        let inverse: Vec<f64> = root.iter().map(|&r| if r > 0.0 { 1.0 / r } else { 0.0 }).collect();
        let times = |q: &[f64], y: &mut [f64]| {
            for (i, root) in root.iter().enumerate() {
                (from.state.x[i], from.state.v[i]) = (q[i] * root / unit, q[n + i] * root);
            }
            self.evaluate(from.state.as_ref(), &mut from.forces);
            let stepped = stepper.attempt(Attempt { from: &from, h, t_next: h }, &mut to, &mut Counters::default());
            failed |= stepped.is_err();
            for (i, inverse) in inverse.iter().enumerate() {
                (y[i], y[n + i]) = (to.state.x[i] * inverse * unit, to.state.v[i] * inverse);
            }
        };
        let start: Vec<f64> = (0..2 * n).map(|i| if root[i % n] > 0.0 { rough(i) } else { 0.0 }).collect();
        let krylov = Krylov::of(start, PRODUCTS, times)?;
        let size = |re: f64, im: f64| norm(&[re, im]);
        let settled = krylov.values.iter().filter(|z| z.residual <= CONVERGED * size(z.re, z.im));
        let largest = settled.max_by(|a, b| size(a.re, a.im).total_cmp(&size(b.re, b.im)))?;
        if failed {
            return None;
        }
        let parts = krylov.parts(*largest);
        let moves = |i: usize| (parts[i] + parts[n + i]) * root[i].powi(2);
        let most = (0..n).max_by(|&a, &b| moves(a).total_cmp(&moves(b)))?;
        Some((size(largest.re, largest.im), most))
    }
}

impl System for LinearScene {
    fn n_dof(&self) -> usize {
        self.root.len()
    }

    fn initial_state(&self) -> State {
        State { t: 0.0, x: vec![0.0; self.n_dof()], v: vec![0.0; self.n_dof()] }
    }

    fn terms(&self) -> &[TermInfo] {
        &TERMS
    }

    fn new_forces(&self) -> Forces {
        Forces { total: vec![0.0; self.n_dof()], tallies: vec![Tally::default()], ..Forces::default() }
    }

    fn evaluate(&self, at: StateRef<'_>, out: &mut Forces) {
        self.matrices.times([-1.0, -1.0], [at.x, at.v], &mut out.total);
    }

    fn inverse_mass(&self) -> &[f64] {
        &self.inverse_mass
    }

    fn mass_times(&self, a: &[f64], out: &mut [f64]) {
        for ((out, a), inverse) in out.iter_mut().zip(a).zip(&self.inverse_mass) {
            *out = if *inverse > 0.0 { a / inverse } else { 0.0 };
        }
    }

    fn kinetic_energy(&self, v: &[f64]) -> f64 {
        let moving = v.iter().zip(&self.inverse_mass).filter(|(_, inverse)| **inverse > 0.0);
        moving.map(|(v, inverse)| 0.5 * v * v / inverse).sum()
    }

    fn velocity_dependent(&self) -> bool {
        self.damped
    }
}

impl TangentSystem for LinearScene {
    fn symmetric(&self) -> bool {
        self.assembler.pattern.symmetric
    }

    fn assembler(&self) -> Result<Assembler, PatternError> {
        Ok(self.assembler.clone())
    }

    fn assemble(&self, _at: StateRef<'_>, w: Weights, assembler: &mut Assembler) {
        let pattern = Arc::clone(&assembler.pattern);
        for (j, &column) in pattern.dof.iter().enumerate() {
            let values = assembler.values_mut().iter_mut().skip(pattern.col_ptr[j] as usize);
            for (&i, value) in pattern.column(j).iter().zip(values) {
                let row = pattern.dof[i as usize];
                let [k, c] = self.matrices.entry(row, column);
                let mass = if row == column { 1.0 / self.inverse_mass[row as usize] } else { 0.0 };
                *value = w.m * mass + w.c * c + w.k * k;
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
