//! The mean force of a membrane over a step (Simo & Tarnow 1992), with Gonzalez' correction (1996) where it wrinkles.
//!
//! ```text
//! f_a = -A0 F S g_a,     F = (F_0 + F_1)/2,   dE = E_1 - E_0,   sum of -f . dx = A0 S : dE
//! S   = (S_0 + S_1)/2 + k dE,     k = 1/2 (S_1 : E_0 - S_0 : E_1)/(dE : dE)
//! K_ab = A0 [(g_a . S g_b) I + 2 B_a^T (dS/dE_1) B_1b]       B at F, B_1 at F_1
//! ```
//! W is homogeneous, 1/2 S : E, so that A0 S : dE is the change of energy. Between two taut states k = 0. As W is convex
//! with a largest second derivative C, |k| <= C/8: where rounding says more, the strain has hardly changed.

use super::{Membrane, MembraneData, strain_along};
use crate::force::law::tension_field::{Voigt, Wrinkling};
use crate::force::{MeanForce, MeanStep, TangentForm, TangentSink};
use crate::model::forces::Tally;
use crate::model::system::{StepMean, Weights};
use nalgebra::{Matrix2, Matrix3, Matrix3x2, Vector3};

/// [-] Change of strain over strain below which a wrinkled triangle, whose stress is smooth, has no correction: it
/// would be rounding.
const STILL: f64 = 1e-6;

/// Stress of a triangle over a step, in scaled axes.
pub(super) struct MeanSheet {
    /// S
    pub stress: Voigt,
    /// 2 dS/dE_1
    pub exact: Matrix3<f64>,
    /// a symmetric, positive semidefinite approximation of it
    pub symmetric: Matrix3<f64>,
}

/// Two strains, their stresses, and their difference.
struct Ends {
    strain: [Voigt; 2],
    stress: [Voigt; 2],
    /// dE
    change: Voigt,
    /// dE : dE
    square: f64,
    k: f64,
    /// whether k follows the strain
    exact: bool,
}

fn dot(a: Voigt, b: Voigt) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// With the shear of a tensor.
fn tensor([e11, e22, twice]: Voigt) -> Voigt {
    [e11, e22, 0.5 * twice]
}

impl Ends {
    fn mean(&self, dissipation: f64) -> Voigt {
        let ([s0, s1], d) = (self.stress, tensor(self.change));
        [0, 1, 2].map(|j| 0.5 * (s0[j] + s1[j]) + self.k * d[j] + 0.5 * dissipation * (s1[j] - s0[j]))
    }
}

impl MembraneData {
    /// The ends of a step at whose middle a triangle has this deformation and this rate of it.
    fn ends(&self, [f, rate]: [&Matrix3x2<f64>; 2], half: f64) -> Ends {
        let by = rate * half;
        let strain @ [e0, e1] = [f - by, f + by].map(|f| self.strain(&f));
        let stress @ [s0, s1] = [e0, e1].map(|strain| self.sheet.stress(strain));
        let change = strain_along([f, &by]).map(|e| 2.0 * e);
        let square = dot(tensor(change), change);
        let mut ends = Ends { strain, stress, change, square, k: 0.0, exact: false };
        let still = || square <= STILL * STILL * dot(tensor(e0), e0).max(dot(tensor(e1), e1));
        match strain.map(|strain| self.sheet.wrinkling(strain)) {
            [Wrinkling::Taut, Wrinkling::Taut] | [Wrinkling::Slack, Wrinkling::Slack] => {}
            [Wrinkling::Wrinkled, Wrinkling::Wrinkled] if still() => {}
            _ if square > 0.0 => {
                let (k, largest) = (0.5 * (dot(s1, e0) - dot(s0, e1)) / square, self.sheet.stiffest() / 8.0);
                (ends.k, ends.exact) = (k.clamp(-largest, largest), k.abs() <= largest);
            }
            _ => {}
        }
        ends
    }

    /// The stress of a triangle over a step, with its tangents.
    pub(super) fn mean_sheet(&self, f: [&Matrix3x2<f64>; 2], mean: StepMean) -> MeanSheet {
        let ends = self.ends(f, mean.half);
        let [c0, c1] = ends.strain.map(|strain| self.stiffness(strain));
        let (grown, k) = (1.0 + mean.dissipation, ends.k);
        let mut exact = c1 * grown + Matrix3::from_diagonal(&Vector3::new(2.0 * k, 2.0 * k, k));
        if ends.exact {
            let [d, e0, s0] = [tensor(ends.change), ends.strain[0], ends.stress[0]].map(Vector3::from);
            exact += d * (c1 * e0 - s0 - 4.0 * k * d).transpose() / ends.square;
        }
        MeanSheet { stress: ends.mean(mean.dissipation), exact, symmetric: (c0 + c1) * (0.5 * grown) }
    }
}

impl MeanForce for Membrane {
    fn add_mean(&self, MeanStep { at, mean }: MeanStep<'_>, f: &mut [Vector3<f64>]) -> Tally {
        for (i, nodes) in self.data.triangles.iter().enumerate() {
            let [middle, rate] = [at.x, at.v].map(|of| self.data.deformation(i, of));
            let [s11, s22, s12] = self.data.ends([&middle, &rate], mean.half).mean(mean.dissipation);
            let shape = &self.data.shapes[i];
            let force = middle * (Matrix2::new(s11, s12, s12, s22) * -shape.area);
            for (&node, g) in nodes.iter().zip(shape.gradients()) {
                f[node as usize] += force * g;
            }
        }
        Tally::default()
    }

    fn mean_tangent(&self, step: MeanStep<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink) {
        for (i, &nodes) in self.data.triangles.iter().enumerate() {
            sink.triangle(nodes, &self.data.blocks(i, (step.at, Some(step.mean)), w, form));
        }
    }
}
