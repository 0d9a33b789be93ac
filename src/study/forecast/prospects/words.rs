//! What is said of prospects.

use serde::Serialize;

use super::{ErrorForecast, KnownBy, Prospect, Prospects};
use crate::accuracy::Accuracy;
use crate::case::spec::TimeSpec;
use crate::format_number::{counted, figures};
use crate::template::seconds;

/// The lines of `check`.
#[derive(Debug, Serialize)]
pub struct Lines {
    own: String,
    numbers: String,
    recommended: Vec<String>,
    none: String,
    known: String,
}

/// Numbers of a run that are told.
const NUMBERS: usize = 4;

impl Prospects {
    /// In words; `own` says whether the run that others were compared with is the case's, `time` when it
    /// ends.
    pub fn lines(&self, own: bool, time: &TimeSpec, accuracy: &Accuracy) -> Lines {
        let Prospects { this_case, recommended, part, runs, landing, .. } = self;
        let ends = match (time.until_rest, time.to_ground, landing) {
            (Some(_), ..) => ", as it ends at rest",
            (None, true, None) => ", as it ends on the ground",
            _ => "",
        };
        let steps = if this_case.step.is_some() { "step" } else { "tolerance" };
        let rough = this_case.known_by == KnownBy::Steps && this_case.estimate.doubtful;
        let mut numbers = this_case.described(accuracy);
        let unknown = this_case.errors.len() - numbers.len();
        let more = numbers.len().saturating_sub(NUMBERS);
        numbers.truncate(NUMBERS);
        let mut rest = if more > 0 { format!(" and {more} more") } else { String::new() };
        if unknown > 0 {
            let why = if *part < 1.0 { ", as the end was not reached" } else { "" };
            rest.push_str(&format!(
                "; of {} the error is not known{why}",
                counted(unknown as u64, "number", "numbers")
            ));
        }
        let said = |prospect: &Prospect| {
            let same = own && prospect.is_as(this_case);
            let who = if same { "your run".to_owned() } else { prospect.typed() };
            let worst = prospect.described(accuracy).into_iter().next().unwrap_or_default();
            let times = prospect.cpu_seconds / this_case.cpu_seconds;
            let gains = match own && times > 1.5 {
                true => format!("; {} times your run", figures(times, 2)),
                false => String::new(),
            };
            format!("{who}, about {}: {worst} at most{gains}", seconds(prospect.cpu_seconds))
        };
        let reached = if *part < 1.0 {
            format!("the first {} % of the run, with {runs}", figures(100.0 * part, 2))
        } else {
            format!("whole runs, with {runs}")
        };
        Lines {
            own: format!(
                "{}, {steps} {}: {} steps, {} {}{ends}{}",
                this_case.method,
                this_case.size(),
                figures(this_case.estimate.steps, 4),
                if !ends.is_empty() || rough { "at most about" } else { "about" },
                seconds(this_case.cpu_seconds),
                landing.map_or_else(String::new, |t| format!(", to the landing at t = {} s", figures(t, 3)))
            ),
            numbers: match numbers.is_empty() {
                true => "errors not known, as check makes too little of the run; canopy-fem solve --verify finds them"
                    .to_owned(),
                false => numbers.join(", ") + &rest,
            },
            recommended: recommended.iter().map(said).collect(),
            none: match numbers.is_empty() && runs.is_empty() {
                true => {
                    let typed = accuracy.to_string().replace(' ', "");
                    format!(
                        "not tried; canopy-fem check --within {typed} tries runs, solve --within {typed} makes them"
                    )
                }
                false => "no run is known to be; canopy-fem solve --within and tradeoff make longer ones".to_owned(),
            },
            known: match self.this_case.known_by {
                KnownBy::Counts => "from single steps and counts".to_owned(),
                KnownBy::Steps => "from some of its steps, along a coarse run".to_owned(),
                KnownBy::Part if runs.is_empty() => format!("from the first {} % of the run", figures(100.0 * part, 2)),
                _ => format!("by {reached}"),
            },
        }
    }
}

impl Prospect {
    fn is_as(&self, other: &Prospect) -> bool {
        self.method == other.method && self.step == other.step && self.tolerance == other.tolerance
    }

    /// Its step [s] or tolerance, with the unit.
    fn size(&self) -> String {
        match (self.step, self.tolerance) {
            (Some(h), _) => format!("{} s", figures(h, 4)),
            (None, Some(tolerance)) => format!("{tolerance:e}"),
            (None, None) => String::new(),
        }
    }

    /// As the command line takes it.
    fn typed(&self) -> String {
        match (self.step, self.tolerance) {
            (Some(h), _) => format!("--method {} --step {}", self.method, figures(h, 4)),
            (None, Some(tolerance)) => format!("--method {} --tolerance {tolerance:e}", self.method),
            (None, None) => self.method.to_owned(),
        }
    }

    /// Its errors in words, the largest share of the accuracy first: "opening load ± 0.1 %".
    pub fn described(&self, accuracy: &Accuracy) -> Vec<String> {
        let mut all: Vec<(&String, &ErrorForecast)> = self.errors.iter().collect();
        let size = |of: &ErrorForecast| of.share.or(of.error).unwrap_or(f64::INFINITY);
        all.sort_by(|a, b| size(b.1).total_cmp(&size(a.1)));
        all.retain(|(_, of)| of.error.is_some());
        let words = |(name, of): (&String, &ErrorForecast)| {
            let name = spoken(name);
            match (accuracy, of) {
                (Accuracy::Absolute(_, unit), ErrorForecast { error: Some(error), .. }) => {
                    format!("{name} ± {} {unit}", figures(*error, 2))
                }
                (_, ErrorForecast { share: Some(share), .. }) => format!("{name} ± {} %", figures(100.0 * share, 2)),
                _ => format!("{name} not known"),
            }
        };
        all.into_iter().map(words).collect()
    }
}

/// The name of a quantity in a sentence.
fn spoken(name: &str) -> String {
    match name {
        "opening_load" => "opening load".to_owned(),
        "displacement_end" => "displacement".to_owned(),
        _ => name.to_owned(),
    }
}
