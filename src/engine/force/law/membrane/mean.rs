//! The mean force of a membrane over a step (Simo & Tarnow 1992), also where it wrinkles.
//!
//! ```text
//! f_a = -A0 F S g_a,     F = (F_0 + F_1)/2,   dE = E_1 - E_0,   sum of -f . dx = A0 S : dE
//! S   = integral of S(E_0 + s dE) over s from 0 to 1,      dS/dE_1 = integral of s S'(E_0 + s dE)
//! K_ab = A0 [(g_a . S g_b) I + 2 B_a^T (dS/dE_1) B_1b]       B at F, B_1 at F_1
//! ```
//! The integral is the change of W, and its tangent is symmetric and positive semidefinite, as W is convex. It is cut
//! where the line crosses the cones of taut and of slack strains. There S is linear; between them, in wrinkles, it is
//! summed at five points (Gauss), and what W has more or less than that sum is added along dE (Gonzalez 1996).

use super::{Membrane, MembraneData, strain_along};
use crate::force::law::tension_field::{Sheet, Voigt, Wrinkling};
use crate::force::{MeanForce, MeanStep, TangentForm, TangentSink};
use crate::model::forces::Tally;
use crate::model::system::{StepMean, Weights};
use nalgebra::{Matrix2, Matrix3, Matrix3x2, Vector3};

/// [-] Change of strain over strain below which the sum at five points is the integral to rounding.
const STILL: f64 = 1e-2;

/// Gauss' points in an interval, and their weights. With fewer the tangent would miss how the cuts move.
const GAUSS: [[f64; 2]; 5] = [
    [0.046_910_077_030_668, 0.118_463_442_528_094_5],
    [0.230_765_344_947_158_5, 0.239_314_335_249_683_2],
    [0.5, 0.284_444_444_444_444_4],
    [0.769_234_655_052_841_5, 0.239_314_335_249_683_2],
    [0.953_089_922_969_332, 0.118_463_442_528_094_5],
];

/// Stress of a triangle over a step, in scaled axes.
pub(super) struct MeanSheet {
    /// S
    pub stress: Voigt,
    /// 2 dS/dE_1
    pub exact: Matrix3<f64>,
    /// a symmetric, positive semidefinite approximation of it
    pub symmetric: Matrix3<f64>,
}

/// The strains of a step.
struct Way<'a> {
    data: &'a MembraneData,
    ends: [Voigt; 2],
    /// dE
    change: Voigt,
}

/// What is added along dE.
struct Correction {
    k: f64,
    /// dE : dE
    square: f64,
    /// S without it
    sum: Voigt,
}

fn dot(a: Voigt, b: Voigt) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// With the shear of a tensor.
fn tensor([e11, e22, twice]: Voigt) -> Voigt {
    [e11, e22, 0.5 * twice]
}

/// Where the determinant of a + s b, two symmetric tensors, is 0 for s in (0, 1); 1 for what there is not.
fn zeros([a11, a22, a12]: Voigt, [b11, b22, b12]: Voigt) -> [f64; 2] {
    let (c, half, a) = (a11 * a22 - a12 * a12, 0.5 * (a11 * b22 + a22 * b11) - a12 * b12, b11 * b22 - b12 * b12);
    let root = (half * half - a * c).max(0.0).sqrt();
    let q = -(half + root.copysign(half));
    [q / a, c / q].map(|s| if s > 0.0 && s < 1.0 { s } else { 1.0 })
}

