//! Interrupted, killed, out of disk, and resumed: the results are those of a run that was never stopped, byte for byte.

mod bits;
#[cfg(unix)]
mod disk;
mod folders;
#[cfg(unix)]
mod kills;
#[cfg(unix)]
mod one_file;
mod refusals;
