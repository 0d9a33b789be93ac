//! The air in a canopy: one follower pressure on its triangles, by the air speed along its axis and by how fast the
//! cloth moves in the air that goes with the canopy.
//!
//! ```text
//! V = speed of the skirt against the wind along the axis a, with a `cavity` that of the confluence (`axial_flow`)
//! r = wind + V a,     w = (v - r) . n     of a triangle with mean velocity v and unit normal n from inside to outside
//! p = dCp (p_0 + kappa (V - w)|V - w|),     kappa = rho/2,     f_i = p S/3,     power = f . v
//! ```
//! Cloth that moves outwards meets less pressure: w takes energy from the breathing of a canopy, from its turning and
//! from its motion across the axis. It is nothing in steady flight along the axis. p_0 is that of a `cavity`, what its
//! pressure has beyond kappa V|V|, or a loss at the mouth (`inflow`). Else it is 0. kappa, V, r and p_0 couple the
//! nodes of the apex and the confluence, or of the skirt or the canopy, with all nodes of the canopy. The tangent is
//! local but for a rank-one part of each of these numbers. With c = V - w
//! ```text
//! -df_i/dx_j = -1/3 [p I + 2 kappa dCp |c| S ((I - n n^T)(r - v))^T/A] dS/dx_j,     -df_i/dv_j = 2 kappa dCp |c| S n^T/9
//! -df_i/dkappa = -dCp c|c| S/3,     -df_i/dV = -2 kappa dCp |c| S/3,     -df_i/dr = -2 kappa dCp |c| S n^T/3
//! -df_i/dp_0 = -dCp S/3,     dr = a dV + V da + dwind
//! ```
//! While a canopy fills, its drag area A(t) is given. Then
//! ```text
//! kappa = rho A/(2 G),   G = -sum dCp S . a,     dkappa = kappa (drho/rho - dG/G),     dG/dx_j = -sum dCp (dS/dx_j)^T a
//! ```
//! and dG by the axis -(I - a a^T) (sum dCp S)/(L n_c) at the confluence, the opposite at the apex.

use crate::force::kernel::batch::{BufferReads, Records, SceneNumbers};
use crate::force::kernel::element_block::{MOST_NUMBERS, NodeVectors, SceneValues};
use crate::force::kernel::faces::{FaceBatch, FaceKernel, Faces};
use crate::force::kernel::triangle_pairs::{PressureForce, PressureLaw};
use crate::force::law::axial_flow::{AxialFlow, CanopyAxis};
use crate::force::law::cavity::Cavity;
use crate::force::law::inflow::InflowLoss;
use crate::force::law::stages::Stages;
use crate::force::law::triangle::{AreaVector, THIRD, mean};
use crate::force::{Copies, ForceTerm, NodeState, RankOne, TangentForm, TangentSink, outer};
use crate::model::forces::{Role, Tally};
use crate::model::quad::Real;
use crate::model::system::{TermInfo, Weights};
use nalgebra::{Matrix3, Vector3};
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
    /// skirt, apex and confluence, and the air around them
    pub axis: CanopyAxis,
    /// what sets the pressure
    pub air: AirModel,
    /// loss of pressure by the air that enters; none with a cavity, which has a balance of its own
    pub inflow: Option<InflowLoss>,
}

/// What sets the pressure in a canopy, as [`CanopyAir`](crate::model::spec::CanopyAir) says.
#[derive(Clone, Debug)]
pub enum AirModel {
    /// q dCp
    Coefficient,
    /// stages of the drag area
    Filling(Stages),
    /// balance of the air inside
    Cavity(Cavity),
}

impl CanopyData {
    /// [m^2] The sum of dCp S.
    fn opening(&self, x: NodeVectors<'_>) -> Vector3<f64> {
        let areas = self.triangles.iter().zip(self.pressure_coefficient.iter()).map(|(&[a, b, c], dcp)| {
            let from = x.at(a);
            0.5 * dcp * (x.at(b) - from).cross(&(x.at(c) - from))
        });
        areas.sum()
    }
}

/// What the pressures depend on besides the triangles themselves.
#[derive(Clone, Copy)]
struct Breathing {
    /// [kg/m^3] kappa
    kappa: f64,
    /// [m/s] V
    speed: f64,
    /// [m/s] r
    along: Vector3<f64>,
    /// [Pa] p_0
    excess: f64,
}

