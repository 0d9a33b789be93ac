//! Where and how a study was made.

use std::fs;
use std::time::{SystemTime, UNIX_EPOCH};

use serde::Serialize;

/// How to make a study again.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Rerun {
    /// the command as it was typed
    pub command: String,
    /// where it ran
    pub machine: Machine,
}

/// A machine, as far as it is known.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Machine {
    /// model of the processor
    pub processor: Option<String>,
    /// sets of vector instructions it has, of those that matter here
    pub vectors: Vec<String>,
    /// threads it can run at once
    pub cores: Option<usize>,
    /// [byte] main memory
    pub memory_bytes: Option<u64>,
    /// operating system
    pub system: String,
    /// day, UTC: `2026-11-21`
    pub date: Option<String>,
}

impl Rerun {
    /// This machine, and the arguments of a command line without the program's own name, quoted as a POSIX shell wants
    /// them.
    ///
    /// ```
    /// use canopy_fem_study::report::Rerun;
    /// let typed = ["tradeoff", "a b.json", "--methods", r#"{"hht": {"alpha": -0.2}}"#, "--out", "it's"];
    /// let how = Rerun::here(typed.map(String::from));
    /// assert_eq!(how.command, r#"canopy-fem tradeoff 'a b.json' --methods '{"hht": {"alpha": -0.2}}' --out 'it'\''s'"#);
    /// ```
    pub fn here(arguments: impl IntoIterator<Item = String>) -> Self {
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+@%".contains(c);
        let quoted = |word: String| match word.is_empty() || !word.chars().all(plain) {
            true => format!("'{}'", word.replace('\'', r"'\''")),
            false => word,
        };
        let words = std::iter::once("canopy-fem".to_owned()).chain(arguments.into_iter().map(quoted));
        Rerun { command: words.collect::<Vec<_>>().join(" "), machine: Machine::here() }
    }
}

impl Machine {
    /// This machine, today.
    pub fn here() -> Self {
        let line = |path: &str, key: &str, sign: char| {
            let text = fs::read_to_string(path).ok()?;
            let value = text.lines().find_map(|line| line.strip_prefix(key)?.trim_start().strip_prefix(sign))?;
            Some(value.trim().trim_matches('"').to_owned()).filter(|v| !v.is_empty())
        };
        let memory = line("/proc/meminfo", "MemTotal", ':');
        let kibibytes = memory.and_then(|m| m.trim_end_matches("kB").trim().parse::<u64>().ok());
        let system = line("/etc/os-release", "PRETTY_NAME", '=').unwrap_or_else(|| std::env::consts::OS.to_owned());
        let kernel = fs::read_to_string("/proc/sys/kernel/osrelease").ok();
        let kernel = kernel.map(|k| format!(", kernel {}", k.trim())).unwrap_or_default();
        Machine {
            processor: line("/proc/cpuinfo", "model name", ':'),
            vectors: vectors(),
            cores: std::thread::available_parallelism().ok().map(usize::from),
            memory_bytes: kibibytes.map(|k| k.saturating_mul(1024)),
            system: format!("{system}{kernel}, {}", std::env::consts::ARCH),
            date: SystemTime::now().duration_since(UNIX_EPOCH).ok().map(|d| date(d.as_secs() / 86_400)),
        }
    }
}

#[cfg(target_arch = "x86_64")]
fn vectors() -> Vec<String> {
    let found = [
        ("AVX2", std::arch::is_x86_feature_detected!("avx2")),
        ("FMA", std::arch::is_x86_feature_detected!("fma")),
        ("AVX-512F", std::arch::is_x86_feature_detected!("avx512f")),
    ];
    found.into_iter().filter(|(_, has)| *has).map(|(name, _)| name.to_owned()).collect()
}

#[cfg(not(target_arch = "x86_64"))]
fn vectors() -> Vec<String> {
    Vec::new()
}

/// A day of the Gregorian calendar from the days since 1970-01-01 (Fliegel & Van Flandern 1968, from the Julian day
/// number).
fn date(days: u64) -> String {
    let l = days + 2_440_588 + 68_569;
    let n = 4 * l / 146_097;
    let l = l - (146_097 * n).div_ceil(4);
    let i = 4000 * (l + 1) / 1_461_001;
    let l = l - 1461 * i / 4 + 31;
    let j = 80 * l / 2447;
    let day = l - 2447 * j / 80;
    let l = j / 11;
    let month = j + 2 - 12 * l;
    let year = 100 * (n - 49) + i + l;
    format!("{year:04}-{month:02}-{day:02}")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first day, a leap day, and the days around the end of a century that is no leap year's.
    #[test]
    fn dates() {
        let days = [(0, "1970-01-01"), (19_782, "2024-02-29"), (47_540, "2100-02-28"), (47_541, "2100-03-01")];
        for (days, expected) in days {
            assert_eq!(date(days), expected);
        }
    }
}
