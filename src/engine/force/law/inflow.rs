//! What the air costs that must enter a canopy before it can widen: a loss of pressure at its mouth.
//!
//! ```text
//! u = Vol'/A_m,     p_0 = -k rho u|u|/2
//! ```
//! Vol is the volume of the canopy, A_m the size of the area vector of the skirt's loop, k the loss coefficient. A
//! canopy that widens has less pressure, one that closes more: the air takes the power k rho/2 A_m |u|^3. It is nothing
//! in steady flight. The tangent is
//! ```text
//! dp_0 = -k rho |u| du - k u|u| drho/2,     du = dVol'/A_m - u dA_m/A_m
//! ```

use crate::force::NodeState;
use crate::force::kernel::element_block::NodeVectors;
use crate::force::law::axial_flow::{AxialFlow, CanopyAxis};
use crate::force::law::enclosure::Enclosure;
use crate::model::system::Weights;
use nalgebra::Vector3;
use std::sync::Arc;

/// The mouth of a canopy as a loss of pressure.
#[derive(Clone, Debug)]
pub struct InflowLoss {
    /// cloth and rims
    pub enclosure: Arc<Enclosure>,
    /// which of the rims is the skirt
    pub mouth: usize,
    /// [-] k
    pub coefficient: f64,
}

impl InflowLoss {
    /// [m/s] u, and A_m as a vector [m^2].
    fn speed(&self, x: NodeVectors<'_>, v: NodeVectors<'_>) -> (f64, Vector3<f64>) {
        let opening = self.enclosure.opening(self.mouth, x);
        let [_, rate] = self.enclosure.volume(x, v, Vector3::zeros());
        (rate / opening.norm(), opening)
    }

    /// [Pa] p_0
    pub(super) fn pressure(&self, density: f64, x: NodeVectors<'_>, v: NodeVectors<'_>) -> f64 {
        let (u, _) = self.speed(x, v);
        -0.5 * self.coefficient * density * u * u.abs()
    }

    /// Adds c dp_0/dv + k dp_0/dx.
    pub(super) fn add_gradient(
        &self,
        axis: &CanopyAxis,
        flow: AxialFlow,
        at: NodeState<'_>,
        w: Weights,
        g: &mut [Vector3<f64>],
    ) {
        let (u, opening) = self.speed(NodeVectors::Nodes(at.x), NodeVectors::Nodes(at.v));
        let (size, density) = (opening.norm(), flow.air.density[0]);
        axis.add_density_gradient(flow, -0.5 * self.coefficient * u * u.abs() * w.k, g);
        let by_speed = -self.coefficient * density * u.abs();
        let by_rate = by_speed / size;
        self.enclosure.add_rate_gradient([at.x, at.v], [by_rate * w.c, by_rate * w.k], g);
        let along = opening * (-by_rate * u * w.k / size);
        self.enclosure.add_opening_gradient(self.mouth, at.x, along, g);
    }
}
