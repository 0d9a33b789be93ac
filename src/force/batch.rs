//! Sums element forces into nodes, with the same bits for every number of threads.
//!
//! One thread computes a block of elements into a small buffer and scatters it. Several threads compute all
//! elements first, then every node gathers its own elements in ascending order. Both add the same numbers to a
//! node in the same order, and the tallies of fixed blocks are added in block order; so the bits agree.

use super::NodeState;
use crate::model::forces::Tally;
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Mutex, OnceLock, PoisonError};

/// Elements a block: the buffers of a block stay in the first-level cache.
pub const BLOCK: usize = 64;
/// Blocks a parallel task, so that a task outweighs its hand-over.
const BLOCKS_PER_TASK: usize = 16;
const NODES_PER_TASK: usize = 1024;

/// How many threads a force pass may use.
#[derive(Debug, Default)]
pub struct Threads(Option<rayon::ThreadPool>);

impl Threads {
    /// One thread: no pool is made.
    pub fn one() -> Self {
        Threads(None)
    }

    /// `n` threads (0 and 1 mean one).
    ///
    /// # Errors
    /// When the operating system gives no threads.
    pub fn new(n: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        if n <= 1 {
            return Ok(Threads(None));
        }
        Ok(Threads(Some(rayon::ThreadPoolBuilder::new().num_threads(n).build()?)))
    }
}

/// The forces of like elements with `N` nodes each.
pub trait Kernel<const N: usize>: Send + Sync {
    /// How an element's force vector acts on each of its nodes: +1 or -1.
    const SIGNS: [f64; N];

    /// Node numbers of every element.
    fn elements(&self) -> &[[u32; N]];

    /// `out[i] =` force vector [N] of element `range.start + i`; returns the range's energy or power.
    fn forces(&self, at: NodeState<'_>, range: Range<usize>, out: &mut [DVec3]) -> Tally;
}

/// A kernel with what several threads need, made when first used.
#[derive(Debug)]
pub struct Batch<K, const N: usize> {
    kernel: K,
    parallel: OnceLock<Mutex<Parallel>>,
}

#[derive(Debug)]
struct Parallel {
    /// per node: start of its list in `incidence`
    start: Vec<u32>,
    /// element * N + local node, ascending
    incidence: Vec<u32>,
    force: Vec<DVec3>,
    tally: Vec<Tally>,
}

impl<K: Kernel<N>, const N: usize> Batch<K, N> {
    /// Wraps a kernel.
    pub fn new(kernel: K) -> Self {
        Batch { kernel, parallel: OnceLock::new() }
    }

    /// The kernel.
    pub fn kernel(&self) -> &K {
        &self.kernel
    }

    /// Number of elements.
    pub fn elements(&self) -> usize {
        self.kernel.elements().len()
    }

    /// f += element forces; returns the sum of energies or powers.
    pub fn add(&self, at: NodeState<'_>, threads: &Threads, f: &mut [DVec3]) -> Tally {
        match &threads.0 {
            None => self.scatter(at, f),
            Some(pool) => {
                let parallel = self.parallel.get_or_init(|| Mutex::new(self.prepare(f.len())));
                let mut guard = parallel.lock().unwrap_or_else(PoisonError::into_inner);
                let parallel = &mut *guard;
                pool.install(|| self.gather(at, parallel, f))
            }
        }
    }

    fn scatter(&self, at: NodeState<'_>, f: &mut [DVec3]) -> Tally {
        let elements = self.kernel.elements();
        let mut buffer = [DVec3::ZERO; BLOCK];
        let mut total = Tally::default();
        for (b, nodes) in elements.chunks(BLOCK).enumerate() {
            let first = b * BLOCK;
            let force = &mut buffer[..nodes.len()];
            total += self.kernel.forces(at, first..first + nodes.len(), force);
            for (nodes, &force) in nodes.iter().zip(force.iter()) {
                for (&node, sign) in nodes.iter().zip(K::SIGNS) {
                    f[node as usize] += sign * force;
                }
            }
        }
        total
    }

    fn gather(&self, at: NodeState<'_>, p: &mut Parallel, f: &mut [DVec3]) -> Tally {
        let n = self.kernel.elements().len();
        p.force
            .par_chunks_mut(BLOCK * BLOCKS_PER_TASK)
            .zip(p.tally.par_chunks_mut(BLOCKS_PER_TASK))
            .enumerate()
            .for_each(|(task, (force, tally))| {
                let first = task * BLOCK * BLOCKS_PER_TASK;
                for (b, (force, tally)) in force.chunks_mut(BLOCK).zip(tally).enumerate() {
                    let begin = first + b * BLOCK;
                    *tally = self.kernel.forces(at, begin..(begin + BLOCK).min(n), force);
                }
            });
        let Parallel { start, incidence, force, tally } = &*p;
        f.par_chunks_mut(NODES_PER_TASK).enumerate().for_each(|(task, f)| {
            let first = task * NODES_PER_TASK;
            for (i, f) in f.iter_mut().enumerate() {
                let list = start[first + i] as usize..start[first + i + 1] as usize;
                for &entry in &incidence[list] {
                    *f += K::SIGNS[entry as usize % N] * force[entry as usize / N];
                }
            }
        });
        let mut total = Tally::default();
        for &t in tally {
            total += t;
        }
        total
    }

    fn prepare(&self, n_nodes: usize) -> Parallel {
        let elements = self.kernel.elements();
        let mut start = vec![0u32; n_nodes + 1];
        for &node in elements.as_flattened() {
            start[node as usize + 1] += 1;
        }
        for i in 0..n_nodes {
            start[i + 1] += start[i];
        }
        let mut next = start.clone();
        let mut incidence = vec![0u32; elements.len() * N];
        for (entry, &node) in elements.as_flattened().iter().enumerate() {
            incidence[next[node as usize] as usize] = entry as u32;
            next[node as usize] += 1;
        }
        let force = vec![DVec3::ZERO; elements.len()];
        Parallel { start, incidence, force, tally: vec![Tally::default(); elements.len().div_ceil(BLOCK)] }
    }
}

/// Sum in eight fixed lanes: vectorises, and has the same bits everywhere.
pub(crate) fn lane_sum(values: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    let chunks = values.chunks_exact(8);
    let rest = chunks.remainder();
    for chunk in chunks {
        for (lane, v) in lanes.iter_mut().zip(chunk) {
            *lane += v;
        }
    }
    for (lane, v) in lanes.iter_mut().zip(rest) {
        *lane += v;
    }
    ((lanes[0] + lanes[4]) + (lanes[2] + lanes[6])) + ((lanes[1] + lanes[5]) + (lanes[3] + lanes[7]))
}
