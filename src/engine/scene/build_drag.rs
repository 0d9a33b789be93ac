//! The drag of lines and of bodies at nodes, and canopies that are such bodies.

use super::acting::Added;
use super::apparent::{ApparentMass, Volume};
use super::build::{Builder, filling_times};
use super::point_canopy::{PointCanopy, ShownCanopy};
use crate::force::law::drag::{LineDrag, LineDragData, NodeDrag, NodeDragData};
use crate::force::law::glide::Glide;
use crate::force::law::stages::Stages;
use crate::force::law::stream::Stream;
use crate::model::spec::{CanopySpec, FillingSpec, LineDragSpec, NodeDragSpec};
use std::sync::Arc;

impl Builder<'_> {
    /// A canopy that is a node with a drag area.
    pub(super) fn point_canopy(&mut self, canopy: &CanopySpec, stages: &[FillingSpec], stream: &Arc<Stream>) {
        let Some(node) = canopy.skirt.first().map(|node| self.node(*node)) else { return };
        let (changes, stages) = (filling_times(stages), self.stages(stages));
        if let Some(factor) = canopy.apparent_mass {
            let volume = Volume::Point { nominal_area: canopy.nominal_area, stages: stages.clone() };
            let (stream, term) = (stream.clone(), self.acting.terms.len());
            self.acting.apparent.push(ApparentMass { nodes: [(node, 1.0)].into(), volume, factor, stream, term });
        }
        let glide = canopy.glide.as_ref().map(Glide::new);
        let data = NodeDragData { nodes: [[node]].into(), drag_area: 0.0, stages, glide, stream: stream.clone() };
        let shown = PointCanopy { node, drag: data.clone(), nominal_area: canopy.nominal_area };
        self.acting.canopies.push(ShownCanopy::Point(shown));
        self.acting.add(Added { changes, ..node_drag(data) });
    }

    pub(super) fn drag(&mut self) {
        let Some(stream) = self.acting.stream.clone() else { return };
        for LineDragSpec { edges, diameter, coefficient } in &self.spec.line_drag {
            let ends = |edge: u32| self.spec.mesh.edges[edge as usize].map(|i| self.node(i));
            let mut segments: Vec<[u32; 2]> = edges.iter().map(|&edge| ends(edge)).collect();
            segments.sort_unstable_by_key(|[a, b]| (*a.min(b), *a.max(b)));
            let (segments, width, stream) = (segments.into(), diameter * coefficient, stream.clone());
            self.acting.add(Added::term(LineDrag::new(LineDragData { segments, width, stream })));
        }
        for NodeDragSpec { nodes, drag_area, glide } in &self.spec.node_drag {
            let mut nodes: Vec<[u32; 1]> = nodes.iter().map(|&i| [self.node(i)]).collect();
            nodes.sort_unstable();
            let (nodes, drag_area, stream) = (nodes.into(), *drag_area, stream.clone());
            let (stages, glide) = (Stages::none(), glide.as_ref().map(Glide::new));
            self.acting.add(node_drag(NodeDragData { nodes, drag_area, stages, glide, stream }));
        }
    }
}

/// The drag of nodes, with the heading of those that glide.
fn node_drag(data: NodeDragData) -> Added {
    let heading = data.glide.as_ref().map(|glide| glide.heading().clone());
    Added::term(NodeDrag::new(data)).by(heading)
}
