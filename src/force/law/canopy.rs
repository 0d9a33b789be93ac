//! The air in a canopy: one follower pressure on its triangles, by the air speed along its axis and by how fast the
//! cloth moves in the air that goes with the canopy.
//!
//! ```text
//! a = unit vector from the apex to the confluence,     u = mean skirt velocity - wind there,     V = a . u
//! r = wind + V a,     w = (v - r) . n     of a triangle with mean velocity v and unit normal n from inside to outside
//! p = kappa dCp (V - w)|V - w|,     kappa = rho/2,     f_i = p S/3,     power = f . v
//! ```
//! Cloth that moves outwards meets less pressure: w takes energy from the breathing of a canopy, from its turning and
//! from its motion across the axis. It is nothing in steady flight along the axis. kappa, V and r couple all nodes of
//! the skirt, the apex and the confluence with all nodes of the canopy. The tangent is local but for a rank-one part of
//! each of these five numbers. With c = V - w
//! ```text
//! -df_i/dx_j = -1/3 [p I + 2 kappa dCp |c| S ((I - n n^T)(r - v))^T/A] dS/dx_j,     -df_i/dv_j = 2 kappa dCp |c| S n^T/9
//! -df_i/dkappa = -dCp c|c| S/3,     -df_i/dV = -2 kappa dCp |c| S/3,     -df_i/dr = -2 kappa dCp |c| S n^T/3
//! dV/dv_skirt = a/n_s,     dV/dz_skirt = -a . dw/dz/n_s,     dV/dx_confluence = da^T u,     da = (I - a a^T)/(L n_c)
//! dr = a dV + V da + dwind
//! ```
//! and the opposite at the apex. While a canopy fills, its drag area A(t) is given. Then
//! ```text
//! kappa = rho A/(2 G),   G = -sum dCp S . a,     dkappa = kappa (drho/rho - dG/G),     dG/dx_j = -sum dCp (dS/dx_j)^T a
//! ```
//! and dG by the axis -(I - a a^T) (sum dCp S)/(L n_c) at the confluence, the opposite at the apex.

use crate::force::kernel::batch::{BufferReads, Records, SceneNumbers};
use crate::force::kernel::element_block::{NodeVectors, SceneValues};
use crate::force::kernel::faces::{FaceBatch, FaceKernel, Faces};
use crate::force::kernel::triangle_pairs::{PressureForce, PressureLaw};
use crate::force::law::stream::{AirState, Stream};
use crate::force::law::triangle::{AreaVector, THIRD, mean};
use crate::force::{ForceTerm, NodeState, RankOne, TangentForm, TangentSink, outer};
use crate::model::forces::{Role, Tally};
use crate::model::quad::Real;
use crate::model::spec::FillingSpec;
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
    /// nodes of the skirt
    pub skirt: Vec<u32>,
    /// nodes around the apex
    pub apex: Vec<u32>,
    /// nodes where the lines meet
    pub confluence: Vec<u32>,
    /// the air around it
    pub stream: Arc<Stream>,
    /// stages of its drag area; none if the pressure is q dCp
    pub filling: Arc<[FillingSpec]>,
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
    /// [m^2] The drag area at time `t` [s] of a canopy that fills.
    pub fn drag_area(&self, t: f64) -> Option<f64> {
        let grown = |before: f64, stage: &FillingSpec| {
            let share = ((t - stage.start) / stage.duration).clamp(0.0, 1.0).powf(stage.exponent);
            before + share * (stage.drag_area - before)
        };
        (!self.filling.is_empty()).then(|| self.filling.iter().fold(0.0, grown))
    }

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

/// What the pressures depend on besides the triangles themselves.
#[derive(Clone, Copy)]
struct Breathing {
    /// [kg/m^3] kappa
    kappa: f64,
    /// [m/s] V
    speed: f64,
    /// [m/s] r
    along: Vector3<f64>,
}

impl Breathing {
    fn new([kappa, speed, x, y, z]: SceneValues) -> Self {
        Breathing { kappa, speed, along: Vector3::new(x, y, z) }
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
        Breathing::new(self.find(t, x, v))
    }

    fn meeting(&self, at: NodeState<'_>, air: Breathing, triangle: usize) -> Meeting {
        let (nodes, dcp) = (self.triangles[triangle], self.pressure_coefficient[triangle]);
        let area = AreaVector::new(at.x, nodes);
        let a = area.s.norm();
        let n = if a > 0.0 { area.s / a } else { Vector3::zeros() };
        let lag = air.along - mean(at.v, nodes);
        let c = air.speed + lag.dot(&n);
        let slope = 2.0 * air.kappa * dcp * c.abs();
        Meeting { area, n, lag, c, pressure: 0.5 * slope * c, slope }
    }

    /// [Pa] The pressures on its triangles at a state.
    pub fn pressures<'a>(&'a self, at: NodeState<'a>) -> impl Iterator<Item = f64> + 'a {
        let air = self.breathing(at.t, NodeVectors::Nodes(at.x), NodeVectors::Nodes(at.v));
        (0..self.triangles.len()).map(move |i| self.meeting(at, air, i).pressure)
    }

