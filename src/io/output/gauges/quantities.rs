//! The quantities of a run: which channels and which parts of the account they are made of, and their values.

use super::names::without_rule;
use super::places::{PROBE, Places};
use super::{Channel, Gauges, GaugesSpec};
use crate::drive::event::{Fired, Landing};
use crate::drive::observer::Energies;
use crate::model::gauge::{DRAG, PeakRule, Quantity as Column};
use crate::model::quantity::{Named, OfLanding, QuantityName, Statistic};
use crate::output::quantity::{
    ENERGIES, ENERGY, QuantityReport, QuantityReports, UnknownQuantity, column_of, energies, reported,
};
use crate::output::schedule::RowSchedule;
use crate::output::statistics::SeriesSoFar;
use serde::{Deserialize, Serialize};

/// A quantity of a run and its value.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredQuantity {
    /// its name
    pub name: String,
    /// its unit
    pub unit: &'static str,
    /// its value; `None` for `motion`, and where the run did not come to it
    pub value: Option<f64>,
    /// largest magnitude of its series; 0 where it has none, and for times
    pub largest: f64,
    /// of a peak, about what falls between two steps
    pub missed: f64,
    /// whether it is asked for, or is one of the numbers of the report where nothing is asked for
    pub wanted: bool,
    /// what it is of its series
    pub statistic: Statistic,
    /// of a value at the end, the values at equal times of the last tenth of the run; empty where there are none
    pub late: Vec<f64>,
}

impl MeasuredQuantity {
    /// Whether it is the motion of all nodes, which has no value.
    pub fn is_motion(&self) -> bool {
        self.name == "motion"
    }

    /// Whether it is a number of the landing.
    pub fn is_of_landing(&self) -> bool {
        OfLanding::ALL.iter().any(|of| of.name() == self.name)
    }

    /// Whether it is a time that only falls on steps.
    pub fn is_time(&self) -> bool {
        self.statistic == Statistic::PeakTime
    }

    /// Whether it is known at the end of the run only.
    pub fn at_end(&self) -> bool {
        matches!(self.statistic, Statistic::Last | Statistic::Mean | Statistic::Steady)
    }

    /// Those of a run for `summary.json`.
    pub fn reports(all: &[MeasuredQuantity]) -> QuantityReports {
        let valued = all.iter().filter(|quantity| quantity.value.is_some());
        let report = |quantity: &MeasuredQuantity| {
            let MeasuredQuantity { name, unit, value, .. } = quantity;
            (name.clone(), QuantityReport { value: *value, unit: (*unit).to_owned(), ..QuantityReport::default() })
        };
        valued.map(report).collect()
    }
}

/// What a quantity is made of.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Source {
    Motion,
    DisplacementEnd,
    Channel(usize),
    /// the largest of several channels
    Channels(Vec<usize>),
    /// a column of the energy account
    Energy(usize),
    Landing(OfLanding),
}

/// A quantity that was found.
#[derive(Clone, Debug)]
struct Found {
    name: QuantityName,
    unit: &'static str,
    source: Source,
    statistic: Statistic,
    wanted: bool,
}

/// What is kept of quantities from step to step; part of a checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct QuantitiesSoFar {
    /// of each column of the account, if a quantity is made of it
    account: Vec<SeriesSoFar>,
    /// the value of each quantity that was caught on the way
    caught: Vec<Option<f64>>,
}

/// The quantities of a run.
#[derive(Debug, Default)]
pub(super) struct Quantities {
    found: Vec<Found>,
    pub so_far: QuantitiesSoFar,
    /// [m]
    pub displacement_end: f64,
    landing: Option<(Fired, Landing)>,
}

