//! Linear springs, slack or not (thesis Eq. 3, 52 and 67; Provot 1995).
//!
//! ```text
//! e = l - l0,  n = (xb - xa)/l      force on a = T(e) n,  on b = -T(e) n      energy = integral of T de
//! -df/dx = [[B, -B], [-B, B]],      B = (T/l)(I - n n^T) + (dT/dl) n n^T      -df/dv = 0
//! ```
//! T carries its sign: in compression B is indefinite. Two coincident nodes have no direction: force and tangent are 0.

use super::batch::{Batch, Kernel, LANES, Lanes, Padded, Threads, Tile, Wants};
use super::slack::{Clamped, Plain, TensionLaw, clamped, tension};
use super::tile::{minus, plus, times};
use super::{ForceTerm, NodeState, TangentSink, outer};
use crate::model::forces::{Role, Tally};
use crate::model::spec::Slack;
use crate::model::system::{TermInfo, Weights};
use glam::{DMat3, DVec3};
use multiversion::multiversion;
use std::sync::Arc;

/// One value for all elements, or one each; a uniform value is not read from memory again and again.
#[derive(Clone, Debug, PartialEq)]
pub enum Coefficient {
    /// the same for all
    Uniform(f64),
    /// one an element
    Each(Arc<[f64]>),
}

impl Coefficient {
    /// Chooses the compact form.
    pub fn from_values(values: &[f64]) -> Self {
        match values.first() {
            Some(&first) if values.iter().all(|&v| v == first) => Coefficient::Uniform(first),
            _ => Coefficient::Each(values.into()),
        }
    }

    /// The value of element `i`.
    #[inline]
    pub fn at(&self, i: usize) -> f64 {
        match self {
            Coefficient::Uniform(c) => *c,
            Coefficient::Each(values) => values[i],
        }
    }
}

/// Plain arrays of a batch of springs.
#[derive(Clone, Debug)]
pub struct SpringData {
    /// end nodes a, b
    pub nodes: Arc<[[u32; 2]]>,
    /// [m] rest length l0, one a spring
    pub rest_length: Arc<[f64]>,
    /// [N/m] stiffness k
    pub stiffness: Coefficient,
    /// slack kind of the batch
    pub slack: Slack,
}

/// A batch of springs as a force term.
#[derive(Debug)]
pub struct Springs(Batch<SpringData, 2>);

impl Springs {
    /// Makes the term; node numbers must be below the number of nodes it will be used with.
    pub fn new(data: SpringData) -> Self {
        Springs(Batch::new(data))
    }

    /// The arrays.
    pub fn data(&self) -> &SpringData {
        self.0.kernel()
    }
}

impl SpringData {
    /// Vector from a to b, length, and elongation of spring `i`.
    #[inline]
    pub(crate) fn stretch(&self, x: &[DVec3], i: usize) -> Stretch {
        let [a, b] = self.nodes[i];
        let d = x[b as usize] - x[a as usize];
        let length = d.length();
        let n = if length > 0.0 { d * length.recip() } else { DVec3::ZERO };
        Stretch { n, length, elongation: length - self.rest_length[i] }
    }

    /// [N] elastic tension of spring `i`.
    pub fn tension(&self, x: &[DVec3], i: usize) -> f64 {
        tension(self.slack, self.stiffness.at(i), self.stretch(x, i).elongation).force
    }

    /// [-] largest strain of all springs, -inf without any.
    pub fn max_strain(&self, x: &[DVec3]) -> f64 {
        largest_strain(self, x)
    }

    /// [-] strain (l - l0)/l0 of spring `i`.
    pub fn strain(&self, x: &[DVec3], i: usize) -> f64 {
        self.stretch(x, i).elongation / self.rest_length[i]
    }
}

/// Compiled for each vector width and chosen at run time; without fused operations all give the same bits.
#[multiversion(targets("x86_64+avx+avx2"))]
fn add_plain(data: &SpringData, tile: Tile<'_, 2>, f: &mut [Padded]) -> f64 {
    add_springs(data, tile, f, Plain)
}

/// The same for slack springs.
#[multiversion(targets("x86_64+avx+avx2"))]
fn add_clamped(data: &SpringData, tile: Tile<'_, 2>, f: &mut [Padded], law: Clamped) -> f64 {
    add_springs(data, tile, f, law)
}

#[inline(always)]
fn add_springs<L: TensionLaw>(data: &SpringData, tile: Tile<'_, 2>, f: &mut [Padded], law: L) -> f64 {
    let (l0, last_l0) = data.rest_length[tile.range()].as_chunks();
    match &data.stiffness {
        Coefficient::Uniform(k) => {
            let (blocks, last) = ([*k; LANES], [*k; LANES]);
            let k = (std::iter::repeat(&blocks), last.iter());
            add_blocks(tile, l0.iter().zip(k.0), last_l0.iter().zip(k.1), law, f)
        }
        Coefficient::Each(k) => {
            let (k, last_k) = k[tile.range()].as_chunks();
            add_blocks(tile, l0.iter().zip(k), last_l0.iter().zip(last_k), law, f)
        }
    }
}

