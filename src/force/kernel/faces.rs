//! Triangles that are pushed along their normal, by blocks.

use crate::force::kernel::batch::{BlockForces, BufferReads, PARTS};
use crate::force::kernel::element_block::ElementBlock;
use crate::force::kernel::local_buffer::Records;
use crate::force::kernel::triangle_pairs::{Group, PressureLaw, PressurePass, arrange};
use crate::model::forces::Tally;
use crate::model::quad;
use std::ops::Range;

/// The forces of triangles, for forces of this crate.
pub trait FaceKernel: Send + Sync {
    /// What it reads of the local buffers.
    const READS: BufferReads;

    /// Nodes of every triangle, in ascending order of their smallest.
    fn elements(&self) -> &[[u32; 3]];

    /// Adds the forces [N] of a block's triangles to its local buffer; returns their energy [J] or power [W]. Which of
    /// a triangle's nodes comes first is not kept, in which sense they go round is.
    fn add(&self, block: Faces<'_>, f: &mut Records) -> Tally;
}

/// A block's triangles.
#[derive(Clone, Copy)]
pub struct Faces<'a> {
    /// [s]
    pub t: f64,
    /// [m] positions of the local buffer's nodes, where the kernel reads them
    pub(in crate::force) x: &'a Records,
    /// [m/s] their velocities, where the kernel reads them
    pub(in crate::force) v: &'a Records,
    /// by where the records of their nodes begin in the local buffer
    groups: &'a [Group],
}

impl Faces<'_> {
    /// Adds the forces [N] of the triangles to the block's sum; returns their power [W].
    pub(in crate::force) fn add_pressure<L: PressureLaw>(self, law: &L, f: &mut Records) -> f64 {
        quad::run(PressurePass { law, groups: self.groups, x: self.x, v: self.v, f })
    }
}

/// A kernel, and its triangles by blocks.
#[derive(Debug)]
pub struct FaceBatch<K> {
    kernel: K,
    groups: Vec<Group>,
    /// groups of every block
    blocks: Vec<Range<usize>>,
}

impl<K: FaceKernel> FaceBatch<K> {
    /// Wraps a kernel; node numbers must be below the number of nodes it will be used with, and triangles in ascending
    /// order of their smallest node.
    pub fn new(kernel: K) -> Self {
        FaceBatch { kernel, groups: Vec::new(), blocks: Vec::new() }
    }

    /// The kernel.
    pub fn kernel(&self) -> &K {
        &self.kernel
    }
}

impl<K: FaceKernel> BlockForces for FaceBatch<K> {
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
        if block == 0 {
            self.groups.clear();
            self.blocks.clear();
        }
        let triangles: Vec<[u16; 3]> = self.kernel.elements()[elements].iter().map(|nodes| nodes.map(place)).collect();
        let first = self.groups.len();
        self.groups.extend(arrange(&triangles));
        self.blocks.push(first..self.groups.len());
    }

    fn add(&self, block: &ElementBlock<'_>, [sum, _]: [Option<&mut Records>; PARTS]) -> [Tally; PARTS] {
        let (Some(f), Some(groups)) = (sum, self.blocks.get(block.number)) else { return Default::default() };
        let faces = Faces { t: block.t, x: block.x, v: block.v, groups: &self.groups[groups.clone()] };
        [self.kernel.add(faces, f), Tally::default()]
    }
}
