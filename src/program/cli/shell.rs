//! `canopy-fem completions SHELL` and `canopy-fem man DIR`: what a shell and `man` want to know of the command line.

use super::args::{CompletionsArgs, ManArgs};
use super::{Args, CliError};
use crate::output::folder::FolderError;
use clap::CommandFactory;
use std::path::Path;

/// The script that a shell sources.
pub(super) fn completions(args: &CompletionsArgs) -> String {
    let mut script = Vec::new();
    let mut command = Args::command();
    let name = command.get_name().to_owned();
    clap_complete::generate(args.shell, &mut command, name, &mut script);
    String::from_utf8_lossy(&script).into_owned()
}

/// Writes a page for the program and one for each command.
pub(super) fn man(args: &ManArgs) -> Result<String, CliError> {
    let fault = |path: &Path, source| FolderError::System { path: path.display().to_string(), source };
    std::fs::create_dir_all(&args.dir).map_err(|source| fault(&args.dir, source))?;
    clap_mangen::generate_to(Args::command(), &args.dir).map_err(|source| fault(&args.dir, source))?;
    Ok(format!("pages written; try: man {}\n", args.dir.join("canopy-fem.1").display()))
}
