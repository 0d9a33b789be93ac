//! The frames of a run as one series: a .vtu file for each and the .pvd that lists them, or one VTKHDF file.

use std::path::{Path, PathBuf};

use super::atomic::{Durability, replace};
use super::csv::write_fault;
use super::files::FilesSpec;
use super::frame::Frame;
use super::frame_arrays::{FrameArrays, cells_of, with_parts};
use super::frame_files::{FrameFiles, vtu_error};
use super::pvd::{Collection, CollectionMark};
use super::resume::{ResumeError, open_plain};
use crate::drive::observer::ObserveError;
use crate::vtk::hdf::{HdfFrames, HdfScene, HdfWriter};
use crate::vtk::write::VtuError;
use crate::vtk::{FrameFormat, HDF_ENDING};

/// The frames of a run, in the format of its case.
#[derive(Debug)]
pub(super) enum FrameSeries {
    /// files and their list
    Files(Box<FrameFiles>, Collection),
    /// one file
    One(Box<HdfSeries>),
}

/// The VTKHDF file of a run.
#[derive(Debug)]
pub(super) struct HdfSeries {
    path: PathBuf,
    arrays: FrameArrays,
    writer: HdfWriter,
    /// [s] of the frames
    times: Vec<f64>,
}

/// The list of the frames of a run.
fn list_of(spec: &FilesSpec<'_>) -> PathBuf {
    spec.folder.join(format!("{}.pvd", spec.stem))
}

/// The one file of a run.
fn one_of(spec: &FilesSpec<'_>) -> PathBuf {
    spec.folder.join(format!("{}.{HDF_ENDING}", spec.stem))
}

impl FrameSeries {
    /// Makes ready for the first frame.
    ///
    /// # Errors
    /// When something cannot be created, or a cell names a node that does not exist.
    pub(super) fn create(spec: &FilesSpec<'_>) -> Result<Self, ObserveError> {
        Ok(match spec.format.file {
            FrameFormat::Vtu => Self::Files(Box::new(FrameFiles::create(spec)?), Collection::new(&list_of(spec))),
            FrameFormat::Vtkhdf => Self::One(Box::new(HdfSeries::create(spec)?)),
        })
    }

    /// Checks that the frames of a mark are there; nothing is changed.
    ///
    /// # Errors
    /// Frames that are missing or have changed.
    pub(super) fn check(spec: &FilesSpec<'_>, mark: CollectionMark) -> Result<(), ResumeError> {
        match spec.format.file {
            FrameFormat::Vtu => {
                Collection::read(&list_of(spec), mark)?;
                FrameFiles::check(spec, mark.frames)
            }
            FrameFormat::Vtkhdf => HdfSeries::check(spec, mark.frames),
        }
    }

    /// Goes on after the frames of a mark; later ones are removed.
    ///
    /// # Errors
    /// As [`FrameSeries::check`], and when a frame cannot be removed.
    pub(super) fn reopen(spec: &FilesSpec<'_>, mark: CollectionMark) -> Result<Self, ResumeError> {
        Ok(match spec.format.file {
            FrameFormat::Vtu => {
                let mut collection = Collection::read(&list_of(spec), mark)?;
                // The collection first, so that it never lists a missing frame.
                collection.write(Durability::Visible)?;
                Self::Files(Box::new(FrameFiles::reopen(spec, mark.frames)?), collection)
            }
            FrameFormat::Vtkhdf => Self::One(Box::new(HdfSeries::open(spec, mark.frames)?)),
        })
    }

    /// Number of frames so far.
    pub(super) fn frames(&self) -> u64 {
        match self {
            Self::Files(_, collection) => collection.frames(),
            Self::One(one) => one.writer.frames(),
        }
    }

