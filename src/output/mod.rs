//! Results: a ParaView time series, `history.csv`, `probes.csv` and `summary.json` in one folder.
//!
//! The integrating thread only copies numbers into reused buffers ([`recorder`]); one background thread
//! ([`writer`]) formats and writes them ([`files`]), so that a slow disk costs memory for a few frames and
//! then waiting, never a lost or half-written row. A fault of that thread comes back as an
//! [`ObserveError`](crate::drive::observer::ObserveError) at the next send and at the end.

pub mod atomic;
pub mod csv;
pub mod encode;
pub mod files;
pub mod folder;
pub mod frame;
pub mod hermite;
pub mod history;
pub mod names;
pub mod probes;
pub mod process;
pub mod pvd;
pub mod recorder;
pub mod schedule;
pub mod space;
pub mod summary;
pub mod vtu;
pub mod writer;
