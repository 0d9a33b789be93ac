//! The rows that terminal and page show: differences in words.

use serde::Serialize;

use super::combine::{cost, percent};
use super::compare::{Comparison, Errors, Shown};
use crate::format_number::figures;

/// Most quantities that have a column each in a terminal.
const COLUMNS: usize = 3;

/// The tables in a terminal: a column a quantity, or, where there are many, the largest difference only.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Printed {
    /// names of the columns of differences
    pub(super) names: Vec<String>,
    /// widths of all columns
    pub(super) widths: Vec<usize>,
    /// rows of changes within the accuracy, and of others
    pub(super) parts: [Vec<Line>; 2],
    /// the errors side by side
    pub(super) errors: Vec<ErrorLine>,
}

impl Printed {
    pub(super) fn of(names: &[&str], parts: &[&[Line]; 2], errors: &[ErrorLine]) -> Self {
        let few = names.len() <= COLUMNS;
        let short = |shares: &[Share]| -> Vec<String> {
            let largest = shares.iter().zip(names).max_by(|a, b| a.0.size.total_cmp(&b.0.size));
            match largest.filter(|_| !few) {
                Some((share, name)) if share.size >= 0.0 => vec![share.words.clone(), (*name).to_owned()],
                Some((share, _)) => vec![share.words.clone(), String::new()],
                None => shares.iter().map(|share| share.words.clone()).collect(),
            }
        };
        let names: Vec<String> = match few {
            true => names.iter().map(|name| (*name).to_owned()).collect(),
            false => ["largest", "in"].map(str::to_owned).to_vec(),
        };
        let parts = parts.map(|lines| {
            let line = |line: &Line| Line { printed: short(&line.shares), ..line.clone() };
            lines.iter().map(line).collect::<Vec<_>>()
        });
        let error = |line: &ErrorLine| ErrorLine { printed: short(&line.shares), ..line.clone() };
        let errors: Vec<ErrorLine> = errors.iter().map(error).collect();
        let lines = parts.iter().flatten().map(|line| (line.described.as_str(), &line.printed));
        let rows: Vec<(&str, &Vec<String>)> =
            lines.chain(errors.iter().map(|line| (line.of, &line.printed))).chain([("", &names)]).collect();
        let first = rows.iter().map(|(described, _)| described.chars().count()).max().unwrap_or(0);
        let letters = |cells: &Vec<String>, i: usize| cells.get(i).map_or(0, |cell| cell.chars().count());
        let column = |i: usize| rows.iter().map(|(_, cells)| letters(cells, i)).max().unwrap_or(0);
        let widths = [first].into_iter().chain((0..names.len()).map(column)).collect();
        Printed { names, widths, parts, errors }
    }
}

/// A difference in words.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Share {
    /// in words
    pub(super) words: String,
    /// [-] its size; below 0 for none
    pub(super) size: f64,
}

impl Share {
    pub(super) fn of(share: Option<f64>, words: impl Fn(f64) -> String, none: &str) -> Self {
        Share { words: share.map_or_else(|| none.to_owned(), words), size: share.map_or(-1.0, f64::abs) }
    }
}

/// A row of a printed table.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Line {
    /// what is changed
    pub(super) described: String,
    /// the difference of each quantity
    pub(super) shares: Vec<Share>,
    /// what is saved
    pub(super) cost: String,
    /// the differences in a terminal
    pub(super) printed: Vec<String>,
}

/// An error beside the others.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct ErrorLine {
    /// of what
    pub(super) of: &'static str,
    /// in each quantity
    pub(super) shares: Vec<Share>,
    /// what shows it
    pub(super) by: String,
    /// the errors in a terminal
    pub(super) printed: Vec<String>,
}

impl Line {
    pub(super) fn of(one: &Comparison) -> Self {
        Line {
            described: one.described.clone(),
            shares: one.differences.iter().map(|of| Share::of(of.share, percent, "no value")).collect(),
            cost: cost(one),
            printed: Vec::new(),
        }
    }
}

impl ErrorLine {
    /// The errors of step, mesh and model.
    pub(super) fn all(errors: &Errors, names: &[&str]) -> Vec<ErrorLine> {
        let Errors { step, mesh, harmless, harmful } = errors;
        let plus_minus = |share: f64| format!("± {} %", figures(100.0 * share.abs(), 2));
        let line = |of: &'static str, shown: &[Shown], words: &dyn Fn(f64) -> String| {
            let share = |name: &&str| shown.iter().find(|one| one.name == **name).map(|one| one.share);
            let mut by: Vec<&str> = shown.iter().map(|one| one.by.as_str()).collect();
            by.sort_unstable();
            by.dedup();
            ErrorLine {
                of,
                shares: names.iter().map(|name| Share::of(share(name), words, "-")).collect(),
                by: if by.is_empty() { "no run shows it".to_owned() } else { by.join("; ") },
                printed: Vec::new(),
            }
        };
        vec![
            line("step", step, &plus_minus),
            line("mesh", mesh, &plus_minus),
            line("model, may be left out", harmless, &percent),
            line("model, may not", harmful, &percent),
        ]
    }
}
