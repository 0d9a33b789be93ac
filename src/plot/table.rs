//! Comma-separated files of known columns, read by `csv`, with the line of every fault.

use super::PlotError;
use std::path::Path;
use std::str::FromStr;

/// A row and the line it begins on.
pub(super) struct CsvRow<'a> {
    path: &'a Path,
    line: u64,
    cells: csv::StringRecord,
}

/// All rows of a file below its header.
///
/// # Errors
/// Another header, a row of another length, or a file that was cut off.
pub(super) fn rows<'a>(path: &'a Path, text: &str, header: &str) -> Result<Vec<CsvRow<'a>>, PlotError> {
    let fault = |line: Option<u64>, what: String| PlotError::BadFile {
        path: path.to_owned(),
        line: line.map(|line| line as usize),
        what,
    };
    let columns = header.split(',').count();
    let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(text.as_bytes());
    let mut rows = Vec::new();
    let mut last_line = None;
    for record in reader.records() {
        let cells = record.map_err(|error| fault(error.position().map(csv::Position::line), error.to_string()))?;
        let line = cells.position().map_or(1, csv::Position::line);
        last_line = Some(line);
        if line == 1 {
            if cells.iter().ne(header.split(',')) {
                return Err(fault(last_line, format!("expected the header \"{header}\"")));
            }
        } else {
            rows.push(CsvRow { path, line, cells });
        }
    }
    // The program writes complete lines only; a full disk or a power cut leaves an incomplete last one.
    if last_line.is_none() {
        return Err(fault(None, format!("is empty; expected the header \"{header}\"")));
    } else if !text.matches('"').count().is_multiple_of(2) {
        return Err(fault(last_line, "a quote that does not end".to_owned()));
    } else if !text.ends_with('\n') {
        return Err(fault(last_line, "the line does not end; the file was cut off".to_owned()));
    }
    match rows.iter().find(|row| row.cells.len() != columns) {
        Some(row) => Err(fault(Some(row.line), format!("{} values where {columns} are expected", row.cells.len()))),
        None => Ok(rows),
    }
}

impl CsvRow<'_> {
    /// A cell as text.
    pub(super) fn text(&self, column: usize) -> &str {
        self.cells.get(column).unwrap_or("")
    }

    /// A cell as a number; a diverged run also writes NaN and inf.
    ///
    /// # Errors
    /// A cell that is not a number.
    pub(super) fn number<T: FromStr>(&self, column: usize) -> Result<T, PlotError> {
        let text = self.text(column);
        text.parse().map_err(|_| PlotError::BadFile {
            path: self.path.to_owned(),
            line: Some(self.line as usize),
            what: format!("value {} is \"{text}\", not a number as expected there", column + 1),
        })
    }

    /// Consecutive cells as numbers.
    ///
    /// # Errors
    /// A cell that is not a number.
    pub(super) fn numbers<const N: usize>(&self, first: usize) -> Result<[f64; N], PlotError> {
        let mut values = [0.0; N];
        for (i, value) in values.iter_mut().enumerate() {
            *value = self.number(first + i)?;
        }
        Ok(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<Vec<String>>, String> {
        let rows = rows(Path::new("a.csv"), text, "t,name").map_err(|e| e.to_string())?;
        Ok(rows.iter().map(|r| r.cells.iter().map(str::to_owned).collect()).collect())
    }

    /// Quoted cells come back as they were, with commas, quotes and line ends in them.
    #[test]
    fn cells_are_read_back() {
        assert_eq!(
            read("t,name\n1,a\n2,\"b, \"\"c\"\"\nd\"\r\n"),
            Ok(vec![vec!["1".into(), "a".into()], vec!["2".into(), "b, \"c\"\nd".into()]])
        );
        assert_eq!(read("t,name\n"), Ok(vec![]));
    }

    /// Every fault names the file and the line.
    #[test]
    fn faults_name_their_line() {
        for (text, fault) in [
            ("", "a.csv: is empty"),
            ("t,name\n1,\"a\nb\"\n2,c,d\n", "a.csv, line 4: 3 values where 2"),
            ("t,name\n1,\"a\n", "a.csv, line 2: a quote"),
        ] {
            let error = read(text).expect_err(text);
            assert!(error.starts_with(fault), "{error}");
        }
    }
}
