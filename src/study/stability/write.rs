//! The files of a study.

use super::region::{Scenery, regions};
use super::{Stability, csv};
use crate::integrate::registry::MethodChoice;
use crate::output::atomic::{Durability, replace};
use crate::plot::PlotError;
use crate::scene::Scene;
use std::io;
use std::path::{Path, PathBuf};

/// The files, in the order they are written: the last one only when the others are there.
pub const FILES: [&str; 3] = ["stability.csv", "stability.svg", "stability.json"];

/// Why a study cannot be kept.
#[derive(Debug, thiserror::Error)]
pub enum StabilityError {
    /// There is an earlier one.
    #[error("{folder} already holds a study ({found}); give --force to replace it, or another folder with --out")]
    HoldsStudy {
        /// the folder
        folder: String,
        /// the first file found
        found: &'static str,
    },
    /// The system's answer.
    #[error("{path}: {source}")]
    System {
        /// the path
        path: String,
        /// the reason
        source: io::Error,
    },
    /// The picture cannot be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
}

impl StabilityError {
    /// 2 for an earlier study, 1 for all else.
    pub fn exit_status(&self) -> u8 {
        match self {
            StabilityError::HoldsStudy { .. } => 2,
            StabilityError::System { .. } => 1,
            StabilityError::Plot(plot) => plot.exit_status(),
        }
    }
}

/// A folder that can take a study.
#[derive(Clone, Debug)]
pub struct Folder(PathBuf);

impl Folder {
    /// Makes the folder if need be, before anything is run.
    ///
    /// # Errors
    /// An earlier study without `force`; a folder that cannot be made.
    pub fn prepare(dir: &Path, force: bool) -> Result<Self, StabilityError> {
        let there = FILES.into_iter().find(|file| dir.join(file).symlink_metadata().is_ok());
        if let Some(found) = there.filter(|_| !force) {
            return Err(StabilityError::HoldsStudy { folder: dir.display().to_string(), found });
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
    ) -> Result<Vec<PathBuf>, StabilityError> {
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
                None => match std::fs::remove_file(&path) {
                    Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(system(&path, e)),
                    _ => {}
                },
            }
        }
        Ok(written)
    }
}

fn system(path: &Path, source: io::Error) -> StabilityError {
    StabilityError::System { path: path.display().to_string(), source }
}
