//! Shape and air of a canopy for gauges.

use super::network::{by_node, node_state};
use crate::force::kernel::batch::Kernel;
use crate::force::kernel::element_block::NodeVectors;
use crate::force::kernel::faces::FaceKernel;
use crate::force::law::axial_flow::CanopyAxis;
use crate::force::law::canopy::{AirModel, CanopyData};
use crate::force::law::enclosure::Enclosure;
use crate::force::law::rings::RingsData;
use crate::force::law::triangle::AreaVector;
use crate::force::{Copies, NodeState};
use crate::model::gauge::CANOPY_QUANTITIES;
use crate::model::state::StateRef;
use nalgebra::Vector3;
use std::f64::consts::PI;
use std::sync::Arc;

/// [-] Dp/D0 from which a canopy counts as filled; flat canopies end at 0.64 to 0.70.
const FULL: f64 = 0.5;

/// What fills a canopy.
#[derive(Clone, Debug)]
pub(super) enum CanopyLaw {
    /// one pressure
    Canopy(CanopyData),
    /// the pressure ring by ring
    Rings(RingsData),
}

impl CanopyLaw {
    fn axis(&self) -> &CanopyAxis {
        match self {
            CanopyLaw::Canopy(data) => &data.axis,
            CanopyLaw::Rings(data) => &data.axis,
        }
    }

    /// Triangles, and the dCp of each.
    fn triangles(&self) -> impl Iterator<Item = ([u32; 3], f64)> {
        let (triangles, coefficients) = match self {
            CanopyLaw::Canopy(data) => (&data.triangles, &data.pressure_coefficient[..]),
            CanopyLaw::Rings(data) => (&data.triangles, &[][..]),
        };
        triangles.iter().enumerate().map(|(i, nodes)| (*nodes, coefficients.get(i).copied().unwrap_or(1.0)))
    }

    /// The force of the air along the axis [N], towards the apex, and the mean of the pressure over the cloth [Pa].
    fn drag_and_pressure(&self, at: NodeState<'_>, axis: Vector3<f64>) -> [f64; 2] {
        match self {
            CanopyLaw::Canopy(data) => drag_and_pressure(&data.triangles, data.pressures(at), at, axis),
            CanopyLaw::Rings(data) => drag_and_pressure(&data.triangles, data.pressures(at), at, axis),
        }
    }

    fn for_run(&self, copies: &mut Copies) -> Self {
        match self {
            CanopyLaw::Canopy(data) => CanopyLaw::Canopy(data.for_run(copies)),
            CanopyLaw::Rings(data) => CanopyLaw::Rings(data.for_run(copies).unwrap_or_else(|| data.clone())),
        }
    }
}

fn drag_and_pressure(
    triangles: &[[u32; 3]],
    pressures: impl IntoIterator<Item = f64>,
    at: NodeState<'_>,
    axis: Vector3<f64>,
) -> [f64; 2] {
    let (mut drag, mut sum, mut cloth) = (0.0, 0.0, 0.0);
    for (&nodes, pressure) in triangles.iter().zip(pressures) {
        let area = AreaVector::new(at.x, nodes).s;
        drag -= pressure * area.dot(&axis);
        sum += pressure * area.norm();
        cloth += area.norm();
    }
    [drag, sum / cloth]
}

/// A canopy with the loops around its openings, in internal numbers.
#[derive(Clone, Debug)]
pub(super) struct CanopyShape {
    law: CanopyLaw,
    enclosure: Arc<Enclosure>,
    /// rims without nodes of the skirt, by their places in the enclosure
    vents: Vec<usize>,
    /// [m^2] S0
    nominal_area: f64,
}

impl CanopyShape {
    pub(super) fn new(law: CanopyLaw, enclosure: Arc<Enclosure>, nominal_area: f64) -> Self {
        let of_skirt = |rim: &[u32]| rim.iter().any(|node| law.axis().skirt.contains(node));
        let vents = (0..enclosure.rims().len()).filter(|&i| !of_skirt(&enclosure.rims()[i])).collect();
        CanopyShape { law, enclosure, vents, nominal_area }
    }

    /// That of another run.
    pub(super) fn for_run(&self, copies: &mut Copies) -> Self {
        CanopyShape { law: self.law.for_run(copies), ..self.clone() }
    }

    pub(super) fn values(&self, at: StateRef<'_>) -> [f64; CANOPY_QUANTITIES.len()] {
        let (x, v) = (NodeVectors::Nodes(by_node(at.x)), NodeVectors::Nodes(by_node(at.v)));
        let flow = self.law.axis().flow(at.t, x, v);
        let axis = flow.axis;
        let skirt = &self.law.axis().skirt;
        let middle = x.mean(skirt);
        let place = |node: u32| x.at(node) - middle;
        let (mut facing, mut closing) = (0.0, 0.0);
        for ([a, b, c], dcp) in self.law.triangles() {
            let [a, b, c] = [a, b, c].map(place);
            let along = -0.5 * (b - a).cross(&(c - a)).dot(&axis);
            facing += along.max(0.0);
            closing += dcp * along;
        }
        let openings: f64 = self.vents.iter().map(|&rim| self.enclosure.opening(rim, x).dot(&axis)).sum();
        let [volume, _] = self.enclosure.volume(x, v, middle);
        let projected = facing + openings.max(0.0);
        let radii = skirt.iter().map(|&node| {
            let from = place(node);
            (from - axis.dot(&from) * axis).norm()
        });
        let mouth = 2.0 * radii.sum::<f64>() / skirt.len() as f64;
        let [drag, pressure] = self.law.drag_and_pressure(node_state(at), axis);
        let q = flow.dynamic_pressure;
        let across = 2.0 * (projected / PI).sqrt();
        let ratio = across / (4.0 * self.nominal_area / PI).sqrt();
        let (area, filled) = match &self.law {
            CanopyLaw::Canopy(CanopyData { air: AirModel::Coefficient, .. }) => (closing, true),
            CanopyLaw::Canopy(CanopyData { air: AirModel::Filling(stages), .. }) => {
                (stages.area_at(at.t), stages.half_filled(at.t))
            }
            CanopyLaw::Canopy(CanopyData { air: AirModel::Cavity(_), .. }) => (drag / q, true),
            CanopyLaw::Rings(_) => (drag / q, ratio >= FULL),
        };
        // Before it fills, its attitude does not matter, and its drag is not that of a stage.
        let [coefficient, lean] = match filled {
            true => [drag / (q * self.nominal_area), (flow.speed / flow.velocity.norm()).acos().to_degrees()],
            false => [f64::NAN; 2],
        };
        [across, mouth, volume, flow.speed, q, area, drag, pressure, ratio, coefficient, lean]
    }
}
