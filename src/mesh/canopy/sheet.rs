//! The triangles of a canopy: their boundary, the arc length over them, their area and their openings.

use super::CanopyError;
use crate::adjacency::row_starts;
use crate::topology::unique_edges;
use crate::{BoundaryLoop, Group, Mesh, MeshError, Topology};
use nalgebra::Vector3;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap, HashMap};

/// Triangles that turn the same way, at most two at an edge.
pub(super) struct Sheet<'a> {
    /// the mesh that they are part of
    whole: &'a Mesh,
    /// [m^2] area of its triangles
    area: f64,
    /// the triangles alone, with all nodes
    mesh: Mesh,
    topology: Topology,
    /// number of triangles at each of their sides, the smaller node first
    sides: HashMap<[u32; 2], usize>,
    /// by node: whether some triangle has it
    has: Vec<bool>,
}

impl<'a> Sheet<'a> {
    pub(super) fn new(whole: &'a Mesh, triangles: &[u32]) -> Result<Self, CanopyError> {
        let corners = triangles.iter().filter_map(|&t| whole.triangles.get(t as usize)).copied().collect();
        let mesh = Mesh { nodes: whole.nodes.clone(), triangles: corners, ..Mesh::default() };
        let number = |triangle: u32| triangles.get(triangle as usize).copied().unwrap_or(triangle);
        let checked = Topology::new(&mesh).and_then(|topology| {
            topology.check_manifold()?;
            topology.check_orientation(&mesh)?;
            Ok(topology)
        });
        let topology = checked.map_err(|error| match error {
            MeshError::Orientation { first, second, a, b } => {
                CanopyError::Orientation { first: number(first), second: number(second), a, b }
            }
            MeshError::NonManifold { triangles, a, b } => CanopyError::Branching { a, b, triangles },
            other => CanopyError::Mesh(other),
        })?;
        let mut has = vec![false; mesh.nodes.len()];
        let mut sides = HashMap::new();
        for &[a, b, c] in &mesh.triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                has[from as usize] = true;
                *sides.entry([from.min(to), from.max(to)]).or_insert(0) += 1;
            }
        }
        let area = Group { triangles: triangles.to_vec(), ..Group::default() }.area(whole);
        Ok(Sheet { whole, area, mesh, topology, sides, has })
    }

    /// Whether a triangle has this node.
    pub(super) fn has(&self, node: u32) -> bool {
        self.has.get(node as usize).copied().unwrap_or_default()
    }

    /// Number of triangles at an edge.
    pub(super) fn triangles_at(&self, [a, b]: [u32; 2]) -> usize {
        self.sides.get(&[a.min(b), a.max(b)]).copied().unwrap_or_default()
    }

    fn point(&self, node: u32) -> Vector3<f64> {
        self.mesh.point(node)
    }

    /// The nodes of the one outer boundary.
    pub(super) fn outer_boundary(&self) -> Result<&[u32], CanopyError> {
        let outer: Vec<&BoundaryLoop> = self.topology.loops().iter().filter(|l| l.outer).collect();
        match outer.as_slice() {
            [one] => closed(one),
            [] => Err(CanopyError::Closed),
            sheets => Err(CanopyError::Sheets { sheets: sheets.len() }),
        }
    }

    /// The closed loop of the boundary that has all these nodes.
    pub(super) fn loop_through(&self, nodes: &[u32]) -> Result<&[u32], CanopyError> {
        let first = nodes.first().copied().unwrap_or_default();
        let with = |node: u32| self.topology.loops().iter().find(|l| l.nodes.contains(&node));
        let one = with(first).ok_or(CanopyError::OffSkirt { node: first })?;
        let around = closed(one)?;
        let on_it: std::collections::HashSet<u32> = around.iter().copied().collect();
        match nodes.iter().find(|node| !on_it.contains(node)) {
            Some(&node) => Err(CanopyError::OffSkirt { node }),
            None => Ok(around),
        }
    }

    /// Edges of the whole mesh that join nodes of the sheet.
    fn edges_within(&self) -> impl Iterator<Item = [u32; 2]> {
        self.whole.edges.iter().copied().filter(|[a, b]| self.has(*a) && self.has(*b))
    }

    /// [m] Lengths of the shortest paths along edges from some nodes, with a length of its own at each; infinite where
    /// no path leads. Edges of the mesh that join nodes of the canopy are paths too.
    fn distances(&self, from: &[(u32, f64)]) -> Vec<f64> {
        let edges = self.edges_within().chain(unique_edges(&self.mesh.triangles));
        let mut ways: Vec<[u32; 2]> = edges.flat_map(|[a, b]| [[a, b], [b, a]]).collect();
        ways.sort_unstable();
        ways.dedup();
        let start = row_starts(self.has.len(), ways.iter().map(|[a, _]| *a));
        let mut distance = vec![f64::INFINITY; self.has.len()];
        // Distances are positive, so their bits are in their order.
        let mut next = BinaryHeap::new();
        for &(node, d) in from {
            distance[node as usize] = d;
            next.push(Reverse((d.to_bits(), node)));
        }
        while let Some(Reverse((bits, node))) = next.pop() {
            let d = f64::from_bits(bits);
            if d > distance[node as usize] {
                continue;
            }
            for [_, other] in &ways[start[node as usize] as usize..start[node as usize + 1] as usize] {
                let to = d + (self.point(*other) - self.point(node)).norm();
                if to < distance[*other as usize] {
                    distance[*other as usize] = to;
                    next.push(Reverse((to.to_bits(), *other)));
                }
            }
        }
        distance
    }

    /// The nodes of the apex and the arc length over the sheet by node, from 0 there to 1 at the skirt, whose loop is
    /// `around`. The apex is the middle of the vent on which the node is that is farthest from the skirt; else the
    /// first of the rows, where they are known, or that node.
    pub(super) fn arc_lengths(&self, skirt: &[u32], around: &[u32]) -> Result<(Vec<u32>, Vec<f64>), CanopyError> {
        let from_skirt = self.distances(&skirt.iter().map(|&node| (node, 0.0)).collect::<Vec<_>>());
        let nodes = || (0_u32..).zip(&self.has).filter(|(_, has)| **has).map(|(node, _)| node);
        let far = |node: &u32| from_skirt[*node as usize];
        if let Some(node) = nodes().find(|node| far(node).is_infinite()) {
            return Err(CanopyError::Apart { node });
        }
        let farthest = nodes().max_by(|a, b| far(a).total_cmp(&far(b)).then(b.cmp(a))).unwrap_or_default();
        let vent = self.topology.loops().iter().map(|l| &l.nodes).find(|nodes| nodes.contains(&farthest));
        let vent = vent.filter(|nodes| !nodes.iter().any(|node| around.contains(node)));
        // Along edges another node than the apex of a triangle may be farther.
        let row = self.whole.rows.iter().find(|row| row.iter().all(|node| self.has(*node)));
        let apex = vent.or(row).cloned().unwrap_or_else(|| vec![farthest]);
        let middle = self.middle(&apex);
        let from: Vec<(u32, f64)> = apex.iter().map(|&node| (node, (self.point(node) - middle).norm())).collect();
        let from_apex = self.distances(&from);
        let place = from_apex.iter().zip(&from_skirt).map(|(a, s)| if a + s > 0.0 { a / (a + s) } else { 0.0 });
        Ok((apex, place.collect()))
    }

    fn middle(&self, nodes: &[u32]) -> Vector3<f64> {
        nodes.iter().map(|&node| self.point(node)).sum::<Vector3<f64>>() / nodes.len() as f64
    }

    /// [m^2] Area of the triangles.
    pub(super) fn cloth_area(&self) -> f64 {
        self.area
    }

    /// [m] The longest side of a triangle.
    pub(super) fn longest_edge(&self) -> f64 {
        self.sides.keys().map(|[a, b]| (self.point(*a) - self.point(*b)).norm()).fold(0.0, f64::max)
    }

    /// [m^2] Area of the gaps between parts of the sheet, and of flat covers of its vents. A gap lies between two loops
    /// that edges join, such as radial tapes; a vent is any other loop but the skirt's, which is `around`.
    pub(super) fn openings(&self, around: &[u32]) -> [f64; 2] {
        let loops = self.topology.loops();
        let mut on: HashMap<u32, (usize, usize)> = HashMap::new();
        for (number, one) in loops.iter().enumerate() {
            for (i, node) in one.nodes.iter().enumerate() {
                on.entry(*node).or_insert((number, i));
            }
        }
        // The joining edges of each pair of loops, by their place on the first.
        let mut joined: BTreeMap<[usize; 2], Vec<(usize, [u32; 2])>> = BTreeMap::new();
        for edge in self.edges_within().filter(|edge| self.triangles_at(*edge) == 0) {
            let [Some(&from), Some(&to)] = edge.map(|node| on.get(&node)) else { continue };
            let [a, b] = edge;
            match from.0.cmp(&to.0) {
                std::cmp::Ordering::Less => joined.entry([from.0, to.0]).or_default().push((from.1, [a, b])),
                std::cmp::Ordering::Greater => joined.entry([to.0, from.0]).or_default().push((to.1, [b, a])),
                std::cmp::Ordering::Equal => {}
            }
        }
        let mut gaps = 0.0;
        for edges in joined.values_mut() {
            edges.sort_unstable();
            let next = edges.iter().skip(1).chain(edges.first());
            gaps += edges.iter().zip(next).map(|((_, [a, b]), (_, [d, c]))| self.quad([*a, *b, *c, *d])).sum::<f64>();
        }
        let at_gap = |number: usize| joined.keys().any(|pair| pair.contains(&number));
        let skirt = around.first();
        let vents = loops
            .iter()
            .enumerate()
            .filter(|(number, one)| !at_gap(*number) && !skirt.is_some_and(|node| one.nodes.contains(node)));
        [gaps, vents.map(|(_, one)| self.cover(&one.nodes)).sum()]
    }

    /// [m^2] Area of a flat quadrilateral.
    fn quad(&self, nodes: [u32; 4]) -> f64 {
        let [a, b, c, d] = nodes.map(|node| self.point(node));
        0.5 * (c - a).cross(&(d - b)).norm()
    }

    /// [m^2] Area of a fan about the middle of a loop.
    fn cover(&self, nodes: &[u32]) -> f64 {
        let middle = self.middle(nodes);
        let sides = nodes.iter().zip(nodes.iter().cycle().skip(1));
        let arm = |node: &u32| self.point(*node) - middle;
        sides.map(|(a, b)| 0.5 * arm(a).cross(&arm(b)).norm()).sum()
    }
}

/// The nodes of a loop that is closed.
fn closed(one: &BoundaryLoop) -> Result<&[u32], CanopyError> {
    match (one.closed, one.nodes.first()) {
        (true, _) => Ok(&one.nodes),
        (false, node) => Err(CanopyError::OpenSkirt { node: node.copied().unwrap_or_default(), edges: 1 }),
    }
}
