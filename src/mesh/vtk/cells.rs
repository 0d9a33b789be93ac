//! The cells of a frame, and why a frame cannot be written.

/// The constant part: the number of points and the cells.
#[derive(Clone, Copy, Debug)]
pub struct Cells<'a> {
    /// number of points
    pub points: usize,
    /// triangles, which come first
    pub triangles: &'a [[u32; 3]],
    /// edges, which come after the triangles
    pub edges: &'a [[u32; 2]],
}

impl Cells<'_> {
    /// Number of corners of all cells.
    pub(super) fn corners(&self) -> usize {
        3 * self.triangles.len() + 2 * self.edges.len()
    }
}

/// Why a frame cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VtuError {
    /// A cell names a point that does not exist.
    #[error("cell {cell} uses point {point}, but there are {points} points, counted from 0")]
    PointOutOfRange {
        /// the cell, triangles counted before edges
        cell: usize,
        /// the point it names
        point: u32,
        /// number of points
        points: usize,
    },
    /// An array has the wrong length.
    #[error("array \"{name}\" holds {found} values where {expected} are needed")]
    WrongLength {
        /// the array
        name: String,
        /// its length
        found: usize,
        /// the number of points or cells
        expected: usize,
    },
    /// The system's error.
    #[error(transparent)]
    Write(#[from] std::io::Error),
}
