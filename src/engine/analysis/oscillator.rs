//! A damped oscillator m x'' = -k x - c x', m = 1: what a scheme's stability is tried on.

use crate::assembly::{Assembler, PatternError, TangentSystem};
use crate::force::TangentForm;
use crate::model::forces::{Forces, Role, Tally};
use crate::model::state::{State, StateRef};
use crate::model::system::{BesideStiff, StepMean, StiffPart, StiffSprings, System, TermInfo, Weights};

const SPRING: TermInfo = TermInfo::of("spring", Role::Elastic);
const DAMPING: TermInfo = TermInfo { name: "damping", role: Role::Dissipative, velocity_dependent: true, ..SPRING };
static TERMS: [TermInfo; 2] = [SPRING, DAMPING];

/// The oscillator; x = 1, v = 0 at the start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Oscillator {
    /// [N/m]
    pub k: f64,
    /// [N s/m]
    pub c: f64,
}

impl System for Oscillator {
    fn n_dof(&self) -> usize {
        1
    }

    fn initial_state(&self) -> State {
        State { t: 0.0, x: vec![1.0], v: vec![0.0] }
    }

    fn terms(&self) -> &[TermInfo] {
        &TERMS
    }

    fn new_forces(&self) -> Forces {
        let tallies = vec![Tally::default(); 2];
        Forces { total: vec![0.0], external: vec![], dissipative: vec![0.0], reactions: vec![], tallies }
    }

    fn evaluate(&self, at: StateRef<'_>, out: &mut Forces) {
        let (x, v) = (at.x[0], at.v[0]);
        out.dissipative[0] = -self.c * v;
        out.total[0] = -self.k * x + out.dissipative[0];
        out.tallies[0].energy = 0.5 * self.k * x * x;
        out.tallies[1].power = out.dissipative[0] * v;
    }

    fn inverse_mass(&self) -> &[f64] {
        &[1.0]
    }

    fn mass_times(&self, a: &[f64], out: &mut [f64]) {
        out.copy_from_slice(a);
    }

    fn kinetic_energy(&self, v: &[f64]) -> f64 {
        0.5 * v[0] * v[0]
    }

    fn stiff(&self) -> Option<&dyn StiffSprings> {
        Some(self)
    }

    fn velocity_dependent(&self) -> bool {
        self.c != 0.0
    }
}

/// The only spring is the stiffest.
impl StiffSprings for Oscillator {
    fn stiff_part(&self, _ratio: f64) -> Option<StiffPart> {
        Some(StiffPart { dofs: vec![0], system: Box::new(*self), share: 1.0 })
    }

    fn beside_stiff(&self, _ratio: f64, _at: StateRef<'_>) -> Option<BesideStiff> {
        None
    }
}

impl TangentSystem for Oscillator {
    fn symmetric(&self) -> bool {
        true
    }

    fn assembler(&self) -> Result<Assembler, PatternError> {
        Ok(Assembler::dense(1))
    }

    fn assemble(&self, _at: StateRef<'_>, w: Weights, assembler: &mut Assembler) {
        assembler.values_mut()[0] = w.m + w.c * self.c + w.k * self.k;
    }

    fn mean_forces(&self, middle: StateRef<'_>, mean: StepMean, out: &mut Forces) {
        self.evaluate(middle, out);
        out.total[0] -= self.k * mean.dissipation * mean.half * middle.v[0];
    }

    fn assemble_mean(
        &self,
        middle: StateRef<'_>,
        mean: StepMean,
        w: Weights,
        _: TangentForm,
        assembler: &mut Assembler,
    ) {
        self.assemble(middle, Weights { k: (1.0 + mean.dissipation) * w.k, ..w }, assembler);
    }

    fn nodal_stiffness(&self) -> Vec<f64> {
        vec![self.k]
    }

    fn force_scale(&self, _forces: &Forces) -> f64 {
        self.k
    }
}
