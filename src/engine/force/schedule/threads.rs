//! The threads of a force pass.

use crate::force::kernel::local_buffer::LocalBuffer;
use crate::model::workers::Workers;
use rayon::{ThreadPool, ThreadPoolBuildError};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Sums of a pass at most.
pub(crate) const SUMS: usize = 3;

/// A thread's local buffers.
#[derive(Debug)]
pub(in crate::force) struct LocalBuffers {
    pub x: LocalBuffer,
    pub v: LocalBuffer,
    pub sums: [LocalBuffer; SUMS],
    /// for a scene that stays in its local buffers
    pub single_block: SingleBlockBuffers,
}

/// Further buffers for nodes that stay in the local buffers.
#[derive(Debug)]
pub(in crate::force) struct SingleBlockBuffers {
    /// [1/kg] by degree of freedom
    pub inverse_mass: LocalBuffer,
    /// [m] positions at the start of the step
    pub before: LocalBuffer,
    /// [m/s] kicked velocities
    pub kicked: LocalBuffer,
    /// [N] forces of terms of position only
    pub kept: LocalBuffer,
}

impl Default for LocalBuffers {
    fn default() -> Self {
        let [inverse_mass, before, kicked, kept] = [48, 24, 56, 4].map(LocalBuffer::new);
        let single_block = SingleBlockBuffers { inverse_mass, before, kicked, kept };
        LocalBuffers {
            x: LocalBuffer::new(0),
            v: LocalBuffer::new(32),
            sums: [16, 40, 8].map(LocalBuffer::new),
            single_block,
        }
    }
}

/// The threads of force passes, and their local buffers.
#[derive(Debug)]
pub struct Threads {
    workers: Workers,
    /// one per thread
    local_buffers: Vec<Mutex<LocalBuffers>>,
}

impl Default for Threads {
    fn default() -> Self {
        Threads::one()
    }
}

impl Threads {
    fn of(workers: Workers) -> Self {
        let n = workers.pool().map_or(1, ThreadPool::current_num_threads);
        Threads { workers, local_buffers: (0..n).map(|_| Mutex::default()).collect() }
    }

    /// One thread, without a pool.
    pub fn one() -> Self {
        Threads::of(Workers::default())
    }

    /// `n` threads (0 and 1 mean one).
    ///
    /// # Errors
    /// When the operating system cannot start threads.
    pub fn new(n: usize) -> Result<Self, ThreadPoolBuildError> {
        Ok(Threads::of(Workers::new(n)?))
    }

    /// The same with the calling thread as one of them, for scenes that are used on it: see [`Workers::with_caller`].
    ///
    /// # Errors
    /// When the operating system cannot start threads.
    pub fn with_caller(n: usize) -> Result<Self, ThreadPoolBuildError> {
        Ok(Threads::of(Workers::with_caller(n)?))
    }

    /// The same threads for another scene, which has its own local buffers.
    pub fn again(&self) -> Self {
        Threads::of(self.workers.clone())
    }

    /// The threads, for loops over nodes.
    pub fn workers(&self) -> &Workers {
        &self.workers
    }

    /// Their number.
    pub(in crate::force) fn count(&self) -> usize {
        self.local_buffers.len()
    }

    /// The local buffers of a thread of the pool.
    pub(in crate::force) fn local_buffers(&self, thread: usize) -> MutexGuard<'_, LocalBuffers> {
        self.local_buffers[thread % self.local_buffers.len()].lock().unwrap_or_else(PoisonError::into_inner)
    }
}
