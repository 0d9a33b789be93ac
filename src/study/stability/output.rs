//! The results of a stability study: a table to read, and its files.

use super::region::regions;
use super::row::AGREES;
use super::{AsGiven, KnownBy, Row, Stability, Status};
use crate::format_number::figures;
use crate::integrate::registry::MethodChoice;
use crate::output::atomic::{Durability, replace};
use crate::output::sanitize::csv_field;
use crate::scene::Scene;
use crate::study::StudyError;
use crate::study::store::{remove, system};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// The files, in the order they are written: the last one only when the others are there.
pub const FILES: [&str; 3] = ["stability.csv", "stability.svg", "stability.json"];

/// A folder that can take a study.
#[derive(Clone, Debug)]
pub struct Folder(PathBuf);

impl Folder {
    /// Makes the folder if need be, before anything is run.
    ///
    /// # Errors
    /// An earlier study without `force`; a folder that cannot be made.
    pub fn prepare(dir: &Path, force: bool) -> Result<Self, StudyError> {
        let there = FILES.into_iter().find(|file| dir.join(file).symlink_metadata().is_ok());
        if let Some(found) = there.filter(|_| !force) {
            return Err(StudyError::HoldsStudy { folder: dir.to_owned(), found });
        }
        std::fs::create_dir_all(dir).map_err(|e| system(dir, e))?;
        Ok(Folder(dir.to_owned()))
    }

    /// Writes all files of a study; returns their paths. A study in which no method has a limit has no picture, and an
    /// earlier one goes.
    ///
    /// # Errors
    /// When a file cannot be written or the picture not be drawn.
    pub fn write(
        &self,
        scene: &dyn Scene,
        methods: &[MethodChoice],
        study: &Stability,
    ) -> Result<Vec<PathBuf>, StudyError> {
        let picture = regions(scene, methods, study)?;
        let json = serde_json::to_string_pretty(study).map_err(|e| system(&self.0.join(FILES[2]), e.into()))? + "\n";
        let texts = [Some(csv(&study.methods)), picture, Some(json)];
        let mut written = Vec::new();
        for (file, text) in FILES.into_iter().zip(texts) {
            let path = self.0.join(file);
            match text {
                Some(text) => {
                    replace(&path, text.as_bytes(), Durability::Visible).map_err(|e| system(&path, e))?;
                    written.push(path);
                }
                None => remove(&path)?,
            }
        }
        Ok(written)
    }
}

/// `stability.csv`: a row a method. `predicted` and `measured` are seconds; empty: unlimited; `nan`: there is no
/// number. Two words say what each cell is worth: `prediction` is `certified`, `estimate`, `unlimited`, `unknown` or
/// `refused`, `measurement` is `limit`, `none-holds`, `no-limit-found`, `not-settled`, `refused`, `out-of-budget` or
/// `interrupted`.
pub fn csv(rows: &[Row]) -> String {
    let mut text = String::from("method,predicted,measured,prediction,measurement\n");
    for row in rows {
        let (prediction, measurement) = (prediction_word(row), measurement_word(row));
        let cell = |step: Option<f64>, unlimited: bool| match step {
            Some(step) => figures(step, 6),
            None if unlimited => String::new(),
            None => "nan".to_owned(),
        };
        let predicted = cell(row.prediction.step, prediction == "unlimited");
        let measured = cell(row.measured, measurement == "no-limit-found");
        let _ = writeln!(text, "{},{predicted},{measured},{prediction},{measurement}", csv_field(&row.method));
    }
    text
}

/// As it is written in the table.
fn known_by(row: &Row) -> &'static str {
    match (row.status, row.prediction.known_by) {
        (Status::Refused, _) => "-",
        (_, KnownBy::Unlimited) => "no limit",
        (_, KnownBy::Unknown) => "not known",
        _ => prediction_word(row),
    }
}

fn prediction_word(row: &Row) -> &'static str {
    match (row.status, row.prediction.known_by) {
        (Status::Refused, _) => "refused",
        (_, KnownBy::Certified) => "certified",
        (_, KnownBy::Estimate) => "estimate",
        (_, KnownBy::Unlimited) => "unlimited",
        (_, KnownBy::Unknown) => "unknown",
    }
}

fn measurement_word(row: &Row) -> &'static str {
    match (row.status, row.measured) {
        (Status::Refused, _) => "refused",
        (Status::NotSettled, _) => "not-settled",
        (Status::OutOfBudget, _) => "out-of-budget",
        (Status::Interrupted, _) => "interrupted",
        (Status::Measured, Some(step)) if step > 0.0 => "limit",
        (Status::Measured, Some(_)) => "none-holds",
        (Status::Measured, None) => "no-limit-found",
    }
}

