//! A finished run, read back from its folder.

use super::PlotError;
use super::table::rows;
use crate::drive::Status;
use crate::mesh::frames::{FrameFault, FramePlace, FrameReader, frames_of};
use crate::output::files::{FRAMES, GAUGES, HISTORY, PROBES};
use crate::output::folder::SUMMARY;
use crate::output::rows::{GAUGES_HEADER, HISTORY_HEADER, HistoryRow, PROBES_HEADER};
use crate::output::sanitize::file_stem;
use crate::vtk::HDF_ENDING;
use crate::vtk::read::{DataSet, Piece, named_array, read as read_vtk};
use serde_json::Value;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// The data of a run for charts.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// its folder
    pub folder: PathBuf,
    /// name of its case
    pub name: String,
    /// name of its method
    pub method: String,
    /// [s] its step, if it is fixed
    pub step: Option<f64>,
    /// [-] relative tolerance of a run in adaptive steps
    pub tolerance: Option<f64>,
    /// how it ended
    pub ending: RunEnd,
    /// whether it is a simple pendulum, whose bob is node 0 around the origin
    pub pendulum: bool,
    /// one row per step or per n steps
    pub history: Vec<HistoryRow>,
    /// one for every quantity of every gauge, in the order of the file
    pub gauges: Vec<GaugePath>,
    /// names of the fields in its frames, beside displacement and velocity
    pub fields: Vec<String>,
    /// one for every node of every probe, in the order of the file
    pub tracks: Vec<ProbePath>,
}

/// How a run ended.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RunEnd {
    /// its status
    pub status: Status,
    /// [s] when divergence was found, or else the time of the last state
    pub time: f64,
}

/// What a gauge measured.
#[derive(Clone, Debug, PartialEq)]
pub struct GaugePath {
    /// its name
    pub name: String,
    /// what it measures, as in the file
    pub quantity: String,
    /// its unit, or empty
    pub unit: String,
    /// time [s] and value
    pub values: Vec<(f64, f64)>,
}

/// The path of a node.
#[derive(Clone, Debug, PartialEq)]
pub struct ProbePath {
    /// name of its probe
    pub probe: String,
    /// in the user's numbering
    pub node: u32,
    /// [m] position before the initial displacement; for a bob, the lowest point
    pub reference: [f64; 3],
    /// at each frame time
    pub moments: Vec<ProbeSample>,
}

/// A node at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeSample {
    /// [s]
    pub t: f64,
    /// [m] position
    pub x: [f64; 3],
    /// [m/s] velocity
    pub v: [f64; 3],
}

impl Run {
    /// Reads the folder of a run that has ended in any way.
    ///
    /// # Errors
    /// No folder, no results in it, or a file that `canopy-fem solve` did not write.
    pub fn read(folder: &Path) -> Result<Self, PlotError> {
        if !folder.is_dir() {
            return Err(PlotError::NoFolder(folder.to_owned()));
        }
        let mut run = read_summary(folder)?;
        let path = folder.join(HISTORY);
        run.history = rows(&path, &text(folder, HISTORY, "")?, HISTORY_HEADER)?;
        // A run without probes or gauges has no such file.
        let path = folder.join(PROBES);
        if path.exists() {
            run.tracks = read_probes(&path, &text(folder, PROBES, "")?)?;
        }
        let path = folder.join(GAUGES);
        if path.exists() {
            read_gauges(&path, &text(folder, GAUGES, "")?, &mut run.gauges)?;
        }
        if !run.tracks.is_empty() {
            place(&mut run)?;
        }
        Ok(run)
    }
}

impl Run {
    /// The times [s] of the frames and what `measure` finds in an array of each, which is on points or on cells.
    ///
    /// # Errors
    /// No list of frames, a missing or damaged frame, or one without this array.
    pub(super) fn over_frames<T>(
        &self,
        array: &str,
        measure: impl Fn(&[f64]) -> T,
    ) -> Result<Vec<(f64, T)>, PlotError> {
        let stem = file_stem(&self.name);
        if let Some(one) = one_file(&self.folder, &stem) {
            return over_one(&one, array, measure);
        }
        let list = format!("{stem}.pvd");
        let collection = text(&self.folder, &list, "; it lists the frames")?;
        let mut found = Vec::new();
        // The frames of the list are numbered from 0.
        for (i, entry) in collection.split("timestep=\"").skip(1).enumerate() {
            let time = entry.split('"').next().and_then(|t| t.parse().ok());
            let t = time.ok_or_else(|| bad(&self.folder.join(&list), format!("has no time of frame {i}")))?;
            let file = format!("{FRAMES}/{stem}_{i:06}.vtu");
            let frame = bytes(&self.folder, &file, "; it is in the list of frames")?;
            let values = read_vtk(&frame, &[array]).and_then(|frame| values_of(frame, array));
            found.push((t, measure(&values.map_err(|what| bad(&self.folder.join(&file), what))?)));
        }
        Ok(found)
    }
}