/// Springs with their l0 and k: as many side by side as a register holds, and the last ones alone.
#[inline(always)]
fn add_blocks<'a, L: TensionLaw>(
    tile: Tile<'_, 2>,
    blocks: impl Iterator<Item = (&'a [f64; LANES], &'a [f64; LANES])>,
    last: impl Iterator<Item = (&'a f64, &'a f64)>,
    law: L,
    f: &mut [Padded],
) -> f64 {
    let mut energy = Lanes::default();
    let (nodes, rest) = tile.nodes.as_chunks::<LANES>();
    for (nodes, (l0, k)) in nodes.iter().zip(blocks) {
        add_block(nodes, (l0, k), law, tile.x, f, &mut energy);
    }
    for (nodes, (l0, k)) in rest.iter().zip(last) {
        add_block(&[*nodes], (&[*l0], &[*k]), law, tile.x, f, &mut energy);
    }
    energy.total()
}

/// Loops by number instead of iterators and maps: only these become vector instructions.
#[inline(always)]
fn add_block<const B: usize, L: TensionLaw>(
    nodes: &[[u16; 2]; B],
    (l0, k): (&[f64; B], &[f64; B]),
    law: L,
    x: &[Padded],
    f: &mut [Padded],
    energy: &mut Lanes,
) {
    let mut d = [[0.0; 4]; B];
    let mut scale = [0.0; B];
    let mut stored = [0.0; B];
    for j in 0..B {
        d[j] = minus(x[nodes[j][1] as usize], x[nodes[j][0] as usize]);
    }
    for j in 0..B {
        let l = (d[j][0] * d[j][0] + d[j][1] * d[j][1] + d[j][2] * d[j][2]).sqrt();
        let t = law.at(k[j], l - l0[j]);
        scale[j] = if l > 0.0 { t.force / l } else { 0.0 };
        stored[j] = t.energy;
    }
    energy.add(&stored);
    for j in 0..B {
        let [a, b] = nodes[j];
        let force = times(scale[j], d[j]);
        f[a as usize] = plus(f[a as usize], force);
        f[b as usize] = minus(f[b as usize], force);
    }
}

/// Without directions, which cost a division each.
#[multiversion(targets("x86_64+avx+avx2"))]
fn largest_strain(data: &SpringData, x: &[DVec3]) -> f64 {
    let mut largest = [f64::NEG_INFINITY; LANES];
    let (nodes, rest) = data.nodes.as_chunks::<LANES>();
    let (l0, _) = data.rest_length.as_chunks::<LANES>();
    for (nodes, l0) in nodes.iter().zip(l0) {
        let mut square = [0.0; LANES];
        for j in 0..LANES {
            let [a, b] = nodes[j];
            square[j] = (x[b as usize] - x[a as usize]).length_squared();
        }
        for j in 0..LANES {
            largest[j] = f64::max(largest[j], (square[j].sqrt() - l0[j]) / l0[j]);
        }
    }
    let last = data.nodes.len() - rest.len()..data.nodes.len();
    last.map(|i| data.strain(x, i)).chain(largest).fold(f64::NEG_INFINITY, f64::max)
}

/// Direction, length and elongation of a spring.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch {
    /// unit vector from a to b, zero for coincident nodes
    pub n: DVec3,
    /// [m]
    pub length: f64,
    /// [m] l - l0
    pub elongation: f64,
}

impl Stretch {
    /// `(t/l)(I - n n^T) + s n n^T`, zero for coincident nodes.
    pub(crate) fn block(&self, t: f64, s: f64) -> DMat3 {
        if self.length == 0.0 {
            return DMat3::ZERO;
        }
        let g = t / self.length;
        DMat3::from_diagonal(DVec3::splat(g)) + outer(self.n, self.n) * (s - g)
    }
}

impl Kernel<2> for SpringData {
    const WANTS: Wants = Wants { x: true, v: false };

    fn elements(&self) -> &[[u32; 2]] {
        &self.nodes
    }

    fn add(&self, tile: Tile<'_, 2>, f: &mut [Padded]) -> Tally {
        let energy = match clamped(self.slack) {
            None => add_plain(self, tile, f),
            Some(law) => add_clamped(self, tile, f, law),
        };
        Tally { energy, power: 0.0 }
    }
}

impl ForceTerm for Springs {
    fn info(&self) -> TermInfo {
        TermInfo { name: "springs", role: Role::Elastic }
    }

    fn elements(&self) -> usize {
        self.0.elements()
    }

    fn velocity_dependent(&self) -> bool {
        false
    }

    fn symmetric(&self) -> bool {
        true
    }

    fn add(&self, at: NodeState<'_>, threads: &Threads, f: &mut [DVec3]) -> Tally {
        self.0.add(at, threads, f)
    }

    fn tangent(&self, at: NodeState<'_>, w: Weights, sink: &mut dyn TangentSink) {
        let data = self.data();
        for (i, &nodes) in data.nodes.iter().enumerate() {
            let s = data.stretch(at.x, i);
            let t = tension(data.slack, data.stiffness.at(i), s.elongation);
            sink.edge(nodes, s.block(t.force, t.slope) * w.k);
        }
    }

    /// B = max(T, 0)/l (I - n n^T) + (dT/dl) n n^T: the geometric part of a compressed spring is dropped.
    fn convex_tangent(&self, at: NodeState<'_>, w: Weights, sink: &mut dyn TangentSink) {
        let data = self.data();
        for (i, &nodes) in data.nodes.iter().enumerate() {
            let s = data.stretch(at.x, i);
            let t = tension(data.slack, data.stiffness.at(i), s.elongation);
            sink.edge(nodes, s.block(t.force.max(0.0), t.slope) * w.k);
        }
    }

    fn add_stiffness(&self, nodes: &mut [f64]) {
        let data = self.data();
        for (i, pair) in data.nodes.iter().enumerate() {
            for &node in pair {
                nodes[node as usize] += data.stiffness.at(i);
            }
        }
    }
}
