//! The triangles and edges of a mesh, each once.

use super::assemble::{FacePieces, NONE, Notes};
use crate::format_number::first_few;
use crate::topology;
use crate::tuples::{earliest, sorted};

/// The triangles of a mesh.
pub(super) struct FaceList {
    pub triangles: Vec<[u32; 3]>,
    /// the triangle of each piece of a face
    pub of_piece: Vec<u32>,
}

/// The triangles in file order, each once. `means_groups` says that a face is listed once for each of its groups.
pub(super) fn faces_once(pieces: &FacePieces, means_groups: bool, notes: &mut Notes) -> FaceList {
    let count = pieces.triangles.len();
    let mut list = FaceList { triangles: Vec::with_capacity(count), of_piece: Vec::with_capacity(count) };
    let mut again = Vec::new();
    let keys: Vec<[u32; 3]> = pieces.triangles.iter().map(|triangle| sorted(*triangle)).collect();
    for (piece, first) in earliest(&keys).into_iter().enumerate() {
        if first as usize == piece {
            list.of_piece.push(list.triangles.len() as u32);
            list.triangles.push(pieces.triangles[piece]);
        } else {
            list.of_piece.push(list.of_piece[first as usize]);
            again.push(pieces.of_face[piece]);
        }
    }
    if !again.is_empty() && !means_groups {
        again.dedup();
        notes.found.push(format!(
            "{} faces with the nodes of an earlier one were dropped: {}",
            again.len(),
            first_few(&again)
        ));
    }
    list
}

/// The edges of a mesh.
pub(super) struct EdgeList {
    /// lines in file order, each once, then the triangles' other edges
    pub edges: Vec<[u32; 2]>,
    /// the edge of each line; `None` if its ends are one node
    pub of_line: Vec<Option<u32>>,
    /// edges on seams, ascending
    pub seams: Vec<u32>,
}

pub(super) fn edges(
    lines: impl Iterator<Item = [u32; 2]>,
    seam: &[bool],
    triangles: &[[u32; 3]],
    means_groups: bool,
    notes: &mut Notes,
) -> EdgeList {
    let mut list = EdgeList { edges: Vec::new(), of_line: Vec::new(), seams: Vec::new() };
    let (mut points, mut repeated) = (0, 0);
    let lines: Vec<[u32; 2]> = lines.collect();
    let mut keys: Vec<[u32; 2]> = lines.iter().map(|line| sorted(*line)).collect();
    for (number, (line, first)) in lines.into_iter().zip(earliest(&keys)).enumerate() {
        if line[0] == line[1] {
            points += 1;
            list.of_line.push(None);
            continue;
        }
        let edge = if first as usize == number {
            list.edges.push(line);
            list.edges.len() as u32 - 1
        } else {
            repeated += 1;
            list.of_line[first as usize].unwrap_or(NONE)
        };
        list.of_line.push(Some(edge));
        if seam.get(number) == Some(&true) {
            list.seams.push(edge);
        }
    }
    // Both are in ascending order.
    keys.sort_unstable();
    let mut listed = keys.into_iter().peekable();
    list.edges.extend(topology::unique_edges(triangles).into_iter().filter(|side| {
        while listed.next_if(|line| line < side).is_some() {}
        listed.peek() != Some(side)
    }));
    list.seams.sort_unstable();
    list.seams.dedup();
    if points > 0 {
        notes.found.push(format!("{points} lines whose ends are one node were dropped"));
    }
    if repeated > 0 && !means_groups {
        notes.found.push(format!("{repeated} repeated lines were dropped"));
    }
    list
}
