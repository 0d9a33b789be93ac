//! Comma-separated files of known columns, read strictly (RFC 4180), with the line of every fault.

use super::PlotError;
use std::path::Path;
use std::str::FromStr;

/// A row and the line it begins on.
pub(super) struct CsvRow<'a> {
    path: &'a Path,
    line: usize,
    cells: Vec<String>,
}

/// All rows of a file below its header.
///
/// # Errors
/// Another header, a row of another length, or a quote that does not end.
pub(super) fn rows<'a>(path: &'a Path, text: &str, header: &str) -> Result<Vec<CsvRow<'a>>, PlotError> {
    let columns = header.split(',').count();
    let mut reader = Reader { rest: text, line: 1 };
    let mut rows = Vec::new();
    loop {
        let line = reader.line;
        let fault = |what: String| PlotError::BadFile { path: path.to_owned(), line: Some(line), what };
        let Some(cells) = reader.record().map_err(|what| fault(what.to_owned()))? else { break };
        if line == 1 {
            if cells.join(",") != header {
                return Err(fault(format!("expected the header \"{header}\"")));
            }
        } else if cells.len() == columns {
            rows.push(CsvRow { path, line, cells });
        } else {
            return Err(fault(format!("{} values where {columns} are expected", cells.len())));
        }
    }
    if reader.line == 1 {
        let what = format!("is empty; expected the header \"{header}\"");
        return Err(PlotError::BadFile { path: path.to_owned(), line: None, what });
    }
    Ok(rows)
}

impl CsvRow<'_> {
    /// A cell as text.
    pub(super) fn text(&self, column: usize) -> &str {
        self.cells.get(column).map_or("", String::as_str)
    }

    /// A cell as a number; NaN and inf are numbers a diverged run writes.
    ///
    /// # Errors
    /// A cell that is none.
    pub(super) fn number<T: FromStr>(&self, column: usize) -> Result<T, PlotError> {
        let text = self.text(column);
        text.parse().map_err(|_| PlotError::BadFile {
            path: self.path.to_owned(),
            line: Some(self.line),
            what: format!("value {} is \"{text}\", not a number as expected there", column + 1),
        })
    }

    /// Consecutive cells as numbers.
    ///
    /// # Errors
    /// A cell that is none.
    pub(super) fn numbers<const N: usize>(&self, first: usize) -> Result<[f64; N], PlotError> {
        let mut values = [0.0; N];
        for (i, value) in values.iter_mut().enumerate() {
            *value = self.number(first + i)?;
        }
        Ok(values)
    }
}

struct Reader<'a> {
    rest: &'a str,
    /// of the next record, counted from 1
    line: usize,
}

impl Reader<'_> {
    /// The next record; nothing at the end.
    fn record(&mut self) -> Result<Option<Vec<String>>, &'static str> {
        if self.rest.is_empty() {
            return Ok(None);
        }
        let (mut cells, mut cell, mut quoted) = (Vec::new(), String::new(), false);
        let mut letters = self.rest.char_indices().peekable();
        while let Some((at, letter)) = letters.next() {
            self.line += usize::from(letter == '\n');
            match letter {
                '"' if quoted && letters.next_if(|(_, next)| *next == '"').is_some() => cell.push('"'),
                '"' => quoted = !quoted,
                ',' if !quoted => cells.push(std::mem::take(&mut cell)),
                '\r' if !quoted && letters.peek().is_some_and(|(_, next)| *next == '\n') => {}
                '\n' if !quoted => {
                    cells.push(cell);
                    self.rest = self.rest.get(at + 1..).unwrap_or("");
                    return Ok(Some(cells));
                }
                other => cell.push(other),
            }
        }
        // The program writes whole lines only; a torn last one is what a full disk or a power cut leaves.
        Err(if quoted { "a quote that does not end" } else { "the line does not end; the file was cut off" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<Vec<String>>, String> {
        let rows = rows(Path::new("a.csv"), text, "t,name").map_err(|e| e.to_string())?;
        Ok(rows.into_iter().map(|r| r.cells).collect())
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
            ("x,name\n", "a.csv, line 1: expected the header"),
            ("t,name\n1,a\n2\n", "a.csv, line 3: 1 values where 2"),
            ("t,name\n1,\"a\nb\"\n2,c,d\n", "a.csv, line 4: 3 values where 2"),
            ("t,name\n1,\"a\n", "a.csv, line 2: a quote"),
            ("t,name\n1,a\n2,", "a.csv, line 3: the line does not end"),
        ] {
            let error = read(text).expect_err(text);
            assert!(error.starts_with(fault), "{error}");
        }
        let rows = rows(Path::new("a.csv"), "t,name\n1e-3,x\n", "t,name").expect("good");
        assert_eq!(rows[0].number::<f64>(0).expect("a number"), 1e-3);
        let error = rows[0].number::<f64>(1).expect_err("no number").to_string();
        assert!(error.starts_with("a.csv, line 2: value 2 is \"x\""), "{error}");
    }
}
