//! Why a case cannot be used. All variants give exit status 2, except an existing file that cannot be read
//! ([`CaseError::Read`]), which gives 1.

use super::diagnostics::Fault;
use super::render::render;

/// Why a case cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CaseError {
    /// The operating system cannot read the file.
    #[error("{path}: {source}")]
    Read {
        /// the case file
        path: String,
        /// the system's reason
        source: std::io::Error,
    },
    /// The file is larger than the largest case.
    #[error(
        "{path}: larger than {limit} bytes; put a large mesh into a mesh file and name it: {{\"file\": \"canopy.vtu\"}}"
    )]
    TooLarge {
        /// the case file
        path: String,
        /// [bytes] largest case file
        limit: u64,
    },
    /// The file is not text in UTF-8.
    #[error("{path}: byte {offset} is not UTF-8; {advice}")]
    NotUtf8 {
        /// the case file
        path: String,
        /// first byte that cannot be read
        offset: usize,
        /// what to do
        advice: &'static str,
    },
    /// The file holds nothing but white space and comments.
    #[error("{path}: the file is empty; `canopy-fem init NAME` writes an example case")]
    Empty {
        /// the case file
        path: String,
    },
    /// A `--set` assignment cannot be applied.
    #[error("--set {key}={value}: {reason}")]
    Override {
        /// dotted path
        key: String,
        /// what to put there
        value: String,
        /// why that cannot be done
        reason: String,
    },
    /// The text is not JSON, or not a case that can be run.
    #[error("{path}: {} in the case\n\n{}{}", count(faults.len() + more), render(path, text, faults), rest(*more))]
    Faults {
        /// the case file
        path: String,
        /// the text as read, for quotations
        text: String,
        /// what is wrong, in the order of the text; at most 50
        faults: Vec<Fault>,
        /// number of faults beyond those
        more: usize,
    },
}

impl CaseError {
    /// 1 for a case file that the system cannot read, 2 for a bad case and for a path that is no file.
    pub fn exit_status(&self) -> u8 {
        use std::io::ErrorKind::{InvalidInput, IsADirectory, NotADirectory, NotFound};
        match self {
            Self::Read { source, .. } => {
                if matches!(source.kind(), NotFound | IsADirectory | NotADirectory | InvalidInput) { 2 } else { 1 }
            }
            _ => 2,
        }
    }

    /// The faults, if there are any.
    pub fn faults(&self) -> &[Fault] {
        match self {
            Self::Faults { faults, .. } => faults,
            _ => &[],
        }
    }
}

fn rest(more: usize) -> String {
    if more == 0 { String::new() } else { format!("\n\nand {more} more; correct these and check again") }
}

fn count(n: usize) -> String {
    if n == 1 { "1 fault".to_owned() } else { format!("{n} faults") }
}
