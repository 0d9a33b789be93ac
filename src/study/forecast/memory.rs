//! The memory of a run, from counted bytes on top of what this process holds with the same scene built.

use super::cost::TangentCost;
use super::output::OutputCost;
use crate::analysis::critical::CostLimits;
use crate::analysis::modes::search_numbers;
use crate::integrate::registry::Family;
use crate::process;
use crate::scene::Scene;

/// [byte] the program itself and the libraries it uses.
const PROGRAM: u64 = 7 << 20;
/// [byte] a node with its springs and triangles, in the scene and in its picture.
const NODE: u64 = 700;
/// Vectors of unknowns that corrections of a kept factor take.
const KEPT: u64 = 24;
/// Vectors over all degrees of freedom that the search for a critical step works with, besides those that it keeps.
const SEARCH: u64 = 10;
/// [byte] of an LU an entry of W, for every doubling of the unknowns beyond 2^8; columns are ordered for the worst
/// pivots. Measured on annuli of 703 to 40,000 nodes.
const LU_ENTRY: f64 = 40.0;

/// What the process held before any trial.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Baseline {
    /// [byte] resident with the scene built
    pub resident: Option<u64>,
    /// [byte] most until then
    pub peak: Option<u64>,
}

impl Baseline {
    /// Of this process, now.
    pub fn now() -> Self {
        Baseline { resident: process::resident_bytes(), peak: process::peak_memory_bytes() }
    }
}

/// What the memory of a run depends on.
#[derive(Clone, Copy)]
pub struct MemorySpec<'a> {
    /// the scene
    pub scene: &'a dyn Scene,
    /// what the process held
    pub baseline: Baseline,
    /// what is written
    pub output: &'a OutputCost,
    /// the tangent, if it can be made
    pub tangent: Option<&'a TangentCost>,
}

/// A run by its needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Needs {
    /// what a step needs
    pub family: Family,
    /// whether steps are adaptive
    pub adaptive: bool,
    /// whether `solve` looks for the critical step at its start
    pub searches: bool,
}

impl MemorySpec<'_> {
    /// [byte] Largest resident memory of `canopy-fem solve`.
    pub fn predict(&self, needs: Needs) -> u64 {
        let base = self.baseline.resident.unwrap_or(PROGRAM + NODE * self.scene.reference().len() as u64);
        let peak = self.baseline.peak.unwrap_or(0);
        (base + self.vectors(needs) + self.files() + self.matrix(needs).max(self.search(needs))).max(peak)
    }

    /// [byte] States, forces and what a scheme works with.
    fn vectors(&self, needs: Needs) -> u64 {
        let vector = 8 * self.scene.n_dof() as u64;
        let forces = self.scene.new_forces();
        let one = |v: &[f64]| 8 * v.len() as u64;
        let point = 2 * vector + one(&forces.total) + one(&forces.external) + one(&forces.dissipative);
        // Two ends of a step and a frame between them; a stage of the scheme; the whole step and its second half.
        let points = 4 + if needs.adaptive { 2 } else { 0 };
        points * point + vector * if needs.family == Family::Implicit { 14 } else { 8 }
    }

    /// [byte] Frames on their way to the disk, as many as there may be, and the file being written.
    fn files(&self) -> u64 {
        self.output.waiting_bytes + self.output.frame_bytes
    }

    /// [byte] W, what finds its slots, and its factor.
    fn matrix(&self, needs: Needs) -> u64 {
        let Some(tangent) = self.tangent.filter(|_| needs.family == Family::Implicit) else { return 0 };
        let (entries, blocks) = (tangent.matrix_nonzeros as u64, tangent.blocks as u64);
        match tangent.factor_nonzeros.or((tangent.linear_solver == "cg").then_some(0)) {
            // Values and rows of W (again in blocks, for conjugate gradients), slots of the blocks, the factor and a
            // front of it, and what the last steps of an iteration take.
            Some(factor) => {
                16 * entries + 4 * entries + 24 * blocks + 9 * factor as u64 + 8 * KEPT * tangent.unknowns as u64
            }
            None => {
                let doublings = ((tangent.unknowns.max(1) as f64).log2() - 8.0).max(1.0);
                (LU_ENTRY * doublings * entries as f64) as u64
            }
        }
    }

    /// [byte] The search for the critical step before a run.
    fn search(&self, needs: Needs) -> u64 {
        if !needs.searches {
            return 0;
        }
        let n = self.scene.n_dof();
        let factor = self.tangent.and_then(|t| t.factor_nonzeros).filter(|_| n <= CostLimits::START.factorise);
        let kept = search_numbers(n, self.scene.velocity_dependent()) as u64;
        8 * (SEARCH * n as u64 + kept) + 12 * factor.unwrap_or(0) as u64
    }
}
