//! A network as a person sees it: back in the user's numbering.

use super::network::{Network, by_node};
use super::sums::motion;
use crate::model::forces::Forces;
use crate::model::picture::Picture;
use crate::model::state::StateRef;
use crate::model::stride::strain_of;

impl Picture for Network {
    fn reference(&self) -> &[[f64; 3]] {
        &self.mesh.nodes
    }

    fn triangles(&self) -> &[[u32; 3]] {
        &self.mesh.triangles
    }

    fn edges(&self) -> &[[u32; 2]] {
        &self.mesh.edges
    }

    fn trace(&self, at: StateRef<'_>, positions: &mut [[f64; 3]], velocities: &mut [[f64; 3]]) {
        for (i, &user) in self.numbering.user.iter().enumerate() {
            positions[user as usize] = by_node(at.x)[i].to_array();
            velocities[user as usize] = by_node(at.v)[i].to_array();
        }
    }

    fn node_forces(&self, _at: StateRef<'_>, forces: &Forces, out: &mut [[f64; 3]]) {
        for (f, &user) in by_node(&forces.total).iter().zip(&self.numbering.user) {
            out[user as usize] = f.to_array();
        }
    }

    fn node_reactions(&self, forces: &Forces, out: &mut [[f64; 3]]) {
        out.fill([0.0; 3]);
        let held = self.fixed.as_flattened().iter().enumerate().filter(|(_, held)| **held);
        for ((dof, _), &reaction) in held.zip(&forces.reactions) {
            out[self.numbering.user[dof / 3] as usize][dof % 3] = reaction;
        }
    }

    fn edge_tension(&self, at: StateRef<'_>, tension: &mut [f64], strain: &mut [f64]) {
        tension.fill(f64::NAN);
        strain.fill(f64::NAN);
        let x = by_node(at.x);
        for batch in &self.springs {
            for (i, &edge) in batch.edges.iter().enumerate() {
                (tension[edge as usize], strain[edge as usize]) = batch.data.tension_and_strain(x, i);
            }
        }
    }

    fn max_strain(&self, at: StateRef<'_>) -> f64 {
        let x = by_node(at.x);
        strain_of(self.springs.iter().map(|b| b.data.largest_stretch(x)).fold(f64::NEG_INFINITY, f64::max))
    }

    fn max_speed(&self, at: StateRef<'_>) -> f64 {
        motion(at.v, &self.mass).largest_square.sqrt()
    }
}
