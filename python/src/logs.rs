//! What the engine logs, for the logger `canopy_fem.engine` of Python: kept until a thread has the interpreter.

use log::{Level, LevelFilter, Log, Metadata, Record};
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// The logger of Python that gets it.
const LOGGER: &str = "canopy_fem.engine";
/// Lines that wait at most; later ones are lost until some were told.
const MOST: usize = 10_000;

struct Waiting {
    lines: Mutex<Vec<(Level, String)>>,
    some: AtomicBool,
}

static WAITING: Waiting = Waiting { lines: Mutex::new(Vec::new()), some: AtomicBool::new(false) };

impl Log for Waiting {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.level() <= log::max_level() && metadata.target().starts_with("canopy_fem")
    }

    fn log(&self, record: &Record<'_>) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let mut lines = self.lines.lock().unwrap_or_else(PoisonError::into_inner);
        if lines.len() < MOST {
            lines.push((record.level(), record.args().to_string()));
            self.some.store(true, Ordering::Relaxed);
        }
    }

    fn flush(&self) {}
}

/// Makes it the logger of this module.
pub(crate) fn install() {
    // It fails where it was done before, by another interpreter of this process.
    let _ = log::set_logger(&WAITING);
}

/// Level of Python's numbers.
fn number(level: Level) -> u8 {
    match level {
        Level::Error => 40,
        Level::Warn => 30,
        Level::Info => 20,
        Level::Debug | Level::Trace => 10,
    }
}

/// The engine logs from now on what the logger of Python lets through.
#[pyfunction]
pub(crate) fn _listen(py: Python<'_>) -> PyResult<()> {
    let least: u32 = logger(py)?.call_method0("getEffectiveLevel")?.extract()?;
    let all = [Level::Error, Level::Warn, Level::Info, Level::Debug];
    let most = all.into_iter().rfind(|level| u32::from(number(*level)) >= least);
    log::set_max_level(most.map_or(LevelFilter::Off, |level| level.to_level_filter()));
    Ok(())
}

/// Tells Python what waits.
///
/// # Errors
/// What a handler raises.
pub(crate) fn tell(py: Python<'_>) -> PyResult<()> {
    if !WAITING.some.swap(false, Ordering::Relaxed) {
        return Ok(());
    }
    let lines = std::mem::take(&mut *WAITING.lines.lock().unwrap_or_else(PoisonError::into_inner));
    let logger = logger(py)?;
    lines.into_iter().try_for_each(|(level, line)| logger.call_method1("log", (number(level), "%s", line)).map(drop))
}

fn logger(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    py.import("logging")?.call_method1("getLogger", (LOGGER,))
}
