//! Dashpots on the whole relative velocity of a spring's ends (thesis Eq. 53 and 68; Kang 2000).
//!
//! ```text
//! force on a = c (vb - va), on b = -c (vb - va)      power = -c |vb - va|^2      -df/dv = c [[I, -I], [-I, I]]
//! ```
//! They also damp rigid rotation, so they are not a material; the thesis uses them with c = k dt.

use super::batch::{BLOCK, Batch, Kernel, Threads, lane_sum};
use super::spring::Coefficient;
use super::{ForceTerm, NodeState, TangentSink};
use crate::model::forces::{Role, Tally};
use crate::model::system::{TermInfo, Weights};
use glam::{DMat3, DVec3};
use std::ops::Range;
use std::sync::Arc;

/// A batch of relative dashpots.
#[derive(Debug)]
pub struct RelativeDashpots(Batch<RelativeData, 2>);

/// Plain arrays of the batch.
#[derive(Clone, Debug)]
pub struct RelativeData {
    /// end nodes
    pub nodes: Arc<[[u32; 2]]>,
    /// [N s/m] c
    pub coefficient: Coefficient,
}

impl RelativeDashpots {
    /// Makes the term.
    pub fn new(data: RelativeData) -> Self {
        RelativeDashpots(Batch::new(data))
    }
}

impl Kernel<2> for RelativeData {
    const SIGNS: [f64; 2] = [1.0, -1.0];

    fn elements(&self) -> &[[u32; 2]] {
        &self.nodes
    }

    fn forces(&self, at: NodeState<'_>, range: Range<usize>, out: &mut [DVec3]) -> Tally {
        let n = range.len();
        let mut buffers = [[0.0; BLOCK]; 2];
        let [c, power] = &mut buffers;
        let (c, power) = (&mut c[..n], &mut power[..n]);
        self.coefficient.fill(range.clone(), c);
        for (((&[a, b], out), c), power) in self.nodes[range].iter().zip(out).zip(c.iter()).zip(power.iter_mut()) {
            let dv = at.v[b as usize] - at.v[a as usize];
            *out = *c * dv;
            *power = -c * dv.length_squared();
        }
        Tally { energy: 0.0, power: lane_sum(power) }
    }
}

impl ForceTerm for RelativeDashpots {
    fn info(&self) -> TermInfo {
        TermInfo { name: "relative dashpots", role: Role::Dissipative }
    }

    fn elements(&self) -> usize {
        self.0.elements()
    }

    fn velocity_dependent(&self) -> bool {
        true
    }

    fn symmetric(&self) -> bool {
        true
    }

    fn add(&self, at: NodeState<'_>, threads: &Threads, f: &mut [DVec3]) -> Tally {
        self.0.add(at, threads, f)
    }

    fn tangent(&self, _at: NodeState<'_>, w: Weights, sink: &mut dyn TangentSink) {
        let data = self.0.kernel();
        for (i, &nodes) in data.nodes.iter().enumerate() {
            sink.edge(nodes, DMat3::from_diagonal(DVec3::splat(w.c * data.coefficient.at(i))));
        }
    }
}
