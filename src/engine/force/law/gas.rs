//! Gas in a closed volume: one pressure on all triangles around it, which falls as the volume grows.
//!
//! ```text
//! p = p_a (V_a/V)^gamma - p_a along the outer normals,     f_i = p S/3 = p dV/dx_i
//! ```
//! p_a is the absolute pressure outside, V_a the amount of gas as its volume at that pressure: its mass over its
//! density there. gamma is 1 for changes of state at one temperature, and the ratio of the heat capacities without
//! heat. V is what the triangles enclose, and a constant beside it. The energy is the work that the gas can do until it
//! has the pressure outside, with r = ln(V_a/V)
//! ```text
//! U = p_a V_a [(e^((gamma-1) r) - 1)/(gamma-1) + e^-r - 1] >= 0,      -dU/dx_i = f_i
//! dU/dV_a = p_a gamma (e^((gamma-1) r) - 1)/(gamma-1)
//! ```
//! The last is the work by which a pump fills it from the air outside, by amount. The tangent is the geometric
//! stiffness of every triangle, by the volume of the tetrahedron that it makes with a point, and one part of rank one:
//! ```text
//! V = sum x_0 . (x_1 x x_2)/6,      d2V/dx_0 dx_1 = -[x_2]x/6 and so on around
//! -df_i/dx_j = -p d2V/dx_i dx_j + gamma (p + p_a)/V (dV/dx_i)(dV/dx_j)^T      (symmetric)
//! ```
//! Openings are closed by flat covers over rims that are held: the ground takes what pushes on them.

mod mean;

use crate::force::kernel::batch::{Batch, BufferReads, Elements, Kernel, Records, SceneNumbers};
use crate::force::kernel::element_block::{NodeVectors, SceneValues, add, vector};
use crate::force::law::enclosure::Enclosure;
use crate::force::law::series::{Scale, Table};
use crate::force::law::triangle::{AreaVector, THIRD};
use crate::force::{Copies, ForceTerm, MeanForce, NodeState, RankOne, TangentForm, TangentSink};
use crate::model::forces::{Role, Tally};
use crate::model::system::{TermInfo, Weights};
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// The gas in a volume.
pub type Gas = Batch<GasData, 3>;

/// Plain data of a gas and of what is around it.
#[derive(Clone, Debug)]
pub struct GasData {
    /// vertices, right-handed outwards
    pub triangles: Arc<[[u32; 3]]>,
    /// the same, with the rims of their openings
    pub enclosure: Arc<Enclosure>,
    /// \[m^3\] volume beside what the triangles enclose
    pub beside: f64,
    /// its law
    pub law: GasLaw,
    /// \[N/m\] stiffness of each of its nodes at the start, the sum of a row
    pub stiffness: Arc<[(u32, f64)]>,
}

/// Pressure over volume and amount.
#[derive(Clone, Debug)]
pub struct GasLaw {
    /// [Pa] p_a
    pub ambient: f64,
    /// \[-\] gamma
    pub gamma: f64,
    /// \[m^3\] volume at the start
    pub at_start: f64,
    /// what fills it, over time
    pub table: Arc<Table<1>>,
    /// whether the table is the pressure \[Pa\] above p_a in the volume at the start; else the amount \[m^3\]
    pub by_pressure: bool,
    /// \[-\] share of it that is filled in: of the pressure, or of what the amount is above the volume at the start. 1
    /// but for steps of the loads
    pub filled: Arc<Scale>,
}

/// (e^(k r) - 1)/k, r where k is 0.
fn growth(k: f64, r: f64) -> f64 {
    if k == 0.0 { r } else { (k * r).exp_m1() / k }
}

impl GasLaw {
    /// \[m^3\] V_a at time `t` [s].
    pub fn amount(&self, t: f64) -> f64 {
        let ([value], filled) = (self.table.at(t), self.filled.get());
        if self.by_pressure {
            return self.at_start * (1.0 + filled * value / self.ambient).powf(1.0 / self.gamma);
        }
        // Nothing is added to a whole amount, so that it keeps every bit.
        filled * value + (1.0 - filled) * self.at_start
    }

    /// [Pa] p in a volume [m^3].
    pub fn pressure(&self, t: f64, volume: f64) -> f64 {
        self.ambient * (self.gamma * (self.amount(t) / volume).ln()).exp_m1()
    }

    /// [Pa/m^3] -dp/dV
    fn stiffness(&self, t: f64, volume: f64) -> f64 {
        self.gamma * (self.pressure(t, volume) + self.ambient) / volume
    }

    /// [J] U, and [J/m^3] dU/dV_a.
    fn energy(&self, t: f64, volume: f64) -> [f64; 2] {
        let amount = self.amount(t);
        let r = (amount / volume).ln();
        let expansion = growth(self.gamma - 1.0, r);
        [self.ambient * amount * (expansion + (-r).exp_m1()), self.ambient * self.gamma * expansion]
    }

