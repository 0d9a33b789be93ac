//! `canopy-fem plot OUT...`: displacement, phase and energy of finished runs as SVG.

use super::CliError;
use crate::output::atomic::{Durability, replace};
use crate::plot::PlotError;
use crate::plot::results::Run;
use crate::plot::view::{Direction, Kind, View, picture};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// `plot`.
#[derive(Clone, Debug, clap::Args)]
pub struct PlotArgs {
    /// Folders with results, as `canopy-fem solve` writes them
    #[arg(required = true, value_name = "OUT")]
    pub runs: Vec<PathBuf>,
    /// Folder for the pictures [default: the run's folder; for several runs, the current folder]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// What to plot; may be given several times [default: all that the results hold]
    #[arg(long, value_enum)]
    pub kind: Vec<Kind>,
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
    /// Plot from this time on [s]
    #[arg(long, value_parser = seconds, allow_negative_numbers = true, value_name = "TIME")]
    pub from: Option<f64>,
    /// Plot up to this time [s]
    #[arg(long, value_parser = seconds, allow_negative_numbers = true, value_name = "TIME")]
    pub to: Option<f64>,
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
    let runs = args.runs.iter().map(|folder| Run::read(folder)).collect::<Result<Vec<_>, _>>()?;
    let view = View {
        axis: args.axis,
        probes: args.probe.clone(),
        nodes: args.nodes.clone().map(|n| n.0).unwrap_or_default(),
        from: args.from,
        to: args.to,
    };
    // All charts are made before the first is written.
    let pictures = kinds(args, &runs).into_iter().map(|kind| Ok((kind.file(), picture(&runs, &view, kind)?)));
    let pictures = pictures.collect::<Result<Vec<_>, PlotError>>()?;
    let folder = match (&args.out, args.runs.as_slice()) {
        (Some(out), _) => out.as_path(),
        (None, [only]) => only.as_path(),
        _ => Path::new(""),
    };
    let mut text = String::new();
    if !folder.as_os_str().is_empty() {
        std::fs::create_dir_all(folder).map_err(|source| PlotError::System { path: folder.to_owned(), source })?;
    }
    for (file, svg) in pictures {
        let path = folder.join(file);
        replace(&path, svg.as_bytes(), Durability::Visible)
            .map_err(|source| PlotError::System { path: path.clone(), source })?;
        let _ = writeln!(text, "{}", path.display());
    }
    Ok(text)
}

/// The requested kinds, each once. By default all kinds, but without those of motion if no run has probes.
fn kinds(args: &PlotArgs, runs: &[Run]) -> Vec<Kind> {
    let probed = runs.iter().any(|run| !run.tracks.is_empty());
    let wanted = |kind: &Kind| match args.kind.as_slice() {
        [] => probed || *kind == Kind::Energy,
        kinds => kinds.contains(kind),
    };
    Kind::ALL.into_iter().filter(wanted).collect()
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
