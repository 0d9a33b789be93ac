//! Two triangles whose nodes move along cubics in time, and runs that show them to an observer.

use canopy_fem::drive::observer::{AcceptedStep, Energies, ObserveError, Observer, Point};
use canopy_fem::model::forces::Forces;
use canopy_fem::model::observables::Observables;
use canopy_fem::model::state::{State, StateRef};
use canopy_fem::model::system::{System, TermInfo};

/// Four nodes, five edges; the last edge carries no spring.
pub struct TrianglePair {
    reference: Vec<[f64; 3]>,
}

const START: [f64; 12] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.1, 0.0, 1.0, 0.2, 1.0, 1.0, 0.3];

impl TrianglePair {
    pub fn new() -> Self {
        Self { reference: START.as_chunks().0.to_vec() }
    }

    pub fn positions(&self, t: f64) -> Vec<f64> {
        let path = |i: usize| START[i] + t * (0.1 * i as f64 + t * (0.3 - 0.7 * t));
        (0..12).map(path).collect()
    }

    pub fn velocities(&self, t: f64) -> Vec<f64> {
        (0..12).map(|i| 0.1 * f64::from(i) + t * (0.6 - 2.1 * t)).collect()
    }

    pub fn forces(&self, t: f64) -> Vec<f64> {
        (0..12).map(|i| t * f64::from(i)).collect()
    }

    pub fn point(&self, t: f64) -> Point {
        let state = State { t, x: self.positions(t), v: self.velocities(t) };
        let mut forces = self.new_forces();
        self.evaluate(state.as_ref(), &mut forces);
        Point { state, forces }
    }
}

impl System for TrianglePair {
    fn n_dof(&self) -> usize {
        12
    }
    fn initial_state(&self) -> State {
        self.point(0.0).state
    }
    fn terms(&self) -> &[TermInfo] {
        &[]
    }
    fn new_forces(&self) -> Forces {
        Forces { total: vec![0.0; 12], reactions: vec![0.0; 3], ..Forces::default() }
    }
    fn evaluate(&self, at: StateRef<'_>, out: &mut Forces) {
        out.total.copy_from_slice(&self.forces(at.t));
        out.reactions.copy_from_slice(&[9.0, 8.0, 7.0]);
    }
    fn inverse_mass(&self) -> &[f64] {
        &[1.0; 12]
    }
    fn mass_times(&self, a: &[f64], out: &mut [f64]) {
        out.copy_from_slice(a);
    }
    fn kinetic_energy(&self, v: &[f64]) -> f64 {
        v.iter().map(|v| 0.5 * v * v).sum()
    }
    fn velocity_dependent(&self) -> bool {
        false
    }
}

impl Observables for TrianglePair {
    fn reference(&self) -> &[[f64; 3]] {
        &self.reference
    }
    fn triangles(&self) -> &[[u32; 3]] {
        &[[0, 1, 2], [1, 3, 2]]
    }
    fn edges(&self) -> &[[u32; 2]] {
        &[[0, 1], [1, 2], [2, 0], [1, 3], [3, 2]]
    }
    fn trace(&self, at: StateRef<'_>, positions: &mut [[f64; 3]], velocities: &mut [[f64; 3]]) {
        positions.as_flattened_mut().copy_from_slice(at.x);
        velocities.as_flattened_mut().copy_from_slice(at.v);
    }
    fn node_forces(&self, _at: StateRef<'_>, forces: &Forces, out: &mut [[f64; 3]]) {
        out.as_flattened_mut().copy_from_slice(&forces.total);
    }
    fn node_reactions(&self, forces: &Forces, out: &mut [[f64; 3]]) {
        out.fill([0.0; 3]);
        out[0].copy_from_slice(&forces.reactions);
    }
    fn edge_tension(&self, at: StateRef<'_>, tension: &mut [f64], strain: &mut [f64]) {
        for (i, (tension, strain)) in tension.iter_mut().zip(strain).enumerate() {
            let spring = i < 4;
            *tension = if spring { (i as f64 + 1.0) * (at.t + 1.0) } else { f64::NAN };
            *strain = *tension / 100.0;
        }
    }
    fn max_strain(&self, at: StateRef<'_>) -> f64 {
        2.0 * at.t
    }
    fn max_speed(&self, at: StateRef<'_>) -> f64 {
        at.t + 0.5
    }
}

/// An account with a different value in every column.
pub fn ledger(t: f64) -> Energies {
    Energies {
        kinetic: t / 3.0,
        elastic: 1e-12 * t,
        gravity: -t,
        external_work: 1e20 * t,
        dissipated: 5.0,
        numerical: t * t,
    }
}

pub fn view<'a>(from: &'a Point, to: &'a Point, step: u64) -> AcceptedStep<'a> {
    AcceptedStep {
        step,
        from: from.state.t,
        t: to.state.t,
        ledger: ledger(to.state.t),
        start: Some(from),
        end: Some(to),
        newton_iterations: 3,
        residual: 1e-9,
        credible: true,
        ..AcceptedStep::default()
    }
}

/// A fixed-step run from t = 0.
#[derive(Clone, Copy, Debug)]
pub struct Run {
    pub step: f64,
    pub steps: u32,
}

impl Run {
    pub fn end(self) -> f64 {
        f64::from(self.steps) * self.step
    }

    /// Start and steps, without the end.
    pub fn begin(self, pair: &TrianglePair, observer: &mut impl Observer) -> Result<(), ObserveError> {
        let mut from = pair.point(0.0);
        observer.started(&from, ledger(0.0))?;
        for step in 1..=self.steps {
            let to = pair.point(f64::from(step) * self.step);
            observer.accepted(view(&from, &to, u64::from(step)))?;
            from = to;
        }
        Ok(())
    }

    pub fn through(self, pair: &TrianglePair, observer: &mut impl Observer) -> Result<(), ObserveError> {
        self.begin(pair, observer)?;
        observer.finished(&pair.point(self.end()))
    }
}
