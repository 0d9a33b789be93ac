//! The columns of a sweep.

use super::plan::{SweepPlan, plain};
use super::run::SweepRow;
use super::words;
use crate::error::StudyError;
use crate::output::gauges::Peak;
use crate::row::RowStatus;

/// A column of numbers.
pub(super) struct Quantity {
    /// name of the column
    pub name: String,
    /// its unit; empty for a count
    pub unit: String,
    of: Source,
}

/// Where a number comes from.
enum Source {
    Number(fn(&SweepRow) -> Option<f64>),
    Count(fn(&SweepRow) -> u64),
    /// of the peak of a gauge, by its name and quantity
    Gauge(String, String, fn(&Peak) -> f64),
    /// whether it was steady at the end
    Steady(String, String),
    /// a quantity that is asked for, by its name
    Asked(String),
}

/// A number of a gauge.
struct OfGauge {
    /// the end of the column's name
    end: &'static str,
    /// the same in words
    words: &'static str,
    /// its unit if not that of the quantity
    unit: Option<&'static str>,
    of: fn(&Peak) -> f64,
}
const OF_GAUGE: [OfGauge; 3] = [
    OfGauge { end: "peak", words: "peak", unit: None, of: |peak| peak.value },
    OfGauge { end: "peak_time", words: "time of the peak", unit: Some("s"), of: |peak| peak.t },
    OfGauge { end: "last", words: "at the end", unit: None, of: |peak| peak.last },
];

impl Quantity {
    /// The number of a run; none where it was not measured.
    pub(super) fn of(&self, row: &SweepRow) -> Option<f64> {
        match &self.of {
            Source::Number(of) => of(row),
            Source::Count(of) => made(row).then(|| of(row) as f64),
            Source::Gauge(name, quantity, of) => peak(row, name, quantity).map(of),
            Source::Asked(name) => row.result.quantities.get(name).and_then(|quantity| quantity.value),
            Source::Steady(name, quantity) => peak(row, name, quantity).map(|peak| f64::from(u8::from(peak.steady))),
        }
        .filter(|x| x.is_finite())
    }

    /// As the table has it.
    fn cell(&self, row: &SweepRow) -> String {
        match &self.of {
            Source::Count(of) => {
                if made(row) {
                    of(row).to_string()
                } else {
                    String::new()
                }
            }
            Source::Steady(name, quantity) => {
                peak(row, name, quantity).map(|p| p.steady.to_string()).unwrap_or_default()
            }
            _ => self.of(row).map(|x| format!("{x:?}")).unwrap_or_default(),
        }
    }

    /// What it is, in words.
    pub(super) fn words(&self) -> String {
        match &self.of {
            Source::Gauge(name, quantity, _) => {
                let end = OF_GAUGE.iter().find(|of| self.name.ends_with(&format!(".{}", of.end)));
                words::of_gauge(name, quantity, end.map_or("", |of| of.words))
            }
            Source::Steady(name, quantity) => words::of_gauge(name, quantity, "whether it is steady"),
            Source::Asked(name) => words::of_quantity(name),
            Source::Number(_) | Source::Count(_) => match self.name.as_str() {
                "t_end" => "end of the run".to_owned(),
                "cpu_seconds" => "processor time".to_owned(),
                name => words::of_quantity(name).replace('_', " "),
            },
        }
    }

    /// Words and unit for an axis.
    pub(super) fn label(&self) -> String {
        let unit = if self.unit.is_empty() { "-" } else { &self.unit };
        format!("{} [{}]", self.words(), words::shown(unit))
    }
}

/// Whether a run was begun and has a cost.
fn made(row: &SweepRow) -> bool {
    !matches!(row.result.status, RowStatus::NotRun | RowStatus::Refused)
}

fn peak<'r>(row: &'r SweepRow, name: &str, quantity: &str) -> Option<&'r Peak> {
    row.result.peaks.iter().find(|peak| peak.name == name && peak.quantity == quantity)
}

