//! The pressure in a canopy from the balance of the air that flows through its mouth and its cloth. Experimental: a
//! balance of the volume of the air without its inertia.
//!
//! ```text
//! dp = p_i - Cp q   over the whole canopy,      q = rho V|V|/2,     Cp outside, p_i inside
//! eta V A_m x = Vol' + A w(dp),     p_i = q (1 - x|x|),     dp = alpha w + beta w|w|
//! ```
//! eta is how much of the free stream enters the mouth, A_m the size of the area vector of the skirt's loop, Vol the
//! volume of the canopy, A the area of its cloth, w the speed of the air through it. V x = R is left where V is 0:
//! ```text
//! R = (Vol' + A w)/(eta A_m),     f(w) = alpha w + beta w|w| + rho/2 R|R| - (1 - Cp) q = 0
//! ```
//! f rises strictly, and between w = 0 and R = 0 and on both sides it is a parabola: its root is found in closed form.
//! Cloth that lets no air through has w = 0. The tangent is that of the implicit function:
//! ```text
//! d(dp) = s [(1 - Cp) dq - R|R| drho/2 - rho |R| dR],     1/s = 1 + rho |R| A/(eta A_m (alpha + 2 beta |w|))
//! dR = (dVol' + w dA)/(eta A_m) - R dA_m/A_m   with w held
//! ```

use crate::force::NodeState;
use crate::force::kernel::element_block::NodeVectors;
use crate::force::law::axial_flow::{AxialFlow, CanopyAxis};
use crate::force::law::enclosure::Enclosure;
use crate::force::law::triangle::AreaVector;
use crate::model::spec::CavitySpec;
use crate::model::system::Weights;
use nalgebra::Vector3;
use std::sync::Arc;

/// The air in a canopy with a mouth.
#[derive(Clone, Debug)]
pub struct Cavity {
    /// cloth and rims
    pub enclosure: Arc<Enclosure>,
    /// which of the rims is the skirt
    pub mouth: usize,
    /// coefficients
    pub spec: CavitySpec,
}

/// What the balance depends on.
#[derive(Clone, Copy, Debug)]
struct Mouth {
    /// [Pa] (1 - Cp) q
    drive: f64,
    /// [kg/m^3]
    density: f64,
    /// [m^3/s] Vol'
    rate: f64,
    /// [m^2] A
    cloth: f64,
    /// [m^2] eta A_m
    inlet: f64,
}

/// The air in balance.
#[derive(Clone, Copy, Debug)]
struct Balance {
    /// [Pa] dp
    pressure: f64,
    /// [m/s] w
    through: f64,
    /// [m/s] R
    inflow: f64,
    /// [-] s
    share: f64,
}

impl Mouth {
    fn balance(self, cloth: Option<[f64; 2]>) -> Balance {
        let Mouth { drive, density, rate, inlet, .. } = self;
        let Some(law) = cloth else {
            let inflow = rate / inlet;
            let pressure = drive - 0.5 * density * inflow * inflow.abs();
            return Balance { pressure, through: 0.0, inflow, share: 1.0 };
        };
        let ([w, inflow], [linear, quadratic]) = (self.root(law), law);
        let slope = linear + 2.0 * quadratic * w.abs();
        let braking = density * inflow.abs() * self.cloth / inlet;
        let share = if slope > 0.0 { slope / (slope + braking) } else { 0.0 };
        Balance { pressure: (linear + quadratic * w.abs()) * w, through: w, inflow, share }
    }

