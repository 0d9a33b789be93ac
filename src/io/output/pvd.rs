//! The .pvd collection: the file of each frame time. ParaView can open it during the run.

use std::fmt::Write as _;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::atomic::{Durability, replace};
use super::csv::write_fault;
use super::resume::ResumeError;
use super::resume::{FilePrefix, RunningChecksum, open_plain};
use crate::drive::observer::ObserveError;
use crate::vtk::xml_attribute;

/// Least time between two writes of the collection, since a write costs as much as a small frame …
const LEAST_DELAY: Duration = Duration::from_millis(100);
/// … and beyond this number of frames a write waits until there are a percent more, or …
const SMALL: u64 = 1000;
/// … until this time has passed, so that many quick frames do not cost a quadratic number of bytes.
const LONGEST_DELAY: Duration = Duration::from_secs(1);

const HEAD: &str = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\" \
                    header_type=\"UInt64\">\n<Collection>\n";
const TAIL: &str = "</Collection>\n</VTKFile>\n";

/// State of a collection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CollectionMark {
    /// number of frames
    pub frames: u64,
    /// the lines down to the last frame's
    pub text: FilePrefix,
}

/// A growing collection of frames.
#[derive(Debug)]
pub(crate) struct Collection {
    path: PathBuf,
    /// the whole file except its last lines
    text: String,
    tally: RunningChecksum,
    frames: u64,
    shown: u64,
    last_write: Instant,
}

impl Collection {
    /// An empty collection; nothing is written yet.
    pub(crate) fn new(path: &Path) -> Self {
        let mut tally = RunningChecksum::default();
        tally.add(HEAD.as_bytes());
        let (path, text) = (path.to_owned(), HEAD.to_owned());
        Self { path, text, tally, frames: 0, shown: 0, last_write: Instant::now() }
    }

    /// Reads the collection as it was at the mark; nothing is written yet.
    ///
    /// # Errors
    /// When it cannot be read or has changed before the mark.
    pub(crate) fn read(path: &Path, mark: CollectionMark) -> Result<Self, ResumeError> {
        let mut found = Self::new(path);
        if mark.frames > 0 {
            let mut bytes = Vec::new();
            let file = open_plain(path)?;
            file.take(mark.text.bytes).read_to_end(&mut bytes).map_err(|e| ResumeError::system(path, e))?;
            found.tally = RunningChecksum::default();
            found.tally.add(&bytes);
            mark.text.agrees(found.tally.mark(), path)?;
            let not_text = |_| ResumeError::Changed { path: path.display().to_string(), bytes: mark.text.bytes };
            found.text = String::from_utf8(bytes).map_err(not_text)?;
        }
        (found.frames, found.shown) = (mark.frames, mark.frames);
        Ok(found)
    }

    /// Its present state.
    pub(crate) fn mark(&self) -> CollectionMark {
        CollectionMark { frames: self.frames, text: self.tally.mark() }
    }

    /// Number of frames so far.
    pub(crate) fn frames(&self) -> u64 {
        self.frames
    }

    /// Adds a frame that is complete on disk: its time in seconds and its path from the collection's folder.
    pub(crate) fn push(&mut self, time: f64, file: &str) {
        let (file, before) = (xml_attribute(file), self.text.len());
        let _ = writeln!(self.text, "<DataSet timestep=\"{time:?}\" group=\"\" part=\"0\" file=\"{file}\"/>");
        self.tally.add(self.text.as_bytes().get(before..).unwrap_or_default());
        self.frames += 1;
    }

    /// Removes the frames after a time [s], which are the last; returns the number of the others.
    pub(crate) fn withdraw_after(&mut self, t: f64) -> u64 {
        while let Some((head, time)) = self.text.trim_end().rsplit_once("<DataSet timestep=\"") {
            let later = time.split('"').next().and_then(|time| time.parse::<f64>().ok()).is_some_and(|time| time > t);
            if !later {
                break;
            }
            let end = head.len();
            self.text.truncate(end);
            self.frames -= 1;
        }
        self.shown = self.shown.min(self.frames);
        self.tally = RunningChecksum::default();
        self.tally.add(self.text.as_bytes());
        self.frames
    }

    /// Replaces the file on disk if it is due (see [`Collection::write`]): with the first frame, and then at most ten
    /// times per second. Beyond 1000 frames it is due after one per cent more, or a second.
    pub(crate) fn write_if_due(&mut self) -> Result<(), ObserveError> {
        let waiting = self.frames - self.shown;
        if waiting == 0 {
            return Ok(());
        }
        let enough = self.frames <= SMALL || waiting * 100 >= self.frames;
        let delay = if enough { LEAST_DELAY } else { LONGEST_DELAY };
        if self.shown == 0 || self.last_write.elapsed() >= delay { self.write(Durability::Visible) } else { Ok(()) }
    }

    /// Replaces the file on disk, atomically, with all frames so far.
    pub(crate) fn write(&mut self, durability: Durability) -> Result<(), ObserveError> {
        let open = self.text.len();
        self.text.push_str(TAIL);
        let written = replace(&self.path, self.text.as_bytes(), durability);
        self.text.truncate(open);
        written.map_err(|e| write_fault(&self.path, e))?;
        self.shown = self.frames;
        self.last_write = Instant::now();
        Ok(())
    }
}
