//! Two-node elements by blocks, in the order in which they are quickest ([`crate::force::kernel::star_batches`]).

use crate::force::kernel::coefficient::{Coefficient, Column, STAR, STARS};
use crate::force::kernel::cut::Cut;
use crate::force::kernel::element_block::ElementBlock;
use crate::force::kernel::local_buffer::{Records, record, set_record};
use crate::force::kernel::star_batches::{AxialLaw, Group, Stars, arrange};
use crate::model::quad;
use std::ops::Range;

/// Elements by fours that are copied at once where some have broken.
const AT_ONCE: usize = 32;

/// The elements of all blocks, with three numbers each.
#[derive(Clone, Debug, Default)]
pub(in crate::force) struct BarBatch {
    /// ends by where their records begin, block after block: groups of stars of three, then groups of stars of one,
    /// the last of them filled up with elements between a node and itself
    ends: Vec<[u16; 2]>,
    /// numbers in the same order; empty where all are the same
    numbers: [Vec<[f64; STARS]>; 3],
    uniform: [[[f64; STARS]; STAR]; 3],
    /// the element at every place; none where groups are filled up
    elements: Vec<Option<u32>>,
    blocks: Vec<BlockBars>,
}

/// The elements of a block.
#[derive(Clone, Debug)]
struct BlockBars {
    /// all of them, by fours
    quads: Range<usize>,
    /// how many of these are in stars of three
    in_stars: usize,
    /// their numbers
    springs: Range<usize>,
}

/// A block's elements.
#[derive(Clone, Copy)]
pub(in crate::force) struct Bars<'a> {
    /// ends by where their records begin, and three numbers of each; the same order
    pub ends: &'a [[u16; 2]],
    numbers: [Column<'a>; 3],
    /// by fours
    in_stars: usize,
    /// the element at every place, and which of them carry nothing, where some have broken
    broken: Option<(&'a [[Option<u32>; STARS]], &'a Cut)>,
}

impl BarBatch {
    /// Takes the elements of the next block, by their ends and numbers.
    pub(crate) fn assign_block(&mut self, block: usize, ends: Vec<[u16; 2]>, (first, all): (usize, &[Coefficient; 3])) {
        if block == 0 {
            *self = BarBatch::default();
            for (uniform, numbers) in self.uniform.iter_mut().zip(all) {
                if let Coefficient::Uniform(number) = numbers {
                    *uniform = [[*number; STARS]; STAR];
                }
            }
        }
        let springs = first..first + ends.len();
        let (order, groups) = arrange(&ends);
        let start = self.ends.len();
        self.ends.extend(order.iter().map(|placed| {
            let [a, b] = ends[placed.element];
            if placed.turned { [b, a] } else { [a, b] }
        }));
        let padded = start + order.len().next_multiple_of(STARS);
        if let Some(&[a, _]) = self.ends[start..].last() {
            self.ends.resize(padded, [a, a]);
        }
        self.elements.extend(order.iter().map(|placed| Some((first + placed.element) as u32)));
        self.elements.resize(padded, None);
        let (places, _) = self.elements[start..].as_chunks();
        for (numbers, all) in self.numbers.iter_mut().zip(all) {
            if let Coefficient::Each(values) = all {
                numbers.extend(numbers_at(places, values));
            }
        }
        self.blocks.push(BlockBars { quads: start / STARS..padded / STARS, in_stars: STAR * groups, springs });
    }

    /// Replaces one of the three numbers, which every element has its own of.
    pub(crate) fn set_number(&mut self, which: usize, values: &[f64]) {
        let places = self.elements.as_chunks().0;
        self.numbers[which].iter_mut().zip(numbers_at(places, values)).for_each(|(to, value)| *to = value);
    }

    /// A block's elements, if it has any that are not all cut.
    pub(crate) fn bars<'a>(&'a self, block: usize, cut: &'a Cut) -> Option<Bars<'a>> {
        let BlockBars { quads, in_stars, springs } = self.blocks.get(block).filter(|of| !of.quads.is_empty())?;
        if cut.all() {
            return None;
        }
        let numbers = std::array::from_fn(|i| match self.numbers[i].get(quads.clone()) {
            Some(numbers) => Column::each(numbers),
            None => Column::uniform(&self.uniform[i]),
        });
        let at = || (&self.elements.as_chunks().0[quads.clone()], cut);
        let broken = cut.some_broken_in(springs.clone()).then(at);
        Some(Bars { ends: &self.ends[STARS * quads.start..STARS * quads.end], numbers, in_stars: *in_stars, broken })
    }

    /// One of the three numbers of a block's elements; none where all are the same.
    pub(crate) fn each_number(&self, block: usize, which: usize) -> &[f64] {
        let quads = self.blocks.get(block).map_or(0..0, |placing| placing.quads.clone());
        self.numbers[which].get(quads).unwrap_or_default().as_flattened()
    }
}

