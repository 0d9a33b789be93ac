//! Linear springs, slack or not (thesis Eq. 3, 52 and 67; Provot 1995).
//!
//! ```text
//! e = l - l0,  n = (xb - xa)/l      force on a = T(e) n,  on b = -T(e) n      energy = integral of T de
//! -df/dx = [[B, -B], [-B, B]],      B = (T/l)(I - n n^T) + (dT/dl) n n^T      -df/dv = 0
//! ```
//! T carries its sign: in compression B is indefinite. Two coincident nodes have no direction: force and tangent are 0.

use crate::force::kernel::axial_kernel::{AxialLaw, Pull, pull};
use crate::force::kernel::batch::{Records, Wants};
pub use crate::force::kernel::coefficient::Coefficient;
use crate::force::kernel::edges::{EdgeBatch, EdgeKernel, Edges};
use crate::force::law::slack::{Plain, TensionLaw, clamped, tension};
use crate::force::law::stretch::{InScene, InWindow, Stretched, largest};
pub use crate::force::law::tension::Carried;
use crate::force::law::tension::Carrying;
use crate::force::{ForceTerm, NodeState, TangentSink, outer};
use crate::model::forces::{Role, Tally};
use crate::model::quad::{self, Quad, VectorUnit};
use crate::model::spec::Slack;
use crate::model::system::{TermInfo, Weights};
use multiversion::multiversion;
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

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
pub type Springs = EdgeBatch<SpringData>;

impl SpringData {
    /// Vector from a to b, length, and elongation of spring `i`.
    #[inline]
    pub(crate) fn stretch(&self, x: &[Vector3<f64>], i: usize) -> Stretch {
        let [a, b] = self.nodes[i];
        self.stretch_of(x[b as usize] - x[a as usize], i)
    }

    /// The same with its nodes `d` [m] apart.
    #[inline]
    pub(crate) fn stretch_of(&self, d: Vector3<f64>, i: usize) -> Stretch {
        let length = d.norm();
        let n = if length > 0.0 { d * length.recip() } else { Vector3::zeros() };
        Stretch { n, length, elongation: length - self.rest_length[i] }
    }

    /// Elastic tension and strain of every spring at positions `x` [m], each at its own of `to.places`, of which there
    /// are as many as springs; what has no spring keeps what it holds.
    ///
    /// # Panics
    /// When a place lies beyond `to.tension` or `to.strain`.
    pub fn carried(&self, x: &[Vector3<f64>], to: Carried<'_>) {
        let data = self;
        match clamped(self.slack) {
            None => quad::run(Carrying { data, law: Plain, x, to }),
            Some(law) => quad::run(Carrying { data, law, x, to }),
        }
    }

    /// [m] elongation of spring `i`, without its direction.
    fn elongation(&self, x: &[Vector3<f64>], i: usize) -> f64 {
        let [a, b] = self.nodes[i];
        (x[b as usize] - x[a as usize]).norm() - self.rest_length[i]
    }

    /// [-] Largest l^2/l0^2 of all springs, -inf without any; at positions `x` [m].
    pub fn largest_stretch(&self, x: &[Vector3<f64>]) -> f64 {
        largest(Stretched { ends: &self.nodes, rest_length: &self.rest_length, at: InScene(bytemuck::cast_slice(x)) })
    }

    /// Whether some spring points away at `to` [m] from where it pointed at `from` [m].
    pub fn turns_over(&self, from: &[Vector3<f64>], to: &[Vector3<f64>]) -> bool {
        turns_over(self, from, to)
    }

    /// [-] strain (l - l0)/l0 of spring `i`.
    pub fn strain(&self, x: &[Vector3<f64>], i: usize) -> f64 {
        self.elongation(x, i) / self.rest_length[i]
    }
}

/// Springs side by side, by stiffness and rest length.
struct SpringLaw<T>(T);

