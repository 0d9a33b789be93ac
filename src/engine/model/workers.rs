//! Loops over all degrees of freedom on several threads, with the same bits for every number of them.
//!
//! A loop is divided into chunks whose size depends on its length only. The results of the chunks are added in their
//! order, on one thread too, so the bits agree.

use super::lanes::{LANES, Lanes};
use multiversion::multiversion;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use std::cell::OnceCell;
use std::ops::Range;
use std::sync::{Arc, Mutex};

/// Largest number of chunks.
const CHUNKS: usize = 64;
/// Least number of entries of a chunk: enough to outweigh its hand-over. A multiple of every block size of the loops.
const CHUNK: usize = 3 * 2048;

/// The threads that loops over a scene's nodes may use.
#[derive(Clone, Debug, Default)]
pub struct Workers(Option<Arc<ThreadPool>>);

thread_local! {
    /// A pool that includes this thread, which saves handing work over and waking it afterwards.
    static OWN: OnceCell<Arc<ThreadPool>> = const { OnceCell::new() };
}

/// Work on chunks of two vectors with their range.
type OnBoth<'a> = &'a (dyn Fn(Range<usize>, &mut [f64], &mut [f64]) + Sync);

/// The calling thread only.
pub static ALONE: Workers = Workers(None);

impl Workers {
    /// `n` threads; 0 and 1 mean the calling thread, without a pool.
    ///
    /// # Errors
    /// When the operating system cannot start threads.
    pub fn new(n: usize) -> Result<Self, ThreadPoolBuildError> {
        if n <= 1 {
            return Ok(Workers(None));
        }
        Ok(Workers(Some(Arc::new(ThreadPoolBuilder::new().num_threads(n).build()?))))
    }

    /// The same with the calling thread as one of them, which saves a hand-over each time. It must be used on that
    /// thread, since on others there is one thread less. The pool exists as long as the thread, and also runs the
    /// thread's own parallel loops. A thread can belong to one such pool only: a second one with another number is made
    /// by [`Workers::new`].
    ///
    /// # Errors
    /// When the operating system cannot start threads.
    pub fn with_caller(n: usize) -> Result<Self, ThreadPoolBuildError> {
        if n <= 1 {
            return Ok(Workers(None));
        }
        let shared = OWN.with(|own| {
            if own.get().is_none()
                && let Ok(pool) = ThreadPoolBuilder::new().num_threads(n).use_current_thread().build()
            {
                let _ = own.set(Arc::new(pool));
            }
            own.get().filter(|pool| pool.current_num_threads() == n).cloned()
        });
        shared.map_or_else(|| Workers::new(n), |pool| Ok(Workers(Some(pool))))
    }

    /// The pool, if there is more than one thread.
    pub fn pool(&self) -> Option<&ThreadPool> {
        self.0.as_deref()
    }

    /// Calls `work` for chunks of `out` with their ranges.
    pub fn set(&self, out: &mut [f64], work: impl Fn(Range<usize>, &mut [f64]) + Sync) {
        self.set_chunks(out, &work);
    }

    /// Not generic: one copy of what shares out chunks serves all loops.
    fn set_chunks(&self, out: &mut [f64], work: &(dyn Fn(Range<usize>, &mut [f64]) + Sync)) {
        let size = chunk(out.len());
        let run = |(i, out): (usize, &mut [f64])| work(i * size..i * size + out.len(), out);
        match self.pool().filter(|_| out.len() > size) {
            None => out.chunks_mut(size).enumerate().for_each(run),
            Some(pool) => pool.install(|| out.par_chunks_mut(size).enumerate().for_each(run)),
        }
    }

    /// The same for chunks of two vectors of one length.
    pub fn both(&self, a: &mut [f64], b: &mut [f64], work: impl Fn(Range<usize>, &mut [f64], &mut [f64]) + Sync) {
        self.both_chunks(a, b, &work);
    }

    fn both_chunks(&self, a: &mut [f64], b: &mut [f64], work: OnBoth<'_>) {
        let size = chunk(a.len());
        let run = |(i, (a, b)): (usize, (&mut [f64], &mut [f64]))| work(i * size..i * size + a.len(), a, b);
        match self.pool().filter(|_| a.len() > size) {
            None => a.chunks_mut(size).zip(b.chunks_mut(size)).enumerate().for_each(run),
            Some(pool) => {
                pool.install(|| a.par_chunks_mut(size).zip(b.par_chunks_mut(size)).enumerate().for_each(run));
            }
        }
    }

    /// The results of two pieces of work, side by side if there is more than one thread.
    pub fn join<A: Send, B: Send>(
        &self,
        mut one: impl FnMut() -> A + Send,
        mut other: impl FnMut() -> B + Send,
    ) -> (A, B) {
        let (mut a, mut b) = (None, None);
        side_by_side(self.pool(), &mut || a = Some(run(&mut one)), &mut || b = Some(run(&mut other)));
        // Both have run.
        (a.unwrap_or_else(|| run(&mut one)), b.unwrap_or_else(|| run(&mut other)))
    }

    /// Does the work on all sections, each on any thread.
    pub fn each_section<T: Send>(
        &self,
        mut sections: impl ExactSizeIterator<Item = T> + Send,
        work: impl Fn(T) + Sync,
    ) {
        let count = sections.len();
        let Some(pool) = self.pool().filter(|_| count > 1) else { return sections.for_each(work) };
        let left = Mutex::new(&mut sections);
        let next = || left.lock().ok().and_then(|mut left| left.next());
        let threads = count.min(pool.current_num_threads());
        on_threads_of(pool, threads, &|| std::iter::from_fn(next).for_each(&work));
    }

