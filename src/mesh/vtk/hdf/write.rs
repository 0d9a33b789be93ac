//! Writes the frames of a run into one VTKHDF file.

use std::fs::{File, OpenOptions};
use std::io;
use std::path::Path;

use super::super::cells::VtuError;
use super::super::encode::{little_endian, little_endian_f32};
use super::super::write::{Array, Snapshot, Values, right};
use super::super::{Compression, VtuFormat};
use super::filters::pack;
use super::head::{Growing, HdfScene, Head, Lists, STEPS};
use super::header::{Kind, LENGTH_AT};
use super::region::{Region, word};
use super::tree::{Chunk, find};

/// Adds frames to a file.
#[derive(Debug)]
pub struct HdfWriter {
    region: Region,
    format: VtuFormat,
    points: usize,
    cells: usize,
    frames: u64,
    /// points, arrays on points, arrays on cells
    arrays: Vec<Growing>,
    pub(super) lists: Lists,
    /// [byte] what precedes the first frame
    head: u64,
    numbers: Vec<u8>,
    shuffled: Vec<u8>,
    packed: Vec<u8>,
}

impl HdfWriter {
    /// The bytes of a file without frames.
    ///
    /// # Errors
    /// When a cell names a point that does not exist, or an array has the wrong length.
    pub fn empty(scene: &HdfScene<'_>) -> Result<Vec<u8>, VtuError> {
        Ok(Head::new(scene)?.image)
    }

    /// Opens a file to go on after its first `frames` frames; later ones are removed.
    ///
    /// # Errors
    /// As [`HdfWriter::check`], and errors of the system.
    pub fn open(path: &Path, scene: &HdfScene<'_>, frames: u64) -> Result<Self, VtuError> {
        let mut writer = Self::of_file(OpenOptions::new().read(true).write(true).open(path)?, scene, frames)?;
        writer.cut(frames)?;
        Ok(writer)
    }

    /// Checks that a file is one of this scene with at least so many frames.
    ///
    /// # Errors
    /// A file that is missing, damaged or of another scene, or has fewer frames.
    pub fn check(path: &Path, scene: &HdfScene<'_>, frames: u64) -> Result<(), VtuError> {
        Self::of_file(File::open(path)?, scene, frames).map(drop)
    }

    fn of_file(file: File, scene: &HdfScene<'_>, frames: u64) -> Result<Self, VtuError> {
        let Head { mut image, cells, arrays, lists } = Head::new(scene)?;
        let wrong = |what: String| VtuError::Write(io::Error::new(io::ErrorKind::InvalidData, what));
        let end = file.metadata()?.len();
        let mut region = Region::new(file, end);
        let found = region.read(0, image.len())?;
        let grown = arrays.iter().chain(&lists.stored).flat_map(|of| [of.rows_at, of.root_at]);
        for at in grown.chain(lists.same_rows_at).chain([LENGTH_AT, lists.steps_at]) {
            let at = at as usize;
            image[at..at + 8].copy_from_slice(&found[at..at + 8]);
        }
        if image != found {
            return Err(wrong("it is damaged, or of another case".to_owned()));
        }
        let there = word(&found[lists.steps_at as usize..]);
        if there < frames {
            return Err(wrong(format!("it holds {there} frames, and not {frames}")));
        }
        let head = image.len() as u64;
        let points = scene.cells.points;
        let [numbers, shuffled, packed] = [(); 3].map(|()| Vec::new());
        let format = scene.format;
        Ok(Self { region, format, points, cells, frames: there, arrays, lists, head, numbers, shuffled, packed })
    }

    /// Number of frames.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Adds a frame, with the arrays of the scene in their order.
    ///
    /// # Errors
    /// When an array has the wrong length, or writing fails.
    pub fn frame(&mut self, frame: &Snapshot<'_>) -> Result<(), VtuError> {
        self.add(frame)?;
        Ok(self.publish(self.frames + 1)?)
    }

