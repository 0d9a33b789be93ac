//! In what order the blocks of a scene are gone over, by which threads, and for how many steps at once.

pub(in crate::force) mod buffer_pool;
pub(in crate::force) mod partition;
pub(in crate::force) mod pass_kind;
pub(in crate::force) mod single_block;
pub(crate) mod step_block;
pub(crate) mod step_boundary;
pub(crate) mod sweep;
pub(crate) mod terms;
pub mod threads;
mod tuning;
pub(in crate::force) mod wavefront;
pub(in crate::force) mod workspace;
