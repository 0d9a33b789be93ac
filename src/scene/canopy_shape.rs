//! Shape and air of a canopy for gauges.

use super::network::{Network, by_node};
use crate::force::kernel::batch::SceneNumber;
use crate::force::kernel::element_block::NodeVectors;
use crate::force::law::canopy::{CanopyData, drag_area};
use crate::model::observables::CANOPY_QUANTITIES;
use crate::model::state::StateRef;
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// A canopy with the loops around its openings, in internal numbers.
#[derive(Debug)]
pub(super) struct CanopyShape {
    data: CanopyData,
    /// closed loops of boundary edges, each turning as the triangles beside it
    loops: Vec<BoundaryOfCanopy>,
}

#[derive(Debug)]
struct BoundaryOfCanopy {
    nodes: Vec<u32>,
    /// whether it has nodes of the skirt
    skirt: bool,
}

impl CanopyShape {
    pub(super) fn new(data: CanopyData) -> Self {
        let loops = closed_loops(&data.triangles).into_iter();
        let skirt = |nodes: &[u32]| nodes.iter().any(|node| data.skirt.contains(node));
        let loops = loops.map(|nodes| BoundaryOfCanopy { skirt: skirt(&nodes), nodes }).collect();
        CanopyShape { data, loops }
    }

    fn values(&self, at: StateRef<'_>) -> [f64; CANOPY_QUANTITIES.len()] {
        let data = &self.data;
        let (x, v) = (NodeVectors::Nodes(by_node(at.x)), NodeVectors::Nodes(by_node(at.v)));
        let flow = data.flow(at.t, x, v);
        let axis = flow.axis;
        let middle = x.mean(&data.skirt);
        let place = |node: u32| x.at(node) - middle;
        let (mut facing, mut closing, mut volume) = (0.0, 0.0, 0.0);
        for (&[a, b, c], dcp) in data.triangles.iter().zip(data.pressure_coefficient.iter()) {
            let [a, b, c] = [a, b, c].map(place);
            let along = -0.5 * (b - a).cross(&(c - a)).dot(&axis);
            facing += along.max(0.0);
            closing += dcp * along;
            volume += a.dot(&b.cross(&c)) / 6.0;
        }
        let mut openings = 0.0;
        for BoundaryOfCanopy { nodes, skirt } in &self.loops {
            let centre = nodes.iter().map(|&node| place(node)).sum::<Vector3<f64>>() / nodes.len() as f64;
            let mut area = Vector3::zeros();
            for (i, &node) in nodes.iter().enumerate() {
                let (a, b) = (place(node), place(nodes[(i + 1) % nodes.len()]));
                area += 0.5 * (a - centre).cross(&(b - centre));
                volume += centre.dot(&b.cross(&a)) / 6.0;
            }
            if !skirt {
                openings += area.dot(&axis);
            }
        }
        let projected = facing + openings.max(0.0);
        let radii = data.skirt.iter().map(|&node| {
            let from = place(node);
            (from - axis.dot(&from) * axis).norm()
        });
        let skirt = 2.0 * radii.sum::<f64>() / data.skirt.len() as f64;
        let area = data.filling.map_or(closing, |filling| drag_area(filling, at.t));
        let drag = data.find(at.t, x, v) * closing;
        [2.0 * (projected / PI).sqrt(), skirt, volume, flow.speed, flow.dynamic_pressure, area, drag]
    }
}

/// The loops of edges that one triangle has alone, each turning as its triangles; chains that do not close are left
/// out.
fn closed_loops(triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let sides = || triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let all: std::collections::BTreeSet<[u32; 2]> = sides().collect();
    let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for [a, b] in sides().filter(|[a, b]| !all.contains(&[*b, *a])) {
        next.entry(a).or_default().push(b);
    }
    let mut loops = Vec::new();
    while let Some(&start) = next.keys().next() {
        let mut nodes = vec![start];
        let mut at = start;
        while let Some(list) = next.get_mut(&at) {
            let Some(to) = list.pop() else { break };
            if list.is_empty() {
                next.remove(&at);
            }
            at = to;
            if at == start {
                break;
            }
            nodes.push(at);
        }
        if at == start && nodes.len() > 2 {
            loops.push(nodes);
        }
    }
    loops
}

impl Network {
    pub(super) fn shape_of_canopy(&self, canopy: usize, at: StateRef<'_>) -> [f64; CANOPY_QUANTITIES.len()] {
        self.canopies.get(canopy).map_or([f64::NAN; CANOPY_QUANTITIES.len()], |canopy| canopy.values(at))
    }
}

#[cfg(test)]
mod tests {
    use super::closed_loops;

    /// A ring of triangles has two loops, which turn against each other; a single triangle has one.
    #[test]
    fn loops_of_a_ring() {
        assert_eq!(closed_loops(&[[4, 7, 5]]), [[4, 7, 5]]);
        let ring: Vec<[u32; 3]> = (0..3)
            .flat_map(|i| {
                let j = (i + 1) % 3;
                [[i, i + 3, j + 3], [i, j + 3, j]]
            })
            .collect();
        let loops = closed_loops(&ring);
        assert_eq!(loops, [vec![0, 2, 1], vec![3, 4, 5]]);
    }
}
