//! Gauges: what `gauges.csv`, the peaks and the quantities in `summary.json` hold.

pub mod derivatives;
pub mod names;
mod place_seeds;
mod places;
mod present;
mod quantities;
pub mod seeds;

use super::quantity::UnknownQuantity;
use super::schedule::RowSchedule;
use super::stages::{StagePlaces, StageReport, Stages, StagesSoFar};
use super::statistics::SeriesSoFar;
use crate::case::spec::{GaugeOf, GaugeSpec, OutputSpec, ProbeSpec, RowEvery, StagesSpec};
use crate::drive::event::Fired;
use crate::drive::max_displacement::Displacement;
use crate::drive::observer::{AcceptedStep, Energies};
use crate::model::gauge::{
    CANOPY_QUANTITIES, GAS_QUANTITIES, NodeGauge, Quantity, ReportLine, STRESS_MAX, TENSION_MAX,
};
use crate::model::observables::Observables;
use crate::model::point::Point;
use crate::model::quantity::QuantityName;
use places::Places;
pub use present::ChannelName;
pub use quantities::MeasuredQuantity;
use quantities::Quantities;
use serde::{Deserialize, Serialize};

/// A column of values: one quantity of one gauge.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// name of the gauge
    pub name: String,
    /// what it measures
    pub quantity: Quantity,
    /// \[N\] of springs, \[Pa\] of membranes
    strength: Option<f64>,
}

/// What is kept of the gauges from step to step; part of a checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GaugesSoFar {
    channels: Vec<SeriesSoFar>,
    quantities: quantities::QuantitiesSoFar,
    stages: StagesSoFar,
    /// [s] time of the newest values
    newest: f64,
}

/// The largest value of a quantity of a gauge, for `summary.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Peak {
    /// name of the gauge
    pub name: String,
    /// its name for people, where it is another one: the group of a rule of springs
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub label: String,
    /// what it measures
    pub quantity: String,
    /// its unit
    pub unit: String,
    /// largest value; of components and speeds along an axis, that of the largest magnitude
    pub value: f64,
    /// estimate of the error of `value` by the steps; not given unless asked for
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
    /// about what falls between two steps
    #[serde(skip)]
    pub missed: f64,
    /// [s] when it was reached first
    pub t: f64,
    /// value at the end
    pub last: f64,
    /// estimate of the error of `last`, where it is a number of the report
    #[serde(skip)]
    pub last_error: Option<f64>,
    /// whether the value changed by less than 1 % over the last tenth of the run
    pub steady: bool,
    /// strength of springs [N], or of membranes over their thickness [Pa], if the case gives one
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strength: Option<f64>,
    /// [-] strength over the largest value; null without tension
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub safety_factor: Option<f64>,
    /// its line in the report of the run
    #[serde(skip)]
    pub line: Option<ReportLine>,
}

impl Peak {
    /// Its name for people.
    pub fn shown(&self) -> &str {
        if self.label.is_empty() { &self.name } else { &self.label }
    }
}

/// A value of a channel, to be written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaugeRow {
    /// [s] time
    pub t: f64,
    /// number of the channel
    pub channel: usize,
    /// the value
    pub value: f64,
}

/// What is to be measured.
#[derive(Clone, Copy, Debug)]
pub struct GaugesSpec<'a> {
    /// gauges of the case
    pub gauges: &'a [GaugeSpec],
    /// its probes
    pub probes: &'a [ProbeSpec],
    /// quantities that are asked for
    pub quantities: &'a [QuantityName],
    /// the stages of the run
    pub stages: &'a StagesSpec,
    /// interval of the rows of canopies
    pub history: RowEvery,
    /// [s] planned end of the run
    pub end: f64,
}

impl<'a> GaugesSpec<'a> {
    /// The gauges and quantities of a case in a run to `end` [s].
    pub fn of(output: &'a OutputSpec, end: f64) -> Self {
        let OutputSpec { gauges, probes, quantities, stages, history_every, .. } = output;
        GaugesSpec { gauges, probes, quantities, stages, history: *history_every, end }
    }
}

#[derive(Debug)]
struct Gauge {
    places: Places,
    rows: RowSchedule,
    /// its first channel, and how many it has
    channels: std::ops::Range<usize>,
    /// [s] time of its newest row
    written: f64,
}

/// The gauges of a run.
#[derive(Debug)]
pub(super) struct Gauges {
    gauges: Vec<Gauge>,
    channels: Vec<Channel>,
    series: Vec<SeriesSoFar>,
    values: Vec<f64>,
    /// gauges and channels that are shown; the others are there for quantities
    shown: [usize; 2],
    quantities: Quantities,
    stages: Stages,
    every_step: bool,
    /// the rows at which a canopy or a gas without any gauge is measured
    sampled: Option<RowSchedule>,
    /// [s] planned end of the run
    end: f64,
    /// [s] time of the newest values
    newest: f64,
}

