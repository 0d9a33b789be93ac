//! The cells of a picture as VTK stores them: corners, ends and types, in numbers as short as the scene allows.

use super::write::{Cells, VtuError};

/// VTK's cell types (vtkCellType.h).
const VTK_VERTEX: u8 = 1;
const VTK_LINE: u8 = 3;
const VTK_TRIANGLE: u8 = 5;

/// How the numbers of points and ends of cells are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Width {
    /// UInt16
    Half,
    /// Int32
    Short,
    /// Int64
    Long,
}

impl Width {
    /// The shortest that can number so many points and corners of cells: in 32 bits cells are a third to a half of a
    /// frame.
    pub fn of(points: usize, corners: usize) -> Self {
        let most = points.max(corners);
        if u16::try_from(most).is_ok() {
            Width::Half
        } else if i32::try_from(most).is_ok() {
            Width::Short
        } else {
            Width::Long
        }
    }

    /// [byte] of a number
    pub fn bytes(self) -> usize {
        match self {
            Width::Half => size_of::<u16>(),
            Width::Short => size_of::<i32>(),
            Width::Long => size_of::<i64>(),
        }
    }

    /// VTK's name.
    pub fn kind(self) -> &'static str {
        match self {
            Width::Half => "UInt16",
            Width::Short => "Int32",
            Width::Long => "Int64",
        }
    }
}

/// The cell arrays as bytes: connectivity and ends, UInt8 types.
pub(super) struct CellTable {
    pub connectivity: Vec<u8>,
    pub ends: Vec<u8>,
    pub types: Vec<u8>,
    pub width: Width,
}

impl CellTable {
    /// Triangles, then edges; without either a vertex a point.
    ///
    /// # Errors
    /// When a cell names a point that is not there.
    pub fn new(cells: &Cells<'_>, width: Width) -> Result<Self, VtuError> {
        let mut table = Self { connectivity: Vec::new(), ends: Vec::new(), types: Vec::new(), width };
        for triangle in cells.triangles {
            table.push(VTK_TRIANGLE, triangle, cells.points)?;
        }
        for edge in cells.edges {
            table.push(VTK_LINE, edge, cells.points)?;
        }
        if table.types.is_empty() {
            for point in 0..cells.points {
                table.put(VTK_VERTEX, [point as u64].into_iter());
            }
        }
        Ok(table)
    }

    fn push(&mut self, kind: u8, corners: &[u32], points: usize) -> Result<(), VtuError> {
        if let Some(&point) = corners.iter().find(|&&p| p as usize >= points) {
            return Err(VtuError::PointOutOfRange { cell: self.types.len(), point, points });
        }
        self.put(kind, corners.iter().map(|&p| u64::from(p)));
        Ok(())
    }

    fn put(&mut self, kind: u8, corners: impl Iterator<Item = u64>) {
        // The low bytes come first.
        let bytes = self.width.bytes();
        corners.for_each(|p| self.connectivity.extend_from_slice(&p.to_le_bytes()[..bytes]));
        let end = (self.connectivity.len() / bytes) as u64;
        self.ends.extend_from_slice(&end.to_le_bytes()[..bytes]);
        self.types.push(kind);
    }
}
