//! The simple pendulum (thesis Eq. 58-61 with Eq. 61's g/(mL) corrected to g/L): one angle from the lowest position.
//!
//! ```text
//! m L^2 theta'' = -m g L sin(theta) - c theta'
//! ```

use super::{BoundBuffer, Scene, Suspect};
use crate::assembly::{Assembler, PatternError, SceneInterfaces, TangentSystem};
use crate::force::TangentForm;
use crate::model::at_dof::AtDof;
use crate::model::forces::{Forces, Role, Tally};
use crate::model::observables::Observables;
use crate::model::spec::PendulumSpec;
use crate::model::state::{State, StateRef};
use crate::model::system::{StepMean, System, TermInfo, Weights};

/// A pendulum; its one degree of freedom is the angle [rad], its mass the moment of inertia.
#[derive(Clone, Debug)]
pub struct Pendulum {
    spec: PendulumSpec,
    inverse_inertia: [f64; 1],
    reference: [[f64; 3]; 1],
    terms: Vec<TermInfo>,
}

impl Pendulum {
    /// Makes a pendulum; the case reader has checked the numbers.
    pub fn new(spec: PendulumSpec) -> Self {
        let gravity = TermInfo::of("gravity", Role::Gravity);
        let mut terms = vec![gravity];
        if spec.damping != 0.0 {
            terms.push(TermInfo { name: "damping", role: Role::Dissipative, velocity_dependent: true, ..gravity });
        }
        let inverse_inertia = [1.0 / (spec.mass * spec.length * spec.length)];
        let mut pendulum = Pendulum { spec, inverse_inertia, reference: [[0.0; 3]], terms };
        pendulum.reference = [pendulum.bob(spec.angle)];
        pendulum
    }

    fn bob(&self, angle: f64) -> [f64; 3] {
        [self.spec.length * angle.sin(), 0.0, -self.spec.length * angle.cos()]
    }

    fn weight_moment(&self) -> f64 {
        self.spec.mass * self.spec.gravity * self.spec.length
    }
}

impl System for Pendulum {
    fn n_dof(&self) -> usize {
        1
    }

    fn initial_state(&self) -> State {
        State { t: 0.0, x: vec![self.spec.angle], v: vec![self.spec.rate] }
    }

    fn terms(&self) -> &[TermInfo] {
        &self.terms
    }

    fn new_forces(&self) -> Forces {
        Forces {
            total: vec![0.0],
            external: Vec::new(),
            dissipative: vec![0.0; self.terms.len() - 1],
            reactions: Vec::new(),
            tallies: vec![Tally::default(); self.terms.len()],
        }
    }

    fn evaluate(&self, at: StateRef<'_>, out: &mut Forces) {
        let (theta, rate) = (at.x[0], at.v[0]);
        out.total[0] = -self.weight_moment() * theta.sin();
        // Zero at the lowest position; 2 sin^2(theta/2) = 1 - cos(theta) without its cancellation.
        out.tallies[0].energy = 2.0 * self.weight_moment() * (0.5 * theta).sin().powi(2);
        if let (Some(f), Some(tally)) = (out.dissipative.first_mut(), out.tallies.get_mut(1)) {
            *f = -self.spec.damping * rate;
            tally.power = *f * rate;
            out.total[0] += *f;
        }
    }

    fn inverse_mass(&self) -> &[f64] {
        &self.inverse_inertia
    }

    fn mass_times(&self, a: &[f64], out: &mut [f64]) {
        out[0] = a[0] / self.inverse_inertia[0];
    }

    fn kinetic_energy(&self, v: &[f64]) -> f64 {
        0.5 * v[0] * v[0] / self.inverse_inertia[0]
    }

    fn velocity_dependent(&self) -> bool {
        self.spec.damping != 0.0
    }
}

impl TangentSystem for Pendulum {
    fn symmetric(&self) -> bool {
        true
    }

    fn assembler(&self) -> Result<Assembler, PatternError> {
        Ok(Assembler::dense(1))
    }

    fn assemble(&self, at: StateRef<'_>, w: Weights, assembler: &mut Assembler) {
        let k = self.weight_moment() * at.x[0].cos();
        assembler.values_mut()[0] = w.m / self.inverse_inertia[0] + w.c * self.spec.damping + w.k * k;
    }

