//! The air along the axis of a canopy.
//!
//! ```text
//! a = unit vector from the apex to the confluence,     L = their distance,      z = height of the carrier
//! u = mean carrier velocity - wind(z),      V = a . u,      q = rho(z) V|V|/2
//! dV/dv_carrier = a/n,     dV/dz_carrier = -a . dw/dz/n,     dV/dx_confluence = (I - a a^T) u/(L n_c)
//! ```
//! and the opposite at the apex. The carrier is the skirt, and the confluence where a balance of the air fills the
//! canopy: the skirt's own speed swings then.

use crate::force::kernel::element_block::NodeVectors;
use crate::force::law::stream::{AirState, Stream};
use crate::model::system::Weights;
use nalgebra::Vector3;
use std::sync::Arc;

/// What sets the axis of a canopy and its air speed.
#[derive(Clone, Debug)]
pub struct CanopyAxis {
    /// nodes of the skirt
    pub skirt: Vec<u32>,
    /// nodes around the apex
    pub apex: Vec<u32>,
    /// nodes where the lines meet
    pub confluence: Vec<u32>,
    /// nodes whose velocity and height are meant by u and z: those of the confluence, or of the skirt
    pub carrier: Vec<u32>,
    /// the air around the canopy
    pub stream: Arc<Stream>,
}

/// The air along the axis.
#[derive(Clone, Copy, Debug)]
pub struct AxialFlow {
    /// unit vector from the apex to the confluence; 0 where they coincide
    pub axis: Vector3<f64>,
    /// [m] distance from the apex to the confluence
    pub length: f64,
    /// [m/s] u
    pub velocity: Vector3<f64>,
    /// [m/s] V
    pub speed: f64,
    /// [Pa] q, of the sign of V
    pub dynamic_pressure: f64,
    /// the air at z
    pub air: AirState,
}

impl CanopyAxis {
    /// The air along the axis at time `t` [s], positions `x` [m] and velocities `v` [m/s].
    pub fn flow(&self, t: f64, x: NodeVectors<'_>, v: NodeVectors<'_>) -> AxialFlow {
        let along = x.mean(&self.confluence) - x.mean(&self.apex);
        let length = along.norm();
        let axis = if length > 0.0 { along / length } else { Vector3::zeros() };
        let air = self.stream.at(t, x.mean(&self.carrier).z);
        let velocity = v.mean(&self.carrier) - air.wind[0];
        let speed = axis.dot(&velocity);
        AxialFlow { axis, length, velocity, speed, dynamic_pressure: 0.5 * air.density[0] * speed * speed.abs(), air }
    }

    /// Adds c dV/dv + k dV/dx.
    pub(super) fn add_speed_gradient(&self, flow: AxialFlow, w: Weights, g: &mut [Vector3<f64>]) {
        let AxialFlow { axis, velocity, air, .. } = flow;
        let [_, shear] = air.wind;
        spread(&self.carrier, w.c * axis - w.k * axis.dot(&shear) * Vector3::z(), g);
        self.add_turn(flow, w.k * velocity, g);
    }

    /// The same for one component of wind + V a.
    pub(super) fn add_along_gradient(&self, i: usize, flow: AxialFlow, w: Weights, g: &mut [Vector3<f64>]) {
        let AxialFlow { axis, speed, air, .. } = flow;
        self.add_speed_gradient(flow, Weights { c: w.c * axis[i], k: w.k * axis[i], ..w }, g);
        spread(&self.carrier, w.k * air.wind[1][i] * Vector3::z(), g);
        let mut component = Vector3::zeros();
        component[i] = w.k * speed;
        self.add_turn(flow, component, g);
    }

    /// Adds `by` drho/dx.
    pub(super) fn add_density_gradient(&self, flow: AxialFlow, by: f64, g: &mut [Vector3<f64>]) {
        spread(&self.carrier, Vector3::z() * (by * flow.air.density[1]), g);
    }

    /// Adds the gradient of a product of the axis and a given vector.
    pub(super) fn add_turn(&self, flow: AxialFlow, by: Vector3<f64>, g: &mut [Vector3<f64>]) {
        let AxialFlow { axis, length, .. } = flow;
        if length > 0.0 {
            let turn = (by - axis.dot(&by) * axis) / length;
            spread(&self.confluence, turn, g);
            spread(&self.apex, -turn, g);
        }
    }
}

/// Adds `whole` times the gradient of a mean over some nodes.
fn spread(nodes: &[u32], whole: Vector3<f64>, g: &mut [Vector3<f64>]) {
    let share = whole / nodes.len() as f64;
    nodes.iter().for_each(|&node| g[node as usize] += share);
}