/// The table for standard output, and a sentence for every method whose limits differ.
pub fn table(study: &Stability) -> String {
    let longest = study.methods.iter().map(|row| row.method.len()).max().unwrap_or(0).max(6);
    let mut text = format!("{}: largest stable steps, {} unknowns\n", study.name, study.unknowns);
    let heading = "measured [s]: holds, fails";
    let widest = study.methods.iter().map(|row| measured(row).len()).max().unwrap_or(0).max(heading.len());
    let _ = writeln!(
        text,
        "  {:<longest$}  predicted [s]  known by   {heading:<widest$}  measured/predicted  runs",
        "method"
    );
    for row in &study.methods {
        let predicted = row.prediction.step.map_or_else(|| "-".to_owned(), |step| figures(step, 4));
        let ratio = row.ratio.map_or_else(|| "-".to_owned(), |ratio| figures(ratio, 3));
        let _ = writeln!(
            text,
            "  {:<longest$}  {predicted:<13}  {:<9}  {:<widest$}  {ratio:<18}  {}",
            row.method,
            known_by(row),
            measured(row),
            row.runs.len()
        );
    }
    let differing = study.methods.iter().filter_map(|row| Some((row, row.explanation.as_ref()?)));
    for (row, why) in differing {
        let _ = writeln!(text, "{}: {why}", row.method);
    }
    for (row, given) in study.methods.iter().filter_map(|row| Some((row, row.as_given?))) {
        let _ = writeln!(text, "{}: {}", row.method, as_given(row, given));
    }
    for (row, why) in study.methods.iter().filter_map(|row| Some((row, row.why.as_ref()?))) {
        let _ = writeln!(text, "{}: {why}", row.method);
    }
    text
}

/// Why small motion was measured.
fn as_given(row: &Row, AsGiven { measured, unstable, settled }: AsGiven) -> String {
    let found = match (measured, unstable) {
        _ if !settled => between([measured, unstable])
            .map_or_else(|| "nothing is settled".to_owned(), |steps| format!("the limit is not settled: {steps}")),
        (Some(held), Some(fails)) if held > 0.0 => {
            format!("runs hold up to {} s and fail at {} s", figures(held, 4), figures(fails, 4))
        }
        (_, Some(fails)) => format!("no run holds, down from {} s", figures(fails, 4)),
        (_, None) => "no run fails".to_owned(),
    };
    let held = row.measured.or(row.tried_up_to).or(row.at_least).unwrap_or(0.0);
    let why = match unstable {
        Some(fails) if fails < (1.0 - AGREES) * held => {
            ", where steps reach beyond the range in which its forces are linear"
        }
        _ => "",
    };
    format!(
        "measured from small motion about the equilibrium, because the scene's own motion is linear; from its own start {found}{why}"
    )
}

fn measured(row: &Row) -> String {
    match (row.status, row.measured, row.unstable, row.tried_up_to) {
        (Status::Refused, ..) => "refused".to_owned(),
        (Status::NotSettled, ..) => {
            known(row).map_or_else(|| "not settled".to_owned(), |steps| format!("not settled: {steps}"))
        }
        (Status::OutOfBudget, ..) => unfinished(row, "budget"),
        (Status::Interrupted, ..) => unfinished(row, "interrupted"),
        (Status::Measured, Some(measured), Some(unstable), _) if measured > 0.0 => {
            format!("{}, {}", figures(measured, 4), figures(unstable, 4))
        }
        (Status::Measured, Some(_), Some(unstable), _) => format!("none, {}", figures(unstable, 4)),
        (Status::Measured, _, _, Some(longest)) => format!("no limit up to {}", figures(longest, 4)),
        (Status::Measured, ..) => "-".to_owned(),
    }
}

/// A measurement that ended before its time.
fn unfinished(row: &Row, why: &str) -> String {
    known(row).map_or_else(|| format!("left out: {why}"), |steps| format!("not settled ({why}): {steps}"))
}

/// What runs know of a limit that is not settled.
fn known(row: &Row) -> Option<String> {
    between([row.at_least, row.at_most])
}

fn between([least, most]: [Option<f64>; 2]) -> Option<String> {
    let least = least.map(|h| format!("at least {}", figures(h, 4)));
    let most = most.map(|h| format!("at most {}", figures(h, 4)));
    let both: Vec<String> = least.into_iter().chain(most).collect();
    (!both.is_empty()).then(|| both.join(", "))
}
