//! What can be said of a scene and a method without running them: fastest rates, largest stable steps.

mod arnoldi;
pub mod buckling;
mod certificate;
pub mod critical;
mod hessenberg;
mod lanczos;
pub mod limit;
pub(crate) mod linearised;
mod matrices;
mod motions;
mod oscillator;
pub mod rates;
mod shape;
mod step_map;
pub mod warnings;

pub(crate) use linearised::rough;
