//! The sizes that affect speed only, chosen by the measurements in `docs/performance/tried.md` on nets of 703 to a
//! million nodes. The number of steps in a block of a small scene is [`crate::model::step_block::LONGEST`].

/// Least number of nodes of a node block, before rounding: the local buffers of a pass then fit into a second-level
/// cache of 1 MB, and the halo is smaller than the node block.
pub(super) const LEAST_NODES: usize = 2048;

/// The largest number.
pub(super) const MOST_NODES: usize = 2560;

/// Least number of node blocks, where these bounds allow it: work for many threads.
pub(super) const NODE_BLOCKS_WANTED: usize = 64;

/// Largest number of levels of a wavefront: their data still fit into a third-level cache.
pub(super) const LEVELS: usize = 8;

/// One over the largest share of the work in seams, which are done after the parts.
pub(super) const SEAMS: usize = 3;

/// Number of seams from which on they are done side by side; fewer are done one after the other by all threads.
pub(super) const SEAMS_SIDE_BY_SIDE: usize = 3;

/// Node blocks in a round for each of several threads that share a wavefront, enough that no thread waits long: for one
/// step, and for several, where a cache must hold those of all levels.
pub(super) const ROUND: [usize; 2] = [4, 2];
