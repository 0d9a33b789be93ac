//! The air in a canopy that fills by itself: a balance of the air ring by ring, and how fast the cloth moves.
//!
//! ```text
//! ring j from the vent edge (0) to the skirt (N), band b of cloth between rings b and b + 1
//! Q_j = dVol_j/dt + leaks above + vent,    x_j = Q_j/(A_j |V|)         what passes the disc of a ring
//! p_i = q - q (x|x| + max(0, X^2 - 1)),    X the largest x from here to the skirt
//! p_o = Cb q above the widest ring,  Cb q (1 - min(max(x_N, 0), 1)^2) below it
//! w   = (v - r) . n of a triangle with mean velocity v and outer normal n,      r = wind + V a
//! p   = max(p_i - p_o, 0) - rho w (kd |V| + kv |w|),     f_i = p S/3,     power = f . v
//! ```
//! V is the speed of the *confluence* against the wind along the axis a (`axial_flow`), q = rho V|V|/2: the skirt's own
//! speed swings while a canopy fills. x|x| is Bernoulli's equation at each ring: in the crown x is near 0 and the
//! pressure full, at the skirt x is near 1 and the pressure low, so the crown fills first and grows downwards. A mouth
//! gives what the stream brings; more costs head, X^2 - 1. Cloth under outer pressure folds and carries none. `balance`
//! finds the pressures dp_b = max(p_i - p_o, 0), with rounded corners; `stations` measures rings and bands.
//!
//! dp_b, D = kd rho|V|, E = kv rho and r couple all nodes. The tangent is local but for a rank-one part of each:
//! ```text
//! -df_i/dx_j = -1/3 [p I + s S ((I - n n^T)(r - v))^T/A] dS/dx_j,    -df_i/dv_j = s S n^T/9,     s = D + 2 E|w|
//! -df_i/d(dp_b) = -S/3 on band b,    -df_i/dD = w S/3,    -df_i/dE = w|w| S/3,    -df_i/dr = -s S n^T/3
//! ```

mod balance;
mod stations;

use crate::force::kernel::batch::{Batch, BufferReads, Elements, Kernel, Records, SceneNumbers};
use crate::force::kernel::element_block::{MOST_NUMBERS, NodeVectors, SceneValues, add, vector};
use crate::force::law::axial_flow::{AxialFlow, CanopyAxis};
use crate::force::law::triangle::{AreaVector, THIRD, mean};
use crate::force::{Copies, ForceTerm, NodeState, RankOne, TangentForm, TangentSink, outer};
use crate::model::forces::{Role, Tally};
use crate::model::system::{TermInfo, Weights};
pub(crate) use balance::Passage;
use balance::{Flow, FlowGradient, MOST_BANDS};
use nalgebra::{Matrix3, Vector3};
pub(crate) use stations::Stations;
use std::sync::Arc;

/// The air in a canopy, ring by ring.
pub type RingedCanopy = Batch<RingsData, 3>;

/// Bands of cloth at most.
pub(crate) const MOST_STATIONS: usize = MOST_BANDS;

/// Numbers beside the pressures of the bands: D, E and r.
const OTHERS: usize = 5;
const _: () = assert!(MOST_BANDS + OTHERS <= MOST_NUMBERS);

/// Plain data of a canopy.
#[derive(Clone, Debug)]
pub struct RingsData {
    /// vertices, right-handed about the outer normal
    pub triangles: Arc<[[u32; 3]]>,
    /// band of each triangle
    pub(crate) bands: Arc<[u16]>,
    /// apex and confluence, and the air around them
    pub axis: CanopyAxis,
    pub(crate) stations: Arc<Stations>,
    pub(crate) passage: Arc<Passage>,
    /// [-] Cb
    pub outer: f64,
    /// [-] kd and kv
    pub damping: [f64; 2],
}

/// The air at a state.
struct CanopyState {
    axial: AxialFlow,
    flow: Flow,
    /// dp \[Pa\] by band, D \[Pa s/m\], E \[Pa s^2/m^2\] and r \[m/s\]
    numbers: SceneValues,
}

