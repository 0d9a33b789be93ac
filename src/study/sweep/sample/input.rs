//! What is drawn: a distribution of a key, or of several keys together, as `--vary` gives it.

use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::super::vary::{Vary, list_value};
use super::law::Law;
use crate::error::StudyError;
use crate::input_file;

/// The column of a file that says how likely its rows are.
const WEIGHT: &str = "weight";
/// What begins the text of rows of several keys.
const ROWS: &str = "rows:";
/// What the text of a distribution looks like, for hints.
const EXPECTED: &str = "expected KEY=normal:MEAN±SD, KEY=normal:MEAN±SD,A..B, KEY=lognormal:MEAN±SD, KEY=uniform:A..B, \
                        KEY=table:FILE.csv or rows:FILE.csv; +- stands for ±";

/// Keys that are drawn together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Input {
    /// dotted paths in the case
    pub keys: Vec<String>,
    /// how their values are distributed
    pub law: Law,
}

/// Whether a text of `--vary` is a distribution, so that values are drawn.
pub fn is_drawn(text: &str) -> bool {
    text.starts_with(ROWS) || law_of(text).is_some()
}

/// Key, name of the distribution and the rest.
fn law_of(text: &str) -> Option<(&str, &str, &str)> {
    let (key, given) = text.split_once('=')?;
    let (law, rest) = given.split_once(':')?;
    ["normal", "lognormal", "uniform", "table"].contains(&law.trim()).then_some((key.trim(), law.trim(), rest.trim()))
}

impl Input {
    /// Reads a text of `--vary`. The values of a list or a range are equally likely. Files are found from here.
    ///
    /// # Errors
    /// The text with its fault, and what is allowed.
    pub fn parse(text: &str) -> Result<Self, StudyError> {
        let wrong = |why: &str| StudyError::Usage(format!("--vary {text}: {why}"));
        let input = match (text.strip_prefix(ROWS), law_of(text)) {
            (Some(file), _) => {
                let (keys, rows, weights) = rows_of(file.trim()).map_err(|why| wrong(&why))?;
                Input { keys, law: Law::Rows { rows, weights } }
            }
            (None, Some((key, law, rest))) if !key.is_empty() => {
                let law = match law {
                    "uniform" => uniform(rest),
                    "table" => table(rest),
                    _ => normal(rest, law == "lognormal"),
                };
                Input { keys: vec![key.to_owned()], law: law.map_err(|why| wrong(&why))? }
            }
            _ => {
                let Vary { key, values, .. } = Vary::parse(text)?;
                let weights = vec![1.0; values.len()];
                Input {
                    keys: vec![key],
                    law: Law::Rows { rows: values.into_iter().map(|v| vec![v]).collect(), weights },
                }
            }
        };
        input.law.fault().map_or(Ok(input), |why| Err(wrong(&why)))
    }

    /// All of them; no key may be there twice.
    ///
    /// # Errors
    /// As [`Input::parse`]; a key that is there twice.
    pub fn parse_all(texts: &[String]) -> Result<Vec<Self>, StudyError> {
        let all = texts.iter().map(|text| Input::parse(text)).collect::<Result<Vec<_>, _>>()?;
        let keys: Vec<&String> = all.iter().flat_map(|input| &input.keys).collect();
        match keys.iter().enumerate().find(|(i, key)| keys[..*i].contains(*key)) {
            Some((_, key)) => Err(StudyError::Usage(format!("--vary {key} is given twice"))),
            None => Ok(all),
        }
    }

    /// Its keys as one name.
    pub fn name(&self) -> String {
        self.keys.join(", ")
    }
}

fn finite(text: &str) -> Result<f64, String> {
    let x: f64 = text.trim().parse().map_err(|_| format!("\"{}\" is no number; {EXPECTED}", text.trim()))?;
    if x.is_finite() { Ok(x) } else { Err("numbers must be finite".to_owned()) }
}

fn ends(text: &str) -> Result<[f64; 2], String> {
    let (from, to) = text.split_once("..").ok_or_else(|| format!("\"{text}\" is no interval A..B; {EXPECTED}"))?;
    Ok([finite(from)?, finite(to)?])
}

/// `MEAN±SD` or `MEAN±SD%`, with `,A..B` for what is cut off.
fn normal(text: &str, log: bool) -> Result<Law, String> {
    let (text, within) = match text.split_once(',') {
        Some((text, within)) => (text, Some(ends(within)?)),
        None => (text, None),
    };
    let parts = text.split_once('±').or_else(|| text.split_once("+-"));
    let (mean, sd) = parts.ok_or_else(|| format!("the standard deviation is missing: MEAN±SD; {EXPECTED}"))?;
    let mean = finite(mean)?;
    let sd = match sd.trim().strip_suffix('%') {
        Some(percent) => 0.01 * finite(percent)? * mean.abs(),
        None => finite(sd)?,
    };
    match (log, within) {
        (false, within) => Ok(Law::Normal { mean, sd, within }),
        (true, None) => Ok(Law::Lognormal { mean, sd }),
        (true, Some(_)) => Err("a lognormal distribution has no ends".to_owned()),
    }
}

fn uniform(text: &str) -> Result<Law, String> {
    let [from, to] = ends(text)?;
    Ok(Law::Uniform { from, to })
}