impl Breathing {
    fn new(numbers: &[f64]) -> Self {
        let [kappa, speed, x, y, z, excess] = std::array::from_fn(|i| numbers.get(i).copied().unwrap_or(0.0));
        Breathing { kappa, speed, along: Vector3::new(x, y, z), excess }
    }
}

/// The air at a triangle.
struct Meeting {
    area: AreaVector,
    /// unit normal; 0 without an area
    n: Vector3<f64>,
    /// [m/s] r - v
    lag: Vector3<f64>,
    /// [m/s] V - w
    c: f64,
    /// [Pa] p
    pressure: f64,
    /// [Pa s/m] dp/dc
    slope: f64,
}

impl CanopyData {
    fn breathing(&self, t: f64, x: NodeVectors<'_>, v: NodeVectors<'_>) -> Breathing {
        let mut numbers = [0.0; MOST_NUMBERS];
        self.find(t, x, v, &mut numbers);
        Breathing::new(&numbers)
    }

    fn meeting(&self, at: NodeState<'_>, air: Breathing, triangle: usize) -> Meeting {
        let (nodes, dcp) = (self.triangles[triangle], self.pressure_coefficient[triangle]);
        let area = AreaVector::new(at.x, nodes);
        let a = area.s.norm();
        let n = if a > 0.0 { area.s / a } else { Vector3::zeros() };
        let lag = air.along - mean(at.v, nodes);
        let c = air.speed + lag.dot(&n);
        let slope = 2.0 * air.kappa * dcp * c.abs();
        Meeting { area, n, lag, c, pressure: dcp * air.excess + 0.5 * slope * c, slope }
    }

    /// [Pa] The pressures on its triangles at a state.
    pub fn pressures<'a>(&'a self, at: NodeState<'a>) -> impl Iterator<Item = f64> + 'a {
        let air = self.breathing(at.t, NodeVectors::Nodes(at.x), NodeVectors::Nodes(at.v));
        (0..self.triangles.len()).map(move |i| self.meeting(at, air, i).pressure)
    }
}

impl SceneNumbers for CanopyData {
    fn count(&self) -> usize {
        match (&self.air, &self.inflow) {
            (AirModel::Coefficient | AirModel::Filling(_), None) => 5,
            _ => 6,
        }
    }

    /// kappa [kg/m^3], V [m/s], r [m/s] and p_0 [Pa]
    fn find(&self, t: f64, x: NodeVectors<'_>, v: NodeVectors<'_>, out: &mut SceneValues) {
        let flow = self.axis.flow(t, x, v);
        let AxialFlow { axis, speed, air, .. } = flow;
        let along = air.wind[0] + speed * axis;
        let loss = self.inflow.as_ref().map_or(0.0, |inflow| inflow.pressure(air.density[0], x, v));
        let (share, excess) = match &self.air {
            AirModel::Coefficient => (1.0, loss),
            AirModel::Filling(stages) => (stages.area_at(t) / -self.opening(x).dot(&axis), loss),
            AirModel::Cavity(cavity) => (1.0, cavity.excess(&self.triangles, flow, x, v)),
        };
        let numbers = [0.5 * air.density[0] * share, speed, along.x, along.y, along.z, excess];
        out[..numbers.len()].copy_from_slice(&numbers);
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

    fn scene_numbers(&self) -> Option<&dyn SceneNumbers> {
        Some(self)
    }

    fn add(&self, block: Faces<'_>, f: &mut Records) -> Tally {
        let law = CanopyLaw(Breathing::new(block.scene_numbers));
        Tally { energy: 0.0, power: block.add_pressure(&law, f) }
    }

    fn for_run(&self, copies: &mut Copies) -> Self {
        let axis = CanopyAxis { stream: copies.of(&self.axis.stream), ..self.axis.clone() };
        let air = match &self.air {
            AirModel::Filling(stages) => AirModel::Filling(stages.for_run(copies)),
            AirModel::Coefficient | AirModel::Cavity(_) => self.air.clone(),
        };
        CanopyData { axis, air, ..self.clone() }
    }
}

struct CanopyLaw(Breathing);

impl PressureLaw for CanopyLaw {
    const FACTORS: bool = true;