impl Quantities {
    /// Those that are asked for, and those of the report. Adds gauges for what no gauge measures yet.
    pub(super) fn find(gauges: &mut Gauges, spec: &GaugesSpec<'_>, canopies: usize) -> Result<Self, UnknownQuantity> {
        let mut found = Vec::new();
        for name in spec.quantities {
            found.push(find(gauges, spec, name)?);
        }
        let alone = canopies == 1;
        let lines = gauges.channels().iter().filter_map(|of| reported(&of.name, of.quantity, alone));
        let mut reported: Vec<QuantityName> = lines.collect();
        if reported.is_empty() {
            reported.extend("motion".parse());
        }
        let default = spec.quantities.is_empty();
        // Drift, heading and place may be 0, or nothing but rounding: their errors are told where they are asked for.
        let reports = |of: &OfLanding| matches!(of, OfLanding::Time | OfLanding::Speed);
        let landing = OfLanding::ALL.into_iter().filter(|_| spec.stages.landing);
        let (told, more): (Vec<_>, Vec<_>) = landing.partition(reports);
        reported.extend(told.into_iter().filter_map(|of| of.name().parse().ok()));
        let own = std::iter::once("displacement_end").chain(more.into_iter().map(OfLanding::name));
        let own = own.filter_map(|name| name.parse().ok());
        for (name, wanted) in reported.into_iter().map(|name| (name, default)).chain(own.map(|name| (name, false))) {
            if found.iter().all(|other: &Found| other.name != name) {
                found.push(Found { wanted, ..find(gauges, spec, &name)? });
            }
        }
        let account = found.iter().any(|of| matches!(of.source, Source::Energy(_)));
        let so_far = QuantitiesSoFar {
            account: vec![SeriesSoFar::default(); if account { ENERGIES.len() } else { 0 }],
            caught: vec![None; found.len()],
        };
        Ok(Quantities { found, so_far, displacement_end: f64::NAN, landing: None })
    }

    /// Name, source and statistic of those that are asked for.
    pub(super) fn wanted(&self) -> impl Iterator<Item = (&str, &Source, Statistic)> {
        let wanted = self.found.iter().filter(|found| found.wanted);
        wanted.map(|found| (found.name.text.as_str(), &found.source, found.statistic))
    }

    pub(super) fn take_up(&mut self, kept: &QuantitiesSoFar) {
        let alike = kept.account.len() == self.so_far.account.len() && kept.caught.len() == self.so_far.caught.len();
        if alike {
            self.so_far = kept.clone();
        }
    }

    /// Keeps the landing, if an event is one. A run that continues is told of it again.
    pub(super) fn event(&mut self, event: &Fired) {
        self.landing = event.landing.map(|landing| (event.clone(), landing)).or(self.landing.take());
    }

    fn of_landing(&self, of: OfLanding) -> Option<f64> {
        let (Fired { t, place: [x, y, _], .. }, Landing { speed, drift, heading, .. }) = self.landing.as_ref()?;
        match of {
            OfLanding::Time => Some(*t),
            OfLanding::Speed => Some(*speed),
            OfLanding::Drift => Some(*drift),
            OfLanding::Heading => *heading,
            OfLanding::X => Some(*x),
            OfLanding::Y => Some(*y),
        }
    }

    /// Adds a row of the account of a run that is planned to `end` [s].
    pub(super) fn account(&mut self, t: f64, ledger: Energies, end: f64) {
        if self.so_far.account.is_empty() {
            return;
        }
        let QuantitiesSoFar { account, caught } = &mut self.so_far;
        for (number, (series, value)) in account.iter_mut().zip(energies(ledger)).enumerate() {
            catch(&self.found, caught, &Source::Energy(number), (series, t, value));
            series.note(t, value, PeakRule::LargestMagnitude, end);
        }
    }

    /// Keeps the values at times between the newest value of a series and the next one, `value` at `t` [s].
    pub(super) fn catch(&mut self, source: &Source, series: &SeriesSoFar, t: f64, value: f64) {
        catch(&self.found, &mut self.so_far.caught, source, (series, t, value));
    }

