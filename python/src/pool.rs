//! The threads of rollouts, which stay for the next one.

use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::{Arc, Mutex, PoisonError};

/// A pool and the process that has its threads.
struct Kept {
    process: u32,
    pool: Arc<ThreadPool>,
}

static KEPT: Mutex<Option<Kept>> = Mutex::new(None);

/// [byte] memory of which the allocator of glibc keeps twice as much for the next run, once a block of it was freed.
/// Without it, it returns the memory of every small run to the system, and has it cleared again for the next one.
const KEPT_MEMORY: usize = 8 << 20;

/// The pool, with `threads` threads or more. It is made at the first call, again where more threads are asked for, and
/// again in a process that was forked: of a pool, a fork has the memory and not the threads.
///
/// # Errors
/// The system has no more threads.
pub(crate) fn of(_py: Python<'_>, threads: usize) -> PyResult<Arc<ThreadPool>> {
    // Held with the interpreter only, so that no fork of Python's finds it locked.
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    if let Some(Kept { process: own, pool }) = &*kept
        && *own == process
        && pool.current_num_threads() >= threads
    {
        return Ok(pool.clone());
    }
    drop(std::hint::black_box(Vec::<u8>::with_capacity(KEPT_MEMORY)));
    let made = ThreadPoolBuilder::new().num_threads(threads).thread_name(|number| format!("rollout {number}")).build();
    let pool = Arc::new(made.map_err(|error| PyOSError::new_err(error.to_string()))?);
    let before = kept.replace(Kept { process, pool: pool.clone() });
    // To end the threads of another process would wait for them.
    before.filter(|before| before.process != process).into_iter().for_each(std::mem::forget);
    Ok(pool)
}
