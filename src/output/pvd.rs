//! The .pvd collection: which file shows which time. ParaView opens it, also while the run goes on.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::atomic::{Durability, replace};
use super::csv::write_fault;
use super::names::xml_attribute;
use crate::drive::observer::ObserveError;

/// Up to here the collection is rewritten after every frame; beyond, after each further percent of frames or …
const SMALL: usize = 1000;
/// … this much time, so that many quick frames do not cost a quadratic number of bytes.
const LONGEST_DELAY: Duration = Duration::from_secs(1);

const HEAD: &str = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\" \
                    header_type=\"UInt64\">\n<Collection>\n";
const TAIL: &str = "</Collection>\n</VTKFile>\n";

/// A growing collection of frames.
#[derive(Debug)]
pub struct Collection {
    path: PathBuf,
    /// the whole file but for its last lines
    text: String,
    frames: usize,
    shown: usize,
    last_write: Instant,
}

impl Collection {
    /// An empty collection; nothing is written yet.
    pub fn new(path: &Path) -> Self {
        Self { path: path.to_owned(), text: HEAD.to_owned(), frames: 0, shown: 0, last_write: Instant::now() }
    }

    /// Number of frames so far.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// Adds a frame that is complete on disk: its time in seconds and its path from the collection's folder.
    pub fn push(&mut self, time: f64, file: &str) {
        let file = xml_attribute(file);
        let _ = writeln!(self.text, "<DataSet timestep=\"{time:?}\" group=\"\" part=\"0\" file=\"{file}\"/>");
        self.frames += 1;
    }

    /// Replaces the file on disk if it is due (see [`Collection::write`]): after every frame up to 1000 of them,
    /// later after one per cent more, or a second.
    ///
    /// # Errors
    /// When the file cannot be replaced.
    pub fn write_if_due(&mut self) -> Result<(), ObserveError> {
        let waiting = self.frames - self.shown;
        let due = self.frames <= SMALL || waiting * 100 >= self.frames || self.last_write.elapsed() >= LONGEST_DELAY;
        if waiting > 0 && due { self.write() } else { Ok(()) }
    }

    /// Replaces the file on disk, atomically, with all frames so far.
    ///
    /// # Errors
    /// When the file cannot be replaced.
    pub fn write(&mut self) -> Result<(), ObserveError> {
        let open = self.text.len();
        self.text.push_str(TAIL);
        let written = replace(&self.path, self.text.as_bytes(), Durability::Visible);
        self.text.truncate(open);
        written.map_err(|e| write_fault(&self.path, e))?;
        self.shown = self.frames;
        self.last_write = Instant::now();
        Ok(())
    }
}
