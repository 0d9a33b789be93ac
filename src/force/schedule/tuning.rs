//! The sizes that decide speed and nothing else, chosen by the measurements in `docs/performance/tried.md` on nets of
//! 703 to a million nodes. How many steps a block of a small scene has is [`crate::model::step_block::LONGEST`].

/// Nodes of a node block, before their number is rounded, at least: with them the local buffers of a pass fit into a
/// second-level cache of 1 MB, and what lies beyond a node block's end is less than what lies in it.
pub(super) const LEAST_NODES: usize = 2048;

/// The same at most.
pub(super) const MOST_NODES: usize = 2560;

/// Node blocks at least, where these bounds allow: work for many threads.
pub(super) const NODE_BLOCKS_WANTED: usize = 64;

/// Levels of a wavefront at most: what they all work on still fits into a third-level cache.
pub(super) const LEVELS: usize = 8;

/// Seams take a part of all work that is no larger than one in so many: they are gone over when only they are left.
pub(super) const SEAMS: usize = 3;

/// So many seams are gone over side by side, fewer one after the other by all threads.
pub(super) const SEAMS_SIDE_BY_SIDE: usize = 3;

/// Node blocks in a round for each of several threads that share a wavefront, enough that none waits long for another:
/// in one step, and in several, where a cache is to hold those of all levels.
pub(super) const ROUND: [usize; 2] = [4, 2];
