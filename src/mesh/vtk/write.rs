//! Writes .vtu files (VTK XML unstructured grid, version 1.0): triangles, then edges, as cells.
//!
//! A frame has appended arrays. Connectivity, offsets and types do not change during a run: they are encoded once and
//! come first in the appended section, so a frame only adds its own arrays after them.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::Write;

pub use super::cells::{Cells, VtuError};
use super::encode::{Appender, CellTable, Width, little_endian, little_endian_f32};
use super::tags::{field_arrays, field_data, tag};
use super::vectored_write::{Appended, Segment};
use super::{Compression, Encoding, Precision, VtuFormat, xml_attribute};

/// Values of an array, one per point or per cell.
#[derive(Clone, Copy, Debug)]
pub enum Values<'a> {
    /// one number per point or cell
    Scalars(&'a [f64]),
    /// three numbers per point or cell
    Vectors(&'a [[f64; 3]]),
    /// one small whole number per point or cell
    Flags(&'a [u8]),
}

/// A named array.
#[derive(Clone, Copy, Debug)]
pub struct Array<'a> {
    /// name, as shown by ParaView
    pub name: &'a str,
    /// its values
    pub values: Values<'a>,
}

/// One frame of the scene.
#[derive(Clone, Copy, Debug)]
pub struct Snapshot<'a> {
    /// [s] written as `TimeValue`, if given
    pub time: Option<f64>,
    /// [m] current positions
    pub points: &'a [[f64; 3]],
    /// arrays on the points
    pub point_data: &'a [Array<'a>],
    /// arrays on the cells, triangles before edges
    pub cell_data: &'a [Array<'a>],
}

/// Arrays that do not change, each with its name.
#[derive(Clone, Copy, Debug, Default)]
pub struct FixedArrays<'a> {
    /// whole numbers on the cells, triangles before edges
    pub cell_numbers: Option<(&'a str, &'a [i32])>,
    /// small numbers on the cells
    pub cell_flags: &'a [(&'a str, &'a [u8])],
    /// whole numbers on the points
    pub point_numbers: Option<(&'a str, &'a [i32])>,
    /// vectors on the points
    pub point_vectors: Option<(&'a str, &'a [[f64; 3]])>,
    /// whole numbers of the file as a whole
    pub field: &'a [(String, Vec<i32>)],
}

/// Whether an array has one value for each point or cell.
pub(super) fn right(name: &str, found: usize, expected: usize) -> Result<(), VtuError> {
    match found == expected {
        true => Ok(()),
        false => Err(VtuError::WrongLength { name: name.to_owned(), found, expected }),
    }
}

pub(super) fn bytes(numbers: &[i32]) -> Vec<u8> {
    numbers.iter().flat_map(|i| i.to_le_bytes()).collect()
}

/// The first lines of a file with this kind of data, with a further attribute of its root.
pub(super) fn head(kind: &str, compressor: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"{kind}\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\"{compressor}>\n<{kind}>\n"
    )
}

/// Writes frames of one scene; buffers are reused.
#[derive(Clone, Debug)]
pub struct VtuWriter {
    points: usize,
    cells: usize,
    appender: Appender,
    head: String,
    /// the appended data, except arrays that are written from their own memory
    body: Vec<u8>,
    /// buffer for numbers in single precision
    short: Vec<u8>,
    fixed_len: usize,
    fixed_offsets: [usize; 3],
    width: Width,
    fixed: FixedTags,
}

/// The tags of arrays that do not change.
#[derive(Clone, Debug, Default)]
struct FixedTags {
    points: String,
    cells: String,
    field: String,
}

impl VtuWriter {
    /// Encodes the cells. A scene without cells gets one vertex cell per point: a piece without cells is invisible, and
    /// some readers refuse it.
    ///
    /// # Errors
    /// When a cell names a point that does not exist.
    pub fn new(cells: &Cells<'_>, format: VtuFormat) -> Result<Self, VtuError> {
        let table = CellTable::new(cells, Width::of(cells.points, cells.corners()))?;
        let mut appender = Appender::new(format);
        let mut body = Vec::new();
        let mut fixed_offsets = [0; 3];
        for (offset, array) in fixed_offsets.iter_mut().zip([&table.connectivity, &table.ends, &table.types]) {
            *offset = body.len();
            appender.append(array, &mut body)?;
        }
        let fixed_len = body.len();
        Ok(Self {
            points: cells.points,
            cells: table.types.len(),
            appender,
            head: String::new(),
            body,
            short: Vec::new(),
            fixed_len,
            fixed_offsets,
            width: table.width,
            fixed: FixedTags::default(),
        })
    }

    /// Adds arrays that all frames have; they are encoded once.
    ///
    /// # Errors
    /// When an array has the wrong length.
    pub fn with_fixed(mut self, arrays: &FixedArrays<'_>) -> Result<Self, VtuError> {
        let (points, cells) = (self.points, self.cells);
        if let Some((name, vectors)) = arrays.point_vectors {
            right(name, vectors.len(), points)?;
            self.fixed.points = self.fixed_array(name, "Float64", 3, &little_endian(vectors.as_flattened()))?;
        }
        if let Some((name, numbers)) = arrays.point_numbers {
            right(name, numbers.len(), points)?;
            let tag = self.fixed_array(name, "Int32", 1, &bytes(numbers))?;
            self.fixed.points += &tag;
        }
        if let Some((name, numbers)) = arrays.cell_numbers {
            right(name, numbers.len(), cells)?;
            self.fixed.cells = self.fixed_array(name, "Int32", 1, &bytes(numbers))?;
        }
        for (name, flags) in arrays.cell_flags {
            right(name, flags.len(), cells)?;
            let tag = self.fixed_array(name, "UInt8", 1, flags)?;
            self.fixed.cells += &tag;
        }
        self.fixed.field = field_arrays(arrays.field);
        self.fixed_len = self.body.len();
        Ok(self)
    }

