//! Arguments that commands share, and those of `check` and `solve`.

use crate::study::accuracy::Accuracy;
use std::path::PathBuf;

/// Changes of a case, for every command that reads one.
#[derive(Clone, Debug, clap::Args)]
pub struct Changes {
    /// Replace any value of the case, e.g. time.step=1e-3 or system.network.springs.0.stiffness=500
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    pub set: Vec<(String, String)>,
}

/// Threads, for every command that evaluates forces.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct Threads {
    /// Threads for the force passes of scenes above 2,000 nodes; results are the same for every number
    #[arg(long = "threads", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub number: u16,
}

/// What a command prints.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct Print {
    /// No progress, no warnings, no report
    #[arg(long, short)]
    pub quiet: bool,
    /// Print the results as JSON in place of the report
    #[arg(long)]
    pub json: bool,
}

impl Threads {
    /// Their number.
    pub(super) fn get(self) -> usize {
        usize::from(self.number)
    }
}

/// A case with changes to it.
#[derive(Clone, Debug, clap::Args)]
pub struct CaseArgs {
    /// Case file (JSON; // comments and trailing commas are allowed)
    pub case: PathBuf,
    /// Method, with its default parameters, or as in the case file: '{"hht": {"alpha": -0.2}}'
    #[arg(long)]
    pub method: Option<String>,
    /// Fixed step [s]; replaces time.tolerance
    #[arg(long, allow_negative_numbers = true)]
    pub step: Option<String>,
    /// Relative tolerance of adaptive steps, with a hundredth of it [m] as the absolute one; replaces time.step
    #[arg(long, allow_negative_numbers = true, conflicts_with = "step")]
    pub tolerance: Option<String>,
    /// End of the simulated time [s]
    #[arg(long, allow_negative_numbers = true)]
    pub end: Option<String>,
    /// changes
    #[command(flatten)]
    pub changes: Changes,
}

/// `check`.
#[derive(Clone, Debug, clap::Args)]
pub struct CheckArgs {
    /// the case
    #[command(flatten)]
    pub case: CaseArgs,
    /// Recommend the cheapest run whose numbers are within this: 1%, 5e-3, or with a unit, 20N [default: the case's
    /// relative tolerance, else 1%]
    #[arg(long, visible_alias = "accuracy", value_name = "ACCURACY", allow_hyphen_values = true)]
    pub within: Option<Accuracy>,
    /// A number that is asked for, as study.quantities of the case has it: riser.tension.peak, opening_load, motion …;
    /// may be given several times [default: the numbers that solve prints]
    #[arg(long, value_name = "NAME")]
    pub quantity: Vec<String>,
    /// Check what `canopy-fem static` finds and costs; so are cases without a `time` section
    #[arg(long = "static", conflicts_with_all = ["within", "quantity"])]
    pub at_rest: bool,
    /// Time of loads, wind and supports [s] for that [default: 0]
    #[arg(long, value_name = "T", value_parser = super::static_::time, conflicts_with_all = ["within", "quantity"])]
    pub at: Option<f64>,
    /// Print the model, its cost, and what is predicted of every method, too
    #[arg(long, short)]
    pub all: bool,
    /// Print nothing but the case as JSON, with its materials and the defaults of its parachute written out as rules;
    /// it runs by itself, to the same results
    #[arg(long, conflicts_with_all = ["all", "within", "quiet", "json"])]
    pub expand: bool,
    /// threads
    #[command(flatten)]
    pub threads: Threads,
    /// what is printed
    #[command(flatten)]
    pub print: Print,
}

