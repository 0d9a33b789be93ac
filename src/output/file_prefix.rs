//! How far a growing file had come, and whether what it holds up to there is still what was written.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::resume::ResumeError;

/// The first `bytes` of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct FilePrefix {
    /// their number
    pub bytes: u64,
    /// their CRC-32 (IEEE 802.3)
    pub crc: u32,
}

/// A [`FilePrefix`] that follows a file as it grows.
#[derive(Clone, Debug, Default)]
pub struct PrefixCounter {
    bytes: u64,
    crc: crc32fast::Hasher,
}

impl PrefixCounter {
    /// Goes on from a mark.
    pub fn after(mark: FilePrefix) -> Self {
        Self { bytes: mark.bytes, crc: crc32fast::Hasher::new_with_initial_len(mark.crc, mark.bytes) }
    }

    /// Counts what was appended.
    pub fn add(&mut self, data: &[u8]) {
        self.bytes += data.len() as u64;
        self.crc.update(data);
    }

    /// Where the file is now.
    pub fn mark(&self) -> FilePrefix {
        FilePrefix { bytes: self.bytes, crc: self.crc.clone().finalize() }
    }

    /// Number of bytes so far.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }
}

impl FilePrefix {
    /// Reads the marked part of a file and compares; what comes after it does not matter.
    ///
    /// # Errors
    /// A file that is missing, no file at all, shorter, or holds something else.
    pub fn check(&self, path: &Path) -> Result<(), ResumeError> {
        let file = open_plain(path)?;
        let mut rest = file.take(self.bytes);
        let (mut seen, mut block) = (PrefixCounter::default(), vec![0; 1 << 16]);
        loop {
            match rest.read(&mut block) {
                Ok(0) => break,
                Ok(n) => seen.add(block.get(..n).unwrap_or_default()),
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => return Err(ResumeError::system(path, e)),
            }
        }
        self.agrees(seen.mark(), path)
    }

    /// Compares with what was found in a file.
    ///
    /// # Errors
    /// A file that is shorter or holds something else.
    pub fn agrees(&self, found: FilePrefix, path: &Path) -> Result<(), ResumeError> {
        let path = || path.display().to_string();
        if found.bytes < self.bytes {
            return Err(ResumeError::Shorter { path: path(), found: found.bytes, needed: self.bytes });
        }
        if found != *self {
            return Err(ResumeError::Changed { path: path(), bytes: self.bytes });
        }
        Ok(())
    }
}

/// Opens a result to read; a link or a folder in its place is refused.
///
/// # Errors
/// When it is missing, no plain file, or cannot be opened.
pub fn open_plain(path: &Path) -> Result<File, ResumeError> {
    match fs::symlink_metadata(path) {
        Ok(there) if there.is_file() => File::open(path).map_err(|e| ResumeError::system(path, e)),
        Ok(_) => Err(ResumeError::NoFile { path: path.display().to_string() }),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Err(ResumeError::Missing { path: path.display().to_string() }),
        Err(e) => Err(ResumeError::system(path, e)),
    }
}
