//! Comma-separated files of known columns, read by `csv`, with the line of every fault.

use super::PlotError;
use csv::{ErrorKind, Position, ReaderBuilder, StringRecord};
use serde::de::DeserializeOwned;
use std::path::Path;

/// All rows of a file below its header; `T` takes the columns in their order.
///
/// # Errors
/// Another header, a row of another length, a cell of another type, or a file that was cut off.
pub(crate) fn rows<T: DeserializeOwned>(path: &Path, text: &str, header: &str) -> Result<Vec<T>, PlotError> {
    let fault = |position: Option<&Position>, what: String| {
        let line = position.map(|position| position.line() as usize);
        PlotError::BadFile { path: path.to_owned(), line, what }
    };
    let columns = header.split(',').count();
    let mut reader = ReaderBuilder::new().has_headers(false).flexible(true).from_reader(text.as_bytes());
    let records: Result<Vec<StringRecord>, csv::Error> = reader.records().collect();
    let records = records.map_err(|error| fault(error.position(), error.to_string()))?;
    let Some((first, rows)) = records.split_first() else {
        return Err(fault(None, format!("is empty; expected the header \"{header}\"")));
    };
    if first.iter().ne(header.split(',')) {
        return Err(fault(first.position(), format!("expected the header \"{header}\"")));
    }
    // The program writes whole lines only; a torn last one is what a full disk or a power cut leaves.
    let last = rows.last().unwrap_or(first).position();
    if !text.matches('"').count().is_multiple_of(2) {
        return Err(fault(last, "a quote that does not end".to_owned()));
    } else if !text.ends_with('\n') {
        return Err(fault(last, "the line does not end; the file was cut off".to_owned()));
    }
    if let Some(row) = rows.iter().find(|row| row.len() != columns) {
        return Err(fault(row.position(), format!("{} values where {columns} are expected", row.len())));
    }
    let typed = |row: &StringRecord| {
        row.deserialize(None).map_err(|error: csv::Error| {
            let field = match error.kind() {
                ErrorKind::Deserialize { err, .. } => err.field(),
                _ => None,
            };
            let cell = |field: u64| (field + 1, row.get(field as usize).unwrap_or_default());
            let what = match field.map(cell) {
                Some((number, text)) => format!("value {number} is \"{text}\", not a number as expected there"),
                None => error.to_string(),
            };
            fault(row.position(), what)
        })
    };
    rows.iter().map(typed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<(u8, String)>, String> {
        rows(Path::new("a.csv"), text, "t,name").map_err(|e| e.to_string())
    }

    /// Quoted cells come back as they were, with commas, quotes and line ends in them.
    #[test]
    fn cells_are_read_back() {
        let text = "t,name\n1,a\n2,\"b, \"\"c\"\"\nd\"\r\n";
        assert_eq!(read(text), Ok(vec![(1, "a".into()), (2, "b, \"c\"\nd".into())]));
        assert_eq!(read("t,name\n"), Ok(vec![]));
    }

    /// Every fault names the file and the line.
    #[test]
    fn faults_name_their_line() {
        for (text, fault) in [
            ("", "a.csv: is empty"),
            ("t,name\n1,\"a\nb\"\n2,c,d\n", "a.csv, line 4: 3 values where 2"),
            ("t,name\n1,\"a\n", "a.csv, line 2: a quote"),
            ("t,name\n1,a\nx,b\n", "a.csv, line 3: value 1 is \"x\", not a number"),
        ] {
            let error = read(text).expect_err(text);
            assert!(error.starts_with(fault), "{error}");
        }
    }
}