impl Gauges {
    /// The gauges of a request. Canopies and gases without a gauge are measured too: at every step if there are other
    /// gauges, else only at the rows of the history, because the steps between can then be made in blocks.
    ///
    /// # Errors
    /// A quantity that is not there.
    pub(super) fn new(picture: &dyn Observables, spec: &GaugesSpec<'_>) -> Result<Self, UnknownQuantity> {
        let canopies = picture.air().map_or(0, |air| air.canopies());
        let mut made = Gauges {
            gauges: Vec::new(),
            channels: Vec::new(),
            series: Vec::new(),
            values: Vec::new(),
            shown: [0; 2],
            quantities: Quantities::default(),
            stages: Stages::default(),
            every_step: false,
            sampled: None,
            end: spec.end,
            newest: 0.0,
        };
        for GaugeSpec { name, of, every } in spec.gauges {
            let (columns, places, strength) = Places::of(picture, of);
            made.add(name, strength, columns, places, RowSchedule::Steps((*every).max(1)));
        }
        let mut of_canopies = Vec::with_capacity(canopies);
        for canopy in 0..canopies {
            of_canopies.push(made.channels.len());
            let name = if canopies == 1 { "canopy".to_owned() } else { format!("canopy {canopy}") };
            made.add(&name, None, &CANOPY_QUANTITIES, Places::Canopy(canopy), RowSchedule::of(spec.history));
        }
        let gases = picture.air().map_or(0, |air| air.gases());
        let measured = |gas: usize| spec.gauges.iter().any(|gauge| gauge.of == GaugeOf::Gas { gas });
        for gas in (0..gases).filter(|gas| !measured(*gas)) {
            let name = if gases == 1 { "gas".to_owned() } else { format!("gas {gas}") };
            made.add(&name, None, &GAS_QUANTITIES, Places::Gas(gas), RowSchedule::of(spec.history));
        }
        made.shown = [made.gauges.len(), made.channels.len()];
        made.quantities = Quantities::find(&mut made, spec, canopies)?;
        made.every_step = !spec.gauges.is_empty() || made.gauges.len() > made.shown[0];
        let height = made.height(&spec.stages.payload, canopies);
        let places = StagePlaces { canopies: of_canopies, height };
        made.stages = Stages::new(spec.stages, made.channels(), places);
        made.sampled = (!made.every_step && canopies + gases > 0).then(|| RowSchedule::of(spec.history));
        Ok(made)
    }

    fn add(&mut self, name: &str, strength: Option<f64>, columns: &[Quantity], places: Places, rows: RowSchedule) {
        let first = self.channels.len();
        for &quantity in columns {
            let strength = strength.filter(|_| [TENSION_MAX, STRESS_MAX].contains(&quantity));
            self.channels.push(Channel { name: name.to_owned(), quantity, strength });
        }
        let channels = first..self.channels.len();
        self.series.resize(self.channels.len(), SeriesSoFar::default());
        self.values.resize(self.channels.len(), f64::NAN);
        self.gauges.push(Gauge { places, rows, channels, written: f64::NAN });
    }

    /// Adds a gauge of the payload's position, and returns the channel of its height.
    fn height(&mut self, payload: &[u32], canopies: usize) -> Option<usize> {
        if payload.is_empty() || canopies == 0 {
            return None;
        }
        let (of, first) = (NodeGauge::POSITION, self.channels.len());
        self.add("payload", None, of.columns.all(), Places::Nodes(of, payload.to_vec()), RowSchedule::Steps(1));
        Some(first + 2)
    }

    /// Takes up an event in the state that was measured last: a stage may begin at it, or the run end with it.
    pub(super) fn event(&mut self, event: &Fired) {
        if let Some(stage) = &event.stage {
            self.stages.event(event.t, stage);
        }
        self.quantities.event(event);
    }

    /// Whether no step has to be measured.
    pub(super) fn is_empty(&self) -> bool {
        self.gauges.is_empty()
    }

    /// All channels that are shown, in the order of the rows.
    pub(super) fn channels(&self) -> &[Channel] {
        &self.channels[..self.shown[1]]
    }

    /// What a checkpoint keeps.
    pub(super) fn kept(&self) -> GaugesSoFar {
        let (quantities, stages) = (self.quantities.so_far.clone(), self.stages.so_far.clone());
        GaugesSoFar { channels: self.series.clone(), quantities, stages, newest: self.newest }
    }

    /// Takes up what a checkpoint kept.
    pub(super) fn take_up(&mut self, kept: &GaugesSoFar) {
        if kept.channels.len() == self.series.len() {
            self.series.clone_from_slice(&kept.channels);
        }
        self.newest = kept.newest;
        self.quantities.take_up(&kept.quantities);
        self.stages.take_up(&kept.stages);
    }

    /// Skips the rows up to `t` [s].
    pub(super) fn skip(&mut self, t: f64) {
        self.gauges.iter_mut().map(|gauge| &mut gauge.rows).chain(&mut self.sampled).for_each(|rows| rows.skip(t));
    }