    #[inline(always)]
    fn pressure_force<R: Real>(&self, s: [R; 3], v: [R; 3]) -> PressureForce<R> {
        let (all, Breathing { kappa, speed, along, excess }) = (|number| s[0].all(number), self.0);
        let flow = all(THIRD) * (s[0] * v[0] + s[1] * v[1] + s[2] * v[2]);
        let flux = s[0] * all(along.x) + s[1] * all(along.y) + s[2] * all(along.z) - flow;
        let area = (s[0] * s[0] + s[1] * s[1] + s[2] * s[2]).sqrt();
        let c = all(speed) + (flux / area).where_positive(area);
        let pressure = all(excess) + all(kappa) * c * c.abs();
        PressureForce { share: all(THIRD) * pressure, amount: pressure * flow }
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

    /// The symmetric form is the velocity part, as for any follower pressure.
    fn tangent(&self, at: NodeState<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink) {
        let data = self.kernel();
        let air = data.breathing(at.t, NodeVectors::Nodes(at.x), NodeVectors::Nodes(at.v));
        for (triangle, &nodes) in data.triangles.iter().enumerate() {
            let Meeting { area, n, lag, pressure, slope, .. } = data.meeting(at, air, triangle);
            let dv = outer(area.s, n) * (w.c * slope / 9.0);
            if form.symmetric {
                sink.triangle(nodes, &[[dv; 3]; 3]);
                continue;
            }
            // S/A = n
            let ds = Matrix3::from_diagonal_element(pressure) + outer(n, lag - lag.dot(&n) * n) * slope;
            let row = [0, 1, 2].map(|j| ds * area.derivative(j) * (-w.k / 3.0) + dv);
            sink.triangle(nodes, &[row; 3]);
        }
    }

    fn rank_one(&self, which: usize, at: NodeState<'_>, w: Weights, RankOne { u, g }: RankOne<'_>) {
        let data = self.kernel();
        u.fill(Vector3::zeros());
        g.fill(Vector3::zeros());
        let air = data.breathing(at.t, NodeVectors::Nodes(at.x), NodeVectors::Nodes(at.v));
        for (triangle, (&nodes, dcp)) in data.triangles.iter().zip(data.pressure_coefficient.iter()).enumerate() {
            let Meeting { area, n, c, slope, .. } = data.meeting(at, air, triangle);
            let change = match which {
                0 => dcp * c * c.abs(),
                1 => slope,
                5 => *dcp,
                _ => slope * n[which - 2],
            };
            let force = area.s * (change / 3.0);
            nodes.into_iter().for_each(|node| u[node as usize] -= force);
        }
        let flow = data.axis.flow(at.t, NodeVectors::Nodes(at.x), NodeVectors::Nodes(at.v));
        match (which, &data.air) {
            (0, AirModel::Filling(stages)) => {
                data.add_kappa_gradient(at, flow, stages.area_at(at.t), w.k, g);
            }
            (0, AirModel::Coefficient | AirModel::Cavity(_)) => data.axis.add_density_gradient(flow, 0.5 * w.k, g),
            (1, _) => data.axis.add_speed_gradient(flow, w, g),
            (2..5, _) => data.axis.add_along_gradient(which - 2, flow, w, g),
            (_, AirModel::Cavity(cavity)) => cavity.add_excess_gradient(&data.triangles, &data.axis, at, w, g),
            (_, AirModel::Coefficient | AirModel::Filling(_)) => {
                if let Some(inflow) = &data.inflow {
                    inflow.add_gradient(&data.axis, flow, at, w, g);
                }
            }
        }
    }

    fn for_run(&self, copies: &mut Copies) -> Box<dyn ForceTerm> {
        Box::new(FaceBatch::for_run(self, copies))
    }
}

impl CanopyData {
    /// Adds k dkappa/dx while a canopy fills, with its drag area [m^2].
    fn add_kappa_gradient(&self, at: NodeState<'_>, flow: AxialFlow, area: f64, k: f64, g: &mut [Vector3<f64>]) {
        let AxialFlow { axis, air, .. } = flow;
        let opening = self.opening(NodeVectors::Nodes(at.x));
        let size = -opening.dot(&axis);
        let share = area / size;
        self.axis.add_density_gradient(flow, 0.5 * k * share, g);
        // kappa/G, by which dG counts.
        let closing = 0.5 * air.density[0] * share / size * k;
        self.axis.add_turn(flow, closing * opening, g);
        for (&nodes, dcp) in self.triangles.iter().zip(self.pressure_coefficient.iter()) {
            let area = AreaVector::new(at.x, nodes);
            for (j, node) in nodes.into_iter().enumerate() {
                g[node as usize] += closing * *dcp * (area.derivative(j).transpose() * axis);
            }
        }
    }
}