/// A file with the columns `value` and `cumulative`, or `value` and perhaps `weight`.
fn table(file: &str) -> Result<Law, String> {
    let (head, rows) = read(file)?;
    let column = |name: &str| head.iter().position(|other| other == name);
    let value = column("value").ok_or_else(|| format!("{file} has no column \"value\""))?;
    let numbers = |at: usize| rows.iter().map(|row| finite(&row[at])).collect::<Result<Vec<f64>, _>>();
    if let Some(at) = column("cumulative") {
        return Ok(Law::Table { values: numbers(value)?, cumulative: numbers(at)? });
    }
    let weights = column(WEIGHT).map_or_else(|| Ok(vec![1.0; rows.len()]), numbers)?;
    let rows = rows.iter().map(|row| Ok(vec![list_value(&row[value])?])).collect::<Result<_, String>>()?;
    Ok(Law::Rows { rows, weights })
}

/// Keys, rows and weights.
type Rows = (Vec<String>, Vec<Vec<Value>>, Vec<f64>);

/// A file whose columns are keys, but for one that may be `weight`: keys, rows and weights.
fn rows_of(file: &str) -> Result<Rows, String> {
    let (head, rows) = read(file)?;
    let weight = head.iter().position(|name| name == WEIGHT);
    let keys: Vec<usize> = (0..head.len()).filter(|at| Some(*at) != weight).collect();
    if keys.is_empty() {
        return Err(format!("{file} has no column with the name of a key"));
    }
    let weights = match weight {
        Some(at) => rows.iter().map(|row| finite(&row[at])).collect::<Result<_, _>>()?,
        None => vec![1.0; rows.len()],
    };
    let values = |row: &Vec<String>| keys.iter().map(|at| list_value(&row[*at])).collect::<Result<Vec<_>, String>>();
    let rows = rows.iter().map(values).collect::<Result<_, _>>()?;
    Ok((keys.into_iter().map(|at| head[at].clone()).collect(), rows, weights))
}

/// A csv file with a head; all rows are as long as it.
fn read(file: &str) -> Result<(Vec<String>, Vec<Vec<String>>), String> {
    let bytes = input_file::read(Path::new(file)).map_err(|why| format!("{file}: {why}"))?;
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(&bytes[..]);
    let fault = |why: csv::Error| format!("{file}: {why}");
    let owned = |row: &csv::StringRecord| row.iter().map(str::to_owned).collect::<Vec<String>>();
    let head = owned(reader.headers().map_err(fault)?);
    let rows: Vec<Vec<String>> =
        reader.records().map(|row| row.map(|row| owned(&row))).collect::<Result<_, _>>().map_err(fault)?;
    if rows.is_empty() { Err(format!("{file} has no rows")) } else { Ok((head, rows)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn distributions_as_typed() {
        let law = |text: &str| Input::parse(text).expect("good").law;
        assert_eq!(law("k=normal:3±0.5"), Law::Normal { mean: 3.0, sd: 0.5, within: None });
        assert_eq!(law("k=normal:-200+-5%"), Law::Normal { mean: -200.0, sd: 10.0, within: None });
        assert_eq!(law("k=normal:3±1,0..5"), Law::Normal { mean: 3.0, sd: 1.0, within: Some([0.0, 5.0]) });
        assert_eq!(law("k=lognormal:2±10%"), Law::Lognormal { mean: 2.0, sd: 0.2 });
        assert_eq!(law("k=uniform:-1..4"), Law::Uniform { from: -1.0, to: 4.0 });
        assert_eq!(law("k=a,b"), Law::Rows { rows: vec![vec![json!("a")], vec![json!("b")]], weights: vec![1.0; 2] });
        assert!(
            is_drawn("k=normal:1±1") && is_drawn("rows:a.csv") && !is_drawn("k=log:1..2:3") && !is_drawn("k=normal")
        );
    }

    #[test]
    fn files_have_rows() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name).display().to_string();
        let write = |name: &str, text: &str| std::fs::write(path(name), text).expect("written");
        write("set.csv", "a.b,weight,c\n1,2,\"[0, 0, 5]\"\n2.5,1,word\n");
        let input = Input::parse(&format!("rows:{}", path("set.csv"))).expect("good");
        assert_eq!(input.keys, ["a.b", "c"]);
        let rows = vec![vec![json!(1), json!([0, 0, 5])], vec![json!(2.5), json!("word")]];
        assert_eq!(input.law, Law::Rows { rows, weights: vec![2.0, 1.0] });
        write("table.csv", "value, cumulative\n0, 0\n2, 0.5\n3, 1\n");
        let input = Input::parse(&format!("k=table:{}", path("table.csv"))).expect("good");
        assert_eq!(input.law, Law::Table { values: vec![0.0, 2.0, 3.0], cumulative: vec![0.0, 0.5, 1.0] });
        write("bad.csv", "value,cumulative\n0,0\n2,0.5\n");
        let error = Input::parse(&format!("k=table:{}", path("bad.csv"))).expect_err("no end").to_string();
        assert!(error.contains("from 0 to 1"), "{error}");
    }

    #[test]
    fn what_is_no_distribution_says_why() {
        for (text, why) in [
            ("k=normal:3", "standard deviation is missing"),
            ("k=normal:3±x", "no number"),
            ("k=normal:3±0", "above 0"),
            ("k=normal:3±1,5..4", "first end"),
            ("k=normal:3±1,50..60", "of the distribution"),
            ("k=lognormal:-3±1", "above 0"),
            ("k=uniform:3", "no interval"),
            ("k=uniform:3..3", "first below"),
            ("k=table:none.csv", "none.csv"),
        ] {
            let error = Input::parse(text).expect_err(text).to_string();
            assert!(error.contains(why) && error.contains(text), "{text}: {error}");
        }
        assert!(Input::parse_all(&["k=uniform:0..1".to_owned(), "k=1,2".to_owned()]).is_err());
    }
}