    /// The values, of the series of all channels in a run that ended at `end` [s].
    pub(super) fn measured(&self, channels: &[SeriesSoFar], end: f64) -> Vec<MeasuredQuantity> {
        let of_series = |found: &Found, caught: Option<f64>, series: &[SeriesSoFar], number: usize| {
            let series = series.get(number)?;
            series.statistic(found.statistic, end).or(caught)
        };
        let value = |(found, caught): (&Found, &Option<f64>)| match &found.source {
            Source::Motion => None,
            Source::DisplacementEnd => Some(self.displacement_end),
            Source::Channel(number) => of_series(found, *caught, channels, *number),
            Source::Channels(several) => {
                several.iter().filter_map(|number| of_series(found, *caught, channels, *number)).reduce(f64::max)
            }
            Source::Energy(number) => of_series(found, *caught, &self.so_far.account, *number),
            Source::Landing(of) => self.of_landing(*of),
        };
        let series = |source: &Source| match source {
            Source::Channel(number) => channels.get(*number),
            Source::Energy(number) => self.so_far.account.get(*number),
            Source::Motion | Source::DisplacementEnd | Source::Channels(_) | Source::Landing(_) => None,
        };
        let between = |number: &usize| channels.get(*number).map_or(0.0, |series| series.missed);
        let missed = |source: &Source| match source {
            Source::Channels(several) => several.iter().map(between).fold(0.0, f64::max),
            source => series(source).map_or(0.0, |series| series.missed),
        };
        let largest = |source: &Source| series(source).map_or(0.0, |of| of.peak.abs().max(of.min.abs()));
        let late = |source: &Source| series(source).map_or_else(Vec::new, |series| series.late_values(end));
        let measured = |of: (&Found, &Option<f64>)| MeasuredQuantity {
            name: of.0.name.text.clone(),
            unit: of.0.unit,
            value: value(of).filter(|value| value.is_finite()),
            wanted: of.0.wanted,
            largest: if of.0.statistic == Statistic::PeakTime { 0.0 } else { largest(&of.0.source) },
            missed: if of.0.statistic == Statistic::Peak { missed(&of.0.source) } else { 0.0 },
            statistic: of.0.statistic,
            late: if of.0.statistic == Statistic::Last { late(&of.0.source) } else { Vec::new() },
        };
        self.found.iter().zip(&self.so_far.caught).map(measured).collect()
    }
}

/// Keeps the values of a source at times between the newest value of its series and the next one, at `t` [s].
fn catch(found: &[Found], caught: &mut [Option<f64>], source: &Source, next: (&SeriesSoFar, f64, f64)) {
    let (series, t, value) = next;
    for (of, caught) in found.iter().zip(caught) {
        if let Statistic::At(time) = of.statistic
            && of.source == *source
            && caught.is_none()
            && time <= t
        {
            *caught = Some(series.at(time, t, value)).filter(|value| value.is_finite());
        }
    }
}

