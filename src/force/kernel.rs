//! Loops over elements of one shape in the local buffers of a block, four or eight side by side; they know no scene.

pub(in crate::force) mod axial_kernel;
pub mod batch;
pub mod coefficient;
pub mod edges;
pub mod element_block;
pub mod faces;
pub(in crate::force) mod incidence;
pub(in crate::force) mod lane_batches;
pub mod local_buffer;
pub mod neighbours;
pub(in crate::force) mod pressure_kernel;
pub(in crate::force) mod star_batches;
pub(in crate::force) mod triangle_pairs;
