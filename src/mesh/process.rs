//! Resources used by this process.

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

/// Cost of a run, or of a part of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// [s] processor time, all threads; `None` if the system does not report it
    pub cpu: Option<f64>,
    /// time on the clock
    pub wall: Duration,
}

impl Cost {
    /// [s] Processor time, or the wall clock where the system does not say.
    pub fn seconds(self) -> f64 {
        self.cpu.unwrap_or(self.wall.as_secs_f64())
    }
}

/// Measures the cost of a run, added to the cost of its earlier parts.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch {
    before: Cost,
    clock: fn() -> Option<f64>,
    cpu: Option<f64>,
    wall: Instant,
}

impl Default for Stopwatch {
    fn default() -> Self {
        Stopwatch::start(Cost::default())
    }
}

impl Stopwatch {
    /// [s] Processor time until now, or the wall clock where the system does not say.
    pub fn seconds(&self) -> f64 {
        self.read().seconds()
    }

    /// Starts now.
    pub fn start(before: Cost) -> Self {
        Self { before, clock: cpu_seconds, cpu: cpu_seconds(), wall: Instant::now() }
    }

    /// As if it had started at a time and a processor time [s] of this process.
    pub fn since(before: Cost, wall: Instant, cpu: Option<f64>) -> Self {
        Self { before, clock: cpu_seconds, cpu, wall }
    }

    /// Starts now, and measures the processor time of the calling thread alone: several runs may share the process.
    pub fn of_thread(before: Cost) -> Self {
        Self { before, clock: thread_seconds, cpu: thread_seconds(), wall: Instant::now() }
    }

    /// The cost until now.
    pub fn read(&self) -> Cost {
        let now = || Some((self.clock)()? - self.cpu?);
        // A run without earlier parts begins at zero, even if the system reports nothing.
        let before = if self.before == Cost::default() { Some(0.0) } else { self.before.cpu };
        Cost {
            cpu: before.and_then(|before| Some(before + now()?)),
            wall: self.before.wall.saturating_add(self.wall.elapsed()),
        }
    }
}

/// [s] Processor time of all threads of this process; `None` if the system does not report it.
pub fn cpu_seconds() -> Option<f64> {
    #[cfg(unix)]
    {
        let spent = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        Some(spent.tv_sec as f64 + spent.tv_nsec as f64 * 1e-9)
    }
    #[cfg(not(unix))]
    None
}

/// [s] Processor time of the calling thread; `None` if the system does not report it.
pub fn thread_seconds() -> Option<f64> {
    #[cfg(unix)]
    {
        let spent = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
        Some(spent.tv_sec as f64 + spent.tv_nsec as f64 * 1e-9)
    }
    #[cfg(not(unix))]
    None
}

/// [byte] largest resident memory so far (`VmHWM` of proc(5)); `None` if the system does not report it.
pub fn peak_memory_bytes() -> Option<u64> {
    status_bytes("VmHWM:")
}

/// [byte] resident memory now (`VmRSS` of proc(5)); `None` if the system does not report it.
pub fn resident_bytes() -> Option<u64> {
    status_bytes("VmRSS:")
}

fn status_bytes(key: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(key))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    /// Work increases the processor time, and used memory the peak.
    #[test]
    fn use_is_seen() {
        let before = cpu_seconds().expect("Linux tells");
        let block = vec![1u8; 64 << 20];
        let sum: u64 = std::hint::black_box(&block).iter().map(|&b| u64::from(b)).sum();
        assert_eq!(sum, 64 << 20);
        assert!(cpu_seconds().expect("Linux tells") > before);
        assert!(peak_memory_bytes().expect("Linux tells") >= 64 << 20);
    }
}