/// What the pressure on a triangle depends on besides itself.
#[derive(Clone, Copy)]
struct Meets<'a> {
    /// [Pa] dp by band
    dp: &'a [f64],
    /// [Pa s/m] D
    linear: f64,
    /// [Pa s^2/m^2] E
    quadratic: f64,
    /// [m/s] r
    along: Vector3<f64>,
}

/// The air at a triangle.
struct Meeting {
    area: AreaVector,
    /// unit normal; 0 without an area
    n: Vector3<f64>,
    /// [m/s] r - v
    lag: Vector3<f64>,
    /// [m/s] w
    outwards: f64,
    /// [Pa] p
    pressure: f64,
    /// [Pa s/m] s
    slope: f64,
}

impl<'a> Meets<'a> {
    fn new(numbers: &'a [f64], bands: usize) -> Self {
        let (dp, others) = numbers.split_at(bands);
        Meets { dp, linear: others[0], quadratic: others[1], along: Vector3::new(others[2], others[3], others[4]) }
    }

    fn at(self, band: u16, area: AreaVector, v: Vector3<f64>) -> Meeting {
        let a = area.s.norm();
        let n = if a > 0.0 { area.s / a } else { Vector3::zeros() };
        let lag = self.along - v;
        let outwards = -lag.dot(&n);
        let pressure = self.dp[usize::from(band)] - outwards * (self.linear + self.quadratic * outwards.abs());
        Meeting { area, n, lag, outwards, pressure, slope: self.linear + 2.0 * self.quadratic * outwards.abs() }
    }
}

impl RingsData {
    fn bands(&self) -> usize {
        self.stations.bands()
    }

    fn air(&self, t: f64, x: NodeVectors<'_>, v: NodeVectors<'_>) -> CanopyState {
        let axial = self.axis.flow(t, x, v);
        let AxialFlow { axis, speed, dynamic_pressure: q, air, .. } = axial;
        let (n, density) = (self.bands(), air.density[0]);
        let stations::Measured { rate, area, open, below } = self.stations.measure(x, v);
        let flow = Flow { bands: n, q, density, outer: self.outer, rate, area, open, below };
        let mut numbers = [0.0; MOST_NUMBERS];
        numbers[..n].copy_from_slice(&flow.pressures(&self.passage)[..n]);
        let along = air.wind[0] + speed * axis;
        let [linear, quadratic] = self.damping.map(|k| k * density);
        numbers[n..n + OTHERS].copy_from_slice(&[linear * speed.abs(), quadratic, along.x, along.y, along.z]);
        CanopyState { axial, flow, numbers }
    }

    fn meetings<'a>(&'a self, at: NodeState<'a>, numbers: &'a [f64]) -> impl Iterator<Item = Meeting> + 'a {
        let meets = Meets::new(numbers, self.bands());
        let triangles = self.triangles.iter().zip(self.bands.iter());
        triangles.map(move |(&nodes, &band)| meets.at(band, AreaVector::new(at.x, nodes), mean(at.v, nodes)))
    }

    fn air_at(&self, at: NodeState<'_>) -> CanopyState {
        self.air(at.t, NodeVectors::Nodes(at.x), NodeVectors::Nodes(at.v))
    }

    /// \[Pa\] The pressures on its triangles at a state.
    pub fn pressures(&self, at: NodeState<'_>) -> Vec<f64> {
        self.meetings(at, &self.air_at(at).numbers).map(|meeting| meeting.pressure).collect()
    }
}

impl SceneNumbers for RingsData {
    fn count(&self) -> usize {
        self.bands() + OTHERS
    }

    /// dp [Pa] by band, D [Pa s/m], E [Pa s^2/m^2] and r [m/s]
    fn find(&self, t: f64, x: NodeVectors<'_>, v: NodeVectors<'_>, out: &mut SceneValues) {
        let count = self.count();
        out[..count].copy_from_slice(&self.air(t, x, v).numbers[..count]);
    }
}

impl Kernel<3> for RingsData {
    const READS: BufferReads = BufferReads { x: true, v: true };

