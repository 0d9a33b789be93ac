//! Reads the frames of a VTKHDF file that [`HdfWriter`](super::HdfWriter) wrote, also while it is being written.

use std::fs::File;
use std::io;

use super::super::read::{CellLists, Column, DataSet, Numbers, Piece};
use super::array_name;
use super::filters::unpack;
use super::header::{Kind, Layout, NOWHERE, ROOT_AT, SIGNATURE, SUPERBLOCK, Shape, message};
use super::region::{Region, word};
use super::tree::find;

/// [byte] largest part of a file of any size, and how much larger than its file a part may be: a damaged file asks for
/// any size
const ANY: usize = 32 << 20;
const TIMES: usize = 1100;

/// A data set of the file.
#[derive(Clone, Debug)]
struct Stored {
    name: String,
    shape: Shape,
    rows: usize,
    layout: Layout,
}

/// The header of a group or data set.
struct Messages(Vec<(u16, Vec<u8>)>);

/// The frames of a file.
#[derive(Debug)]
pub struct HdfFrames {
    file: Reader,
    /// [s] time of every frame
    times: Vec<f64>,
    points: Stored,
    point_data: Vec<Stored>,
    cell_data: Vec<Stored>,
    /// what all frames share: cells and fields
    cells: CellLists,
    fields: Vec<(String, Vec<i64>)>,
}

fn damaged(what: &str) -> String {
    format!("is damaged: {what}")
}

fn system(error: io::Error) -> String {
    match error.kind() {
        io::ErrorKind::InvalidData => damaged(&error.to_string()),
        _ => format!("cannot be read: {error}"),
    }
}

impl HdfFrames {
    /// The frames that a file has by now.
    ///
    /// # Errors
    /// The fault of the file, as the end of a sentence that begins with its name.
    pub fn of(file: File) -> Result<Self, String> {
        let length = file.metadata().map_err(system)?.len();
        let most = ANY.max(TIMES.saturating_mul(length as usize));
        let mut file = Reader { region: Region::new(file, length), most };
        if length < SUPERBLOCK as u64 {
            return Err("is not a VTKHDF file of canopy-fem".to_owned());
        }
        let block = file.read(0, SUPERBLOCK)?;
        if !block.starts_with(&SIGNATURE) || block.get(8) != Some(&1) {
            return Err("is not a VTKHDF file of canopy-fem".to_owned());
        }
        let root = file.header(word(&block[ROOT_AT..]))?;
        let vtk = file.linked(&root, "VTKHDF")?;
        let times = file.times(&vtk)?;
        let mut list = |name| file.data(&vtk, name).and_then(|of| file.rows(&of, 0)).map(Numbers::whole);
        let (ends, corners, types) = (list("Offsets")?, list("Connectivity")?, list("Types")?);
        let ends = ends.into_iter().skip(1).map(|end| usize::try_from(end).unwrap_or(usize::MAX)).collect();
        let cells = CellLists::new(corners, ends, types.into_iter().map(|kind| kind as u8).collect())?;
        let mut fields = Vec::new();
        for field in file.group(&vtk, "FieldData")? {
            let numbers = file.rows(&field, 0)?.whole();
            fields.push((field.name, numbers));
        }
        let (point_data, cell_data) = (file.group(&vtk, "PointData")?, file.group(&vtk, "CellData")?);
        let points = file.data(&vtk, "Points")?;
        Ok(Self { file, times, points, point_data, cell_data, cells, fields })
    }

