//! Wind on a surface by pressure coefficients, as building codes give them: a pressure along the normals of the
//! triangles of a zone, by the dynamic pressure of the wind and the angle at which it meets the surface.
//!
//! ```text
//! n = outer unit normal (right-handed), V = wind at the height z of the triangle's centre, w = V/|V|, q = rho |V|^2/2
//! theta = angle between n and -w: 0 where the wind meets the outer face, pi/2 along it, pi on the lee side
//! p = -cp(theta) q along n,      f_i = p S/3,      power = p S . mean(v)
//! ```
//! A positive cp pushes onto the outer face, a negative one is suction. q is that of the wind alone: a structure is
//! slow beside it, and codes know no velocity of the surface. With c = n . w, sin(theta) = |w - c n| the exact tangent
//! is
//! ```text
//! dtheta = t . dS/A + m . (dV/dz) dz/|V|,      t = (w - c n)/sin(theta),  m = (n - c w)/sin(theta)
//! dp = -q cp' dtheta - cp dq,                  dq/dz = rho'/2 |V|^2 + rho V . dV/dz
//! -df_i/dx_j = -1/3 [(p I - q cp'/A S t^T) dS/dx_j + dp/dz S e_z^T/3]      (not symmetric)
//! ```
//! Where the wind meets the surface head-on, theta has a kink; its slope is taken as 0 there. A triangle of zero area
//! has no normal, and calm air no direction: force and tangent are 0.

use crate::force::kernel::batch::{Batch, BufferReads, Elements, Kernel, Records};
use crate::force::kernel::element_block::{add, vector};
use crate::force::law::stream::{AirState, Stream};
use crate::force::law::triangle::{AreaVector, THIRD};
use crate::force::{Copies, ForceTerm, NodeState, TangentForm, TangentSink, outer};
use crate::model::forces::{Role, Tally};
use crate::model::spec::Series;
use crate::model::system::{TermInfo, Weights};
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// The wind on a zone of a surface.
pub type SurfacePressure = Batch<SurfacePressureData, 3>;

/// Plain data of a zone.
#[derive(Clone, Debug)]
pub struct SurfacePressureData {
    /// vertices, right-handed about the outer normal
    pub triangles: Arc<[[u32; 3]]>,
    /// \[-\] cp over the angle of incidence \[rad\], which stands for the time of the table
    pub coefficient: Arc<Series<[f64; 1]>>,
    /// the air around it
    pub stream: Arc<Stream>,
}

/// The wind at a triangle.
struct Incidence {
    /// [m/s] |V|
    speed: f64,
    /// [Pa] q
    q: f64,
    /// unit normal
    n: Vector3<f64>,
    /// w
    w: Vector3<f64>,
    /// n . w
    c: f64,
    /// [-] sin(theta)
    sine: f64,
    /// [rad]
    theta: f64,
}

impl Incidence {
    /// `None` without an area or a wind.
    fn new(s: Vector3<f64>, air: &AirState) -> Option<Self> {
        let (area, speed) = (s.norm(), air.wind[0].norm());
        if area == 0.0 || speed == 0.0 {
            return None;
        }
        let (n, w) = (s / area, air.wind[0] / speed);
        let c = n.dot(&w);
        let sine = (w - c * n).norm();
        Some(Incidence { speed, q: 0.5 * air.density[0] * speed * speed, n, w, c, sine, theta: sine.atan2(-c) })
    }
}

/// How the pressure on a triangle changes.
struct Slopes {
    /// [Pa/m^2] by the area vector
    by_area: Vector3<f64>,
    /// [Pa/m] by the height of the centre
    by_height: f64,
}

impl SurfacePressureData {
    fn air(&self, t: f64, x: [Vector3<f64>; 3]) -> AirState {
        self.stream.at(t, THIRD * (x[0].z + x[1].z + x[2].z))
    }

    /// [Pa] p along the normal.
    fn pressure(&self, t: f64, x: [Vector3<f64>; 3], s: Vector3<f64>) -> f64 {
        Incidence::new(s, &self.air(t, x)).map_or(0.0, |meets| -self.coefficient.at(meets.theta)[0] * meets.q)
    }

