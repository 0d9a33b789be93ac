//! The triangles and edges of a mesh, each once.

use super::assemble::{FacePieces, NONE, Notes};
use crate::format_number::first_few;
use crate::topology;
use crate::tuples::{earliest, repeated, sorted};

/// The triangles of a mesh.
pub(super) struct FaceList {
    pub triangles: Vec<[u32; 3]>,
    /// the triangle of each piece of a face; empty if each piece is the triangle of its number
    of_piece: Vec<u32>,
}

impl FaceList {
    /// The triangle of a piece of a face.
    pub(super) fn of_piece(&self, piece: u32) -> u32 {
        self.of_piece.get(piece as usize).copied().unwrap_or(piece)
    }
}

/// The triangles in file order, each once. `means_groups` says that a face is listed once for each of its groups.
pub(super) fn faces_once(pieces: &mut FacePieces, means_groups: bool, notes: &mut Notes) -> FaceList {
    let mut triangles = std::mem::take(&mut pieces.triangles);
    let mut again = repeated(triangles.iter().map(|triangle| sorted(*triangle)));
    if again.is_empty() {
        return FaceList { triangles, of_piece: Vec::new() };
    }
    again.sort_unstable();
    let mut of_piece = Vec::with_capacity(triangles.len());
    let (mut kept, mut next) = (0, again.iter().peekable());
    for piece in 0..triangles.len() {
        if let Some([_, first]) = next.next_if(|[number, _]| *number as usize == piece) {
            of_piece.push(of_piece[*first as usize]);
        } else {
            of_piece.push(kept);
            triangles[kept as usize] = triangles[piece];
            kept += 1;
        }
    }
    triangles.truncate(kept as usize);
    if !means_groups {
        let mut faces: Vec<u32> = again.iter().map(|[piece, _]| pieces.of_face[*piece as usize]).collect();
        faces.dedup();
        notes.found.push(format!(
            "{} faces with the nodes of an earlier one were dropped: {}",
            faces.len(),
            first_few(&faces)
        ));
    }
    FaceList { triangles, of_piece }
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
    let mut sides = topology::unique_edges(triangles);
    if list.edges.is_empty() {
        list.edges = sides;
    } else {
        sides.retain(|side| {
            while listed.next_if(|line| line < side).is_some() {}
            listed.peek() != Some(side)
        });
        list.edges.append(&mut sides);
    }
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
