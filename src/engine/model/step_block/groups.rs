//! Groups of four nodes in a nodal vector.

use crate::model::quad::Quad;

/// Four nodes.
pub(super) type Group<const W: usize> = [[f64; 4]; W];

pub(super) fn groups<const W: usize>(values: &[f64]) -> (&[Group<W>], &[f64]) {
    let (whole, last) = values.split_at(values.len() / (4 * W) * (4 * W));
    (whole.as_chunks().0.as_chunks().0, last)
}

pub(super) fn groups_mut<const W: usize>(values: &mut [f64]) -> (&mut [Group<W>], &mut [f64]) {
    let (whole, last) = values.split_at_mut(values.len() / (4 * W) * (4 * W));
    (whole.as_chunks_mut().0.as_chunks_mut().0, last)
}

/// The nodes, with the first one repeated in the remaining places.
pub(super) fn filled<const W: usize>(nodes: &[f64]) -> Group<W> {
    let mut group = [[0.0; 4]; W];
    for to in group.as_flattened_mut().chunks_mut(W) {
        to.copy_from_slice(&nodes[..W]);
    }
    group.as_flattened_mut()[..nodes.len()].copy_from_slice(nodes);
    group
}

/// The nodes, with zeros in the remaining places.
pub(super) fn begun<const W: usize>(nodes: &[f64]) -> Group<W> {
    let mut group = [[0.0; 4]; W];
    group.as_flattened_mut()[..nodes.len()].copy_from_slice(nodes);
    group
}

/// The components of four nodes.
#[inline(always)]
pub(super) fn columns<Q: Quad, const W: usize>(nodes: [Q; W]) -> [Q; 3] {
    match W {
        3 => Q::unpack([nodes[0], nodes[1], nodes[2]]),
        _ => Q::columns([nodes[0], nodes[1], nodes[2], nodes[3 % W]]),
    }
}
