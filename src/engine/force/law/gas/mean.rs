//! The mean force of a gas over a step, whose work is what its energy loses.
//!
//! ```text
//! f = p G,     G = integral of dV/dx along the way,     G . (x_1 - x_0) = V_1 - V_0
//! p = (U(V_0) - U(V_1))/(V_1 - V_0) = p_a [(V_a/V_0)^gamma phi - 1],     L = ln(V_1/V_0)
//! phi = (1 - e^((1-gamma) L))/((gamma-1)(e^L - 1)),      1 where L is 0
//! ```
//! dV/dx is quadratic in x, so that G is dV/dx in the middle and a twelfth of that of the change x_1 - x_0. The amount
//! is that in the middle. With a middle that moves while x_0 stays, and g_1 = dV/dx at x_1,
//! ```text
//! -df/dx = -p d2V/dx2 at x + (x_1 - x_0)/6  -  2 dp/dV_1 G g_1^T      (of rank one, not symmetric)
//! dp/dV_1 = (p(V_1) - p)/(V_1 - V_0)
//! ```
//! With dissipation chi, chi/2 (p(V_1) - p(V_0)) is added to p, which never gives energy, as p falls with V.

use super::{Gas, GasData, GasLaw, growth};
use crate::force::law::triangle::{AreaVector, THIRD};
use crate::force::{MeanForce, MeanStep, NodeState, RankOne, TangentForm, TangentSink};
use crate::model::forces::Tally;
use crate::model::system::{StepMean, Weights};
use nalgebra::Vector3;

/// [-] Logarithm of a change of the volume below which slopes are those of a series.
const STILL: f64 = 1e-4;

/// Volumes of a step.
#[derive(Clone, Copy, Debug)]
struct Way {
    /// \[s\] time of its middle
    t: f64,
    /// \[m^3\] V_0 and V_1
    ends: [f64; 2],
    chi: f64,
}

impl GasLaw {
    /// [Pa] p, and \[Pa/m^3\] dp/dV_1.
    fn mean_pressure(&self, Way { t, ends: [start, end], chi }: Way) -> [f64; 2] {
        let way = (end / start).ln();
        let phi = if way == 0.0 { 1.0 } else { growth(1.0 - self.gamma, way) / growth(1.0, way) };
        let absolute = self.ambient * (self.amount(t) / start).powf(self.gamma);
        let mean = absolute * phi - self.ambient;
        let [before, after] = [start, end].map(|volume| self.pressure(t, volume));
        let slope = if way.abs() < STILL {
            let stiffness = self.stiffness(t, start);
            stiffness * ((self.gamma + 1.0) / 3.0 * (end / start - 1.0) - 0.5)
        } else {
            (after - mean) / (end - start)
        };
        [mean + 0.5 * chi * (after - before), slope - 0.5 * chi * self.stiffness(t, end)]
    }
}

impl GasData {
    fn way(&self, MeanStep { at: NodeState { t, x, v }, mean: StepMean { half, dissipation } }: MeanStep<'_>) -> Way {
        let Some([first, ..]) = self.triangles.first() else { return Way { t, ends: [self.beside; 2], chi: 0.0 } };
        let ends = [-half, half].map(|by| {
            let place = |node: u32| x[node as usize] + v[node as usize] * by;
            self.beside + self.enclosure.volume_of(place, place(*first))
        });
        Way { t, ends, chi: dissipation }
    }

    /// Adds `by` G.
    fn add_mean_gradient(&self, MeanStep { at, mean }: MeanStep<'_>, by: f64, g: &mut [Vector3<f64>]) {
        // The area vector of twice `half` v.
        let of_change = 4.0 * mean.half * mean.half / 12.0;
        for &nodes in self.triangles.iter() {
            let [middle, rate] = [at.x, at.v].map(|of| AreaVector::new(of, nodes).s);
            let part = (middle + rate * of_change) * (by * THIRD);
            nodes.into_iter().for_each(|node| g[node as usize] += part);
        }
    }
}

impl MeanForce for Gas {
    fn add_mean(&self, step: MeanStep<'_>, f: &mut [Vector3<f64>]) -> Tally {
        let data = self.kernel();
        let way = data.way(step);
        let [pressure, _] = data.law.mean_pressure(way);
        data.add_mean_gradient(step, pressure, f);
        let [_, power] = data.law.energy(way.t, 0.5 * (way.ends[0] + way.ends[1]));
        Tally { energy: 0.0, power }
    }

    fn mean_tangent(&self, step: MeanStep<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink) {
        let data = self.kernel();
        let [pressure, _] = data.law.mean_pressure(data.way(step));
        let (NodeState { x, v, .. }, by) = (step.at, step.mean.half / 3.0);
        data.emit_geometric(|node| x[node as usize] + v[node as usize] * by, w.k * pressure, form, sink);
    }

    fn mean_rank_one(&self, _: usize, step: MeanStep<'_>, w: Weights, RankOne { u, g }: RankOne<'_>) {
        let data = self.kernel();
        u.fill(Vector3::zeros());
        g.fill(Vector3::zeros());
        let [_, slope] = data.law.mean_pressure(data.way(step));
        data.add_mean_gradient(step, -2.0 * slope, u);
        let NodeState { x, v, .. } = step.at;
        for &nodes in data.triangles.iter() {
            let corners = nodes.map(|node| x[node as usize] + v[node as usize] * step.mean.half);
            let part = AreaVector::of(corners).s * (w.k * THIRD);
            nodes.into_iter().for_each(|node| g[node as usize] += part);
        }
    }
}
