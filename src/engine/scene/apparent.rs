//! The air that a canopy takes along: it has momentum, but no weight.
//!
//! ```text
//! V = sum b_i v_i - wind,   b_i = share of a node in the area of the cloth,   m = k rho Vol
//! force on node i: -b_i d(m V)/dt = -b_i (m A + m' V),    A = dV/dt in a steady wind
//! ```
//! Vol is the volume of the canopy, each of its rims closed by a fan about its middle (`enclosure`). That of a point is
//! the volume of Taylor's shape of a flat canopy of its nominal area, pi a r^2/3 with a = D0/2 and r = 0.7627 a, times
//! (A/A_full)^(3/2) with the drag area A.
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
use crate::force::law::stages::Stages;
use crate::force::law::stream::Stream;
use crate::force::{Copies, NodeState};
use crate::model::forces::Tally;
use nalgebra::Vector3;
use std::f64::consts::PI;
use std::sync::Arc;

/// The air that a canopy takes along.
#[derive(Clone)]
pub(super) struct ApparentMass {
    /// [-] nodes of the canopy, and the share of each in its motion; they sum to 1
    pub nodes: Arc<[(u32, f64)]>,
    /// its volume
    pub volume: Volume,
    /// [-] k
    pub factor: f64,
    /// the air around it
    pub stream: Arc<Stream>,
    /// which of the terms the air in this canopy is
    pub term: usize,
}

/// [m] Half of a difference over heights, over which the density of the air is a straight line to nine digits.
const HEIGHT: f64 = 0.1;

/// [-] Volume of Taylor's shape over D0^3: pi 0.7627^2/24.
const TAYLOR: f64 = 0.076_14;

/// The volume of a canopy.
#[derive(Clone)]
pub(super) enum Volume {
    /// that within its cloth and rims
    Cloth(Arc<Enclosure>),
    /// that of a point, by its drag area
    Point {
        /// [m^2] S0
        nominal_area: f64,
        stages: Stages,
    },
}

impl Volume {
    /// [m^3] and [m^3/s]
    fn at(&self, at: NodeState<'_>, origin: Vector3<f64>) -> [f64; 2] {
        match self {
            Volume::Cloth(enclosure) => {
                let [x, v] = [at.x, at.v].map(NodeVectors::Nodes);
                enclosure.volume(x, v, origin)
            }
            Volume::Point { nominal_area, stages } => {
                let full = stages.full_area().unwrap_or(1.0);
                let open = TAYLOR * (4.0 * nominal_area / PI).powf(1.5);
                let share = stages.area_at(at.t) / full;
                let growth = stages.growth_at(at.t) / full;
                [open * share.powf(1.5), 1.5 * open * share.sqrt() * growth]
            }
        }
    }
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
    /// [m^3] Vol
    volume: f64,
    /// [kg/m^3] k rho, and [kg/m^4] its slope over height
    densities: [f64; 2],
}

impl ApparentMass {
    /// That of another run.
    pub(super) fn for_run(&self, copies: &mut Copies) -> Self {
        let volume = match &self.volume {
            Volume::Cloth(_) => self.volume.clone(),
            Volume::Point { nominal_area, stages } => {
                Volume::Point { nominal_area: *nominal_area, stages: stages.for_run(copies) }
            }
        };
        ApparentMass { stream: copies.of(&self.stream), volume, ..self.clone() }
    }

    fn mean(&self, of: &[Vector3<f64>]) -> Vector3<f64> {
        self.nodes.iter().map(|&(node, share)| share * of[node as usize]).sum()
    }

    fn entrained(&self, at: NodeState<'_>) -> Entrained {
        self.entrained_at(at, self.mean(at.x).z)
    }

    /// The same in the air at height `z` [m].
    fn entrained_at(&self, at: NodeState<'_>, z: f64) -> Entrained {
        let origin = self.nodes.first().map_or(Vector3::zeros(), |&(node, _)| at.x[node as usize]);
        let ([volume, rate], absolute) = (self.volume.at(at, origin), self.mean(at.v));
        let air = self.stream.at(at.t, z);
        let [density, slope] = air.density;
        // Turned inside out, a canopy encloses no air.
        let factor = if volume > 0.0 { self.factor } else { 0.0 };
        let growth = factor * (density * rate + slope * absolute.z * volume);
        let (velocity, densities) = (absolute - air.wind[0], [factor * density, factor * slope]);
        Entrained { mass: factor * density * volume, growth, velocity, absolute, volume, densities }
    }

    /// Adds the derivatives of p . (m A + m' V) by positions and velocities to `out`, for a fixed A [m/s^2]; `p` is the
    /// mean of a vector over the nodes.
    fn add_slopes(&self, at: NodeState<'_>, [p, a]: [Vector3<f64>; 2], out: [&mut [Vector3<f64>]; 2]) {
        let [by_x, by_v] = out;
        let found = self.entrained(at);
        let Entrained { growth, velocity, absolute, volume, densities: [density, slope], .. } = found;
        let along = p.dot(&velocity);
        let by_volume = density * p.dot(&a) + slope * absolute.z * along;
        let by_rate = density * along;
        if let Volume::Cloth(enclosure) = &self.volume {
            enclosure.add_rate_gradient([at.x, at.v], [by_volume, by_rate], by_x);
            enclosure.add_rate_gradient([at.x, at.v], [by_rate, 0.0], by_v);
        }
        let z = self.mean(at.x).z;
        let [below, above] = [z - HEIGHT, z + HEIGHT].map(|z| {
            let Entrained { mass, growth, velocity, .. } = self.entrained_at(at, z);
            p.dot(&(mass * a + growth * velocity))
        });
        let by_height = (above - below) / (2.0 * HEIGHT);
        let by_velocity = growth * p + Vector3::new(0.0, 0.0, slope * volume * along);
        for &(node, share) in self.nodes.iter() {
            by_x[node as usize].z += share * by_height;
            by_v[node as usize] += share * by_velocity;
        }
    }

    /// [N] What it does to a canopy whose acceleration is known.
    pub(super) fn force(&self, at: NodeState<'_>, acceleration: Vector3<f64>) -> Vector3<f64> {
        let Entrained { mass, growth, velocity, .. } = self.entrained(at);
        -(mass * acceleration + growth * velocity)
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
            let Entrained { mass, growth, velocity, absolute, .. } = canopy.entrained(at);
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

    /// Overwrites `out` [N] with b (m A + m' V), for accelerations [m/s^2] of the nodes.
    pub(super) fn apparent_force_of(&self, at: NodeState<'_>, acceleration: &[Vector3<f64>], out: &mut [Vector3<f64>]) {
        out.fill(Vector3::zeros());
        for canopy in &self.acting.apparent {
            let force = canopy.force(at, canopy.mean(acceleration));
            canopy.nodes.iter().for_each(|&(node, share)| out[node as usize] -= share * force);
        }
    }

    /// Overwrites `out` with J_x^T p and J_v^T p, for the derivatives J of [`Network::apparent_force_of`] by positions
    /// and velocities at these accelerations [m/s^2].
    pub(super) fn apparent_slopes(
        &self,
        at: NodeState<'_>,
        [acceleration, p]: [&[Vector3<f64>]; 2],
        [by_x, by_v]: [&mut [Vector3<f64>]; 2],
    ) {
        by_x.fill(Vector3::zeros());
        by_v.fill(Vector3::zeros());
        for canopy in &self.acting.apparent {
            let means = [p, acceleration].map(|of| canopy.mean(of));
            canopy.add_slopes(at, means, [&mut *by_x, &mut *by_v]);
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
