//! Measured curves.

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::error::StudyError;
use crate::output::gauge_rows::ColumnName;

/// Most points of a file.
const MOST: usize = 1_000_000;

/// A file of data and the column of a gauge that it is held against, as typed: `riser.csv:riser.tension`.
#[derive(Clone, Debug, PartialEq)]
pub struct DataSource {
    /// the file
    pub path: PathBuf,
    /// gauge and column
    pub column: ColumnName,
    /// what the values of the file are multiplied by, to have the unit of the gauge
    pub factor: f64,
}

/// A measured curve.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct DataSet {
    /// the file, as typed
    pub file: String,
    /// `GAUGE.COLUMN`
    pub of: String,
    /// [s] times
    #[serde(skip)]
    pub t: Vec<f64>,
    /// values, in the unit of the gauge
    #[serde(skip)]
    pub value: Vec<f64>,
    /// standard deviations of the values; empty if they are not known
    #[serde(skip)]
    pub sigma: Vec<f64>,
}

impl DataSource {
    /// Reads `FILE:GAUGE.COLUMN` or `FILE:GAUGE.COLUMN*FACTOR`.
    ///
    /// # Errors
    /// The text with its fault.
    pub fn parse(text: &str) -> Result<Self, StudyError> {
        let wrong = |why: &str| StudyError::Usage(format!("--data {text}: {why}"));
        let form = "expected FILE:GAUGE.COLUMN, such as riser.csv:riser.tension, or FILE:GAUGE.COLUMN*FACTOR";
        let (path, rest) = text.rsplit_once(':').ok_or_else(|| wrong(form))?;
        let (name, factor) = match rest.split_once('*') {
            None => (rest, 1.0),
            Some((name, factor)) => {
                let number = factor.trim().parse().ok().filter(|x: &f64| x.is_finite() && *x != 0.0);
                (name, number.ok_or_else(|| wrong(&format!("\"{factor}\" is no factor; expected a number but 0")))?)
            }
        };
        let (gauge, column) = name.trim().rsplit_once('.').ok_or_else(|| wrong(form))?;
        if path.is_empty() || gauge.is_empty() || column.is_empty() {
            return Err(wrong(form));
        }
        let column = ColumnName { gauge: gauge.to_owned(), column: column.to_owned() };
        Ok(DataSource { path: PathBuf::from(path), column, factor })
    }

    /// Reads the file: columns time [s], value and, if there is a third, standard deviation of the value. A first line
    /// of names, empty lines and lines that begin with `#` are skipped.
    ///
    /// # Errors
    /// A file that cannot be read; a line without two or three numbers; times that do not ascend; a standard deviation
    /// that is not above 0; too many or too few lines.
    pub fn read(&self) -> Result<DataSet, StudyError> {
        let mut table = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_path(&self.path)
            .map_err(|why| self.broken(&why))?;
        let ColumnName { gauge, column } = &self.column;
        let (file, of) = (self.path.display().to_string(), format!("{gauge}.{column}"));
        let mut data = DataSet { file, of, ..DataSet::default() };
        for (number, record) in table.records().enumerate() {
            let record = record.map_err(|why| self.broken(&why))?;
            let line = record.position().map_or(0, csv::Position::line);
            let numbers: Result<Vec<f64>, _> = record.iter().map(str::parse::<f64>).collect();
            match numbers {
                Ok(numbers) => data.add(&numbers, self.factor).map_err(|why| self.fault(line, &why))?,
                Err(_) if number == 0 => {}
                Err(_) => return Err(self.fault(line, "a field is no number")),
            }
            if data.t.len() > MOST {
                return Err(self.fault(line, &format!("more than {MOST} points")));
            }
        }
        if data.t.is_empty() {
            return Err(self.fault(0, "no points"));
        }
        if !data.sigma.is_empty() && data.sigma.len() < data.t.len() {
            return Err(self.fault(0, "some lines have a standard deviation and some have none"));
        }
        Ok(data)
    }

    fn broken(&self, why: &csv::Error) -> StudyError {
        StudyError::Usage(format!("--data {}: {why}", self.path.display()))
    }

    fn fault(&self, line: u64, why: &str) -> StudyError {
        let line = if line > 0 { format!(", line {line}") } else { String::new() };
        StudyError::Usage(format!("--data {}{line}: {why}", self.path.display()))
    }
}

impl DataSet {
    /// Adds a line of a file.
    fn add(&mut self, numbers: &[f64], factor: f64) -> Result<(), String> {
        let (t, value, sigma) = match *numbers {
            [t, value] => (t, value, None),
            [t, value, sigma] => (t, value, Some(sigma)),
            _ => {
                return Err(format!(
                    "expected 2 or 3 numbers (time, value, standard deviation), found {}",
                    numbers.len()
                ));
            }
        };
        if !numbers.iter().all(|x| x.is_finite()) {
            return Err("a number is not finite".to_owned());
        }
        if self.t.last().is_some_and(|before| *before >= t) {
            return Err(format!("times must ascend; {t} s is not after the line before"));
        }
        if sigma.is_some_and(|sigma| sigma <= 0.0) {
            return Err("a standard deviation must be above 0".to_owned());
        }
        self.t.push(t);
        self.value.push(factor * value);
        self.sigma.extend(sigma.map(|sigma| factor.abs() * sigma));
        Ok(())
    }

    /// Largest magnitude of the values; 1 where all are 0.
    pub(super) fn scale(&self) -> f64 {
        let largest = self.value.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        if largest > 0.0 { largest } else { 1.0 }
    }

    /// Its file without folders.
    pub(super) fn short(&self) -> String {
        Path::new(&self.file).file_name().map_or_else(|| self.file.clone(), |name| name.to_string_lossy().into_owned())
    }
}