    /// Appends an array; returns its tag.
    fn fixed_array(&mut self, name: &str, kind: &str, components: usize, data: &[u8]) -> Result<String, VtuError> {
        let (offset, name) = (self.body.len(), xml_attribute(name));
        self.appender.append(data, &mut self.body)?;
        Ok(tag(&name, kind, components, offset))
    }

    /// Number of cells, which is the length of every cell array.
    pub fn cells(&self) -> usize {
        self.cells
    }

    /// Writes one frame.
    ///
    /// # Errors
    /// When an array has the wrong length, or writing fails.
    pub fn write(&mut self, picture: &Snapshot<'_>, out: &mut impl Write) -> Result<(), VtuError> {
        self.body.truncate(self.fixed_len);
        let mut appended = Appended::from(Segment::Body(0..self.fixed_len));
        self.begin(picture.time);
        self.head.push_str("<PointData>\n");
        self.head.push_str(&self.fixed.points);
        for array in picture.point_data {
            self.array(array, self.points, &mut appended)?;
        }
        self.head.push_str("</PointData>\n<CellData>\n");
        self.head.push_str(&self.fixed.cells);
        for array in picture.cell_data {
            self.array(array, self.cells, &mut appended)?;
        }
        self.head.push_str("</CellData>\n<Points>\n");
        let points = Array { name: "Points", values: Values::Vectors(picture.points) };
        // Far from the origin, neighbours could coincide in seven digits, so positions keep all digits.
        self.array_as(&points, self.points, Precision::F64, &mut appended)?;
        self.head.push_str("</Points>\n");
        self.end();
        let tail = b"\n</AppendedData>\n</VTKFile>\n";
        Ok(appended.write(out, &self.body, [self.head.as_bytes(), tail])?)
    }

    fn begin(&mut self, time: Option<f64>) {
        let compressor = match self.appender.format().compression {
            Compression::None => "",
            Compression::Zlib => " compressor=\"vtkZLibDataCompressor\"",
        };
        self.head.clear();
        self.head.push_str(&head("UnstructuredGrid", compressor));
        let time = time.map_or_else(String::new, |time| {
            format!(
                "<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{time:?}\
                 </DataArray>\n"
            )
        });
        self.head.push_str(&field_data(&(time + &self.fixed.field)));
        let _ = writeln!(self.head, "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">", self.points, self.cells);
    }

    /// An array in the precision of the format.
    fn array<'a>(&mut self, array: &Array<'a>, expected: usize, to: &mut Appended<'a>) -> Result<(), VtuError> {
        self.array_as(array, expected, self.appender.format().precision, to)
    }

    fn array_as<'a>(
        &mut self,
        array: &Array<'a>,
        expected: usize,
        precision: Precision,
        to: &mut Appended<'a>,
    ) -> Result<(), VtuError> {
        let (values, found, components) = match array.values {
            Values::Scalars(s) => (s, s.len(), 1),
            Values::Vectors(v) => (v.as_flattened(), v.len(), 3),
            Values::Flags(flags) => return self.flags(array.name, flags, expected, to),
        };
        right(array.name, found, expected)?;
        let (offset, begin) = (to.len(), self.body.len());
        let mut as_they_are = None;
        let kind = match precision {
            Precision::F64 => {
                match little_endian(values) {
                    Cow::Borrowed(bytes) if self.appender.leaves_as_is() => {
                        self.appender.announce(bytes.len(), &mut self.body);
                        as_they_are = Some(bytes);
                    }
                    bytes => self.appender.append(&bytes, &mut self.body)?,
                }
                "Float64"
            }
            Precision::F32 => {
                little_endian_f32(values, &mut self.short);
                self.appender.append(&self.short, &mut self.body)?;
                "Float32"
            }
        };
        to.push(Segment::Body(begin..self.body.len()));
        as_they_are.into_iter().for_each(|bytes| to.push(Segment::Numbers(bytes)));
        self.head.push_str(&tag(&xml_attribute(array.name), kind, components, offset));
        Ok(())
    }

    fn flags(&mut self, name: &str, flags: &[u8], expected: usize, to: &mut Appended<'_>) -> Result<(), VtuError> {
        right(name, flags.len(), expected)?;
        let (offset, begin) = (to.len(), self.body.len());
        self.appender.append(flags, &mut self.body)?;
        to.push(Segment::Body(begin..self.body.len()));
        self.head.push_str(&tag(&xml_attribute(name), "UInt8", 1, offset));
        Ok(())
    }

    fn end(&mut self) {
        self.head.push_str("<Cells>\n");
        let kind = self.width.kind();
        let arrays = [(kind, "connectivity"), (kind, "offsets"), ("UInt8", "types")];
        for ((kind, name), offset) in arrays.into_iter().zip(self.fixed_offsets) {
            let _ = writeln!(
                self.head,
                "<DataArray type=\"{kind}\" Name=\"{name}\" format=\"appended\" offset=\"{offset}\"/>"
            );
        }
        let encoding = match self.appender.format().encoding {
            Encoding::Raw => "raw",
            Encoding::Base64 => "base64",
        };
        let _ = write!(self.head, "</Cells>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"{encoding}\">\n_");
    }
}
