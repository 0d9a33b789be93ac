//! Stages of a run: what its gauges and canopies reached in each, and under what circumstances.
//!
//! A stage begins at the start of the run and at every event, such as the cut of a reefing line. A state at which an
//! event happens belongs to the stage that ends there.

use serde::{Deserialize, Serialize};

use super::gauges::Channel;
use super::statistics::{SeriesSoFar, late_from};
use crate::case::spec::{StageStart, StagesSpec};
use crate::model::gauge::{
    ANGLE_OF_ATTACK, AXIAL_SPEED, CANOPY_QUANTITIES, DRAG, DRAG_AREA, DRAG_COEFFICIENT, DYNAMIC_PRESSURE, Quantity,
    ReportLine,
};

/// [-] Relative difference of times that are the same.
const SAME: f64 = 1e-12;
/// [-] Share of the drag area at the end of a stage from which on a canopy was open when the stage began.
const OPEN: f64 = 0.9;

/// The largest value of a quantity of a gauge in a stage, for `summary.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StagePeak {
    /// name of the gauge
    pub name: String,
    /// what it measures
    pub quantity: String,
    /// its unit
    pub unit: String,
    /// largest value; of the last tenth of the run, the mean
    pub value: f64,
    /// [s] when it was reached first; not given for a mean
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub t: Option<f64>,
    /// what the canopies and the payload did then
    #[serde(flatten)]
    pub at: Circumstances,
    /// [-] of a drag, the opening-force coefficient: the peak over the dynamic pressure at the start of the stage and
    /// the drag area at its end
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opening_force_coefficient: Option<f64>,
}

/// What the canopies and the payload did at a time; nothing that the scene does not have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Circumstances {
    /// [m/s] speed of the canopy against the air; of several canopies the mean
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed: Option<f64>,
    /// [m] z of the payload
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height: Option<f64>,
    /// [m^2] drag area of the canopy; of several canopies the sum
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drag_area: Option<f64>,
    /// [-] drag coefficient of the canopy on S0; not given for several canopies
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drag_coefficient: Option<f64>,
}

/// A stage of a run, for `summary.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StageReport {
    /// its name, such as `opening` or `disreef 1`; for the last tenth of the run `steady` if the speeds of all canopies
    /// are steady there, else `last tenth`
    pub name: String,
    /// [s] its start
    pub from: f64,
    /// [s] its end, or that of the run
    pub to: f64,
    /// the peaks of the quantities that have a line in the report of the run, in the order of the gauges
    pub peaks: Vec<StagePeak>,
}

/// What is kept of the stages from step to step; part of a checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct StagesSoFar {
    /// the stages that have begun
    stages: Vec<StageSoFar>,
    /// how many of those that begin at a known time have begun
    known: usize,
    /// of each canopy, dynamic pressure [Pa] and drag area [m^2] in the newest state
    newest: Vec<[f64; 2]>,
}

/// Where the channels are that stages are told by.
#[derive(Debug, Default)]
pub(super) struct StagePlaces {
    /// of each canopy, its first channel
    pub canopies: Vec<usize>,
    /// channel of the payload's z, if it is known
    pub height: Option<usize>,
}

/// A stage so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct StageSoFar {
    start: StageStart,
    /// [s] newest state
    to: f64,
    /// of each channel that is followed
    peaks: Vec<Option<PeakSoFar>>,
    /// of each canopy: \[Pa\] dynamic pressure and \[m^2\] drag area at the start
    before: Vec<[f64; 2]>,
    /// of each canopy: \[m^2\] drag area in the newest state
    area: Vec<f64>,
}

/// The peak of a channel in a stage so far.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct PeakSoFar {
    value: f64,
    t: f64,
    /// speed, height, drag area, drag coefficient; NaN where there is none
    at: [f64; 4],
}

/// The stages of a run.
#[derive(Debug, Default)]
pub(super) struct Stages {
    /// stages that begin at a known time, ascending
    known: Vec<StageStart>,
    /// channels that are followed
    followed: Vec<usize>,
    /// of each canopy, its first channel
    canopies: Vec<usize>,
    /// channel of the payload's z, if it is known
    height: Option<usize>,
    pub so_far: StagesSoFar,
}

