//! The proof that no mode is faster than a bound: m M + c C + k K is positive definite if and only if Cholesky finds
//! only positive pivots (Sylvester's law of inertia). Its rounding, n 1e-16 of the largest eigenvalue, is far below the
//! margins used.

use crate::assembly::Assembler;
use crate::model::state::StateRef;
use crate::model::system::Weights;
use crate::model::workers::ALONE;
use crate::scene::Scene;
use crate::solve::{Inertia, LinearChoice, LinearSolver, solver_for};

/// Matrix and factorisation of a symmetric scene.
pub(super) struct Certifier {
    assembler: Assembler,
    /// `None` for a single unknown
    solver: Option<Box<dyn LinearSolver>>,
}

impl Certifier {
    /// `None` for non-symmetric scenes.
    pub(super) fn of(scene: &dyn Scene) -> Option<Self> {
        if !scene.symmetric() {
            return None;
        }
        let assembler = scene.assembler().ok()?;
        let single = assembler.pattern.n() == 1;
        let solver = if single {
            None
        } else {
            Some(solver_for(assembler.pattern.clone(), LinearChoice::Cholesky, &ALONE).ok()?)
        };
        Some(Certifier { assembler, solver })
    }

    /// Whether m M + c C + k K is proved positive definite.
    pub(super) fn definite(&mut self, scene: &dyn Scene, at: StateRef<'_>, w: Weights) -> bool {
        scene.assemble(at, w, &mut self.assembler);
        match &mut self.solver {
            None => self.assembler.values().first().is_some_and(|&value| value > 0.0 && value.is_finite()),
            Some(solver) => matches!(solver.factor_definite(self.assembler.values()), Ok(Inertia::Definite)),
        }
    }
}
