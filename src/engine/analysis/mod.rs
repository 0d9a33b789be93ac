//! Analysis of a scene and a method without running them: fastest rates, modes, largest stable steps.

mod arnoldi;
pub mod buckling;
mod certificate;
pub mod cloth;
pub mod contact;
pub mod critical;
pub mod growing;
mod hessenberg;
mod krylov;
mod lanczos;
pub mod later;
pub mod limit;
mod low_mode;
pub mod lowest;
pub mod modes;
mod operators;
mod oscillator;
pub(crate) mod pencil;
pub mod rates;
pub mod spectrum;
mod step_map;
pub mod taut;
mod vectors;
pub mod warnings;
