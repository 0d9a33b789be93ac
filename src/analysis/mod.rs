//! What can be said of a scene and a method without running them: fastest rates, largest stable steps.

pub mod limit;
mod oscillator;
pub mod rates;