    /// Writes all of a frame but what makes it visible.
    pub(super) fn add(&mut self, frame: &Snapshot<'_>) -> Result<(), VtuError> {
        let points = [Array { name: "Points", values: Values::Vectors(frame.points) }];
        let on_points = points.iter().chain(frame.point_data).map(|array| (array, self.points));
        let all = on_points.chain(frame.cell_data.iter().map(|array| (array, self.cells)));
        for (growing, (array, rows)) in self.arrays.iter_mut().zip(all) {
            right(array.name, array.values.rows(), rows)?;
            encode(array.values, growing.shape.kind, &mut self.numbers);
            let Self { numbers, shuffled, packed, .. } = self;
            let (bytes, left_out) = match self.format.compression {
                Compression::None => (&*numbers, 0),
                Compression::Zlib => {
                    let left_out = pack(numbers, growing.shape.row_bytes(), shuffled, packed)?;
                    (&*packed, left_out)
                }
            };
            let chunk = Chunk { at: self.region.append(bytes), length: bytes.len() as u32, left_out };
            growing.tree.push(chunk, &mut self.region);
        }
        let step = self.frames;
        let first = |rows: usize| (step * rows as u64).to_le_bytes();
        let values = [frame.time.unwrap_or_default().to_le_bytes(), first(self.points), first(self.cells)];
        let lists = &mut self.lists;
        for ((list, last), value) in lists.stored.iter_mut().zip(&mut lists.last).zip(values) {
            let place = step as usize % STEPS;
            if place == 0 {
                let mut numbers = [0; 8 * STEPS];
                numbers[..8].copy_from_slice(&value);
                *last = self.region.append(&numbers);
                list.tree.push(Chunk { at: *last, length: numbers.len() as u32, left_out: 0 }, &mut self.region);
            } else {
                self.region.patch(*last + 8 * place as u64, &value);
            }
        }
        self.patch_rows(step + 1);
        Ok(self.region.write()?)
    }

    /// Changes the number of frames and the lengths of all lists of steps, in one write: VTK 9.7 writes over its memory
    /// where it finds more times than steps.
    fn publish(&mut self, frames: u64) -> io::Result<()> {
        let Lists { stored, same_rows_at: [zeros, ones], steps_at, .. } = &self.lists;
        let [values, on_points, on_cells] = stored.each_ref().map(|list| list.rows_at);
        let places = [values, on_points, on_cells, *zeros, *ones, *steps_at];
        let start = places.into_iter().fold(*steps_at, u64::min);
        let end = 8 + places.into_iter().fold(*steps_at, u64::max);
        let mut bytes = self.region.read(start, (end - start) as usize)?;
        for place in places.map(|at| (at - start) as usize) {
            bytes[place..place + 8].copy_from_slice(&frames.to_le_bytes());
        }
        self.region.patch(start, &bytes);
        self.frames = frames;
        self.region.write()
    }

    /// Removes all frames but the first ones.
    ///
    /// # Errors
    /// Errors of the system, or an index that is damaged.
    pub fn cut(&mut self, frames: u64) -> Result<(), VtuError> {
        self.publish(frames)?;
        self.patch_rows(frames);
        let mut end = self.head;
        for array in &mut self.arrays {
            end = end.max(array.tree.cut(frames, &mut self.region)?);
        }
        let lists = &mut self.lists;
        for (list, last) in lists.stored.iter_mut().zip(&mut lists.last) {
            let root = word(&self.region.read(list.root_at, 8)?);
            end = end.max(list.tree.cut(frames.div_ceil(STEPS as u64), &mut self.region)?);
            let Some(step) = frames.checked_sub(1) else { continue };
            let first = step - step % STEPS as u64;
            let damaged = || io::Error::new(io::ErrorKind::InvalidData, "its index is damaged");
            *last = find(list.shape, root, first, &mut self.region)?.ok_or_else(damaged)?.at;
            let used = 8 * (frames - first) as usize;
            self.region.patch(*last + used as u64, &vec![0; 8 * STEPS - used]);
        }
        Ok(self.region.cut(end)?)
    }

    /// Makes all frames durable.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn sync(&self) -> io::Result<()> {
        self.region.sync()
    }

    fn patch_rows(&mut self, frames: u64) {
        for array in &self.arrays {
            self.region.patch(array.rows_at, &(frames * array.shape.rows as u64).to_le_bytes());
        }
    }
}

impl Values<'_> {
    /// Number of values.
    fn rows(&self) -> usize {
        match self {
            Values::Scalars(values) => values.len(),
            Values::Vectors(values) => values.len(),
            Values::Flags(values) => values.len(),
        }
    }
}

/// The bytes of an array.
fn encode(values: Values<'_>, kind: Kind, out: &mut Vec<u8>) {
    let real = match values {
        Values::Scalars(values) => values,
        Values::Vectors(values) => values.as_flattened(),
        Values::Flags(flags) => {
            out.clear();
            return out.extend_from_slice(flags);
        }
    };
    if kind == Kind::F32 {
        return little_endian_f32(real, out);
    }
    out.clear();
    out.extend_from_slice(&little_endian(real));
}
