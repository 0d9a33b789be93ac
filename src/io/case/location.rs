//! The location of a fault: a range of the file's text, or an assignment on the command line.

use std::fmt;
use std::ops::Range;

/// The location of a fault.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Location {
    /// in the file
    Text {
        /// [byte] the range of the text
        range: Range<usize>,
        /// line of its start, from 1
        line: usize,
        /// column of its start in characters, from 1
        column: usize,
    },
    /// on the command line
    Assignment {
        /// dotted path
        key: String,
        /// the value assigned, shortened
        value: String,
    },
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text { line, column, .. } => write!(f, "{line}:{column}"),
            Self::Assignment { key, value } => write!(f, "--set {key}={value}"),
        }
    }
}

impl Location {
    /// A range of a text.
    pub(crate) fn in_text(text: &str, range: Range<usize>) -> Self {
        let start = floor(text, range.start);
        let head = text.get(..start).unwrap_or_default();
        let line_start = head.rfind('\n').map_or(0, |i| i + 1);
        let column = 1 + head.get(line_start..).unwrap_or_default().chars().count();
        let line = 1 + head.bytes().filter(|b| *b == b'\n').count();
        Self::Text { range: start..floor(text, range.end.max(start)), line, column }
    }
}

/// The offset, moved back to the start of its character and into the text.
fn floor(text: &str, offset: usize) -> usize {
    let mut offset = offset.min(text.len());
    while !text.is_char_boundary(offset) {
        offset -= 1;
    }
    offset
}
