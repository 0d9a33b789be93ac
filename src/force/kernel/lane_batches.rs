//! Kernels in vector registers: eight elements side by side, a chunk of them phase by phase.
//!
//! First every element of a chunk is measured, side by side and independent of the others; where a long chain of roots
//! and quotients follows, it has a phase of its own; then the chunk's forces go to their nodes, one after the other,
//! because elements share nodes. Apart, none waits for the others. All units and threads add the same numbers in the
//! same order.

use crate::force::kernel::batch::Records;
use crate::force::kernel::coefficient::Place;
use crate::model::lanes::{LANES, Lanes};
use crate::model::quad::{Pass, Quad, VectorUnit, run};

/// How elements with `N` nodes are measured, and how their forces go to the nodes. Its functions are
/// `#[inline(always)]`.
pub(in crate::force) trait LaneKernel<const N: usize> {
    /// What is kept of a block between the phases.
    type Kept: Copy + Default;

    /// As many of them as there are blocks in a chunk, an array. A chunk of one leaves it to the processor to measure
    /// the next while the forces of one are added.
    type Chunk: Default + AsMut<[Self::Kept]>;

    /// Measures four elements; returns their energies or powers.
    fn measure<U: VectorUnit>(
        &self,
        unit: U,
        place: Place,
        nodes: &[[u16; N]; LANES],
        kept: &mut Self::Kept,
    ) -> U::Quad;

    /// Goes on with four elements; returns what comes to their energies or powers.
    #[inline(always)]
    fn finish<U: VectorUnit>(&self, unit: U, half: usize, kept: &mut Self::Kept) -> U::Quad {
        let _ = (half, kept);
        unit.splat(0.0)
    }

    /// Adds the forces [N] of a block's first elements to the local buffer.
    fn scatter<U: VectorUnit>(&self, unit: U, nodes: &[[u16; N]], kept: &Self::Kept, f: &mut Records);
}

/// Adds the forces of a block's elements to its local buffer; returns the sum of their energies or powers.
pub(in crate::force) fn add<P: LaneKernel<N>, const N: usize>(phases: P, nodes: &[[u16; N]], f: &mut Records) -> f64 {
    run(Elements { phases, nodes, f })
}

struct Elements<'a, P, const N: usize> {
    phases: P,
    nodes: &'a [[u16; N]],
    f: &'a mut Records,
}

impl<P: LaneKernel<N>, const N: usize> Pass for Elements<'_, P, N> {
    type Output = f64;

    #[inline(always)]
    fn run<U: VectorUnit>(self, unit: U) -> f64 {
        let Elements { phases, nodes, f } = self;
        let (blocks, rest) = nodes.as_chunks();
        let mut chunk = P::Chunk::default();
        let kept = chunk.as_mut();
        let mut sums = [unit.splat(0.0); 2];
        for (blocks, first) in blocks.chunks(kept.len()).zip((0..).step_by(kept.len())) {
            for ((nodes, kept), block) in blocks.iter().zip(&mut *kept).zip(first..) {
                sums[0] = sums[0] + phases.measure(unit, Place { block, half: 0 }, nodes, kept);
                sums[1] = sums[1] + phases.measure(unit, Place { block, half: 1 }, nodes, kept);
            }
            for (_, kept) in blocks.iter().zip(&mut *kept) {
                sums[0] = sums[0] + phases.finish(unit, 0, kept);
                sums[1] = sums[1] + phases.finish(unit, 1, kept);
            }
            for (nodes, kept) in blocks.iter().zip(&*kept) {
                phases.scatter(unit, nodes, kept, f);
            }
        }
        let mut total = Lanes::default();
        total.add(&flat(sums.map(Quad::numbers)));
        if !rest.is_empty() {
            let (mut nodes, mut kept) = ([[0; N]; LANES], P::Kept::default());
            nodes[..rest.len()].copy_from_slice(rest);
            // No `map`: its closure would be compiled for any machine, and every operation in it called.
            let mut amounts = [[0.0; 4]; 2];
            for (half, amounts) in amounts.iter_mut().enumerate() {
                let measured = phases.measure(unit, Place { block: blocks.len(), half }, &nodes, &mut kept);
                *amounts = (measured + phases.finish(unit, half, &mut kept)).numbers();
            }
            phases.scatter(unit, rest, &kept, f);
            flat(amounts)[..rest.len()].iter().for_each(|&amount| total.add(&[amount]));
        }
        total.total()
    }
}

#[inline(always)]
fn flat([[a, b, c, d], [e, f, g, h]]: [[f64; 4]; 2]) -> [f64; LANES] {
    [a, b, c, d, e, f, g, h]
}

#[cfg(test)]
pub(in crate::force) mod tests {
    use super::*;
    use crate::force::kernel::local_buffer::{LocalBuffer, RECORD, rows};
    use crate::model::quad::Portable;

    /// What a force adds to the records of 50 nodes, and its energy or power, in bits.
    pub type Found = (Vec<[u64; 3]>, u64);

    pub const NODES: usize = 50;

    /// Numbers between -1 and 1, always the same.
    pub fn random(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed;
        move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as f64 / f64::from(1u32 << 30) - 1.0
        }
    }

    /// A local buffer with vectors of [`NODES`] nodes; the last two are the same.
    pub fn vectors(seed: u64) -> LocalBuffer {
        let (mut window, mut random) = (LocalBuffer::new(0), random(seed));
        let rows = rows(window.records(), NODES);
        for row in rows.iter_mut() {
            *row = [0; RECORD].map(|_| random());
        }
        rows[NODES - 1] = rows[NODES - 2];
        window
    }

    /// `n` elements between these nodes, some with a node twice; the first is between the two nodes at the same place.
    pub fn elements<const N: usize>(n: usize, seed: u64) -> Vec<[u16; N]> {
        let mut random = random(seed);
        let place = |node: usize| (RECORD * node) as u16;
        let mut all: Vec<[u16; N]> =
            (0..n).map(|_| [0; N].map(|_| place((random().abs() * (NODES - 1) as f64) as usize))).collect();
        if let Some(first) = all.first_mut() {
            *first = std::array::from_fn(|i| place(NODES - 1 - i % 2));
        }
        all
    }

    /// The same elements on this machine's best unit and on any.
    pub fn on_both<P: LaneKernel<N>, const N: usize>(phases: impl Fn() -> P, nodes: &[[u16; N]]) -> [Found; 2] {
        let found = |pass: &dyn Fn(&mut Records) -> f64| {
            let mut f = LocalBuffer::new(0);
            let sum = pass(f.records());
            let bits = |r: &mut [f64; RECORD]| [r[0].to_bits(), r[1].to_bits(), r[2].to_bits()];
            (rows(f.records(), NODES).iter_mut().map(bits).collect(), sum.to_bits())
        };
        [found(&|f| add(phases(), nodes, f)), found(&|f| Elements { phases: phases(), nodes, f }.run(Portable))]
    }
}
