//! The supports of the parts of a net.

use super::DiagnosisInput;
use crate::mesh::components::components;

impl DiagnosisInput<'_> {
    /// Text for a degree of freedom whose part of the net has no support.
    pub(super) fn unheld(&self, dof: usize) -> Option<String> {
        let n = self.scene.reference().len();
        if 3 * n != self.scene.n_dof() {
            return None;
        }
        let node = self.scene.name_of(dof).0 as usize;
        let part = components(n, self.scene.edges().iter().copied());
        let members = (0..n).filter(|&i| part[i] == part[node]);
        let held = self.held();
        let free = members.clone().all(|i| !held.get(i).copied().unwrap_or(true));
        free.then(|| format!("nothing holds the {} nodes connected to node {node}", members.count()))
    }

    /// Whether a node (user's number) is held in any direction.
    fn held(&self) -> Vec<bool> {
        let mut held = vec![false; self.scene.reference().len()];
        for (dof, inverse) in self.scene.inverse_mass().iter().enumerate() {
            if let Some(held) = held.get_mut(self.scene.name_of(dof).0 as usize) {
                *held |= *inverse == 0.0;
            }
        }
        held
    }
}
