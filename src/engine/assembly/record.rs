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
    /// a four-node element, by its place among these
    Four(u32),
}

/// A sink that records elements without their blocks.
#[derive(Clone, Debug, Default)]
pub struct Recorder {
    /// in order of emission
    pub emissions: Vec<Emission>,
    /// nodes of the four-node elements
    fours: Vec<[u32; 4]>,
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

    fn few(&mut self, nodes: &[u32], _blocks: &[[Matrix3<f64>; 4]; 4]) {
        self.emissions.push(match *nodes {
            [i] => Emission::Pair([i; 2]),
            [a, b] => Emission::Edge([a, b]),
            [a, b, c] => Emission::Triangle([a, b, c]),
            [a, b, c, d, ..] => {
                self.fours.push([a, b, c, d]);
                Emission::Four(self.fours.len() as u32 - 1)
            }
            [] => return,
        });
    }
}

impl Recorder {
    /// Calls `visit(row node, column node)` for every block of all elements, in the order the sink fills them. Of a
    /// symmetric matrix the blocks with row node >= column node only.
    pub(super) fn blocks(&self, symmetric: bool, mut visit: impl FnMut(u32, u32)) {
        for emission in &self.emissions {
            match emission {
                Emission::Pair([i, j]) if !symmetric || i == j => visit(*i, *j),
                Emission::Pair(_) => {}
                Emission::Edge(nodes) => all_pairs(nodes, symmetric, &mut visit),
                Emission::Triangle(nodes) => all_pairs(nodes, symmetric, &mut visit),
                Emission::Four(place) => all_pairs(&self.fours[*place as usize], symmetric, &mut visit),
            }
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