    /// -(V_1 - V_0)/(theta_1 - theta_0) = -m g L sin(theta) sin(u)/u for the angle theta in the middle, with
    /// u = h/2 theta'.
    fn mean_forces(&self, middle: StateRef<'_>, mean: StepMean, out: &mut Forces) {
        self.evaluate(middle, out);
        let (theta, u) = (middle.x[0], mean.half * middle.v[0]);
        out.total[0] += self.weight_moment() * theta.sin() * (1.0 - sinc(u)[0]);
    }

    fn assemble_mean(
        &self,
        middle: StateRef<'_>,
        mean: StepMean,
        w: Weights,
        _: TangentForm,
        assembler: &mut Assembler,
    ) {
        let (theta, [sinc, slope]) = (middle.x[0], sinc(mean.half * middle.v[0]));
        let k = self.weight_moment() * (theta.cos() * sinc + theta.sin() * slope);
        assembler.values_mut()[0] = w.m / self.inverse_inertia[0] + w.c * self.spec.damping + w.k * k;
    }

    fn nodal_stiffness(&self) -> Vec<f64> {
        vec![self.weight_moment()]
    }

    fn force_scale(&self, _forces: &Forces) -> f64 {
        self.weight_moment()
    }
}

/// sin(u)/u and its derivative, by their series where quotients would lose digits.
fn sinc(u: f64) -> [f64; 2] {
    let square = u * u;
    if u.abs() < 1e-2 {
        return [1.0 - square / 6.0 * (1.0 - square / 20.0), -u / 3.0 * (1.0 - square / 10.0 * (1.0 - square / 28.0))];
    }
    let (sin, cos) = u.sin_cos();
    [sin / u, (u * cos - sin) / square]
}

impl Observables for Pendulum {
    fn reference(&self) -> &[[f64; 3]] {
        &self.reference
    }

    fn triangles(&self) -> &[[u32; 3]] {
        &[]
    }

    fn edges(&self) -> &[[u32; 2]] {
        &[]
    }

    fn trace(&self, at: StateRef<'_>, positions: &mut [[f64; 3]], velocities: &mut [[f64; 3]]) {
        let (theta, speed) = (at.x[0], self.spec.length * at.v[0]);
        positions[0] = self.bob(theta);
        velocities[0] = [speed * theta.cos(), 0.0, speed * theta.sin()];
    }

    /// Weight and drag; the rod's pull is no applied force.
    fn node_forces(&self, at: StateRef<'_>, _forces: &Forces, out: &mut [[f64; 3]]) {
        let drag = -self.spec.damping * at.v[0] / self.spec.length;
        let (sin, cos) = at.x[0].sin_cos();
        out[0] = [drag * cos, 0.0, drag * sin - self.spec.mass * self.spec.gravity];
    }

    fn node_reactions(&self, _forces: &Forces, out: &mut [[f64; 3]]) {
        out[0] = [0.0; 3];
    }

    fn edge_tension(&self, _at: StateRef<'_>, _tension: &mut [f64], _strain: &mut [f64]) {}

    fn max_strain(&self, _at: StateRef<'_>) -> f64 {
        0.0
    }

    fn max_speed(&self, at: StateRef<'_>) -> f64 {
        self.spec.length * at.v[0].abs()
    }
}

impl Scene for Pendulum {
    fn for_run(&self) -> Box<dyn Scene> {
        Box::new(self.clone())
    }

    fn interfaces(&self) -> SceneInterfaces<'_> {
        SceneInterfaces { system: self, tangent: self, graph: None }
    }

    fn size(&self) -> f64 {
        0.0
    }

    fn extent(&self, _at: StateRef<'_>) -> f64 {
        0.0
    }

    fn suspect(&self, _at: StateRef<'_>, _dof: usize) -> Suspect {
        Suspect { node: Some(0), spring: None, term: self.terms.first().copied() }
    }

    fn name_of(&self, _dof: usize) -> (u32, &'static str) {
        (0, "angle")
    }

    fn rate_bound(&self, at: StateRef<'_>, w: Weights, _buffer: &mut BoundBuffer) -> AtDof {
        let stiffness = w.k * self.weight_moment() * at.x[0].cos();
        AtDof { value: (w.c * self.spec.damping + stiffness.max(0.0)) * self.inverse_inertia[0], dof: 0 }
    }

    fn tangent_times(&self, at: StateRef<'_>, w: Weights, p: &[f64], y: &mut [f64]) {
        y[0] = (w.c * self.spec.damping + w.k * self.weight_moment() * at.x[0].cos()) * p[0];
    }
}
