//! Gauges: what `gauges.csv` and the peaks in `summary.json` hold.

use super::schedule::RowSchedule;
use crate::case::spec::{GaugeOf, GaugeSpec, RowEvery};
use crate::mesh::CrossingFinder;
use crate::model::abilities::SpringPlace;
use crate::model::gauge::{
    CANOPY_QUANTITIES, CROSSINGS, NodeColumns, NodeGauge, PeakRule, Quantity, ReportLine, SpringColumns, SpringGauge,
    TENSION_MAX,
};
use crate::model::observables::Observables;
use crate::model::point::Point;
use serde::{Deserialize, Serialize};

/// [-] Share of a run at its end over which a value must not change to count as steady.
const LAST_PART: f64 = 0.1;
/// [-] Relative change over that part below which it is steady.
const STEADY: f64 = 0.01;

/// A column of values: one quantity of one gauge.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// name of the gauge
    pub name: String,
    /// what it measures
    pub quantity: Quantity,
    /// [N]
    strength: Option<f64>,
}

/// What is kept of a channel from step to step; part of a checkpoint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChannelPeak {
    /// largest value
    value: f64,
    /// [s] its time
    t: f64,
    /// newest value
    last: f64,
    /// [s] time and value with which the last part of the run begins
    late: [f64; 2],
}

impl Default for ChannelPeak {
    fn default() -> Self {
        ChannelPeak { value: f64::NAN, t: f64::NAN, last: f64::NAN, late: [f64::NEG_INFINITY, f64::NAN] }
    }
}

/// The largest value of a quantity of a gauge, for `summary.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Peak {
    /// name of the gauge
    pub name: String,
    /// what it measures
    pub quantity: String,
    /// its unit
    pub unit: String,
    /// largest value; of components and speeds along an axis, that of the largest magnitude
    pub value: f64,
    /// [s] when it was reached first
    pub t: f64,
    /// value at the end
    pub last: f64,
    /// whether the value changed by less than 1 % over the last tenth of the run
    pub steady: bool,
    /// [N] strength of the springs, if the case gives one
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strength: Option<f64>,
    /// [-] strength over the largest value; null without tension
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub safety_factor: Option<f64>,
    /// its line in the report of the run
    #[serde(skip)]
    pub line: Option<ReportLine>,
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

/// Where a gauge measures, as the scene knows it.
#[derive(Debug)]
enum Places {
    Nodes(NodeGauge, Vec<u32>),
    Springs(SpringGauge, Vec<SpringPlace>),
    Cloth(Box<Cloth>),
    Canopy(usize),
}

/// Cloth whose crossings are counted.
#[derive(Debug)]
struct Cloth {
    /// `None` where cloth cannot cross
    finder: Option<CrossingFinder>,
    /// of every node, whether it is selected
    selected: Vec<bool>,
    /// \[m\] and \[m/s\] of every node
    trace: [Vec<[f64; 3]>; 2],
}

impl Cloth {
    fn new(picture: &dyn Observables, nodes: &[u32]) -> Self {
        let count = picture.reference().len();
        let mut selected = vec![false; count];
        nodes.iter().for_each(|node| selected[*node as usize] = true);
        let finder = CrossingFinder::new(picture.triangles()).map(|finder| finder.with_start(picture.reference()));
        Cloth { finder, selected, trace: [(); 2].map(|()| vec![[0.0; 3]; count]) }
    }

    /// Number of crossings with the selected nodes; NaN for positions that are not finite.
    fn crossings(&mut self, picture: &dyn Observables, at: &Point) -> f64 {
        let Some(finder) = &mut self.finder else { return 0.0 };
        let [positions, velocities] = &mut self.trace;
        picture.trace(at.state.as_ref(), positions, velocities);
        if !positions.as_flattened().iter().all(|x| x.is_finite()) {
            return f64::NAN;
        }
        let all = |nodes: &[u32]| nodes.iter().all(|node| self.selected[*node as usize]);
        let triangle = |number: u32| all(&picture.triangles()[number as usize]);
        finder.find(positions).iter().filter(|one| all(&one.edge) || triangle(one.triangle)).count() as f64
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
    peaks: Vec<ChannelPeak>,
    values: Vec<f64>,
    every_step: bool,
    /// the rows at which a canopy without any gauge is measured
    sampled: Option<RowSchedule>,
    /// [s] end of the run
    end: f64,
}

impl Gauges {
    /// The gauges of a request. Canopies are measured too: at every step if there are other gauges, else only at the
    /// rows of the history, because the steps between can then be made in blocks.
    pub(super) fn new(picture: &dyn Observables, specs: &[GaugeSpec], history: RowEvery, end: f64) -> Self {
        let canopies = picture.air().map_or(0, |air| air.canopies());
        let mut made = Gauges {
            gauges: Vec::new(),
            channels: Vec::new(),
            peaks: Vec::new(),
            values: Vec::new(),
            every_step: !specs.is_empty(),
            sampled: (specs.is_empty() && canopies > 0).then(|| RowSchedule::of(history)),
            end,
        };
        for GaugeSpec { name, of, every } in specs {
            let (columns, places, strength): (&[Quantity], _, _) = match of {
                GaugeOf::Nodes { of, nodes } => (of.columns.all(), Places::Nodes(*of, nodes.clone()), None),
                GaugeOf::Cloth { nodes } => (&[CROSSINGS], Places::Cloth(Box::new(Cloth::new(picture, nodes))), None),
                GaugeOf::Springs { of, edges, rule, strength } => {
                    let springs = picture.springs().map_or_else(Vec::new, |springs| springs.springs_on(edges, *rule));
                    (of.columns().all(), Places::Springs(*of, springs), *strength)
                }
            };
            made.add(name, strength, columns, places, RowSchedule::Steps((*every).max(1)));
        }
        for canopy in 0..canopies {
            let name = if canopies == 1 { "canopy".to_owned() } else { format!("canopy {canopy}") };
            made.add(&name, None, &CANOPY_QUANTITIES, Places::Canopy(canopy), RowSchedule::of(history));
        }
        made
    }

