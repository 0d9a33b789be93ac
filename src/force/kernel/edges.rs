//! Batches of two-node elements that act along their edges, in the order in which they are quickest: stars first
//! (`stars`).

use crate::force::kernel::batch::{Summand, Wants};
use crate::force::kernel::coefficient::{Coefficient, Column};
use crate::force::kernel::element_block::ElementBlock;
use crate::force::kernel::local_buffer::Records;
use crate::force::kernel::star_batches::{GROUP, STAR, STARS, StarBatches, arrange};
use crate::model::forces::Tally;
use crate::model::lanes::LANES;
use std::ops::Range;

/// The forces of two-node elements, for forces of this crate.
pub trait EdgeKernel: Send + Sync {
    /// What it reads of the local buffers.
    const WANTS: Wants;

    /// End nodes of every element, in ascending order of the smaller.
    fn elements(&self) -> &[[u32; 2]];

    /// Two numbers of every element, as [`EdgeKernel::add`] is to find them in a block.
    fn numbers(&self) -> [Coefficient; 2];

    /// Adds the forces [N] of a block's elements, or whatever it sums, to its local buffer; returns their energy [J] or
    /// power [W]. Elements act alike on both ends: which is the first is not kept.
    fn add(&self, block: Edges<'_>, f: &mut Records) -> Tally;

    /// [-] Largest l^2/l0^2 of a block's springs; -inf where elements have no rest length.
    fn largest_stretch(&self, block: Edges<'_>) -> f64 {
        let _ = block;
        f64::NEG_INFINITY
    }
}

/// A block's elements.
#[derive(Clone, Copy)]
pub struct Edges<'a> {
    /// [m] positions of the local buffer's nodes, where the kernel wants them
    pub(in crate::force) x: &'a Records,
    /// [m/s] their velocities, where the kernel wants them
    pub(in crate::force) v: &'a Records,
    /// end nodes by where their records begin in the local buffer, those of stars first
    pub(in crate::force) ends: &'a [[u16; 2]],
    /// how many of them are in stars
    in_stars: usize,
    /// two numbers of every element: those in stars, then all others in whole blocks
    numbers: [Column<'a>; 2],
}

impl<'a> Edges<'a> {
    /// The elements in stars, with their numbers.
    pub(in crate::force) fn stars(&self) -> StarBatches<'a> {
        (self.ends[..self.in_stars].as_chunks().0, self.numbers)
    }

    /// All others.
    pub(in crate::force) fn others(&self) -> (&'a [[u16; 2]], [Column<'a>; 2]) {
        (&self.ends[self.in_stars..], self.numbers.map(|numbers| numbers.from(self.in_stars)))
    }

    /// The second number of every element; none where a kernel has one for all.
    pub(in crate::force) fn second(&self) -> &'a [f64] {
        self.numbers[1].values().get(..self.ends.len()).unwrap_or_default()
    }
}

/// A kernel, and its elements by blocks.
#[derive(Debug)]
pub struct EdgeBatch<K> {
    kernel: K,
    ends: Vec<[u16; 2]>,
    /// by element in the same order, those of every block in whole blocks; empty where all are the same
    numbers: [Vec<[f64; 4]>; 2],
    uniform: [[[f64; STARS]; STAR]; 2],
    blocks: Vec<Placing>,
}

/// The elements of a block, and how many are in stars.
#[derive(Clone, Debug)]
struct Placing {
    elements: Range<usize>,
    in_stars: usize,
    /// where their numbers are, by fours
    numbers: Range<usize>,
}

impl<K: EdgeKernel> EdgeBatch<K> {
    /// Wraps a kernel; node numbers must be below the number of nodes it will be used with, and elements in ascending
    /// order of their smaller node.
    pub fn new(kernel: K) -> Self {
        EdgeBatch {
            kernel,
            ends: Vec::new(),
            numbers: Default::default(),
            uniform: Default::default(),
            blocks: Vec::new(),
        }
    }

    /// The kernel.
    pub fn kernel(&self) -> &K {
        &self.kernel
    }

    /// A block's elements, if it has any.
    fn edges<'a>(&'a self, block: &'a ElementBlock<'_>) -> Option<Edges<'a>> {
        let Placing { elements, in_stars, numbers } =
            self.blocks.get(block.number).filter(|placing| !placing.elements.is_empty())?;
        let numbers = std::array::from_fn(|i| match self.numbers[i].get(numbers.clone()) {
            Some(numbers) => Column::each(numbers),
            None => Column::uniform(&self.uniform[i]),
        });
        Some(Edges { x: block.x, v: block.v, ends: &self.ends[elements.clone()], in_stars: *in_stars, numbers })
    }
}

impl<K: EdgeKernel> Summand for EdgeBatch<K> {
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
        let (all, of_elements) = (self.kernel.elements(), self.kernel.numbers());
        if block == 0 {
            self.blocks.clear();
            self.ends.clear();
            self.ends.reserve_exact(all.len());
            for ((numbers, uniform), of_elements) in self.numbers.iter_mut().zip(&mut self.uniform).zip(&of_elements) {
                numbers.clear();
                match of_elements {
                    Coefficient::Uniform(number) => *uniform = [[*number; STARS]; STAR],
                    // Workspace for what fills up the last block of every block besides.
                    Coefficient::Each(_) => numbers.reserve_exact(all.len() / 4 * 65 / 64 + 4),
                }
            }
        }
        let ends: Vec<[u16; 2]> = all[elements.clone()].iter().map(|nodes| nodes.map(place)).collect();
        let (order, groups) = arrange(&ends);
        self.ends.extend(order.iter().map(|placed| {
            let [a, b] = ends[placed.element];
            if placed.turned { [b, a] } else { [a, b] }
        }));
        let in_stars = GROUP * groups;
        let fours = (in_stars + (order.len() - in_stars).next_multiple_of(LANES)) / 4;
        for (numbers, of_elements) in self.numbers.iter_mut().zip(&of_elements) {
            if let Coefficient::Each(values) = of_elements {
                let value = |i: usize| order.get(i).map_or(0.0, |placed| values[elements.start + placed.element]);
                numbers.extend((0..fours).map(|four| [0, 1, 2, 3].map(|q| value(4 * four + q))));
            }
        }
        let first = self.blocks.last().map_or(0, |last| last.numbers.end);
        self.blocks.push(Placing { elements, in_stars, numbers: first..first + fours });
    }

    fn add(&self, block: &ElementBlock<'_>, f: &mut Records) -> Tally {
        self.edges(block).map_or_else(Tally::default, |edges| self.kernel.add(edges, f))
    }

    fn largest_stretch(&self, block: &ElementBlock<'_>) -> f64 {
        self.edges(block).map_or(f64::NEG_INFINITY, |edges| self.kernel.largest_stretch(edges))
    }
}

#[cfg(test)]
pub(in crate::force) mod links;
