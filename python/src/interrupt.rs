//! Long work that Ctrl-C ends.

use crate::errors::panicked;
use crate::forces::Raised;
use crate::{logs, pool};
use canopy_fem::interrupt::heeding;
use pyo3::prelude::*;
use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Time between two looks at signals.
pub(crate) const LOOK: Duration = Duration::from_millis(10);

/// The same within a step, where each look may wait for other threads of the interpreter.
const SELDOM: Duration = Duration::from_millis(50);

/// What a thread has done, or how it has panicked.
type Done<R> = Result<R, Box<dyn Any + Send>>;

/// Runs `work` on a thread of its own, while this one looks at signals and calls `meanwhile`. If one of them raises,
/// the flag is set that `work` gets, and its exception is raised once `work` has ended.
///
/// # Errors
/// A signal's exception, such as `KeyboardInterrupt`; one of `meanwhile`; a panic.
pub(crate) fn watched<R: Send>(
    py: Python<'_>,
    work: impl FnOnce(&AtomicBool) -> R + Send,
    meanwhile: impl FnMut(Python<'_>) -> PyResult<()> + Send,
) -> PyResult<R> {
    let stop = Arc::new(AtomicBool::new(false));
    let done = py.detach(|| {
        let (sender, receiver) = channel();
        std::thread::scope(|scope| {
            let own = stop.clone();
            scope.spawn(move || {
                // The receiver waits for it.
                let _ = sender.send(caught(own, work));
            });
            attended(&receiver, &stop, meanwhile)
        })
    });
    results(py, done)?.pop().ok_or_else(|| panicked(&"a thread ended without a result"))
}

/// Runs `work` on each of a number of threads of the pool, likewise.
///
/// # Errors
/// As [`watched`], and when the system has no more threads.
pub(crate) fn pooled<R: Send>(
    py: Python<'_>,
    threads: usize,
    work: impl Fn(&AtomicBool) -> R + Send + Sync,
    meanwhile: impl FnMut(Python<'_>) -> PyResult<()> + Send,
) -> PyResult<Vec<R>> {
    let (pool, stop) = (pool::of(py, threads)?, Arc::new(AtomicBool::new(false)));
    let done = py.detach(|| {
        let (sender, receiver) = channel();
        pool.in_place_scope(|scope| {
            for _ in 0..threads {
                let (sender, own, work) = (sender.clone(), stop.clone(), &work);
                scope.spawn(move |_| {
                    // The receiver waits for it.
                    let _ = sender.send(caught(own, work));
                });
            }
            drop(sender);
            attended(&receiver, &stop, meanwhile)
        })
    });
    results(py, done)
}

/// Runs `work`, whose parts end once `stop` is set.
fn caught<R>(stop: Arc<AtomicBool>, work: impl FnOnce(&AtomicBool) -> R) -> Done<R> {
    let flag = stop.clone();
    let asked = move || stop.load(Ordering::Relaxed);
    catch_unwind(AssertUnwindSafe(|| heeding(asked, || work(&flag))))
}

/// Waits for threads; what they have done, and what was raised meanwhile.
fn attended<R>(
    receiver: &Receiver<Done<R>>,
    stop: &AtomicBool,
    mut meanwhile: impl FnMut(Python<'_>) -> PyResult<()>,
) -> (Vec<Done<R>>, Option<PyErr>) {
    let (mut all, mut raised) = (Vec::new(), None);
    loop {
        match receiver.recv_timeout(LOOK) {
            Ok(done) => {
                stop.fetch_or(done.is_err(), Ordering::Relaxed);
                all.push(done);
            }
            Err(RecvTimeoutError::Disconnected) => return (all, raised),
            Err(RecvTimeoutError::Timeout) if raised.is_some() => {}
            Err(RecvTimeoutError::Timeout) => {
                let look =
                    |py: Python<'_>| py.check_signals().and_then(|()| logs::tell(py)).and_then(|()| meanwhile(py));
                raised = Python::attach(look).err();
                stop.fetch_or(raised.is_some(), Ordering::Relaxed);
            }
        }
    }
}

/// What threads have done, unless something was raised.
fn results<R>(py: Python<'_>, (all, raised): (Vec<Done<R>>, Option<PyErr>)) -> PyResult<Vec<R>> {
    logs::tell(py)?;
    match raised {
        Some(error) => Err(error),
        None => all.into_iter().map(|done| done.map_err(|panic| panicked(&*panic))).collect(),
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
