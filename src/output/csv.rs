//! Comma-separated files that are readable at any moment: only whole lines are handed to the system.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

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
}

impl CsvFile {
    /// Creates (or empties) the file and writes its header line at once.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn create(path: &Path, header: &str) -> Result<Self, ObserveError> {
        let fault = |source| write_fault(path, source);
        let mut file = File::create(path).map_err(fault)?;
        writeln!(file, "{header}").map_err(fault)?;
        Ok(Self { path: path.to_owned(), file, buffer: Vec::with_capacity(BLOCK), last_write: Instant::now() })
    }

    /// Appends one line; `fill` writes it without the line's end.
    ///
    /// # Errors
    /// When the system refuses a block.
    pub fn line(&mut self, fill: impl FnOnce(&mut Vec<u8>) -> io::Result<()>) -> Result<(), ObserveError> {
        fill(&mut self.buffer).map_err(|e| write_fault(&self.path, e))?;
        self.buffer.push(b'\n');
        // Leave room for one more line, so that the buffer keeps its size.
        if self.buffer.len() + 512 > BLOCK { self.flush() } else { Ok(()) }
    }

    /// Writes what has waited longer than [`LONGEST_DELAY`].
    ///
    /// # Errors
    /// When the system refuses.
    pub fn flush_if_due(&mut self) -> Result<(), ObserveError> {
        if self.last_write.elapsed() >= LONGEST_DELAY { self.flush() } else { Ok(()) }
    }

    /// Writes all lines that wait.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn flush(&mut self) -> Result<(), ObserveError> {
        if !self.buffer.is_empty() {
            self.file.write_all(&self.buffer).map_err(|e| write_fault(&self.path, e))?;
            self.buffer.clear();
        }
        self.last_write = Instant::now();
        Ok(())
    }
}

/// An [`ObserveError::Write`] for a path.
pub fn write_fault(path: &Path, source: io::Error) -> ObserveError {
    ObserveError::Write { path: path.display().to_string(), source }
}
