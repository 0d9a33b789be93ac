//! The bytes of arrays in VTK's XML formats, and the cells of a mesh as arrays: corners, ends and types, in integers as
//! short as the mesh allows.

use std::borrow::Cow;
use std::io::{self, Write};

use base64::engine::general_purpose::STANDARD;
use base64::write::EncoderWriter;
use flate2::write::ZlibEncoder;

use super::cells::{Cells, VtuError};
use super::{Compression, Encoding, VtuFormat};

/// [byte] uncompressed size of a zlib block
const BLOCK: usize = 1 << 20;

/// Appends arrays to a body, with the length headers (`UInt64`) that VTK expects before each.
#[derive(Clone, Debug, Default)]
pub(super) struct Appender {
    format: VtuFormat,
    head: Vec<u8>,
    packed: Vec<u8>,
}

impl Appender {
    /// An appender for a format.
    pub(super) fn new(format: VtuFormat) -> Self {
        Self { format, ..Self::default() }
    }

    /// The format in use.
    pub(super) fn format(&self) -> VtuFormat {
        self.format
    }

    /// Whether bytes are neither compressed nor encoded.
    pub(super) fn leaves_as_is(&self) -> bool {
        (self.format.encoding, self.format.compression) == (Encoding::Raw, Compression::None)
    }

    /// Appends the header of `len` bytes of data, which then follow unchanged.
    pub(super) fn announce(&self, len: usize, body: &mut Vec<u8>) {
        body.extend_from_slice(&(len as u64).to_le_bytes());
    }

    /// Appends `data`.
    ///
    /// # Errors
    /// When an encoder fails, which does not happen in memory.
    pub(super) fn append(&mut self, data: &[u8], body: &mut Vec<u8>) -> io::Result<()> {
        self.head.clear();
        match self.format.compression {
            Compression::None => {
                self.head.extend_from_slice(&(data.len() as u64).to_le_bytes());
                self.spell(&[&self.head, data], body)?;
            }
            Compression::Zlib => {
                self.pack(data)?;
                // VTK first reads the header alone, so in base64 it is padded alone.
                self.spell(&[&self.head], body)?;
                self.spell(&[&self.packed], body)?;
            }
        }
        Ok(())
    }

    /// Compresses into `packed`; `head` gets \[number of blocks, size of a block, size of a last partial block,
    /// compressed size of each\].
    fn pack(&mut self, data: &[u8]) -> io::Result<()> {
        self.packed.clear();
        let mut put = |n: usize| self.head.extend_from_slice(&(n as u64).to_le_bytes());
        put(data.len().div_ceil(BLOCK));
        put(BLOCK);
        put(data.len() % BLOCK);
        for block in data.chunks(BLOCK) {
            let before = self.packed.len();
            let mut encoder = ZlibEncoder::new(&mut self.packed, flate2::Compression::fast());
            encoder.write_all(block)?;
            encoder.finish()?;
            put(self.packed.len() - before);
        }
        Ok(())
    }

    fn spell(&self, parts: &[&[u8]], body: &mut Vec<u8>) -> io::Result<()> {
        match self.format.encoding {
            Encoding::Raw => parts.iter().for_each(|part| body.extend_from_slice(part)),
            Encoding::Base64 => {
                let mut encoder = EncoderWriter::new(body, &STANDARD);
                parts.iter().try_for_each(|part| encoder.write_all(part))?;
                encoder.finish()?;
            }
        }
        Ok(())
    }
}

/// The bytes of numbers, little-endian; borrowed on little-endian machines.
pub(super) fn little_endian(values: &[f64]) -> Cow<'_, [u8]> {
    if cfg!(target_endian = "little") {
        Cow::Borrowed(bytemuck::cast_slice(values))
    } else {
        Cow::Owned(values.iter().flat_map(|v| v.to_le_bytes()).collect())
    }
}

/// Writes numbers as `f32`, little-endian, into `out`; those that are too large become infinite.
pub(super) fn little_endian_f32(values: &[f64], out: &mut Vec<u8>) {
    out.clear();
    out.extend(values.iter().flat_map(|v| (*v as f32).to_le_bytes()));
}

/// VTK's cell types (vtkCellType.h).
const VTK_VERTEX: u8 = 1;
const VTK_LINE: u8 = 3;
const VTK_TRIANGLE: u8 = 5;

/// The integer type for numbers of points and ends of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// UInt16
    Half,
    /// Int32
    Short,
    /// Int64
    Long,
}

impl Width {
    /// The shortest type for this many points and corners of cells: in 32 bits, cells are a third to a half of a frame.
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
    /// Triangles, then edges; without either, one vertex cell per point.
    ///
    /// # Errors
    /// When a cell names a point that does not exist.
    pub(super) fn new(cells: &Cells<'_>, width: Width) -> Result<Self, VtuError> {
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
