//! The results of a stability study: a table to read, and its files.

use super::region::regions;
use super::row::AGREES;
use super::{KnownBy, Row, Stability, Status};
use crate::format_number::figures;
use crate::integrate::registry::MethodChoice;
use crate::output::atomic::{Durability, replace};
use crate::output::sanitize::csv_field;
use crate::scene::Scene;
use crate::study::StudyError;
use crate::study::store::{remove, system};
use crate::study::template::render;
use serde::Serialize;
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
///
/// # Errors
/// What the template engine refuses.
pub fn table(study: &Stability) -> Result<String, StudyError> {
    #[derive(Serialize)]
    struct Table<'a> {
        agrees: f64,
        #[serde(flatten)]
        study: &'a Stability,
    }
    let table = Table { agrees: AGREES, study };
    render("stability.txt", include_str!("../../../assets/report/stability.txt"), &table)
}
