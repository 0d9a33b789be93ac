//! `canopy-fem export OUT --to glb`: an animation of a run for programs of pictures.

use super::CliError;
use super::terminal::complain;
use crate::output::atomic::{Durability, replace};
use crate::output::sanitize::file_stem;
use crate::plot::PlotError;
use crate::study::export::{Animation, AnimationFormat, FRAMES};
use crate::study::view::Recording;
use std::path::PathBuf;

/// Examples of the command, for its help.
pub const EXAMPLES: &str = "\
Examples:
  canopy-fem export out/c9-filling --to glb                       writes out/c9-filling/c9-filling.glb
  canopy-fem export out/c9-filling --to usda --output canopy.usda";

/// `export`.
#[derive(Clone, Debug, clap::Args)]
pub struct ExportArgs {
    /// Folder with results, as `canopy-fem solve` writes it, or its .pvd or .vtkhdf file
    #[arg(value_name = "OUT")]
    pub run: PathBuf,
    /// What to make
    #[arg(long, value_name = "FORMAT")]
    pub to: AnimationFormat,
    /// The file [default: the name of the case, in the run's folder]
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Most frames: every second, third, … of more is taken, and the last
    #[arg(long, default_value_t = FRAMES, value_parser = at_least_two, value_name = "N")]
    pub frames: usize,
    /// No warnings, no name of the file
    #[arg(long, short)]
    pub quiet: bool,
}

fn at_least_two(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|frames| *frames >= 2).ok_or_else(|| "give a whole number from 2 on".to_owned())
}

pub(super) fn run(args: &ExportArgs) -> Result<String, CliError> {
    let run = Recording::open(&args.run)?;
    let animation = Animation::read(&run, args.frames)?;
    let (shown, listed) = (animation.frames.len(), animation.listed);
    if shown < listed && !args.quiet {
        complain(&format!("warning: {shown} of {listed} frames are in it; --frames {listed} takes all"));
    }
    let file = || run.folder.join(format!("{}.{}", file_stem(&run.name), args.to.ending()));
    let path = args.output.clone().unwrap_or_else(file);
    let bytes = animation.encode(args.to).map_err(|what| PlotError::NotThere(format!("{} {what}", run.name)))?;
    replace(&path, &bytes, Durability::Visible).map_err(|source| PlotError::System { path: path.clone(), source })?;
    Ok(if args.quiet { String::new() } else { format!("{}\n", path.display()) })
}
