//! The air in a canopy: one follower pressure on its triangles, by the air speed along its axis.
//!
//! ```text
//! a = unit vector from the apex to the confluence,      u = mean skirt velocity - wind there,      V = a . u
//! q = rho V |V|/2,      f_i = q dCp S/3,      power = f . v
//! ```
//! V couples all nodes of the skirt, the apex and the confluence with all nodes of the canopy. The tangent is local but
//! for one rank:
//! ```text
//! -df/dx = -q dCp dS/dx/3 - (f/q) (dq/dx)^T,      -df/dv = -(f/q) (dq/dv)^T
//! dq/dv_skirt = rho |V| a/n
//! dq/dx_confluence = rho |V| (I - a a^T) u/(L n),      the opposite at the apex
//! dq/dz_skirt = (rho' V |V|/2 - rho |V| a . dw/dz)/n
//! ```
//! While a canopy fills, its drag area A(t) is given. Then the pressure is p dCp with
//! ```text
//! p = q A/G,   G = -sum dCp S . a,      dp/dx = (A/G) dq/dx - (p/G) dG/dx,      dG/dx_j = -sum dCp (dS/dx_j)^T a
//! ```
//! and dG by the axis -(I - a a^T) (sum dCp S)/(L n) at the confluence, the opposite at the apex.
//!
//! The speed of cloth relative to the skirt changes nothing: the law has no damping of breathing of its own.

use crate::force::kernel::batch::{BufferReads, Records, SceneNumber};
use crate::force::kernel::element_block::NodeVectors;
use crate::force::kernel::faces::{FaceBatch, FaceKernel, Faces};
use crate::force::kernel::triangle_pairs::{PressureForce, PressureLaw};
use crate::force::law::stream::{AirState, Stream};
use crate::force::law::triangle::{AreaVector, THIRD};
use crate::force::{ForceTerm, NodeState, RankOne, TangentForm, TangentSink};
use crate::model::forces::{Role, Tally};
use crate::model::quad::Real;
use crate::model::spec::FillingSpec;
use crate::model::system::{TermInfo, Weights};
use nalgebra::Vector3;
use std::sync::Arc;

/// The air in a canopy.
pub type Canopy = FaceBatch<CanopyData>;

/// Plain data of a canopy.
#[derive(Clone, Debug)]
pub struct CanopyData {
    /// vertices, right-handed about the direction from inside to outside
    pub triangles: Arc<[[u32; 3]]>,
    /// [-] dCp by triangle
    pub pressure_coefficient: Arc<[f64]>,
    /// nodes of the skirt
    pub skirt: Vec<u32>,
    /// nodes around the apex
    pub apex: Vec<u32>,
    /// nodes where the lines meet
    pub confluence: Vec<u32>,
    /// the air around it
    pub stream: Arc<Stream>,
    /// drag area over time
    pub filling: Option<FillingSpec>,
}

/// [m^2] The drag area at time `t` [s].
pub fn drag_area(FillingSpec { drag_area, start, duration, exponent }: FillingSpec, t: f64) -> f64 {
    drag_area * ((t - start) / duration).clamp(0.0, 1.0).powf(exponent)
}

/// The air along the axis.
#[derive(Clone, Copy, Debug)]
pub struct AxialFlow {
    /// unit vector from the apex to the confluence; 0 where they coincide
    pub axis: Vector3<f64>,
    /// [m] distance from the apex to the confluence
    pub length: f64,
    /// [m/s] velocity of the skirt relative to the air
    pub velocity: Vector3<f64>,
    /// [m/s] V
    pub speed: f64,
    /// [Pa] q, of the sign of V
    pub dynamic_pressure: f64,
    air: AirState,
}

impl CanopyData {
    /// The air along the axis at time `t` [s], positions `x` [m] and velocities `v` [m/s].
    pub fn flow(&self, t: f64, x: NodeVectors<'_>, v: NodeVectors<'_>) -> AxialFlow {
        let along = x.mean(&self.confluence) - x.mean(&self.apex);
        let length = along.norm();
        let axis = if length > 0.0 { along / length } else { Vector3::zeros() };
        let air = self.stream.at(t, x.mean(&self.skirt).z);
        let velocity = v.mean(&self.skirt) - air.wind[0];
        let speed = axis.dot(&velocity);
        AxialFlow { axis, length, velocity, speed, dynamic_pressure: 0.5 * air.density[0] * speed * speed.abs(), air }
    }

    /// [m^2] The sum of dCp S.
    fn opening(&self, x: NodeVectors<'_>) -> Vector3<f64> {
        let areas = self.triangles.iter().zip(self.pressure_coefficient.iter()).map(|(&[a, b, c], dcp)| {
            let from = x.at(a);
            0.5 * dcp * (x.at(b) - from).cross(&(x.at(c) - from))
        });
        areas.sum()
    }
}

