//! Canopies for gauges: cloth, and points.

use super::canopy_shape::CanopyShape;
use super::network::{Network, by_node, node_state};
use crate::force::Copies;
use crate::force::kernel::batch::Kernel;
use crate::force::law::drag::NodeDragData;
use crate::model::gauge::CANOPY_QUANTITIES;
use crate::model::point::Point;
use crate::model::state::StateRef;
use nalgebra::Vector3;

/// A canopy as gauges see it.
#[derive(Clone, Debug)]
pub(super) enum ShownCanopy {
    /// cloth with a shape
    Cloth(Box<CanopyShape>),
    /// a node with a drag area
    Point(PointCanopy),
}

/// A canopy that is a node, in internal numbers.
#[derive(Clone, Debug)]
pub(super) struct PointCanopy {
    pub node: u32,
    pub drag: NodeDragData,
    /// [m^2] S0
    pub nominal_area: f64,
}

impl ShownCanopy {
    /// That of another run.
    pub(super) fn for_run(&self, copies: &mut Copies) -> Self {
        match self {
            ShownCanopy::Cloth(shape) => ShownCanopy::Cloth(Box::new(shape.for_run(copies))),
            ShownCanopy::Point(point) => {
                let drag = point.drag.for_run(copies).unwrap_or_else(|| point.drag.clone());
                ShownCanopy::Point(PointCanopy { drag, ..point.clone() })
            }
        }
    }
}

impl PointCanopy {
    /// A point has no shape, and its drag is along its motion.
    fn values(&self, at: StateRef<'_>) -> [f64; CANOPY_QUANTITIES.len()] {
        let [x, v] = [at.x, at.v].map(|of| by_node(of)[self.node as usize]);
        let air = self.drag.stream.at(at.t, x.z);
        let speed = (v - air.wind[0]).norm();
        let q = 0.5 * air.density[0] * speed * speed;
        let area = self.drag.stages.area_at(at.t);
        let filled = self.drag.stages.half_filled(at.t);
        let coefficient = if filled { area / self.nominal_area } else { f64::NAN };
        let none = f64::NAN;
        [none, none, none, speed, q, area, q * area, none, none, coefficient, none]
    }
}

impl Network {
    pub(super) fn shape_of_canopy(&self, canopy: usize, at: StateRef<'_>) -> [f64; CANOPY_QUANTITIES.len()] {
        match self.acting.canopies.get(canopy) {
            Some(ShownCanopy::Cloth(shape)) => shape.values(at),
            Some(ShownCanopy::Point(point)) => point.values(at),
            None => [f64::NAN; CANOPY_QUANTITIES.len()],
        }
    }

    /// [N] See [`Air::pull_of_points`](crate::model::abilities::Air::pull_of_points).
    pub(super) fn pull(&self, mass: f64, at: &Point) -> f64 {
        let here = node_state(at.state.as_ref());
        let points = self.acting.canopies.iter().filter_map(|canopy| match canopy {
            ShownCanopy::Point(point) => Some(point),
            ShownCanopy::Cloth(_) => None,
        });
        let (mut force, mut acceleration) = (Vector3::zeros(), Vector3::zeros());
        for PointCanopy { node, drag, .. } in points {
            let node = *node as usize;
            force += drag.force(here.t, here.x[node], here.v[node]);
            acceleration = by_node(&at.forces.total)[node].component_mul(&by_node(&self.phase().inverse_mass)[node]);
        }
        let air = self.acting.apparent.iter().map(|air| air.force(here, acceleration));
        (force + air.sum::<Vector3<f64>>() + mass * (self.gravity() - acceleration)).norm()
    }
}
