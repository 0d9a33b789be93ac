//! The mean force of a membrane over a step (Simo & Tarnow 1992), with Gonzalez' correction (1996) where it wrinkles.
//!
//! ```text
//! f_a = -A0 F S g_a,     F = (F_0 + F_1)/2,   dE = E_1 - E_0,   sum of -f . dx = A0 S : dE
//! S   = (S_0 + S_1)/2 + k dE,     k = 1/2 (S_1 : E_0 - S_0 : E_1)/(dE : dE)
//! K_ab = A0 [(g_a . S g_b) I + 2 B_a^T (dS/dE_1) B_1b]       B at F, B_1 at F_1
//! ```
//! W is homogeneous, 1/2 S : E, so that A0 S : dE is the change of energy. Between two taut states k = 0.

use super::{Membrane, MembraneData, strain_along};
use crate::force::law::tension_field::{Voigt, Wrinkling};
use crate::force::{MeanForce, MeanStep, TangentForm, TangentSink};
use crate::model::forces::Tally;
use crate::model::system::{StepMean, Weights};
use nalgebra::{Matrix2, Matrix3, Matrix3x2, Vector3};

/// [-] Change of strain below which rounding of energies would show in k, and the correction does not.
const STILL: f64 = 1e-8;

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
    change: Voigt,
    /// k and dE : dE, where there is a correction
    correction: Option<[f64; 2]>,
}

fn dot(a: Voigt, b: Voigt) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Ends {
    /// dE with the shear of a tensor.
    fn direction(&self) -> Voigt {
        let [e11, e22, twice] = self.change;
        [e11, e22, 0.5 * twice]
    }

    fn mean(&self, dissipation: f64) -> Voigt {
        let ([s0, s1], d) = (self.stress, self.direction());
        let k = self.correction.map_or(0.0, |[k, _]| k);
        [0, 1, 2].map(|j| 0.5 * (s0[j] + s1[j]) + k * d[j] + 0.5 * dissipation * (s1[j] - s0[j]))
    }
}

impl MembraneData {
    /// The ends of a step at whose middle a triangle has this deformation and this rate of it.
    fn ends(&self, [f, rate]: [&Matrix3x2<f64>; 2], half: f64) -> Ends {
        let change = rate * half;
        let strain = [f - change, f + change].map(|f| self.strain(&f));
        let stress = strain.map(|strain| self.sheet.stress(strain));
        let mut ends = Ends { strain, stress, change: strain_along([f, &change]).map(|e| 2.0 * e), correction: None };
        let states = strain.map(|strain| self.sheet.wrinkling(strain));
        let ([e0, e1], [s0, s1]) = (strain, stress);
        let square = dot(ends.direction(), ends.change);
        let [one, two] = self.squares();
        if states != [Wrinkling::Taut; 2] && square > (STILL * one.min(two)).powi(2) {
            ends.correction = Some([0.5 * (dot(s1, e0) - dot(s0, e1)) / square, square]);
        }
        ends
    }

    /// The stress of a triangle over a step, with its tangents.
    pub(super) fn mean_sheet(&self, f: [&Matrix3x2<f64>; 2], mean: StepMean) -> MeanSheet {
        let ends = self.ends(f, mean.half);
        let [c0, c1] = ends.strain.map(|strain| self.stiffness(strain));
        let grown = 1.0 + mean.dissipation;
        let mut exact = c1 * grown;
        if let Some([k, square]) = ends.correction {
            let (d, [e0, _], [s0, _]) = (Vector3::from(ends.direction()), ends.strain, ends.stress);
            let slope = (0.5 * (c1 * Vector3::from(e0) - Vector3::from(s0)) - 2.0 * k * d) / square;
            exact += 2.0 * (Matrix3::from_diagonal(&Vector3::new(k, k, 0.5 * k)) + d * slope.transpose());
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
