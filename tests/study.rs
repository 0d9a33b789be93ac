//! `canopy-fem tradeoff`: what it says is true, and it comes to the same however it is made.

#[path = "cli/bench.rs"]
#[allow(dead_code)] // this binary uses its own part
mod bench;
mod common;
#[path = "study/hyperqueue.rs"]
mod hyperqueue;
#[path = "support/read_vtu.rs"]
#[allow(dead_code)]
mod read_vtu;
#[path = "study/refusals.rs"]
mod refusals;
#[path = "study/sharing.rs"]
mod sharing;
#[path = "study/sweep.rs"]
mod sweep;
#[path = "study/table.rs"]
mod table;
#[path = "study/truth.rs"]
mod truth;
