//! Long work that Ctrl-C ends.

use crate::errors::panicked;
use crate::forces::Raised;
use canopy_fem::interrupt::heeding;
use pyo3::prelude::*;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Time between two looks at signals.
pub(crate) const LOOK: Duration = Duration::from_millis(10);

/// The same within a step, where each look may wait for other threads of the interpreter.
const SELDOM: Duration = Duration::from_millis(50);

/// Runs `work` on a thread of its own, while this one looks at signals and calls `meanwhile`. If one of them raises,
/// the flag is set that `work` gets, and its exception is raised once `work` has ended.
///
/// # Errors
/// A signal's exception, such as `KeyboardInterrupt`; one of `meanwhile`; a panic.
pub(crate) fn watched<R: Send>(
    py: Python<'_>,
    work: impl FnOnce(&AtomicBool) -> R + Send,
    mut meanwhile: impl FnMut(Python<'_>) -> PyResult<()> + Send,
) -> PyResult<R> {
    let stop = Arc::new(AtomicBool::new(false));
    let mut raised = None;
    let done = py.detach(|| {
        let (sender, receiver) = channel();
        std::thread::scope(|scope| {
            let own = stop.clone();
            scope.spawn(move || {
                let (flag, asked) = (own.clone(), move || own.load(Ordering::Relaxed));
                let done = catch_unwind(AssertUnwindSafe(|| heeding(asked, || work(&flag))));
                // The receiver waits for it.
                let _ = sender.send(done);
            });
            loop {
                match receiver.recv_timeout(LOOK) {
                    Ok(done) => return Some(done),
                    Err(RecvTimeoutError::Disconnected) => return None,
                    Err(RecvTimeoutError::Timeout) if raised.is_some() => {}
                    Err(RecvTimeoutError::Timeout) => {
                        let looked = Python::attach(|py| py.check_signals().and_then(|()| meanwhile(py)));
                        raised = looked.err();
                        stop.store(raised.is_some(), Ordering::Relaxed);
                    }
                }
            }
        })
    });
    let done = done.unwrap_or_else(|| Err(Box::new("a thread ended without a result")));
    match (raised, done) {
        (Some(error), _) => Err(error),
        (None, Ok(done)) => Ok(done),
        (None, Err(panic)) => Err(panicked(&*panic)),
    }
}

/// Runs `work` on this thread, which looks at signals wherever `work` asks whether to stop: the interpreter calls its
/// handlers on no other thread than the main one. An exception of one goes to `raised`, and `work` is asked to end.
pub(crate) fn looking<R>(raised: &Arc<Raised>, work: impl FnOnce() -> R) -> R {
    let (raised, last) = (raised.clone(), Cell::new(Instant::now()));
    let asked = move || {
        if !raised.is_set() && last.get().elapsed() > SELDOM {
            if let Err(error) = Python::attach(|py| py.check_signals()) {
                raised.keep(error);
            }
            last.set(Instant::now());
        }
        raised.is_set()
    };
    heeding(asked, work)
}
