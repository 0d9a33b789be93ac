//! Comma-separated files that are readable at any time: only complete lines are passed to the system.

use std::fs::{File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::folder::{Lock, lock};
use super::resume::ResumeError;
use super::resume::{FilePrefix, RunningChecksum};
use crate::drive::observer::ObserveError;

/// Lines are written at the latest after this many bytes …
const BLOCK: usize = 16 * 1024;
/// … or this much time, whichever comes first.
pub const LONGEST_DELAY: Duration = Duration::from_millis(500);

/// A csv file that grows line by line.
#[derive(Debug)]
pub struct CsvFile {
    path: PathBuf,
    file: File,
    buffer: Vec<u8>,
    last_write: Instant,
    /// the part passed to the system
    written: RunningChecksum,
}

impl CsvFile {
    /// Creates (or empties) the file and writes its header line at once. It is locked as long as it is open.
    ///
    /// # Errors
    /// When another run holds its lock, or it cannot be written.
    pub fn create(path: &Path, header: &str) -> Result<Self, ObserveError> {
        let fault = |source| write_fault(path, source);
        // Emptied only under the lock, because another run may be writing it where folders cannot be locked.
        let file = OpenOptions::new().write(true).create(true).truncate(false).open(path).map_err(fault)?;
        if lock(&file) == Lock::Elsewhere {
            return Err(fault(io::Error::new(io::ErrorKind::ResourceBusy, "another run is writing it")));
        }
        file.set_len(0).map_err(fault)?;
        let mut made = Self::around(path, file, RunningChecksum::default());
        made.line(|out| write!(out, "{header}"))?;
        made.flush()?;
        Ok(made)
    }

    /// Opens a file that begins with the content of `mark`, and cuts off the rest. It is locked as long as it is open.
    ///
    /// # Errors
    /// When another run holds its lock, or it cannot be opened or cut.
    pub fn reopen(path: &Path, mark: FilePrefix) -> Result<Self, ResumeError> {
        let fault = |source| ResumeError::system(path, source);
        let mut file = OpenOptions::new().write(true).open(path).map_err(fault)?;
        if lock(&file) == Lock::Elsewhere {
            return Err(ResumeError::Busy { path: path.display().to_string() });
        }
        file.set_len(mark.bytes).map_err(fault)?;
        file.seek(SeekFrom::Start(mark.bytes)).map_err(fault)?;
        Ok(Self::around(path, file, RunningChecksum::after(mark)))
    }

    fn around(path: &Path, file: File, written: RunningChecksum) -> Self {
        let buffer = Vec::with_capacity(BLOCK);
        Self { path: path.to_owned(), file, buffer, last_write: Instant::now(), written }
    }

    /// Appends one line; `fill` writes it without the line break.
    pub fn line(&mut self, fill: impl FnOnce(&mut Vec<u8>) -> io::Result<()>) -> Result<(), ObserveError> {
        fill(&mut self.buffer).map_err(|e| write_fault(&self.path, e))?;
        self.buffer.push(b'\n');
        // Leaves room for one more line, so that the buffer keeps its size.
        if self.buffer.len() + 512 > BLOCK { self.flush() } else { Ok(()) }
    }

    /// Writes the lines if they have waited longer than [`LONGEST_DELAY`].
    pub fn flush_if_due(&mut self) -> Result<(), ObserveError> {
        if self.last_write.elapsed() >= LONGEST_DELAY { self.flush() } else { Ok(()) }
    }

    /// Writes all waiting lines. If the disk is full, the file ends with its last complete line.
    pub fn flush(&mut self) -> Result<(), ObserveError> {
        if !self.buffer.is_empty() {
            if let Err(source) = self.file.write_all(&self.buffer) {
                self.keep_whole_lines();
                return Err(write_fault(&self.path, source));
            }
            self.written.add(&self.buffer);
            self.buffer.clear();
        }
        self.last_write = Instant::now();
        Ok(())
    }

    /// Writes all waiting lines and makes them durable; returns the mark of the file.
    pub fn sync(&mut self) -> Result<FilePrefix, ObserveError> {
        self.flush()?;
        self.file.sync_data().map_err(|e| write_fault(&self.path, e))?;
        Ok(self.written.mark())
    }

    /// After an incomplete write: cuts off the incomplete line; this one and those after it wait again.
    fn keep_whole_lines(&mut self) {
        let length = self.file.metadata().map_or(0, |there| there.len());
        let arrived = usize::try_from(length.saturating_sub(self.written.bytes())).unwrap_or(0);
        let arrived = self.buffer.get(..arrived).unwrap_or(&self.buffer);
        let whole = arrived.iter().rposition(|byte| *byte == b'\n').map_or(0, |at| at + 1);
        self.written.add(arrived.get(..whole).unwrap_or_default());
        self.buffer.drain(..whole);
        // The original error is reported.
        let end = self.written.bytes();
        let _ = self.file.set_len(end).and_then(|()| self.file.seek(SeekFrom::Start(end)));
    }
}

/// An [`ObserveError::Write`] for a path.
pub fn write_fault(path: &Path, source: io::Error) -> ObserveError {
    ObserveError::Write { path: path.display().to_string(), source }
}
