//! Sums over neighbours along springs, as Kang's filter has them: `sum_j k_ij (u_j - u_i)` in what is viscous,
//! `sum_j k_ij u_j` in its second sweep. Not a force term: nothing that a scene adds up, and without energies.
//!
//! Every node gathers from its neighbours, so that no two write to one place and any range of nodes can be summed for
//! itself; four nodes go side by side. A spring is met twice, which costs less here than adding to two nodes in memory:
//! there is no root and no division to be saved.

use crate::force::kernel::coefficient::Coefficient;
use crate::model::quad::{self, Quad, VectorUnit};
use std::ops::Range;

/// Every node's neighbours with the weights of the springs between.
#[derive(Clone, Debug)]
pub struct Neighbours {
    /// by group of four nodes: how many rounds there are before it
    first: Vec<usize>,
    rounds: Vec<NeighbourLanes>,
}

/// A neighbour of each of four nodes; one that has no more is its own, without a weight.
#[derive(Clone, Copy, Debug)]
struct NeighbourLanes {
    /// first degrees of freedom
    places: [u32; SIDE_BY_SIDE],
    weights: [f64; SIDE_BY_SIDE],
}

/// Place of a weight.
#[derive(Clone, Copy, Debug)]
pub struct WeightSlot {
    round: u32,
    /// which of the four nodes
    q: u8,
}

const SIDE_BY_SIDE: usize = 4;

/// Degrees of freedom of four nodes: ranges of sums begin at multiples of it.
const GROUP: usize = 3 * SIDE_BY_SIDE;

/// Pairs of nodes, and a weight for each, such as a stiffness [N/m].
#[derive(Clone, Copy, Debug)]
pub struct Links<'a> {
    /// the two nodes of every link
    pub nodes: &'a [[u32; 2]],
    /// the weight of every link
    pub weights: &'a Coefficient,
}

impl Neighbours {
    /// Of `n` nodes with `links`. Nodes may be linked more than once.
    ///
    /// # Panics
    /// When a node is not below `n`, or a weight is missing.
    pub fn new<'a>(n: usize, links: impl Iterator<Item = Links<'a>> + Clone) -> Self {
        Self::with_slots(n, links).0
    }

    /// The same, and where the two weights of every link are, in the order of the links.
    ///
    /// # Panics
    /// As [`Neighbours::new`].
    pub fn with_slots<'a>(n: usize, links: impl Iterator<Item = Links<'a>> + Clone) -> (Self, Vec<[WeightSlot; 2]>) {
        let mut degrees = vec![0; n];
        for &node in links.clone().flat_map(|links| links.nodes.as_flattened()) {
            degrees[node as usize] += 1;
        }
        let mut neighbours = Neighbours { first: vec![0], rounds: Vec::new() };
        for (group, degrees) in degrees.chunks(SIDE_BY_SIDE).enumerate() {
            let most = degrees.iter().copied().max().unwrap_or_default();
            let places = std::array::from_fn(|q| 3 * (SIDE_BY_SIDE * group + q).min(n - 1) as u32);
            let empty = NeighbourLanes { places, weights: [0.0; SIDE_BY_SIDE] };
            neighbours.rounds.extend(std::iter::repeat_n(empty, most));
            neighbours.first.push(neighbours.rounds.len());
        }
        degrees.fill(0);
        let mut slots = Vec::new();
        for Links { nodes, weights } in links {
            for (i, &[a, b]) in nodes.iter().enumerate() {
                slots.push([[a, b], [b, a]].map(|ends| neighbours.push(&mut degrees, ends, weights.at(i))));
            }
        }
        (neighbours, slots)
    }

    /// Changes a weight.
    ///
    /// # Panics
    /// When the slot is of another graph, and larger.
    pub fn set(&mut self, WeightSlot { round, q }: WeightSlot, weight: f64) {
        self.rounds[round as usize].weights[usize::from(q)] = weight;
    }

    /// `filled` counts the neighbours that every node has so far.
    fn push(&mut self, filled: &mut [usize], [own, other]: [u32; 2], weight: f64) -> WeightSlot {
        let (group, q) = (own as usize / SIDE_BY_SIDE, own as usize % SIDE_BY_SIDE);
        let filled = &mut filled[own as usize];
        let number = self.first[group] + *filled;
        let round = &mut self.rounds[number];
        (round.places[q], round.weights[q]) = (3 * other, weight);
        *filled += 1;
        WeightSlot { round: number as u32, q: q as u8 }
    }

    /// `sum_j k_ij` of every node, and zeros that fill up the last four.
    pub fn weights(&self) -> impl Iterator<Item = f64> {
        let rounds = self.first.windows(2).map(|ends| &self.rounds[ends[0]..ends[1]]);
        rounds.flat_map(|rounds| {
            rounds.iter().fold([0.0; SIDE_BY_SIDE], |sums, round| std::array::from_fn(|q| sums[q] + round.weights[q]))
        })
    }

    /// `out_i = sum_j k_ij u_j` for the nodes with degrees of freedom `dofs`, which begin at a multiple of twelve, as
    /// many as `out` has; `u` has those of all nodes. In units of a weight times one of `u`.
    ///
    /// # Panics
    /// When `dofs` begin elsewhere, are not as many as `out` has or lie beyond the scene, or `u` lacks a node.
    pub fn sums(&self, u: &[f64], dofs: Range<usize>, out: &mut [f64]) {
        quad::run(Gather::<false> { neighbours: self, u, dofs, out });
    }

    /// `out_i = sum_j k_ij (u_j - u_i)`, likewise.
    ///
    /// # Panics
    /// As [`Neighbours::sums`].
    pub fn differences(&self, u: &[f64], dofs: Range<usize>, out: &mut [f64]) {
        quad::run(Gather::<true> { neighbours: self, u, dofs, out });
    }
}

