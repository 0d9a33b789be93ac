//! `canopy-fem plot OUT...`: charts of finished runs.

use super::CliError;
use super::terminal::complain;
use crate::output::atomic::{Durability, replace};
use crate::plot::PlotError;
use crate::plot::chart::Scale;
use crate::plot::convert::{Format, convert};
use crate::plot::picture::{Picture, picture};
use crate::plot::results::Run;
use crate::plot::view::{Direction, Kind, Results, View};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Examples of the command, for its help.
pub const EXAMPLES: &str = "\
Examples:
  canopy-fem plot out/c9-drop                                   the four charts to look at first
  canopy-fem plot out/c9-drop --all                             all that the results hold
  canopy-fem plot out/c9-drop --kind gauges --gauge riser       one gauge
  canopy-fem plot out/c9-drop --kind ledger --log y             small entries of the energy account
  canopy-fem plot out/rk4 out/newmark --out out/plots           two runs in the same charts
  canopy-fem plot out/rk4 --minus out/newmark --out out/plots   the difference of two runs
  canopy-fem plot out/c9-drop --format png,pdf                  for slides and for print";

/// `plot`.
#[derive(Clone, Debug, clap::Args)]
pub struct PlotArgs {
    /// Folders with results, as `canopy-fem solve` writes them
    #[arg(required = true, value_name = "OUT")]
    pub runs: Vec<PathBuf>,
    /// Folder for the pictures [default: the run's folder; for several runs or a difference, the current folder]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// What to plot, all charts of it; may be given several times [default: four charts, of the probes, the energies
    /// and the gauges that the report tells, then of what else there is]
    #[arg(long, value_enum, value_delimiter = ',')]
    pub kind: Vec<Kind>,
    /// All charts that the results hold something for
    #[arg(long, conflicts_with = "kind")]
    pub all: bool,
    /// Direction of motion; for a bob, measured from its lowest point [default: direction of the largest motion; the
    /// angle of a pendulum]
    #[arg(long, value_enum)]
    pub axis: Option<Direction>,
    /// Probe by name; may be given several times [default: all]
    #[arg(long, value_name = "NAME")]
    pub probe: Vec<String>,
    /// Nodes among the probed ones, e.g. 3,7 or 650..702 with both ends [default: all]
    #[arg(long, value_parser = nodes, value_name = "LIST")]
    pub nodes: Option<Nodes>,
    /// Gauge by name; may be given several times [default: all]
    #[arg(long, value_name = "NAME")]
    pub gauge: Vec<String>,
    /// Subtract this run from each of the others, at their times; between its times it is a cubic
    #[arg(long, value_name = "OUT")]
    pub minus: Option<PathBuf>,
    /// Axes that are logarithmic; points that are not above 0 are left out
    #[arg(long, value_enum, value_name = "AXES")]
    pub log: Option<LogAxes>,
    /// Plot from this time on [s]
    #[arg(long, value_parser = seconds, allow_negative_numbers = true, value_name = "TIME")]
    pub from: Option<f64>,
    /// Plot up to this time [s]
    #[arg(long, value_parser = seconds, allow_negative_numbers = true, value_name = "TIME")]
    pub to: Option<f64>,
    /// Formats of the pictures, separated by commas; png and pdf need a program built with `--features pictures`
    #[arg(long, value_enum, value_delimiter = ',', default_value = "svg")]
    pub format: Vec<Format>,
    /// No warnings, no names of files
    #[arg(long, short)]
    pub quiet: bool,
    /// Pixels of a PNG per pixel of the SVG
    #[arg(long, value_parser = scale, default_value = "2", value_name = "FACTOR")]
    pub scale: f32,
}

/// Axes that are logarithmic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum LogAxes {
    /// the horizontal one
    X,
    /// the vertical one
    Y,
    /// both
    Xy,
}

/// A list of nodes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Nodes(pub Vec<u32>);

pub(super) fn run(args: &PlotArgs) -> Result<String, CliError> {
    if let (Some(from), Some(to)) = (args.from, args.to)
        && from >= to
    {
        return Err(PlotError::NotThere(format!("--from {from} is not before --to {to}")).into());
    }
    args.format.iter().try_for_each(|format| format.check())?;
    let results = Results {
        runs: args.runs.iter().map(|folder| Run::read(folder)).collect::<Result<_, _>>()?,
        base: args.minus.as_deref().map(Run::read).transpose()?,
    };
    // All charts are made before the first is written.
    let mut files = Vec::new();
    for (stem, Picture { svg, remarks, .. }) in pictures(args, &results)? {
        remarks.iter().filter(|_| !args.quiet).for_each(|remark| complain(&format!("warning: {remark}")));
        for (i, format) in args.format.iter().enumerate() {
            if !args.format[..i].contains(format) {
                let name = format!("{stem}.{}", format.ending());
                files.push((name, convert(&svg, *format, args.scale)?.into_owned()));
            }
        }
    }
    let folder = match (&args.out, args.runs.as_slice()) {
        (Some(out), _) => out.as_path(),
        (None, [only]) if args.minus.is_none() => only.as_path(),
        _ => Path::new(""),
    };
    let mut text = String::new();
    if !folder.as_os_str().is_empty() {
        std::fs::create_dir_all(folder).map_err(|source| PlotError::System { path: folder.to_owned(), source })?;
    }
    for (name, bytes) in files {
        let path = folder.join(name);
        replace(&path, &bytes, Durability::Visible)
            .map_err(|source| PlotError::System { path: path.clone(), source })?;
        let _ = writeln!(text, "{}", path.display());
    }
    Ok(if args.quiet { String::new() } else { text })
}

