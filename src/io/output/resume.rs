//! Checks that the files of a run have not changed since its checkpoint; and why a run cannot be resumed.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use super::checkpoint::CheckpointFault;
use crate::case::fingerprint::Differences;
pub use crate::checksum::{FilePrefix, RunningChecksum};
use crate::drive::observer::ObserveError;

/// Why a run cannot be resumed. No results are lost: nothing is changed before everything has been checked, and a
/// resumed run writes again what is then cut off.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ResumeError {
    /// There is no checkpoint.
    #[error(
        "{folder} holds no checkpoint.bin, so there is nothing to resume; a run keeps one if it is interrupted or its case has \
         output.checkpoint; solve without --resume to start from t = 0"
    )]
    Nothing {
        /// the folder
        folder: String,
    },
    /// The file is not a checkpoint that this program can use.
    #[error("{path}: {fault}")]
    Unusable {
        /// the file
        path: String,
        /// the reason
        fault: CheckpointFault,
    },
    /// The checkpoint is of another case.
    #[error(
        "{path} belongs to another case: {differences}; resume the case as it was, solve this one with --force, or \
         begin where that run ended with system.network.initial.from"
    )]
    OtherCase {
        /// the checkpoint
        path: String,
        /// the parts that differ
        differences: Differences,
    },
    /// A result file is too short.
    #[error("{path} holds {found} bytes, but held {needed} when the checkpoint was written; solve again with --force")]
    Shorter {
        /// the file
        path: String,
        /// [byte] its length
        found: u64,
        /// [byte] its length at the checkpoint
        needed: u64,
    },
    /// A result file has changed.
    #[error(
        "the first {bytes} bytes of {path} are not those it held when the checkpoint was written; solve again with --force"
    )]
    Changed {
        /// the file
        path: String,
        /// [byte] marked part
        bytes: u64,
    },
    /// A result file is missing.
    #[error("{path} is missing, which was there when the checkpoint was written; solve again with --force")]
    Missing {
        /// the file
        path: String,
    },
    /// There is something else at the path of a result.
    #[error("{path} is not a plain file, which it was when the checkpoint was written")]
    NoFile {
        /// the path
        path: String,
    },
    /// The file of frames is damaged, of another case, or has too few.
    #[error("{path} is not as it was when the checkpoint was written: {what}; solve again with --force")]
    Unfit {
        /// the file
        path: String,
        /// what is wrong
        what: String,
    },
    /// The other run has not ended.
    #[error("{path} is being written by another run; wait until it has ended")]
    Busy {
        /// the file
        path: String,
    },
    /// The part after the checkpoint cannot be cut off.
    #[error(transparent)]
    Write(#[from] ObserveError),
    /// The system's error.
    #[error("{path}: {source}")]
    System {
        /// the path
        path: String,
        /// the reason
        source: io::Error,
    },
}

impl ResumeError {
    /// Whether it is an error of the system, and not of the files.
    pub fn is_system(&self) -> bool {
        matches!(self, ResumeError::System { .. } | ResumeError::Write(_))
    }

    /// The system's error for a path.
    pub fn system(path: &Path, source: io::Error) -> Self {
        ResumeError::System { path: path.display().to_string(), source }
    }
}

impl FilePrefix {
    /// Reads the marked part of a file and compares it; the rest is ignored.
    ///
    /// # Errors
    /// A file that is missing, not a plain file, too short, or has changed.
    pub fn check(&self, path: &Path) -> Result<(), ResumeError> {
        let mut seen = RunningChecksum::default();
        io::copy(&mut open_plain(path)?.take(self.bytes), &mut seen).map_err(|e| ResumeError::system(path, e))?;
        self.agrees(seen.mark(), path)
    }

    /// Compares with the prefix found in a file.
    ///
    /// # Errors
    /// A file that is too short or has changed.
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
/// When it is missing, not a plain file, or cannot be opened.
pub fn open_plain(path: &Path) -> Result<File, ResumeError> {
    match fs::symlink_metadata(path) {
        Ok(there) if there.is_file() => File::open(path).map_err(|e| ResumeError::system(path, e)),
        Ok(_) => Err(ResumeError::NoFile { path: path.display().to_string() }),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Err(ResumeError::Missing { path: path.display().to_string() }),
        Err(e) => Err(ResumeError::system(path, e)),
    }
}
