//! The air on porous cloth: a pressure jump that depends on the velocity through the cloth (thesis Eq. 6 with its
//! sign restored; Ergun 1952; Darcy-Forchheimer).
//!
//! ```text
//! u = wind - mean vertex velocity,  N = unit normal,  A = current area,  v_n = N . u
//! dp = a v_n + b v_n |v_n|,         F = dp A N, a third to each vertex,  power = F . mean(v)
//! ```
//! With S = A N and dp' = a + 2 b |v_n| the exact tangents are
//! ```text
//! -df_i/dx_j = -1/3 [ dp I + S (dp'/A) ((I - N N^T) u)^T ] dS/dx_j     (not symmetric)
//! -df_i/dv_j = dp'/9 S N^T                                             (symmetric)
//! ```
//! A triangle of zero area has no normal: force and tangents are 0.

use super::batch::{BLOCK, Batch, Kernel, Threads, lane_sum};
use super::series::interpolate;
use super::triangle::{AreaVector, THIRD, mean};
use super::{ForceTerm, NodeState, TangentSink, outer};
use crate::model::forces::{Role, Tally};
use crate::model::spec::Series;
use crate::model::system::{TermInfo, Weights};
use glam::{DMat3, DVec3};
use std::ops::Range;
use std::sync::Arc;

/// The air on a batch of triangles.
#[derive(Debug)]
pub struct Air(Batch<AirData, 3>);

/// Plain data of the batch.
#[derive(Clone, Debug)]
pub struct AirData {
    /// vertices
    pub triangles: Arc<[[u32; 3]]>,
    /// [Pa s/m] viscous coefficient a
    pub linear: f64,
    /// [Pa s^2/m^2] inertial coefficient b
    pub quadratic: f64,
    /// [m/s] wind over time
    pub wind: Series<DVec3>,
}

struct Flow {
    area: AreaVector,
    /// [m^2]
    a: f64,
    n: DVec3,
    /// wind relative to it
    u: DVec3,
    dp: f64,
    /// d(dp)/d(v_n)
    slope: f64,
}

impl Air {
    /// Makes the term.
    pub fn new(data: AirData) -> Self {
        Air(Batch::new(data))
    }
}

impl AirData {
    #[inline]
    fn flow(&self, at: NodeState<'_>, wind: DVec3, nodes: [u32; 3]) -> Flow {
        let area = AreaVector::new(at.x, nodes);
        let a = area.s.length();
        let n = if a > 0.0 { area.s * a.recip() } else { DVec3::ZERO };
        let u = wind - mean(at.v, nodes);
        let vn = n.dot(u);
        let dp = self.linear * vn + self.quadratic * vn * vn.abs();
        Flow { area, a, n, u, dp, slope: self.linear + 2.0 * self.quadratic * vn.abs() }
    }
}

impl Kernel<3> for AirData {
    const SIGNS: [f64; 3] = [1.0; 3];

    fn elements(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    fn forces(&self, at: NodeState<'_>, range: Range<usize>, out: &mut [DVec3]) -> Tally {
        let wind = interpolate(&self.wind, at.t);
        let n = range.len();
        let mut buffers = [[0.0; BLOCK]; 3];
        let [flux, square, power] = &mut buffers;
        let (flux, square, power) = (&mut flux[..n], &mut square[..n], &mut power[..n]);
        for ((((&nodes, out), flux), square), power) in self.triangles[range]
            .iter()
            .zip(out.iter_mut())
            .zip(flux.iter_mut())
            .zip(square.iter_mut())
            .zip(power.iter_mut())
        {
            let (s, v) = (AreaVector::new(at.x, nodes).s, mean(at.v, nodes));
            *flux = s.dot(wind - v);
            *square = s.length_squared();
            *power = s.dot(v);
            *out = s;
        }
        // dp = a v_n + b v_n |v_n| with v_n = (S . u)/A; no memory access by node number, so that it vectorises.
        for ((flux, square), power) in flux.iter_mut().zip(square.iter()).zip(power.iter_mut()) {
            let vn = if *square > 0.0 { *flux / square.sqrt() } else { 0.0 };
            let dp = self.linear * vn + self.quadratic * vn * vn.abs();
            *flux = dp * THIRD;
            *power *= dp;
        }
        for (out, share) in out.iter_mut().zip(flux.iter()) {
            *out *= *share;
        }
        Tally { energy: 0.0, power: lane_sum(power) }
    }
}

impl ForceTerm for Air {
    fn info(&self) -> TermInfo {
        TermInfo { name: "air", role: Role::External }
    }

    fn elements(&self) -> usize {
        self.0.elements()
    }

    fn velocity_dependent(&self) -> bool {
        true
    }

    fn symmetric(&self) -> bool {
        false
    }

    fn add(&self, at: NodeState<'_>, threads: &Threads, f: &mut [DVec3]) -> Tally {
        self.0.add(at, threads, f)
    }

    fn tangent(&self, at: NodeState<'_>, w: Weights, sink: &mut dyn TangentSink) {
        let data = self.0.kernel();
        let wind = interpolate(&data.wind, at.t);
        for &nodes in data.triangles.iter() {
            let flow = data.flow(at, wind, nodes);
            if flow.a == 0.0 {
                sink.triangle(nodes, &[[DMat3::ZERO; 3]; 3]);
                continue;
            }
            let (s, n) = (flow.area.s, flow.n);
            let tangential = flow.u - n.dot(flow.u) * n;
            let ds = DMat3::from_diagonal(DVec3::splat(flow.dp)) + outer(s, tangential) * (flow.slope / flow.a);
            let dv = outer(s, n) * (w.c * flow.slope / 9.0);
            let row = [0, 1, 2].map(|j| ds * flow.area.derivative(j) * (-w.k / 3.0) + dv);
            sink.triangle(nodes, &[row; 3]);
        }
    }

    /// The part in the velocities, dp'/9 S N^T; what the shape does to the pressure has no symmetric part worth keeping.
    fn symmetric_tangent(&self, at: NodeState<'_>, w: Weights, sink: &mut dyn TangentSink) {
        let data = self.0.kernel();
        let wind = interpolate(&data.wind, at.t);
        for &nodes in data.triangles.iter() {
            let flow = data.flow(at, wind, nodes);
            let dv = outer(flow.area.s, flow.n) * (w.c * flow.slope / 9.0);
            sink.triangle(nodes, &[[dv; 3]; 3]);
        }
    }
}
