//! Batches of two-node elements that act along their edges, in the order in which they are quickest: fans first
//! (`fans`).

use crate::force::kernel::batch::{Summand, Wants};
use crate::force::kernel::coefficient::{Coefficient, Column};
use crate::force::kernel::element_block::Tile;
use crate::force::kernel::local_buffer::Records;
use crate::force::kernel::star_batches::{FAN, FANS, Fans, GROUP, arrange};
use crate::model::forces::Tally;
use crate::model::lanes::LANES;
use std::ops::Range;

/// The forces of two-node elements, for forces of this crate.
pub trait EdgeKernel: Send + Sync {
    /// What it reads of the windows.
    const WANTS: Wants;

    /// End nodes of every element, in ascending order of the smaller.
    fn elements(&self) -> &[[u32; 2]];

    /// Two numbers of every element, as [`EdgeKernel::add`] is to find them in a tile.
    fn numbers(&self) -> [Coefficient; 2];

    /// Adds the forces [N] of a tile's elements, or whatever it sums, to its window; returns their energy [J] or power
    /// [W]. Elements act alike on both ends: which is the first is not kept.
    fn add(&self, tile: Edges<'_>, f: &mut Records) -> Tally;

    /// [-] Largest l^2/l0^2 of a tile's springs; -inf where elements have no rest length.
    fn largest_stretch(&self, tile: Edges<'_>) -> f64 {
        let _ = tile;
        f64::NEG_INFINITY
    }
}

/// A tile's elements.
#[derive(Clone, Copy)]
pub struct Edges<'a> {
    /// [m] positions of the window's nodes, where the kernel wants them
    pub(in crate::force) x: &'a Records,
    /// [m/s] their velocities, where the kernel wants them
    pub(in crate::force) v: &'a Records,
    /// end nodes by where their records begin in the window, those of fans first
    pub(in crate::force) ends: &'a [[u16; 2]],
    /// how many of them are in fans
    in_fans: usize,
    /// two numbers of every element: those in fans, then all others in whole blocks
    numbers: [Column<'a>; 2],
}

impl<'a> Edges<'a> {
    /// The elements in fans, with their numbers.
    pub(in crate::force) fn fans(&self) -> Fans<'a> {
        (self.ends[..self.in_fans].as_chunks().0, self.numbers)
    }

    /// All others.
    pub(in crate::force) fn others(&self) -> (&'a [[u16; 2]], [Column<'a>; 2]) {
        (&self.ends[self.in_fans..], self.numbers.map(|numbers| numbers.from(self.in_fans)))
    }

    /// The second number of every element; none where a kernel has one for all.
    pub(in crate::force) fn second(&self) -> &'a [f64] {
        self.numbers[1].values().get(..self.ends.len()).unwrap_or_default()
    }
}

/// A kernel, and its elements by tiles.
#[derive(Debug)]
pub struct EdgeBatch<K> {
    kernel: K,
    ends: Vec<[u16; 2]>,
    /// by element in the same order, those of every tile in whole blocks; empty where all are the same
    numbers: [Vec<[f64; 4]>; 2],
    uniform: [[[f64; FANS]; FAN]; 2],
    tiles: Vec<Placing>,
}

/// The elements of a tile, and how many are in fans.
#[derive(Clone, Debug)]
struct Placing {
    elements: Range<usize>,
    in_fans: usize,
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
            tiles: Vec::new(),
        }
    }

    /// The kernel.
    pub fn kernel(&self) -> &K {
        &self.kernel
    }

    /// A tile's elements, if it has any.
    fn edges<'a>(&'a self, tile: &'a Tile<'_>) -> Option<Edges<'a>> {
        let Placing { elements, in_fans, numbers } =
            self.tiles.get(tile.number).filter(|placing| !placing.elements.is_empty())?;
        let numbers = std::array::from_fn(|i| match self.numbers[i].get(numbers.clone()) {
            Some(numbers) => Column::each(numbers),
            None => Column::uniform(&self.uniform[i]),
        });
        Some(Edges { x: tile.x, v: tile.v, ends: &self.ends[elements.clone()], in_fans: *in_fans, numbers })
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

    fn take(&mut self, tile: usize, elements: Range<usize>, place: &dyn Fn(u32) -> u16) {
        let (all, of_elements) = (self.kernel.elements(), self.kernel.numbers());
        if tile == 0 {
            self.tiles.clear();
            self.ends.clear();
            self.ends.reserve_exact(all.len());
            for ((numbers, uniform), of_elements) in self.numbers.iter_mut().zip(&mut self.uniform).zip(&of_elements) {
                numbers.clear();
                match of_elements {
                    Coefficient::Uniform(number) => *uniform = [[*number; FANS]; FAN],
                    // Room for what fills up the last block of every tile besides.
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
        let in_fans = GROUP * groups;
        let fours = (in_fans + (order.len() - in_fans).next_multiple_of(LANES)) / 4;
        for (numbers, of_elements) in self.numbers.iter_mut().zip(&of_elements) {
            if let Coefficient::Each(values) = of_elements {
                let value = |i: usize| order.get(i).map_or(0.0, |placed| values[elements.start + placed.element]);
                numbers.extend((0..fours).map(|four| [0, 1, 2, 3].map(|q| value(4 * four + q))));
            }
        }
        let first = self.tiles.last().map_or(0, |last| last.numbers.end);
        self.tiles.push(Placing { elements, in_fans, numbers: first..first + fours });
    }

    fn add(&self, tile: &Tile<'_>, f: &mut Records) -> Tally {
        self.edges(tile).map_or_else(Tally::default, |edges| self.kernel.add(edges, f))
    }

    fn largest_stretch(&self, tile: &Tile<'_>) -> f64 {
        self.edges(tile).map_or(f64::NEG_INFINITY, |edges| self.kernel.largest_stretch(edges))
    }
}

#[cfg(test)]
pub(in crate::force) mod links;
