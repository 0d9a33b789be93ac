//! The rim of cloth: its boundary edges one after the other around every loop.

use super::Cloth;
use crate::components::components;
use nalgebra::Vector3;

/// A boundary edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct RimEdge {
    /// its nodes in the order of its loop
    pub ends: [u32; 2],
    /// its triangle
    pub triangle: u32,
    /// [m] length
    pub length: f64,
    /// direction from the first end to the second
    pub along: Vector3<f64>,
    /// direction into the triangle, across the edge
    pub inward: Vector3<f64>,
    /// [m] height of the triangle over the edge
    pub height: f64,
    /// number of its loop
    pub of_loop: usize,
    /// [m] way along the loop to its first end
    pub way: f64,
    /// the edges before and after it
    pub beside: [Option<usize>; 2],
}

/// All boundary edges.
pub(super) struct Rim {
    pub edges: Vec<RimEdge>,
    /// [m] length of every loop
    around: Vec<f64>,
    /// the part that every node belongs to; empty if there is one only
    part: Vec<u32>,
}

impl Rim {
    pub(super) fn new(cloth: &Cloth<'_>) -> Self {
        let (mesh, topology) = (cloth.mesh, cloth.topology);
        let (mut edges, mut around): (Vec<RimEdge>, Vec<f64>) = Default::default();
        for (of_loop, rim) in topology.loops().iter().enumerate() {
            let first = edges.len();
            let count = if rim.closed { rim.nodes.len() } else { rim.nodes.len() - 1 };
            let mut way = 0.0;
            for i in 0..count {
                let ends = [rim.nodes[i], rim.nodes[(i + 1) % rim.nodes.len()]];
                let &[triangle] = topology.triangles_at(ends) else { continue };
                let [a, b] = ends.map(|node| mesh.point(node));
                let corners = mesh.triangles[triangle as usize];
                let apex = corners.into_iter().find(|node| !ends.contains(node)).unwrap_or(ends[0]);
                let length = (b - a).norm();
                let along = (b - a) / length;
                let up = mesh.point(apex) - a;
                let inward = up - along * up.dot(&along);
                let height = inward.norm();
                let at = |step: usize| rim.closed.then_some(first + (i + step) % count);
                let beside = [
                    at(count - 1).or((i > 0).then(|| first + i - 1)),
                    at(1).or((i + 1 < count).then_some(first + i + 1)),
                ];
                let inward = inward / height;
                edges.push(RimEdge { ends, triangle, length, along, inward, height, of_loop, way, beside });
                way += length;
            }
            around.push(if rim.closed { way } else { f64::INFINITY });
        }
        let several = topology.components() > 1 && !edges.is_empty();
        let across = mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [a, c]]);
        let pairs = mesh.edges.iter().copied().chain(across);
        let part = if several { components(mesh.nodes.len(), pairs) } else { Vec::new() };
        Rim { edges, around, part }
    }

    /// Whether no edge and no triangle connects two nodes, however far around.
    pub(super) fn are_apart(&self, a: u32, b: u32) -> bool {
        self.part.get(a as usize) != self.part.get(b as usize)
    }

    /// [m] Way along the loop from the first end of an edge to the nearer end of another edge of the loop.
    pub(super) fn way(&self, start: usize, other: usize) -> f64 {
        let (from, other) = (self.edges[start].way, &self.edges[other]);
        let along = [other.way, other.way + other.length].map(|to| {
            let way = (to - from).abs();
            way.min(self.around[other.of_loop] - way)
        });
        along[0].min(along[1]).max(0.0)
    }

    /// [m] Length of the edges around a boundary edge: the longest of it and its neighbours, so that a short one among
    /// long ones does not count.
    pub(super) fn size(&self, edge: usize) -> f64 {
        let one = &self.edges[edge];
        one.beside.iter().flatten().map(|other| self.edges[*other].length).fold(one.length, f64::max)
    }

    /// The edges at the first end of a boundary edge: the one before it, and itself.
    pub(super) fn at_start(&self, edge: usize) -> impl Iterator<Item = usize> {
        self.edges[edge].beside[0].into_iter().chain([edge])
    }
}