impl Stages {
    /// Follows the stages of a run whose canopies have these first channels; none where there is neither a canopy nor
    /// an event.
    pub(super) fn new(spec: &StagesSpec, channels: &[Channel], places: StagePlaces) -> Self {
        let (known, StagePlaces { canopies, height }) = (&spec.starts, places);
        if canopies.is_empty() && known.len() < 2 && !spec.events {
            return Stages::default();
        }
        let of_report =
            |channel: &Channel| matches!(channel.quantity.line, Some(ReportLine::Peak(_) | ReportLine::Drag));
        let followed = (0..channels.len()).filter(|number| channels.get(*number).is_some_and(of_report)).collect();
        Stages { known: known.to_vec(), followed, canopies, height, so_far: StagesSoFar::default() }
    }

    /// Whether no stage is followed.
    fn is_empty(&self) -> bool {
        self.followed.is_empty()
    }

    /// Takes up what a checkpoint kept.
    pub(super) fn take_up(&mut self, kept: &StagesSoFar) {
        if kept.newest.len() == self.canopies.len() && !self.is_empty() {
            self.so_far = kept.clone();
        }
    }

    /// Adds the values of all channels at `t` [s].
    pub(super) fn note(&mut self, t: f64, values: &[f64]) {
        if self.is_empty() {
            return;
        }
        let first = self.so_far.stages.is_empty();
        // A stage whose start is the newest state begins with the next one.
        while let Some(start) = self.known.get(self.so_far.known).filter(|start| first || start.t < t).cloned() {
            self.so_far.known += 1;
            self.begin(start);
            if first {
                break;
            }
        }
        let at = self.circumstances(values);
        let Stages { followed, canopies, so_far: StagesSoFar { stages, newest, .. }, .. } = self;
        newest.resize(canopies.len(), [f64::NAN; 2]);
        for ([q, area], &first) in newest.iter_mut().zip(&*canopies) {
            // Of the whole motion through the air, also where a canopy is not yet turned into it.
            let angle = value_of(values, first, ANGLE_OF_ATTACK).to_radians();
            let share = if angle.is_finite() { angle.cos().powi(2) } else { 1.0 };
            *q = value_of(values, first, DYNAMIC_PRESSURE).abs() / share;
            *area = value_of(values, first, DRAG_AREA);
        }
        let Some(stage) = stages.last_mut() else { return };
        stage.to = t;
        if first {
            stage.before.clone_from(newest);
        }
        stage.area.iter_mut().zip(newest).for_each(|(area, [_, new])| *area = *new);
        for (peak, number) in stage.peaks.iter_mut().zip(followed) {
            let value = values.get(*number).copied().filter(|value| value.is_finite());
            if let Some(value) = value.filter(|value| peak.is_none_or(|peak| *value > peak.value)) {
                *peak = Some(PeakSoFar { value, t, at });
            }
        }
    }

    /// Begins a stage at an event that has happened in the newest state, at `t` [s].
    pub(super) fn event(&mut self, t: f64, name: &str) {
        let begun = self.so_far.stages.last().is_some_and(|stage| stage.start.t < t);
        if self.is_empty() || !begun {
            return;
        }
        // An event that has a name of its own where a stage begins at a known time.
        let same = |start: &StageStart| start.t <= t * (1.0 + SAME);
        self.so_far.known += self.known.iter().skip(self.so_far.known).take_while(|start| same(start)).count();
        self.begin(StageStart { t, name: name.to_owned() });
    }

    /// Begins a stage after the newest state.
    fn begin(&mut self, start: StageStart) {
        let peaks = vec![None; self.followed.len()];
        let to = start.t;
        let (before, area) = (self.so_far.newest.clone(), vec![f64::NAN; self.canopies.len()]);
        self.so_far.stages.push(StageSoFar { start, to, peaks, before, area });
    }

    /// Speed, height, drag area and drag coefficient of the canopies and the payload; NaN where there is none.
    fn circumstances(&self, values: &[f64]) -> [f64; 4] {
        let count = self.canopies.len();
        let sum = |column: Quantity| self.canopies.iter().map(|first| value_of(values, *first, column)).sum::<f64>();
        let height = self.height.and_then(|height| values.get(height).copied()).unwrap_or(f64::NAN);
        match count {
            0 => [f64::NAN, height, f64::NAN, f64::NAN],
            1 => [sum(AXIAL_SPEED), height, sum(DRAG_AREA), sum(DRAG_COEFFICIENT)],
            _ => [sum(AXIAL_SPEED) / count as f64, height, sum(DRAG_AREA), f64::NAN],
        }
    }

