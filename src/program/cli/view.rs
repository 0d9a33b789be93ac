//! `canopy-fem view OUT`: a page with the frames and gauges of a run.

use super::CliError;
use super::terminal::complain;
use super::view_live::serve;
use crate::output::atomic::{Durability, replace};
use crate::plot::PlotError;
use crate::study::view::{Recording, page};
use std::path::{Path, PathBuf};

/// Name of the page.
pub const PAGE: &str = "view.html";
/// Examples of the command, for its help.
pub const EXAMPLES: &str = "\
Examples:
  canopy-fem view out/c9-filling                            writes out/c9-filling/view.html
  canopy-fem view out/c9-filling out/c9-drop --out out      two runs beside each other
  canopy-fem view out/c9-filling --live                     a run that goes on, at http://127.0.0.1:...";

/// `view`.
#[derive(Clone, Debug, clap::Args)]
pub struct ViewArgs {
    /// Folders with results, as `canopy-fem solve` writes them, or their .pvd or .vtkhdf files: one, or two to compare
    #[arg(required = true, num_args = 1..=2, value_name = "OUT")]
    pub runs: Vec<PathBuf>,
    /// Folder for view.html [default: the run's folder; for two runs, the current folder]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Write no file: serve the page of a run that goes on to browsers of this machine, until Ctrl-C; it shows new
    /// frames by itself
    #[arg(long, conflicts_with = "out")]
    pub live: bool,
    /// Port of --live [default: a free one]
    #[arg(long, requires = "live", default_value_t = 0, hide_default_value = true, value_name = "PORT")]
    pub port: u16,
    /// No warnings, no name of the file
    #[arg(long, short)]
    pub quiet: bool,
}

pub(super) fn run(args: &ViewArgs) -> Result<String, CliError> {
    if args.live {
        let [only] = args.runs.as_slice() else {
            return Err(PlotError::NotThere("--live shows one run; give one folder".to_owned()).into());
        };
        return serve(only, args.port).map(|()| String::new());
    }
    let runs: Vec<Recording> = args.runs.iter().map(|run| Recording::open(run)).collect::<Result<_, _>>()?;
    let folder = match (&args.out, runs.as_slice()) {
        (Some(out), _) => out.as_path(),
        (None, [only]) => only.folder.as_path(),
        _ => Path::new(""),
    };
    let path = write(&runs, folder, args.quiet)?;
    Ok(if args.quiet { String::new() } else { format!("{}\n", path.display()) })
}

/// Writes the page of some runs into a folder, which is made if it is not there; the path of the page.
pub(super) fn write(runs: &[Recording], folder: &Path, quiet: bool) -> Result<PathBuf, CliError> {
    let (text, notes) = page(runs, false)?;
    notes.iter().filter(|_| !quiet).for_each(|note| complain(&format!("warning: {note}")));
    let system = |path: &Path| {
        let path = path.to_owned();
        move |source| PlotError::System { path, source }
    };
    if !folder.as_os_str().is_empty() {
        std::fs::create_dir_all(folder).map_err(system(folder))?;
    }
    let path = folder.join(PAGE);
    replace(&path, text.as_bytes(), Durability::Visible).map_err(system(&path))?;
    Ok(path)
}