    /// Whether the state at the end of step number `step`, at `t` [s], is measured; `from` [s] is its start.
    pub(super) fn wants(&self, step: u64, [from, t]: [f64; 2]) -> bool {
        self.every_step
            || self.sampled.is_some_and(|mut rows| {
                rows.skip(from);
                rows.due(step, t)
            })
    }

    /// Adds the account at the start of the run.
    pub(super) fn account(&mut self, t: f64, ledger: Energies) {
        self.quantities.account(t, ledger, self.end);
    }

    /// Adds an accepted step to the account, and measures its end if it is known; calls `write` for the rows that are
    /// due.
    pub(super) fn accepted<E>(
        &mut self,
        picture: &dyn Observables,
        step: AcceptedStep<'_>,
        write: impl FnMut(GaugeRow) -> Result<(), E>,
    ) -> Result<(), E> {
        if step.credible {
            self.account(step.t, step.ledger);
        }
        match step.end.filter(|_| !self.is_empty()) {
            Some(end) => self.step(picture, step.step, end, step.credible, write),
            None => Ok(()),
        }
    }

    /// Measures at the end of a step (number 0 is the start) and adds it to the series where it is credible; calls
    /// `write` for the rows that are due.
    pub(super) fn step<E>(
        &mut self,
        picture: &dyn Observables,
        step: u64,
        at: &Point,
        credible: bool,
        mut write: impl FnMut(GaugeRow) -> Result<(), E>,
    ) -> Result<(), E> {
        let t = at.state.t;
        if step > 0 && !self.every_step && !self.sampled.as_mut().is_some_and(|rows| rows.due(step, t)) {
            return Ok(());
        }
        self.measure(picture, at);
        if credible {
            self.note(t);
        }
        for gauge in self.gauges.iter_mut().take(self.shown[0]) {
            if step == 0 || gauge.rows.due(step, t) {
                gauge.written = t;
                let mut rows =
                    gauge.channels.clone().map(|channel| GaugeRow { t, channel, value: self.values[channel] });
                rows.try_for_each(&mut write)?;
            }
        }
        Ok(())
    }

    /// Measures the last state of a run and calls `write` for gauges without a row there.
    pub(super) fn last<E>(
        &mut self,
        picture: &dyn Observables,
        at: &Point,
        credible: bool,
        mut write: impl FnMut(GaugeRow) -> Result<(), E>,
    ) -> Result<(), E> {
        let t = at.state.t;
        self.measure(picture, at);
        if credible {
            self.note(t);
            self.quantities.displacement_end = Displacement::of(picture, at.state.as_ref()).distance;
        }
        for gauge in self.gauges.iter().take(self.shown[0]).filter(|gauge| gauge.written != t) {
            let mut rows = gauge.channels.clone().map(|channel| GaugeRow { t, channel, value: self.values[channel] });
            rows.try_for_each(&mut write)?;
        }
        Ok(())
    }

    fn measure(&mut self, picture: &dyn Observables, at: &Point) {
        for gauge in &mut self.gauges {
            gauge.places.measure(picture, at, &mut self.values[gauge.channels.clone()]);
        }
    }

    fn note(&mut self, t: f64) {
        self.newest = t;
        for (number, ((series, channel), &value)) in
            self.series.iter_mut().zip(&self.channels).zip(&self.values).enumerate()
        {
            self.quantities.catch(&quantities::Source::Channel(number), series, t, value);
            series.note(t, value, channel.quantity.peak, self.end);
        }
        self.stages.note(t, &self.values);
    }

    /// The peaks so far.
    pub(super) fn peaks(&self) -> Vec<Peak> {
        let peaks = self.series.iter().zip(self.channels()).filter(|(series, _)| series.peak_time.is_finite());
        let labels = names::for_people(self.channels().iter().map(|channel| channel.name.as_str()));
        let label = |name: &str| labels.get(name).filter(|label| **label != name).map_or("", |label| label).to_owned();
        let peak = |(series, channel): (&SeriesSoFar, &Channel)| {
            let &SeriesSoFar { peak, peak_time, last, .. } = series;
            Peak {
                name: channel.name.clone(),
                label: label(&channel.name),
                quantity: channel.quantity.name.to_owned(),
                unit: channel.quantity.unit.to_owned(),
                value: peak,
                error: None,
                missed: series.missed,
                t: peak_time,
                last,
                last_error: None,
                steady: series.is_steady(self.newest),
                strength: channel.strength,
                safety_factor: channel.strength.filter(|_| peak > 0.0).map(|strength| strength / peak),
                line: channel.quantity.line,
            }
        };
        peaks.map(peak).collect()
    }

    /// The stages so far.
    pub(super) fn stages(&self) -> Vec<StageReport> {
        self.stages.reports(self.channels(), &self.series, self.newest)
    }

    /// The quantities so far.
    pub(super) fn quantities(&self) -> Vec<MeasuredQuantity> {
        self.quantities.measured(&self.series, self.newest)
    }
}
