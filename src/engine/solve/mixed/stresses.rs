//! The stresses of membranes in the mixed iteration. They act both ways: a wrinkled sheet has the tangent of its law at
//! an iterate. With the stress S(E) of the strain and its tangent D, the next stress is S <- S(E) + D B dx.

use crate::model::spring_state::SheetState;
use nalgebra::{Matrix2, Vector3};

/// The stresses, with their buffers; all `[n_sheets]`.
#[derive(Clone, Debug, Default)]
pub(super) struct Stresses {
    at: Vec<SheetState>,
    /// unknown stresses
    s: Vec<Vector3<f64>>,
    ds: Vec<Vector3<f64>>,
    before: Vec<Vector3<f64>>,
    tangents: Vec<Vector3<f64>>,
}

impl Stresses {
    /// Room for the states of `n` triangles.
    pub(super) fn resize(&mut self, n: usize) -> &mut [SheetState] {
        self.at.resize(n, SheetState::default());
        &mut self.at
    }

    /// Where states are measured.
    pub(super) fn state(&mut self) -> &mut [SheetState] {
        &mut self.at
    }

    /// Makes the stresses of the measured states the first ones.
    pub(super) fn begin(&mut self) {
        self.s.clear();
        self.s.extend(self.at.iter().map(|sheet| sheet.stress));
        self.ds.resize(self.s.len(), Vector3::zeros());
    }

    /// What the matrix has of the stresses, with this share [-] of compression.
    pub(super) fn set_tangents(&mut self, share: f64) -> &[Vector3<f64>] {
        self.tangents.clear();
        self.tangents.extend(self.s.iter().map(|s| with_compression(s, share)));
        &self.tangents
    }

    /// [m^2] Sum of the squared errors of the stresses, as displacements.
    pub(super) fn errors_squared(&self) -> f64 {
        self.s.iter().zip(&self.at).map(|(s, at)| ((s - at.stress) * at.flexibility).norm_squared()).sum()
    }

    /// Adds to forces [N] `[n_dof]` of a residual what the stresses of the strains pull more than these.
    pub(super) fn add_pull(&self, weight: f64, dofs: &mut [f64]) {
        for (s, at) in self.s.iter().zip(&self.at) {
            for (node, b) in at.nodes.iter().zip(&at.by_node) {
                let force = b.transpose() * (s - at.stress) * (weight * at.area);
                let first = 3 * *node as usize;
                dofs[first..first + 3].iter_mut().zip(&force).for_each(|(dof, force)| *dof += force);
            }
        }
    }

    /// Finds the changes of all stresses for displacements of all degrees of freedom [m] `[n_dof]`.
    pub(super) fn follow(&mut self, dofs: &[f64]) {
        for ((ds, s), at) in self.ds.iter_mut().zip(&self.s).zip(&self.at) {
            let moved = |node: u32| Vector3::from_column_slice(&dofs[3 * node as usize..3 * node as usize + 3]);
            let strain = at.nodes.iter().zip(&at.by_node).map(|(&node, b)| b * moved(node)).sum::<Vector3<f64>>();
            *ds = at.stress - s + at.stiffness * strain;
        }
    }

    pub(super) fn remember(&mut self) {
        self.before.clone_from(&self.s);
    }

    /// Takes a share of the changes, from the stresses before.
    pub(super) fn take(&mut self, share: f64) {
        for ((s, before), ds) in self.s.iter_mut().zip(&self.before).zip(&self.ds) {
            *s = before + ds * share;
        }
    }
}

/// A stress with a share [-] of its principal values below 0.
fn with_compression(s: &Vector3<f64>, share: f64) -> Vector3<f64> {
    if share >= 1.0 || s.x >= 0.0 && s.y >= 0.0 && s.x * s.y >= s.z * s.z {
        return *s;
    }
    let eigen = Matrix2::new(s.x, s.z, s.z, s.y).symmetric_eigen();
    let kept = eigen.eigenvalues.map(|value| if value < 0.0 { share * value } else { value });
    let kept = eigen.eigenvectors * Matrix2::from_diagonal(&kept) * eigen.eigenvectors.transpose();
    Vector3::new(kept[(0, 0)], kept[(1, 1)], kept[(0, 1)])
}
