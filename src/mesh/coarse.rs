//! The start of a large mesh: a relaxed mesh of a quarter of its nodes, with halved edges.
//!
//! The relaxation moves a defect of the mesh by about an edge in an iteration, so a finer mesh needs more of them. A
//! mesh with edges twice as long has a quarter of the defects, and the nodes that halving its edges adds are even from
//! the start. A. Brandt's nested iteration (Mathematics of Computation 31, 1977), for meshes.

use super::distmesh::{CLEARANCE, kept_clear};
use super::layout::{Freedom, Layout, MeshPlan, ROUND_ENOUGH};
use super::sdf::SizeFunction;
use super::sides::{edge_keys, unique_edges};
use nalgebra::Vector2;

/// Edges from loop to loop of a coarse mesh. In a thinner one the rows that halving makes do not fit between the loops,
/// and many iterations mend that less well than a start without it.
const LEAST_ACROSS: f64 = 16.0;

/// Edges between two seams on a loop of a coarse mesh: with fewer there is too little room between them.
const LEAST_BETWEEN: usize = 2;

impl MeshPlan {
    /// The plan with edges twice as long whose mesh with halved edges has the free nodes of this one, or up to three
    /// fewer. `None` for a mesh that is not large, a thin ring, and where loops or the room between seams are too
    /// small.
    pub(super) fn coarser(&self) -> Option<MeshPlan> {
        if !self.is_large() {
            return None;
        }
        let loops = self.loops.map(|nodes| nodes.div_ceil(2));
        if loops.iter().any(|&nodes| (1..ROUND_ENOUGH.max(LEAST_BETWEEN * self.seams)).contains(&nodes)) {
            return None;
        }
        let [at_inner, at_outer] = [2.0 * self.size.at_inner, 2.0 * self.size.at_outer];
        let size = SizeFunction { at_inner, at_outer, ..self.size };
        let mut coarser = MeshPlan { size, loops, hub: 2.0 * self.hub, free: 0, ..*self };
        if coarser.edges_across() < LEAST_ACROSS {
            return None;
        }
        coarser.seam_nodes = coarser.count_seam_nodes();
        // Each further node adds three edges.
        coarser.free = self.free.checked_sub(coarser.free_when_halved())? / 4;
        (coarser.free > 0).then_some(coarser)
    }

    /// Free nodes, and edges off loops and seams, whose middles become free nodes.
    fn free_when_halved(&self) -> usize {
        // A triangle has three edges, an edge off the loops has two triangles.
        let off_loops = (3 * self.triangles() - self.boundary()) / 2;
        self.free + off_loops - self.seams * (self.seam_nodes + 1)
    }

    /// The layout of [`MeshPlan::start`] with an interior from a mesh of the plan [`MeshPlan::coarser`].
    pub(super) fn start_from(&self, coarse: &Layout, triangles: &[[u32; 3]]) -> Layout {
        let at = |node: u32| coarse.points[node as usize];
        let kept = edge_keys(&coarse.constraints);
        let free = coarse.points.iter().zip(&coarse.freedom).filter(|(_, f)| **f == Freedom::Free).map(|(p, _)| *p);
        let edges = unique_edges(triangles);
        let halved = edges.iter().filter(|edge| kept.binary_search(edge).is_err()).map(|&[a, b]| 0.5 * (at(a) + at(b)));
        let mut interior: Vec<Vector2<f64>> = free.chain(halved).collect();
        // Nodes that are missing go into triangles far apart.
        let missing = self.free.saturating_sub(interior.len());
        let middle = |[a, b, c]: [u32; 3]| (at(a) + at(b) + at(c)) / 3.0;
        interior.extend((0..missing).map(|i| middle(triangles[i * triangles.len() / missing])));
        // Around a hole of few nodes a coarse mesh may reach into it.
        for p in &mut interior {
            *p = kept_clear(self, Freedom::Free, *p, CLEARANCE * self.size.at(p.norm()));
        }
        self.with_interior(interior)
    }
}

#[cfg(test)]
mod tests {
    use super::super::distmesh::triangulate_plan;
    use super::super::layout::GradedRequest;
    use super::super::random::SplitMix64;
    use super::super::sdf::Ring;

    /// From a coarse spiral, with a hole and without, with seams and with a hub, odd numbers of nodes on loops and
    /// seams: the halved mesh lacks three nodes at most, and what starts from it is a mesh of the plan.
    #[test]
    fn halved_edges_make_the_planned_mesh() {
        for (inner, nodes, seams, boundary_nodes) in [
            (0.1, 40_000, 0, None),
            (0.1, 40_001, 0, Some(901)),
            (0.3, 60_002, 13, None),
            (0.3, 40_000, 28, None),
            (0.0, 30_000, 0, None),
            (0.0, 50_003, 5, None),
            (0.0, 40_000, 16, Some(801)),
        ] {
            let ring = Ring { inner, outer: 1.0 };
            let plan = GradedRequest { ring, nodes, boundary_nodes, seams, grading: None }.plan().expect("fits");
            let coarser = plan.coarser().expect("large and wide");
            let lacking = plan.free.checked_sub(coarser.free_when_halved());
            assert!(lacking.is_some_and(|lacking| lacking < 4), "{inner}, {seams}: {lacking:?}");
            let coarse = coarser.start(SplitMix64::new(1, 0));
            let triangles = triangulate_plan(&coarser, &coarse).expect("a mesh of the coarse plan");
            let start = plan.start_from(&coarse, &triangles);
            assert_eq!(start.points.len(), nodes);
            assert_eq!(triangulate_plan(&plan, &start).map(|found| found.len()).ok(), Some(plan.triangles()));
        }
    }

    /// Small meshes, thin rings, tiny holes and meshes of many seams start from nothing.
    #[test]
    fn some_meshes_have_no_coarser_one() {
        for (inner, nodes, seams) in [(0.1, 15_000, 0), (0.97, 40_000, 0), (0.001, 40_000, 0), (0.1, 40_000, 60)] {
            let ring = Ring { inner, outer: 1.0 };
            let request = GradedRequest { ring, nodes, boundary_nodes: None, seams, grading: None };
            assert_eq!(request.plan().expect("fits").coarser(), None);
        }
    }
}
