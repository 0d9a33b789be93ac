//! Triangles that are pushed along their normal, by blocks.

use crate::force::Copies;
use crate::force::kernel::batch::{BlockForces, BufferReads, PARTS, SceneNumbers};
use crate::force::kernel::element_block::ElementBlock;
use crate::force::kernel::local_buffer::Records;
use crate::force::kernel::triangle_pairs::{Group, GroupFactors, PressureLaw, PressurePass, arrange};
use crate::model::forces::Tally;
use crate::model::quad;
use std::ops::Range;
use std::sync::Arc;

/// The forces of triangles, for forces of this crate.
pub trait FaceKernel: Send + Sync + Sized {
    /// What it reads of the local buffers.
    const READS: BufferReads;

    /// Nodes of every triangle, in ascending order of their smallest.
    fn elements(&self) -> &[[u32; 3]];

    /// Adds the forces [N] of a block's triangles to its local buffer; returns their energy [J] or power [W]. Which of
    /// a triangle's nodes comes first is not kept, in which sense they go round is.
    fn add(&self, block: Faces<'_>, f: &mut Records) -> Tally;

    /// The same with the values that change in a run from `copies`.
    fn for_run(&self, copies: &mut Copies) -> Self;

    /// [-] Factors of the pressures of the triangles, one per triangle; `None` if they are all 1. They apply where the
    /// kernel's law asks for them.
    fn factors(&self) -> Option<&[f64]> {
        None
    }

    /// As [`BlockForces::scene_numbers`].
    fn scene_numbers(&self) -> Option<&dyn SceneNumbers> {
        None
    }
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
    /// [-] factors of their pressures, if the kernel has any
    factors: &'a [GroupFactors],
    /// see [`FaceKernel::scene_numbers`]
    pub scene_numbers: &'a [f64],
}

impl Faces<'_> {
    /// Adds the forces [N] of the triangles to the block's sum; returns their power [W].
    pub(in crate::force) fn add_pressure<L: PressureLaw>(self, law: &L, f: &mut Records) -> f64 {
        quad::run(PressurePass { law, groups: self.groups, factors: self.factors, x: self.x, v: self.v, f })
    }
}

/// A kernel, and its triangles by blocks.
#[derive(Debug)]
pub struct FaceBatch<K> {
    kernel: K,
    placed: Arc<Placed>,
}

/// The triangles of all blocks.
#[derive(Clone, Debug, Default)]
struct Placed {
    groups: Vec<Group>,
    /// of every group, if the kernel has any
    factors: Vec<GroupFactors>,
    /// groups of every block
    blocks: Vec<Range<usize>>,
}

impl<K: FaceKernel> FaceBatch<K> {
    /// Wraps a kernel; node numbers must be below the number of nodes it will be used with, and triangles in ascending
    /// order of their smallest node.
    pub fn new(kernel: K) -> Self {
        FaceBatch { kernel, placed: Arc::default() }
    }

    /// The kernel.
    pub fn kernel(&self) -> &K {
        &self.kernel
    }

    /// The same triangles for another run.
    pub(in crate::force) fn for_run(&self, copies: &mut Copies) -> Self {
        FaceBatch { kernel: self.kernel.for_run(copies), placed: self.placed.clone() }
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
        let placed = Arc::make_mut(&mut self.placed);
        if block == 0 {
            *placed = Placed::default();
        }
        let triangles: Vec<[u16; 3]> =
            self.kernel.elements()[elements.clone()].iter().map(|nodes| nodes.map(place)).collect();
        let first = placed.groups.len();
        let (groups, numbers) = arrange(&triangles);
        placed.groups.extend(groups);
        if let Some(factors) = self.kernel.factors() {
            let factor = |number: Option<u32>| number.map_or(0.0, |number| factors[elements.start + number as usize]);
            placed
                .factors
                .extend(numbers.iter().map(|of_group| [0, 1].map(|half| of_group.map(|pair| factor(pair[half])))));
        }
        placed.blocks.push(first..placed.groups.len());
    }

    fn add(&self, block: &ElementBlock<'_>, [sum, _]: [Option<&mut Records>; PARTS]) -> [Tally; PARTS] {
        let (Some(f), Some(groups)) = (sum, self.placed.blocks.get(block.number)) else { return Default::default() };
        let factors = self.placed.factors.get(groups.clone()).unwrap_or_default();
        let (groups, scene_numbers) = (&self.placed.groups[groups.clone()], block.scene_numbers);
        let faces = Faces { t: block.t, x: block.x, v: block.v, groups, factors, scene_numbers };
        [self.kernel.add(faces, f), Tally::default()]
    }

    fn scene_numbers(&self) -> Option<&dyn SceneNumbers> {
        self.kernel.scene_numbers()
    }
}
