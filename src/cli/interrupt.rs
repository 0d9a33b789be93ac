//! Ctrl-C: the first asks, the second ends the program at once. `SIGTERM` and `SIGXCPU`, with which batch systems announce the end of a job, ask too.

use super::complain;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Interrupts closer than this are one.
const SAME_INTERRUPT: Duration = Duration::from_millis(500);

/// A flag that Ctrl-C, `SIGTERM` and `SIGXCPU` set.
pub(super) fn stop_on_interrupt() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    let mut first: Option<Instant> = None;
    let handler = move || {
        flag.store(true, Ordering::Relaxed);
        if first.get_or_insert_with(Instant::now).elapsed() > SAME_INTERRUPT {
            std::process::exit(130);
        }
    };
    // Without a handler Ctrl-C still ends the program, only without a summary.
    if let Err(e) = ctrlc::set_handler(handler) {
        complain(&format!("warning: Ctrl-C will not be caught: {e}"));
    }
    // Not by ctrlc, which would catch SIGHUP as well, and so end what was started with nohup.
    #[cfg(unix)]
    {
        use signal_hook::consts::{SIGTERM, SIGXCPU};
        [SIGTERM, SIGXCPU].into_iter().for_each(|signal| catch(signal, &stop));
    }
    stop
}

/// Where a file reaches the size that is allowed, writing it is to fail, with a message, and not to end the program without one.
pub(super) fn outlive_full_files() {
    #[cfg(unix)]
    catch(signal_hook::consts::SIGXFSZ, &Arc::default());
}

#[cfg(unix)]
fn catch(signal: i32, flag: &Arc<AtomicBool>) {
    if let Err(e) = signal_hook::flag::register(signal, Arc::clone(flag)) {
        complain(&format!("warning: signal {signal} will not be caught: {e}"));
    }
}
