//! The run: steps are attempted, accepted or dropped, accounted for and observed.

pub mod observer;
