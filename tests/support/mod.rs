//! A made-up scene, and a reader of .vtu files that shares no code with the writer.

pub mod read_vtu;
pub mod triangle_pair;
