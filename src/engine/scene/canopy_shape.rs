//! Shape and air of a canopy for gauges.

use super::network::{Network, by_node, node_state};
use crate::force::Copies;
use crate::force::kernel::element_block::NodeVectors;
use crate::force::kernel::faces::FaceKernel;
use crate::force::law::canopy::{AirModel, CanopyData};
use crate::force::law::enclosure::Enclosure;
use crate::model::gauge::CANOPY_QUANTITIES;
use crate::model::spec::FillingSpec;
use crate::model::state::StateRef;
use std::f64::consts::PI;
use std::sync::Arc;

/// A canopy with the loops around its openings, in internal numbers.
#[derive(Clone, Debug)]
pub(super) struct CanopyShape {
    data: CanopyData,
    enclosure: Arc<Enclosure>,
    /// rims without nodes of the skirt, by their places in the enclosure
    vents: Vec<usize>,
    /// [m^2] S0
    nominal_area: f64,
}

impl CanopyShape {
    pub(super) fn new(data: CanopyData, enclosure: Arc<Enclosure>, nominal_area: f64) -> Self {
        let of_skirt = |rim: &[u32]| rim.iter().any(|node| data.axis.skirt.contains(node));
        let vents = (0..enclosure.rims().len()).filter(|&i| !of_skirt(&enclosure.rims()[i])).collect();
        CanopyShape { data, enclosure, vents, nominal_area }
    }

    /// That of another run.
    pub(super) fn for_run(&self, copies: &mut Copies) -> Self {
        CanopyShape { data: self.data.for_run(copies), ..self.clone() }
    }

    fn values(&self, at: StateRef<'_>) -> [f64; CANOPY_QUANTITIES.len()] {
        let data = &self.data;
        let (x, v) = (NodeVectors::Nodes(by_node(at.x)), NodeVectors::Nodes(by_node(at.v)));
        let flow = data.axis.flow(at.t, x, v);
        let axis = flow.axis;
        let skirt = &data.axis.skirt;
        let middle = x.mean(skirt);
        let place = |node: u32| x.at(node) - middle;
        let (mut facing, mut closing) = (0.0, 0.0);
        for (&[a, b, c], dcp) in data.triangles.iter().zip(data.pressure_coefficient.iter()) {
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
        let [drag, pressure] = data.drag_and_pressure(node_state(at));
        let q = flow.dynamic_pressure;
        let (area, filled) = match &data.air {
            AirModel::Coefficient => (closing, true),
            AirModel::Filling(stages) => (FillingSpec::area_at(stages, at.t), FillingSpec::half_filled(stages, at.t)),
            AirModel::Cavity(_) => (drag / q, true),
        };
        let across = 2.0 * (projected / PI).sqrt();
        let ratio = across / (4.0 * self.nominal_area / PI).sqrt();
        // Before it fills, its attitude does not matter, and its drag is not that of a stage.
        let [coefficient, lean] = match filled {
            true => [drag / (q * self.nominal_area), (flow.speed / flow.velocity.norm()).acos().to_degrees()],
            false => [f64::NAN; 2],
        };
        [across, mouth, volume, flow.speed, q, area, drag, pressure, ratio, coefficient, lean]
    }
}

impl Network {
    pub(super) fn shape_of_canopy(&self, canopy: usize, at: StateRef<'_>) -> [f64; CANOPY_QUANTITIES.len()] {
        self.acting.canopies.get(canopy).map_or([f64::NAN; CANOPY_QUANTITIES.len()], |canopy| canopy.values(at))
    }
}
