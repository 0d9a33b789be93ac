//! Ctrl-C, and `SIGTERM` and `SIGXCPU`, with which batch systems announce the end of a job. A command with nothing to
//! save ends at once. Another one is asked to stop at the first signal, and ends at once at the second.

use super::complain;
use std::process::exit;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Signals closer together than this count as one: a terminal and a batch system may both send one.
const SAME_INTERRUPT: Duration = Duration::from_millis(500);
/// Exit status of an interrupted command.
pub(super) const STATUS: i32 = 130;

/// Whether a signal has asked to stop; global, as signals belong to the process.
static ASKED: AtomicBool = AtomicBool::new(false);
/// Whether there is something to save, so that the first signal only asks.
static SAVES: AtomicBool = AtomicBool::new(false);
/// Time of the first signal.
static FIRST: Mutex<Option<Instant>> = Mutex::new(None);

/// From now on, the first signal only sets the [flag].
pub(super) fn stop_on_interrupt() -> &'static AtomicBool {
    SAVES.store(true, Ordering::Relaxed);
    flag()
}

/// The flag that the first signal sets, once there is something to save.
pub(super) fn flag() -> &'static AtomicBool {
    &ASKED
}

/// Whether a signal has asked to stop.
pub(super) fn is_asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}

/// Catches signals. They end the program until it says that it has something to save.
pub(super) fn catch_interrupts() {
    // Without a handler a signal still ends the program, only without a summary.
    if let Err(e) = ctrlc::set_handler(interrupted) {
        complain(&format!("warning: Ctrl-C will not be caught: {e}"));
    }
    // The crate ctrlc would also catch SIGHUP, and so end commands that were started with nohup.
    #[cfg(unix)]
    {
        use signal_hook::consts::{SIGTERM, SIGXCPU};
        match signal_hook::iterator::Signals::new([SIGTERM, SIGXCPU]) {
            Ok(mut signals) => {
                std::thread::spawn(move || signals.forever().for_each(|_| interrupted()));
            }
            Err(e) => complain(&format!("warning: signals will not be caught: {e}")),
        }
    }
}

fn interrupted() {
    if !SAVES.load(Ordering::Relaxed) {
        complain("interrupted");
        exit(STATUS)
    }
    ASKED.store(true, Ordering::Relaxed);
    let mut first = FIRST.lock().unwrap_or_else(PoisonError::into_inner);
    if first.get_or_insert_with(Instant::now).elapsed() > SAME_INTERRUPT {
        exit(STATUS);
    }
}

/// Makes a write beyond the allowed file size fail with a message, instead of ending the program without one.
pub(super) fn outlive_full_files() {
    #[cfg(unix)]
    if let Err(e) = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default()) {
        complain(&format!("warning: signal SIGXFSZ will not be caught: {e}"));
    }
}
