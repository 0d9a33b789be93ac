//! The quantities of a run: which columns and statistics their names mean, and how `summary.json` has them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::drive::observer::Energies;
use crate::model::gauge::{AXIAL_SPEED, DRAG, Quantity as Column, ReportLine};
use crate::model::quantity::QuantityName;

/// Name of the gauge of the energy account.
pub(super) const ENERGY: &str = "energy";
/// Columns of an energy account.
pub const ENERGIES: [&str; 6] = ["kinetic", "elastic", "gravity", "external_work", "dissipated", "numerical"];

/// [J] The columns of an account.
pub(super) fn energies(account: Energies) -> [f64; 6] {
    let Energies { kinetic, elastic, gravity, external_work, dissipated, numerical } = account;
    [kinetic, elastic, gravity, external_work, dissipated, numerical]
}

/// Why a name names nothing in a run.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{name}\": there is no {missing} here; {known}")]
pub struct UnknownQuantity {
    /// as it was written
    pub name: String,
    /// what is not there
    pub missing: String,
    /// what is, in words
    pub known: String,
}

/// What the gauge of a column measures, in a word: `tension` of `tension_max`.
pub fn word(column: &str) -> &str {
    column.rsplit_once('_').map_or(column, |(word, _)| word)
}

/// The column of a gauge that a name means: the column itself, or that of the report, the largest or the only one of
/// those that begin with this word.
pub(super) fn column_of(columns: &[Column], name: &str) -> Option<usize> {
    if let Some(exact) = columns.iter().position(|column| column.name == name) {
        return Some(exact);
    }
    let alike: Vec<usize> =
        (0..columns.len()).filter(|i| columns.get(*i).is_some_and(|c| word(c.name) == name)).collect();
    let with = |of: &dyn Fn(&Column) -> bool| alike.iter().copied().find(|i| columns.get(*i).is_some_and(of));
    with(&Column::is_reported)
        .or_else(|| with(&|column| column.name.ends_with("_max")))
        .or(alike.first().copied().filter(|_| alike.len() == 1))
}

/// The name of the number that a line of the report shows; `alone` says that the scene has one canopy only.
pub fn reported(gauge: &str, column: Column, alone: bool) -> Option<QuantityName> {
    let (short, statistic) = match column.line? {
        ReportLine::Drag if alone => return "opening_load".parse().ok(),
        ReportLine::Drag => (DRAG.name, "peak"),
        ReportLine::Descent => (AXIAL_SPEED.name, "last"),
        ReportLine::Ratio { .. } => (column.name, "last"),
        ReportLine::Peak(_) => (word(column.name), "peak"),
        ReportLine::Told(_) => return None,
    };
    format!("{gauge}.{short}.{statistic}").parse().ok()
}

/// A quantity of a run, as `summary.json` has it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct QuantityReport {
    /// its value; null where it has none, as `motion`, or was not measured
    pub value: Option<f64>,
    /// its unit
    pub unit: String,
    /// estimate of its error by the steps, in its unit; of `motion`, a share of the motion. Not given unless asked for
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
    /// how the error is known, or why it is not
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub error_by: String,
    /// the value that three runs extrapolate to, where they show the method's order
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub extrapolated: Option<f64>,
}

/// The quantities of a run by name.
pub type QuantityReports = BTreeMap<String, QuantityReport>;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::gauge::{CANOPY_QUANTITIES, GaugeQuantity};

    #[test]
    fn a_word_means_the_column_of_the_report_or_the_largest() {
        let name = |of: GaugeQuantity, word| {
            let columns = of.columns();
            column_of(columns, word).map(|i| columns[i].name)
        };
        assert_eq!(name(GaugeQuantity::Tension, "tension"), Some("tension_max"));
        assert_eq!(name(GaugeQuantity::Reaction, "reaction"), Some("reaction_total"));
        assert_eq!(name(GaugeQuantity::Speed, "speed"), Some("speed_max"));
        assert_eq!(name(GaugeQuantity::Position, "position"), None, "three of the same rank");
        assert_eq!(name(GaugeQuantity::Position, "position_z"), Some("position_z"));
        assert_eq!(name(GaugeQuantity::Stress, "stress"), Some("stress_max"));
        assert_eq!(name(GaugeQuantity::Wrinkling, "wrinkled_share"), Some("wrinkled_share"));
        let drag = column_of(&CANOPY_QUANTITIES, "drag").map(|i| CANOPY_QUANTITIES[i].name);
        assert_eq!(drag, Some("drag"));
    }
}