struct Gather<'a, const DIFFERENCES: bool> {
    neighbours: &'a Neighbours,
    u: &'a [f64],
    dofs: Range<usize>,
    out: &'a mut [f64],
}

impl<const DIFFERENCES: bool> quad::Pass for Gather<'_, DIFFERENCES> {
    type Output = ();

    #[inline(always)]
    fn run<U: VectorUnit>(self, unit: U) {
        let Gather { neighbours, u, dofs, out } = self;
        assert!(dofs.start.is_multiple_of(GROUP) && dofs.len() == out.len(), "whole groups of nodes");
        let (groups, last) = out.as_chunks_mut::<GROUP>();
        let mut number = dofs.start / GROUP;
        for out in groups {
            let sums = sums::<U, DIFFERENCES>(unit, neighbours, u, number);
            for (out, sum) in out.as_chunks_mut().0.iter_mut().zip(sums) {
                *out = sum.numbers();
            }
            number += 1;
        }
        if !last.is_empty() {
            let sums = sums::<U, DIFFERENCES>(unit, neighbours, u, number).map(Quad::numbers);
            last.copy_from_slice(&sums.as_flattened()[..last.len()]);
        }
    }
}

/// Of the four nodes of a group, packed.
#[inline(always)]
fn sums<U: VectorUnit, const DIFFERENCES: bool>(
    unit: U,
    neighbours: &Neighbours,
    u: &[f64],
    group: usize,
) -> [U::Quad; 3] {
    let mut own = [unit.splat(0.0); SIDE_BY_SIDE];
    if DIFFERENCES {
        for (q, own) in own.iter_mut().enumerate() {
            *own = vector(unit, u, (GROUP * group + 3 * q).min(u.len() - 3));
        }
    }
    let mut sums = [unit.splat(0.0); SIDE_BY_SIDE];
    for round in &neighbours.rounds[neighbours.first[group]..neighbours.first[group + 1]] {
        for q in 0..SIDE_BY_SIDE {
            let mut other = vector(unit, u, round.places[q] as usize);
            if DIFFERENCES {
                other = other - own[q];
            }
            sums[q] = sums[q] + unit.splat(round.weights[q]) * other;
        }
    }
    U::Quad::pack(sums)
}