impl Way<'_> {
    fn at(&self, s: f64) -> Voigt {
        [0, 1, 2].map(|j| self.ends[0][j] + s * self.change[j])
    }

    /// Shows points s of the way from 0 to 1, their strains, and their weights in the mean of a stress.
    fn each(&self, mut visit: impl FnMut(f64, Voigt, f64)) {
        let sheet: &Sheet = &self.data.sheet;
        let state = |s: f64| sheet.wrinkling(self.at(s));
        let [start, end] = self.ends.map(|strain| sheet.wrinkling(strain));
        if start == end && start != Wrinkling::Wrinkled {
            // The two cones are convex.
            return visit(0.5, self.at(0.5), 1.0);
        }
        let [taut, slack] = [
            zeros(sheet.taut_stress(self.ends[0]), sheet.taut_stress(self.change)),
            zeros(tensor(self.ends[0]), tensor(self.change)),
        ];
        let mut cuts = [0.0, taut[0], taut[1], slack[0], slack[1], 1.0];
        cuts.sort_by(f64::total_cmp);
        for cut in cuts.windows(2).filter(|cut| cut[1] > cut[0]) {
            let (from, length) = (cut[0], cut[1] - cut[0]);
            let middle = from + 0.5 * length;
            match state(middle) {
                Wrinkling::Slack => {}
                Wrinkling::Taut => visit(middle, self.at(middle), length),
                Wrinkling::Wrinkled => {
                    for [x, weight] in GAUSS {
                        let s = from + x * length;
                        visit(s, self.at(s), weight * length);
                    }
                }
            }
        }
    }

    /// S without dissipation, and what was added for it.
    fn stress(&self) -> (Voigt, Option<Correction>) {
        let mut sum = [0.0; 3];
        self.each(|_, strain, weight| {
            let stress = self.data.sheet.stress(strain);
            sum.iter_mut().zip(stress).for_each(|(sum, stress)| *sum += weight * stress);
        });
        let ([e0, e1], d) = (self.ends, tensor(self.change));
        let square = dot(d, self.change);
        let still = STILL * STILL * dot(tensor(e0), e0).max(dot(tensor(e1), e1));
        if !self.data.sheet.wrinkles || square <= still {
            return (sum, None);
        }
        // W is homogeneous: 1/2 S : E.
        let [w0, w1] = self.ends.map(|strain| 0.5 * dot(self.data.sheet.stress(strain), strain));
        let k = ((w1 - w0) - dot(sum, self.change)) / square;
        ([0, 1, 2].map(|j| sum[j] + k * d[j]), Some(Correction { k, square, sum }))
    }

    fn with_dissipation(&self, stress: Voigt, chi: f64) -> Voigt {
        if chi == 0.0 {
            return stress;
        }
        let [s0, s1] = self.ends.map(|strain| self.data.sheet.stress(strain));
        [0, 1, 2].map(|j| stress[j] + 0.5 * chi * (s1[j] - s0[j]))
    }
}

impl MembraneData {
    /// The step at whose middle a triangle has this deformation and this rate of it.
    fn way(&self, [f, rate]: [&Matrix3x2<f64>; 2], half: f64) -> Way<'_> {
        let by = rate * half;
        let ends = [f - by, f + by].map(|f| self.strain(&f));
        Way { data: self, ends, change: strain_along([f, &by]).map(|e| 2.0 * e) }
    }

    /// The stress of a triangle over a step, with its tangents.
    pub(super) fn mean_sheet(&self, f: [&Matrix3x2<f64>; 2], mean: StepMean) -> MeanSheet {
        let way = self.way(f, mean.half);
        let mut symmetric = Matrix3::zeros();
        way.each(|s, strain, weight| symmetric += self.stiffness(strain) * (2.0 * s * weight));
        let (stress, correction) = way.stress();
        let mut exact = symmetric;
        if let Some(Correction { k, square, sum }) = correction {
            let [d, change, sum, end] =
                [tensor(way.change), way.change, sum, self.sheet.stress(way.ends[1])].map(Vector3::from);
            let slope = 2.0 * (end - sum) - symmetric * change - 4.0 * k * d;
            exact += Matrix3::from_diagonal(&Vector3::new(2.0 * k, 2.0 * k, k)) + d * slope.transpose() / square;
        }
        if mean.dissipation > 0.0 {
            let damping = self.stiffness(way.ends[1]) * mean.dissipation;
            exact += damping;
            symmetric += damping;
        }
        MeanSheet { stress: way.with_dissipation(stress, mean.dissipation), exact, symmetric }
    }
}

impl MeanForce for Membrane {
    fn add_mean(&self, MeanStep { at, mean }: MeanStep<'_>, f: &mut [Vector3<f64>]) -> Tally {
        for (i, nodes) in self.data.triangles.iter().enumerate() {
            let [middle, rate] = [at.x, at.v].map(|of| self.data.deformation(i, of));
            let way = self.data.way([&middle, &rate], mean.half);
            let [s11, s22, s12] = way.with_dissipation(way.stress().0, mean.dissipation);
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
