//! A column of values of a gauge: its name, its words, its unit, its peak and its line in a report.

use super::{CANOPY_QUANTITIES, GaugeQuantity};
use serde::Serialize;

/// A column of values of a gauge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Quantity {
    /// its name in `gauges.csv` and `summary.json`
    pub name: &'static str,
    /// its unit
    #[serde(skip)]
    pub unit: &'static str,
    /// what it is, in words; empty where `name` has the same words
    #[serde(skip)]
    words: &'static str,
    /// which of its values is its peak
    #[serde(skip)]
    pub peak: PeakRule,
    /// its line in the report of a run, if it has one
    #[serde(skip)]
    pub line: Option<ReportLine>,
}

/// Which value of a quantity is its peak.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PeakRule {
    /// the largest
    Largest,
    /// that of the largest magnitude, as of components
    LargestMagnitude,
}

/// A line of the report of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReportLine {
    /// the peak, with a word for what it is
    Peak(&'static str),
    /// the peak with words for what it is, of what no study takes for its number without being asked
    Told(&'static str),
    /// the peak of a canopy's drag
    Drag,
    /// the speed of a canopy at the end
    Descent,
    /// a ratio at the end
    Ratio {
        /// its symbol
        symbol: &'static str,
        /// what follows its value
        of: &'static str,
    },
}

impl Quantity {
    /// A quantity whose peak is its largest value.
    pub const fn of(name: &'static str, unit: &'static str) -> Self {
        Quantity { name, unit, words: "", peak: PeakRule::Largest, line: None }
    }

    /// A quantity whose peak is the value of the largest magnitude.
    pub const fn signed(name: &'static str, unit: &'static str) -> Self {
        Quantity { peak: PeakRule::LargestMagnitude, ..Self::of(name, unit) }
    }

    pub(super) const fn called(self, words: &'static str) -> Self {
        Quantity { words, ..self }
    }

    /// What it is, in words.
    pub fn words(&self) -> String {
        if self.words.is_empty() { self.name.replace('_', " ") } else { self.words.to_owned() }
    }

    /// The column of a gauge or a canopy with this name.
    pub fn named(name: &str) -> Option<Self> {
        let all = GaugeQuantity::ALL.into_iter().flat_map(GaugeQuantity::columns).chain(&CANOPY_QUANTITIES);
        all.copied().find(|column| column.name == name)
    }

    /// Whether it is a number of the report that studies take without being asked.
    pub fn is_reported(&self) -> bool {
        self.line.is_some_and(|line| !matches!(line, ReportLine::Told(_)))
    }

    pub(super) const fn in_report(self, line: ReportLine) -> Self {
        Quantity { line: Some(line), ..self }
    }
}
