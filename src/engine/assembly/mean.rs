//! A system whose forces are means over a step, at the state in the middle of the step: what an energy-momentum method
//! solves.

use super::{Assembler, PatternError, TangentSystem};
use crate::force::TangentForm;
use crate::model::abilities::Touches;
use crate::model::forces::Forces;
use crate::model::state::{State, StateRef};
use crate::model::system::{StepMean, System, TermInfo, Weights};
use crate::model::workers::Workers;

/// A system with the [mean forces](TangentSystem::mean_forces) of steps of one size. Matrices are those of the step of
/// backward Euler that ends in the middle of the step: their weights have `c` = 1/half.
#[derive(Clone, Copy)]
pub struct MeanSystem<'a> {
    /// the system
    pub system: &'a dyn TangentSystem,
    /// the step
    pub mean: StepMean,
}

impl MeanSystem<'_> {
    /// From the weights, because a factor that is made again may belong to a step of another size.
    fn mean_for(&self, w: Weights) -> StepMean {
        StepMean { half: 1.0 / w.c, ..self.mean }
    }

    fn write(&self, at: StateRef<'_>, w: Weights, form: TangentForm, assembler: &mut Assembler) {
        self.system.assemble_mean(at, self.mean_for(w), w, form, assembler);
    }
}

impl System for MeanSystem<'_> {
    fn n_dof(&self) -> usize {
        self.system.n_dof()
    }

    fn initial_state(&self) -> State {
        self.system.initial_state()
    }

    fn terms(&self) -> &[TermInfo] {
        self.system.terms()
    }

    fn new_forces(&self) -> Forces {
        self.system.new_forces()
    }

    fn evaluate(&self, at: StateRef<'_>, out: &mut Forces) {
        self.system.mean_forces(at, self.mean, out);
    }

    fn inverse_mass(&self) -> &[f64] {
        self.system.inverse_mass()
    }

    fn moved(&self) -> &[u32] {
        self.system.moved()
    }

    fn mass_times(&self, a: &[f64], out: &mut [f64]) {
        self.system.mass_times(a, out);
    }

    fn kinetic_energy(&self, v: &[f64]) -> f64 {
        self.system.kinetic_energy(v)
    }

    fn workers(&self) -> &Workers {
        self.system.workers()
    }

    fn touches(&self) -> Option<&dyn Touches> {
        self.system.touches()
    }

    fn velocity_dependent(&self) -> bool {
        self.system.velocity_dependent()
    }
}

impl TangentSystem for MeanSystem<'_> {
    /// A discrete gradient has no potential.
    fn symmetric(&self) -> bool {
        false
    }

    fn assembler(&self) -> Result<Assembler, PatternError> {
        self.system.mean_assembler()
    }

    fn way_over_unknown(&self) -> f64 {
        2.0
    }

    fn outgrown(&self, assembler: &Assembler) -> bool {
        self.system.outgrown(assembler)
    }

    fn assemble(&self, at: StateRef<'_>, w: Weights, assembler: &mut Assembler) {
        self.write(at, w, TangentForm::EXACT, assembler);
    }

    /// Symmetric too, so that its directions lead downhill: along them the residual falls as that of a potential does.
    fn assemble_convex(&self, at: StateRef<'_>, w: Weights, assembler: &mut Assembler) {
        self.write(at, w, TangentForm { convex: true, symmetric: true }, assembler);
    }

    fn symmetric_assembler(&self) -> Result<Option<Assembler>, PatternError> {
        self.system.symmetric_assembler()
    }

    fn assemble_symmetric(&self, at: StateRef<'_>, w: Weights, convex: bool, assembler: &mut Assembler) {
        self.write(at, w, TangentForm { convex, symmetric: true }, assembler);
    }

    fn rank_ones(&self) -> usize {
        self.system.rank_ones()
    }

    fn mass_parts(&self) -> usize {
        self.system.mass_parts()
    }

    fn kept_parts(&self) -> usize {
        self.system.kept_parts()
    }

    fn with_apparent_mass(&self, at: StateRef<'_>, residual: &mut [f64]) {
        self.system.with_apparent_mass(at, residual);
    }

    fn rank_one(&self, which: usize, at: StateRef<'_>, w: Weights, u: &mut [f64], g: &mut [f64]) {
        self.system.mean_rank_one(which, (at, self.mean), w, u, g);
    }

    fn mean_forces(&self, middle: StateRef<'_>, mean: StepMean, out: &mut Forces) {
        self.system.mean_forces(middle, mean, out);
    }

    fn assemble_mean(
        &self,
        middle: StateRef<'_>,
        mean: StepMean,
        w: Weights,
        form: TangentForm,
        assembler: &mut Assembler,
    ) {
        self.system.assemble_mean(middle, mean, w, form, assembler);
    }

    fn turns_over(&self, from: &[f64], to: &[f64]) -> bool {
        self.system.turns_over(from, to)
    }

    fn nodal_stiffness(&self) -> Vec<f64> {
        self.system.nodal_stiffness()
    }

    fn force_scale(&self, forces: &Forces) -> f64 {
        self.system.force_scale(forces)
    }
}
