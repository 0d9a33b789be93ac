//! `--verbose`: a log on standard error of what the program does, with the time since its start. Without it nothing is
//! made: the macros of `log` then only compare two numbers.

use super::terminal::interject;
use log::{Level, LevelFilter, Log, Metadata, Record};
use std::sync::OnceLock;
use std::time::Instant;

/// Writes every record as a line.
struct Lines {
    began: Instant,
}

impl Log for Lines {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.level() <= Level::Debug && metadata.target().starts_with("canopy_fem")
    }

    fn log(&self, record: &Record<'_>) {
        if self.enabled(record.metadata()) {
            interject(&format!("[{:9.4} s] {}", self.began.elapsed().as_secs_f64(), record.args()));
        }
    }

    fn flush(&self) {}
}

/// Starts the log: once for phases, solvers and events, twice for every factorisation too.
pub(super) fn start(verbose: u8) {
    static LINES: OnceLock<Lines> = OnceLock::new();
    let level = match verbose {
        0 => return,
        1 => LevelFilter::Info,
        _ => LevelFilter::Debug,
    };
    let lines = LINES.get_or_init(|| Lines { began: Instant::now() });
    // It is refused only if there is one already.
    if log::set_logger(lines).is_ok() {
        log::set_max_level(level);
    }
}