/// What a name means in this run.
fn find(gauges: &mut Gauges, spec: &GaugesSpec<'_>, name: &QuantityName) -> Result<Found, UnknownQuantity> {
    let made = |unit, source, statistic| Found { name: name.clone(), unit, source, statistic, wanted: true };
    let rows = RowSchedule::of(spec.history);
    match &name.names {
        Named::Motion => Ok(made("-", Source::Motion, Statistic::Peak)),
        Named::DisplacementEnd => Ok(made("m", Source::DisplacementEnd, Statistic::Last)),
        Named::Landing(of) if spec.stages.landing => Ok(made(of.unit(), Source::Landing(*of), Statistic::Last)),
        Named::Landing(_) => Err(unknown(gauges, spec, name, "landing without time.until".to_owned())),
        Named::Largest(of) => {
            let column = Column::of("largest", of.unit());
            gauges.add(&name.text, None, &[column], Places::Scene(*of), rows);
            Ok(made(of.unit(), Source::Channel(gauges.channels.len() - 1), Statistic::Peak))
        }
        Named::OpeningLoad => {
            let drags = gauges.channels().iter().enumerate().filter(|(_, channel)| channel.quantity == DRAG);
            let drags: Vec<usize> = drags.map(|(number, _)| number).collect();
            if drags.is_empty() {
                return Err(unknown(gauges, spec, name, "canopy".to_owned()));
            }
            Ok(made(DRAG.unit, Source::Channels(drags), Statistic::Peak))
        }
        Named::Series { gauge, column, statistic } => {
            let unit = |own| if *statistic == Statistic::PeakTime { "s" } else { own };
            if let Statistic::At(time) = statistic
                && !(0.0..=spec.end).contains(time)
            {
                return Err(unknown(gauges, spec, name, format!("time {time} s: the run ends at {} s", spec.end)));
            }
            if gauge == ENERGY
                && let Some(number) = ENERGIES.iter().position(|known| known == column)
            {
                return Ok(made(unit("J"), Source::Energy(number), *statistic));
            }
            if let Some(number) = channel(&gauges.channels, gauge, column) {
                let own = gauges.channels.get(number).map_or("", |channel| channel.quantity.unit);
                return Ok(made(unit(own), Source::Channel(number), *statistic));
            }
            let probe = spec.probes.iter().find(|probe| probe.name == *gauge);
            if let (Some(probe), Some(place)) = (probe, PROBE.iter().position(|known| known.name == column)) {
                let first = gauges.channels.len();
                gauges.add(gauge, None, &PROBE, Places::of_probe(probe), rows);
                return Ok(made(unit(PROBE[place].unit), Source::Channel(first + place), *statistic));
            }
            let known = gauges.channels().iter().any(|channel| channel.name == *gauge) || probe.is_some();
            let missing = if known { format!("column \"{column}\" of {gauge}") } else { format!("gauge \"{gauge}\"") };
            Err(unknown(gauges, spec, name, missing))
        }
    }
}

/// The channel of a gauge that a word means. The gauge of a rule of springs on a group, `springs[5] lines`, is found by
/// its group too, and under another number: a variant of a case may have fewer rules.
fn channel(channels: &[Channel], gauge: &str, column: &str) -> Option<usize> {
    let exact = channels.iter().position(|channel| channel.name == gauge);
    let first = exact.or_else(|| only_with_group(channels, without_rule(gauge)))?;
    let name = &channels.get(first)?.name;
    let own = channels.iter().skip(first).take_while(|channel| channel.name == *name);
    let columns: Vec<Column> = own.map(|channel| channel.quantity).collect();
    Some(first + column_of(&columns, column)?)
}

/// The first channel of the only gauge of a rule of springs on this group.
fn only_with_group(channels: &[Channel], group: &str) -> Option<usize> {
    let fits = |channel: &Channel| channel.name != group && without_rule(&channel.name) == group;
    let first = channels.iter().position(fits)?;
    let alone = channels.iter().all(|channel| !fits(channel) || channel.name == channels[first].name);
    alone.then_some(first)
}

fn unknown(gauges: &Gauges, spec: &GaugesSpec<'_>, name: &QuantityName, missing: String) -> UnknownQuantity {
    let mut known: Vec<String> = Vec::new();
    let mut last: Option<&str> = None;
    for channel in gauges.channels() {
        match known.last_mut().filter(|_| last == Some(&channel.name)) {
            Some(words) => words.push_str(&format!(", {}", channel.quantity.name)),
            None => known.push(format!("{}: {}", channel.name, channel.quantity.name)),
        }
        last = Some(&channel.name);
    }
    known.extend(spec.probes.iter().map(|probe| format!("{} (probe): x, y, z, vx, vy, vz", probe.name)));
    known.push(format!("{ENERGY}: {}", ENERGIES.join(", ")));
    if spec.stages.landing {
        known.push(OfLanding::ALL.map(OfLanding::name).join(", "));
    }
    UnknownQuantity { name: name.text.clone(), missing, known: format!("gauges and columns: {}", known.join("; ")) }
}
