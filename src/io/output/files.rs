//! The files of a run, used by the writing thread.

use std::fs;
use std::io::Write;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::atomic::{Durability, part_path, replace};
use super::checkpoint::Checkpoint;
use super::csv::{CsvFile, write_fault};
use super::folder::{CHECKPOINT, SUMMARY};
use super::frame::{Fields, Frame, FrameSize};
use super::gauges::GaugeRow;
use super::pvd::CollectionMark;
use super::resume::FilePrefix;
use super::resume::ResumeError;
use super::rows::{GAUGES_HEADER, HISTORY_HEADER, HistoryRow, PROBES_HEADER, write_probes};
use super::sanitize::csv_field;
use super::series::FrameSeries;
use crate::case::spec::ProbeSpec;
use crate::drive::observer::ObserveError;
use crate::mesh::Groups;
use crate::vtk::VtuFormat;

pub use crate::vtk::FRAMES;
/// One row per step, or per n steps.
pub const HISTORY: &str = "history.csv";
/// Chosen nodes at each frame time.
pub const PROBES: &str = "probes.csv";

/// Gauges at every step, or every so many.
pub const GAUGES: &str = "gauges.csv";

/// The data of the run for the writing thread; everything in the user's numbering.
#[derive(Clone, Debug)]
pub struct FilesSpec<'a> {
    /// folder of the results
    pub folder: PathBuf,
    /// stem of the .pvd and the frames, see [`super::sanitize::file_stem`]
    pub stem: String,
    /// [m] positions of zero displacement
    pub reference: &'a [[f64; 3]],
    /// triangles of the picture
    pub triangles: &'a [[u32; 3]],
    /// edges of the picture
    pub edges: &'a [[u32; 2]],
    /// named parts of the picture
    pub groups: &'a Groups,
    /// fields to write
    pub fields: Fields,
    /// whether edges that are sides of triangles are drawn
    pub draw_sides: bool,
    /// nodes to follow; `probes.csv` is written only if there are any
    pub probes: &'a [ProbeSpec],
    /// names and quantities of the gauges' channels; `gauges.csv` is written only if there are any
    pub gauges: Vec<[String; 2]>,
    /// encoding of the frames' arrays
    pub format: VtuFormat,
}

impl FilesSpec<'_> {
    /// Sizes of the frames of the run.
    pub(super) fn frame_size(&self) -> FrameSize {
        FrameSize {
            nodes: self.reference.len(),
            edges: self.edges.len(),
            triangles: self.triangles.len(),
            fields: self.fields,
        }
    }
}

/// State of the result files when a checkpoint was written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct FilesProgress {
    /// frames in the collection
    pub collection: CollectionMark,
    /// rows of the history
    pub history: FilePrefix,
    /// rows of the probes, if there are any
    pub probes: Option<FilePrefix>,
    /// rows of the gauges, if there are any
    pub gauges: Option<FilePrefix>,
}

/// The open files of a run.
#[derive(Debug)]
pub struct ResultFiles {
    frames: FrameSeries,
    history: CsvFile,
    probes: Option<CsvFile>,
    /// names, quoted for csv
    followed: Vec<ProbeSpec>,
    gauges: Option<CsvFile>,
    /// name and quantity of every channel, as in a row
    channels: Vec<String>,
    checkpoint: PathBuf,
    /// buffer for the bytes of a checkpoint
    encoded: Vec<u8>,
    /// frames that the checkpoint counts
    frames_kept: u64,
}

impl ResultFiles {
    /// Creates `history.csv`, `probes.csv` if there are probes, and what holds the frames.
    ///
    /// # Errors
    /// When something cannot be created, or a cell names a node that does not exist.
    pub fn create(spec: &FilesSpec<'_>) -> Result<Self, ObserveError> {
        let path = |name: &str| spec.folder.join(name);
        let frames = FrameSeries::create(spec)?;
        let probes = (!spec.probes.is_empty()).then(|| CsvFile::create(&path(PROBES), PROBES_HEADER)).transpose()?;
        Ok(Self {
            frames,
            history: CsvFile::create(&path(HISTORY), HISTORY_HEADER)?,
            probes,
            followed: quoted(spec.probes),
            gauges: (!spec.gauges.is_empty()).then(|| CsvFile::create(&path(GAUGES), GAUGES_HEADER)).transpose()?,
            channels: labels(&spec.gauges),
            checkpoint: path(CHECKPOINT),
            encoded: Vec::new(),
            frames_kept: 0,
        })
    }