impl SceneNumber for CanopyData {
    /// [Pa] the pressure at dCp = 1
    fn find(&self, t: f64, x: NodeVectors<'_>, v: NodeVectors<'_>) -> f64 {
        let AxialFlow { axis, dynamic_pressure, .. } = self.flow(t, x, v);
        match self.filling {
            None => dynamic_pressure,
            Some(filling) => dynamic_pressure * drag_area(filling, t) / -self.opening(x).dot(&axis),
        }
    }
}

impl FaceKernel for CanopyData {
    const READS: BufferReads = BufferReads { x: true, v: true };

    fn elements(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    fn factors(&self) -> Option<&[f64]> {
        Some(&self.pressure_coefficient)
    }

    fn scene_number(&self) -> Option<&dyn SceneNumber> {
        Some(self)
    }

    fn add(&self, block: Faces<'_>, f: &mut Records) -> Tally {
        let law = CanopyLaw { pressure: block.scene_number };
        Tally { energy: 0.0, power: block.add_pressure(&law, f) }
    }
}

struct CanopyLaw {
    /// [Pa] at dCp = 1
    pressure: f64,
}

impl PressureLaw for CanopyLaw {
    const FACTORS: bool = true;

    #[inline(always)]
    fn pressure_force<R: Real>(&self, s: [R; 3], v: [R; 3]) -> PressureForce<R> {
        let share = s[0].all(THIRD * self.pressure);
        PressureForce { share, amount: share * (s[0] * v[0] + s[1] * v[1] + s[2] * v[2]) }
    }
}

impl ForceTerm for Canopy {
    fn parts(&self) -> &[TermInfo] {
        const INFO: TermInfo = TermInfo {
            velocity_dependent: true,
            follower: true,
            on_triangles: true,
            ..TermInfo::of("canopy air", Role::External)
        };
        &[INFO]
    }

    fn symmetric(&self) -> bool {
        false
    }

    fn tangent(&self, at: NodeState<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink) {
        let data = self.kernel();
        let q = data.find(at.t, NodeVectors::Nodes(at.x), NodeVectors::Nodes(at.v));
        for (&nodes, dcp) in data.triangles.iter().zip(data.pressure_coefficient.iter()) {
            let area = AreaVector::new(at.x, nodes);
            // There is no symmetric form, as for any follower pressure.
            let k = if form.symmetric { 0.0 } else { w.k };
            let row = [0, 1, 2].map(|j| area.derivative(j) * (-k * q * dcp / 3.0));
            sink.triangle(nodes, &[row; 3]);
        }
    }

    fn rank_one(&self, at: NodeState<'_>, w: Weights, RankOne { u, g }: RankOne<'_>) {
        let data = self.kernel();
        u.fill(Vector3::zeros());
        g.fill(Vector3::zeros());
        for (&nodes, dcp) in data.triangles.iter().zip(data.pressure_coefficient.iter()) {
            let force = AreaVector::new(at.x, nodes).s * (dcp / 3.0);
            nodes.into_iter().for_each(|node| u[node as usize] -= force);
        }
        let AxialFlow { axis, length, velocity, speed, air, dynamic_pressure } =
            data.flow(at.t, NodeVectors::Nodes(at.x), NodeVectors::Nodes(at.v));
        let [density, thinning] = air.density;
        let (slope, [_, shear]) = (density * speed.abs(), air.wind);
        let turn = if length > 0.0 { (velocity - speed * axis) * (slope / length) } else { Vector3::zeros() };
        let rise = 0.5 * thinning * speed * speed.abs() - slope * axis.dot(&shear);
        let mut at_skirt = w.c * slope * axis + w.k * Vector3::new(0.0, 0.0, rise);
        let mut at_confluence = w.k * turn;
        if let Some(filling) = data.filling {
            let opening = data.opening(NodeVectors::Nodes(at.x));
            let share = drag_area(filling, at.t) / -opening.dot(&axis);
            (at_skirt, at_confluence) = (share * at_skirt, share * at_confluence);
            // p/G, by which dG counts.
            let closing = share * dynamic_pressure / -opening.dot(&axis) * w.k;
            if length > 0.0 {
                at_confluence += closing / length * (opening - opening.dot(&axis) * axis);
            }
            for (&nodes, dcp) in data.triangles.iter().zip(data.pressure_coefficient.iter()) {
                let area = AreaVector::new(at.x, nodes);
                for (j, node) in nodes.into_iter().enumerate() {
                    g[node as usize] += closing * *dcp * (area.derivative(j).transpose() * axis);
                }
            }
        }
        for (nodes, whole) in [(&data.skirt, at_skirt), (&data.confluence, at_confluence), (&data.apex, -at_confluence)]
        {
            let share = whole / nodes.len() as f64;
            nodes.iter().for_each(|&node| g[node as usize] += share);
        }
    }
}
