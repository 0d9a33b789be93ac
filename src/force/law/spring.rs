//! Linear springs, slack or not (thesis Eq. 3, 52 and 67; Provot 1995).
//!
//! ```text
//! e = l - l0,  n = (xb - xa)/l      force on a = T(e) n,  on b = -T(e) n      energy = integral of T de
//! -df/dx = [[B, -B], [-B, B]],      B = (T/l)(I - n n^T) + (dT/dl) n n^T      -df/dv = 0
//! ```
//! T carries its sign: in compression B is indefinite. Two coincident nodes have no direction: force and tangent are 0.

pub use crate::force::kernel::coefficient::Coefficient;
use crate::force::law::slack::{LinearLaw, clamped, tension};
use crate::force::law::stretch::{SpringLengths, WholeScene, largest, strain_base};
pub use crate::force::law::tension::SpringOutput;
use crate::force::law::tension::TensionPass;
use crate::force::outer;
use crate::model::quad;
use crate::model::spec::Slack;
use multiversion::multiversion;
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// Plain arrays of a batch of springs.
#[derive(Clone, Debug)]
pub struct SpringData {
    /// end nodes a, b
    pub nodes: Arc<[[u32; 2]]>,
    /// [m] rest length l0 of every spring; may be 0
    pub rest_length: Arc<[f64]>,
    /// [N/m] stiffness k
    pub stiffness: Coefficient,
    /// slack kind of the batch
    pub slack: Slack,
}

impl SpringData {
    /// Vector from a to b, length, and elongation of spring `i`.
    #[inline]
    pub(crate) fn stretch(&self, x: &[Vector3<f64>], i: usize) -> Stretch {
        let [a, b] = self.nodes[i];
        let d = x[b as usize] - x[a as usize];
        let length = d.norm();
        let n = if length > 0.0 { d * length.recip() } else { Vector3::zeros() };
        Stretch { n, length, elongation: length - self.rest_length[i] }
    }

    /// [N] elastic tension of spring `i`.
    pub fn tension(&self, x: &[Vector3<f64>], i: usize) -> f64 {
        tension(self.slack, self.stiffness.at(i), self.elongation(x, i)).force
    }

    /// Writes elastic tension and strain of every spring at positions `x` [m] `[n_nodes]` to its index in `to.places`
    /// `[n_springs]`; other entries keep their values.
    ///
    /// # Panics
    /// When an index is beyond the end of `to.tension` or `to.strain`.
    pub fn carried(&self, x: &[Vector3<f64>], to: SpringOutput<'_>) {
        let data = self;
        match clamped(self.slack) {
            None => quad::run(TensionPass { data, law: LinearLaw, x, to }),
            Some(law) => quad::run(TensionPass { data, law, x, to }),
        }
    }

    /// [m] elongation of spring `i`, without its direction.
    fn elongation(&self, x: &[Vector3<f64>], i: usize) -> f64 {
        let [a, b] = self.nodes[i];
        (x[b as usize] - x[a as usize]).norm() - self.rest_length[i]
    }

    /// [-] Largest l^2/l0^2 of all springs, -inf without any; at positions `x` [m].
    pub fn largest_stretch(&self, x: &[Vector3<f64>]) -> f64 {
        largest(SpringLengths {
            ends: &self.nodes,
            rest_length: &self.rest_length,
            at: WholeScene(bytemuck::cast_slice(x)),
        })
    }

    /// Whether some spring has turned by more than 90 degrees from positions `from` [m] to `to` [m].
    pub fn turns_over(&self, from: &[Vector3<f64>], to: &[Vector3<f64>]) -> bool {
        turns_over(self, from, to)
    }

    /// [-] strain (l - l0)/l0 of spring `i`; 0 without a rest length.
    pub fn strain(&self, x: &[Vector3<f64>], i: usize) -> f64 {
        self.elongation(x, i) / strain_base(self.rest_length[i])
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
