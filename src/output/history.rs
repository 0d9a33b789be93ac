//! `history.csv`: a row a step, or every n.

use std::io::{self, Write};
use std::path::Path;

use super::csv::CsvFile;
use super::file_prefix::FilePrefix;
use super::resume::ResumeError;
use crate::drive::observer::{LedgerRow, ObserveError};

/// The header line; other programs rely on it.
pub const HEADER: &str = "t,step,kinetic,elastic,gravity,external_work,dissipated,numerical,newton_iterations,residual,\
                          max_speed,max_strain";

/// One row.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct HistoryRow {
    /// [s] time
    pub t: f64,
    /// number of the step, 0 for the start
    pub step: u64,
    /// [J] the energy account
    pub ledger: LedgerRow,
    /// Newton iterations of the step, 0 for explicit schemes
    pub newton_iterations: u32,
    /// [-] final residual over its scale, 0 for explicit schemes
    pub residual: f64,
    /// [m/s] largest node speed
    pub max_speed: f64,
    /// [-] largest strain over all springs
    pub max_strain: f64,
}

impl HistoryRow {
    /// The row as text, every number in the shortest form that reads back to the same bits.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let Self { t, step, ledger, newton_iterations, residual, max_speed, max_strain } = self;
        let LedgerRow { kinetic, elastic, gravity, external_work, dissipated, numerical } = ledger;
        write!(
            out,
            "{t:?},{step},{kinetic:?},{elastic:?},{gravity:?},{external_work:?},{dissipated:?},{numerical:?},"
        )?;
        write!(out, "{newton_iterations},{residual:?},{max_speed:?},{max_strain:?}")
    }
}

/// The growing file.
#[derive(Debug)]
pub struct History {
    file: CsvFile,
}

impl History {
    /// Creates the file with its header.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn create(path: &Path) -> Result<Self, ObserveError> {
        Ok(Self { file: CsvFile::create(path, HEADER)? })
    }

    /// Goes on with a file after its mark.
    ///
    /// # Errors
    /// When another run holds it or it cannot be opened.
    pub fn reopen(path: &Path, mark: FilePrefix) -> Result<Self, ResumeError> {
        Ok(Self { file: CsvFile::reopen(path, mark)? })
    }

    /// Appends a row.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn push(&mut self, row: &HistoryRow) -> Result<(), ObserveError> {
        self.file.line(|buffer| row.write(buffer))
    }

    /// The file under it, to flush.
    pub fn file(&mut self) -> &mut CsvFile {
        &mut self.file
    }
}
