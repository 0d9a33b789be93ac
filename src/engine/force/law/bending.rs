//! Bending, quadratic in the positions: triangles between hinges, and nodes of a chain (after Bergou et al. 2006).
//!
//! ```text
//! y_r = sum of w_ri x_i,   energy = sum over r of |y_r|^2/2,   f_i = -sum of w_ri y_r,   K_ij = sum of w_ri w_rj I
//! hinge of the edge 0-1 with the wings 2 and 3:     j = sum of c_i x_i                  |j| = 2 l sin(angle/2)
//!     c = (c_03 + c_04, c_01 + c_02, -c_01 - c_03, -c_02 - c_04), cotangents of the angles at the edge
//! triangle of the area A whose sides have hinges to triangles A_e, and the normals n_e in its plane:
//!     curvature = sum over sides of j_e/(A + A_e) n_e n_e^T,     energy = A B/2 |curvature|^2            B in N m
//!     y = sqrt(A B) times the curvatures xx, yy and sqrt(2) xy
//! node 1 of the chain 0-1-2:     y = sqrt(2 EI/(l + l')) (x_0/l - x_1/l - x_1/l' + x_2/l')            EI in N m^2
//! ```
//! The weights add up to 0, so there is no force on a sheet or a line that is moved, turned or straight. Lengths, areas
//! and angles are those at rest; a hinge is right for triangles that keep their shape, at any angle. At rest the sheet
//! is flat and the line straight, whatever the mesh.
//!
//! The curvature of a triangle is the mean of n times the slope along its sides (Onate & Cervera 1993), where the slope
//! at a side is the mean of both triangles'. Each has the other's area as its weight, so the energy that hinges have by
//! themselves is B |j|^2/(2 (A + A_e)). On a mesh of equal triangles, each pair of which is symmetric about the middle
//! of its edge, the curvature of any second-order surface is exact: the sheet is a plate of Poisson's ratio 0, and
//! bends with B to a cylinder as well as in a strip with free sides. On meshes without order it is stiffer, by 4 to 9
//! %.
//!
//! A side without a hinge is free: its curvature n n^T is the one with the least energy, so that no moment acts there.
//! A triangle whose corners are held is a clamp: it has no energy, and counts as A_e = 0, as a segment of a chain whose
//! ends are held counts as l = 0. So the sheet begins at the side of the clamp, with the clamp's slope.
//!
//! The mean over a step ([`crate::force::MeanForce`]) is the force at y in its middle, with dissipation times 1 + c:
//! ```text
//! c = chi (|y_1| - |y_0|)/(|y_1| + |y_0|)        D = chi/2 (|y_1| - |y_0|)^2
//! K_ij = w_i w_j B,     B = (1 + c) I + 4 chi |y_0|/(|y_1| + |y_0|)^2 y n_1^T,      n_1 = y_1/|y_1|
//! ```
//! So each y is a spring of no length with the ends of y, and turns nothing.
//!
//! K is emitted as a sum over pairs of nodes: as the weights add up to 0, |y|^2 is the sum of -w_i w_j |x_i - x_j|^2
//! over all pairs.

use crate::force::kernel::batch::{Batch, BufferReads, Elements, Kernel, Records};
use crate::force::kernel::element_block::{add, vector};
use crate::force::{Copies, ForceTerm, MeanForce, MeanStep, NodeState, TangentForm, TangentSink, outer};
use crate::model::forces::{Role, Tally};
use crate::model::system::{TermInfo, Weights};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::SQRT_2;

/// Triangles between hinges (`N` = 6, `R` = 3), or nodes of chains (`N` = 3, `R` = 1).
pub type Bending<const N: usize, const R: usize> = Batch<BendingData<N, R>, N>;

/// A triangle between hinges, or a node of a chain.
#[derive(Clone, Copy, Debug)]
pub struct BendingElement<const N: usize, const R: usize> {
    /// [sqrt(N/m)] w of every y
    pub weights: [[f64; N]; R],
}