/// The file that holds all frames of a run, if there is one.
fn one_file(folder: &Path, stem: &str) -> Option<PathBuf> {
    Some(folder.join(format!("{stem}.{HDF_ENDING}"))).filter(|path| path.is_file())
}

/// What [`Run::over_frames`] finds in a file that holds all frames.
fn over_one<T>(file: &Path, array: &str, measure: impl Fn(&[f64]) -> T) -> Result<Vec<(f64, T)>, PlotError> {
    let fault = |fault| match fault {
        FrameFault::System(source) => PlotError::System { path: file.to_owned(), source },
        FrameFault::Content(what) => bad(file, what),
    };
    let mut reader = FrameReader::default();
    let mut found = Vec::new();
    for (t, place) in frames_of(file).map_err(fault)? {
        let frame = reader.read(&place, &[array]).map_err(fault)?;
        found.push((t, measure(&values_of(frame, array).map_err(|what| bad(file, what))?)));
    }
    Ok(found)
}

/// The numbers of an array of a frame, which is on points or on cells.
fn values_of(frame: DataSet, array: &str) -> Result<Vec<f64>, String> {
    let piece = piece_of(frame)?;
    let on_points = named_array(&piece.point_data, array);
    on_points.or_else(|| named_array(&piece.cell_data, array)).ok_or(format!("has no array \"{array}\""))
}

fn piece_of(frame: DataSet) -> Result<Piece, String> {
    frame.pieces.into_iter().next().ok_or("has no points".to_owned())
}

fn bytes(folder: &Path, file: &str, why: &'static str) -> Result<Vec<u8>, PlotError> {
    let path = folder.join(file);
    crate::input_file::read(&path).map_err(|source| match source.kind() {
        std::io::ErrorKind::InvalidInput => bad(&path, source.to_string()),
        std::io::ErrorKind::NotFound => PlotError::NoFile { folder: folder.to_owned(), file: file.to_owned(), why },
        _ => PlotError::System { path, source },
    })
}

fn text(folder: &Path, file: &str, why: &'static str) -> Result<String, PlotError> {
    let what = "is no text (UTF-8)".to_owned();
    String::from_utf8(bytes(folder, file, why)?).map_err(|_| bad(&folder.join(file), what))
}

fn bad(path: &Path, what: String) -> PlotError {
    PlotError::BadFile { path: path.to_owned(), line: None, what }
}

/// Reads only the keys that charts need, so that results of other versions of the program can be drawn too.
fn read_summary(folder: &Path) -> Result<Run, PlotError> {
    let path = folder.join(SUMMARY);
    let text = text(folder, SUMMARY, "; a run writes it when it ends")?;
    let json: Value = serde_json::from_str(&text).map_err(|e| PlotError::BadFile {
        path: path.clone(),
        line: Some(e.line()),
        what: e.to_string(),
    })?;
    let missing = |key: &str| bad(&path, format!("has no \"{key}\" that can be read"));
    let word = |key: &str| json.pointer(key).and_then(Value::as_str).map(str::to_owned).ok_or_else(|| missing(key));
    let number = |key: &str| json.pointer(key).and_then(Value::as_f64);
    let status = json.get("status").cloned().and_then(|s| serde_json::from_value(s).ok());
    // A run that continued after a divergence is drawn up to the divergence.
    let fields = json.pointer("/case/output/fields").and_then(Value::as_array);
    let ended = number("/failure/blow_up_time").or_else(|| number("/failure/time")).or_else(|| number("/t_end"));
    Ok(Run {
        folder: folder.to_owned(),
        name: word("/case/name")?,
        method: word("/method")?,
        step: number("/case/time/step"),
        tolerance: number("/case/time/tolerance/relative"),
        ending: RunEnd {
            status: status.ok_or_else(|| missing("/status"))?,
            time: ended.ok_or_else(|| missing("/t_end"))?,
        },
        pendulum: json.pointer("/case/system/pendulum").is_some_and(|p| !p.is_null()),
        history: Vec::new(),
        gauges: units(&json),
        fields: fields.into_iter().flatten().filter_map(Value::as_str).map(str::to_owned).collect(),
        tracks: Vec::new(),
    })
}

