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

use crate::force::kernel::batch::{BufferReads, Records};
use crate::force::kernel::faces::{FaceBatch, FaceKernel, Faces};
use crate::force::kernel::triangle_pairs::{PressureForce, PressureLaw};
use crate::force::law::stream::Stream;
use crate::force::law::triangle::{AreaVector, THIRD, mean};
use crate::force::{Copies, ForceTerm, NodeState, TangentForm, TangentSink, outer};
use crate::model::forces::{Role, Tally};
use crate::model::quad::Real;
use crate::model::system::{TermInfo, Weights};
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// The air on a batch of triangles.
pub type Air = FaceBatch<AirData>;

/// Plain data of the batch.
#[derive(Clone, Debug)]
pub struct AirData {
    /// vertices
    pub triangles: Arc<[[u32; 3]]>,
    /// [Pa s/m] viscous coefficient a
    pub linear: f64,
    /// [Pa s^2/m^2] inertial coefficient b
    pub quadratic: f64,
    /// its wind is the same at all heights
    pub stream: Arc<Stream>,
}

struct Flow {
    area: AreaVector,
    /// [m^2]
    a: f64,
    n: Vector3<f64>,
    /// wind relative to it
    u: Vector3<f64>,
    dp: f64,
    /// d(dp)/d(v_n)
    slope: f64,
}

impl AirData {
    #[inline]
    fn flow(&self, at: NodeState<'_>, wind: Vector3<f64>, nodes: [u32; 3]) -> Flow {
        let area = AreaVector::new(at.x, nodes);
        let a = area.s.norm();
        let n = if a > 0.0 { area.s * a.recip() } else { Vector3::zeros() };
        let u = wind - mean(at.v, nodes);
        let vn = n.dot(&u);
        let dp = self.linear * vn + self.quadratic * vn * vn.abs();
        Flow { area, a, n, u, dp, slope: self.linear + 2.0 * self.quadratic * vn.abs() }
    }
}

impl AirData {
    /// [Pa] dp of each triangle.
    pub fn pressures<'a>(&'a self, at: NodeState<'a>) -> impl Iterator<Item = f64> + 'a {
        let wind = self.stream.uniform_wind(at.t);
        self.triangles.iter().map(move |&nodes| self.flow(at, wind, nodes).dp)
    }
}

impl FaceKernel for AirData {
    const READS: BufferReads = BufferReads { x: true, v: true };

    fn elements(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    fn add(&self, block: Faces<'_>, f: &mut Records) -> Tally {
        let wind = self.stream.uniform_wind(block.t);
        Tally { energy: 0.0, power: block.add_pressure(&AirLaw { data: self, wind }, f) }
    }

    fn for_run(&self, copies: &mut Copies) -> Self {
        AirData { stream: copies.of(&self.stream), ..self.clone() }
    }
}

struct AirLaw<'a> {
    data: &'a AirData,
    wind: Vector3<f64>,
}

impl PressureLaw for AirLaw<'_> {
    /// dp = a v_n + b v_n |v_n| with v_n = (S . u)/A, so that no normal is needed.
    #[inline(always)]
    fn pressure_force<R: Real>(&self, s: [R; 3], v: [R; 3]) -> PressureForce<R> {
        let (all, wind) = (|number| s[0].all(number), self.wind);
        let flow = all(THIRD) * (s[0] * v[0] + s[1] * v[1] + s[2] * v[2]);
        let flux = s[0] * all(wind.x) + s[1] * all(wind.y) + s[2] * all(wind.z) - flow;
        let area = (s[0] * s[0] + s[1] * s[1] + s[2] * s[2]).sqrt();
        let vn = (flux / area).where_positive(area);
        let dp = all(self.data.linear) * vn + all(self.data.quadratic) * vn * vn.abs();
        PressureForce { share: dp * all(THIRD), amount: dp * flow }
    }
}

impl ForceTerm for Air {
    fn parts(&self) -> &[TermInfo] {
        const INFO: TermInfo = TermInfo {
            velocity_dependent: true,
            follower: true,
            on_triangles: true,
            ..TermInfo::of("air", Role::External)
        };
        &[INFO]
    }

    fn symmetric(&self) -> bool {
        false
    }

    /// The symmetric form is the velocity part, dp'/9 S N^T. The symmetric part of the change of pressure with shape is
    /// not useful.
    fn tangent(&self, at: NodeState<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink) {
        let data = self.kernel();
        let wind = data.stream.uniform_wind(at.t);
        for &nodes in data.triangles.iter() {
            let flow = data.flow(at, wind, nodes);
            if form.symmetric {
                let dv = outer(flow.area.s, flow.n) * (w.c * flow.slope / 9.0);
                sink.triangle(nodes, &[[dv; 3]; 3]);
                continue;
            }
            if flow.a == 0.0 {
                sink.triangle(nodes, &[[Matrix3::zeros(); 3]; 3]);
                continue;
            }
            let (s, n) = (flow.area.s, flow.n);
            let tangential = flow.u - n.dot(&flow.u) * n;
            let ds = Matrix3::from_diagonal_element(flow.dp) + outer(s, tangential) * (flow.slope / flow.a);
            let dv = outer(s, n) * (w.c * flow.slope / 9.0);
            let row = [0, 1, 2].map(|j| ds * flow.area.derivative(j) * (-w.k / 3.0) + dv);
            sink.triangle(nodes, &[row; 3]);
        }
    }

    fn for_run(&self, copies: &mut Copies) -> Box<dyn ForceTerm> {
        Box::new(FaceBatch::for_run(self, copies))
    }
}