    /// That of another run.
    #[must_use]
    pub(crate) fn for_run(&self, copies: &mut Copies) -> Self {
        GasLaw { table: copies.of(&self.table), filled: copies.of(&self.filled), ..self.clone() }
    }
}

impl GasData {
    /// \[m^3\] V
    fn volume(&self, x: NodeVectors<'_>) -> f64 {
        let Some([first, ..]) = self.triangles.first() else { return self.beside };
        self.beside + self.enclosure.volume(x, x, x.at(*first))[0]
    }

    /// [Pa] p on each of its triangles.
    pub fn pressures<'a>(&'a self, at: NodeState<'a>) -> impl Iterator<Item = f64> + 'a {
        let [pressure, _] = self.pressure_and_volume(at);
        self.triangles.iter().map(move |_| pressure)
    }

    /// [Pa] p and \[m^3\] V in a state.
    pub fn pressure_and_volume(&self, at: NodeState<'_>) -> [f64; 2] {
        let volume = self.volume(NodeVectors::Nodes(at.x));
        [self.law.pressure(at.t, volume), volume]
    }

    /// That of another run.
    #[must_use]
    pub(crate) fn copy(&self, copies: &mut Copies) -> Self {
        GasData { law: self.law.for_run(copies), ..self.clone() }
    }

    /// Adds `by` dV/dx.
    fn add_gradient(&self, x: &[Vector3<f64>], by: f64, g: &mut [Vector3<f64>]) {
        for &nodes in self.triangles.iter() {
            let part = AreaVector::new(x, nodes).s * (by * THIRD);
            nodes.into_iter().for_each(|node| g[node as usize] += part);
        }
    }

    /// Emits -`by` d2V/dx2 at some places of the nodes; nothing where the form is convex.
    fn emit_geometric(
        &self,
        place: impl Fn(u32) -> Vector3<f64>,
        by: f64,
        form: TangentForm,
        sink: &mut dyn TangentSink,
    ) {
        let Some([first, ..]) = self.triangles.first() else { return };
        let (origin, k) = (place(*first), if form.convex { 0.0 } else { by / 6.0 });
        for &nodes in self.triangles.iter() {
            let [x0, x1, x2] = nodes.map(|node| (place(node) - origin) * k);
            let (none, [a, b, c]) = (Matrix3::zeros(), [x0, x1, x2].map(|x| x.cross_matrix()));
            sink.triangle(nodes, &[[none, c, -b], [-c, none, a], [b, -a, none]]);
        }
    }

    /// \[N/m\] Bounds by node on the part of rank one: (g . u)^2 <= sum |g| sum |g_i| |u_i|^2.
    fn row_sums(&self, at: NodeState<'_>) -> impl Iterator<Item = (u32, f64)> {
        let mut g = vec![Vector3::zeros(); at.x.len()];
        self.add_gradient(at.x, 1.0, &mut g);
        let all: f64 = g.iter().map(Vector3::norm).sum();
        let scale = all * self.law.stiffness(at.t, self.volume(NodeVectors::Nodes(at.x)));
        let numbered = (0_u32..).zip(g.into_iter().map(|g| g.norm()));
        numbered.filter(|(_, size)| *size > 0.0).map(move |(node, size)| (node, scale * size))
    }

    /// The same with the stiffness at the start, at the node positions `x` [m].
    #[must_use]
    pub fn stiff_at(self, x: &[Vector3<f64>]) -> Self {
        let stiffness = self.row_sums(NodeState { t: 0.0, x, v: &[] }).collect();
        GasData { stiffness, ..self }
    }
}

impl SceneNumbers for GasData {
    fn count(&self) -> usize {
        1
    }

    /// V [m^3]
    fn find(&self, _: f64, x: NodeVectors<'_>, _: NodeVectors<'_>, out: &mut SceneValues) {
        out[0] = self.volume(x);
    }
}

impl Kernel<3> for GasData {
    const READS: BufferReads = BufferReads { x: true, v: false };

    fn elements(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    fn scene_numbers(&self) -> Option<&dyn SceneNumbers> {
        Some(self)
    }

    /// The energy counts with the first triangle.
    fn add(&self, block: Elements<'_, 3>, f: &mut Records) -> Tally {
        let volume = block.scene_numbers.first().copied().unwrap_or(f64::NAN);
        let share = THIRD * self.law.pressure(block.t, volume);
        for &nodes in block.nodes {
            let force = AreaVector::of(nodes.map(|node| vector(block.x, node))).s * share;
            nodes.into_iter().for_each(|node| add(f, node, force));
        }
        if block.first > 0 {
            return Tally::default();
        }
        let [energy, power] = self.law.energy(block.t, volume);
        Tally { energy, power }
    }

    fn for_run(&self, copies: &mut Copies) -> Option<Self> {
        Some(self.copy(copies))
    }
}

impl ForceTerm for Gas {
    fn parts(&self) -> &[TermInfo] {
        const INFO: TermInfo = TermInfo { on_triangles: true, ..TermInfo::of("gas", Role::Elastic) };
        &[INFO]
    }

