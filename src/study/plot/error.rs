//! Why a chart cannot be made.

use std::path::PathBuf;

/// Any error of this folder.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
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
    /// The results hold nothing of a kind.
    #[error("{folder}: {what}; add {add} to the output section of the case")]
    NotHeld {
        /// the folder
        folder: PathBuf,
        /// what is missing
        what: &'static str,
        /// the key that makes a run write it
        add: &'static str,
    },
    /// A logarithmic axis has nothing to show.
    #[error(
        "\"{title}\": none of the {points} points is above 0 on the logarithmic axis \"{axis}\"; the largest is \
         {largest:e}. Leave that axis out of --log"
    )]
    NothingPositive {
        /// title of the chart
        title: String,
        /// label of the axis
        axis: String,
        /// number of points
        points: usize,
        /// largest of them on this axis
        largest: f64,
    },
    /// The run of --minus lacks a curve.
    #[error("{folder} has no {missing} to subtract; it has: {}. Choose what both runs have by {choose}", there.join(", "))]
    Unmatched {
        /// folder of the run to subtract
        folder: PathBuf,
        /// what it lacks
        missing: String,
        /// what it has
        there: Vec<String>,
        /// the options for it
        choose: &'static str,
    },
    /// The program was built without a format.
    #[error(
        "this program was built without --format {0}, whose libraries take long to compile. Take --format svg, or build \
         it in the folder of its sources with: cargo install --path . --features pictures"
    )]
    NoFormat(&'static str),
    /// A picture could not be converted.
    #[error("cannot make a {format}: {what}")]
    Convert {
        /// the format
        format: &'static str,
        /// why
        what: String,
    },
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
