//! Sums of a nodal vector's differences to the neighbours of a node, over the two-node elements of a block:
//!
//! ```text
//! f_i += sum_j c_ij (v_j - v_i)
//! ```
//! Every element is gone over at both of its ends: it costs two loads and no store, and less than to add to either end
//! in memory. Nodes of equally many elements follow each other, so that the inner loop has the same length again and
//! again.

use crate::force::kernel::coefficient::Coefficient;
use crate::force::kernel::incidence::Incidence;
use crate::force::kernel::local_buffer::{Records, record, set_record};
use crate::model::quad::{self, Pass, Quad, VectorUnit};
use std::ops::Range;

/// The elements of all blocks, by their ends.
#[derive(Clone, Debug, Default)]
pub(in crate::force) struct Differences {
    /// nodes that have elements, by where their records begin; block after block
    nodes: Vec<u16>,
    /// the other ends of their elements, node after node
    others: Vec<u16>,
    /// c of each of these; empty where all are the same
    numbers: Vec<f64>,
    uniform: f64,
    /// nodes that follow each other and have equally many elements: how many nodes, and how many elements each
    runs: Vec<[u32; 2]>,
    /// places of a block in nodes, others, and runs
    blocks: Vec<[Range<usize>; 3]>,
}

impl Differences {
    /// Takes the elements of the next block, by their ends; the first of them has number `first` in `c`.
    pub(crate) fn assign_block(&mut self, block: usize, ends: &[[u16; 2]], (first, c): (usize, &Coefficient)) {
        if block == 0 {
            *self = Differences::default();
        }
        let starts = [self.nodes.len(), self.others.len(), self.runs.len()];
        let around = Incidence::new(ends);
        let mut nodes: Vec<u16> = around.places().filter(|&node| !around.at(node).is_empty()).collect();
        nodes.sort_by_key(|&node| around.at(node).len());
        for run in nodes.chunk_by(|&a, &b| around.at(a).len() == around.at(b).len()) {
            self.runs.push([run.len() as u32, around.at(run[0]).len() as u32]);
        }
        for &node in &nodes {
            for &element in around.at(node) {
                let [a, b] = ends[element];
                self.others.push(if a == node { b } else { a });
                match c {
                    Coefficient::Uniform(c) => self.uniform = *c,
                    Coefficient::Each(values) => self.numbers.push(values[first + element]),
                }
            }
        }
        self.nodes.append(&mut nodes);
        let ends = [self.nodes.len(), self.others.len(), self.runs.len()];
        self.blocks.push(std::array::from_fn(|i| starts[i]..ends[i]));
    }

    /// Adds the sums of a block to `f`, and returns the sum of f_i . v_i of these.
    pub(crate) fn add(&self, block: usize, v: &Records, f: &mut Records) -> f64 {
        let Some([nodes, others, runs]) = self.blocks.get(block) else { return 0.0 };
        let numbers = self.numbers.get(others.clone()).unwrap_or_default();
        let (nodes, others, runs) =
            (&self.nodes[nodes.clone()], &self.others[others.clone()], &self.runs[runs.clone()]);
        let (uniform, elements) = (self.uniform, Elements { nodes, others, runs });
        match numbers {
            [] => quad::run(DifferencePass { elements, c: uniform, v, f }),
            each => quad::run(DifferencePass { elements, c: each, v, f }),
        }
    }
}

struct Elements<'a> {
    nodes: &'a [u16],
    others: &'a [u16],
    runs: &'a [[u32; 2]],
}

/// Nodes of equally many elements.
struct Node<'a, U: VectorUnit, C> {
    unit: U,
    c: C,
    v: &'a Records,
    /// number of the next element
    first: usize,
    power: U::Quad,
}

impl<U: VectorUnit, C: Factor> Node<'_, U, C> {
    /// Nodes of `N` elements: the loop over these is unrolled.
    #[inline(always)]
    fn run<const N: usize>(&mut self, nodes: &[u16], others: &[u16], f: &mut Records) {
        for (&node, others) in nodes.iter().zip(others.as_chunks::<N>().0) {
            self.node(node, others, f);
        }
    }

    #[inline(always)]
    fn node(&mut self, node: u16, others: &[u16], f: &mut Records) {
        let Node { unit, c, v, .. } = *self;
        let own = unit.quad(record(v, node));
        let mut sum = unit.splat(0.0);
        for (other, i) in others.iter().zip(self.first..) {
            sum = sum + c.of_element(unit, i, unit.quad(record(v, *other)) - own);
        }
        self.first += others.len();
        let force = c.of_sum(unit, sum);
        self.power = self.power + force * own;
        set_record(f, node, (unit.quad(record(f, node)) + force).numbers());
    }
}

/// Coefficients of elements: the same for all, or one each; its functions are `#[inline(always)]`.
trait Factor: Copy {
    /// A difference, times that of element `i` if they have one each.
    fn of_element<U: VectorUnit>(self, unit: U, i: usize, difference: U::Quad) -> U::Quad;

