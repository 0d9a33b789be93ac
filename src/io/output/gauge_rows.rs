//! The values of some columns of gauges at every step of a run, in memory.

use super::gauges::{Channel, Gauges, GaugesSpec};
use super::quantity::{UnknownQuantity, column_of};
use crate::case::spec::{GaugeSpec, OutputSpec, RowEvery};
use crate::drive::observer::{AcceptedStep, Energies, ObserveError, Observer, Point, UpcomingStep, Wants};
use crate::model::gauge::Quantity;
use crate::model::observables::Observables;

/// A column of a gauge, by their names: `riser` and `tension`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ColumnName {
    /// the gauge; `canopy` of a scene with one canopy
    pub gauge: String,
    /// the column, or its first word where only one begins so
    pub column: String,
}

/// The observer that keeps columns of gauges at the start and at every step.
pub struct GaugeRows<'a> {
    picture: &'a dyn Observables,
    gauges: Gauges,
    wanted: Vec<usize>,
    /// [s] times of the rows
    pub t: Vec<f64>,
    /// the values of every column, (columns, rows)
    pub values: Vec<Vec<f64>>,
}

impl<'a> GaugeRows<'a> {
    /// Columns of a run to `end` [s].
    ///
    /// # Errors
    /// A quantity of the case, a gauge or a column that is not there.
    pub fn new(
        picture: &'a dyn Observables,
        output: &OutputSpec,
        end: f64,
        columns: &[ColumnName],
    ) -> Result<Self, UnknownQuantity> {
        let every_step = |gauge: &GaugeSpec| GaugeSpec { every: 1, ..gauge.clone() };
        let gauges = output.gauges.iter().map(every_step).collect();
        let output = OutputSpec { gauges, history_every: RowEvery::Steps(1), ..output.clone() };
        let gauges = Gauges::new(picture, &GaugesSpec::of(&output, end))?;
        let wanted: Vec<usize> =
            columns.iter().map(|column| find(gauges.channels(), column)).collect::<Result<_, _>>()?;
        let values = vec![Vec::new(); wanted.len()];
        Ok(GaugeRows { picture, gauges, wanted, t: Vec::new(), values })
    }

    /// What each column measures.
    pub fn quantities(&self) -> Vec<Quantity> {
        self.wanted.iter().filter_map(|at| Some(self.gauges.channels().get(*at)?.quantity)).collect()
    }
}

/// The channel of a column.
fn find(channels: &[Channel], wanted: &ColumnName) -> Result<usize, UnknownQuantity> {
    let ColumnName { gauge, column } = wanted;
    let unknown = |missing: &str, known: Vec<&str>| UnknownQuantity {
        name: format!("{gauge}.{column}"),
        missing: missing.to_owned(),
        known: format!("there are {}", known.join(", ")),
    };
    let of: Vec<usize> = (0..channels.len()).filter(|i| channels.get(*i).is_some_and(|c| c.name == *gauge)).collect();
    if of.is_empty() {
        let mut names: Vec<&str> = channels.iter().map(|channel| channel.name.as_str()).collect();
        names.dedup();
        return Err(unknown("gauge of this name", names));
    }
    let columns: Vec<Quantity> = of.iter().filter_map(|i| Some(channels.get(*i)?.quantity)).collect();
    let at = column_of(&columns, column).and_then(|at| of.get(at).copied());
    at.ok_or_else(|| unknown("column of this name", columns.iter().map(|quantity| quantity.name).collect()))
}

impl Observer for GaugeRows<'_> {
    fn started(&mut self, at: &Point, _ledger: Energies) -> Result<(), ObserveError> {
        let Self { picture, gauges, wanted, t, values } = self;
        t.push(at.state.t);
        gauges.step(*picture, 0, at, true, |row| keep(wanted, values, row.channel, row.value))
    }

    fn wants(&self, _step: UpcomingStep) -> Wants {
        Wants::end_if(true)
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        let Self { picture, gauges, wanted, t, values } = self;
        t.push(step.t);
        gauges.accepted(*picture, step, |row| keep(wanted, values, row.channel, row.value))
    }
}

/// Adds a value to the columns that are its channel's.
fn keep(wanted: &[usize], values: &mut [Vec<f64>], channel: usize, value: f64) -> Result<(), ObserveError> {
    let columns = wanted.iter().zip(values).filter(|(at, _)| **at == channel);
    columns.for_each(|(_, column)| column.push(value));
    Ok(())
}
