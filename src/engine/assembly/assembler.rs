//! Assembly of W: the slot of every entry of every block is found once.

use super::pattern::{Pattern, PatternError};
use super::record::Recorder;
use crate::contact::near::Candidate;
use crate::force::TangentSink;
use crate::mesh::adjacency::row_starts;
use crate::model::workers::Workers;
use nalgebra::Matrix3;
use std::sync::Arc;

/// Marks a fixed degree of freedom.
const FIXED: u32 = u32::MAX;

/// W: pattern, values, and where each emitted block goes.
#[derive(Clone, Debug)]
pub struct Assembler {
    /// the pattern, shared with the linear solver
    pub pattern: Arc<Pattern>,
    /// entries of W in the order of the pattern
    values: Vec<f64>,
    /// slots of every distinct node-pair block; the first has none
    blocks: Vec<BlockSlots>,
    /// block of every emitted node pair, in order of emission
    emitted: Vec<u32>,
    /// slot of the diagonal entry of every unknown
    diagonal: Vec<u32>,
    /// pairs that may touch, whose blocks come last
    pub near: Arc<[Candidate]>,
}

/// Where the entries of a 3 x 3 block go.
#[derive(Clone, Copy, Debug, Default)]
struct BlockSlots {
    /// slot of the first stored entry of every column; the others follow
    first: [u32; 3],
    /// which entries are stored, those with row r and column c in bit 3 c + r
    stored: u16,
}

/// [`BlockSlots::stored`] of a block beside the diagonal none of whose components is fixed.
const WHOLE: u16 = 0x1ff;

impl BlockSlots {
    #[inline]
    fn add(&self, block: &Matrix3<f64>, values: &mut [f64]) {
        let columns = self.first.iter().zip(block.as_slice().chunks_exact(3));
        if self.stored == WHOLE {
            for (&first, column) in columns {
                let slots = &mut values[first as usize..first as usize + 3];
                slots.iter_mut().zip(column).for_each(|(slot, entry)| *slot += entry);
            }
            return;
        }
        for (c, (&first, column)) in columns.enumerate() {
            let stored = column.iter().enumerate().filter(|(r, _)| self.stored >> (3 * c + r) & 1 == 1);
            values[first as usize..].iter_mut().zip(stored).for_each(|(slot, (_, entry))| *slot += entry);
        }
    }
}

/// Positions of the nodes, and which of their degrees of freedom are fixed.
#[derive(Clone, Copy, Debug)]
pub struct Nodes<'a> {
    /// [m] positions
    pub position: &'a [[f64; 3]],
    /// whether each of x, y, z is fixed
    pub fixed: &'a [[bool; 3]],
}

impl Assembler {
    /// Builds pattern and slots from the emitted elements, on up to two threads of `workers`. Every free degree of
    /// freedom gets a diagonal entry (its mass).
    ///
    /// # Errors
    /// When W would have more entries than 32 bits can number.
    pub fn new(
        nodes: Nodes<'_>,
        recorder: &Recorder,
        symmetric: bool,
        workers: &Workers,
    ) -> Result<Self, PatternError> {
        let pairs = distinct_pairs(nodes, recorder, symmetric);
        let unknown = number_unknowns(nodes.fixed);
        let nonzeros: usize = pairs.iter().map(|&p| block_entries(p, &unknown, symmetric)).sum();
        if nonzeros >= u32::MAX as usize {
            return Err(PatternError::TooLarge { nonzeros });
        }
        let lay_out = || {
            let pattern = build_pattern(nodes, &pairs, &unknown, symmetric);
            let mut blocks = Vec::with_capacity(pairs.len() + 1);
            blocks.push(BlockSlots::default());
            for column in pairs.chunk_by(|a, b| a.0 == b.0) {
                add_slots(&pattern, column, &unknown, &mut blocks);
            }
            (pattern, blocks)
        };
        let number = || blocks_of(recorder, &pairs, nodes.fixed.len(), symmetric);
        let ((pattern, blocks), emitted) = workers.join(lay_out, number);
        let diagonal = (0..pattern.n() as u32).filter_map(|i| pattern.slot(i, i)).collect();
        let values = vec![0.0; pattern.nonzeros()];
        Ok(Assembler { pattern: Arc::new(pattern), values, blocks, emitted, diagonal, near: Arc::default() })
    }