/// The hinge at a side of a triangle, as the triangle sees it at rest.
#[derive(Clone, Copy, Debug)]
pub struct Hinge {
    /// [m] third corner of the other triangle
    pub wing: Vector3<f64>,
    /// [N m] B
    pub rigidity: f64,
    /// whether the other triangle is held
    pub clamped: bool,
}

impl BendingElement<6, 3> {
    /// A triangle that is not held. `corners` [m] are at rest; `hinges[k]` is at the side across from corner k, and its
    /// wing is node 3 + k. `None` if a triangle has no area.
    pub fn triangle(corners: [Vector3<f64>; 3], hinges: [Option<Hinge>; 3]) -> Option<Self> {
        let [a, b, c] = corners;
        let area = 0.5 * (b - a).cross(&(c - a)).norm();
        let along = (b - a).try_normalize(0.0)?;
        let across = (c - a - along * along.dot(&(c - a))).try_normalize(0.0)?;
        let side = |k: usize| [(k + 1) % 3, (k + 2) % 3];
        // n n^T of a side as the vector of its components xx, yy and sqrt(2) xy.
        let dyad = |k: usize| {
            let [from, to] = side(k).map(|corner| corners[corner]);
            let n = (to - from).normalize();
            let (x, y) = (n.dot(&across), -n.dot(&along));
            Vector3::new(x * x, y * y, SQRT_2 * x * y)
        };
        let mut free: Vec<Vector3<f64>> = Vec::with_capacity(3);
        let without = |free: &[Vector3<f64>], v| free.iter().fold(v, |v: Vector3<f64>, n| v - n * n.dot(&v));
        for k in (0..3).filter(|&k| hinges[k].is_none()) {
            free.extend(without(&free, dyad(k)).try_normalize(0.0));
        }
        let mut weights = [[0.0; 6]; 3];
        for (k, hinge) in hinges.iter().enumerate() {
            let Some(Hinge { wing, rigidity, clamped }) = *hinge else { continue };
            let [from, to] = side(k);
            let (jump, other) = jump([corners[from], corners[to], corners[k], wing]);
            let total = if clamped { area } else { area + other };
            let curvature = without(&free, dyad(k)) * ((area * rigidity).sqrt() / total);
            for (row, part) in weights.iter_mut().zip(&curvature) {
                for (node, c) in [from, to, k, 3 + k].into_iter().zip(jump) {
                    row[node] += part * c;
                }
            }
        }
        weights.as_flattened().iter().all(|w| w.is_finite()).then_some(BendingElement { weights })
    }
}

/// [-] Weights c of the edge a-b [m] with the wings c and d, and the area [m^2] of the triangle a-b-d.
fn jump([a, b, c, d]: [Vector3<f64>; 4]) -> ([f64; 4], f64) {
    let cotangent = |at: Vector3<f64>, p: Vector3<f64>, q: Vector3<f64>| {
        let (p, q) = (p - at, q - at);
        p.dot(&q) / p.cross(&q).norm()
    };
    let [at_a, at_b] = [[c, d].map(|wing| cotangent(a, b, wing)), [c, d].map(|wing| cotangent(b, a, wing))];
    let weights = [at_b[0] + at_b[1], at_a[0] + at_a[1], -at_a[0] - at_b[0], -at_a[1] - at_b[1]];
    (weights, 0.5 * (b - a).cross(&(d - a)).norm())
}

impl BendingElement<3, 1> {
    /// The node between two segments of these lengths [m], not both of which are held; `rigidity` is EI [N m^2].
    pub fn chain([before, after]: [f64; 2], held: [bool; 2], rigidity: f64) -> Option<Self> {
        let free: f64 = [before, after].into_iter().zip(held).filter(|(_, held)| !held).map(|(length, _)| length).sum();
        let root = (2.0 * rigidity / free).sqrt();
        let weights = [1.0 / before, -1.0 / before - 1.0 / after, 1.0 / after].map(|w| root * w);
        weights.iter().all(|w| w.is_finite()).then_some(BendingElement { weights: [weights] })
    }
}