/// The quantities of gauges with their units, from the peaks of a summary; still without values.
pub(crate) fn units(summary: &Value) -> Vec<GaugePath> {
    let peaks = summary.get("peaks").and_then(Value::as_array).into_iter().flatten();
    let gauge = |peak: &Value| {
        let word = |key: &str| peak.get(key).and_then(Value::as_str).unwrap_or_default().to_owned();
        GaugePath { name: word("name"), quantity: word("quantity"), unit: word("unit"), values: Vec::new() }
    };
    peaks.map(gauge).collect()
}

/// Reads `gauges.csv` into the quantities of the summary, and those that it does not know.
pub(crate) fn read_gauges(path: &Path, text: &str, gauges: &mut Vec<GaugePath>) -> Result<(), PlotError> {
    let key = |gauge: &GaugePath| (gauge.name.clone(), gauge.quantity.clone());
    let mut known: HashMap<(String, String), usize> = gauges.iter().map(key).zip(0..).collect();
    for (t, name, quantity, value) in rows::<(f64, String, String, f64)>(path, text, GAUGES_HEADER)? {
        let at = *known.entry((name.clone(), quantity.clone())).or_insert_with(|| {
            gauges.push(GaugePath { name, quantity, unit: String::new(), values: Vec::new() });
            gauges.len() - 1
        });
        if let Some(gauge) = gauges.get_mut(at) {
            gauge.values.push((t, value));
        }
    }
    gauges.retain(|gauge| !gauge.values.is_empty());
    Ok(())
}

/// A row of `probes.csv`: time [s], probe, node, position [m] and velocity [m/s].
type ProbeRow = (f64, String, u32, [f64; 3], [f64; 3]);

fn read_probes(path: &Path, text: &str) -> Result<Vec<ProbePath>, PlotError> {
    let mut tracks: Vec<ProbePath> = Vec::new();
    let mut known: HashMap<(String, u32), usize> = HashMap::new();
    for (t, probe, node, x, v) in rows::<ProbeRow>(path, text, PROBES_HEADER)? {
        let at = *known.entry((probe.clone(), node)).or_insert_with(|| {
            tracks.push(ProbePath { probe, node, reference: [0.0; 3], moments: Vec::new() });
            tracks.len() - 1
        });
        if let Some(track) = tracks.get_mut(at) {
            track.moments.push(ProbeSample { t, x, v });
        }
    }
    Ok(tracks)
}

/// Gives every track the reference position of its node.
fn place(run: &mut Run) -> Result<(), PlotError> {
    if run.pendulum {
        // The displacements of a bob in the frames are from the start of the run, which is not a rest position.
        for track in &mut run.tracks {
            let length = track.moments.first().map_or(0.0, |m| m.x[0].hypot(m.x[2]));
            track.reference = [0.0, 0.0, -length];
        }
        return Ok(());
    }
    let stem = file_stem(&run.name);
    let (path, first) = match one_file(&run.folder, &stem) {
        Some(path) => {
            let place = FramePlace { file: path.clone(), number: Some(0) };
            (path, FrameReader::default().read(&place, &["displacement"]).map_err(|fault| fault.to_string()))
        }
        None => {
            let file = format!("{FRAMES}/{stem}_000000.vtu");
            let first = bytes(&run.folder, &file, "; displacements count from the positions in it")?;
            (run.folder.join(&file), read_vtk(&first, &["displacement"]))
        }
    };
    let reference = first.and_then(reference_positions).map_err(|what| bad(&path, what))?;
    for track in &mut run.tracks {
        let found = reference.get(track.node as usize).copied();
        track.reference = found.ok_or_else(|| bad(&path, format!("has no node {}, which is probed", track.node)))?;
    }
    Ok(())
}

/// [m] `[n_nodes]` Positions of nodes before the initial displacement, from a frame: its points minus its
/// displacements.
///
/// `probes.csv` has positions, and a run may begin displaced, so its first row is not enough. The case would be enough,
/// but making its mesh again takes long and needs the mesh file at its place.
fn reference_positions(frame: DataSet) -> Result<Vec<[f64; 3]>, String> {
    let piece = piece_of(frame)?;
    let points = piece.points.as_flattened();
    let displacement = named_array(&piece.point_data, "displacement").ok_or("has no array \"displacement\"")?;
    let reference: Vec<f64> = points.iter().zip(&displacement).map(|(x, u)| x - u).collect();
    match reference.as_chunks() {
        (positions, []) if points.len() == displacement.len() => Ok(positions.to_vec()),
        _ => Err(format!("has {} coordinates but {} displacements", points.len(), displacement.len())),
    }
}