    /// Its present state, for a checkpoint.
    pub(super) fn mark(&self) -> CollectionMark {
        match self {
            Self::Files(_, collection) => collection.mark(),
            Self::One(one) => CollectionMark { frames: one.writer.frames(), ..CollectionMark::default() },
        }
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// Errors of the system.
    pub(super) fn write(&mut self, frame: &Frame) -> Result<(), ObserveError> {
        match self {
            Self::Files(files, collection) => {
                let file = files.write(frame, collection.frames())?;
                collection.push(frame.time, &file);
            }
            Self::One(one) => one.write(frame)?,
        }
        Ok(())
    }

    /// Writes the list of frames if it has waited long enough.
    ///
    /// # Errors
    /// Errors of the system.
    pub(super) fn write_if_due(&mut self) -> Result<(), ObserveError> {
        match self {
            Self::Files(_, collection) => collection.write_if_due(),
            Self::One(_) => Ok(()),
        }
    }

    /// Shows all frames so far in the list.
    ///
    /// # Errors
    /// Errors of the system.
    pub(super) fn finish(&mut self) -> Result<(), ObserveError> {
        match self {
            Self::Files(_, collection) if collection.frames() > 0 => collection.write(Durability::Visible),
            _ => Ok(()),
        }
    }

    /// Makes all frames durable, and then their list.
    ///
    /// # Errors
    /// Errors of the system.
    pub(super) fn sync(&mut self) -> Result<(), ObserveError> {
        match self {
            Self::Files(files, collection) => {
                files.sync(collection.frames())?;
                if collection.frames() > 0 { collection.write(Durability::Synced) } else { Ok(()) }
            }
            Self::One(one) => one.writer.sync().map_err(|e| write_fault(&one.path, e)),
        }
    }

    /// Removes the frames after a time [s], which are the last. `before` is called with the number of the others, when
    /// nothing leads to those that go, and they are still there.
    ///
    /// # Errors
    /// Errors of the system.
    pub(super) fn withdraw_after(
        &mut self,
        t: f64,
        before: impl FnOnce(u64) -> Result<(), ObserveError>,
    ) -> Result<(), ObserveError> {
        match self {
            Self::Files(files, collection) => {
                let all = collection.frames();
                let left = collection.withdraw_after(t);
                // The collection first, so that it never lists a missing frame.
                collection.write(Durability::Visible)?;
                before(left)?;
                files.remove(left..all)
            }
            Self::One(one) => {
                let left = one.times.iter().rposition(|time| *time <= t).map_or(0, |last| last + 1);
                before(left as u64)?;
                one.times.truncate(left);
                one.writer.cut(left as u64).map_err(|e| write_fault(&one.path, vtu_error(e)))
            }
        }
    }
}

impl HdfSeries {
    fn create(spec: &FilesSpec<'_>) -> Result<Self, ObserveError> {
        let path = one_of(spec);
        let fault = |e| write_fault(&path, vtu_error(e));
        let empty = with_scene(spec, HdfWriter::empty).map_err(fault)?;
        replace(&path, &empty, Durability::Visible).map_err(|e| write_fault(&path, e))?;
        let writer = with_scene(spec, |scene| HdfWriter::open(&path, scene, 0)).map_err(fault)?;
        Ok(Self { path, arrays: FrameArrays::new(spec), writer, times: Vec::new() })
    }

    fn check(spec: &FilesSpec<'_>, frames: u64) -> Result<(), ResumeError> {
        let path = one_of(spec);
        drop(open_plain(&path)?);
        with_scene(spec, |scene| HdfWriter::check(&path, scene, frames)).map_err(|e| wrong(&path, e))
    }

    fn open(spec: &FilesSpec<'_>, frames: u64) -> Result<Self, ResumeError> {
        let path = one_of(spec);
        let writer = with_scene(spec, |scene| HdfWriter::open(&path, scene, frames)).map_err(|e| wrong(&path, e))?;
        let times = HdfFrames::of(open_plain(&path)?).map(|frames| frames.times().to_vec());
        let times = times.map_err(|what| ResumeError::Unfit { path: path.display().to_string(), what })?;
        Ok(Self { path, arrays: FrameArrays::new(spec), writer, times })
    }

    fn write(&mut self, frame: &Frame) -> Result<(), ObserveError> {
        let Self { path, arrays, writer, times } = self;
        arrays.show(frame, |picture| writer.frame(picture)).map_err(|e| write_fault(path, vtu_error(e)))?;
        times.push(frame.time);
        Ok(())
    }
}

/// What does not change in a run.
fn with_scene<T>(spec: &FilesSpec<'_>, then: impl FnOnce(&HdfScene<'_>) -> T) -> T {
    let (mut arrays, cells) = (FrameArrays::new(spec), cells_of(spec));
    let parts = FrameArrays::new(spec);
    arrays.show_zeros(spec, |frame| {
        with_parts(spec, &parts, |fixed| then(&HdfScene { cells: &cells, fixed, format: spec.format, frame }))
    })
}

/// Why a file cannot be continued.
fn wrong(path: &Path, fault: VtuError) -> ResumeError {
    match vtu_error(fault) {
        e if e.kind() == std::io::ErrorKind::InvalidData => {
            ResumeError::Unfit { path: path.display().to_string(), what: e.to_string() }
        }
        e => ResumeError::system(path, e),
    }
}