impl<const N: usize, const R: usize> BendingElement<N, R> {
    /// The pairs of nodes, with -w_ri w_rj of every y.
    fn pairs(&self, nodes: [u32; N]) -> impl Iterator<Item = ([u32; 2], [f64; R])> + '_ {
        let pairs = (0..N).flat_map(move |i| (i + 1..N).map(move |j| [i, j]));
        // A side without a hinge has a corner in place of its wing, and two wings may meet.
        let apart = pairs.filter(move |&[i, j]| nodes[i] != nodes[j]);
        apart.map(move |[i, j]| ([nodes[i], nodes[j]], self.weights.map(|w| -w[i] * w[j])))
    }
}

/// Plain arrays of the elements.
#[derive(Clone, Debug)]
pub struct BendingData<const N: usize, const R: usize> {
    /// nodes of every element, in ascending order of their smallest
    pub nodes: Vec<[u32; N]>,
    /// one each
    pub elements: Vec<BendingElement<N, R>>,
}

impl<const N: usize, const R: usize> Kernel<N> for BendingData<N, R> {
    const READS: BufferReads = BufferReads { x: true, v: false };

    fn elements(&self) -> &[[u32; N]] {
        &self.nodes
    }

    fn add(&self, block: Elements<'_, N>, f: &mut Records) -> Tally {
        let mut energy = 0.0;
        for (nodes, i) in block.nodes.iter().zip(block.range()) {
            let BendingElement { weights } = &self.elements[i];
            // Relative to the first node, so that a far-away origin costs no digits.
            let from = vector(block.x, nodes[0]);
            let x = nodes.map(|node| vector(block.x, node) - from);
            let y = weights.map(|row| sum(&row, &x));
            energy += 0.5 * y.iter().map(Vector3::norm_squared).sum::<f64>();
            for (k, &node) in nodes.iter().enumerate() {
                let force = weights.iter().zip(&y).fold(Vector3::zeros(), |sum, (w, y)| sum - y * w[k]);
                add(f, node, force);
            }
        }
        Tally { energy, power: 0.0 }
    }
}

/// The sum of w_i x_i.
fn sum<const N: usize>(weights: &[f64; N], x: &[Vector3<f64>; N]) -> Vector3<f64> {
    weights.iter().zip(x).fold(Vector3::zeros(), |y, (w, x)| y + x * *w)
}

