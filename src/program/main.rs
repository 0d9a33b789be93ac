//! The program; everything is in the library.

fn main() -> std::process::ExitCode {
    canopy_fem::cli::main()
}