    /// [m/s] The root w of f, and R there. They are found from the nearer of w = 0 and R = 0, so that neither is a
    /// difference of large numbers.
    fn root(self, [linear, quadratic]: [f64; 2]) -> [f64; 2] {
        let Mouth { drive, density, rate, cloth, inlet } = self;
        let k = 0.5 * density / inlet.powi(2);
        let value = |w: f64, flow: f64| (linear + quadratic * w.abs()) * w + k * flow * flow.abs() - drive;
        let closed = -rate / cloth;
        let [f_tight, f_closed] = [value(0.0, rate), value(closed, 0.0)];
        let between = (f_tight > 0.0) != (f_closed > 0.0);
        let from_closed = if between {
            (value(0.5 * closed, 0.5 * rate) > 0.0) == (f_tight > 0.0)
        } else {
            f_closed.abs() < f_tight.abs()
        };
        let (from, f, df) = if from_closed {
            (closed, f_closed, linear + 2.0 * quadratic * closed.abs())
        } else {
            (0.0, f_tight, linear + 2.0 * k * cloth * rate.abs())
        };
        // The signs of w and R beside this end, on the way to the root.
        let beyond = if f > 0.0 { -1.0 } else { 1.0 };
        let [sign_w, sign_r] = if between { [closed.signum(), rate.signum()] } else { [beyond; 2] };
        let bend = quadratic * sign_w + k * cloth * cloth * sign_r;
        // f + df d + bend d^2 = 0, in the form without a difference of large numbers; rounding alone makes it negative.
        let slope = (df * df - 4.0 * bend * f).max(0.0).sqrt();
        let d = if f == 0.0 { 0.0 } else { -2.0 * f / (df + slope) };
        let inflow = if from_closed { cloth * d } else { rate + cloth * d };
        [from + d, inflow / inlet]
    }
}

impl Cavity {
    fn cloth(&self) -> Option<[f64; 2]> {
        self.spec.cloth.map(|law| [law.linear, law.quadratic])
    }

    fn mouth(
        &self,
        triangles: &[[u32; 3]],
        flow: AxialFlow,
        x: NodeVectors<'_>,
        v: NodeVectors<'_>,
    ) -> (Mouth, Vector3<f64>) {
        let opening = self.enclosure.opening(self.mouth, x);
        let [_, rate] = self.enclosure.volume(x, v, Vector3::zeros());
        let cloth = triangles.iter().map(|nodes| AreaVector::of(nodes.map(|node| x.at(node))).s.norm()).sum();
        let drive = (1.0 - self.spec.outer_pressure_coefficient) * flow.dynamic_pressure;
        let inlet = self.spec.inflow * opening.norm();
        (Mouth { drive, density: flow.air.density[0], rate, cloth, inlet }, opening)
    }

    /// [Pa] dp - q, what the pressure has beyond that of the stream on a wall.
    pub(super) fn excess(
        &self,
        triangles: &[[u32; 3]],
        flow: AxialFlow,
        x: NodeVectors<'_>,
        v: NodeVectors<'_>,
    ) -> f64 {
        self.mouth(triangles, flow, x, v).0.balance(self.cloth()).pressure - flow.dynamic_pressure
    }

    /// Adds c d(dp - q)/dv + k d(dp - q)/dx.
    pub(super) fn add_excess_gradient(
        &self,
        triangles: &[[u32; 3]],
        axis: &CanopyAxis,
        at: NodeState<'_>,
        w: Weights,
        g: &mut [Vector3<f64>],
    ) {
        let (x, v) = (NodeVectors::Nodes(at.x), NodeVectors::Nodes(at.v));
        let flow = axis.flow(at.t, x, v);
        let (mouth, opening) = self.mouth(triangles, flow, x, v);
        let Balance { through, inflow, share, .. } = mouth.balance(self.cloth());
        let AxialFlow { speed, air, .. } = flow;
        let by_q = share * (1.0 - self.spec.outer_pressure_coefficient) - 1.0;
        let by_speed = by_q * air.density[0] * speed.abs();
        axis.add_speed_gradient(flow, Weights { m: 0.0, c: by_speed * w.c, k: by_speed * w.k }, g);
        let by_density = 0.5 * (by_q * speed * speed.abs() - share * inflow * inflow.abs());
        axis.add_density_gradient(flow, w.k * by_density, g);
        let by_inflow = -share * air.density[0] * inflow.abs();
        let by_rate = by_inflow / mouth.inlet;
        self.enclosure.add_rate_gradient([at.x, at.v], [by_rate * w.c, by_rate * w.k], g);
        let size = opening.norm();
        let along = opening * (-by_inflow * inflow * w.k / (size * size));
        self.enclosure.add_opening_gradient(self.mouth, at.x, along, g);
        if through != 0.0 {
            add_area_gradient(triangles, at.x, by_rate * through * w.k, g);
        }
    }
}

