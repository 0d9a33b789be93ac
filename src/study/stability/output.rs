//! The results of a stability study: a table to read, and its files.

use super::region::{panels, picture};
use super::row::AGREES;
use super::{Row, Stability};
use crate::StudyError;
use crate::integrate::registry::MethodChoice;
use crate::method_look::BLACK;
use crate::plot::chart::{Chart, Line, Size};
use crate::plot::layout::legend_samples;
use crate::scene::Scene;
use crate::store::{system, write_files};
use crate::template::{PageFigure, render, told};
use minijinja::context;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The files, in the order they are written: the last one only when the others are there.
pub const FILES: [&str; 4] = ["stability.csv", "stability.svg", "stability.html", "stability.json"];

/// [px] A region on the page.
const PANEL: Size = Size { width: 330, height: 360 };

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
        let json = serde_json::to_string_pretty(study).map_err(|e| system(&self.0.join(FILES[3]), e.into()))? + "\n";
        let charts = panels(scene, methods, study);
        let page = html(study, &charts)?;
        let picture = picture(charts, methods, study)?;
        let mut made = vec![(FILES[0], csv(&study.methods)?), (FILES[2], page), (FILES[3], json)];
        made.extend(picture.map(|picture| (FILES[1], picture)));
        write_files(&self.0, &FILES, &made)
    }
}

/// `stability.csv`: a row a method. `predicted` and `measured` are seconds; empty: unlimited; `nan`: there is no
/// number. Two words say what each cell is worth: `prediction` is `certified`, `estimate`, `unlimited`, `unknown` or
/// `refused`, `measurement` is `limit`, `none-holds`, `no-limit-found`, `not-settled`, `refused`, `out-of-budget` or
/// `interrupted`.
///
/// # Errors
/// What the template engine refuses.
pub fn csv(methods: &[Row]) -> Result<String, StudyError> {
    render("stability.csv", include_str!("../templates/stability.csv"), &context! { methods })
}

/// `stability.html`: one page that needs nothing beside it.
fn html(study: &Stability, charts: &[Chart]) -> Result<String, StudyError> {
    let Stability { name, end, unknowns, methods, case, version } = study;
    let case_json = serde_json::to_string_pretty(case).map_err(|e| StudyError::Page(e.to_string()))?;
    let panel = |chart: &Chart| PageFigure::of(chart, "", [PANEL, PANEL]);
    let panels = charts.iter().map(panel).collect::<Result<Vec<_>, _>>()?;
    // The marks of no method in particular.
    let plain = |line: &Line| Line { color: Some(BLACK), ..line.clone() };
    let lines: Vec<Line> = charts.first().map(|chart| chart.lines.iter().map(plain).collect()).unwrap_or_default();
    let legend = legend_samples(&lines);
    let told: BTreeMap<&str, Vec<[String; 2]>> =
        methods.iter().map(|row| (row.method.as_str(), told_of(row))).collect();
    let page = context! { name, end, unknowns, methods, case_json, version, panels, legend, told };
    render("stability.html", include_str!("../templates/stability.html"), &page)
}

/// What the marks of a method tell.
fn told_of(row: &Row) -> Vec<[String; 2]> {
    let all = [
        ("method", row.method.clone()),
        ("predicted limit [s]", told(row.prediction.step)),
        ("holds [s]", told(row.measured)),
        ("fails [s]", told(row.unstable)),
        ("measured over predicted", told(row.ratio)),
        ("frequency [rad/s]", told(row.prediction.frequency)),
        ("damping [1/s]", told(row.prediction.damping)),
    ];
    all.into_iter().filter(|(_, text)| !text.is_empty()).map(|(name, text)| [name.to_owned(), text]).collect()
}

/// The table for standard output, and a sentence for every method whose limits differ.
///
/// # Errors
/// What the template engine refuses.
pub fn table(study: &Stability) -> Result<String, StudyError> {
    let Stability { name, unknowns, methods, .. } = study;
    let context = context! { agrees => AGREES, name, unknowns, methods };
    render("stability.txt", include_str!("../templates/stability.txt"), &context)
}