/// Charts that are drawn if nobody asks for others.
const FEW: usize = 4;
/// Kinds in the order in which they get a place among [`FEW`] charts, with the most that they get of them at first.
const FIRST: [(Kind, usize); 7] = [
    (Kind::Displacement, 1),
    (Kind::Energy, 1),
    (Kind::Gauges, FEW),
    (Kind::Tension, 1),
    (Kind::Reaction, 1),
    (Kind::Phase, 1),
    (Kind::Steps, 1),
];

/// A picture with the stem of its file.
type Named = (&'static str, Picture);

/// The pictures: of the requested kinds, each once; by default a few of what the results hold something of.
fn pictures(args: &PlotArgs, results: &Results) -> Result<Vec<Named>, PlotError> {
    let mut drawing = Drawing { args, results, made: Vec::new(), refused: None };
    if args.all || !args.kind.is_empty() {
        let wanted = |kind: &Kind| if args.all { kind.adds(&results.runs) } else { args.kind.contains(kind) };
        for kind in Kind::ALL.into_iter().filter(wanted) {
            drawing.add(kind, None)?;
        }
        return drawing.finish();
    }
    let (mut left, mut more) = (FEW, false);
    for (kind, most) in FIRST.into_iter().filter(|(kind, _)| kind.adds(&results.runs)) {
        if left == 0 {
            more = true;
            continue;
        }
        let [charts, without] = drawing.add(kind, Some(most.min(left)))?;
        left -= charts;
        more |= without > 0;
    }
    if more && !args.quiet {
        complain("note: these are the first charts; --all draws all, --kind those of a kind");
    }
    let order = |stem: &str| Kind::ALL.iter().position(|kind| kind.stem() == stem);
    drawing.made.sort_by_key(|(stem, _)| order(stem));
    drawing.finish()
}

/// Pictures that are being drawn.
struct Drawing<'a> {
    args: &'a PlotArgs,
    results: &'a Results,
    made: Vec<Named>,
    refused: Option<PlotError>,
}

impl Drawing<'_> {
    /// Draws a kind, with at most so many charts. Returns how many it has, and how many were left out. What the results
    /// do not hold, or a logarithmic axis cannot show, is an error only where the kind is asked for.
    fn add(&mut self, kind: Kind, most: Option<usize>) -> Result<[usize; 2], PlotError> {
        let asked = !self.args.kind.is_empty();
        match picture(self.results, &view(self.args, most), kind) {
            Err(PlotError::NotHeld { .. }) if !asked => Ok([0; 2]),
            Err(error @ PlotError::NothingPositive { .. }) if !asked => {
                if !self.args.quiet {
                    complain(&format!("warning: no {}: {error}", kind.stem()));
                }
                self.refused.get_or_insert(error);
                Ok([0; 2])
            }
            picture => {
                let picture = picture?;
                let charts = picture.charts;
                self.made.push((kind.stem(), picture));
                Ok(charts)
            }
        }
    }

    fn finish(self) -> Result<Vec<Named>, PlotError> {
        match self.refused {
            Some(error) if self.made.is_empty() => Err(error),
            _ => Ok(self.made),
        }
    }
}

/// The selected part of the results, with at most so many charts of a kind.
fn view(args: &PlotArgs, most: Option<usize>) -> View {
    let log = |axes: [LogAxes; 2]| match args.log {
        Some(log) if axes.contains(&log) => Scale::Log,
        _ => Scale::Linear,
    };
    View {
        axis: args.axis,
        probes: args.probe.clone(),
        nodes: args.nodes.clone().map(|n| n.0).unwrap_or_default(),
        gauges: args.gauge.clone(),
        most,
        scales: [log([LogAxes::X, LogAxes::Xy]), log([LogAxes::Y, LogAxes::Xy])],
        from: args.from,
        to: args.to,
    }
}

fn scale(text: &str) -> Result<f32, String> {
    let number = text.parse().ok().filter(|scale: &f32| (0.1..=20.0).contains(scale));
    number.ok_or_else(|| "expected a number from 0.1 to 20".to_owned())
}

fn seconds(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|t: &f64| t.is_finite()).ok_or_else(|| "expected a time in seconds".to_owned())
}

/// Numbers and ranges that include both ends, separated by commas.
fn nodes(text: &str) -> Result<Nodes, String> {
    let wrong = || "expected nodes such as 3,7 or 650..702".to_owned();
    let mut nodes = Vec::new();
    for part in text.split(',') {
        let number = |n: &str| n.trim().parse::<u32>().map_err(|_| wrong());
        let (first, last) = part.split_once("..").unwrap_or((part, part));
        let (first, last) = (number(first)?, number(last)?);
        if first > last || last - first >= 10_000_000 {
            return Err(wrong());
        }
        nodes.extend(first..=last);
    }
    Ok(Nodes(nodes))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lists and ranges with both ends; anything else is refused.
    #[test]
    fn lists_of_nodes() {
        assert_eq!(nodes("3,7"), Ok(Nodes(vec![3, 7])));
        assert_eq!(nodes("5..7, 1"), Ok(Nodes(vec![5, 6, 7, 1])));
        for text in ["", "a", "7..5", "1,,2", "-1", "0..4294967295"] {
            assert!(nodes(text).is_err(), "{text}");
        }
    }
}