impl<T: TensionLaw> AxialLaw for SpringLaw<T> {
    #[inline(always)]
    fn pull<U: VectorUnit>(&self, unit: U, [k, l0]: [U::Quad; 2], square: U::Quad) -> Pull<U::Quad> {
        let l = square.sqrt();
        let (force, energy) = self.0.quad(unit, k, l - l0);
        Pull { scale: (force / l).where_positive(l), amount: energy }
    }
}

/// Without roots and divisions: a fraction of a force pass.
#[multiversion(targets("x86_64+avx+avx2"))]
fn turns_over(data: &SpringData, from: &[Vector3<f64>], to: &[Vector3<f64>]) -> bool {
    let along = |x: &[Vector3<f64>], [a, b]: [u32; 2]| x[b as usize] - x[a as usize];
    data.nodes.chunks(64).any(|chunk| {
        chunk.iter().fold(false, |turned, &nodes| turned | (along(from, nodes).dot(&along(to, nodes)) <= 0.0))
    })
}

/// Direction, length and elongation of a spring.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch {
    /// unit vector from a to b, zero for coincident nodes
    pub n: Vector3<f64>,
    /// [m]
    pub length: f64,
    /// [m] l - l0
    pub elongation: f64,
}

impl Stretch {
    /// `(t/l)(I - n n^T) + s n n^T`, zero for coincident nodes.
    pub(crate) fn block(&self, t: f64, s: f64) -> Matrix3<f64> {
        if self.length == 0.0 {
            return Matrix3::zeros();
        }
        let g = t / self.length;
        Matrix3::from_diagonal_element(g) + outer(self.n, self.n) * (s - g)
    }
}

impl EdgeKernel for SpringData {
    const WANTS: Wants = Wants { x: true, v: false };

    fn elements(&self) -> &[[u32; 2]] {
        &self.nodes
    }

    fn numbers(&self) -> [Coefficient; 2] {
        // One each, even where all are the same: the largest stretch goes over them.
        [self.stiffness.clone(), Coefficient::Each(self.rest_length.clone())]
    }

    fn add(&self, block: Edges<'_>, f: &mut Records) -> Tally {
        let energy = match clamped(self.slack) {
            None => pull(&SpringLaw(Plain), &block, block.x, f),
            Some(tension) => pull(&SpringLaw(tension), &block, block.x, f),
        };
        Tally { energy, power: 0.0 }
    }

    fn largest_stretch(&self, block: Edges<'_>) -> f64 {
        largest(Stretched { ends: block.ends, rest_length: block.second(), at: InWindow(block.x) })
    }
}

impl ForceTerm for Springs {
    fn info(&self) -> TermInfo {
        TermInfo::of("springs", Role::Elastic)
    }

    fn symmetric(&self) -> bool {
        true
    }

    fn tangent(&self, at: NodeState<'_>, w: Weights, sink: &mut dyn TangentSink) {
        let data = self.kernel();
        for (i, &nodes) in data.nodes.iter().enumerate() {
            let s = data.stretch(at.x, i);
            let t = tension(data.slack, data.stiffness.at(i), s.elongation);
            sink.edge(nodes, s.block(t.force, t.slope) * w.k);
        }
    }

    /// B = max(T, 0)/l (I - n n^T) + (dT/dl) n n^T: the geometric part of a compressed spring is dropped.
    fn convex_tangent(&self, at: NodeState<'_>, w: Weights, sink: &mut dyn TangentSink) {
        let data = self.kernel();
        for (i, &nodes) in data.nodes.iter().enumerate() {
            let s = data.stretch(at.x, i);
            let t = tension(data.slack, data.stiffness.at(i), s.elongation);
            sink.edge(nodes, s.block(t.force.max(0.0), t.slope) * w.k);
        }
    }

    fn add_stiffness(&self, nodes: &mut [f64]) {
        let data = self.kernel();
        for (i, pair) in data.nodes.iter().enumerate() {
            for &node in pair {
                nodes[node as usize] += data.stiffness.at(i);
            }
        }
    }
}
