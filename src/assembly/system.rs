//! The contract between a system and implicit schemes: its tangents, assembled.

use super::{Assembler, PatternError};
use crate::model::forces::Forces;
use crate::model::state::StateRef;
use crate::model::system::{SpringGraph, System, Weights};

/// What an implicit scheme needs besides: the tangent of the forces.
pub trait TangentSystem: System {
    /// Whether K and C are symmetric at every state; decides between Cholesky and LU.
    fn symmetric(&self) -> bool;

    /// Finds the pattern of W and the slot of every element's blocks. Called once, and only by implicit schemes.
    fn assembler(&self) -> Result<Assembler, PatternError>;

    /// Writes W = cm M + cc C + ck K at a state into `assembler`'s values.
    fn assemble(&self, at: StateRef<'_>, weights: Weights, assembler: &mut Assembler);

    /// The same with every element's part made positive semidefinite (the compressive geometric stiffness of springs
    /// dropped), so that a symmetric W with a mass is positive definite and -W^-1 r leads downhill.
    fn assemble_convex(&self, at: StateRef<'_>, weights: Weights, assembler: &mut Assembler) {
        self.assemble(at, weights, assembler);
    }

    /// The pattern of [`TangentSystem::assemble_symmetric`]; `None` for systems too small to keep a factor for.
    ///
    /// # Errors
    /// As [`TangentSystem::assembler`].
    fn symmetric_assembler(&self) -> Result<Option<Assembler>, PatternError> {
        Ok(None)
    }

    /// Writes a symmetric approximation of W: terms with a symmetric tangent as they are (or made positive
    /// semidefinite, if `convex`), the others by
    /// [`ForceTerm::symmetric_tangent`](crate::force::ForceTerm::symmetric_tangent).
    fn assemble_symmetric(&self, at: StateRef<'_>, weights: Weights, convex: bool, assembler: &mut Assembler) {
        let _ = (at, weights, convex, assembler);
    }

    /// Whether a spring points away at `to` [m] from where it pointed at `from` [m]; `true` where nothing is known of
    /// it. Only then can a first guess lie near the mirror image of a step's end.
    fn turns_over(&self, from: &[f64], to: &[f64]) -> bool {
        let _ = (from, to);
        true
    }

    /// [N/m] sum of the stiffnesses that meet at every degree of freedom; scales the rounding floor of a residual
    /// there.
    fn nodal_stiffness(&self) -> Vec<f64>;

    /// [N] the larger of |internal| and |external| forces (Euclidean norms over the free degrees of freedom) in a
    /// force pass; weight counts as external. What a residual is compared with.
    fn force_scale(&self, forces: &Forces) -> f64;
}

/// What a scene can do, for binding a scheme to it.
#[derive(Clone, Copy)]
pub struct Abilities<'a> {
    /// forces
    pub system: &'a (dyn System + 'static),
    /// tangents
    pub tangent: &'a (dyn TangentSystem + 'static),
    /// a spring graph, if the scene has one
    pub graph: Option<&'a (dyn SpringGraph + 'static)>,
}
