//! The frames of a run in its folder, as far as they are written, and what its summary says.

use crate::mesh::frames::{FrameFault, FramePlace, frames_of, holds_all};
use crate::output::files::FRAMES;
use crate::output::folder::SUMMARY;
use crate::output::sanitize::file_stem;
use crate::plot::PlotError;
use crate::vtk::HDF_ENDING;
use crate::vtk::read::files_of;
use serde_json::Value;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The frames of a run.
#[derive(Clone, Debug)]
pub struct Recording {
    /// folder of its results
    pub folder: PathBuf,
    /// name of its case
    pub name: String,
    /// what `summary.json` holds; `None` while the run goes on, or if it was killed
    pub summary: Option<Value>,
    /// time [s] and place of every frame
    pub frames: Vec<(f64, FramePlace)>,
}

impl Recording {
    /// Finds the frames in a folder of results, or those that a `.pvd` file lists or a `.vtkhdf` file holds.
    ///
    /// # Errors
    /// No folder, no frames, several lists of frames, or one that cannot be read.
    pub fn open(path: &Path) -> Result<Self, PlotError> {
        let is_list = holds_frames(path) && path.is_file();
        if !is_list && !path.is_dir() {
            return Err(PlotError::NoFolder(path.to_owned()));
        }
        let folder = if is_list { path.parent().unwrap_or(Path::new("")) } else { path };
        let summary = summary(folder)?;
        let named = summary.as_ref().and_then(|s| s.pointer("/case/name")).and_then(Value::as_str);
        let list = if is_list { path.to_owned() } else { list(folder, named)? };
        let frames = frames(&list)?;
        if frames.is_empty() {
            return Err(PlotError::NotThere(format!("{} lists no frames yet", list.display())));
        }
        let stem = || list.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let name = named.map_or_else(stem, str::to_owned);
        Ok(Recording { folder: folder.to_owned(), name, summary, frames })
    }

    /// A text of the summary.
    pub(super) fn word(&self, key: &str) -> Option<&str> {
        self.summary.as_ref()?.pointer(key)?.as_str()
    }
}

/// Why a frame cannot be read that is listed.
pub(crate) fn fault_of(place: &FramePlace, fault: FrameFault) -> PlotError {
    let path = place.file.clone();
    match fault {
        FrameFault::System(source) if source.kind() == ErrorKind::NotFound => PlotError::NotThere(format!(
            "{} is not there, although the list of frames names it; was it moved or removed?",
            path.display()
        )),
        FrameFault::System(source) => PlotError::System { path, source },
        FrameFault::Content(what) => PlotError::BadFile { path, line: None, what },
    }
}

/// Whether a file has the name of one that lists the frames of a run, or holds them.
fn holds_frames(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == "pvd") || holds_all(path)
}

/// The summary; a run writes it when it ends.
fn summary(folder: &Path) -> Result<Option<Value>, PlotError> {
    let path = folder.join(SUMMARY);
    let bytes = match crate::input_file::read(&path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        read => read.map_err(|source| PlotError::System { path: path.clone(), source })?,
    };
    let wrong = |e: serde_json::Error| PlotError::BadFile { path, line: Some(e.line()), what: e.to_string() };
    serde_json::from_slice(&bytes).map(Some).map_err(wrong)
}

/// The list of frames in a folder: that of the case in its summary, else the only one.
fn list(folder: &Path, named: Option<&str>) -> Result<PathBuf, PlotError> {
    let stem = named.map(file_stem);
    let own = |ending: &str| Some(folder.join(format!("{}.{ending}", stem.as_ref()?))).filter(|path| path.is_file());
    if let Some(own) = own("pvd").or_else(|| own(HDF_ENDING)) {
        return Ok(own);
    }
    let mut lists = lists(folder)?;
    let place = folder.display();
    match (lists.len(), lists.pop()) {
        (1, Some(only)) => Ok(only),
        (0, _) => Err(PlotError::NotThere(match folder.parent().filter(|_| folder.ends_with(FRAMES)) {
            Some(above) => {
                format!("{place} holds frames without their list; give the folder above it: {}", shown(above))
            }
            None => format!(
                "{place} holds no frames (no .pvd or .vtkhdf file); give a folder with results of canopy-fem solve"
            ),
        })),
        (_, Some(one)) => Err(PlotError::NotThere(format!(
            "{place} holds frames of several runs; name the file of one, such as {}",
            one.display()
        ))),
        (_, None) => Err(PlotError::NotThere(format!("{place} holds no frames"))),
    }
}

fn shown(folder: &Path) -> String {
    if folder.as_os_str().is_empty() { ".".to_owned() } else { folder.display().to_string() }
}

fn lists(folder: &Path) -> Result<Vec<PathBuf>, PlotError> {
    let system = |source| PlotError::System { path: folder.to_owned(), source };
    let mut lists = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(system)? {
        let path = entry.map_err(system)?.path();
        let hidden = path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
        if holds_frames(&path) && !hidden {
            lists.push(path);
        }
    }
    lists.sort();
    Ok(lists)
}

/// Times and places of the frames of a list, whose files are relative to its folder, or of a file that holds them.
fn frames(list: &Path) -> Result<Vec<(f64, FramePlace)>, PlotError> {
    if holds_all(list) {
        let place = || FramePlace { file: list.to_owned(), number: None };
        return frames_of(list).map_err(|fault| fault_of(&place(), fault));
    }
    let bytes = crate::input_file::read(list).map_err(|source| PlotError::System { path: list.to_owned(), source })?;
    let bad = |what: &str| PlotError::BadFile { path: list.to_owned(), line: None, what: what.to_owned() };
    let text = String::from_utf8_lossy(&bytes);
    let time = |entry: &str| entry.split('"').next()?.parse().ok().filter(|t: &f64| t.is_finite());
    let times: Option<Vec<f64>> = text.split("timestep=\"").skip(1).map(time).collect();
    let (times, files) = (times.ok_or_else(|| bad("has a frame without a time"))?, files_of(&bytes));
    if times.len() != files.len() {
        return Err(bad("has not one time for every frame"));
    }
    let folder = list.parent().unwrap_or(Path::new(""));
    let place = |file| FramePlace { file: folder.join(file), number: None };
    Ok(times.into_iter().zip(files.into_iter().map(place)).collect())
}
