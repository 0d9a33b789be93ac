//! `canopy-fem tradeoff` and `sweep`: what they say is true, and comes to the same however it is made.

mod hyperqueue;
mod models;
mod page;
mod quantities;
mod refusals;
mod sharing;
mod sweep;
pub mod table;
mod truth;
mod vary;
