//! The files of a study.

use super::region::{Scenery, regions};
use super::{Stability, csv};
use crate::integrate::registry::MethodChoice;
use crate::output::atomic::{Durability, replace};
use crate::scene::Scene;
use crate::study::StudyError;
use crate::study::store::{remove, system};
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
        let picture = regions(&Scenery { scene, methods, study })?;
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
