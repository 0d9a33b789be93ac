//! Where the frames of a run are, and their content: in files of their own, or in one.

use crate::input_file;
use crate::vtk::hdf::HdfFrames;
use crate::vtk::read::{DataSet, read};
use crate::vtk::{FRAMES, HDF_ENDING};
use std::io;
use std::path::{Path, PathBuf};

/// Where a frame is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FramePlace {
    /// the file
    pub file: PathBuf,
    /// its number in a file that holds all frames of a run
    pub number: Option<usize>,
}

/// Why a frame cannot be read.
#[derive(Debug)]
pub enum FrameFault {
    /// the system's error
    System(io::Error),
    /// the fault of the file, as the end of a sentence that begins with its name
    Content(String),
}

impl std::fmt::Display for FrameFault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            FrameFault::System(error) => error.fmt(f),
            FrameFault::Content(what) => what.fmt(f),
        }
    }
}

/// Reads frames; a file that holds several is kept open.
#[derive(Debug, Default)]
pub struct FrameReader {
    opened: Option<(PathBuf, HdfFrames)>,
}

impl FrameReader {
    /// A frame with its arrays of whole numbers with one a row, and those with the names that are asked for.
    ///
    /// # Errors
    /// A file that is missing or damaged.
    pub fn read(&mut self, place: &FramePlace, names: &[&str]) -> Result<DataSet, FrameFault> {
        let Some(number) = place.number else {
            let bytes = input_file::read(&place.file).map_err(FrameFault::System)?;
            return read(&bytes, names).map_err(FrameFault::Content);
        };
        let opened = self.opened.take().filter(|(file, _)| *file == place.file);
        let (file, mut frames) = match opened {
            Some(opened) => opened,
            None => (place.file.clone(), open(&place.file)?),
        };
        let frame = frames.frame(number, names).map_err(FrameFault::Content);
        self.opened = Some((file, frames));
        frame
    }
}

fn open(file: &Path) -> Result<HdfFrames, FrameFault> {
    let opened = input_file::open(file).map_err(FrameFault::System)?;
    HdfFrames::of(opened).map_err(FrameFault::Content)
}

/// Whether a file has the name of one that holds all frames of a run.
pub fn holds_all(file: &Path) -> bool {
    file.extension().is_some_and(|ending| ending == HDF_ENDING)
}

/// Times [s] and places of the frames in a file that holds all of a run, as far as they are written.
///
/// # Errors
/// A file that is missing or damaged.
pub fn frames_of(file: &Path) -> Result<Vec<(f64, FramePlace)>, FrameFault> {
    let frames = open(file)?;
    let place = |number| FramePlace { file: file.to_owned(), number: Some(number) };
    Ok(frames.times().iter().enumerate().map(|(number, t)| (*t, place(number))).collect())
}

/// The last frame in the file that holds all of a run.
///
/// # Errors
/// A file that is missing, damaged or without frames, as the end of a sentence that begins with its name.
pub fn last_of(file: &Path) -> Result<FramePlace, String> {
    let frames = frames_of(file).map_err(|fault| fault.to_string())?;
    frames.into_iter().last().map(|(_, place)| place).ok_or_else(|| "holds no frames yet".to_owned())
}

/// The newest frame in the folder of a run.
///
/// # Errors
/// No frames, or several files that hold some.
pub fn last_in(folder: &Path) -> Result<FramePlace, String> {
    let own = folder.join(FRAMES);
    let entries = match std::fs::read_dir(&own) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return last_of_one(folder, &own, &error),
        entries => entries.map_err(|e| format!("{}: {e}", own.display()))?,
    };
    let number = |path: &Path| -> Option<u64> {
        let stem = path.extension().is_some_and(|end| end == "vtu").then(|| path.file_stem())??.to_str()?;
        stem.rsplit_once(['.', '_', '-']).map_or(stem, |(_, number)| number).parse().ok()
    };
    let paths = entries.filter_map(Result::ok).map(|entry| entry.path());
    let newest = paths.filter_map(|path| Some((number(&path)?, path))).max();
    let place = |(_, file)| FramePlace { file, number: None };
    newest.map(place).ok_or_else(|| format!("{} holds no frames", own.display()))
}

/// The newest frame in the only file of a folder that holds all of a run.
fn last_of_one(folder: &Path, own: &Path, error: &io::Error) -> Result<FramePlace, String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().filter_map(Result::ok).map(|entry| entry.path());
    let mut files: Vec<PathBuf> = entries.filter(|path| holds_all(path)).collect();
    match (files.len(), files.pop()) {
        (1, Some(only)) => last_of(&only).map_err(|what| format!("{}: {what}", only.display())),
        (0, _) | (_, None) => Err(format!("{}: {error}", own.display())),
        (_, Some(one)) => {
            let folder = folder.display();
            Err(format!(
                "{folder} holds frames of several runs; name the file of one, as {{\"frame\": \"{}\"}}",
                one.display()
            ))
        }
    }
}
