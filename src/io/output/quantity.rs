//! Quantities of interest: the numbers that a run reports, and the accuracy of which is asked for.
//!
//! A quantity has one name in the terminal, in `summary.json` and in studies:
//! ```text
//! GAUGE.COLUMN.STATISTIC     riser.tension.peak, payload.speed.last, canopy.drag.mean
//! GAUGE.COLUMN@TIME          tip.z@0.5                                            at 0.5 s
//! opening_load               canopy.drag.peak, of the only canopy or the one with the largest
//! displacement_end           [m] largest displacement of a node at the end
//! max_displacement, max_speed, max_strain, max_stress                            the largest of the run
//! energy.kinetic.STATISTIC   [J] and elastic, gravity, external_work, dissipated, numerical
//! motion                     the motion of all nodes in all frames; it has an error and no value
//! ```
//! GAUGE is a gauge of the case, a canopy, or a probe; COLUMN one of `gauges.csv` or of `probes.csv`, or what the gauge
//! measures (`tension` for `tension_max`). Between two steps a value is interpolated linearly.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::statistics::SeriesSoFar;
use crate::drive::observer::Energies;
use crate::model::gauge::{AXIAL_SPEED, DRAG, Quantity as Column, ReportLine};

/// A number made of a series of values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Statistic {
    /// the largest value; of components and speeds along an axis, that of the largest magnitude
    Peak,
    /// [s] when it was reached first
    PeakTime,
    /// the smallest value
    Min,
    /// the value at the end
    Last,
    /// mean over the time of the run
    Mean,
    /// mean over the last tenth of the run
    Steady,
    /// the value at this time [s]
    At(f64),
}

impl Statistic {
    const WORDS: [(&'static str, Statistic); 6] = [
        ("peak", Statistic::Peak),
        ("peak_time", Statistic::PeakTime),
        ("min", Statistic::Min),
        ("last", Statistic::Last),
        ("mean", Statistic::Mean),
        ("steady", Statistic::Steady),
    ];

    /// Of a series of a run to `end` [s]; `None` for [`Statistic::At`], which has to be caught on the way.
    pub(super) fn of(self, series: &SeriesSoFar, end: f64) -> Option<f64> {
        Some(match self {
            Statistic::Peak => series.peak,
            Statistic::PeakTime => series.peak_time,
            Statistic::Min => series.min,
            Statistic::Last => series.last,
            Statistic::Mean => series.mean(),
            Statistic::Steady => series.late_mean(end),
            Statistic::At(_) => return None,
        })
    }
}

/// The name of a quantity, read.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantityName {
    /// as it was written
    pub text: String,
    /// what it names
    pub(super) names: Named,
}

/// What a name names.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Named {
    Motion,
    DisplacementEnd,
    OpeningLoad,
    Largest(OfScene),
    Series { gauge: String, column: String, statistic: Statistic },
}

/// A series of the whole scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum OfScene {
    Displacement,
    Speed,
    Strain,
    Stress,
}

impl OfScene {
    const ALL: [(&'static str, OfScene); 4] = [
        ("max_displacement", OfScene::Displacement),
        ("max_speed", OfScene::Speed),
        ("max_strain", OfScene::Strain),
        ("max_stress", OfScene::Stress),
    ];

    /// Its unit.
    pub(super) fn unit(self) -> &'static str {
        match self {
            OfScene::Displacement => "m",
            OfScene::Speed => "m/s",
            OfScene::Strain => "-",
            OfScene::Stress => "Pa",
        }
    }
}

/// Name of the gauge of the energy account.
pub(super) const ENERGY: &str = "energy";
/// Columns of the energy account, in the order of [`energies`].
pub(super) const ENERGIES: [&str; 6] = ["kinetic", "elastic", "gravity", "external_work", "dissipated", "numerical"];

/// [J] The columns of an account.
pub(super) fn energies(account: Energies) -> [f64; 6] {
    let Energies { kinetic, elastic, gravity, external_work, dissipated, numerical } = account;
    [kinetic, elastic, gravity, external_work, dissipated, numerical]
}

/// Why a name names nothing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum QuantityError {
    /// It has no statistic.
    #[error(
        "\"{name}\" is no quantity: expected GAUGE.COLUMN.STATISTIC with peak, peak_time, min, last, mean or steady, \
         GAUGE.COLUMN@TIME, or one of opening_load, displacement_end, max_displacement, max_speed, max_strain, max_stress, \
         motion"
    )]
    Form {
        /// as it was written
        name: String,
    },
    /// The case has no such gauge or column.
    #[error("\"{name}\": there is no {missing} here; {known}")]
    Unknown {
        /// as it was written
        name: String,
        /// what is not there
        missing: String,
        /// what is, in words
        known: String,
    },
}

