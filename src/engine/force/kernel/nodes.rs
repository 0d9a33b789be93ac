//! Forces on single nodes: weight, given forces, drag of each node.

use crate::force::kernel::element_block::ElementBlock;
use crate::force::kernel::local_buffer::{PaddedVec3, Records, rows, rows_of};
use crate::model::quad::{self, Pass, Quad, VectorUnit};
use nalgebra::Vector3;

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
        let listed = before(own.start)..before(own.end);
        let number = |i: usize| nodes.map_or(i, |list| list[i] as usize);
        let mut total = 0.0;
        let mut at = listed.start;
        while at < listed.end {
            // A run of nodes that follow each other, if there are several; else one.
            let run = listed.end.min(at + BLOCK);
            let run = if number(run - 1) - number(at) == run - 1 - at { run } else { at + 1 };
            let here = number(at) - own.start..number(at) - own.start + (run - at);
            let (x, v) = (&rows_of(block.x, here.end)[here.clone()], &rows_of(block.v, here.end)[here.clone()]);
            let mut sum = unit.splat(0.0);
            for ((f, (x, v)), i) in rows(f, here.end)[here].iter_mut().zip(x.iter().zip(v)).zip(at..) {
                let [force, amount] = law.force(unit, i, unit.quad(*x), unit.quad(*v));
                *f = (unit.quad(*f) + force).numbers();
                sum = sum + amount;
            }
            let [x, y, z, _] = sum.numbers();
            total += x + y + z;
            at = run;
        }
        total
    }
}

/// Vector `i` and a number that means nothing.
#[inline(always)]
pub(in crate::force) fn padded(vectors: &[Vector3<f64>], i: usize) -> PaddedVec3 {
    let numbers = bytemuck::cast_slice::<Vector3<f64>, f64>(&vectors[i..]);
    numbers.first_chunk().copied().unwrap_or_else(|| [numbers[0], numbers[1], numbers[2], 0.0])
}