    /// [N] The force of the air along the axis at a state, towards the apex.
    pub fn drag(&self, at: NodeState<'_>) -> f64 {
        let axis = self.flow(at.t, NodeVectors::Nodes(at.x), NodeVectors::Nodes(at.v)).axis;
        let along = self.triangles.iter().zip(self.pressures(at));
        along.map(|(&nodes, pressure)| -pressure * AreaVector::new(at.x, nodes).s.dot(&axis)).sum()
    }
}

impl SceneNumbers for CanopyData {
    fn count(&self) -> usize {
        5
    }

    /// kappa [kg/m^3], V [m/s] and r [m/s]
    fn find(&self, t: f64, x: NodeVectors<'_>, v: NodeVectors<'_>) -> SceneValues {
        let AxialFlow { axis, speed, air, .. } = self.flow(t, x, v);
        let share = self.drag_area(t).map_or(1.0, |area| area / -self.opening(x).dot(&axis));
        let along = air.wind[0] + speed * axis;
        [0.5 * air.density[0] * share, speed, along.x, along.y, along.z]
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
}

struct CanopyLaw(Breathing);

impl PressureLaw for CanopyLaw {
    const FACTORS: bool = true;

    #[inline(always)]
    fn pressure_force<R: Real>(&self, s: [R; 3], v: [R; 3]) -> PressureForce<R> {
        let (all, Breathing { kappa, speed, along }) = (|number| s[0].all(number), self.0);
        let flow = all(THIRD) * (s[0] * v[0] + s[1] * v[1] + s[2] * v[2]);
        let flux = s[0] * all(along.x) + s[1] * all(along.y) + s[2] * all(along.z) - flow;
        let area = (s[0] * s[0] + s[1] * s[1] + s[2] * s[2]).sqrt();
        let c = all(speed) + (flux / area).where_positive(area);
        let pressure = all(kappa) * c * c.abs();
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
                _ => slope * n[which - 2],
            };
            let force = area.s * (change / 3.0);
            nodes.into_iter().for_each(|node| u[node as usize] -= force);
        }
        let flow = data.flow(at.t, NodeVectors::Nodes(at.x), NodeVectors::Nodes(at.v));
        match which {
            0 => data.kappa_gradient(at, flow, w.k, g),
            1 => data.speed_gradient(flow, w, g),
            _ => data.along_gradient(which - 2, flow, w, g),
        }
    }
}

impl CanopyData {
    /// Adds the gradient of a mean over some nodes.
    fn spread(&self, nodes: &[u32], whole: Vector3<f64>, g: &mut [Vector3<f64>]) {
        let share = whole / nodes.len() as f64;
        nodes.iter().for_each(|&node| g[node as usize] += share);
    }

    /// Adds k dkappa/dx.
    fn kappa_gradient(&self, at: NodeState<'_>, flow: AxialFlow, k: f64, g: &mut [Vector3<f64>]) {
        let (AxialFlow { axis, .. }, [density, thinning]) = (flow, flow.air.density);
        let Some(area) = self.drag_area(at.t) else {
            return self.spread(&self.skirt, Vector3::z() * (0.5 * k * thinning), g);
        };
        let opening = self.opening(NodeVectors::Nodes(at.x));
        let size = -opening.dot(&axis);
        let share = area / size;
        self.spread(&self.skirt, Vector3::z() * (0.5 * k * thinning * share), g);
        // kappa/G, by which dG counts.
        let closing = 0.5 * density * share / size * k;
        self.turn(flow, closing * opening, g);
        for (&nodes, dcp) in self.triangles.iter().zip(self.pressure_coefficient.iter()) {
            let area = AreaVector::new(at.x, nodes);
            for (j, node) in nodes.into_iter().enumerate() {
                g[node as usize] += closing * *dcp * (area.derivative(j).transpose() * axis);
            }
        }
    }

    /// Adds c dV/dv + k dV/dx.
    fn speed_gradient(&self, flow: AxialFlow, w: Weights, g: &mut [Vector3<f64>]) {
        let AxialFlow { axis, velocity, air, .. } = flow;
        let [_, shear] = air.wind;
        self.spread(&self.skirt, w.c * axis - w.k * axis.dot(&shear) * Vector3::z(), g);
        self.turn(flow, w.k * velocity, g);
    }

    /// The same for one component of r.
    fn along_gradient(&self, i: usize, flow: AxialFlow, w: Weights, g: &mut [Vector3<f64>]) {
        let AxialFlow { axis, speed, air, .. } = flow;
        self.speed_gradient(flow, Weights { c: w.c * axis[i], k: w.k * axis[i], ..w }, g);
        self.spread(&self.skirt, w.k * air.wind[1][i] * Vector3::z(), g);
        let mut component = Vector3::zeros();
        component[i] = w.k * speed;
        self.turn(flow, component, g);
    }

    /// Adds the gradient of a product of the axis and a given vector.
    fn turn(&self, AxialFlow { axis, length, .. }: AxialFlow, by: Vector3<f64>, g: &mut [Vector3<f64>]) {
        if length > 0.0 {
            let turn = (by - axis.dot(&by) * axis) / length;
            self.spread(&self.confluence, turn, g);
            self.spread(&self.apex, -turn, g);
        }
    }
}
