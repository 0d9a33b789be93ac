//! The one reader of .vtu, .vtp and legacy .vtk, for meshes and for the frames of a run.
//!
//! Read by hand: `vtkio` reads neither raw nor compressed appended arrays, nor fields and types of numbers that VTK
//! itself writes into legacy files, and it requests all memory that a damaged header asks for.

mod layout;
mod legacy;
mod numbers;
mod xml;

pub use numbers::Numbers;

/// A grid or polygons.
#[derive(Clone, Debug, Default)]
pub struct DataSet {
    /// its parts, one after the other
    pub pieces: Vec<Piece>,
    /// arrays of whole numbers of the file as a whole, by name
    pub fields: Vec<(String, Vec<i64>)>,
}

/// A part of a data set.
#[derive(Clone, Debug, Default)]
pub struct Piece {
    /// [m] places
    pub points: Vec<[f64; 3]>,
    /// the cells, in order
    pub cells: CellLists,
    /// arrays with a row for each point
    pub point_data: Vec<Column>,
    /// arrays with a row for each cell
    pub cell_data: Vec<Column>,
}

/// Cells by their points.
#[derive(Clone, Debug, Default)]
pub struct CellLists {
    /// [-] numbers of points of all cells
    pub points: Vec<u64>,
    /// [-] where the points of each cell end
    pub ends: Vec<usize>,
    /// [-] VTK's number of the type of each cell
    pub types: Vec<u8>,
}

impl CellLists {
    /// Cells of several types, given by the numbers of their points and where the points of each end.
    pub(super) fn new(points: Vec<i64>, ends: Vec<usize>, types: Vec<u8>) -> Result<Self, String> {
        let mut cells = Self::default();
        cells.add(points, ends, 0)?;
        if types.len() != cells.ends.len() {
            return Err(unfit());
        }
        cells.types = types;
        Ok(cells)
    }

    /// The type and the points of each cell.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (u8, &[u64])> {
        (0..self.ends.len()).map(|cell| {
            let begin = if cell == 0 { 0 } else { self.ends[cell - 1] };
            (self.types[cell], &self.points[begin..self.ends[cell]])
        })
    }

    /// Adds cells of one type, given by where the points of each end.
    fn add(&mut self, points: Vec<i64>, mut ends: Vec<usize>, kind: u8) -> Result<(), String> {
        let ascend = ends.is_sorted() && ends.last().is_none_or(|end| *end <= points.len());
        if !ascend || points.iter().any(|point| *point < 0) {
            return Err(unfit());
        }
        let first = self.points.len();
        // In place where these are the first.
        let mut points: Vec<u64> = points.into_iter().map(i64::cast_unsigned).collect();
        if first == 0 && self.ends.is_empty() {
            (self.points, self.ends) = (points, ends);
        } else {
            self.points.append(&mut points);
            ends.iter_mut().for_each(|end| *end += first);
            self.ends.append(&mut ends);
        }
        self.types.resize(self.ends.len(), kind);
        Ok(())
    }
}

fn unfit() -> String {
    "is damaged: its cells and their nodes do not fit together".to_owned()
}

/// An array on points or cells.
#[derive(Clone, Debug)]
pub struct Column {
    /// its name
    pub name: String,
    /// numbers of a row
    pub components: usize,
    /// row after row
    pub numbers: Numbers,
}

/// The numbers of a named array, if it is there.
pub fn named_array(columns: &[Column], name: &str) -> Option<Vec<f64>> {
    columns.iter().find(|column| column.name == name).map(|column| column.numbers.clone().reals())
}

/// The content of a file: arrays of whole numbers with one a row, and those with the names that are asked for.
///
/// # Errors
/// The fault of the file, as the end of a sentence that begins with its name.
pub fn read(bytes: &[u8], names: &[&str]) -> Result<DataSet, String> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    if bytes.trim_ascii_start().starts_with(b"<") { xml::read(bytes, names) } else { legacy::read(bytes, names) }
}

/// Names of the files that a .pvd, .pvtu, .pvtp or .vtm file lists.
pub fn files_of(bytes: &[u8]) -> Vec<String> {
    xml::files_of(bytes)
}

