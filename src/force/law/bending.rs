//! Bending, quadratic in the positions: hinges between two triangles, and nodes of a chain (Bergou et al. 2006).
//!
//! ```text
//! y = sum of w_i x_i,     energy = k/2 |y|^2,     f_i = -k w_i y,     K_ij = k w_i w_j I (constant)
//! hinge of the edge 0-1 with the wings 2 and 3:   k = B/(A_2 + A_3)                            B in N m
//!     w = (c_03 + c_04, c_01 + c_02, -c_01 - c_03, -c_02 - c_04), cotangents of the angles at the edge
//! node 1 of the chain 0-1-2:   w = (1/l, -1/l - 1/l', 1/l'),   k = 2 EI/(l + l')                EI in N m^2
//! ```
//! The weights add up to 0, so there is no force on a sheet or a line that is moved, turned or straight. Lengths, areas
//! and angles are those at rest; a hinge is right for triangles that keep their shape, at any angle. At rest the sheet
//! is flat and the line straight, whatever the mesh.
//!
//! B is that of a plate that is bent to a cylinder: the energy per area is B kappa^2/2 on equal triangles, which are
//! equilateral or halves of squares. (The factor 3 of Bergou et al. belongs to another norm; with it a cylinder has
//! three times this energy.) Equilateral triangles are a plate of Poisson's ratio -1/3 (Seung & Nelson 1988), so a
//! narrow strip with free sides bends with 8/9 B; one of halves of squares with 4/5 B.
//!
//! The mean over a step ([`crate::force::MeanForce`]) is the force at y in its middle, with dissipation times 1 + c:
//! ```text
//! c = chi (|y_1| - |y_0|)/(|y_1| + |y_0|)        D = k/2 chi (|y_1| - |y_0|)^2
//! K_ij = w_i w_j B,     B = k [(1 + c) I + 4 chi |y_0|/(|y_1| + |y_0|)^2 y n_1^T],      n_1 = y_1/|y_1|
//! ```
//! So it is a spring of no length with the ends of y, and turns nothing.
//!
//! K is emitted as a sum over pairs of nodes: as the weights add up to 0, |y|^2 is the sum of -w_i w_j |x_i - x_j|^2
//! over all pairs.

use crate::force::kernel::batch::{Batch, BufferReads, Elements, Kernel, Records};
use crate::force::kernel::element_block::{add, vector};
use crate::force::{ForceTerm, MeanForce, MeanStep, NodeState, TangentForm, TangentSink, outer};
use crate::model::forces::{Role, Tally};
use crate::model::system::{TermInfo, Weights};
use nalgebra::{Matrix3, Vector3};

/// Hinges (`N` = 4) or nodes of chains (`N` = 3).
pub type Bending<const N: usize> = Batch<BendingData<N>, N>;

/// A hinge or a node of a chain.
#[derive(Clone, Copy, Debug)]
pub struct BendingElement<const N: usize> {
    /// [1/m] w for a chain, [-] for a hinge
    pub weights: [f64; N],
    /// k: [N m] for a chain, [N/m] for a hinge
    pub stiffness: f64,
}

impl BendingElement<4> {
    /// The hinge of an edge 0-1 [m] between two triangles with the third corners 2 and 3, at rest; `rigidity` is B
    /// [N m]. `None` if a triangle has no area.
    pub fn hinge([a, b, c, d]: [Vector3<f64>; 4], rigidity: f64) -> Option<Self> {
        let cotangent = |at: Vector3<f64>, p: Vector3<f64>, q: Vector3<f64>| {
            let (p, q) = (p - at, q - at);
            p.dot(&q) / p.cross(&q).norm()
        };
        let areas = 0.5 * ((b - a).cross(&(c - a)).norm() + (b - a).cross(&(d - a)).norm());
        let [at_a, at_b] = [[c, d].map(|wing| cotangent(a, b, wing)), [c, d].map(|wing| cotangent(b, a, wing))];
        let weights = [at_b[0] + at_b[1], at_a[0] + at_a[1], -at_a[0] - at_b[0], -at_a[1] - at_b[1]];
        let stiffness = rigidity / areas;
        (weights.iter().all(|w| w.is_finite()) && stiffness.is_finite())
            .then_some(BendingElement { weights, stiffness })
    }
}

impl BendingElement<3> {
    /// The node between two segments of these lengths [m]; `rigidity` is EI [N m^2].
    pub fn chain([before, after]: [f64; 2], rigidity: f64) -> Self {
        let weights = [1.0 / before, -1.0 / before - 1.0 / after, 1.0 / after];
        BendingElement { weights, stiffness: 2.0 * rigidity / (before + after) }
    }
}

/// Plain arrays of the elements.
#[derive(Clone, Debug)]
pub struct BendingData<const N: usize> {
    /// nodes of every element, in ascending order of their smallest
    pub nodes: Vec<[u32; N]>,
    /// one each
    pub elements: Vec<BendingElement<N>>,
}

impl<const N: usize> Kernel<N> for BendingData<N> {
    const READS: BufferReads = BufferReads { x: true, v: false };

    fn elements(&self) -> &[[u32; N]] {
        &self.nodes
    }

    fn add(&self, block: Elements<'_, N>, f: &mut Records) -> Tally {
        let mut energy = 0.0;
        for (nodes, i) in block.nodes.iter().zip(block.range()) {
            let BendingElement { weights, stiffness } = self.elements[i];
            let from = vector(block.x, nodes[0]);
            // Relative to the first node, so that a far-away origin costs no digits.
            let mut y = Vector3::zeros();
            for (&node, w) in nodes.iter().zip(weights) {
                y += w * (vector(block.x, node) - from);
            }
            energy += 0.5 * stiffness * y.norm_squared();
            for (&node, w) in nodes.iter().zip(weights) {
                add(f, node, y * (-stiffness * w));
            }
        }
        Tally { energy, power: 0.0 }
    }
}