/// A node's vector by its first degree of freedom, and a number that means nothing.
#[inline(always)]
fn vector<U: VectorUnit>(unit: U, u: &[f64], at: usize) -> U::Quad {
    match u.get(at..at + 4) {
        Some(four) => unit.quad(four.first_chunk().copied().unwrap_or_default()),
        None => unit.quad([u[at], u[at + 1], u[at + 2], 0.0]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force::kernel::fixtures::random;
    use crate::model::quad::Portable;

    /// Pairs of nodes, some of them linked twice or with themselves, and some without any.
    fn links(n: usize, count: usize) -> Vec<[u32; 2]> {
        let mut random = random(7);
        let mut node = || (random().abs() * (n as f64 - 0.5)) as u32;
        (0..count).map(|_| [node(), node()]).collect()
    }

    /// Of all nodes, an element after the other.
    fn plain(differences: bool, links: &[[u32; 2]], k: &Coefficient, u: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; u.len()];
        for (i, &[a, b]) in links.iter().enumerate() {
            for (own, other) in [(a, b), (b, a)].map(|(own, other)| (3 * own as usize, 3 * other as usize)) {
                for c in 0..3 {
                    let from = if differences { u[own + c] } else { 0.0 };
                    out[own + c] += k.at(i) * (u[other + c] - from);
                }
            }
        }
        out
    }

    /// What is not finite stays with the node and those it is linked to.
    #[test]
    fn other_nodes_do_not_notice_what_is_not_finite() {
        let chain: Vec<[u32; 2]> = (0..9).map(|i| [i, i + 1]).collect();
        let neighbours =
            Neighbours::new(10, [Links { nodes: &chain, weights: &Coefficient::Uniform(2.0) }].into_iter());
        for (wrong, value) in (0..10).flat_map(|node| [f64::NAN, f64::INFINITY].map(|value| (node, value))) {
            let mut u = vec![1.0; 30];
            u[3 * wrong] = value;
            let mut out = vec![0.0; 30];
            neighbours.sums(&u, 0..30, &mut out);
            for (i, sum) in out.iter().enumerate() {
                let expected = if (3..27).contains(&i) { 4.0 } else { 2.0 };
                match (i / 3).abs_diff(wrong) {
                    1 if i % 3 == 0 => assert!(!sum.is_finite(), "{sum} at {i}, {value} at {wrong}"),
                    0 => {}
                    _ => assert_eq!(*sum, expected, "at {i}, {value} at {wrong}"),
                }
            }
        }
    }

    /// In whatever pieces, and on any machine: a node sums in the order of its links.
    #[test]
    fn sums_have_the_bits_of_a_plain_loop() {
        for n in (1..14).chain([100]) {
            let (first, second) = (links(n, 2 * n), links(n, n));
            let mut random = random(3);
            let u: Vec<f64> = (0..3 * n).map(|_| random()).collect();
            let k: Vec<f64> = (0..2 * n).map(|_| random()).collect();
            let weights = [Coefficient::Each(k.clone().into()), Coefficient::Uniform(0.3)];
            let neighbours = Neighbours::new(
                n,
                [Links { nodes: &first, weights: &weights[0] }, Links { nodes: &second, weights: &weights[1] }]
                    .into_iter(),
            );
            let all = [&first[..], &second].concat();
            let of_all = Coefficient::Each([k, vec![0.3; n]].concat().into());
            let sums = plain(false, &all, &of_all, &vec![1.0; 3 * n]);
            assert!(neighbours.weights().take(n).eq(sums.into_iter().step_by(3)), "{n} nodes");
            let (expected, with_differences) = (plain(false, &all, &of_all, &u), plain(true, &all, &of_all, &u));
            for piece in [12, 24, 1200] {
                let (mut out, mut portable) = (vec![f64::NAN; 3 * n], vec![f64::NAN; 3 * n]);
                for (i, (out, portable)) in out.chunks_mut(piece).zip(portable.chunks_mut(piece)).enumerate() {
                    let dofs = i * piece..i * piece + out.len();
                    neighbours.sums(&u, dofs.clone(), out);
                    let u = &u;
                    quad::Pass::run(Gather::<false> { neighbours: &neighbours, u, dofs, out: portable }, Portable);
                }
                assert_eq!(out, expected, "{n} nodes by {piece}");
                assert_eq!(portable, expected, "{n} nodes by {piece}");
                for (i, (out, portable)) in out.chunks_mut(piece).zip(portable.chunks_mut(piece)).enumerate() {
                    let dofs = i * piece..i * piece + out.len();
                    neighbours.differences(&u, dofs.clone(), out);
                    let u = &u;
                    quad::Pass::run(Gather::<true> { neighbours: &neighbours, u, dofs, out: portable }, Portable);
                }
                assert_eq!(out, with_differences, "{n} nodes by {piece}");
                assert_eq!(portable, with_differences, "{n} nodes by {piece}");
            }
        }
    }
}