    fn slopes(&self, t: f64, x: [Vector3<f64>; 3], s: Vector3<f64>) -> Slopes {
        let air = self.air(t, x);
        let Some(Incidence { speed, q, n, w, c, sine, theta }) = Incidence::new(s, &air) else {
            return Slopes { by_area: Vector3::zeros(), by_height: 0.0 };
        };
        let [cp] = self.coefficient.at(theta);
        let by_sine = if sine > 0.0 { -q * self.coefficient.slope_after(theta)[0] / sine } else { 0.0 };
        let dq = air.density[1] * 0.5 * speed * speed + air.density[0] * air.wind[0].dot(&air.wind[1]);
        Slopes {
            by_area: (w - c * n) * (by_sine / s.norm()),
            by_height: by_sine * (n - c * w).dot(&air.wind[1]) / speed - cp * dq,
        }
    }

    /// [Pa] p of each triangle, along its right-hand normal.
    pub fn pressures<'a>(&'a self, at: NodeState<'a>) -> impl Iterator<Item = f64> + 'a {
        self.triangles.iter().map(move |nodes| {
            let x = nodes.map(|node| at.x[node as usize]);
            self.pressure(at.t, x, AreaVector::of(x).s)
        })
    }
}

impl Kernel<3> for SurfacePressureData {
    const READS: BufferReads = BufferReads { x: true, v: true };

    fn elements(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    fn add(&self, block: Elements<'_, 3>, f: &mut Records) -> Tally {
        let mut power = 0.0;
        for &nodes in block.nodes {
            let [x, v] = [block.x, block.v].map(|of| nodes.map(|node| vector(of, node)));
            let s = AreaVector::of(x).s;
            let force = s * (THIRD * self.pressure(block.t, x, s));
            power += force.dot(&(v[0] + v[1] + v[2]));
            nodes.into_iter().for_each(|node| add(f, node, force));
        }
        Tally { energy: 0.0, power }
    }

    fn for_run(&self, copies: &mut Copies) -> Option<Self> {
        Some(SurfacePressureData { stream: copies.of(&self.stream), ..self.clone() })
    }
}

impl ForceTerm for SurfacePressure {
    fn parts(&self) -> &[TermInfo] {
        const INFO: TermInfo =
            TermInfo { follower: true, on_triangles: true, ..TermInfo::of("surface pressure", Role::External) };
        &[INFO]
    }

    fn symmetric(&self) -> bool {
        false
    }

    /// There is no symmetric form, as for any follower pressure that does not depend on velocity.
    fn tangent(&self, at: NodeState<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink) {
        let data = self.kernel();
        let k = if form.symmetric { 0.0 } else { w.k };
        for &nodes in data.triangles.iter() {
            let x = nodes.map(|node| at.x[node as usize]);
            let area = AreaVector::of(x);
            let pressure = data.pressure(at.t, x, area.s);
            let Slopes { by_area, by_height } = data.slopes(at.t, x, area.s);
            let by_shape = Matrix3::from_diagonal_element(pressure) + outer(area.s, by_area);
            let by_place = outer(area.s, Vector3::z()) * (THIRD * by_height);
            let row = [0, 1, 2].map(|j| (by_shape * area.derivative(j) + by_place) * (-k / 3.0));
            sink.triangle(nodes, &[row; 3]);
        }
    }

    fn for_run(&self, copies: &mut Copies) -> Box<dyn ForceTerm> {
        Box::new(Batch::for_run(self, copies))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::spec::StreamSpec;

    /// A table that is the angle itself, over a triangle that looks to several sides in a wind along x.
    #[test]
    fn the_angle_is_that_between_the_outer_normal_and_where_the_wind_comes_from() {
        let angle = Series { t: vec![0.0, 4.0], value: vec![[0.0], [4.0]] };
        let wind = Series { t: vec![0.0], value: vec![[30.0, 0.0, 0.0]] };
        let data = SurfacePressureData {
            triangles: [[0, 1, 2]].into(),
            coefficient: Arc::new(angle),
            stream: Arc::new(Stream::new(StreamSpec::of_wind(wind))),
        };
        let q = 0.5 * 1.225 * 900.0;
        let half = std::f64::consts::FRAC_PI_2;
        for (normal, theta) in [
            (Vector3::new(-2.0, 0.0, 0.0), 0.0),
            (Vector3::new(0.0, 0.0, 1.0), half),
            (Vector3::new(0.0, -3.0, 0.0), half),
            (Vector3::new(-1.0, 0.0, 1.0), 0.5 * half),
            (Vector3::new(5.0, 0.0, 0.0), 2.0 * half),
        ] {
            let found = data.pressure(0.0, [Vector3::zeros(); 3], normal);
            assert!((found + theta * q).abs() < 1e-12 * q, "{normal:?}: {found}");
        }
    }
}
