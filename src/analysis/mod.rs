//! Analysis of a scene and a method without running them: fastest rates, modes, largest stable steps.

mod arnoldi;
pub mod buckling;
mod certificate;
pub mod critical;
mod hessenberg;
mod lanczos;
pub mod later;
pub mod limit;
pub mod lowest;
pub(crate) mod modes;
mod operators;
mod oscillator;
pub mod rates;
pub mod spectrum;
mod step_map;
pub mod taut;
mod vectors;
pub mod warnings;
