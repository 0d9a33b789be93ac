//! Forces on single nodes: weight, given forces, drag of each node.

use crate::force::kernel::element_block::{ElementBlock, place};
use crate::force::kernel::local_buffer::{PaddedVec3, Records, record, set_record};
use crate::model::quad::{self, Pass, Quad, VectorUnit};
use glam::DVec3;

/// A force on single nodes: a pure function of a node's number, position and velocity.
pub(in crate::force) trait NodeLaw {
    /// Force [N] on node `i`, whose position [m] and velocity [m/s] are vectors of a register, and its energy [J] or
    /// power [W], component by component; `#[inline(always)]`. What stands in the fourth place means nothing.
    fn force<U: VectorUnit>(&self, unit: U, i: usize, x: U::Quad, v: U::Quad) -> [U::Quad; 2];
}

/// Nodes whose energies are summed before they are added to the others: sums of sums lose fewer digits.
const BLOCK: usize = 64;

/// Adds forces [N] on a block's own nodes to its sum; returns their energy [J] or power [W]. The law is asked for those
/// of `nodes`, ascending numbers of the scene's nodes, by their places in this list; for all nodes, by their numbers,
/// if there is no list.
pub(in crate::force) fn add<L: NodeLaw>(
    law: &L,
    nodes: Option<&[u32]>,
    block: &ElementBlock<'_>,
    f: &mut Records,
) -> f64 {
    quad::run(Nodes { law, nodes, block, f })
}

struct Nodes<'a, 'b, L> {
    law: &'a L,
    nodes: Option<&'a [u32]>,
    block: &'a ElementBlock<'b>,
    f: &'a mut Records,
}

impl<L: NodeLaw> Pass for Nodes<'_, '_, L> {
    type Output = f64;

    #[inline(always)]
    fn run<U: VectorUnit>(self, unit: U) -> f64 {
        let Nodes { law, nodes, block, f } = self;
        let own = block.own.clone();
        let before = |node: usize| nodes.map_or(node, |list| list.partition_point(|&i| (i as usize) < node));
        let (mut at, end) = (before(own.start), before(own.end));
        let mut total = 0.0;
        while at < end {
            let next = end.min(at + BLOCK);
            let mut sum = unit.splat(0.0);
            for i in at..next {
                let node = nodes.map_or(i, |list| list[i] as usize);
                let place = place(node - own.start);
                let [x, v] = [unit.quad(record(block.x, place)), unit.quad(record(block.v, place))];
                let [force, amount] = law.force(unit, i, x, v);
                set_record(f, place, (unit.quad(record(f, place)) + force).numbers());
                sum = sum + amount;
            }
            let [x, y, z, _] = sum.numbers();
            total += x + y + z;
            at = next;
        }
        total
    }
}

/// A node's vector and one number more.
#[inline(always)]
pub(in crate::force) fn padded(vectors: &[DVec3], i: usize) -> PaddedVec3 {
    let numbers = bytemuck::cast_slice::<DVec3, f64>(&vectors[i..]);
    numbers.first_chunk().copied().unwrap_or_else(|| [numbers[0], numbers[1], numbers[2], 0.0])
}
