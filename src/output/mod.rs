//! Results: a ParaView time series, `history.csv`, `probes.csv` and `summary.json` in one folder.
//!
//! The integrating thread only copies numbers into reused buffers ([`recorder`]); one background thread
//! (`writer`) formats and writes them (`files`), so that a slow disk costs memory for a few frames and
//! then waiting, never a lost or half-written row. A fault of that thread comes back as an
//! [`ObserveError`](crate::drive::observer::ObserveError) at the next send and at the end.
//!
//! Whenever the program is killed, what is in the folder can be read (a csv file may end within a line), and the newest
//! [`checkpoint`] counts only results that are there: `--resume` cuts off the rest and goes on.

pub(crate) mod atomic;
pub mod checkpoint;
pub(crate) mod csv;
pub(crate) mod files;
pub mod folder;
pub mod frame;
pub(crate) mod frame_files;
pub mod hermite;
pub(crate) mod pvd;
pub mod recorder;
mod request;
pub(crate) mod resume;
pub(crate) mod rows;
pub(crate) mod sanitize;
pub(crate) mod schedule;
pub mod space;
pub mod summary;
pub(crate) mod writer;