    /// Continues the files of an earlier run. It checks everything before it changes anything. Then it removes what was
    /// written after the checkpoint, `summary.json` included, in an order after which a run can be resumed at any time.
    ///
    /// # Errors
    /// When the files have changed, are in use, or cannot be opened or changed.
    pub fn reopen(spec: &FilesSpec<'_>, mark: &FilesProgress) -> Result<Self, ResumeError> {
        let path = |name: &str| spec.folder.join(name);
        let (history, probes, gauges, summary) = (path(HISTORY), path(PROBES), path(GAUGES), path(SUMMARY));
        mark.history.check(&history)?;
        mark.probes.map(|mark| mark.check(&probes)).transpose()?;
        mark.gauges.map(|mark| mark.check(&gauges)).transpose()?;
        FrameSeries::check(spec, mark.collection)?;
        let history = CsvFile::reopen(&history, mark.history)?;
        for leftover in [&summary, &part_path(&summary), &part_path(&path(CHECKPOINT))] {
            match fs::remove_file(leftover) {
                Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(ResumeError::system(leftover, e)),
                _ => {}
            }
        }
        let frames = FrameSeries::reopen(spec, mark.collection)?;
        Ok(Self {
            frames,
            history,
            probes: mark.probes.map(|mark| CsvFile::reopen(&probes, mark)).transpose()?,
            followed: quoted(spec.probes),
            gauges: mark.gauges.map(|mark| CsvFile::reopen(&gauges, mark)).transpose()?,
            channels: labels(&spec.gauges),
            checkpoint: path(CHECKPOINT),
            encoded: Vec::new(),
            frames_kept: mark.collection.frames,
        })
    }

    /// Makes all results durable, and then the checkpoint that counts them.
    ///
    /// # Errors
    /// Errors of the system; the earlier checkpoint is then kept.
    pub fn checkpoint(&mut self, mut checkpoint: Checkpoint) -> Result<(), ObserveError> {
        let history = self.history.sync()?;
        let probes = self.probes.as_mut().map(CsvFile::sync).transpose()?;
        let gauges = self.gauges.as_mut().map(CsvFile::sync).transpose()?;
        self.frames.sync()?;
        self.frames_kept = self.frames.frames();
        checkpoint.files = FilesProgress { collection: self.frames.mark(), history, probes, gauges };
        let path = &self.checkpoint;
        checkpoint.encode(&mut self.encoded).map_err(|e| write_fault(path, e))?;
        replace(path, &self.encoded, Durability::Synced).map_err(|e| write_fault(path, e))
    }

    /// Writes a frame and its probes.
    pub fn frame(&mut self, frame: &Frame) -> Result<(), ObserveError> {
        self.frames.write(frame)?;
        if let Some(probes) = &mut self.probes {
            write_probes(probes, &self.followed, frame)?;
        }
        self.frames.write_if_due()
    }

    /// Removes the frames after a time [s], and the checkpoint if it counts one of them. Rows of the history and of
    /// probes are kept; no more rows of probes are written.
    pub fn withdraw_after(&mut self, t: f64) -> Result<(), ObserveError> {
        let (checkpoint, kept) = (&self.checkpoint, self.frames_kept);
        self.frames.withdraw_after(t, |left| match (kept > left).then(|| fs::remove_file(checkpoint)) {
            Some(Err(e)) if e.kind() != std::io::ErrorKind::NotFound => Err(write_fault(checkpoint, e)),
            _ => Ok(()),
        })?;
        if let Some(mut probes) = self.probes.take() {
            probes.flush()?;
        }
        Ok(())
    }

    /// Appends a row to the history.
    pub fn row(&mut self, row: &HistoryRow) -> Result<(), ObserveError> {
        self.history.line(|buffer| row.write(buffer))
    }

    /// Appends a value of a gauge.
    pub fn gauge(&mut self, &GaugeRow { t, channel, value }: &GaugeRow) -> Result<(), ObserveError> {
        let (Some(file), Some(label)) = (&mut self.gauges, self.channels.get(channel)) else { return Ok(()) };
        file.line(|out| write!(out, "{t:?},{label},{value:?}"))
    }

    /// Writes lines and frames that have waited long enough.
    pub fn flush_if_due(&mut self) -> Result<(), ObserveError> {
        self.history.flush_if_due()?;
        for file in self.probes.iter_mut().chain(&mut self.gauges) {
            file.flush_if_due()?;
        }
        self.frames.write_if_due()
    }

    /// Writes everything.
    ///
    /// # Errors
    /// Errors of the system; all files are tried, and the first error is reported.
    pub fn finish(&mut self) -> Result<(), ObserveError> {
        let history = self.history.flush();
        let probes = self.probes.as_mut().map_or(Ok(()), CsvFile::flush);
        let gauges = self.gauges.as_mut().map_or(Ok(()), CsvFile::flush);
        history.and(probes).and(gauges).and(self.frames.finish())
    }
}

/// Name and quantity of channels as they stand in a row.
fn labels(channels: &[[String; 2]]) -> Vec<String> {
    channels.iter().map(|[name, quantity]| format!("{},{quantity}", csv_field(name))).collect()
}

fn quoted(probes: &[ProbeSpec]) -> Vec<ProbeSpec> {
    probes.iter().map(|p| ProbeSpec { name: csv_field(&p.name), nodes: p.nodes.clone() }).collect()
}
