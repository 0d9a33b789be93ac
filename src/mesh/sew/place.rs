//! Where sewn pieces start in space: pieces that form a ring stand around the z axis, others lie where they fit.

use super::ring::{self, Ring};
use super::{SewError, Stitch, fit};
use crate::Mesh;
use crate::components::components;
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

/// Pieces in space.
pub(super) struct Placed {
    /// [m] place of every node of the flat pieces
    pub at: Vec<Vector3<f64>>,
    /// number of pieces
    pub pieces: usize,
    /// the ring, if the pieces are one
    pub ring: Option<Ring>,
    /// nodes of pieces whose triangles are turned, because they would face inwards
    pub turned: Vec<bool>,
}

impl Placed {
    /// [m] The largest distance of two nodes that meet.
    pub(super) fn gap(&self, stitches: &[Stitch]) -> f64 {
        let apart = |[a, b]: [u32; 2]| (self.at[a as usize] - self.at[b as usize]).norm();
        let widest = stitches.iter().flat_map(Stitch::pairs).map(apart).fold(0.0, f64::max);
        let length = stitches.iter().flat_map(|stitch| &stitch.sides).map(|side| side.length).fold(0.0, f64::max);
        // Less is rounding.
        if widest > 1e-9 * length { widest } else { 0.0 }
    }
}

/// Nodes of the flat pieces.
pub(super) struct Pieces {
    /// by the smallest node of each piece all of its nodes
    pub nodes: BTreeMap<u32, Vec<u32>>,
}

impl Pieces {
    fn of(mesh: &Mesh) -> Self {
        let across = mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [a, c]]);
        let mut nodes: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (node, piece) in (0..).zip(components(mesh.nodes.len(), across)) {
            nodes.entry(piece).or_default().push(node);
        }
        Pieces { nodes }
    }

    pub(super) fn of_piece(&self, piece: u32) -> &[u32] {
        self.nodes.get(&piece).map(Vec::as_slice).unwrap_or_default()
    }
}

/// Places the pieces.
///
/// # Errors
/// Pieces that are sewn to each other in another way.
pub(super) fn place(mesh: &Mesh, stitches: &[Stitch]) -> Result<Placed, SewError> {
    let at = (0..mesh.nodes.len() as u32).map(|node| mesh.point(node)).collect();
    let mut placed = Placed { at, pieces: 0, ring: None, turned: vec![false; mesh.nodes.len()] };
    let pieces = Pieces::of(mesh);
    let joined = components(mesh.nodes.len(), stitches.iter().map(|stitch| [0, 1].map(|i| stitch.sides[i].piece)));
    let mut parts: BTreeMap<u32, Vec<&Stitch>> = BTreeMap::new();
    for stitch in stitches {
        parts.entry(joined[stitch.sides[0].piece as usize]).or_default().push(stitch);
    }
    for part in parts.into_values() {
        let of = |i: usize| move |stitch: &&Stitch| stitch.sides[i].piece;
        let members: BTreeSet<u32> = part.iter().map(of(0)).chain(part.iter().map(of(1))).collect();
        let link = |stitch: &&Stitch| {
            let [a, b] = [0, 1].map(|i| stitch.sides[i].piece);
            [a.min(b), a.max(b)]
        };
        let links: BTreeSet<[u32; 2]> = part.iter().map(link).collect();
        placed.pieces += members.len();
        if links.len() + 1 == members.len() {
            fit::fit(mesh, &pieces, &part, &mut placed);
        } else if links.len() == members.len() && part.len() == members.len() {
            ring::stand(mesh, &pieces, &part, &mut placed)?;
        } else {
            return Err(SewError::NoPlace { pieces: members.len(), links: links.len() });
        }
    }
    Ok(placed)
}
