//! The air that a canopy takes along: it has momentum, but no weight.
//!
//! ```text
//! V = sum b_i v_i - wind,   b_i = share of a node in the area of the cloth,   m = k rho Vol
//! force on node i: -b_i d(m V)/dt = -b_i (m A + m' V),    A = dV/dt in a steady wind
//! ```
//! Vol is the volume of the canopy, each of its rims closed by a fan about its middle (`enclosure`).
//! The masses of the nodes stay what they are: with f, the forces of everything else,
//! ```text
//! A = sum b_i (f_i - b_i (m A + m' V))/m_i,     so     A = (a - m' V s)/(1 + m s)
//! a = sum b_i f_i/m_i,   s = sum b_i^2/m_i
//! ```
//! Its work is that of an external force: -d(m V^2/2) - m' V^2/2, what growing takes included. Implicit schemes solve
//! (M + m b b^T) a = f - b m' V instead, with the same solution.

use super::network::{Network, by_node};
use crate::force::kernel::element_block::NodeVectors;
use crate::force::law::enclosure::Enclosure;
use crate::force::law::stream::Stream;
use crate::force::{Copies, NodeState};
use crate::model::forces::Tally;
use nalgebra::Vector3;
use std::sync::Arc;

/// The air that a canopy takes along.
#[derive(Clone)]
pub(super) struct ApparentMass {
    /// [-] nodes of the canopy, and the share of each in its motion; they sum to 1
    pub nodes: Arc<[(u32, f64)]>,
    /// its cloth and rims
    pub enclosure: Arc<Enclosure>,
    /// [-] k
    pub factor: f64,
    /// the air around it
    pub stream: Arc<Stream>,
    /// which of the terms the air in this canopy is
    pub term: usize,
}

/// That air in a state.
struct Entrained {
    /// [kg] m
    mass: f64,
    /// [kg/s] m'
    growth: f64,
    /// [m/s] V
    velocity: Vector3<f64>,
    /// [m/s] V and the wind
    absolute: Vector3<f64>,
}

impl ApparentMass {
    /// That of another run.
    pub(super) fn for_run(&self, copies: &mut Copies) -> Self {
        ApparentMass { stream: copies.of(&self.stream), ..self.clone() }
    }

    fn mean(&self, of: &[Vector3<f64>]) -> Vector3<f64> {
        self.nodes.iter().map(|&(node, share)| share * of[node as usize]).sum()
    }

    fn entrained(&self, at: NodeState<'_>) -> Entrained {
        let origin = self.nodes.first().map_or(Vector3::zeros(), |&(node, _)| at.x[node as usize]);
        let [x, v] = [at.x, at.v].map(NodeVectors::Nodes);
        let ([volume, rate], absolute) = (self.enclosure.volume(x, v, origin), self.mean(at.v));
        let air = self.stream.at(at.t, self.mean(at.x).z);
        let [density, slope] = air.density;
        // Turned inside out, a canopy encloses no air.
        let factor = if volume > 0.0 { self.factor } else { 0.0 };
        let growth = factor * (density * rate + slope * absolute.z * volume);
        Entrained { mass: factor * density * volume, growth, velocity: absolute - air.wind[0], absolute }
    }

    /// sum b_i^2/m_i [1/kg], along each axis.
    fn mobility(&self, inverse_mass: &[Vector3<f64>]) -> Vector3<f64> {
        self.nodes.iter().map(|&(node, share)| share * share * inverse_mass[node as usize]).sum()
    }

    /// sum b_i f_i/m_i, along each axis.
    fn acceleration(&self, f: &[Vector3<f64>], inverse_mass: &[Vector3<f64>]) -> Vector3<f64> {
        let parts = self.nodes.iter().map(|&(node, share)| {
            let i = node as usize;
            share * f[i].component_mul(&inverse_mass[i])
        });
        parts.sum()
    }
}

impl Network {
    /// Adds what the air that canopies take along does to them: to all forces and the external ones [N] `[n_nodes]`,
    /// and to the powers of the terms.
    pub(super) fn add_apparent(&self, at: NodeState<'_>, sums: [&mut [Vector3<f64>]; 2], tallies: &mut [Tally]) {
        let [total, external] = sums;
        let inverse_mass = by_node(&self.phase().inverse_mass);
        for canopy in &self.acting.apparent {
            let Entrained { mass, growth, velocity, absolute } = canopy.entrained(at);
            let (a, s) = (canopy.acceleration(total, inverse_mass), canopy.mobility(inverse_mass));
            let lost = growth * velocity;
            let accelerated = (a - lost.component_mul(&s)).component_div(&(mass * s).add_scalar(1.0));
            let force = -(mass * accelerated + lost);
            for &(node, share) in canopy.nodes.iter() {
                total[node as usize] += share * force;
                external[node as usize] += share * force;
            }
            if let Some(tally) = self.tally_of(canopy.term).and_then(|tally| tallies.get_mut(tally)) {
                tally.power += force.dot(&absolute);
            }
        }
    }

    /// Replaces a residual M a - f of forces that have the apparent masses in them by (M + m b b^T) a - f, with the
    /// forces of everything else and b m' V.
    pub(super) fn with_apparent(&self, at: NodeState<'_>, residual: &mut [Vector3<f64>]) {
        let inverse_mass = by_node(&self.phase().inverse_mass);
        for canopy in &self.acting.apparent {
            let added = canopy.entrained(at).mass * canopy.acceleration(residual, inverse_mass);
            canopy.nodes.iter().for_each(|&(node, share)| residual[node as usize] += share * added);
        }
    }

    /// A part m b b^T of the mass, along one axis: overwrites u with m b, and g with b.
    pub(super) fn apparent_part(&self, which: usize, at: NodeState<'_>, [u, g]: [&mut [f64]; 2]) {
        u.fill(0.0);
        g.fill(0.0);
        let Some(canopy) = self.acting.apparent.get(which / 3) else { return };
        let mass = canopy.entrained(at).mass;
        for &(node, share) in canopy.nodes.iter() {
            let dof = 3 * node as usize + which % 3;
            (u[dof], g[dof]) = (mass * share, share);
        }
    }
}