    /// A sum over the elements of a node, times that of all if they have the same.
    fn of_sum<U: VectorUnit>(self, unit: U, sum: U::Quad) -> U::Quad;
}

impl Factor for f64 {
    #[inline(always)]
    fn of_element<U: VectorUnit>(self, _: U, _: usize, difference: U::Quad) -> U::Quad {
        difference
    }

    #[inline(always)]
    fn of_sum<U: VectorUnit>(self, unit: U, sum: U::Quad) -> U::Quad {
        unit.splat(self) * sum
    }
}

impl Factor for &[f64] {
    #[inline(always)]
    fn of_element<U: VectorUnit>(self, unit: U, i: usize, difference: U::Quad) -> U::Quad {
        unit.splat(self[i]) * difference
    }

    #[inline(always)]
    fn of_sum<U: VectorUnit>(self, _: U, sum: U::Quad) -> U::Quad {
        sum
    }
}

struct DifferencePass<'a, C> {
    elements: Elements<'a>,
    c: C,
    v: &'a Records,
    f: &'a mut Records,
}

impl<C: Factor> Pass for DifferencePass<'_, C> {
    type Output = f64;

    #[inline(always)]
    fn run<U: VectorUnit>(self, unit: U) -> f64 {
        let DifferencePass { elements: Elements { nodes, others, runs }, c, v, f } = self;
        let (mut nodes, mut first) = (nodes, 0);
        let mut power = unit.splat(0.0);
        for &[count, elements] in runs {
            let (here, after) = nodes.split_at(count as usize);
            nodes = after;
            let n = elements as usize;
            let others = &others[first..first + here.len() * n];
            let mut of = Node { unit, c, v, first, power };
            match n {
                4 => of.run::<4>(here, others, f),
                5 => of.run::<5>(here, others, f),
                6 => of.run::<6>(here, others, f),
                7 => of.run::<7>(here, others, f),
                _ => here.iter().zip(others.chunks(n)).for_each(|(&node, others)| of.node(node, others, f)),
            }
            power = of.power;
            first += others.len();
        }
        let [x, y, z, _] = power.numbers();
        x + y + z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force::kernel::fixtures::{NODES, elements, random, vectors};
    use crate::force::kernel::local_buffer::{LocalBuffer, rows};
    use crate::model::quad::Portable;

    /// Of two blocks, with the same c for all and with one each: all units have the same bits, and the sums are those
    /// of a plain loop but for its order.
    #[test]
    fn sums_are_those_of_a_plain_loop() {
        for (n, uniform) in [0, 1, 7, 150].into_iter().flat_map(|n| [(n, true), (n, false)]) {
            let (ends, mut v) = (elements::<2>(n, 4), vectors(5));
            let values: Vec<f64> =
                std::iter::repeat_with(random(6)).take(2 * n).map(|c| if uniform { 0.7 } else { c }).collect();
            let c = Coefficient::from_values(&values);
            let (v, mut all) = (&*v.records(), Differences::default());
            for block in 0..2 {
                all.assign_block(block, &ends, (n * block, &c));
            }
            for block in 0..2 {
                let (mut sums, mut power) = (vec![[0.0; 3]; NODES], 0.0);
                for (i, &[a, b]) in ends.iter().enumerate() {
                    let u = [0, 1, 2].map(|k| values[n * block + i] * (record(v, b)[k] - record(v, a)[k]));
                    for (node, sign) in [(a, 1.0), (b, -1.0)] {
                        for k in 0..3 {
                            sums[usize::from(node) / 4][k] += sign * u[k];
                            power += sign * u[k] * record(v, node)[k];
                        }
                    }
                }
                let mut f = LocalBuffer::new(0);
                let found = all.add(block, v, f.records());
                assert!((found - power).abs() < 1e-12 * (1.0 + power.abs()), "{found} for {power}");
                let found = rows(f.records(), NODES).to_vec();
                for (found, sum) in found.iter().zip(&sums) {
                    assert!(
                        (0..3).all(|k| (found[k] - sum[k]).abs() < 1e-13 * (1.0 + sum[k].abs())),
                        "{found:?} for {sum:?}"
                    );
                }
                let [nodes, others, runs] = all.blocks[block].clone();
                let elements =
                    Elements { nodes: &all.nodes[nodes], others: &all.others[others.clone()], runs: &all.runs[runs] };
                let mut portable = LocalBuffer::new(0);
                match &c {
                    Coefficient::Uniform(c) => {
                        DifferencePass { elements, c: *c, v, f: portable.records() }.run(Portable)
                    }
                    Coefficient::Each(_) => {
                        DifferencePass { elements, c: &all.numbers[others], v, f: portable.records() }.run(Portable)
                    }
                };
                assert_eq!(rows(portable.records(), NODES), found);
            }
        }
    }
}
