//! Results: a ParaView time series ([`FrameFormat`](crate::vtk::FrameFormat)), `history.csv`, `probes.csv`,
//! `gauges.csv` and `summary.json` in one folder.
//!
//! The integrating thread only copies numbers into reused buffers ([`recorder`]). One background thread (`writer`)
//! formats and writes them (`files`). So a slow disk costs memory for a few frames and then time, but no row is lost or
//! incomplete. An error of that thread is returned as an [`ObserveError`](crate::drive::observer::ObserveError) at the
//! next send and at the end.
//!
//! Whenever the program is killed, the files in the folder can be read (a csv file may end within a line). The newest
//! [`checkpoint`] counts only results that are on the disk: `--resume` cuts off the rest and continues.

pub mod at_rest;
pub mod atomic;
pub mod canopy_doubts;
pub mod checkpoint;
pub mod crossings;
pub mod csv;
pub mod files;
pub mod folder;
pub mod frame;
mod frame_arrays;
pub(crate) mod frame_files;
pub mod gauge_rows;
pub mod gauges;
pub mod hermite;
pub mod largest;
pub mod live;
pub mod modes;
pub(crate) mod pvd;
pub mod quantity;
pub mod recorder;
mod request;
pub mod resume;
pub mod rows;
pub mod samples;
pub mod sanitize;
pub mod schedule;
mod series;
pub mod space;
pub mod stages;
pub mod statistics;
pub mod summary;
pub mod tables;
mod thinned;
pub mod writer;