    /// A full matrix over unknowns without nodes (a pendulum has one).
    pub fn dense(n: u32) -> Self {
        let pattern = Pattern {
            col_ptr: (0..=n).map(|j| j * n).collect(),
            row_idx: (0..n).flat_map(|_| 0..n).collect(),
            symmetric: false,
            dof: (0..n).collect(),
            node_start: (0..=n).collect(),
            position: vec![[0.0; 3]; n as usize],
        };
        let values = vec![0.0; pattern.nonzeros()];
        let diagonal = (0..n).map(|i| i * n + i).collect();
        Assembler {
            pattern: Arc::new(pattern),
            values,
            blocks: Vec::new(),
            emitted: Vec::new(),
            diagonal,
            near: Arc::default(),
        }
    }

    /// Entries of W in the order of the pattern.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The same, writable (a system without nodes fills them itself).
    pub fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    /// Number of element blocks that an assembly adds up.
    pub fn blocks(&self) -> usize {
        self.emitted.len()
    }

    /// Clears W, adds `mass(dof)` [kg, times its weight] to the diagonal, and returns the sink for the terms.
    pub fn sink(&mut self, mass: impl Fn(usize) -> f64) -> MatrixSink<'_> {
        self.values.fill(0.0);
        for (&slot, &dof) in self.diagonal.iter().zip(&self.pattern.dof) {
            self.values[slot as usize] = mass(dof as usize);
        }
        MatrixSink {
            values: &mut self.values,
            blocks: &self.blocks,
            emitted: self.emitted.iter(),
            symmetric: self.pattern.symmetric,
        }
    }
}

/// Adds blocks to the values of W. The terms must emit the elements that the recorder saw, in the same order.
#[derive(Debug)]
pub struct MatrixSink<'a> {
    values: &'a mut [f64],
    blocks: &'a [BlockSlots],
    emitted: std::slice::Iter<'a, u32>,
    symmetric: bool,
}

impl MatrixSink<'_> {
    #[inline]
    fn add(&mut self, block: &Matrix3<f64>) {
        let Some(&id) = self.emitted.next() else {
            debug_assert!(false, "a force term emitted more elements than when the pattern was recorded");
            return;
        };
        self.blocks[id as usize].add(block, self.values);
    }
}

impl MatrixSink<'_> {
    /// An element with any blocks.
    fn element<const N: usize>(&mut self, nodes: [u32; N], blocks: &[[Matrix3<f64>; N]; N]) {
        for (p, row) in nodes.iter().zip(blocks) {
            for (q, block) in nodes.iter().zip(row) {
                if !self.symmetric || p >= q {
                    self.add(block);
                }
            }
        }
    }
}

impl TangentSink for MatrixSink<'_> {
    fn pair(&mut self, [i, j]: [u32; 2], block: Matrix3<f64>) {
        if !self.symmetric || i == j {
            self.add(&block);
        }
    }

    #[inline]
    fn edge(&mut self, [a, b]: [u32; 2], block: Matrix3<f64>) {
        let minus = -block;
        // The order of `Emission::blocks`: (a, a), (a, b), (b, a), (b, b), lower triangle only if symmetric.
        self.add(&block);
        if !self.symmetric || a >= b {
            self.add(&minus);
        }
        if !self.symmetric || b >= a {
            self.add(&minus);
        }
        self.add(&block);
    }

    fn segment(&mut self, nodes: [u32; 2], blocks: &[[Matrix3<f64>; 2]; 2]) {
        self.element(nodes, blocks);
    }

    fn triangle(&mut self, nodes: [u32; 3], blocks: &[[Matrix3<f64>; 3]; 3]) {
        self.element(nodes, blocks);
    }

    fn none(&mut self, nodes: &[u32]) {
        let pairs = nodes.iter().flat_map(|p| nodes.iter().map(move |q| (p, q)));
        let blocks = pairs.filter(|(p, q)| !self.symmetric || p >= q).count();
        self.emitted = self.emitted.as_slice().get(blocks..).unwrap_or_default().iter();
    }

    fn few(&mut self, nodes: &[u32], blocks: &[[Matrix3<f64>; 4]; 4]) {
        for (p, row) in nodes.iter().zip(blocks) {
            for (q, block) in nodes.iter().zip(row) {
                if !self.symmetric || p >= q {
                    self.add(block);
                }
            }
        }
    }
}

