//! Interrupted, killed, out of disk, and resumed: the results are those of a run that was never stopped, byte for byte.

#[path = "cli/bench.rs"]
#[allow(dead_code)] // this binary uses its own part
mod bench;
#[path = "resume/bits.rs"]
mod bits;
mod common;
#[path = "resume/disk.rs"]
#[cfg(unix)]
mod disk;
#[path = "resume/folders.rs"]
mod folders;
#[path = "resume/kills.rs"]
#[cfg(unix)]
mod kills;
#[path = "support/read_vtu.rs"]
#[allow(dead_code)]
mod read_vtu;
#[path = "resume/refusals.rs"]
mod refusals;
