//! Forces: one file a physical effect, each with its force, its exact tangents and its energy or power.

pub mod air;
pub mod atmosphere;
pub mod axial_flow;
pub mod bar_law;
pub mod base_acceleration;
pub mod canopy;
pub mod cavity;
pub mod curve;
pub mod damped_springs;
pub mod dashpot;
pub mod drag;
pub mod enclosure;
pub mod follower_pressure;
pub mod gravity;
pub mod nodal;
pub mod one_sided;
pub mod rayleigh;
pub mod series;
pub mod slack;
pub mod spring;
pub(in crate::force) mod step_samples;
pub mod stream;
pub(in crate::force) mod stretch;
pub(in crate::force) mod tension;
pub mod triangle;
