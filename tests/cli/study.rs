//! `canopy-fem tradeoff`: what it says is true, and it comes to the same however it is made.

mod hyperqueue;
mod refusals;
mod sharing;
mod sweep;
mod table;
mod truth;