/// All columns of numbers, those of the gauges and the quantities that are asked for last.
pub(super) fn quantities(rows: &[SweepRow]) -> Vec<Quantity> {
    let number = |name: &str, unit: &str, of| Quantity { name: name.into(), unit: unit.into(), of: Source::Number(of) };
    let count = |name: &str, of| Quantity { name: name.into(), unit: String::new(), of: Source::Count(of) };
    let mut all = vec![
        number("t_end", "s", |row| made(row).then_some(row.result.t_end)),
        number("displacement_end", "m", |row| row.result.displacement_end),
        number("max_speed", "m/s", |row| row.result.max_speed),
        number("max_strain", "-", |row| row.result.max_strain),
        number("energy_error", "-", |row| row.result.energy_error),
        number("cpu_seconds", "s", |row| row.result.cpu_seconds),
        count("steps", |row| row.result.steps),
        count("rejected_steps", |row| row.result.rejected_steps),
        count("force_evaluations", |row| row.result.counters.force_evaluations),
        count("tangent_assemblies", |row| row.result.counters.tangent_assemblies),
        count("factorizations", |row| row.result.counters.factorizations),
        count("linear_solves", |row| row.result.counters.linear_solves),
        count("newton_iterations", |row| row.result.counters.newton_iterations),
    ];
    if rows.iter().any(|row| row.result.mass_scaling.is_some()) {
        all.push(number("added_mass", "kg", |row| row.result.mass_scaling.map(|added| added.added)));
        all.push(number("added_mass_share", "-", |row| row.result.mass_scaling.map(|added| added.share)));
    }
    let mut known: Vec<&Peak> = Vec::new();
    for peak in rows.iter().flat_map(|row| &row.result.peaks) {
        if known.iter().all(|other| other.name != peak.name || other.quantity != peak.quantity) {
            known.push(peak);
        }
    }
    for Peak { name, quantity, unit, .. } in known {
        let column = |end: &str, unit: &str, of| Quantity {
            name: format!("{name}.{quantity}.{end}"),
            unit: unit.to_owned(),
            of,
        };
        all.extend(OF_GAUGE.map(|OfGauge { end, unit: other, of, .. }| {
            column(end, other.unwrap_or(unit), Source::Gauge(name.clone(), quantity.clone(), of))
        }));
        all.push(column("is_steady", "", Source::Steady(name.clone(), quantity.clone())));
    }
    // A quantity may be a column already.
    for (name, quantity) in rows.iter().flat_map(|row| &row.result.quantities) {
        if all.iter().all(|other| other.name != *name) {
            let of = Source::Asked(name.clone());
            all.push(Quantity { name: name.clone(), unit: quantity.unit.clone(), of });
        }
    }
    all
}

/// The column with a name that `option` asks for.
///
/// # Errors
/// A name that is no column of numbers, with those that are.
pub(super) fn named<'q>(all: &'q [Quantity], option: &str, name: &str) -> Result<&'q Quantity, StudyError> {
    all.iter().find(|quantity| quantity.name == name).ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|quantity| quantity.name.as_str()).collect();
        StudyError::Usage(format!("{option} {name}: there is no such column; there are {}", names.join(", ")))
    })
}

/// Names of all columns of `sweep.csv`.
pub(super) fn header(plan: &SweepPlan, quantities: &[Quantity]) -> Vec<String> {
    let keys = plan.vary.iter().map(|vary| vary.key.clone());
    let numbers = quantities.iter().map(|quantity| quantity.name.clone());
    ["run".to_owned()]
        .into_iter()
        .chain(keys)
        .chain(["status".to_owned()])
        .chain(numbers)
        .chain(["note".to_owned()])
        .collect()
}

/// A row of `sweep.csv`.
pub(super) fn cells(plan: &SweepPlan, quantities: &[Quantity], row: &SweepRow) -> Vec<String> {
    let values = plan.vary.iter().map(|vary| row.job.values.get(&vary.key).map(plain).unwrap_or_default());
    let numbers = quantities.iter().map(|quantity| quantity.cell(row));
    let ends = (row.job.run.to_string(), row.result.status.word().to_owned(), row.result.note.clone());
    [ends.0].into_iter().chain(values).chain([ends.1]).chain(numbers).chain([ends.2]).collect()
}
