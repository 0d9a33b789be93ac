//! The simplest elements, for tests of what goes over elements: they add to either end what is at the other, times a
//! weight.

use super::{EdgeBatch, EdgeKernel, Edges};
use crate::force::kernel::batch::{Records, Wants};
use crate::force::kernel::coefficient::Coefficient;
use crate::force::kernel::local_buffer::{record, set_record};
use crate::model::forces::Tally;
use std::sync::Arc;

/// Links by their ends.
pub struct LinkData {
    pub nodes: Arc<[[u32; 2]]>,
    pub weight: f64,
}

/// A batch of links.
pub type Links = EdgeBatch<LinkData>;

impl EdgeKernel for LinkData {
    const WANTS: Wants = Wants { x: true, v: false };

    fn elements(&self) -> &[[u32; 2]] {
        &self.nodes
    }

    fn numbers(&self) -> [Coefficient; 2] {
        [self.weight, 0.0].map(Coefficient::Uniform)
    }

    fn add(&self, block: Edges<'_>, f: &mut Records) -> Tally {
        for &[a, b] in block.ends {
            for (own, other) in [(a, b), (b, a)] {
                let (sum, x) = (record(f, own), record(block.x, other));
                set_record(f, own, std::array::from_fn(|i| sum[i] + self.weight * x[i]));
            }
        }
        Tally::default()
    }
}
