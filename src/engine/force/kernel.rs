//! Loops over elements of one shape in the local buffers of a block, four side by side; they know no scene.

pub(in crate::force) mod bar_batch;
pub mod batch;
pub mod coefficient;
pub mod cut;
pub(in crate::force) mod differences;
pub mod element_block;
pub mod faces;
#[cfg(test)]
pub(in crate::force) mod fixtures;
pub(in crate::force) mod incidence;
pub mod local_buffer;
pub mod neighbours;
pub(in crate::force) mod nodes;
pub(in crate::force) mod sheet_batches;
pub(in crate::force) mod star_batches;
pub(in crate::force) mod triangle_pairs;
