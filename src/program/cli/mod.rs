//! The command line: its arguments, and one file per command.

mod args;
mod case_args;
mod check;
mod check_contact;
mod check_json;
mod check_static;
mod check_system;
mod error;
pub mod export;
pub mod fit;
pub mod gradient;
pub mod init;
mod interrupt;
mod known_models;
pub mod mesh;
mod mesh_json;
mod mesh_output;
mod methods;
mod parachute;
pub mod plot;
pub mod progress;
mod report;
pub mod require;
mod resume;
mod sample;
pub mod schema;
mod shell;
mod solve;
pub mod stability;
mod stages;
mod static_;
mod study;
pub mod sweep;
mod terminal;
pub mod tradeoff;
mod verbose;
pub mod view;
mod view_live;
mod worth;

pub use args::{Args, Command};
pub use case_args::{CaseArgs, CheckArgs, SolveArgs};
pub use error::CliError;

use clap::Parser;
use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;
use terminal::complain;

/// The program: [`run`] with the arguments of the process.
pub fn main() -> ExitCode {
    ExitCode::from(run(std::env::args_os().skip(1).collect()))
}

/// Parses the arguments after the program's name, runs the command, prints its result, and gives the exit status: 0
/// done, 1 input/output or internal failure, 2 bad usage or bad case, 3 diverged, not solvable or without equilibrium,
/// 130 interrupted.
///
/// Once in a process, and as all that it does: signals are caught from then on, and one may end the process.
pub fn run(arguments: Vec<OsString>) -> u8 {
    interrupt::outlive_full_files();
    interrupt::catch_interrupts();
    study::remember(&arguments);
    let name = std::iter::once(OsString::from("canopy-fem"));
    let args = match Args::try_parse_from(name.chain(arguments)) {
        Ok(args) => args,
        Err(error) => {
            let error = args::with_advice(error);
            // A closed pipe (`canopy-fem --help | head`) is not a failure.
            let _ = error.print().and_then(|()| std::io::stdout().flush());
            return u8::try_from(error.exit_code()).unwrap_or(2);
        }
    };
    verbose::start(args.verbose);
    match dispatch(&args.command) {
        Ok(CommandOutput { text, code }) => {
            let written = if args.command.prints_data() { terminal::print_data(&text) } else { terminal::print(&text) };
            match written {
                // A closed pipe (`canopy-fem methods | head`) is not a failure.
                Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
                    complain(&format!("error: standard output: {e}"));
                    1
                }
                _ => code,
            }
        }
        Err(error) => {
            complain(&format!("error: {error}"));
            // Whatever a signal has cut short.
            if interrupt::is_asked() { 130 } else { error.exit_code() }
        }
    }
}

/// The result of a command: text for standard output, and its exit status.
struct CommandOutput {
    text: String,
    code: u8,
}

fn dispatch(command: &Command) -> Result<CommandOutput, CliError> {
    let done = |text: String| CommandOutput { text, code: 0 };
    match command {
        Command::Solve(args) => solve::run(args),
        Command::Static(args) => static_::run(args),
        Command::Check(args) => check::run(args).map(done),
        Command::Stability(args) => stability::run(args),
        Command::Mesh(args) => Ok(done(mesh::run(args)?)),
        Command::Tradeoff(args) => tradeoff::run(args),
        Command::Sweep(args) => sweep::run(args),
        Command::Fit(args) => fit::run(args),
        Command::Require(args) => require::run(args),
        Command::Gradient(args) => gradient::run(args),
        Command::Plot(args) => plot::run(args).map(done),
        Command::View(args) => view::run(args).map(done),
        Command::Export(args) => export::run(args).map(done),
        Command::Methods(args) => Ok(done(methods::run(args))),
        Command::Schema => Ok(done(schema::run() + "\n")),
        Command::Materials => Ok(done(crate::case::materials::SHIPPED.to_owned())),
        Command::Init(args) => Ok(done(init::run(args)?)),
        Command::Completions(args) => Ok(done(shell::completions(args))),
        Command::Man(args) => shell::man(args).map(done),
    }
}