    /// The results of `part` for each chunk of `0..n`, combined in their order.
    pub fn fold<T: Copy + Send + Sync>(
        &self,
        n: usize,
        none: T,
        part: impl Fn(Range<usize>) -> T + Sync,
        join: impl Fn(T, T) -> T,
    ) -> T {
        let size = chunk(n);
        if n <= size {
            return part(0..n);
        }
        let count = n.div_ceil(size).min(CHUNKS);
        let mut parts = [none; CHUNKS];
        let run = |(i, out): (usize, &mut T)| *out = part(i * size..((i + 1) * size).min(n));
        match self.pool() {
            None => parts[..count].iter_mut().enumerate().for_each(run),
            Some(pool) => pool.install(|| parts[..count].par_iter_mut().enumerate().for_each(run)),
        }
        parts[..count].iter().fold(none, |a, b| join(a, *b))
    }

    /// Sum of the results of `part` for each chunk of `0..n`.
    pub fn sum(&self, n: usize, part: impl Fn(Range<usize>) -> f64 + Sync) -> f64 {
        self.sum_of_chunks(n, &part)
    }

    fn sum_of_chunks(&self, n: usize, part: &(dyn Fn(Range<usize>) -> f64 + Sync)) -> f64 {
        self.fold(n, 0.0, part, |a, b| a + b)
    }

    /// Whether all values are finite.
    pub fn all_finite(&self, values: &[f64]) -> bool {
        self.sum(values.len(), |r| times_zero(&values[r])) == 0.0
    }
}

/// Not inlined: one copy of the work is enough.
#[inline(never)]
fn run<T>(work: &mut impl FnMut() -> T) -> T {
    work()
}

/// Not generic: one copy of what shares out work serves all calls.
fn side_by_side(pool: Option<&ThreadPool>, one: &mut (dyn FnMut() + Send), other: &mut (dyn FnMut() + Send)) {
    match pool {
        None => {
            one();
            other();
        }
        Some(pool) => {
            pool.install(|| rayon::join(one, other));
        }
    }
}

fn on_threads_of(pool: &ThreadPool, count: usize, work: &(dyn Fn() + Sync)) {
    pool.install(|| on_threads(count, work));
}

/// Does the work so many times, on as many threads of the pool as are free. Allocates nothing.
fn on_threads(count: usize, work: &(dyn Fn() + Sync)) {
    match count {
        0 | 1 => work(),
        _ => {
            rayon::join(|| on_threads(count / 2, work), || on_threads(count - count / 2, work));
        }
    }
}

/// The product of a value and zero is zero only if the value is finite.
#[multiversion(targets("x86_64+avx+avx2"))]
fn times_zero(values: &[f64]) -> f64 {
    let mut sum = Lanes::default();
    let (rows, last) = values.as_chunks::<LANES>();
    for row in rows {
        sum.add(&row.map(|value| 0.0 * value));
    }
    sum.total() + last.iter().map(|value| 0.0 * value).sum::<f64>()
}

fn chunk(n: usize) -> usize {
    n.div_ceil(CHUNKS).next_multiple_of(CHUNK).max(CHUNK)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_is_one_of_a_single_pool() {
        let index =
            |workers: &Workers| workers.pool().map(|pool| (pool.current_thread_index(), pool.current_num_threads()));
        let [two, three, again] = [2, 3, 2].map(|n| Workers::with_caller(n).expect("threads"));
        assert_eq!([&two, &three, &again].map(index), [Some((Some(0), 2)), Some((None, 3)), Some((Some(0), 2))]);
        assert_eq!(index(&Workers::with_caller(1).expect("no threads")), None);
        assert_eq!(std::thread::scope(|scope| scope.spawn(|| index(&two)).join().expect("no panic")), Some((None, 2)));
    }

    #[test]
    fn one_value_that_is_not_finite_is_found_wherever_it_is() {
        let workers = Workers::new(2).expect("threads");
        for n in [1, 8, 9, CHUNK + 3] {
            let mut values = vec![-1e308; n];
            assert!(workers.all_finite(&values));
            for at in [0, n / 2, n - 1] {
                for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                    values[at] = wrong;
                    assert!(!workers.all_finite(&values), "{wrong} at {at} of {n}");
                }
                values[at] = 0.0;
            }
        }
        assert!(workers.all_finite(&[]));
    }

    #[test]
    fn chunks_cover_everything_once_and_sums_do_not_depend_on_threads() {
        for n in [0, 1, CHUNK, CHUNK + 1, 200_001, CHUNKS * CHUNK + 7] {
            let values: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
            let results = [1, 2, 3].map(|threads| {
                let workers = Workers::new(threads).expect("threads");
                let mut out = vec![0.0; n];
                workers.set(&mut out, |range, out| out.iter_mut().zip(&values[range]).for_each(|(out, v)| *out += v));
                assert_eq!(out, values);
                let sum: f64 = workers.sum(n, |range| values[range].iter().sum());
                let (mut a, mut b) = (out.clone(), out);
                workers.both(&mut a, &mut b, |range, a, b| {
                    for ((a, b), v) in a.iter_mut().zip(b).zip(&values[range]) {
                        (*a, *b) = (*a - v, *b + v);
                    }
                });
                assert!(a.iter().all(|a| *a == 0.0) && b.iter().zip(&values).all(|(b, v)| *b == 2.0 * v));
                sum.to_bits()
            });
            assert_eq!(results, [results[0]; 3]);
        }
    }
}
