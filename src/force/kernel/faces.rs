//! Batches of triangles that are pushed along their normal, in the order in which they are quickest: pairs first
//! (`pairs`).

use crate::force::kernel::batch::{Summand, Wants};
use crate::force::kernel::element_block::ElementBlock;
use crate::force::kernel::local_buffer::Records;
use crate::force::kernel::triangle_pairs::{Group, PAIRS, arrange};
use crate::model::forces::Tally;
use std::ops::Range;

/// The forces of triangles, for forces of this crate.
pub trait FaceKernel: Send + Sync {
    /// What it reads of the local buffers.
    const WANTS: Wants;

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
    /// [m] positions of the local buffer's nodes, where the kernel wants them
    pub(in crate::force) x: &'a Records,
    /// [m/s] their velocities, where the kernel wants them
    pub(in crate::force) v: &'a Records,
    /// those in pairs, by where the records of their nodes begin in the local buffer
    pub(in crate::force) pairs: &'a [Group],
    /// all others
    pub(in crate::force) others: &'a [[u16; 3]],
}

/// A kernel, and its triangles by blocks.
#[derive(Debug)]
pub struct FaceBatch<K> {
    kernel: K,
    pairs: Vec<Group>,
    others: Vec<[u16; 3]>,
    blocks: Vec<Placing>,
}

/// The triangles of a block.
#[derive(Clone, Debug)]
struct Placing {
    pairs: Range<usize>,
    others: Range<usize>,
}

impl<K: FaceKernel> FaceBatch<K> {
    /// Wraps a kernel; node numbers must be below the number of nodes it will be used with, and triangles in ascending
    /// order of their smallest node.
    pub fn new(kernel: K) -> Self {
        FaceBatch { kernel, pairs: Vec::new(), others: Vec::new(), blocks: Vec::new() }
    }

    /// The kernel.
    pub fn kernel(&self) -> &K {
        &self.kernel
    }
}

impl<K: FaceKernel> Summand for FaceBatch<K> {
    fn elements(&self) -> usize {
        self.kernel.elements().len()
    }

    fn wants(&self) -> Wants {
        K::WANTS
    }

    fn element(&self, number: usize) -> Option<&[u32]> {
        self.kernel.elements().get(number).map(|nodes| nodes.as_slice())
    }

    fn take(&mut self, block: usize, elements: Range<usize>, place: &dyn Fn(u32) -> u16) {
        if block == 0 {
            self.pairs.clear();
            self.others.clear();
            self.blocks.clear();
            // Nearly all are in pairs.
            self.pairs.reserve_exact(self.kernel.elements().len() / (2 * PAIRS));
        }
        let triangles: Vec<[u16; 3]> = self.kernel.elements()[elements].iter().map(|nodes| nodes.map(place)).collect();
        let (pairs, others) = arrange(&triangles);
        let first = [self.pairs.len(), self.others.len()];
        self.pairs.extend(pairs);
        self.others.extend(others);
        self.blocks.push(Placing { pairs: first[0]..self.pairs.len(), others: first[1]..self.others.len() });
    }

    fn add(&self, block: &ElementBlock<'_>, f: &mut Records) -> Tally {
        let Some(Placing { pairs, others }) = self.blocks.get(block.number) else { return Tally::default() };
        let (pairs, others) = (&self.pairs[pairs.clone()], &self.others[others.clone()]);
        self.kernel.add(Faces { t: block.t, x: block.x, v: block.v, pairs, others }, f)
    }
}