/// Adds `by` times the gradient of the area of some triangles.
fn add_area_gradient(triangles: &[[u32; 3]], x: &[Vector3<f64>], by: f64, g: &mut [Vector3<f64>]) {
    for &nodes in triangles {
        let area = AreaVector::new(x, nodes);
        let size = area.s.norm();
        let n = if size > 0.0 { area.s / size } else { Vector3::zeros() };
        for (j, node) in nodes.into_iter().enumerate() {
            g[node as usize] += by * (area.derivative(j).transpose() * n);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The closed form is a root to rounding, in every piece and with either coefficient alone; a bisection in the test
    /// finds the same.
    #[test]
    fn the_closed_form_is_the_root() {
        let numbers = [-300.0, -7.0, -1e-3, 0.0, 2e-4, 0.9, 250.0];
        let laws = [[160.0, 48.0], [1e7, 0.0], [0.0, 3.0], [1e-3, 1e-9]];
        let mut found = 0;
        for (drive, rate) in numbers.into_iter().flat_map(|a| numbers.map(|b| (a, b))) {
            for ([linear, quadratic], inlet) in laws.into_iter().flat_map(|law| [1e-3, 0.4, 30.0].map(|m| (law, m))) {
                let mouth = Mouth { drive, density: 1.2, rate, cloth: 57.0, inlet };
                let terms = |w: f64| {
                    let r = (rate + 57.0 * w) / inlet;
                    [linear * w, quadratic * w * w.abs(), 0.6 * r * r.abs(), -drive]
                };
                let f = |w: f64| terms(w).iter().sum::<f64>();
                let (mut low, mut high) = (-1e9, 1e9);
                for _ in 0..200 {
                    let middle = 0.5 * (low + high);
                    if f(middle) > 0.0 { high = middle } else { low = middle }
                }
                let balance = mouth.balance(Some([linear, quadratic]));
                // In the smallest slope, that at the root of pure squares, rounding moves the root by its square root.
                let flat = linear == 0.0;
                let reach = if flat { 1e-7 } else { 1e-13 } * (1.0 + low.abs().max(rate.abs() / 57.0));
                assert!((balance.through - low).abs() <= reach, "{mouth:?}, {linear} {quadratic}: {balance:?} {low}");
                let size = terms(balance.through).iter().map(|t| t.abs()).sum::<f64>();
                let (dp, r) = (balance.pressure, balance.inflow);
                assert!((dp - drive + 0.6 * r * r.abs()).abs() <= 1e-11 * size, "{mouth:?}: {balance:?}");
                assert!((0.0..=1.0).contains(&balance.share));
                found += 1;
            }
        }
        assert_eq!(found, 588);
    }

    /// The share is the slope of the root over the drive.
    #[test]
    fn the_share_is_a_slope() {
        for (rate, law) in [(3.0, [160.0, 48.0]), (-4.0, [90.0, 5.0]), (0.0, [10.0, 20.0])] {
            let at = |drive: f64| Mouth { drive, density: 1.2, rate, cloth: 57.0, inlet: 4.0 }.balance(Some(law));
            let slope = (at(50.0 + 1e-4).pressure - at(50.0 - 1e-4).pressure) / 2e-4;
            assert!((slope - at(50.0).share).abs() < 1e-7, "{slope} {:?}", at(50.0));
        }
    }
}
