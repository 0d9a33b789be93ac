//! The contract between a system and implicit schemes: its tangents, assembled.

use super::{Assembler, PatternError};
use crate::force::TangentForm;
use crate::model::forces::Forces;
use crate::model::spring_state::{SheetState, SpringState, SpringTangent};
use crate::model::state::StateRef;
use crate::model::system::{SpringGraph, StepMean, System, Weights};
use nalgebra::Vector3;

/// The interface that implicit schemes need besides forces: the tangents.
pub trait TangentSystem: System {
    /// Whether K and C are symmetric at every state; decides between Cholesky and LU.
    fn symmetric(&self) -> bool;

    /// [-] The way of a node in a step over the unknown of the step: 2 if that is the way to its middle.
    fn way_over_unknown(&self) -> f64 {
        1.0
    }

    /// Builds the pattern of W and the slots of every element. Called once, by implicit schemes only.
    fn assembler(&self) -> Result<Assembler, PatternError>;

    /// Whether a pattern lacks blocks that the tangents have at the last evaluated state: of pairs that have come near.
    fn outgrown(&self, assembler: &Assembler) -> bool {
        let _ = assembler;
        false
    }

    /// Writes W = cm M + cc C + ck K at a state, but for its rank-one parts, into `assembler`'s values.
    fn assemble(&self, at: StateRef<'_>, weights: Weights, assembler: &mut Assembler);

    /// Number of rank-one parts u g^T of W, which [`TangentSystem::assemble`] leaves out because they couple nodes of
    /// the whole scene.
    fn rank_ones(&self) -> usize {
        0
    }

    /// How many of these, the first ones, belong to the mass.
    fn mass_parts(&self) -> usize {
        0
    }

    /// How many of these, the first ones, are in the symmetric approximation of W, too: those of the mass, or all of
    /// them.
    fn kept_parts(&self) -> usize {
        self.mass_parts()
    }

    /// Replaces a residual M a - f `[n_dof]` at a state, whose forces have a part that depends on all others, by that
    /// of a mass with the [mass parts](TangentSystem::mass_parts) and forces without this part. It has the same
    /// solution, and its tangent is W.
    fn with_apparent_mass(&self, at: StateRef<'_>, residual: &mut [f64]) {
        let _ = (at, residual);
    }

    /// Overwrites `out` [N] `[n_dof]` with what the [mass parts](TangentSystem::mass_parts) and what goes with them
    /// take from the other forces at a state, for accelerations `a` [m/s^2] `[n_dof]`. Its derivatives by the state are
    /// not in the tangent.
    fn apparent_force(&self, at: StateRef<'_>, a: &[f64], out: &mut [f64]) {
        let _ = (at, a);
        out.fill(0.0);
    }

    /// Overwrites u and g `[n_dof]` with one of these parts at a state.
    fn rank_one(&self, which: usize, at: StateRef<'_>, weights: Weights, u: &mut [f64], g: &mut [f64]) {
        let _ = (which, at, weights, u, g);
    }

    /// The same of the tangent of [mean forces](TangentSystem::mean_forces), at the middle of a step.
    fn mean_rank_one(
        &self,
        which: usize,
        (middle, mean): (StateRef<'_>, StepMean),
        weights: Weights,
        u: &mut [f64],
        g: &mut [f64],
    ) {
        let _ = mean;
        self.rank_one(which, middle, weights, u, g);
    }

    /// [`TangentSystem::assemble`] with every element made positive semidefinite: the compressive geometric stiffness
    /// of springs is dropped. A symmetric W with a mass is then positive definite, and -W^-1 r is a descent direction.
    fn assemble_convex(&self, at: StateRef<'_>, weights: Weights, assembler: &mut Assembler) {
        self.assemble(at, weights, assembler);
    }

    /// The pattern of [`TangentSystem::assemble_symmetric`]; `None` for systems too small to reuse a factor.
    ///
    /// # Errors
    /// As [`TangentSystem::assembler`].
    fn symmetric_assembler(&self) -> Result<Option<Assembler>, PatternError> {
        Ok(None)
    }

    /// Writes a symmetric approximation of W: symmetric tangents as they are (or made positive semidefinite if
    /// `convex`), others in their [symmetric form](crate::force::TangentForm).
    fn assemble_symmetric(&self, at: StateRef<'_>, weights: Weights, convex: bool, assembler: &mut Assembler) {
        let _ = (at, weights, convex, assembler);
    }

    /// Overwrites `out` with the forces of a step as an energy-momentum method has them, from the state in its middle.
    /// Elastic forces are discrete gradients of their energies V between both ends (Gonzalez 1996), all others those in
    /// the middle. The work of the elastic forces over the step is exactly the loss of V, less what is dissipated
    /// inside of elements. Their energies are not found.
    fn mean_forces(&self, middle: StateRef<'_>, mean: StepMean, out: &mut Forces);

    /// The pattern of [`TangentSystem::assemble_mean`] in its exact forms.
    ///
    /// # Errors
    /// As [`TangentSystem::assembler`].
    fn mean_assembler(&self) -> Result<Assembler, PatternError> {
        self.assembler()
    }

    /// Writes the tangent of the [mean forces](TangentSystem::mean_forces) f, w.m M - w.k df/dx - w.c df/dv. df/dx is
    /// that of a middle which moves while the start of the step stays. It is symmetric in the symmetric form only,
    /// whose pattern is that of [`TangentSystem::symmetric_assembler`].
    fn assemble_mean(
        &self,
        middle: StateRef<'_>,
        mean: StepMean,
        weights: Weights,
        form: TangentForm,
        assembler: &mut Assembler,
    );

    /// Its springs, if their tensions can be unknowns of Newton's iteration.
    fn mixed(&self) -> Option<&dyn MixedSystem> {
        None
    }

    /// Whether a spring turns by more than 90 degrees between the positions `from` and `to` [m] `[n_dof]`; `true` if
    /// unknown. Only then can a first guess lie near the mirror image of the solution.
    fn turns_over(&self, from: &[f64], to: &[f64]) -> bool {
        let _ = (from, to);
        true
    }

    /// [N/m] Sum of the stiffnesses at every degree of freedom `[n_dof]`; scales the rounding floor of its residual.
    fn nodal_stiffness(&self) -> Vec<f64>;

    /// [N] The larger of |internal| and |external| forces (Euclidean norms over the free degrees of freedom); weight is
    /// external. The scale of residuals.
    fn force_scale(&self, forces: &Forces) -> f64;
}

/// The springs and membranes of a system whose tensions and stresses are unknowns of Newton's mixed iteration
/// (`solve/mixed`), with the matrix of that iteration. Its pattern is that of [`TangentSystem::assemble`] or
/// [`TangentSystem::assemble_symmetric`].
pub trait MixedSystem {
    /// Number of springs.
    fn springs(&self) -> usize;

    /// Number of membrane triangles.
    fn sheets(&self) -> usize;

    /// Writes all springs in a state to `out` `[n_springs]`. `cv` [1/s] is dv/dx of the step.
    fn measure(&self, at: StateRef<'_>, cv: f64, out: &mut [SpringState]);

    /// Writes all membrane triangles in a state to `out` `[n_sheets]`.
    fn measure_sheets(&self, at: StateRef<'_>, cv: f64, out: &mut [SheetState]);

    /// Writes W at a state, with springs of given tensions and stiffnesses and membranes of given stresses, into
    /// `assembler`'s values.
    fn assemble_mixed(&self, at: StateRef<'_>, weights: Weights, form: MixedForm<'_>, assembler: &mut Assembler);
}

/// What the matrix of the mixed iteration has.
#[derive(Clone, Copy, Debug)]
pub struct MixedForm<'a> {
    /// its springs `[n_springs]`
    pub springs: &'a [SpringTangent],
    /// stresses of its membrane triangles `[n_sheets]`; empty if they are those of their strains
    pub sheets: &'a [Vector3<f64>],
    /// whether other forces leave out the part that makes K indefinite
    pub convex: bool,
    /// whether springs and membranes do, too, so that W is positive definite
    pub definite: bool,
    /// whether other forces are in their symmetric form
    pub symmetric: bool,
}

/// The interfaces of a scene that a scheme is bound to.
#[derive(Clone, Copy)]
pub struct SceneInterfaces<'a> {
    /// forces
    pub system: &'a (dyn System + 'static),
    /// tangents
    pub tangent: &'a (dyn TangentSystem + 'static),
    /// a spring graph, if the scene has one
    pub graph: Option<&'a (dyn SpringGraph + 'static)>,
}