/// Memory that numbers may take: a compressed file, or one whose arrays share their data, may ask for far more than it
/// holds.
struct Budget {
    left: usize,
    /// [byte] size of the file
    file: usize,
}

/// [byte] numbers of any file, and for each of its bytes
const ANY: usize = 32 << 20;
const PER_BYTE: usize = 16;

impl Budget {
    fn of(file: usize) -> Self {
        Budget { left: ANY + PER_BYTE * file, file }
    }

    /// Takes the memory of so many numbers.
    fn take(&mut self, numbers: usize) -> Result<(), String> {
        let left = numbers.checked_mul(8).and_then(|bytes| self.left.checked_sub(bytes));
        self.left = left.ok_or_else(|| {
            let [most, file] = [ANY + PER_BYTE * self.file, self.file].map(|n| n as f64 / 1e6);
            format!(
                "asks for more than {most:.0} MB of numbers in {file:.3} MB; save it uncompressed, with fewer arrays"
            )
        })?;
        Ok(())
    }
}

/// What a frame of a run says of its points, `[n_points][3]`.
pub struct FramePoints {
    /// [m] positions
    pub positions: Vec<[f64; 3]>,
    /// [m] displacements from the mesh as given, if they are there; perhaps in single precision
    pub displacements: Option<Vec<[f64; 3]>>,
    /// [m/s] velocities, if they are there
    pub velocities: Option<Vec<[f64; 3]>>,
}

/// What a frame of a run says of its lines, in order.
#[derive(Debug)]
pub struct FrameLines {
    /// [-] the points at their ends
    pub ends: Vec<[u64; 2]>,
    /// [N] tensions, if they are there
    pub tensions: Option<Vec<f64>>,
    /// [m] rest lengths, -1 without a spring, if they are there
    pub rest_lengths: Option<Vec<f64>>,
}

/// The arrays on lines that [`frame_lines`] takes.
pub const LINE_ARRAYS: [&str; 2] = ["tension", "rest_length"];

/// Takes the lines of a frame.
///
/// # Errors
/// Why this is no frame of one piece.
pub fn frame_lines(frame: &DataSet) -> Result<FrameLines, String> {
    let piece = only_piece(frame)?;
    let lines: Vec<(usize, [u64; 2])> = piece
        .cells
        .iter()
        .map(|(_, ends)| ends)
        .enumerate()
        .filter_map(|(i, ends)| Some((i, ends.try_into().ok()?)))
        .collect();
    let array = |name| {
        let values = named_array(&piece.cell_data, name)?;
        lines.iter().map(|(cell, _)| values.get(*cell).copied()).collect::<Option<Vec<f64>>>()
    };
    let [tensions, rest_lengths] = LINE_ARRAYS.map(array);
    if [&tensions, &rest_lengths].into_iter().flatten().flatten().any(|value| !value.is_finite()) {
        return Err("has numbers that are not finite".into());
    }
    Ok(FrameLines { ends: lines.iter().map(|(_, ends)| *ends).collect(), tensions, rest_lengths })
}

fn only_piece(frame: &DataSet) -> Result<&Piece, String> {
    match &frame.pieces[..] {
        [piece] => Ok(piece),
        _ => Err("does not hold exactly one piece".into()),
    }
}

/// The arrays on points that [`frame_points`] takes.
pub const POINT_ARRAYS: [&str; 2] = ["displacement", "velocity"];

/// Takes the points of a frame.
///
/// # Errors
/// Why this is no frame of one piece.
pub fn frame_points(frame: &DataSet) -> Result<FramePoints, String> {
    let piece = only_piece(frame)?;
    let array = |name| named_array(&piece.point_data, name).map(|values| values.as_chunks().0.to_vec());
    let [displacement, velocities] = POINT_ARRAYS.map(array);
    let positions = piece.points.clone();
    for list in [&displacement, &velocities].into_iter().flatten() {
        if list.len() != positions.len() {
            return Err("is damaged: an array has not one vector per point".into());
        }
    }
    if positions.iter().chain(velocities.iter().flatten()).flatten().any(|value| !value.is_finite()) {
        return Err("has numbers that are not finite".into());
    }
    Ok(FramePoints { positions, displacements: displacement, velocities })
}