impl FromStr for QuantityName {
    type Err = QuantityError;

    fn from_str(text: &str) -> Result<Self, QuantityError> {
        let text = text.trim();
        let wrong = || QuantityError::Form { name: text.to_owned() };
        let of_scene = OfScene::ALL.iter().find(|(word, _)| *word == text).map(|(_, of)| Named::Largest(*of));
        let names = match (text, of_scene) {
            ("motion", _) => Named::Motion,
            ("displacement_end", _) => Named::DisplacementEnd,
            ("opening_load", _) => Named::OpeningLoad,
            (_, Some(of)) => of,
            _ => {
                let (series, statistic) = match text.rsplit_once('@') {
                    Some((series, time)) => {
                        let time = time.trim().trim_end_matches('s').trim_end().parse().map_err(|_| wrong())?;
                        (series, Statistic::At(time))
                    }
                    None => {
                        let (series, word) = text.rsplit_once('.').ok_or_else(wrong)?;
                        let known = Statistic::WORDS.iter().find(|(known, _)| *known == word);
                        (series, known.ok_or_else(wrong)?.1)
                    }
                };
                let (gauge, column) = series.rsplit_once('.').ok_or_else(wrong)?;
                Named::Series { gauge: gauge.to_owned(), column: column.to_owned(), statistic }
            }
        };
        Ok(QuantityName { text: text.to_owned(), names })
    }
}

impl fmt::Display for QuantityName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl QuantityName {
    /// Whether it is the motion of all nodes, which is compared frame by frame.
    pub fn is_motion(&self) -> bool {
        self.names == Named::Motion
    }
}

/// Reads a list of names, each kept once.
///
/// # Errors
/// The first name that cannot be read.
pub fn read_names(names: &[String]) -> Result<Vec<QuantityName>, QuantityError> {
    let mut once: Vec<QuantityName> = Vec::new();
    for name in names {
        let name: QuantityName = name.parse()?;
        if !once.contains(&name) {
            once.push(name);
        }
    }
    Ok(once)
}

/// What the gauge of a column measures, in a word: `tension` of `tension_max`.
fn word(column: &str) -> &str {
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
    with(&|column| column.line.is_some())
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
    use crate::model::gauge::{CANOPY_QUANTITIES, GaugeKind, GaugeQuantity};

    #[test]
    fn names_are_read() {
        let series = |text: &str| match text.parse::<QuantityName>().map(|name| name.names) {
            Ok(Named::Series { gauge, column, statistic }) => Some((gauge, column, statistic)),
            _ => None,
        };
        let [riser, tip, line] =
            ["riser.tension.peak", "tip.z@0.5", "springs[5] lines.tension_max.peak_time"].map(series);
        assert_eq!(riser, Some(("riser".into(), "tension".into(), Statistic::Peak)));
        assert_eq!(tip, Some(("tip".into(), "z".into(), Statistic::At(0.5))));
        assert_eq!(line, Some(("springs[5] lines".into(), "tension_max".into(), Statistic::PeakTime)));
        assert_eq!("motion".parse::<QuantityName>().map(|name| name.is_motion()), Ok(true));
        for wrong in ["", "riser", "riser.peak", "riser.tension.top", "tip.z@soon", "Motion"] {
            assert!(wrong.parse::<QuantityName>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_word_means_the_column_of_the_report_or_the_largest() {
        let columns = |of: GaugeQuantity| match of.kind() {
            GaugeKind::Springs(of) => of.columns().all().to_vec(),
            GaugeKind::Nodes(of) => of.columns.all().to_vec(),
            GaugeKind::Cloth => Vec::new(),
        };
        let name = |of, word| {
            let columns = columns(of);
            column_of(&columns, word).map(|i| columns[i].name)
        };
        assert_eq!(name(GaugeQuantity::Tension, "tension"), Some("tension_max"));
        assert_eq!(name(GaugeQuantity::Reaction, "reaction"), Some("reaction_total"));
        assert_eq!(name(GaugeQuantity::Speed, "speed"), Some("speed_max"));
        assert_eq!(name(GaugeQuantity::Position, "position"), None, "three of the same rank");
        assert_eq!(name(GaugeQuantity::Position, "position_z"), Some("position_z"));
        let drag = column_of(&CANOPY_QUANTITIES, "drag").map(|i| CANOPY_QUANTITIES[i].name);
        assert_eq!(drag, Some("drag"));
    }
}