    fn add(&mut self, name: &str, strength: Option<f64>, columns: &[Quantity], places: Places, rows: RowSchedule) {
        let first = self.channels.len();
        for &quantity in columns {
            let strength = strength.filter(|_| quantity == TENSION_MAX);
            self.channels.push(Channel { name: name.to_owned(), quantity, strength });
        }
        let channels = first..self.channels.len();
        self.peaks.resize(self.channels.len(), ChannelPeak::default());
        self.values.resize(self.channels.len(), f64::NAN);
        self.gauges.push(Gauge { places, rows, channels, written: f64::NAN });
    }

    pub(super) fn is_empty(&self) -> bool {
        self.gauges.is_empty()
    }

    /// All channels, in the order of the rows.
    pub(super) fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// What a checkpoint keeps.
    pub(super) fn kept(&self) -> Vec<ChannelPeak> {
        self.peaks.clone()
    }

    /// Takes up what a checkpoint kept.
    pub(super) fn take_up(&mut self, kept: &[ChannelPeak]) {
        if kept.len() == self.peaks.len() {
            self.peaks.copy_from_slice(kept);
        }
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

    /// Measures at the end of a step (number 0 is the start) and adds it to the peaks where it is credible; calls
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
        for gauge in &mut self.gauges {
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
        }
        for gauge in self.gauges.iter().filter(|gauge| gauge.written != t) {
            let mut rows = gauge.channels.clone().map(|channel| GaugeRow { t, channel, value: self.values[channel] });
            rows.try_for_each(&mut write)?;
        }
        Ok(())
    }

    fn measure(&mut self, picture: &dyn Observables, at: &Point) {
        for gauge in &mut self.gauges {
            let to = &mut self.values[gauge.channels.clone()];
            match &mut gauge.places {
                Places::Canopy(canopy) => {
                    let air = picture.air().into_iter();
                    air.for_each(|air| to.copy_from_slice(&air.canopy_values(*canopy, at.state.as_ref())));
                }
                Places::Springs(of, springs) => {
                    let all = picture.springs();
                    let value = |&spring: &SpringPlace| match of {
                        SpringGauge::Tension => {
                            all.map_or(f64::NAN, |all| all.spring_tension(at.state.as_ref(), spring))
                        }
                    };
                    let values = springs.iter().map(value);
                    let (sum, most) = values.fold((0.0, f64::NEG_INFINITY), |(sum, most), t| (sum + t, t.max(most)));
                    match of.columns() {
                        SpringColumns::SumAndLargest(_) => to.copy_from_slice(&[sum, most]),
                    }
                }
                Places::Cloth(cloth) => to[0] = cloth.crossings(picture, at),
                Places::Nodes(of, nodes) => nodal(picture, *of, nodes, at, to),
            }
        }
    }

    fn note(&mut self, t: f64) {
        let known = self.peaks.iter_mut().zip(&self.channels).zip(&self.values).filter(|(_, value)| value.is_finite());
        for ((peak, channel), &value) in known {
            let more = match channel.quantity.peak {
                PeakRule::Largest => value > peak.value,
                PeakRule::LargestMagnitude => value.abs() > peak.value.abs(),
            };
            if more || peak.value.is_nan() {
                (peak.value, peak.t) = (value, t);
            }
            peak.last = value;
            if peak.late[0] < (1.0 - LAST_PART) * self.end {
                peak.late = [t, value];
            }
        }
    }

    /// The peaks so far.
    pub(super) fn peaks(&self) -> Vec<Peak> {
        let peaks = self.peaks.iter().zip(&self.channels).filter(|(peak, _)| peak.t.is_finite());
        let peak = |(peak, channel): (&ChannelPeak, &Channel)| {
            let &ChannelPeak { value, t, last, late: [from, late] } = peak;
            Peak {
                name: channel.name.clone(),
                quantity: channel.quantity.name.to_owned(),
                unit: channel.quantity.unit.to_owned(),
                value,
                t,
                last,
                steady: from >= (1.0 - LAST_PART) * self.end && (last - late).abs() <= STEADY * last.abs(),
                strength: channel.strength,
                safety_factor: channel.strength.filter(|_| value > 0.0).map(|strength| strength / value),
                line: channel.quantity.line,
            }
        };
        peaks.map(peak).collect()
    }
}

/// The values of a gauge on nodes.
fn nodal(picture: &dyn Observables, of: NodeGauge, nodes: &[u32], at: &Point, to: &mut [f64]) {
    let (mut sum, mut norms, mut most) = ([0.0; 3], 0.0, 0.0_f64);
    for &node in nodes {
        let value = picture.node_value(of.vector, at, node);
        let [x, y, z] = value;
        let norm = (x * x + y * y + z * z).sqrt();
        sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += value);
        (norms, most) = (norms + norm, most.max(norm));
    }
    let share = 1.0 / nodes.len() as f64;
    let [x, y, z] = sum;
    match of.columns {
        NodeColumns::Sum(_) => to.copy_from_slice(&[x, y, z, (x * x + y * y + z * z).sqrt(), most]),
        NodeColumns::Mean(_) => to.copy_from_slice(&[share * x, share * y, share * z]),
        NodeColumns::MeanAndLargest(_) => to.copy_from_slice(&[share * x, share * y, share * z, most]),
        NodeColumns::Sizes(_) => to.copy_from_slice(&[share * norms, most]),
    }
}
