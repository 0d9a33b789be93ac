//! `canopy-fem tradeoff`, `sweep` and `require`: what they say is true, and comes to the same however it is made.

mod hyperqueue;
mod models;
pub(crate) mod page;
mod quantities;
mod refusals;
mod require;
mod sample;
mod sharing;
mod sweep;
pub mod table;
mod truth;
mod vary;
