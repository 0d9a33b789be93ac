//! The .vtu files of a run.

use std::fs::{self, OpenOptions};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::atomic::{Durability, replace_by, sync_folder};
use super::csv::write_fault;
use super::files::{FRAMES, FilesSpec};
use super::frame::Frame;
use super::frame_arrays::{FrameArrays, cells_of, with_parts};
use super::resume::ResumeError;
use crate::drive::observer::ObserveError;
use crate::vtk::write::{VtuError, VtuWriter};

/// Writes frames one by one; each is complete before it gets its final name.
#[derive(Debug)]
pub(crate) struct FrameFiles {
    folder: PathBuf,
    stem: String,
    vtu: VtuWriter,
    arrays: FrameArrays,
    /// number of the first frame that may not be on the disk yet
    unsynced: u64,
}

/// The name of a frame.
fn name_of(stem: &str, number: u64) -> String {
    format!("{stem}_{number:06}.vtu")
}

/// The number in the name of a frame; `None` for any other name.
pub(crate) fn number_of(stem: &str, name: &str) -> Option<u64> {
    let digits = name.strip_prefix(stem)?.strip_prefix('_')?.strip_suffix(".vtu")?;
    let number = digits.bytes().all(|b| b.is_ascii_digit()).then(|| digits.parse().ok())??;
    (name_of(stem, number) == name).then_some(number)
}

impl FrameFiles {
    /// Creates the folder.
    ///
    /// # Errors
    /// When it cannot be created, or a cell names a node that does not exist.
    pub(crate) fn create(spec: &FilesSpec<'_>) -> Result<Self, ObserveError> {
        let folder = spec.folder.join(FRAMES);
        fs::create_dir_all(&folder).map_err(|e| write_fault(&folder, e))?;
        let arrays = FrameArrays::new(spec);
        let vtu = VtuWriter::new(&cells_of(spec), spec.format)
            .and_then(|vtu| with_parts(spec, &arrays, |parts| vtu.with_fixed(parts)))
            .map_err(|e| write_fault(&folder, vtu_error(e)))?;
        Ok(Self { folder, stem: spec.stem.clone(), vtu, arrays, unsynced: 0 })
    }

    /// Continues after `frames` frames of an earlier run; later ones are removed.
    ///
    /// # Errors
    /// As [`FrameFiles::create`], and when a frame cannot be removed.
    pub(crate) fn reopen(spec: &FilesSpec<'_>, frames: u64) -> Result<Self, ObserveError> {
        let mut made = Self::create(spec)?;
        made.unsynced = frames;
        let folder = &made.folder;
        for path in frames_in(folder, &spec.stem).map_err(|e| write_fault(folder, e))? {
            let number = path.file_name().and_then(|name| number_of(&spec.stem, name.to_str()?));
            // Without a number it is the temporary file of a frame that was being written when the run was killed.
            if number.is_none_or(|number| number >= frames) {
                fs::remove_file(&path).map_err(|e| write_fault(&path, e))?;
            }
        }
        Ok(made)
    }

    /// Checks that the first `frames` frames exist.
    ///
    /// # Errors
    /// The first missing frame.
    pub(crate) fn check(spec: &FilesSpec<'_>, frames: u64) -> Result<(), ResumeError> {
        let folder = spec.folder.join(FRAMES);
        for number in 0..frames {
            let path = folder.join(name_of(&spec.stem, number));
            match fs::symlink_metadata(&path) {
                Ok(there) if there.is_file() => {}
                Ok(_) => return Err(ResumeError::NoFile { path: path.display().to_string() }),
                Err(e) if e.kind() == io::ErrorKind::NotFound => {
                    return Err(ResumeError::Missing { path: path.display().to_string() });
                }
                Err(e) => return Err(ResumeError::system(&path, e)),
            }
        }
        Ok(())
    }

    /// Writes frame `number`; returns its path from the folder of the results.
    ///
    /// # Errors
    /// Errors of the system; the frame then does not exist.
    pub(crate) fn write(&mut self, frame: &Frame, number: u64) -> Result<String, ObserveError> {
        let name = name_of(&self.stem, number);
        let path = self.folder.join(&name);
        let Self { vtu, arrays, .. } = self;
        arrays
            .show(frame, |picture| {
                replace_by(&path, Durability::Visible, |file| vtu.write(picture, file).map_err(vtu_error))
            })
            .map_err(|e| write_fault(&path, e))?;
        Ok(format!("{FRAMES}/{name}"))
    }

    /// Removes frames by their numbers.
    pub(crate) fn remove(&mut self, frames: Range<u64>) -> Result<(), ObserveError> {
        self.unsynced = self.unsynced.min(frames.start);
        for number in frames {
            let path = self.folder.join(name_of(&self.stem, number));
            match fs::remove_file(&path) {
                Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(write_fault(&path, e)),
                _ => {}
            }
        }
        Ok(())
    }

    /// Makes the frames before number `frames` durable.
    pub(crate) fn sync(&mut self, frames: u64) -> Result<(), ObserveError> {
        for number in self.unsynced..frames {
            let path = self.folder.join(name_of(&self.stem, number));
            match OpenOptions::new().write(true).open(&path).and_then(|file| file.sync_all()) {
                // The user has removed it; a resumed run will report that.
                Err(e) if e.kind() == io::ErrorKind::NotFound => {}
                done => done.map_err(|e| write_fault(&path, e))?,
            }
        }
        if self.unsynced < frames {
            sync_folder(&self.folder);
            self.unsynced = frames;
        }
        Ok(())
    }
}

/// The frames of one run in a folder, also the part of one that was never finished.
pub(crate) fn frames_in(folder: &Path, stem: &str) -> Result<Vec<PathBuf>, io::Error> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name();
        let Some(name) = name.to_str() else { continue };
        let whole = name.strip_prefix('.').and_then(|rest| rest.strip_suffix(".part")).unwrap_or(name);
        let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
        if !is_folder && number_of(stem, whole).is_some() {
            found.push(entry.path());
        }
    }
    found.sort();
    Ok(found)
}

pub(super) fn vtu_error(fault: VtuError) -> io::Error {
    match fault {
        VtuError::Write(source) => source,
        other => io::Error::new(io::ErrorKind::InvalidInput, other),
    }
}