/// Values of the elements at these places, 0 where there is none.
fn numbers_at(places: &[[Option<u32>; STARS]], values: &[f64]) -> impl Iterator<Item = [f64; STARS]> {
    places.iter().map(|places| places.map(|place| place.map_or(0.0, |element| values[element as usize])))
}

/// Adds the elastic and the damping forces of elements to sums.
type AddForces<'a> = dyn FnMut(Bars<'_>, [Option<&mut Records>; 2]) -> [f64; 2] + 'a;

impl Bars<'_> {
    /// Whether some of them have broken.
    pub(crate) fn some_broken(&self) -> bool {
        self.broken.is_some()
    }

    /// Adds elastic and damping forces [N] to a block's sums; returns the elastic energy [J] and the power of damping
    /// [W].
    pub(crate) fn axial_force<L: AxialLaw>(
        self,
        law: &L,
        block: &ElementBlock<'_>,
        sums: [Option<&mut Records>; 2],
    ) -> [f64; 2] {
        self.without_broken(sums, &mut |Bars { ends, numbers, in_stars, .. }, mut sums| {
            let (stars, others) = ends.as_chunks::<STARS>().0.split_at(in_stars);
            let (x, v) = (block.x, block.v);
            let full: &[Group<STAR>] = stars.as_chunks().0;
            let single: &[Group<1>] = others.as_chunks().0;
            let of_stars = quad::run(Stars {
                law,
                groups: full,
                numbers,
                x,
                v,
                sums: sums.each_mut().map(|sum| sum.as_deref_mut()),
            });
            let numbers = numbers.map(|column| column.after(in_stars));
            let of_others = quad::run(Stars { law, groups: single, numbers, x, v, sums });
            [of_stars[0] + of_others[0], of_stars[1] + of_others[1]]
        })
    }

    /// Calls `add`, which adds forces to sums, with those that have not broken; returns the sums of what it returns.
    fn without_broken(self, mut sums: [Option<&mut Records>; 2], add: &mut AddForces<'_>) -> [f64; 2] {
        if self.broken.is_none() {
            return add(self, sums);
        }
        let (quads, mut total) = (self.ends.len() / STARS, [0.0; 2]);
        for first in (0..quads).step_by(AT_ONCE) {
            let count = AT_ONCE.min(quads - first);
            let (mut ends, mut numbers) = ([[[0; 2]; STARS]; AT_ONCE], [[[0.0; STARS]; AT_ONCE]; 3]);
            for (i, ends) in ends[..count].iter_mut().enumerate() {
                let of_quad;
                (*ends, of_quad) = self.quad(first + i);
                numbers.iter_mut().zip(of_quad).for_each(|(to, numbers)| to[i] = numbers);
            }
            let numbers = numbers.each_ref().map(|column| Column::each(&column[..count]));
            let copied = Bars { ends: ends[..count].as_flattened(), numbers, in_stars: 0, broken: None };
            let added = add(copied, sums.each_mut().map(|sum| sum.as_deref_mut()));
            total.iter_mut().zip(added).for_each(|(total, one)| *total += one);
        }
        total
    }

    /// Four elements with their numbers. Those that have broken act between a node and itself, as those do that fill
    /// groups up.
    fn quad(&self, quad: usize) -> ([[u16; 2]; STARS], [[f64; STARS]; 3]) {
        let mut ends = self.ends.as_chunks().0[quad];
        let mut numbers = self.numbers.map(|column| column.group::<1>(quad)[0]);
        for (q, [a, b]) in ends.iter_mut().enumerate() {
            if self.is_broken(STARS * quad + q) {
                *b = *a;
                numbers.iter_mut().for_each(|numbers| numbers[q] = 0.0);
            }
        }
        (ends, numbers)
    }

    /// Whether the element at a place has broken.
    pub(crate) fn is_broken(&self, place: usize) -> bool {
        let Some((elements, cut)) = self.broken else { return false };
        elements.as_flattened()[place].is_some_and(|element| cut.is_cut(element as usize))
    }

    /// Adds c (v_b - v_a) to the sums at a, the opposite at b, for those that have not broken; c is the third number.
    /// Returns the power of these forces [W].
    pub(crate) fn differences(&self, v: &Records, f: &mut Records) -> f64 {
        let mut power = 0.0;
        for (ends, [_, _, c]) in (0..self.ends.len() / STARS).map(|quad| self.quad(quad)) {
            for ([a, b], c) in ends.into_iter().zip(c) {
                let (of_a, of_b) = (record(v, a), record(v, b));
                let u: [f64; 3] = std::array::from_fn(|i| of_b[i] - of_a[i]);
                for (at, c) in [(a, c), (b, -c)] {
                    let mut sum = record(f, at);
                    sum.iter_mut().zip(u).for_each(|(sum, u)| *sum += c * u);
                    set_record(f, at, sum);
                }
                power -= c * u.iter().map(|u| u * u).sum::<f64>();
            }
        }
        power
    }
}
