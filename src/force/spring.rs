//! Linear springs, slack or not (thesis Eq. 3, 52 and 67; Provot 1995).
//!
//! ```text
//! e = l - l0,  n = (xb - xa)/l      force on a = T(e) n,  on b = -T(e) n      energy = integral of T de
//! -df/dx = [[B, -B], [-B, B]],      B = (T/l)(I - n n^T) + (dT/dl) n n^T      -df/dv = 0
//! ```
//! T carries its sign: in compression B is indefinite. Two coincident nodes have no direction: force and tangent are 0.

use super::batch::{BLOCK, Batch, Kernel, Threads, lane_sum};
use super::slack::{Clamped, Plain, TensionLaw, clamped, tension};
use super::{ForceTerm, NodeState, TangentSink, outer};
use crate::model::forces::{Role, Tally};
use crate::model::spec::Slack;
use crate::model::system::{TermInfo, Weights};
use glam::{DMat3, DVec3};
use multiversion::multiversion;
use std::ops::Range;
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

    /// Fills `out` with the values of a range.
    #[inline]
    pub(crate) fn fill(&self, range: Range<usize>, out: &mut [f64]) {
        match self {
            Coefficient::Uniform(c) => out.fill(*c),
            Coefficient::Each(values) => out.copy_from_slice(&values[range]),
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

    /// [-] strain (l - l0)/l0 of spring `i`.
    pub fn strain(&self, x: &[DVec3], i: usize) -> f64 {
        self.stretch(x, i).elongation / self.rest_length[i]
    }

    fn block_forces(&self, x: &[DVec3], range: Range<usize>, out: &mut [DVec3]) -> Tally {
        let n = range.len();
        let mut buffers = [[0.0; BLOCK]; 3];
        let [k, energy, square] = &mut buffers;
        let (k, energy, square) = (&mut k[..n], &mut energy[..n], &mut square[..n]);
        self.stiffness.fill(range.clone(), k);
        for ((&[a, b], d), q) in self.nodes[range.clone()].iter().zip(out.iter_mut()).zip(square.iter_mut()) {
            *d = x[b as usize] - x[a as usize];
            *q = d.length_squared();
        }
        let springs = Stretched { square, energy, k, rest_length: &self.rest_length[range] };
        match clamped(self.slack) {
            None => scale_plain(springs),
            Some(law) => scale_clamped(springs, law),
        }
        for (d, s) in out.iter_mut().zip(square.iter()) {
            *d *= *s;
        }
        Tally { energy: lane_sum(energy), power: 0.0 }
    }
}

/// A block of springs by lengths alone: no memory access by node number, so that the loop over it vectorises.
struct Stretched<'a> {
    /// [m^2] squared length before, [N/m] T/l after
    square: &'a mut [f64],
    /// [J] stored energy, written
    energy: &'a mut [f64],
    /// [N/m]
    k: &'a [f64],
    /// [m]
    rest_length: &'a [f64],
}

/// Compiled for each vector width and chosen at run time; without fused operations all give the same bits.
#[multiversion(targets("x86_64+avx+avx2", "x86_64+avx512f"))]
fn scale_plain(springs: Stretched<'_>) {
    scale(springs, Plain);
}

/// The same for slack springs.
#[multiversion(targets("x86_64+avx+avx2", "x86_64+avx512f"))]
fn scale_clamped(springs: Stretched<'_>, law: Clamped) {
    scale(springs, law);
}

#[inline(always)]
fn scale<L: TensionLaw>(springs: Stretched<'_>, law: L) {
    let Stretched { square, energy, k, rest_length } = springs;
    for (((q, u), k), l0) in square.iter_mut().zip(energy.iter_mut()).zip(k).zip(rest_length) {
        let l = q.sqrt();
        let t = law.at(*k, l - l0);
        *q = if l > 0.0 { t.force / l } else { 0.0 };
        *u = t.energy;
    }
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
    const SIGNS: [f64; 2] = [1.0, -1.0];

    fn elements(&self) -> &[[u32; 2]] {
        &self.nodes
    }

    fn forces(&self, at: NodeState<'_>, range: Range<usize>, out: &mut [DVec3]) -> Tally {
        self.block_forces(at.x, range, out)
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
