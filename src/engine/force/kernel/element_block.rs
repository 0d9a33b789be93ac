//! A block as kernels see it: the nodes of a run of a scene, in local buffers of records of four numbers (`local
//! buffer`), and the elements that begin there.

use crate::force::kernel::local_buffer::{RECORD, Records, record, set_record};
use nalgebra::Vector3;
use std::ops::Range;

/// A block of the scene.
#[derive(Debug)]
pub struct ElementBlock<'a> {
    /// which one
    pub number: usize,
    /// its own nodes, whose records come first in its local buffers; those that its elements reach beyond follow. Empty
    /// where an earlier block of the node block has them
    pub own: Range<usize>,
    /// [s]
    pub t: f64,
    /// [m] positions of the local buffers' nodes, if some term reads them
    pub x: &'a Records,
    /// [m/s] their velocities, if some term reads them
    pub v: &'a Records,
    /// the term's [`SceneNumbers`]; none for a term without any
    pub scene_numbers: &'a [f64],
}

/// Vectors of all nodes of a scene, by internal number.
#[derive(Clone, Copy)]
pub enum NodeVectors<'a> {
    /// `[n_nodes]`
    Nodes(&'a [Vector3<f64>]),
    /// of a scene that is one block, in its local buffer
    Records(&'a Records),
}

impl NodeVectors<'_> {
    /// The vector of a node.
    #[inline]
    pub fn at(self, node: u32) -> Vector3<f64> {
        match self {
            NodeVectors::Nodes(nodes) => nodes[node as usize],
            NodeVectors::Records(records) => vector(records, place(node as usize)),
        }
    }

    /// The mean over some nodes.
    pub fn mean(self, nodes: &[u32]) -> Vector3<f64> {
        nodes.iter().map(|&node| self.at(node)).sum::<Vector3<f64>>() / nodes.len() as f64
    }
}

/// Scene numbers of a term at most.
pub const MOST_NUMBERS: usize = 37;

/// Values of the scene numbers of a term; one that has fewer leaves the rest 0.
pub type SceneValues = [f64; MOST_NUMBERS];

/// The numbers of a force term that depend on nodes anywhere in the scene, such as the air speed of a canopy. They are
/// found before the term's elements are evaluated, once per pass.
pub trait SceneNumbers: Send + Sync {
    /// How many there are, at most [`MOST_NUMBERS`]. The tangent has a rank-one part for each.
    fn count(&self) -> usize;

    /// Writes the numbers at time `t` [s], positions `x` [m] and velocities `v` [m/s].
    fn find(&self, t: f64, x: NodeVectors<'_>, v: NodeVectors<'_>, out: &mut SceneValues);
}

/// The scene numbers of a pass.
#[derive(Clone, Copy)]
pub(in crate::force) enum PassNumbers<'a> {
    /// by term of the pass, found before it
    Found(&'a [SceneValues]),
    /// of a scene that is one block: found from its local buffers
    InBlock,
}

/// Where the record of one of a block's own nodes begins, counted from the first.
#[inline]
pub(in crate::force) fn place(own: usize) -> u16 {
    (RECORD * own) as u16
}

/// The elements of a block as a kernel sees them.
#[derive(Clone, Copy)]
pub struct Elements<'a, const N: usize> {
    /// [s]
    pub t: f64,
    /// [m] positions of the local buffer's nodes, where the kernel reads them
    pub x: &'a Records,
    /// [m/s] their velocities, where the kernel reads them
    pub v: &'a Records,
    /// every element's nodes, by where their records begin in the local buffer
    pub nodes: &'a [[u16; N]],
    /// number of the first element
    pub first: usize,
    /// see [`SceneNumbers`]
    pub scene_numbers: &'a [f64],
}

impl<const N: usize> Elements<'_, N> {
    /// Numbers of the elements.
    pub fn range(&self) -> Range<usize> {
        self.first..self.first + self.nodes.len()
    }

    /// Adds elements one by one: `element` gives force [N] and energy or power of each from its number and the places
    /// of its nodes, `signs` how it acts on them.
    pub fn each(
        &self,
        signs: [f64; N],
        f: &mut Records,
        mut element: impl FnMut(usize, [u16; N]) -> (Vector3<f64>, f64),
    ) -> f64 {
        let mut sum = 0.0;
        for (&nodes, number) in self.nodes.iter().zip(self.range()) {
            let (force, amount) = element(number, nodes);
            sum += amount;
            for (node, sign) in nodes.into_iter().zip(signs) {
                add(f, node, sign * force);
            }
        }
        sum
    }
}

/// The vector whose record begins at a place.
#[inline(always)]
pub(in crate::force) fn vector(records: &Records, at: u16) -> Vector3<f64> {
    let [x, y, z, _] = record(records, at);
    Vector3::new(x, y, z)
}

/// Adds a force [N] to the record that begins at a place.
#[inline(always)]
pub(in crate::force) fn add(f: &mut Records, at: u16, force: Vector3<f64>) {
    let [x, y, z, _] = record(f, at);
    set_record(f, at, [x + force.x, y + force.y, z + force.z, 0.0]);
}
