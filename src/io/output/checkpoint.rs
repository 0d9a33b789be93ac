//! `checkpoint.bin`: a run between two steps and the state of its result files, in one file.
//!
//! ```text
//! magic, 8 bytes | format, u32 | payload's length, u64 | payload | CRC-32 of all before it, u32       (little end first)
//! payload = program's version, then the Checkpoint, both as postcard writes them
//! ```
//! postcard's wire format: <https://postcard.jamesmunns.com/wire-format>. It has no names, so any change of a stored
//! struct needs another [`FORMAT`]. It contains the program's version, because another version may compute other bits.
//!
//! The checkpoint is written last, after its results are on the disk. So whenever a run is killed, the files begin with
//! the content that the newest checkpoint describes, and a resumed run cuts off the rest.

use std::io::{self, Read};
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::files::FilesProgress;
use super::recorder::RecorderState;
use super::resume::ResumeError;
use super::resume::open_plain;
use crate::case::fingerprint::Fingerprint;
use crate::checksum::{self, ChecksumError};
use crate::drive::Snapshot;
use crate::process::Cost;

/// Number of the file format.
pub const FORMAT: u32 = 24;
/// As in PNG: a byte above 127 and both kinds of line end reveal a transfer as text.
const MAGIC: [u8; 8] = *b"\x89CNPY\r\n\x1a";
/// Length of the header: magic, format, length.
const HEAD: usize = 8 + 4 + 8;
/// The version of the program.
const PROGRAM: &str = env!("CARGO_PKG_VERSION");

/// The content of a checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    /// the fingerprint of its case
    pub case: Fingerprint,
    /// the run
    pub snapshot: Snapshot,
    /// state of the recorder
    pub recorder: RecorderState,
    /// state of the result files
    pub files: FilesProgress,
    /// cost of the run so far
    pub spent: Cost,
}

/// Why a file is not a checkpoint that this program can use.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointFault {
    /// The file is not a checkpoint.
    #[error("this is not a checkpoint of canopy-fem")]
    Foreign,
    /// Another format.
    #[error(
        "the checkpoint has format {found}, and this program reads format {FORMAT}: resume with the program that wrote it"
    )]
    Format {
        /// its number
        found: u32,
    },
    /// The end of the file is missing.
    #[error("the checkpoint is cut short: {found} bytes of {needed}")]
    CutShort {
        /// [byte] its length
        found: u64,
        /// [byte] its length by the header
        needed: u64,
    },
    /// There are bytes after its end.
    #[error("the checkpoint is damaged: {found} bytes where it should end after {needed}")]
    TooLong {
        /// [byte] its length
        found: u64,
        /// [byte] its length by the header
        needed: u64,
    },
    /// The checksum is not that of the content.
    #[error("the checkpoint is damaged: its checksum is {stored:08x}, that of its content {computed:08x}")]
    Checksum {
        /// at the end of the file
        stored: u32,
        /// of the content
        computed: u32,
    },
    /// Another version of the program.
    #[error(
        "the checkpoint was written by version {found}, and this is version {PROGRAM}, which may compute other bits: resume \
         with the program that wrote it"
    )]
    Program {
        /// its version
        found: String,
    },
    /// The payload cannot be decoded.
    #[error("the checkpoint cannot be decoded: {0}")]
    Content(#[from] postcard::Error),
}

impl Checkpoint {
    /// Writes the content of the file into `out`, whose memory is reused.
    ///
    /// # Errors
    /// Errors of postcard, which do not occur for these types.
    pub fn encode(&self, out: &mut Vec<u8>) -> io::Result<()> {
        let refused = |e: postcard::Error| io::Error::new(io::ErrorKind::InvalidData, e);
        out.clear();
        out.extend_from_slice(&MAGIC);
        out.extend_from_slice(&FORMAT.to_le_bytes());
        out.extend_from_slice(&[0; 8]);
        postcard::to_io(&(PROGRAM, self), &mut *out).map_err(refused)?;
        let length = (out.len() - HEAD) as u64;
        if let Some(place) = out.get_mut(HEAD - 8..HEAD) {
            place.copy_from_slice(&length.to_le_bytes());
        }
        checksum::append(out);
        Ok(())
    }

    /// Reads a file's content back.
    ///
    /// # Errors
    /// Anything but a complete and undamaged checkpoint of this program.
    pub fn decode(bytes: &[u8]) -> Result<Self, CheckpointFault> {
        // The magic first: a short file of another kind is foreign, not cut short.
        let begins = bytes.iter().zip(&MAGIC).all(|(a, b)| a == b);
        if bytes.is_empty() || !begins {
            return Err(CheckpointFault::Foreign);
        }
        let found = bytes.len() as u64;
        let cut = |needed: u64| CheckpointFault::CutShort { found, needed };
        let least = (HEAD + checksum::LENGTH) as u64;
        let head = bytes.first_chunk::<HEAD>().ok_or(cut(least))?;
        let [.., f0, f1, f2, f3, n0, n1, n2, n3, n4, n5, n6, n7] = *head;
        let format = u32::from_le_bytes([f0, f1, f2, f3]);
        if format != FORMAT {
            return Err(CheckpointFault::Format { found: format });
        }
        let needed = u64::from_le_bytes([n0, n1, n2, n3, n4, n5, n6, n7]).saturating_add(least);
        if found < needed {
            return Err(cut(needed));
        }
        if found > needed {
            return Err(CheckpointFault::TooLong { found, needed });
        }
        let content = checksum::verified(bytes).map_err(|error| match error {
            ChecksumError::Missing => cut(needed),
            ChecksumError::Differs { stored, computed } => CheckpointFault::Checksum { stored, computed },
        })?;
        let payload = content.get(HEAD..).unwrap_or_default();
        let (program, content): (String, _) = postcard::take_from_bytes(payload)?;
        if program != PROGRAM {
            return Err(CheckpointFault::Program { found: program });
        }
        Ok(postcard::from_bytes(content)?)
    }

    /// Reads the checkpoint of a folder and compares the case.
    ///
    /// # Errors
    /// When there is no checkpoint, it cannot be used, or it belongs to another case.
    pub fn read(path: &Path, case: &Fingerprint) -> Result<Self, ResumeError> {
        let mut file = open_plain(path).map_err(|error| match error {
            ResumeError::Missing { .. } => {
                let folder = path.parent().unwrap_or(Path::new("")).display().to_string();
                ResumeError::Nothing { folder }
            }
            other => other,
        })?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(|e| ResumeError::system(path, e))?;
        let shown = || path.display().to_string();
        let found = Self::decode(&bytes).map_err(|fault| ResumeError::Unusable { path: shown(), fault })?;
        match found.case.differences(case) {
            Some(differences) => Err(ResumeError::OtherCase { path: shown(), differences }),
            None => Ok(found),
        }
    }
}
