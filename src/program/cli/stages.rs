//! The stages of a run in the report of `canopy-fem solve`: what was reached in each, and under what circumstances.

use crate::format_number::figures;
use crate::model::gauge::DRAG;
use crate::output::quantity::word;
use crate::output::stages::{Circumstances, StagePeak, StageReport};
use std::fmt::Write;

/// Peaks of a stage that are shown, the drag of canopies first.
const SHOWN: usize = 3;
/// Width of the column that all lines of the report begin with.
const LABEL: usize = 18;

/// The lines on the stages of a run; none where there is one stage only, in which no canopy opens.
pub(super) fn lines(stages: &[StageReport]) -> String {
    let opens = |stage: &StageReport| stage.peaks.iter().any(|peak| peak.opening_force_coefficient.is_some());
    if stages.len() < 2 && !stages.iter().any(opens) {
        return String::new();
    }
    let head = ["stages", "peak", "at", "speed", "height", "drag area", "CD0"].map(str::to_owned);
    let rows: Vec<[String; 7]> = std::iter::once(head).chain(stages.iter().flat_map(rows)).collect();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    // A scene without canopies has neither speed nor height.
    let used: Vec<usize> = (0..7).filter(|&column| rows.iter().skip(1).any(|row| !row[column].is_empty())).collect();
    let mut text = String::new();
    for row in &rows {
        let cell = |&column: &usize| {
            let width = if column == 0 { width(0).max(LABEL - 4) } else { width(column) };
            format!("{:<width$}", row[column])
        };
        let cells: Vec<String> = used.iter().map(cell).collect();
        let _ = writeln!(text, "  {}", cells.join("  ").trim_end());
    }
    text + &coefficients(stages)
}

/// A row for each peak of a stage that is shown. Springs with a strength have lines of their own, and what is cut has
/// no tension.
fn rows(stage: &StageReport) -> Vec<[String; 7]> {
    let shown = |peak: &&StagePeak| !peak.name.starts_with("springs[") && peak.value != 0.0;
    let mut peaks: Vec<&StagePeak> = stage.peaks.iter().filter(shown).collect();
    // Stable: gauges stay in the order of the case.
    peaks.sort_by_key(|peak| peak.quantity != DRAG.name);
    let row = |(number, peak): (usize, &&StagePeak)| {
        let Circumstances { speed, height, drag_area, drag_coefficient } = peak.at;
        let with = |value: Option<f64>, unit: &str| value.map_or_else(String::new, |v| figures(v, 4) + unit);
        [
            if number == 0 { stage.name.clone() } else { String::new() },
            format!("{} {} ({}, {})", figures(peak.value, 4), peak.unit, peak.name, word(&peak.quantity)),
            peak.t.map_or_else(|| "mean".to_owned(), |t| figures(t, 4) + " s"),
            with(speed, " m/s"),
            with(height, " m"),
            with(drag_area, " m^2"),
            with(drag_coefficient, ""),
        ]
    };
    peaks.iter().take(SHOWN).enumerate().map(row).collect()
}

/// The opening-force coefficients of all canopies and stages, in a line.
fn coefficients(stages: &[StageReport]) -> String {
    let several = |stage: &StageReport| stage.peaks.iter().filter(|peak| peak.quantity == DRAG.name).count() > 1;
    let of_stage = |stage: &StageReport| {
        let of = |peak: &StagePeak| {
            let canopy = if several(stage) { format!(" of {}", peak.name) } else { String::new() };
            Some(format!("{} {}{canopy}", figures(peak.opening_force_coefficient?, 3), stage.name))
        };
        stage.peaks.iter().filter_map(of).collect::<Vec<_>>()
    };
    let all: Vec<String> = stages.iter().flat_map(of_stage).collect();
    if all.is_empty() {
        return String::new();
    }
    format!(
        "  opening-force   coefficient {} (peak drag over q at its start and drag area at its end)\n",
        all.join(", ")
    )
}
