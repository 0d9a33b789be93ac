//! Records which elements the terms emit, in order.

use crate::force::TangentSink;
use nalgebra::Matrix3;

/// One emitted element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Emission {
    /// a diagonal block
    Node(u32),
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
    fn node(&mut self, i: u32, _block: Matrix3<f64>) {
        self.emissions.push(Emission::Node(i));
    }

    fn edge(&mut self, nodes: [u32; 2], _block: Matrix3<f64>) {
        self.emissions.push(Emission::Edge(nodes));
    }

    fn pair(&mut self, nodes: [u32; 2], _blocks: &[[Matrix3<f64>; 2]; 2]) {
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
        let mut pairs = |nodes: &[u32]| {
            for &p in nodes {
                for &q in nodes {
                    if !symmetric || p >= q {
                        visit(p, q);
                    }
                }
            }
        };
        match self {
            Emission::Node(i) => pairs(&[i]),
            Emission::Edge(nodes) => pairs(&nodes),
            Emission::Triangle(nodes) => pairs(&nodes),
        }
    }
}