    fn elements(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    fn scene_numbers(&self) -> Option<&dyn SceneNumbers> {
        Some(self)
    }

    fn add(&self, block: Elements<'_, 3>, f: &mut Records) -> Tally {
        let meets = Meets::new(block.scene_numbers, self.bands());
        let mut power = 0.0;
        for (nodes, number) in block.nodes.iter().zip(block.range()) {
            let [x, v] = [block.x, block.v].map(|of| nodes.map(|node| vector(of, node)));
            let v = (v[0] + v[1] + v[2]) * THIRD;
            let Meeting { area, pressure, .. } = meets.at(self.bands[number], AreaVector::of(x), v);
            let force = area.s * pressure;
            power += force.dot(&v);
            nodes.iter().for_each(|&node| add(f, node, force * THIRD));
        }
        Tally { energy: 0.0, power }
    }

    fn for_run(&self, copies: &mut Copies) -> Option<Self> {
        let axis = CanopyAxis { stream: copies.of(&self.axis.stream), ..self.axis.clone() };
        Some(RingsData { axis, ..self.clone() })
    }
}

impl ForceTerm for RingedCanopy {
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
        let numbers = data.air_at(at).numbers;
        for (meeting, &nodes) in data.meetings(at, &numbers).zip(data.triangles.iter()) {
            let Meeting { area, n, lag, pressure, slope, .. } = meeting;
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
        let n = data.bands();
        let CanopyState { axial, flow, numbers } = data.air_at(at);
        u.fill(Vector3::zeros());
        g.fill(Vector3::zeros());
        if which < n {
            let triangles = data.triangles.iter().zip(data.bands.iter());
            for (&nodes, _) in triangles.filter(|(_, band)| usize::from(**band) == which) {
                let force = AreaVector::new(at.x, nodes).s / 3.0;
                nodes.into_iter().for_each(|node| u[node as usize] -= force);
            }
            let mut dp = [0.0; MOST_BANDS];
            dp[..n].copy_from_slice(&numbers[..n]);
            let gradient = flow.gradient(&data.passage, &dp, which);
            return gradient.map_or((), |by| data.add_pressure_gradient(&by, axial, &flow, at, w, g));
        }
        for (meeting, &nodes) in data.meetings(at, &numbers).zip(data.triangles.iter()) {
            let Meeting { area, n: normal, outwards, slope, .. } = meeting;
            let change = match which - n {
                0 => -outwards,
                1 => -outwards * outwards.abs(),
                number => slope * normal[number - 2],
            };
            let force = area.s * (change / 3.0);
            nodes.into_iter().for_each(|node| u[node as usize] -= force);
        }
        let (density, speed) = (axial.air.density[0], axial.speed);
        let by_speed = |by: f64| Weights { m: 0.0, c: by * w.c, k: by * w.k };
        match which - n {
            0 => {
                let [kd, _] = data.damping;
                data.axis.add_speed_gradient(axial, by_speed(kd * density * speed.signum()), g);
                data.axis.add_density_gradient(axial, w.k * kd * speed.abs(), g);
            }
            1 => data.axis.add_density_gradient(axial, w.k * data.damping[1], g),
            number => data.axis.add_along_gradient(number - 2, axial, w, g),
        }
    }

    /// The volume rates of a canopy that fills damp its motion more than anything local.
    fn couples_strongly(&self) -> bool {
        true
    }

    fn for_run(&self, copies: &mut Copies) -> Box<dyn ForceTerm> {
        Box::new(Batch::for_run(self, copies))
    }
}

impl RingsData {
    /// Adds c d(dp_b)/dv + k d(dp_b)/dx, `by` the gradient of dp_b.
    fn add_pressure_gradient(
        &self,
        by: &FlowGradient,
        axial: AxialFlow,
        flow: &Flow,
        at: NodeState<'_>,
        w: Weights,
        g: &mut [Vector3<f64>],
    ) {
        let (density, speed) = (axial.air.density[0], axial.speed);
        let by_speed = by.q * density * speed.abs();
        self.axis.add_speed_gradient(axial, Weights { m: 0.0, c: by_speed * w.c, k: by_speed * w.k }, g);
        let by_density = by.density + by.q * 0.5 * speed * speed.abs();
        self.axis.add_density_gradient(axial, w.k * by_density, g);
        self.stations.add_gradient([at.x, at.v], &flow.area, by, w, g);
    }
}