/// `solve`.
#[derive(Clone, Debug, clap::Args)]
pub struct SolveArgs {
    /// the case
    #[command(flatten)]
    pub case: CaseArgs,
    /// Folder for the results [default: out/NAME]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// threads
    #[command(flatten)]
    pub threads: Threads,
    /// Replace earlier results in the folder
    #[arg(long)]
    pub force: bool,
    /// Continue from the checkpoint in the folder. A run writes one when it is interrupted, and as often as
    /// output.checkpoint of the case says. With fixed steps, --end may be later than before
    #[arg(long, conflicts_with = "force")]
    pub resume: bool,
    /// Say what the numbers are worth: make runs with twice and four times the step (tolerance times ten) beside it,
    /// and print each number with its error
    #[arg(long, conflicts_with_all = ["resume", "keep_going"])]
    pub verify: bool,
    /// Find the longest step (the widest tolerance) with which the numbers of the report, or those of --quantity, are
    /// within this: 1%, 5e-3, or with a unit, 20N; then make that run
    #[arg(long, value_name = "ACCURACY", conflicts_with_all = ["resume", "keep_going", "verify"])]
    pub within: Option<Accuracy>,
    /// A number that is asked for, as study.quantities of the case has it: riser.tension.peak, tip.z@0.5, opening_load,
    /// motion …; may be given several times
    #[arg(long, value_name = "NAME")]
    pub quantity: Vec<String>,
    /// Continue after a divergence until a value is not finite
    #[arg(long)]
    pub keep_going: bool,
    /// At the end, write the page of `canopy-fem view` into the folder: the run in 3D, for a browser
    #[arg(long)]
    pub view: bool,
    /// Write M, C and K at t = 0 as MatrixMarket files into DIR before solving
    #[arg(long, value_name = "DIR")]
    pub dump_matrices: Option<PathBuf>,
    /// what is printed
    #[command(flatten)]
    pub print: Print,
}

impl CaseArgs {
    /// All replacements in the order they apply: `--set` first, then the flags with a name of their own.
    pub fn overrides(&self) -> Vec<(String, String)> {
        let steps = [
            self.step.clone().map(|step| [("time.tolerance", "null".to_owned()), ("time.step", step)]),
            self.tolerance.as_deref().map(|t| [("time.step", "null".to_owned()), ("time.tolerance", both(t))]),
        ];
        let flags = [("time.method", &self.method), ("time.end", &self.end)];
        let flags = flags.into_iter().filter_map(|(key, value)| Some((key, value.clone()?)));
        let named = flags.chain(steps.into_iter().flatten().flatten()).map(|(key, value)| (key.to_owned(), value));
        self.changes.set.iter().cloned().chain(named).collect()
    }
}

/// Both tolerances from the relative one; a value that is not a number is left to the check of the case.
fn both(relative: &str) -> String {
    match relative.trim().parse::<f64>() {
        // A number such as `.001` is no JSON.
        Ok(number) if number.is_finite() => {
            format!("{{\"relative\": {number:e}, \"absolute\": {:e}}}", number / 100.0)
        }
        _ => format!("{{\"relative\": {}}}", serde_json::Value::String(relative.to_owned())),
    }
}

impl CaseArgs {
    /// Those of the case, then the quantities that are asked for.
    pub(super) fn with_quantities(&self, names: &[String]) -> Vec<(String, String)> {
        self.overrides().into_iter().chain(asked_for(names)).collect()
    }
}

/// Quantities as a change of the case; none leave it as it is.
pub(super) fn asked_for(quantities: &[String]) -> Option<(String, String)> {
    let named = || ("study.quantities".to_owned(), serde_json::json!(quantities).to_string());
    (!quantities.is_empty()).then(named)
}

pub(super) fn key_value(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.is_empty() => Ok((key.to_owned(), value.to_owned())),
        _ => Err("expected KEY=VALUE, e.g. time.step=1e-3".to_owned()),
    }
}

/// [s] A time with its unit; without one, seconds.
pub(super) fn duration(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let units = [("min", 60.0), ("ms", 1e-3), ("s", 1.0), ("m", 60.0), ("h", 3600.0)];
    let (number, unit) =
        units.iter().find_map(|(unit, size)| Some((text.strip_suffix(unit)?, *size))).unwrap_or((text, 1.0));
    let seconds = number.trim().parse().ok().map(|number: f64| number * unit).filter(|s| *s > 0.0 && s.is_finite());
    seconds.ok_or_else(|| "expected a time above 0 such as 60s, 5min or 2h".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_as_typed() {
        let times = [("60s", 60.0), ("1.5", 1.5), ("5min", 300.0), ("5m", 300.0), ("2 h", 7200.0), ("100ms", 0.1)];
        for (text, seconds) in times {
            assert_eq!(duration(text), Ok(seconds), "{text}");
        }
        for text in ["", "0s", "-1s", "soon", "inf", "nan", "1day", "none"] {
            assert!(duration(text).is_err(), "{text}");
        }
    }
}