    /// [s] Times of the frames.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// A frame, with arrays of whole numbers with one a row, and those with the names that are asked for.
    ///
    /// # Errors
    /// The fault of the file, as the end of a sentence that begins with its name.
    pub fn frame(&mut self, step: usize, names: &[&str]) -> Result<DataSet, String> {
        if step >= self.times.len() {
            return Err(format!("has {} frames, and none of number {step}, counted from 0", self.times.len()));
        }
        let Self { file, points, point_data, cell_data, cells, fields, .. } = self;
        let numbers = file.step(points, step)?.reals();
        let (points, []) = numbers.as_chunks::<3>() else { return Err(damaged("a point has not three numbers")) };
        let points = points.to_vec();
        let mut columns = |list: &[Stored]| {
            let whole = |of: &Stored| !matches!(of.shape.kind, Kind::F64 | Kind::F32) && of.shape.components.is_none();
            let wanted = list.iter().filter(|of| whole(of) || names.contains(&of.name.as_str()));
            let column = |of: &Stored| {
                let components = of.shape.components.unwrap_or(1);
                Ok(Column { name: of.name.clone(), components, numbers: file.step(of, step)? })
            };
            wanted.map(column).collect::<Result<Vec<_>, String>>()
        };
        let (point_data, cell_data) = (columns(point_data)?, columns(cell_data)?);
        let piece = Piece { points, cells: cells.clone(), point_data, cell_data };
        Ok(DataSet { pieces: vec![piece], fields: fields.clone() })
    }
}

/// A file with a limit for what is read at once.
#[derive(Debug)]
struct Reader {
    region: Region,
    /// [byte] largest part, unpacked
    most: usize,
}

impl Reader {
    fn read(&mut self, at: u64, length: usize) -> Result<Vec<u8>, String> {
        self.region.read(at, length).map_err(system)
    }

    /// The messages of the header at an address.
    fn header(&mut self, at: u64) -> Result<Messages, String> {
        let prefix = self.read(at, 16)?;
        let length = u32::from_le_bytes(std::array::from_fn(|i| prefix[8 + i]));
        let all = self.read(at.saturating_add(16), length as usize)?;
        let (mut rest, mut found) = (all.as_slice(), Vec::new());
        while let Some((head, after)) = rest.split_at_checked(8) {
            let [number, size] = [0, 2].map(|at| u16::from_le_bytes([head[at], head[at + 1]]));
            let (content, next) =
                after.split_at_checked(size.into()).ok_or_else(|| damaged("a header is cut short"))?;
            found.push((number, content.to_vec()));
            rest = next;
        }
        if prefix[0] == 1 { Ok(Messages(found)) } else { Err(damaged("it has other headers than canopy-fem writes")) }
    }

    fn linked(&mut self, group: &Messages, name: &str) -> Result<Messages, String> {
        let found = group.links().find(|(link, _)| link == name);
        let (_, at) = found.ok_or_else(|| damaged(&format!("it has no {name}")))?;
        self.header(at)
    }

    /// The data sets of a group, by their names.
    fn group(&mut self, parent: &Messages, name: &str) -> Result<Vec<Stored>, String> {
        let group = self.linked(parent, name)?;
        group.links().map(|(name, _)| self.data(&group, &name)).collect()
    }

    fn data(&mut self, group: &Messages, name: &str) -> Result<Stored, String> {
        let header = self.linked(group, name)?;
        header.stored(name).ok_or_else(|| damaged(&format!("{name} is no data set as canopy-fem writes them")))
    }

    /// [s] times of all steps
    fn times(&mut self, vtk: &Messages) -> Result<Vec<f64>, String> {
        let steps = self.linked(vtk, "Steps")?;
        let count = steps.attribute("NSteps").ok_or_else(|| damaged("it has no number of steps"))?;
        let (values, mut times) = (self.data(&steps, "Values")?, Vec::new());
        while times.len() < count {
            let numbers = self.rows(&values, times.len())?.reals();
            let rows = numbers.len().min(count - times.len());
            times.extend(numbers.into_iter().take(rows));
            if rows == 0 {
                return Err(damaged("it has fewer times than steps"));
            }
        }
        Ok(times)
    }

    /// The numbers of an array for a step; the rows of one that does not change are those of every step.
    fn step(&mut self, data: &Stored, step: usize) -> Result<Numbers, String> {
        let first = if data.rows == data.shape.rows { 0 } else { step.saturating_mul(data.shape.rows) };
        self.rows(data, first)
    }