    fn symmetric(&self) -> bool {
        true
    }

    /// The geometric stiffness has either sign, so the convex form has none of it.
    fn tangent(&self, at: NodeState<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink) {
        let data = self.kernel();
        let [pressure, _] = data.pressure_and_volume(at);
        data.emit_geometric(|node| at.x[node as usize], w.k * pressure, form, sink);
    }

    fn rank_one(&self, _: usize, at: NodeState<'_>, w: Weights, RankOne { u, g }: RankOne<'_>) {
        let data = self.kernel();
        u.fill(Vector3::zeros());
        g.fill(Vector3::zeros());
        let volume = data.volume(NodeVectors::Nodes(at.x));
        data.add_gradient(at.x, data.law.stiffness(at.t, volume), u);
        data.add_gradient(at.x, w.k, g);
    }

    /// All of the stiffness of a gas against a change of its volume.
    fn couples_strongly(&self) -> bool {
        true
    }

    fn coupling_bound(&self, at: NodeState<'_>, w: Weights, sink: &mut dyn TangentSink) {
        let rows = self.kernel().row_sums(at);
        rows.for_each(|(node, stiffness)| sink.node(node, Matrix3::from_diagonal_element(w.k * stiffness)));
    }

    fn mean(&self) -> Option<&dyn MeanForce> {
        Some(self)
    }

    fn add_stiffness(&self, nodes: &mut [f64]) {
        self.kernel().stiffness.iter().for_each(|(node, stiffness)| nodes[*node as usize] += stiffness);
    }

    fn for_run(&self, copies: &mut Copies) -> Box<dyn ForceTerm> {
        Box::new(Batch::for_run(self, copies))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::spec::Series;

    /// The energy is 0 where the gas has the pressure outside, and its slopes are the pressure and the work of a pump.
    #[test]
    fn the_energy_is_a_potential() {
        for gamma in [1.0, 1.2, 1.4] {
            let at = |amount: f64| {
                let table = Arc::new(Table::new(Series { t: vec![0.0], value: vec![[amount]] }));
                GasLaw { ambient: 9e4, gamma, at_start: 1.0, table, by_pressure: false, filled: Arc::default() }
            };
            assert_eq!(at(3.0).energy(0.0, 3.0), [0.0, 0.0]);
            for (amount, volume) in [(3.0, 2.0), (2.0, 3.0), (1.01, 1.0)] {
                let d = 1e-5;
                let [energy, pumped] = at(amount).energy(0.0, volume);
                let by_volume =
                    (at(amount).energy(0.0, volume - d)[0] - at(amount).energy(0.0, volume + d)[0]) / (2.0 * d);
                let by_amount =
                    (at(amount + d).energy(0.0, volume)[0] - at(amount - d).energy(0.0, volume)[0]) / (2.0 * d);
                let pressure = at(amount).pressure(0.0, volume);
                assert!(energy > 0.0);
                assert!((by_volume - pressure).abs() < 1e-5 * pressure.abs(), "{gamma}: {by_volume} {pressure}");
                assert!((by_amount - pumped).abs() < 1e-5 * pumped.abs(), "{gamma}: {by_amount} {pumped}");
                let expected = 9e4 * ((amount / volume).powf(gamma) - 1.0);
                assert!((pressure - expected).abs() < 1e-9 * expected.abs());
            }
        }
    }
    /// A share of the pressure in the volume at the start, or of the amount above it; nothing changes when all is in.
    #[test]
    fn a_gas_is_filled_in_shares() {
        for (by_pressure, value) in [(true, 700.0), (false, 1.3)] {
            let table = Arc::new(Table::new(Series { t: vec![0.0], value: vec![[value]] }));
            let filled = Arc::new(Scale::default());
            let law = GasLaw { ambient: 9e4, gamma: 1.4, at_start: 1.1, table, by_pressure, filled: filled.clone() };
            let whole = law.amount(0.0);
            for (share, expected) in [(0.0, 0.0), (0.25, 175.0), (1.0, 700.0)] {
                filled.set(share);
                if by_pressure {
                    assert!((law.pressure(0.0, 1.1) - expected).abs() < 1e-9, "{share}");
                } else {
                    assert!((law.amount(0.0) - (1.1 + share * 0.2)).abs() < 1e-15, "{share}");
                }
            }
            assert_eq!(law.amount(0.0).to_bits(), whole.to_bits());
        }
    }
}