impl<const N: usize, const R: usize> ForceTerm for Bending<N, R> {
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
        for (&nodes, element) in data.nodes.iter().zip(&data.elements) {
            for (pair, c) in element.pairs(nodes) {
                sink.edge(pair, Matrix3::from_diagonal_element(w.k * c.iter().sum::<f64>()));
            }
        }
    }

    fn add_stiffness(&self, nodes: &mut [f64]) {
        let data = self.kernel();
        for (corners, BendingElement { weights }) in data.nodes.iter().zip(&data.elements) {
            for (k, &node) in corners.iter().enumerate() {
                nodes[node as usize] += weights.iter().map(|w| w[k] * w[k]).sum::<f64>();
            }
        }
    }

    fn for_run(&self, copies: &mut Copies) -> Box<dyn ForceTerm> {
        Box::new(Batch::for_run(self, copies))
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
            sum(weights, &nodes.map(|node| of[node as usize] - from))
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

    /// B; in the symmetric form with the direction of y on both sides.
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

impl<const N: usize, const R: usize> MeanForce for Bending<N, R> {
    fn add_mean(&self, step: MeanStep<'_>, f: &mut [Vector3<f64>]) -> Tally {
        let data = self.kernel();
        for (nodes, BendingElement { weights }) in data.nodes.iter().zip(&data.elements) {
            for row in weights {
                let bend = MeanBend::of(step, nodes, row);
                let force = bend.y * bend.factors()[1];
                for (&node, w) in nodes.iter().zip(row) {
                    f[node as usize] -= force * *w;
                }
            }
        }
        Tally::default()
    }

    fn mean_tangent(&self, step: MeanStep<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink) {
        let data = self.kernel();
        for (&nodes, element) in data.nodes.iter().zip(&data.elements) {
            let blocks = element.weights.map(|row| MeanBend::of(step, &nodes, &row).block(form) * w.k);
            for (pair, c) in element.pairs(nodes) {
                sink.edge(pair, blocks.iter().zip(c).fold(Matrix3::zeros(), |sum, (block, c)| sum + block * c));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f64; 2]; 3] = [[0.0, 0.0], [0.4, 0.1], [0.15, 0.3]];
    const RIGIDITY: f64 = 2.5;

    fn energy(element: &BendingElement<6, 3>, x: [Vector3<f64>; 6]) -> f64 {
        element.weights.iter().map(|row| 0.5 * sum(row, &x).norm_squared()).sum()
    }

    /// The triangle and its point reflections about the middles of its sides, raised by a function of the place.
    fn patch(height: impl Fn(f64, f64) -> f64) -> [Vector3<f64>; 6] {
        let [a, b, c] = CORNERS.map(|[x, y]| Vector3::new(x, y, 0.0));
        [a, b, c, b + c - a, c + a - b, a + b - c].map(|p| Vector3::new(p.x, p.y, height(p.x, p.y)))
    }

    fn element(keep: impl Fn(usize) -> bool, clamped: bool) -> BendingElement<6, 3> {
        let [a, b, c, wings @ ..] = patch(|_, _| 0.0);
        let hinge = |k: usize| keep(k).then_some(Hinge { wing: wings[k], rigidity: RIGIDITY, clamped });
        BendingElement::triangle([a, b, c], [0, 1, 2].map(hinge)).expect("an area")
    }

    fn area() -> f64 {
        let [_, [bx, by], [cx, cy]] = CORNERS;
        0.5 * (bx * cy - by * cx)
    }

    /// On a mesh of equal triangles a second-order surface has its own curvature: B/2 (xx^2 + yy^2 + 2 xy^2) per area.
    #[test]
    fn the_curvature_of_a_second_order_surface_is_exact() {
        let whole = element(|_| true, false);
        for [xx, yy, xy] in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.3, -0.7, 0.4]] {
            let x = patch(|x, y| 0.5 * xx * x * x + 0.5 * yy * y * y + xy * x * y + 0.2 * x - 0.1 * y + 3.0);
            let expected = 0.5 * RIGIDITY * area() * (xx * xx + yy * yy + 2.0 * xy * xy);
            assert!((energy(&whole, x) / expected - 1.0).abs() < 1e-12, "{xx} {yy} {xy}");
        }
    }

    /// A free side has the curvature across it that costs least: with t along it, 2 (n t)^2 + (t t)^2 remain.
    #[test]
    fn no_moment_acts_at_a_free_side() {
        let [_, b, c, ..] = patch(|_, _| 0.0);
        let t = (c - b).normalize();
        let n = Vector3::new(t.y, -t.x, 0.0);
        let [xx, yy, xy] = [0.3, -0.7, 0.4];
        let x = patch(|x, y| 0.5 * xx * x * x + 0.5 * yy * y * y + xy * x * y);
        let along = |p: Vector3<f64>, q: Vector3<f64>| xx * p.x * q.x + yy * p.y * q.y + xy * (p.x * q.y + p.y * q.x);
        let expected = 0.5 * RIGIDITY * area() * (along(t, t).powi(2) + 2.0 * along(n, t).powi(2));
        assert!((energy(&element(|k| k != 0, false), x) / expected - 1.0).abs() < 1e-12);
    }

    /// Beside a clamp the whole angle is in the free triangle: its curvature is twice that between two free ones.
    #[test]
    fn a_clamp_has_no_part_in_the_angle() {
        let x = patch(|x, y| x * x - 0.4 * y * y + 0.3 * x * y);
        let [free, clamped] = [false, true].map(|clamped| energy(&element(|_| true, clamped), x));
        assert!((clamped / free - 4.0).abs() < 1e-12);
        let [free, clamped] = [false, true].map(|held| BendingElement::chain([0.2; 2], [held, false], RIGIDITY));
        let root = |element: Option<BendingElement<3, 1>>| element.expect("a free segment").weights[0][0];
        assert!((root(clamped) / root(free) - 2.0_f64.sqrt()).abs() < 1e-12);
    }
}
