//! The threads of a force pass.

use crate::force::kernel::local_buffer::Window;
use crate::model::workers::Workers;
use rayon::{ThreadPool, ThreadPoolBuildError};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Sums of a pass at most.
pub(crate) const SUMS: usize = 3;

/// A thread's windows.
#[derive(Debug)]
pub(in crate::force) struct Windows {
    pub x: Window,
    pub v: Window,
    pub sums: [Window; SUMS],
    /// for a scene that stays in its windows
    pub resident: Resident,
}

/// What is kept of nodes that stay in their windows.
#[derive(Debug)]
pub(in crate::force) struct Resident {
    /// [1/kg] by degree of freedom
    pub inverse_mass: Window,
    /// [m] positions at the start of the step
    pub before: Window,
    /// [m/s] kicked velocities
    pub kicked: Window,
    /// [N] forces of still terms
    pub kept: Window,
}

impl Default for Windows {
    fn default() -> Self {
        let [inverse_mass, before, kicked, kept] = [48, 24, 56, 4].map(Window::new);
        let resident = Resident { inverse_mass, before, kicked, kept };
        Windows { x: Window::new(0), v: Window::new(32), sums: [16, 40, 8].map(Window::new), resident }
    }
}

/// How many threads a force pass may use, and their windows.
#[derive(Debug)]
pub struct Threads {
    workers: Workers,
    /// one a thread
    windows: Vec<Mutex<Windows>>,
}

impl Default for Threads {
    fn default() -> Self {
        Threads::one()
    }
}

impl Threads {
    fn of(workers: Workers) -> Self {
        let n = workers.pool().map_or(1, ThreadPool::current_num_threads);
        Threads { workers, windows: (0..n).map(|_| Mutex::default()).collect() }
    }

    /// One thread: no pool is made.
    pub fn one() -> Self {
        Threads::of(Workers::default())
    }

    /// `n` threads (0 and 1 mean one).
    ///
    /// # Errors
    /// When the operating system gives no threads.
    pub fn new(n: usize) -> Result<Self, ThreadPoolBuildError> {
        Ok(Threads::of(Workers::new(n)?))
    }

    /// The same with the calling thread as one of them, for scenes that are used on it: see [`Workers::with_caller`].
    ///
    /// # Errors
    /// When the operating system gives no threads.
    pub fn with_caller(n: usize) -> Result<Self, ThreadPoolBuildError> {
        Ok(Threads::of(Workers::with_caller(n)?))
    }

    /// The threads, for loops over nodes.
    pub fn workers(&self) -> &Workers {
        &self.workers
    }

    /// How many there are.
    pub(in crate::force) fn count(&self) -> usize {
        self.windows.len()
    }

    /// The windows of a thread of the pool.
    pub(in crate::force) fn windows(&self, thread: usize) -> MutexGuard<'_, Windows> {
        self.windows[thread % self.windows.len()].lock().unwrap_or_else(PoisonError::into_inner)
    }
}
