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
//! The mean over a step ([`crate::force::MeanForce`]) is the force in its middle, or with dissipation that at
//! x + chi h/2 v: the mean stress and chi/2 of its change.
//!
//! K is emitted as a sum over pairs of nodes: as the weights add up to 0, |y|^2 is the sum of -w_i w_j |x_i - x_j|^2
//! over all pairs.

use crate::force::kernel::batch::{Batch, BufferReads, Elements, Kernel, Records};
use crate::force::kernel::element_block::{add, vector};
use crate::force::{ForceTerm, MeanForce, MeanStep, NodeState, TangentForm, TangentSink};
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
        let data = self.kernel();
        for (nodes, BendingElement { weights, stiffness }) in data.nodes.iter().zip(&data.elements) {
            for i in 0..N {
                for j in i + 1..N {
                    let pair = -w.k * stiffness * weights[i] * weights[j];
                    sink.edge([nodes[i], nodes[j]], Matrix3::from_diagonal_element(pair));
                }
            }
        }
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

impl<const N: usize> MeanForce for Bending<N> {
    fn add_mean(&self, MeanStep { at, mean }: MeanStep<'_>, f: &mut [Vector3<f64>]) -> Tally {
        let (data, ahead) = (self.kernel(), mean.dissipation * mean.half);
        for (nodes, BendingElement { weights, stiffness }) in data.nodes.iter().zip(&data.elements) {
            let [from, speed] = [at.x, at.v].map(|of| of[nodes[0] as usize]);
            let mut y = Vector3::zeros();
            for (&node, w) in nodes.iter().zip(weights) {
                let node = node as usize;
                y += ((at.x[node] - from) + (at.v[node] - speed) * ahead) * *w;
            }
            for (&node, w) in nodes.iter().zip(weights) {
                f[node as usize] -= y * (stiffness * w);
            }
        }
        Tally::default()
    }

    fn mean_tangent(&self, step: MeanStep<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink) {
        self.tangent(step.at, Weights { k: (1.0 + step.mean.dissipation) * w.k, ..w }, form, sink);
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
