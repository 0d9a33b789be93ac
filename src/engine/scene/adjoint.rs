//! What an adjoint run needs of a scene: products with transposed tangents, and what single springs and masses do.

use super::acting::SpringBatch;
use super::network::{Network, by_node, node_state};
use crate::force::law::damped_springs::scaled_tension;
use crate::force::law::spring::SpringData;
use crate::model::abilities::SpringPlace;
use crate::model::state::StateRef;
use crate::model::system::Weights;
use nalgebra::Vector3;

/// A scene whose nodes and springs are parameters one by one. Vectors are `[n_dof]` in the scene's numbering, held
/// degrees of freedom included; springs are in the order of [`Adjoint::springs`].
pub trait Adjoint {
    /// y = (c C + k K)^T p at a state, matrix-free. With it, the derivative of p . f by positions is -K^T p, and by
    /// velocities -C^T p.
    fn tangent_transposed_times(&self, at: StateRef<'_>, w: Weights, p: &[f64], y: &mut [f64]);

    /// Overwrites `out` with J_x^T p and J_v^T p, where J are the derivatives, by positions and velocities, of
    /// [`TangentSystem::apparent_force`](crate::assembly::TangentSystem::apparent_force) at accelerations `a` [m/s^2].
    fn apparent_transposed_times(&self, at: StateRef<'_>, a: &[f64], p: &[f64], out: [&mut [f64]; 2]);

    /// All springs, those that are cut included.
    fn springs(&self) -> Vec<SpringPlace>;

    /// First degree of freedom of the two ends of every spring.
    fn spring_ends(&self) -> Vec<[u32; 2]>;

    /// [N/m] and [m] Stiffness and rest length of every spring, without a factor of all rest lengths over time.
    fn spring_values(&self) -> Vec<[f64; 2]>;

    /// Writes the tension [N] of every spring with its axial dashpot, where stiffness and rest length are these factors
    /// times its own; 0 where it is cut.
    fn scaled_tensions(&self, at: StateRef<'_>, factors: [f64; 2], out: &mut [f64]);

    /// Writes the force on every degree of freedom over the mass there [m/s^2], of all forces that are proportional to
    /// it: weight, an accelerated base, damping by mass.
    fn force_per_mass(&self, at: StateRef<'_>, out: &mut [f64]);

    /// First degree of freedom of a node in the user's numbering.
    fn first_dof(&self, node: u32) -> usize;
}

impl Adjoint for Network {
    fn tangent_transposed_times(&self, at: StateRef<'_>, w: Weights, p: &[f64], y: &mut [f64]) {
        // Parts of the mass have none of these weights.
        self.product::<true>(at, Weights { m: 0.0, ..w }, p, y);
    }

    fn apparent_transposed_times(&self, at: StateRef<'_>, a: &[f64], p: &[f64], [by_x, by_v]: [&mut [f64]; 2]) {
        let out = [bytemuck::cast_slice_mut(by_x), bytemuck::cast_slice_mut(by_v)];
        self.apparent_slopes(node_state(at), [by_node(a), by_node(p)], out);
    }

    fn springs(&self) -> Vec<SpringPlace> {
        let batches = self.acting.springs.iter().zip(0_u32..);
        batches
            .flat_map(|(springs, batch)| {
                (0..springs.edges.len() as u32).map(move |number| SpringPlace { batch, number })
            })
            .collect()
    }

    fn spring_ends(&self) -> Vec<[u32; 2]> {
        let all = self.acting.springs.iter().flat_map(|batch| batch.data.nodes.iter());
        all.map(|ends| ends.map(|node| 3 * node)).collect()
    }

    fn spring_values(&self) -> Vec<[f64; 2]> {
        let of = |batch: &SpringBatch| {
            let SpringData { stiffness, rest_length, .. } = &batch.data;
            (0..batch.edges.len()).map(|i| [stiffness.at(i), rest_length[i]]).collect::<Vec<_>>()
        };
        self.acting.springs.iter().flat_map(of).collect()
    }

    fn scaled_tensions(&self, at: StateRef<'_>, factors: [f64; 2], out: &mut [f64]) {
        let mut rest = out;
        for batch in &self.acting.springs {
            let (own, others) = rest.split_at_mut(batch.edges.len());
            rest = others;
            for (i, tension) in own.iter_mut().enumerate() {
                if batch.cut.is_cut(i) {
                    *tension = 0.0;
                    continue;
                }
                let axial = batch.axial.then(|| batch.dashpot.at(i));
                *tension = scaled_tension(&batch.data, node_state(at), (i, axial), factors);
            }
        }
    }

    fn force_per_mass(&self, at: StateRef<'_>, out: &mut [f64]) {
        out.fill(0.0);
        let mut force = vec![Vector3::zeros(); self.built.mass.len()];
        for number in (0..self.acting.terms.len()).filter(|&number| self.acting.terms[number].by_mass()) {
            let Some(part) = self.tally_of(number) else { continue };
            self.pass_of(part, node_state(at), &mut force);
            for ((out, force), mass) in out.chunks_exact_mut(3).zip(&force).zip(self.built.weighed.iter()) {
                out.iter_mut().zip(force.iter()).for_each(|(out, force)| *out += force / mass);
            }
        }
    }

    fn first_dof(&self, node: u32) -> usize {
        3 * self.built.numbering.internal[node as usize] as usize
    }
}
