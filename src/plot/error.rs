//! Why a chart cannot be made.

use std::path::PathBuf;

/// Any error of this folder.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// No line has a point that can be drawn: finite, and above 0 on a logarithmic axis.
    #[error("chart \"{title}\": no line has a point that can be drawn")]
    NothingToDraw {
        /// title of the chart
        title: String,
    },
    /// A fixed range is empty, not finite, or not above 0 on a logarithmic axis.
    #[error("chart \"{title}\", axis \"{axis}\": {low} to {high} is no range to draw on")]
    BadRange {
        /// title of the chart
        title: String,
        /// label of the axis
        axis: String,
        /// its lower end
        low: f64,
        /// its upper end
        high: f64,
    },
    /// A folder does not exist.
    #[error("{0} is no folder; give a folder with results, as canopy-fem solve writes it")]
    NoFolder(PathBuf),
    /// A file of the results does not exist.
    #[error("{folder} holds no results that can be plotted: {file} is not there{why}")]
    NoFile {
        /// the folder
        folder: PathBuf,
        /// path of the file from there
        file: String,
        /// its purpose, or empty
        why: &'static str,
    },
    /// A file of the results is not valid.
    #[error("{path}{}: {what}", at_line(*.line))]
    BadFile {
        /// the file
        path: PathBuf,
        /// the line, counted from 1, in files that have lines
        line: Option<usize>,
        /// the fault
        what: String,
    },
    /// The requested data are not in the results.
    #[error("{0}")]
    NotThere(String),
    /// The system's answer.
    #[error("{path}: {source}")]
    System {
        /// the file
        path: PathBuf,
        /// the answer
        source: std::io::Error,
    },
}

fn at_line(line: Option<usize>) -> String {
    line.map(|n| format!(", line {n}")).unwrap_or_default()
}

impl PlotError {
    /// Exit status: 1 for errors of the system, 2 for those that a user can correct.
    pub fn exit_status(&self) -> u8 {
        match self {
            PlotError::System { .. } => 1,
            _ => 2,
        }
    }
}
