//! Sums element forces into nodes, with the same bits for every number of threads.
//!
//! Elements are cut into tiles, each summed in a window of its own. One thread adds a tile's window to the nodes as soon as it is done;
//! several threads fill all windows first, then every node adds its own entries in the order of the tiles. Both add the same numbers to
//! a node in the same order, and tallies are added in the order of the tiles; so the bits agree.

use super::NodeState;
pub use super::tile::Tile;
use super::tile::{Plan, Tiles, WINDOW};
pub use super::window::Records;
use super::window::{Padded, Window, rows};
use crate::model::forces::Tally;
pub use crate::model::lanes::{LANES, Lanes};
use crate::model::workers::Workers;
use glam::DVec3;
use rayon::prelude::*;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

const NODES_PER_TASK: usize = 4096;

/// A thread's windows for one tile.
#[derive(Debug)]
struct Windows {
    x: Window,
    v: Window,
    f: Window,
}

impl Default for Windows {
    fn default() -> Self {
        Windows { x: Window::new(0), v: Window::new(32), f: Window::new(16) }
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
    /// One thread: no pool is made.
    pub fn one() -> Self {
        Threads { workers: Workers::default(), windows: vec![Mutex::default()] }
    }

    /// `n` threads (0 and 1 mean one).
    ///
    /// # Errors
    /// When the operating system gives no threads.
    pub fn new(n: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        Ok(Threads { workers: Workers::new(n)?, windows: (0..n.max(1)).map(|_| Mutex::default()).collect() })
    }

    /// The threads, for loops over nodes.
    pub fn workers(&self) -> &Workers {
        &self.workers
    }

    /// The windows of a thread of the pool.
    fn windows(&self, thread: usize) -> MutexGuard<'_, Windows> {
        self.windows[thread % self.windows.len()].lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What a kernel wants to find in the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wants {
    /// positions
    pub x: bool,
    /// velocities
    pub v: bool,
}

/// The forces of like elements with `N` nodes each.
pub trait Kernel<const N: usize>: Send + Sync {
    /// What it wants in the window; what it does not want is not copied.
    const WANTS: Wants;

    /// Node numbers of every element.
    fn elements(&self) -> &[[u32; N]];

    /// Adds the forces [N] of a tile's elements to its window; returns their energy or power.
    fn add(&self, tile: Tile<'_, N>, f: &mut Records) -> Tally;
}

/// A kernel with its tiles, and with what several threads need, made when first used.
#[derive(Debug)]
pub struct Batch<K, const N: usize> {
    kernel: K,
    tiles: Tiles<N>,
    parallel: OnceLock<Mutex<Parallel>>,
}

#[derive(Debug)]
struct Parallel {
    /// per node: start of its list in `entries`
    start: Vec<u32>,
    /// places in the windows, ascending
    entries: Vec<u32>,
    /// room for one window a tile
    windows: Vec<Padded>,
    tally: Vec<Tally>,
}

impl<K: Kernel<N>, const N: usize> Batch<K, N> {
    /// Wraps a kernel.
    pub fn new(kernel: K) -> Self {
        let tiles = Tiles::new(kernel.elements());
        Batch { kernel, tiles, parallel: OnceLock::new() }
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
        match threads.workers.pool() {
            None => self.one_thread(at, &mut threads.windows(0), f),
            Some(pool) => {
                let parallel = self.parallel.get_or_init(|| Mutex::new(self.prepare(f.len())));
                let mut guard = parallel.lock().unwrap_or_else(PoisonError::into_inner);
                let parallel = &mut *guard;
                pool.install(|| self.several_threads(at, threads, parallel, f))
            }
        }
    }

    fn one_thread(&self, at: NodeState<'_>, windows: &mut Windows, f: &mut [DVec3]) -> Tally {
        let mut total = Tally::default();
        for plan in self.tiles.plan() {
            let (tally, sums) = self.tile(plan, at, windows);
            total += tally;
            self.tiles.add(plan, sums, f);
        }
        total
    }

    /// Energy or power of a tile, and the forces [N] on the nodes of its window.
    fn tile<'w>(&self, plan: &Plan, at: NodeState<'_>, windows: &'w mut Windows) -> (Tally, &'w [Padded]) {
        let (x, v, f) = (windows.x.records(), windows.v.records(), windows.f.records());
        let n = plan.window.len();
        if K::WANTS.x {
            self.tiles.load(plan, at.x, rows(x, n));
        }
        if K::WANTS.v {
            self.tiles.load(plan, at.v, rows(v, n));
        }
        rows(f, n).as_flattened_mut().fill(0.0);
        let nodes = self.tiles.local(plan);
        let tally = self.kernel.add(Tile { at, x, v, nodes, first: plan.elements.start }, f);
        (tally, rows(f, n))
    }

    fn several_threads(&self, at: NodeState<'_>, threads: &Threads, p: &mut Parallel, f: &mut [DVec3]) -> Tally {
        let Parallel { start, entries, windows, tally } = p;
        let tiles = self.tiles.plan().par_iter().zip(windows.par_chunks_mut(WINDOW)).zip(tally.par_iter_mut());
        tiles.for_each(|((plan, sums), tally)| {
            let mut own = threads.windows(rayon::current_thread_index().unwrap_or(0));
            let (found, own_sums) = self.tile(plan, at, &mut own);
            sums[..own_sums.len()].copy_from_slice(own_sums);
            *tally = found;
        });
        f.par_chunks_mut(NODES_PER_TASK).enumerate().for_each(|(task, f)| {
            let first = task * NODES_PER_TASK;
            for (i, f) in f.iter_mut().enumerate() {
                let list = start[first + i] as usize..start[first + i + 1] as usize;
                for &entry in &entries[list] {
                    let sum = windows[entry as usize];
                    *f += DVec3::new(sum[0], sum[1], sum[2]);
                }
            }
        });
        let mut total = Tally::default();
        for &t in tally.iter() {
            total += t;
        }
        total
    }

    fn prepare(&self, n_nodes: usize) -> Parallel {
        let places =
            || self.tiles.plan().iter().enumerate().flat_map(|(t, plan)| self.tiles.nodes(plan).zip(t * WINDOW..));
        let mut start = vec![0u32; n_nodes + 1];
        for (node, _) in places() {
            start[node as usize + 1] += 1;
        }
        for i in 0..n_nodes {
            start[i + 1] += start[i];
        }
        let mut next = start.clone();
        let mut entries = vec![0u32; start[n_nodes] as usize];
        for (node, place) in places() {
            entries[next[node as usize] as usize] = place as u32;
            next[node as usize] += 1;
        }
        let tiles = self.tiles.plan().len();
        Parallel {
            start,
            entries,
            windows: vec![Padded::default(); tiles * WINDOW],
            tally: vec![Tally::default(); tiles],
        }
    }
}
