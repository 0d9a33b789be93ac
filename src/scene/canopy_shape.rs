//! Shape and air of a canopy for gauges.

use super::enclosure::Enclosure;
use super::network::{Network, by_node, node_state};
use crate::force::kernel::element_block::NodeVectors;
use crate::force::law::canopy::CanopyData;
use crate::model::observables::CANOPY_QUANTITIES;
use crate::model::state::StateRef;
use nalgebra::Vector3;
use std::f64::consts::PI;
use std::sync::Arc;

/// A canopy with the loops around its openings, in internal numbers.
#[derive(Debug)]
pub(super) struct CanopyShape {
    data: CanopyData,
    enclosure: Arc<Enclosure>,
    /// rims without nodes of the skirt, by their places in the enclosure
    vents: Vec<usize>,
}

impl CanopyShape {
    pub(super) fn new(data: CanopyData, enclosure: Arc<Enclosure>) -> Self {
        let of_skirt = |rim: &[u32]| rim.iter().any(|node| data.skirt.contains(node));
        let vents = (0..enclosure.rims().len()).filter(|&i| !of_skirt(&enclosure.rims()[i])).collect();
        CanopyShape { data, enclosure, vents }
    }

    fn values(&self, at: StateRef<'_>) -> [f64; CANOPY_QUANTITIES.len()] {
        let data = &self.data;
        let (x, v) = (NodeVectors::Nodes(by_node(at.x)), NodeVectors::Nodes(by_node(at.v)));
        let flow = data.flow(at.t, x, v);
        let axis = flow.axis;
        let middle = x.mean(&data.skirt);
        let place = |node: u32| x.at(node) - middle;
        let (mut facing, mut closing) = (0.0, 0.0);
        for (&[a, b, c], dcp) in data.triangles.iter().zip(data.pressure_coefficient.iter()) {
            let [a, b, c] = [a, b, c].map(place);
            let along = -0.5 * (b - a).cross(&(c - a)).dot(&axis);
            facing += along.max(0.0);
            closing += dcp * along;
        }
        let mut openings = 0.0;
        for nodes in self.vents.iter().map(|&i| &self.enclosure.rims()[i]) {
            let centre = nodes.iter().map(|&node| place(node)).sum::<Vector3<f64>>() / nodes.len() as f64;
            for (i, &node) in nodes.iter().enumerate() {
                let (a, b) = (place(node), place(nodes[(i + 1) % nodes.len()]));
                openings += 0.5 * (a - centre).cross(&(b - centre)).dot(&axis);
            }
        }
        let [volume, _] = self.enclosure.volume(node_state(at), middle);
        let projected = facing + openings.max(0.0);
        let radii = data.skirt.iter().map(|&node| {
            let from = place(node);
            (from - axis.dot(&from) * axis).norm()
        });
        let skirt = 2.0 * radii.sum::<f64>() / data.skirt.len() as f64;
        let area = data.drag_area(at.t).unwrap_or(closing);
        let drag = data.drag(node_state(at));
        [2.0 * (projected / PI).sqrt(), skirt, volume, flow.speed, flow.dynamic_pressure, area, drag]
    }
}

impl Network {
    pub(super) fn shape_of_canopy(&self, canopy: usize, at: StateRef<'_>) -> [f64; CANOPY_QUANTITIES.len()] {
        self.canopies.get(canopy).map_or([f64::NAN; CANOPY_QUANTITIES.len()], |canopy| canopy.values(at))
    }
}