/// Distinct (column node, row node) pairs between nodes with free degrees of freedom, ascending; diagonals always.
fn distinct_pairs(nodes: Nodes<'_>, recorder: &Recorder, symmetric: bool) -> Vec<(u32, u32)> {
    let free = |i: u32| nodes.fixed[i as usize] != [true; 3];
    let mut pairs: Vec<(u32, u32)> = (0..nodes.fixed.len() as u32).filter(|&i| free(i)).map(|i| (i, i)).collect();
    recorder.blocks(symmetric, |p, q| {
        if p != q && free(p) && free(q) {
            pairs.push((q, p));
        }
    });
    pairs.sort_unstable();
    pairs.dedup();
    pairs.shrink_to_fit();
    pairs
}

fn number_unknowns(fixed: &[[bool; 3]]) -> Vec<[u32; 3]> {
    let mut next = 0;
    let mut number = |held: bool| {
        if held {
            return FIXED;
        }
        next += 1;
        next - 1
    };
    fixed.iter().map(|f| f.map(&mut number)).collect()
}

fn block_entries((j, i): (u32, u32), unknown: &[[u32; 3]], symmetric: bool) -> usize {
    let free = |node: u32| unknown[node as usize].iter().filter(|&&u| u != FIXED).count();
    if symmetric && i == j { free(i) * (free(i) + 1) / 2 } else { free(i) * free(j) }
}

fn build_pattern(nodes: Nodes<'_>, pairs: &[(u32, u32)], unknown: &[[u32; 3]], symmetric: bool) -> Pattern {
    let mut p = Pattern { symmetric, col_ptr: vec![0], node_start: vec![0], ..Pattern::default() };
    for column in pairs.chunk_by(|a, b| a.0 == b.0) {
        let j = column[0].0 as usize;
        for (c, &u) in unknown[j].iter().enumerate().filter(|&(_, &u)| u != FIXED) {
            for &(_, i) in column {
                let rows = unknown[i as usize].iter().copied().filter(|&r| r != FIXED && (!symmetric || r >= u));
                p.row_idx.extend(rows);
            }
            p.col_ptr.push(p.row_idx.len() as u32);
            p.dof.push((3 * j + c) as u32);
        }
        p.node_start.push(p.dof.len() as u32);
        p.position.push(nodes.position[j]);
    }
    p.row_idx.shrink_to_fit();
    p
}

/// Appends the slots of every block in a column of blocks. What is fixed or in the upper triangle has none.
fn add_slots(pattern: &Pattern, column: &[(u32, u32)], unknown: &[[u32; 3]], blocks: &mut Vec<BlockSlots>) {
    let columns = unknown[column[0].0 as usize];
    // The blocks' rows follow each other in a column, so the next free slot of each is where a block's entries go.
    let mut next = columns.map(|j| if j == FIXED { 0 } else { pattern.col_ptr[j as usize] });
    for &(_, i) in column {
        let mut slots = BlockSlots { first: next, stored: 0 };
        for (c, (&j, next)) in columns.iter().zip(&mut next).enumerate().filter(|(_, (j, _))| **j != FIXED) {
            for (r, &row) in unknown[i as usize].iter().enumerate() {
                if row != FIXED && (!pattern.symmetric || row >= j) {
                    slots.stored |= 1 << (3 * c + r);
                    *next += 1;
                }
            }
        }
        blocks.push(slots);
    }
}

/// Number of the block of every emitted pair of nodes, in the order of emission: 0 for those that are eliminated.
fn blocks_of(recorder: &Recorder, pairs: &[(u32, u32)], nodes: usize, symmetric: bool) -> Vec<u32> {
    let start = row_starts(nodes, pairs.iter().map(|&(j, _)| j));
    let mut emitted = Vec::new();
    recorder.blocks(symmetric, |i, j| {
        let first = start[j as usize];
        let column = &pairs[first as usize..start[j as usize + 1] as usize];
        emitted.push(column.binary_search(&(j, i)).map_or(0, |at| first + at as u32 + 1));
    });
    emitted.shrink_to_fit();
    emitted
}
