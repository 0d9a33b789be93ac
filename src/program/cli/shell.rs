//! `canopy-fem completions SHELL` and `canopy-fem man DIR`: what a shell and `man` want to know of the command line.

use super::{Args, CliError};
use crate::output::folder::FolderError;
use clap::CommandFactory;
use clap_complete::Shell;
use std::path::{Path, PathBuf};

/// `completions`.
#[derive(Clone, Debug, clap::Args)]
pub struct CompletionsArgs {
    /// Shell to complete commands for
    #[arg(value_enum)]
    pub shell: Shell,
}

/// `man`.
#[derive(Clone, Debug, clap::Args)]
pub struct ManArgs {
    /// Folder for the pages, made if it does not exist; pages of the same name are replaced
    pub dir: PathBuf,
}

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
