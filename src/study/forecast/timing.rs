//! Processor time of small pieces of work.

use std::time::Instant;

use crate::process;

/// [s] A sample is made at least so long, by repeating the work: far above the clock's grain.
const SAMPLE: f64 = 20e-6;
/// Samples of which the median is taken.
const SAMPLES: usize = 7;

/// Reads processor time, or the wall clock where the system does not say.
#[derive(Clone, Copy, Debug)]
pub struct Clock(Instant);

impl Default for Clock {
    fn default() -> Self {
        Clock(Instant::now())
    }
}

impl Clock {
    /// [s] spent, from some fixed moment on.
    pub fn seconds(&self) -> f64 {
        process::cpu_seconds().unwrap_or_else(|| self.0.elapsed().as_secs_f64())
    }
}

/// [s] What a piece of work costs once it is warm: the median of a few samples, or the only one where that already
/// takes `budget` [s].
pub fn median_seconds(budget: f64, mut work: impl FnMut()) -> f64 {
    let clock = Clock::default();
    let mut sample = |repeats: u32| {
        let before = clock.seconds();
        (0..repeats).for_each(|_| work());
        (clock.seconds() - before) / f64::from(repeats)
    };
    let first = sample(1);
    if first >= budget {
        return first;
    }
    let warm = sample(1).max(1e-9);
    let repeats = (SAMPLE / warm).ceil().clamp(1.0, 1e6);
    let affordable = (budget / (repeats * warm)) as usize;
    let mut samples: Vec<f64> = (0..affordable.clamp(1, SAMPLES)).map(|_| sample(repeats as u32)).collect();
    samples.sort_by(f64::total_cmp);
    samples[samples.len() / 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Work is done a bounded number of times, and dear work once.
    #[test]
    fn dear_work_is_done_once() {
        let mut count = 0u64;
        assert!(median_seconds(0.0, || count += 1) >= 0.0);
        assert_eq!(count, 1);
        let mut count = 0u64;
        median_seconds(1e-3, || count = std::hint::black_box(count + 1));
        assert!((2..100_000_000).contains(&count), "{count}");
    }
}
