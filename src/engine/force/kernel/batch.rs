//! The interface of what a pass over the blocks sums into nodes ([`BlockForces`]), and an implementation for many
//! elements of one kind, one after the other ([`Batch`]). Springs and dashpots have `bar_batch`, triangles that are
//! pushed along their normal `faces`, forces on nodes `nodes`.

use crate::force::Copies;
use crate::force::kernel::element_block::ElementBlock;
pub use crate::force::kernel::element_block::{Elements, SceneNumbers};
pub use crate::force::kernel::local_buffer::Records;
use crate::model::forces::Tally;
use std::ops::Range;
use std::sync::Arc;

/// The local buffers of a block that are read.
#[derive(Clone, Copy, Debug, Default)]
pub struct BufferReads {
    /// positions
    pub x: bool,
    /// velocities
    pub v: bool,
}

impl BufferReads {
    /// What either reads.
    pub(in crate::force) fn or(self, other: BufferReads) -> BufferReads {
        BufferReads { x: self.x | other.x, v: self.v | other.v }
    }
}

/// Parts of a force term at most.
pub const PARTS: usize = 2;

/// Something that is summed into nodes, block after block: every force term.
pub trait BlockForces: Send + Sync {
    /// Number of elements (springs, triangles, nodes) that a pass goes over.
    fn elements(&self) -> usize;

    /// What these of its parts read of the local buffers; what nothing reads is not copied.
    fn reads(&self, parts: [bool; PARTS]) -> BufferReads;

    /// Nodes of an element; `None` beyond the last, and where a pass goes over the nodes themselves. Elements come in
    /// ascending order of their smallest node.
    fn element(&self, number: usize) -> Option<&[u32]> {
        let _ = number;
        None
    }

    /// Hears which elements a block has, and where the records of their nodes begin in its local buffers. Called for
    /// one block after the other; from the first again where a scene is cut anew.
    fn assign_block(&mut self, block: usize, elements: Range<usize>, place: &dyn Fn(u32) -> u16) {
        let _ = (block, elements, place);
    }

    /// Adds its forces [N] to a block's sums: those of the elements it has taken, and those on the block's own nodes;
    /// returns their energies [J] and powers [W]. A term has one part or two ([`crate::force::ForceTerm::parts`]), each
    /// with a sum of its own; a part without a sum is left out.
    fn add(&self, block: &ElementBlock<'_>, sums: [Option<&mut Records>; PARTS]) -> [Tally; PARTS];

    /// The number that its forces depend on and that depends on nodes of the whole scene, if there is one. Its buffers
    /// are then read, positions and velocities.
    fn scene_numbers(&self) -> Option<&dyn SceneNumbers> {
        None
    }

    /// [-] Largest l^2/l0^2 of the springs among a block's elements; -inf where there is none.
    fn largest_stretch(&self, block: &ElementBlock<'_>) -> f64 {
        let _ = block;
        f64::NEG_INFINITY
    }
}

/// The forces of like elements with `N` nodes each.
pub trait Kernel<const N: usize>: Send + Sync {
    /// What it reads of the local buffers.
    const READS: BufferReads;

    /// Node numbers of every element, in ascending order of their smallest.
    fn elements(&self) -> &[[u32; N]];

    /// Adds the forces [N] of a block's elements, or whatever it sums, to its local buffer; returns their energy [J] or
    /// power [W].
    fn add(&self, block: Elements<'_, N>, f: &mut Records) -> Tally;

    /// As [`BlockForces::scene_numbers`].
    fn scene_numbers(&self) -> Option<&dyn SceneNumbers> {
        None
    }

    /// The same with the values that change in a run from `copies`; `None` if it has none, and is shared by all runs.
    fn for_run(&self, copies: &mut Copies) -> Option<Self>
    where
        Self: Sized,
    {
        let _ = copies;
        None
    }
}

/// A kernel, and its elements by blocks.
#[derive(Debug)]
pub struct Batch<K, const N: usize> {
    kernel: Arc<K>,
    placed: Arc<Placed<N>>,
}

/// The elements of all blocks.
#[derive(Clone, Debug, Default)]
struct Placed<const N: usize> {
    /// every element's nodes by where their records begin in the block's local buffers
    local: Vec<[u16; N]>,
    /// elements of every block
    blocks: Vec<Range<usize>>,
}

impl<K: Kernel<N>, const N: usize> Batch<K, N> {
    /// Wraps a kernel; node numbers must be below the number of nodes it will be used with, and elements in ascending
    /// order of their smallest node.
    pub fn new(kernel: K) -> Self {
        Batch { kernel: Arc::new(kernel), placed: Arc::default() }
    }

    /// The kernel.
    pub fn kernel(&self) -> &K {
        &self.kernel
    }

    /// The same elements for another run.
    pub(in crate::force) fn for_run(&self, copies: &mut Copies) -> Self {
        let kernel = self.kernel.for_run(copies).map_or_else(|| self.kernel.clone(), Arc::new);
        Batch { kernel, placed: self.placed.clone() }
    }

    /// A block's elements, if it has any.
    fn elements_of<'a>(&'a self, block: &'a ElementBlock<'_>) -> Option<Elements<'a, N>> {
        let elements = self.placed.blocks.get(block.number).filter(|elements| !elements.is_empty())?;
        let nodes = &self.placed.local[elements.clone()];
        let &ElementBlock { t, x, v, scene_numbers, .. } = block;
        Some(Elements { t, x, v, nodes, first: elements.start, scene_numbers })
    }
}

impl<K: Kernel<N>, const N: usize> BlockForces for Batch<K, N> {
    fn elements(&self) -> usize {
        self.kernel.elements().len()
    }

    fn reads(&self, _: [bool; PARTS]) -> BufferReads {
        K::READS
    }

    fn element(&self, number: usize) -> Option<&[u32]> {
        self.kernel.elements().get(number).map(|nodes| nodes.as_slice())
    }

    fn assign_block(&mut self, block: usize, elements: Range<usize>, place: &dyn Fn(u32) -> u16) {
        let Placed { local, blocks } = Arc::make_mut(&mut self.placed);
        if block == 0 {
            blocks.clear();
            local.clear();
            local.reserve_exact(self.kernel.elements().len());
        }
        local.extend(self.kernel.elements()[elements.clone()].iter().map(|nodes| nodes.map(place)));
        blocks.push(elements);
    }

    fn add(&self, block: &ElementBlock<'_>, [sum, _]: [Option<&mut Records>; PARTS]) -> [Tally; PARTS] {
        let tally = sum.zip(self.elements_of(block)).map(|(f, elements)| self.kernel.add(elements, f));
        [tally.unwrap_or_default(), Tally::default()]
    }

    fn scene_numbers(&self) -> Option<&dyn SceneNumbers> {
        self.kernel.scene_numbers()
    }
}