impl<const N: usize> Bending<N> {
    /// Emits w_i w_j k times the block of every element, pair by pair.
    fn emit(&self, sink: &mut dyn TangentSink, block: impl Fn(&[u32; N], &BendingElement<N>) -> Matrix3<f64>) {
        let data = self.kernel();
        for (nodes, element @ BendingElement { weights, stiffness }) in data.nodes.iter().zip(&data.elements) {
            let block = block(nodes, element);
            for i in 0..N {
                for j in i + 1..N {
                    sink.edge([nodes[i], nodes[j]], block * (-stiffness * weights[i] * weights[j]));
                }
            }
        }
    }
}

impl<const N: usize> ForceTerm for Bending<N> {
    fn parts(&self) -> &[TermInfo] {
        const INFO: TermInfo = TermInfo::of("bending", Role::Elastic);
        &[INFO]
    }

    fn symmetric(&self) -> bool {
        true
    }

    fn mean(&self) -> Option<&dyn MeanForce> {
        Some(self)
    }

    fn tangent(&self, _: NodeState<'_>, w: Weights, _: TangentForm, sink: &mut dyn TangentSink) {
        self.emit(sink, |_, _| Matrix3::from_diagonal_element(w.k));
    }

    fn add_stiffness(&self, nodes: &mut [f64]) {
        let data = self.kernel();
        for (corners, BendingElement { weights, stiffness }) in data.nodes.iter().zip(&data.elements) {
            for (&node, w) in corners.iter().zip(weights) {
                nodes[node as usize] += stiffness * w * w;
            }
        }
    }
}

/// y over a step with dissipation.
struct MeanBend {
    /// y in the middle, and n_1
    y: Vector3<f64>,
    end: Vector3<f64>,
    /// |y_0|, |y_1|
    sizes: [f64; 2],
    chi: f64,
}

impl MeanBend {
    fn of<const N: usize>(MeanStep { at, mean }: MeanStep<'_>, nodes: &[u32; N], weights: &[f64; N]) -> Self {
        let y_of = |of: &[Vector3<f64>]| {
            let from = of[nodes[0] as usize];
            nodes.iter().zip(weights).fold(Vector3::zeros(), |y, (&node, w)| y + (of[node as usize] - from) * *w)
        };
        let (y, change) = (y_of(at.x), y_of(at.v) * mean.half);
        let ends = [y - change, y + change];
        let end = ends[1].try_normalize(0.0).unwrap_or_default();
        MeanBend { y, end, sizes: ends.map(|y| y.norm()), chi: mean.dissipation }
    }

    /// |y_0| + |y_1|, and 1 + c.
    fn factors(&self) -> [f64; 2] {
        let [start, end] = self.sizes;
        let sum = start + end;
        [sum, if sum > 0.0 { 1.0 + self.chi * (end - start) / sum } else { 1.0 }]
    }

    /// B/k; in the symmetric form with the direction of y on both sides.
    fn block(&self, form: TangentForm) -> Matrix3<f64> {
        let [sum, factor] = self.factors();
        let along = if form.symmetric {
            let n = self.y.try_normalize(0.0).unwrap_or_default();
            outer(n, n) * self.chi
        } else if sum > 0.0 {
            outer(self.y, self.end) * (4.0 * self.chi * self.sizes[0] / (sum * sum))
        } else {
            Matrix3::zeros()
        };
        Matrix3::from_diagonal_element(factor) + along
    }
}

impl<const N: usize> MeanForce for Bending<N> {
    fn add_mean(&self, step: MeanStep<'_>, f: &mut [Vector3<f64>]) -> Tally {
        let data = self.kernel();
        for (nodes, BendingElement { weights, stiffness }) in data.nodes.iter().zip(&data.elements) {
            let bend = MeanBend::of(step, nodes, weights);
            let force = bend.y * (stiffness * bend.factors()[1]);
            for (&node, w) in nodes.iter().zip(weights) {
                f[node as usize] -= force * *w;
            }
        }
        Tally::default()
    }

    fn mean_tangent(&self, step: MeanStep<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink) {
        self.emit(sink, |nodes, element| MeanBend::of(step, nodes, &element.weights).block(form) * w.k);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hinge of two equal triangles has the energy B/2 (2 |e| sin(theta/2))^2/(A + A').
    #[test]
    fn a_hinge_has_the_energy_of_its_angle() {
        let [length, height, rigidity] = [0.4, 0.3, 2.5];
        let wing = |angle: f64, side: f64| Vector3::new(0.15, side * height * angle.cos(), height * angle.sin());
        let rest = [Vector3::zeros(), Vector3::new(length, 0.0, 0.0), wing(0.0, 1.0), wing(0.0, -1.0)];
        let hinge = BendingElement::hinge(rest, rigidity).expect("two triangles");
        assert!(hinge.weights.iter().sum::<f64>().abs() < 1e-14);
        for half in [0.01_f64, 0.5, 1.2] {
            let bent = [rest[0], rest[1], wing(half, 1.0), wing(half, -1.0)];
            let y: Vector3<f64> = bent.iter().zip(hinge.weights).map(|(x, w)| *x * w).sum();
            let energy = 0.5 * hinge.stiffness * y.norm_squared();
            // |y| = 2 |e| sin(theta/2), with theta = 2 half.
            let expected = 0.5 * rigidity / (length * height) * (2.0 * length * half.sin()).powi(2);
            assert!((energy - expected).abs() < 1e-12 * expected, "{energy} and not {expected}");
        }
    }
}
