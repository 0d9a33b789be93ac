//! Time integration schemes.

pub mod registry;
