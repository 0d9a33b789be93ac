//! Records which elements the terms emit, in order.

use crate::force::TangentSink;
use nalgebra::Matrix3;

/// One emitted element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Emission {
    /// one block, by its row node and its column node
    Pair([u32; 2]),
    /// a two-node element
    Edge([u32; 2]),
    /// a three-node element
    Triangle([u32; 3]),
}

/// A sink that records elements without their blocks.
#[derive(Clone, Debug, Default)]
pub struct Recorder {
    /// in order of emission
    pub emissions: Vec<Emission>,
}

impl TangentSink for Recorder {
    fn pair(&mut self, nodes: [u32; 2], _block: Matrix3<f64>) {
        self.emissions.push(Emission::Pair(nodes));
    }

    fn edge(&mut self, nodes: [u32; 2], _block: Matrix3<f64>) {
        self.emissions.push(Emission::Edge(nodes));
    }

    fn segment(&mut self, nodes: [u32; 2], _blocks: &[[Matrix3<f64>; 2]; 2]) {
        self.emissions.push(Emission::Edge(nodes));
    }

    fn triangle(&mut self, nodes: [u32; 3], _blocks: &[[Matrix3<f64>; 3]; 3]) {
        self.emissions.push(Emission::Triangle(nodes));
    }
}

impl Emission {
    /// Calls `visit(row node, column node)` for every block of the element, in the order the sink fills them.
    /// Of a symmetric matrix the blocks with row node >= column node only.
    pub(super) fn blocks(self, symmetric: bool, mut visit: impl FnMut(u32, u32)) {
        match self {
            Emission::Pair([i, j]) if !symmetric || i == j => visit(i, j),
            Emission::Pair(_) => {}
            Emission::Edge(nodes) => all_pairs(&nodes, symmetric, visit),
            Emission::Triangle(nodes) => all_pairs(&nodes, symmetric, visit),
        }
    }
}

fn all_pairs(nodes: &[u32], symmetric: bool, mut visit: impl FnMut(u32, u32)) {
    for &p in nodes {
        for &q in nodes {
            if !symmetric || p >= q {
                visit(p, q);
            }
        }
    }
}