    /// The stages of a run that ended at `end` [s], and its last tenth.
    pub(super) fn reports(&self, channels: &[Channel], series: &[SeriesSoFar], end: f64) -> Vec<StageReport> {
        let mut all: Vec<StageReport> = self.so_far.stages.iter().map(|stage| self.report(stage, channels)).collect();
        let late = |number: usize| series.get(number).map(|series| series.late_mean(end)).filter(|v| v.is_finite());
        let means: Vec<f64> = (0..channels.len()).map(|number| late(number).unwrap_or(f64::NAN)).collect();
        let at = Circumstances { height: None, ..Circumstances::of(self.circumstances(&means)) };
        let mean = |&number: &usize| {
            let channel = channels.get(number)?;
            Some(StagePeak { at, ..StagePeak::of(channel, late(number)?, None) })
        };
        let peaks: Vec<StagePeak> = self.followed.iter().filter_map(mean).collect();
        if !peaks.is_empty() && !self.canopies.is_empty() {
            let from = late_from(end);
            let speed = |first: &usize| series.get(channel_of(*first, AXIAL_SPEED)?);
            let steady = self.canopies.iter().filter_map(speed).all(|speed| speed.is_steady(end));
            let name = if steady { "steady" } else { "last tenth" }.to_owned();
            all.push(StageReport { name, from, to: end, peaks });
        }
        all
    }

    fn report(&self, stage: &StageSoFar, channels: &[Channel]) -> StageReport {
        let peak = |(number, peak): (&usize, &Option<PeakSoFar>)| {
            let PeakSoFar { value, t, at } = (*peak)?;
            let at = Circumstances::of(at);
            let channel = channels.get(*number)?;
            let canopy = self.canopies.iter().rposition(|first| first <= number);
            let coefficient =
                canopy.filter(|_| channel.quantity == DRAG).and_then(|canopy| stage.coefficient(canopy, value));
            Some(StagePeak { at, opening_force_coefficient: coefficient, ..StagePeak::of(channel, value, Some(t)) })
        };
        let peaks = self.followed.iter().zip(&stage.peaks).filter_map(peak).collect();
        StageReport { name: stage.start.name.clone(), from: stage.start.t, to: stage.to, peaks }
    }
}

impl Circumstances {
    fn of([speed, height, drag_area, drag_coefficient]: [f64; 4]) -> Self {
        let known = |value: f64| Some(value).filter(|value| value.is_finite());
        Circumstances {
            speed: known(speed),
            height: known(height),
            drag_area: known(drag_area),
            drag_coefficient: known(drag_coefficient),
        }
    }
}

impl StageSoFar {
    /// [-] The opening-force coefficient of a canopy with a peak drag [N]; `None` where its drag area did not grow.
    fn coefficient(&self, canopy: usize, peak: f64) -> Option<f64> {
        let (&[q, before], &area) = (self.before.get(canopy)?, self.area.get(canopy)?);
        let opens = before.is_nan() || before <= OPEN * area;
        Some(peak / (q * area)).filter(|coefficient| opens && coefficient.is_finite() && *coefficient > 0.0)
    }
}

impl StagePeak {
    fn of(channel: &Channel, value: f64, t: Option<f64>) -> Self {
        let (quantity, unit) = (channel.quantity.name.to_owned(), channel.quantity.unit.to_owned());
        StagePeak { name: channel.name.clone(), quantity, unit, value, t, ..StagePeak::default() }
    }
}

/// The channel of a column of the canopy whose first channel is given.
fn channel_of(first: usize, column: Quantity) -> Option<usize> {
    CANOPY_QUANTITIES.iter().position(|known| *known == column).map(|place| first + place)
}

/// The value of that column; NaN where there is none.
fn value_of(values: &[f64], first: usize, column: Quantity) -> f64 {
    channel_of(first, column).and_then(|channel| values.get(channel)).copied().unwrap_or(f64::NAN)
}
