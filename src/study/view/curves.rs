//! The gauges of a run and its largest speed and energies, as far as they are written.

use super::page::encoded;
use crate::model::gauge::{PeakRule, Quantity};
use crate::output::files::{GAUGES, HISTORY};
use crate::output::gauges::names::for_people;
use crate::output::rows::{HISTORY_HEADER, HistoryRow};
use crate::output::stages::{StagePeak, StageReport};
use crate::plot::PlotError;
use crate::plot::decimate::thin;
use crate::plot::results::{GaugePath, read_gauges, units};
use crate::plot::table::rows;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::io::ErrorKind;
use std::path::Path;

/// Points of a curve on the page.
const MOST: usize = 2000;
/// A column of the history with its name and unit.
type OfScene = (&'static str, &'static str, fn(&HistoryRow) -> f64);
/// What is shown of the scene as a whole.
const OF_SCENE: [OfScene; 3] = [
    ("largest speed", "m/s", |row| row.max_speed),
    ("kinetic energy", "J", |row| row.ledger.kinetic),
    ("elastic energy", "J", |row| row.ledger.elastic),
];
/// Curves over time for a page.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Curves {
    /// what each is
    pub heads: Vec<CurveHead>,
    /// times [s] and values of all curves, single precision, compressed, in base64
    pub data: String,
}

/// A curve.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct CurveHead {
    /// what it is, in words
    pub label: String,
    /// name of the gauge; empty for what is of the whole scene
    pub name: String,
    /// what it measures
    pub quantity: String,
    /// its unit
    pub unit: String,
    /// number of points
    pub points: usize,
    /// time [s] and value of its peak
    pub peak: Option<[f64; 2]>,
    /// peaks of the stages of the run, but for the one that is the peak of the whole run
    pub stages: Vec<StageMark>,
    /// whether it is shown without being asked for: what the report of a run tells of gauges
    pub first: bool,
}

/// The peak of a curve in a stage of the run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct StageMark {
    /// name of the stage
    pub name: String,
    /// time [s] and value
    pub at: [f64; 2],
}

impl Curves {
    /// Reads the gauges and the history of a folder.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub(super) fn read(folder: &Path, summary: Option<&Value>) -> Result<Self, PlotError> {
        let mut gauges = summary.map(units).unwrap_or_default();
        if let Some(text) = whole_lines(&folder.join(GAUGES))? {
            read_gauges(&folder.join(GAUGES), &text, &mut gauges)?;
        }
        let reported = |of: &GaugePath| Quantity::named(&of.quantity).is_some_and(|column| column.line.is_some());
        let any = gauges.iter().any(reported);
        let mut curves: Vec<(GaugePath, bool)> =
            gauges.into_iter().map(|of| (reported(&of), of)).map(|(a, b)| (b, a)).collect();
        if let Some(text) = whole_lines(&folder.join(HISTORY))? {
            let history: Vec<HistoryRow> = rows(&folder.join(HISTORY), &text, HISTORY_HEADER)?;
            for (quantity, unit, of) in OF_SCENE {
                let values = history.iter().map(|row| (row.t, of(row))).collect();
                let path = GaugePath { name: String::new(), quantity: quantity.into(), unit: unit.into(), values };
                curves.push((path, !any));
            }
        }
        let stages = summary.and_then(|summary| Vec::deserialize(summary.get("stages")?).ok()).unwrap_or_default();
        Ok(packed(&curves, &stages))
    }
}

/// The peaks of a gauge in the stages of a run, of which 0 is none.
fn marks(stages: &[StageReport], gauge: &GaugePath, of_run: Option<[f64; 2]>) -> Vec<StageMark> {
    let mark = |stage: &StageReport| {
        let own = |peak: &&StagePeak| peak.name == gauge.name && peak.quantity == gauge.quantity;
        let peak = stage.peaks.iter().find(own)?;
        Some(StageMark { name: stage.name.clone(), at: [peak.t?, peak.value] })
    };
    let told = |mark: &StageMark| mark.at[1] != 0.0 && of_run.is_none_or(|peak| peak[0] != mark.at[0]);
    stages.iter().filter_map(mark).filter(told).collect()
}

/// The curves with the bytes of their points.
fn packed(curves: &[(GaugePath, bool)], stages: &[StageReport]) -> Curves {
    let labels = for_people(curves.iter().map(|(path, _)| path.name.as_str()));
    let (mut heads, mut bytes) = (Vec::new(), Vec::new());
    for (path, first) in curves {
        let finite: Vec<(f64, f64)> =
            path.values.iter().copied().filter(|(t, v)| t.is_finite() && v.is_finite()).collect();
        let kept = thin(&finite, MOST);
        bytes.extend(kept.iter().flat_map(|(t, value)| [*t as f32, *value as f32]).flat_map(f32::to_le_bytes));
        let known = Quantity::named(&path.quantity);
        let unit = if path.unit.is_empty() { known.map_or("", |column| column.unit) } else { &path.unit };
        let signed = known.is_some_and(|column| column.peak == PeakRule::LargestMagnitude);
        let size = |(_, value): &(f64, f64)| if signed { value.abs() } else { *value };
        // The first of equal ones.
        let peak = finite.iter().rev().max_by(|a, b| size(a).total_cmp(&size(b))).map(|(t, value)| [*t, *value]);
        heads.push(CurveHead {
            label: label(labels.get(path.name.as_str()).copied().unwrap_or_default(), &path.quantity),
            name: path.name.clone(),
            quantity: path.quantity.replace('_', " "),
            unit: unit.replace("^2", "²").replace("^3", "³"),
            points: kept.len(),
            peak,
            stages: marks(stages, path, peak),
            first: *first,
        });
    }
    Curves { heads, data: encoded(&bytes) }
}

/// A column in words, with the name of its gauge.
fn label(gauge: &str, column: &str) -> String {
    let words = Quantity::named(column).map_or_else(|| column.replace('_', " "), |known| known.words());
    if gauge.is_empty() { words } else { format!("{words} ({gauge})") }
}

/// A file up to its last whole line; `None` without a file. A run that goes on may be writing the next one.
fn whole_lines(path: &Path) -> Result<Option<String>, PlotError> {
    let bytes = match crate::input_file::read(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        read => read.map_err(|source| PlotError::System { path: path.to_owned(), source })?,
    };
    let end = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1);
    Ok(std::str::from_utf8(&bytes[..end]).ok().filter(|text| !text.is_empty()).map(str::to_owned))
}