    /// The numbers of the chunk that begins with a row, or of the whole.
    fn rows(&mut self, data: &Stored, first: usize) -> Result<Numbers, String> {
        let Stored { name, shape, layout, .. } = data;
        let length = shape.chunk_bytes();
        if length > self.most {
            return Err(damaged(&format!("{name} is larger than the file can hold")));
        }
        let bytes = match *layout {
            Layout::Whole { at } => self.read(at, length)?,
            Layout::Chunks { tree, packed } => {
                let none = || damaged(&format!("{name} has no numbers from row {first}"));
                let tree = Some(tree).filter(|tree| *tree != NOWHERE).ok_or_else(none)?;
                let chunk = find(*shape, tree, first as u64, &mut self.region).map_err(system)?.ok_or_else(none)?;
                let bytes = self.read(chunk.at, chunk.length as usize)?;
                match packed {
                    true => unpack(&bytes, shape.row_bytes(), chunk.left_out, length).map_err(system)?,
                    false if bytes.len() == length => bytes,
                    false => return Err(damaged(&format!("a part of {name} has the wrong length"))),
                }
            }
        };
        Ok(numbers(&bytes, shape.kind))
    }
}

fn numbers(bytes: &[u8], kind: Kind) -> Numbers {
    fn each<const N: usize, T>(bytes: &[u8], number: impl Fn([u8; N]) -> T) -> Vec<T> {
        bytes.as_chunks().0.iter().map(|word| number(*word)).collect()
    }
    match kind {
        Kind::F64 => Numbers::Real(each(bytes, f64::from_le_bytes)),
        Kind::F32 => Numbers::Real(each(bytes, |word| f32::from_le_bytes(word).into())),
        Kind::I64 => Numbers::Whole(each(bytes, i64::from_le_bytes)),
        Kind::I32 => Numbers::Whole(each(bytes, |word| i32::from_le_bytes(word).into())),
        Kind::U8 => Numbers::Whole(bytes.iter().map(|byte| i64::from(*byte)).collect()),
    }
}

impl Messages {
    fn of(&self, number: u16) -> impl Iterator<Item = &[u8]> {
        self.0.iter().filter(move |(found, _)| *found == number).map(|(_, content)| content.as_slice())
    }

    /// Names and addresses of links, as [`Header::link`](super::header::Header::link) writes them.
    fn links(&self) -> impl Iterator<Item = (String, u64)> {
        self.of(message::LINK).filter_map(|content| {
            let length = usize::from(u16::from_le_bytes([*content.get(3)?, *content.get(4)?]));
            let (name, rest) = content.get(5..)?.split_at_checked(length)?;
            let at = rest.first_chunk().map(|address| u64::from_le_bytes(*address))?;
            Some((String::from_utf8(name.to_vec()).ok()?, at)).filter(|_| content.starts_with(&[1, 0x11, 1]))
        })
    }

    /// A number that is an attribute: the last eight bytes of its message.
    fn attribute(&self, name: &str) -> Option<usize> {
        let content = self.of(message::ATTRIBUTE).find(|content| {
            content.get(8..).is_some_and(|text| text.starts_with(name.as_bytes()) && text.get(name.len()) == Some(&0))
        })?;
        content.last_chunk().and_then(|number| usize::try_from(u64::from_le_bytes(*number)).ok())
    }

    fn stored(&self, name: &str) -> Option<Stored> {
        let space = self.of(message::DATASPACE).next()?;
        let rank = usize::from(*space.get(1)?);
        let dim = |i: usize| usize::try_from(word(space.get(8 + 8 * i..16 + 8 * i)?)).ok();
        let (rows, components) = (dim(0)?, if rank == 2 { Some(dim(1)?) } else { None });
        let kind = Kind::of(self.of(message::DATATYPE).next()?)?;
        let layout = self.of(message::LAYOUT).next()?;
        let (layout, chunk) = match (layout.get(1)?, rank) {
            (1, 1 | 2) => (Layout::Whole { at: word(layout.get(2..10)?) }, rows),
            (2, 1 | 2) => {
                let chunk = layout.get(11..15)?.first_chunk().map(|rows| u32::from_le_bytes(*rows))?;
                let packed = self.of(message::FILTERS).next().is_some();
                (Layout::Chunks { tree: word(layout.get(3..11)?), packed }, chunk as usize)
            }
            _ => return None,
        };
        let shape = Shape { kind, components, rows: chunk };
        // Sizes that no chunk has.
        kind.size().checked_mul(components.unwrap_or(1))?.checked_mul(chunk)?;
        Some(Stored { name: array_name(name), shape, rows, layout })
    }
}
