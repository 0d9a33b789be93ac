//! Springs, slack or not (thesis Eq. 3, 52 and 67; Provot 1995), linear or of another curve
//! ([`crate::force::law::curve`]).
//!
//! ```text
//! e = l - s l0,  n = (xb - xa)/l    force on a = T(e) n,  on b = -T(e) n      energy = integral of T de
//! -df/dx = [[B, -B], [-B, B]],      B = (T/l)(I - n n^T) + (dT/dl) n n^T      -df/dv = 0
//! ```
//! s is a factor of all rest lengths of a batch over time, 1 without one. Its change does the work dE/ds ds on a
//! spring, -T l0 ds on a linear one.
//!
//! T carries its sign: in compression B is indefinite. Two coincident nodes have no direction: force and tangent are
//! 0.

pub use crate::force::kernel::coefficient::Coefficient;
pub use crate::force::kernel::cut::Cut;
use crate::force::law::curve::{Bar, CurveKind};
use crate::force::law::series::Table;
use crate::force::law::slack::tension;
use crate::force::law::stretch::{SpringLengths, WholeScene, largest, strain_base};
use crate::force::{Copies, outer};
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
    /// tension over elongation
    pub curve: CurveKind,
    /// slack kind of the batch
    pub slack: Slack,
    /// [-] factor s of the rest lengths over time; absent means 1
    pub rest_scale: Option<Arc<Table<1>>>,
}

/// Positions of all nodes, with the rest lengths of a batch at the same time.
#[derive(Clone, Copy, Debug)]
pub struct SpringsAt<'a> {
    /// [m] `[n_nodes]`
    pub x: &'a [Vector3<f64>],
    /// [-] factor s of the rest lengths
    pub rest_scale: f64,
}

impl SpringData {
    /// The same springs for another run.
    #[must_use]
    pub(crate) fn for_run(&self, copies: &mut Copies) -> Self {
        SpringData { rest_scale: self.rest_scale.as_ref().map(|table| copies.of(table)), ..self.clone() }
    }

    /// [-] The factor s of the rest lengths at time `t` [s].
    pub fn rest_scale_at(&self, t: f64) -> f64 {
        self.rest_scale.as_ref().map_or(1.0, |table| table.at(t)[0])
    }

    /// These springs at positions `x` [m] `[n_nodes]` and time `t` [s].
    pub fn at<'a>(&self, t: f64, x: &'a [Vector3<f64>]) -> SpringsAt<'a> {
        SpringsAt { x, rest_scale: self.rest_scale_at(t) }
    }

    /// [m] Rest length of spring `i` times s.
    pub fn rest_length_at(&self, at: SpringsAt<'_>, i: usize) -> f64 {
        self.rest_length[i] * at.rest_scale
    }

    /// Vector from a to b, length, and elongation of spring `i`.
    #[inline]
    pub(crate) fn stretch(&self, at: SpringsAt<'_>, i: usize) -> Stretch {
        let [a, b] = self.nodes[i];
        let d = at.x[b as usize] - at.x[a as usize];
        let length = d.norm();
        let n = if length > 0.0 { d * length.recip() } else { Vector3::zeros() };
        Stretch { n, length, elongation: length - self.rest_length_at(at, i) }
    }

    /// Stiffness and rest length of spring `i`.
    #[inline]
    pub(crate) fn bar(&self, at: SpringsAt<'_>, i: usize) -> Bar {
        Bar { k: self.stiffness.at(i), l0: self.rest_length_at(at, i) }
    }

    /// [N] elastic tension of spring `i`.
    #[inline]
    pub fn tension(&self, at: SpringsAt<'_>, i: usize) -> f64 {
        tension(&self.curve, self.slack, self.bar(at, i), self.elongation(at, i)).force
    }

    /// [m] Elongation of spring `i`, without its direction.
    #[inline]
    fn elongation(&self, at: SpringsAt<'_>, i: usize) -> f64 {
        let [a, b] = self.nodes[i];
        (at.x[b as usize] - at.x[a as usize]).norm() - self.rest_length_at(at, i)
    }

    /// [-] Largest l^2/l0^2 of all springs, -inf without any.
    pub fn largest_stretch(&self, SpringsAt { x, rest_scale }: SpringsAt<'_>) -> f64 {
        largest(SpringLengths {
            ends: &self.nodes,
            rest_length: &self.rest_length,
            rest_scale,
            at: WholeScene(bytemuck::cast_slice(x)),
        })
    }

    /// Whether some spring that carries force has turned by more than 90 degrees from positions `from` to `to` [m],
    /// both `[n_nodes]`.
    pub fn turns_over(&self, cut: &Cut, [from, to]: [&[Vector3<f64>]; 2]) -> bool {
        if !cut.some() {
            return self.nodes.chunks(64).any(|chunk| turns_over(chunk, from, to));
        }
        self.nodes.iter().enumerate().any(|(i, &nodes)| !cut.is_cut(i) && turns_over(&[nodes], from, to))
    }

    /// [-] Strain (l - l0)/l0 of spring `i`; 0 without a rest length.
    pub fn strain(&self, at: SpringsAt<'_>, i: usize) -> f64 {
        self.elongation(at, i) / strain_base(self.rest_length_at(at, i))
    }
}

/// Without roots and divisions: a fraction of a force pass.
#[multiversion(targets("x86_64+avx+avx2"))]
fn turns_over(springs: &[[u32; 2]], from: &[Vector3<f64>], to: &[Vector3<f64>]) -> bool {
    let along = |x: &[Vector3<f64>], [a, b]: [u32; 2]| x[b as usize] - x[a as usize];
    springs.iter().fold(false, |turned, &nodes| turned | (along(from, nodes).dot(&along(to, nodes)) <= 0.0))
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
