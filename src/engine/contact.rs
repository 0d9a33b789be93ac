//! Contact: what is near, what touches, and the forces of it.

pub mod distance;
pub mod impact;
pub mod parallel;
