//! Conditions that every mesh must satisfy before a simulation uses it.

use super::tuples::{repeated, sorted};
use super::{Mesh, MeshError};
use nalgebra::Vector3;

/// [-] area over squared longest edge below which a triangle counts as degenerate; its normal is then mostly rounding.
const LEAST_FLATNESS: f64 = 1e-10;
/// [-] squared normal over the fourth power of the longest edge that is certainly enough: 25 times the least one
const FAR: f64 = 100.0 * LEAST_FLATNESS * LEAST_FLATNESS;

impl Mesh {
    /// Position of a node.
    pub fn point(&self, node: u32) -> Vector3<f64> {
        Vector3::from(self.nodes[node as usize])
    }

    /// [m] Corners of a triangle as it is cut: in its flat piece if it was sewn, else where its nodes are.
    pub fn cut_corners(&self, triangle: u32) -> Option<[Vector3<f64>; 3]> {
        let nodes = self.triangles.get(triangle as usize)?;
        let sewn = self.cut.as_ref().and_then(|cut| cut.triangles.get(triangle as usize));
        Some(sewn.map_or_else(|| nodes.map(|node| self.point(node)), |corners| corners.map(Vector3::from)))
    }

    /// [m] Length of an edge as it is cut.
    pub fn cut_length(&self, edge: u32) -> Option<f64> {
        let &[a, b] = self.edges.get(edge as usize)?;
        let sewn = self.cut.as_ref().and_then(|cut| cut.lengths.get(edge as usize));
        Some(sewn.copied().unwrap_or_else(|| (self.point(a) - self.point(b)).norm()))
    }

    /// Checks the conditions of every simulation: numbers in range, finite positions, no repeated or degenerate edge or
    /// triangle.
    ///
    /// [`crate::Topology`] checks orientation and manifoldness, which not every scene needs.
    ///
    /// # Errors
    /// The first fault found, with its numbers.
    pub fn check(&self) -> Result<(), MeshError> {
        self.check_numbers()?;
        self.check_duplicates()?;
        self.check_shapes()
    }

    /// All but repeated and degenerate edges and triangles.
    pub(crate) fn check_numbers(&self) -> Result<(), MeshError> {
        self.check_sizes()?;
        if let Some(node) = self.nodes.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
            return Err(MeshError::NotFinite { node });
        }
        for (index, edge) in self.edges.iter().enumerate() {
            self.check_corners("edge", index, edge)?;
        }
        for (index, triangle) in self.triangles.iter().enumerate() {
            self.check_corners("triangle", index, triangle)?;
        }
        self.check_seams()?;
        self.check_groups()?;
        self.check_displacement()?;
        self.check_cut()
    }

    fn check_sizes(&self) -> Result<(), MeshError> {
        let reason = if self.nodes.is_empty() {
            "a mesh needs nodes"
        } else if [self.nodes.len(), self.edges.len(), self.triangles.len()].iter().any(|&n| n >= u32::MAX as usize) {
            "node, edge and triangle numbers must stay below 2^32 - 1"
        } else {
            return Ok(());
        };
        let (nodes, edges, triangles) = (self.nodes.len(), self.edges.len(), self.triangles.len());
        Err(MeshError::Size { nodes, edges, triangles, reason })
    }

    fn check_corners(&self, what: &'static str, index: usize, corners: &[u32]) -> Result<(), MeshError> {
        for (i, &node) in corners.iter().enumerate() {
            if node as usize >= self.nodes.len() {
                return Err(MeshError::NodeOutOfRange { what, index, node: node.into(), nodes: self.nodes.len() });
            }
            if corners[..i].contains(&node) {
                return Err(MeshError::RepeatedNode { what, index, node });
            }
        }
        Ok(())
    }

    fn check_seams(&self) -> Result<(), MeshError> {
        match self.seams.iter().position(|&edge| edge as usize >= self.edges.len()) {
            Some(index) => Err(MeshError::SeamOutOfRange { index, edge: self.seams[index], edges: self.edges.len() }),
            None => Ok(()),
        }
    }

    fn check_displacement(&self) -> Result<(), MeshError> {
        let (found, nodes) = (self.displacement.len(), self.nodes.len());
        if found != 0 && found != nodes {
            return Err(MeshError::Displacement { found, nodes });
        }
        match self.displacement.iter().position(|u| !u.iter().all(|c| c.is_finite())) {
            Some(node) => Err(MeshError::NotFinite { node }),
            None => Ok(()),
        }
    }

    fn check_cut(&self) -> Result<(), MeshError> {
        let Some(cut) = &self.cut else { return Ok(()) };
        let wrong =
            [("triangle", cut.triangles.len(), self.triangles.len()), ("edge", cut.lengths.len(), self.edges.len())];
        match wrong.into_iter().find(|(_, found, wanted)| found != wanted) {
            Some((what, found, wanted)) => Err(MeshError::Cut { what, found, wanted }),
            None => Ok(()),
        }
    }

    fn check_duplicates(&self) -> Result<(), MeshError> {
        if let Some((first, second)) = first_duplicate(&self.edges) {
            let [a, b] = sorted(self.edges[first]);
            return Err(MeshError::DuplicateEdge { first, second, a, b });
        }
        match first_duplicate(&self.triangles) {
            Some((first, second)) => Err(MeshError::DuplicateTriangle { first, second }),
            None => Ok(()),
        }
    }

    /// Edges without length and triangles without a normal.
    pub(crate) fn check_shapes(&self) -> Result<(), MeshError> {
        for (edge, &[a, b]) in self.edges.iter().enumerate() {
            if self.point(a) == self.point(b) {
                return Err(MeshError::ZeroLengthEdge { edge, a, b });
            }
        }
        for (triangle, corners) in self.triangles.iter().enumerate() {
            if let Some([area, longest]) = flat(corners.map(|node| self.point(node))) {
                return Err(MeshError::DegenerateTriangle { triangle, area, longest });
            }
        }
        Ok(())
    }
}

/// Area [m^2] and longest edge [m] of a triangle without a normal; `None` if it has one.
#[inline]
pub(super) fn flat(corners: [Vector3<f64>; 3]) -> Option<[f64; 2]> {
    let [u, v, w] = edges(&corners);
    // Far from the limit and from overflow, squares tell as much as their roots.
    let longest_squared = u.norm_squared().max(v.norm_squared()).max(w.norm_squared());
    let twice_squared = u.cross(&v).norm_squared();
    let in_range = f64::MIN_POSITIVE < twice_squared && twice_squared < f64::MAX;
    if in_range && twice_squared > FAR * longest_squared * longest_squared { None } else { flat_by_roots(&corners) }
}

#[inline]
fn edges([a, b, c]: &[Vector3<f64>; 3]) -> [Vector3<f64>; 3] {
    [b - a, c - a, c - b]
}

#[cold]
fn flat_by_roots(corners: &[Vector3<f64>; 3]) -> Option<[f64; 2]> {
    let [u, v, w] = edges(corners);
    let longest = u.norm().max(v.norm()).max(w.norm());
    let area = 0.5 * u.cross(&v).norm();
    // In this form an overflow to NaN or infinity is a fault too.
    let sound = area > LEAST_FLATNESS * longest * longest && area.is_finite();
    (!sound).then_some([area, longest])
}

/// The first item (in list order) that has the same nodes as an earlier one.
fn first_duplicate<const N: usize>(items: &[[u32; N]]) -> Option<(usize, usize)> {
    let again = repeated(items.iter().map(|item| sorted(*item)));
    again.into_iter().min().map(|[number, first]| (first as usize, number as usize))
}
