//! Membrane triangles of constant strain: St. Venant-Kirchhoff sheets, isotropic or orthotropic, taut or wrinkled.
//!
//! ```text
//! F = [x1 - x0, x2 - x0] R,   E = 1/2 (F^T F - X^2)                        strain in scaled axes of the material
//! energy = A0 W(E),   S = dW/dE by the tension field, or C^-1 E            force on node a = -A0 F S g_a
//! K_ab = A0 [(g_a . S g_b) I + B_a^T (dS/dE) B_b],   B_a = dE/dx_a         g_1, g_2: rows of R, g_0 = -g_1 - g_2
//! ```
//! X = diag(x_1, x_2) with x_i^4 = E_i t scales the axes ([`crate::force::law::tension_field`]). Stiffness damping with
//! the time tau acts together with the sheet, as an axial dashpot does with its spring: the stress is S(E + tau dE/dt),
//! of which S(E) is elastic. As S is monotone, damping never makes energy, and a slack sheet has none.
//! ```text
//! K_ab = A0 [(g_a . S_d g_b) I + B_a^T (S'(E + tau dE/dt)(B_b + tau dB_b/dt) - S'(E) B_b)]          (damping alone)
//! C_ab = A0 tau B_a^T S'(E + tau dE/dt) B_b
//! ```

mod mean;
mod mixed;

use crate::force::kernel::batch::{BlockForces, BufferReads, PARTS, Records};
use crate::force::kernel::element_block::{ElementBlock, vector};
use crate::force::kernel::sheet_batches::{Group, GroupShapes, SIDE_BY_SIDE, SheetLaw, SheetPass, SheetStress};
use crate::force::law::rayleigh_membrane::RestTriangle;
use crate::force::law::tension_field::{Sheet, Voigt, Wrinkling};
use crate::force::{Copies, ForceTerm, MeanForce, NodeState, SheetTerm, TangentForm, TangentSink};
use crate::model::forces::{Role, Tally};
use crate::model::quad::{self, Real};
use crate::model::system::{StepMean, TermInfo, Weights};
use nalgebra::{Matrix2, Matrix3, Matrix3x2, Vector2, Vector3};
use std::ops::Range;
use std::sync::Arc;

const MEMBRANE: TermInfo = TermInfo { on_triangles: true, ..TermInfo::of("membrane", Role::Elastic) };
const DAMPING: TermInfo =
    TermInfo { velocity_dependent: true, on_triangles: true, ..TermInfo::of("membrane damping", Role::Dissipative) };

/// The rest shape of a triangle, in scaled axes.
#[derive(Clone, Copy, Debug)]
pub struct RestShape {
    /// [x/m] R: inverse of the sides in the axes of the material, times X
    pub r: Matrix2<f64>,
    /// [m^2] A0
    pub area: f64,
}

impl RestShape {
    /// Of a triangle with these sides [m] from its first corner, a material whose first axis is `warp` (or its
    /// projection on the triangle), and the factors X. `None` for a triangle without an area, or a warp direction at
    /// right angles to it.
    pub fn new([p, q]: [Vector3<f64>; 2], warp: Vector3<f64>, scale: [f64; 2]) -> Option<Self> {
        let normal = p.cross(&q);
        let n = normal.try_normalize(0.0)?;
        let first = (warp - n * n.dot(&warp)).try_normalize(SMALL * warp.norm())?;
        let second = n.cross(&first);
        let sides = Matrix2::new(first.dot(&p), first.dot(&q), second.dot(&p), second.dot(&q));
        let r = sides.try_inverse()? * Matrix2::from_diagonal(&Vector2::from(scale));
        Some(RestShape { r, area: 0.5 * normal.norm() })
    }

    /// Gradients of the shape functions of the three corners, in scaled axes.
    fn gradients(&self) -> [Vector2<f64>; 3] {
        let [second, third] = [self.r.row(0).transpose(), self.r.row(1).transpose()];
        [-second - third, second, third]
    }
}

/// [-] Strain below which a sheet counts as taut: the sign of a rounding error says nothing.
const UNSTRAINED: f64 = 1e-13;

/// [-] Sine of the least angle between the warp direction and the normal of a triangle.
const SMALL: f64 = 1e-6;

/// Plain data of a batch of triangles of one material.
#[derive(Clone, Debug)]
pub struct MembraneData {
    /// vertices
    pub triangles: Arc<[[u32; 3]]>,
    /// one a triangle
    pub shapes: Arc<[RestShape]>,
    /// [(N/m)^(1/4)] X
    pub scale: [f64; 2],
    /// the material
    pub sheet: Sheet,
    /// [s] tau of stiffness damping; 0 for none
    pub damping_time: f64,
}

/// What a triangle is like at a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MembraneState {
    /// [N/m] principal forces per current width, the larger first
    pub tension: [f64; 2],
    /// [-] principal Green strains, the larger first
    pub strain: [f64; 2],
    /// whether it is taut
    pub wrinkling: Wrinkling,
    /// unit vector along the warp
    pub warp: Vector3<f64>,
}

impl MembraneData {
    fn deformation(&self, i: usize, x: &[Vector3<f64>]) -> Matrix3x2<f64> {
        let [a, b, c] = self.triangles[i].map(|node| x[node as usize]);
        Matrix3x2::from_columns(&[b - a, c - a]) * self.shapes[i].r
    }

    fn strain(&self, f: &Matrix3x2<f64>) -> Voigt {
        let c = f.transpose() * f;
        let [one, two] = self.squares();
        [0.5 * (c[(0, 0)] - one), 0.5 * (c[(1, 1)] - two), c[(0, 1)]]
    }

    /// The sheet at a strain: the sign of a rounding error is no wrinkle.
    fn sheet_at(&self, strain: Voigt) -> Sheet {
        let [one, two] = self.scale;
        let sizes = [one * one, two * two, one * two];
        let unstrained = strain.iter().zip(sizes).all(|(e, size)| e.abs() < UNSTRAINED * size);
        Sheet { wrinkles: self.sheet.wrinkles && !unstrained, ..self.sheet }
    }

    fn squares(&self) -> [f64; 2] {
        self.scale.map(|x| x * x)
    }

    /// What triangle `i` is like.
    pub fn state(&self, i: usize, x: &[Vector3<f64>]) -> MembraneState {
        let (f, [one, two]) = (self.deformation(i, x), self.scale);
        let strain = self.strain(&f);
        let s = self.sheet.stress(strain);
        // Cauchy's, as a force per width: F S F^T/J in the plane of the triangle.
        let [u, v] = [f.column(0).into_owned(), f.column(1).into_owned()];
        let area = u.cross(&v).norm();
        let trace = s[0] * u.dot(&u) + s[1] * v.dot(&v) + 2.0 * s[2] * u.dot(&v);
        let det = (s[0] * s[1] - s[2] * s[2]) * area * area;
        // The area ratio in scaled axes is J x_1 x_2.
        let ratio = area / (one * two);
        let tension = if ratio > 0.0 { principal(trace, det).map(|t| t / ratio) } else { [0.0; 2] };
        let green = [strain[0] / (one * one), strain[1] / (two * two), 0.5 * strain[2] / (one * two)];
        let principal_strain = principal(green[0] + green[1], green[0] * green[1] - green[2] * green[2]);
        let warp = u.try_normalize(0.0).unwrap_or_default();
        let wrinkling = self.sheet_at(strain).wrinkling(strain);
        MembraneState { tension, strain: principal_strain, wrinkling, warp }
    }

    /// [-] Square of the largest stretch of triangle `i`.
    fn largest_stretch(&self, f: &Matrix3x2<f64>) -> f64 {
        let [one, two] = self.scale;
        let [u, v] = [f.column(0) / one, f.column(1) / two];
        let (a, b, c) = (u.norm_squared(), v.norm_squared(), u.dot(&v));
        0.5 * (a + b) + (0.5 * (a - b)).hypot(c)
    }

    /// [-] Square of the largest stretch of all triangles, -inf without any.
    pub fn largest_stretch_of_all(&self, x: &[Vector3<f64>]) -> f64 {
        (0..self.triangles.len())
            .map(|i| self.largest_stretch(&self.deformation(i, x)))
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// Triangle `i` at positions `rest` [m], for Rayleigh damping with the factor `beta` [s].
    pub fn at_rest(&self, i: usize, rest: &[Vector3<f64>], beta: f64) -> RestTriangle {
        let (f, shape) = (self.deformation(i, rest), &self.shapes[i]);
        let matrix = matrix(Sheet { wrinkles: false, ..self.sheet }.tangent([0.0; 3])) * (beta * shape.area);
        RestTriangle { by_node: shape.gradients().map(|g| strain_by_node(&f, &g)), matrix }
    }

    /// dS/dE.
    fn stiffness(&self, strain: Voigt) -> Matrix3<f64> {
        matrix(self.sheet_at(strain).tangent(strain))
    }

    /// Strain E of a triangle, and E + tau dE/dt at the rate of its deformation.
    fn strains(&self, [f, rate]: [&Matrix3x2<f64>; 2]) -> [Voigt; 2] {
        let strain = self.strain(f);
        let (mut total, tau) = (strain, self.damping_time);
        if tau > 0.0 {
            let moved = strain_along([f, rate]);
            (0..3).for_each(|j| total[j] += tau * moved[j]);
        }
        [strain, total]
    }

    /// Blocks of `w.c C + w.k K` of triangle `i`, elastic and damping parts together. The elastic one is a mean over
    /// the step around the state, if one is given.
    fn blocks(
        &self,
        i: usize,
        (at, mean): (NodeState<'_>, Option<StepMean>),
        w: Weights,
        form: TangentForm,
    ) -> [[Matrix3<f64>; 3]; 3] {
        let (RestShape { area, .. }, g) = (self.shapes[i], self.shapes[i].gradients());
        let [f, rate] = [at.x, at.v].map(|of| self.deformation(i, of));
        let (strains @ [strain, total], tau) = (self.strains([&f, &rate]), self.damping_time);
        let b = g.map(|g| strain_by_node(&f, &g));
        // The symmetric form is that of the elastic stress, with damping by velocities alone.
        let damped = if tau > 0.0 { self.stiffness(total) } else { Matrix3::zeros() };
        let exact = tau > 0.0 && !form.symmetric;
        let moved = || {
            let rates = g.map(|g| strain_by_node(&rate, &g) * tau);
            [0, 1, 2].map(|q| b[q] + rates[q])
        };
        let nothing = (Matrix3::zeros(), b);
        let (stress, products) = match mean {
            None if exact => (self.sheet.stress(total), [(damped, moved()), nothing, nothing]),
            None => (self.sheet.stress(strain), [(self.stiffness(strain), b), nothing, nothing]),
            Some(mean) => {
                let found = self.mean_sheet([&f, &rate], mean);
                let elastic = match form.symmetric {
                    true => (found.symmetric, b),
                    false => (found.exact, g.map(|g| strain_by_node(&(f + rate * mean.half), &g))),
                };
                if exact {
                    let [without, with] = strains.map(|strain| self.sheet.stress(strain));
                    let stress = [0, 1, 2].map(|j| found.stress[j] + (with[j] - without[j]));
                    (stress, [elastic, (damped, moved()), (-self.stiffness(strain), b)])
                } else {
                    (found.stress, [elastic, nothing, nothing])
                }
            }
        };
        let stress = Matrix2::new(stress[0], stress[2], stress[2], stress[1]);
        let stress = if form.convex { without_compression(stress) } else { stress };
        let used = if mean.is_some() && exact { 3 } else { 1 };
        let block = |p: usize, q: usize| {
            let along = Matrix3::from_diagonal_element(g[p].dot(&(stress * g[q])));
            let terms = products[..used].iter().map(|(matrix, by)| b[p].transpose() * matrix * by[q]);
            let k = terms.fold(along, |sum, term| sum + term);
            (k * w.k + b[p].transpose() * damped * b[q] * (tau * w.c)) * area
        };
        [0, 1, 2].map(|p| [0, 1, 2].map(|q| block(p, q)))
    }
}

/// The larger and the smaller eigenvalue of a symmetric 2x2 matrix.
fn principal(trace: f64, det: f64) -> [f64; 2] {
    let (half, root) = (0.5 * trace, (0.25 * trace * trace - det).max(0.0).sqrt());
    [half + root, half - root]
}

fn without_compression(stress: Matrix2<f64>) -> Matrix2<f64> {
    let eigen = stress.symmetric_eigen();
    let kept = eigen.eigenvalues.map(|value| value.max(0.0));
    eigen.eigenvectors * Matrix2::from_diagonal(&kept) * eigen.eigenvectors.transpose()
}

fn matrix(rows: [Voigt; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

/// d(E11, E22, 2 E12) of a deformation that changes by the second matrix.
fn strain_along([f, change]: [&Matrix3x2<f64>; 2]) -> Voigt {
    let c = f.transpose() * change;
    [c[(0, 0)], c[(1, 1)], c[(0, 1)] + c[(1, 0)]]
}

/// d(E11, E22, 2 E12)/dx of the node with the gradient g.
fn strain_by_node(f: &Matrix3x2<f64>, g: &Vector2<f64>) -> Matrix3<f64> {
    let [u, v] = [f.column(0).transpose(), f.column(1).transpose()];
    Matrix3::from_rows(&[u * g.x, v * g.y, u * g.y + v * g.x])
}

/// Membrane triangles as a force term of one or two parts: elastic, and damping.
#[derive(Clone, Debug)]
pub struct Membrane {
    data: MembraneData,
    placed: Arc<Placed>,
}

/// The triangles of all blocks.
#[derive(Clone, Debug, Default)]
struct Placed {
    groups: Vec<Group>,
    shapes: Vec<GroupShapes>,
    /// triangles of every block, and their groups
    blocks: Vec<(Range<usize>, Range<usize>)>,
    local: Vec<[u16; 3]>,
}

impl Membrane {
    /// Node numbers must be below the number of nodes that the term will be used with, and triangles in ascending order
    /// of their smallest node.
    pub fn new(data: MembraneData) -> Self {
        Membrane { data, placed: Arc::default() }
    }

    fn pass<L: SheetLaw>(&self, law: &L, block: &ElementBlock<'_>, sums: [Option<&mut Records>; PARTS]) -> [f64; 2] {
        let Some((_, groups)) = self.placed.blocks.get(block.number) else { return [0.0; 2] };
        let (groups, shapes) = (&self.placed.groups[groups.clone()], &self.placed.shapes[groups.clone()]);
        quad::run(SheetPass { law, scale: self.data.squares(), groups, shapes, x: block.x, v: block.v, sums })
    }
}

/// The law of the sheet for the kernel, with the time of its damping [s].
struct Law<const ELASTIC: bool, const DAMPED: bool>(Sheet, f64);

impl<const ELASTIC: bool, const DAMPED: bool> SheetLaw for Law<ELASTIC, DAMPED> {
    const ELASTIC: bool = ELASTIC;
    const DAMPED: bool = DAMPED;

    #[inline(always)]
    fn stress<R: Real>(&self, strain: [R; 3], rate: [R; 3]) -> SheetStress<R> {
        let elastic = self.0.stress(strain);
        if !DAMPED {
            return SheetStress { elastic, damping: elastic };
        }
        let tau = strain[0].all(self.1);
        let total = [strain[0] + tau * rate[0], strain[1] + tau * rate[1], strain[2] + tau * rate[2]];
        let total = self.0.stress(total);
        let damping = [total[0] - elastic[0], total[1] - elastic[1], total[2] - elastic[2]];
        SheetStress { elastic, damping }
    }
}

impl BlockForces for Membrane {
    fn elements(&self) -> usize {
        self.data.triangles.len()
    }

    fn reads(&self, [_, damping]: [bool; PARTS]) -> BufferReads {
        BufferReads { x: true, v: damping }
    }

    fn element(&self, number: usize) -> Option<&[u32]> {
        self.data.triangles.get(number).map(|nodes| nodes.as_slice())
    }

    fn assign_block(&mut self, block: usize, elements: Range<usize>, place: &dyn Fn(u32) -> u16) {
        let placed = Arc::make_mut(&mut self.placed);
        if block == 0 {
            *placed = Placed::default();
        }
        let first = placed.groups.len();
        placed.local.extend(self.data.triangles[elements.clone()].iter().map(|nodes| nodes.map(place)));
        for (nodes, shapes) in placed.local[elements.clone()]
            .chunks(SIDE_BY_SIDE)
            .zip(self.data.shapes[elements.clone()].chunks(SIDE_BY_SIDE))
        {
            // Filled up with triangles between a node and itself, of no area.
            let mut group = [[nodes[0][0]; 3]; SIDE_BY_SIDE];
            let mut of_group = [[0.0; SIDE_BY_SIDE]; 5];
            for (i, (nodes, shape)) in nodes.iter().zip(shapes).enumerate() {
                group[i] = *nodes;
                let r = &shape.r;
                let numbers = [r[(0, 0)], r[(0, 1)], r[(1, 0)], r[(1, 1)], shape.area];
                of_group.iter_mut().zip(numbers).for_each(|(to, number)| to[i] = number);
            }
            placed.groups.push(group);
            placed.shapes.push(of_group);
        }
        placed.blocks.push((elements, first..placed.groups.len()));
    }

    fn add(&self, block: &ElementBlock<'_>, sums: [Option<&mut Records>; PARTS]) -> [Tally; PARTS] {
        let (sheet, tau) = (self.data.sheet, self.data.damping_time);
        let [energy, power] = match [sums[0].is_some(), sums[1].is_some() && tau > 0.0] {
            [true, true] => self.pass(&Law::<true, true>(sheet, tau), block, sums),
            [true, false] => self.pass(&Law::<true, false>(sheet, tau), block, sums),
            [false, true] => self.pass(&Law::<false, true>(sheet, tau), block, sums),
            [false, false] => [0.0; 2],
        };
        [Tally { energy, power: 0.0 }, Tally { energy: 0.0, power }]
    }

    fn largest_stretch(&self, block: &ElementBlock<'_>) -> f64 {
        let elements = self.placed.blocks.get(block.number).map_or(0..0, |(elements, _)| elements.clone());
        let stretch = |i: usize| {
            let [a, b, c] = self.placed.local[i].map(|place| vector(block.x, place));
            self.data.largest_stretch(&(Matrix3x2::from_columns(&[b - a, c - a]) * self.data.shapes[i].r))
        };
        elements.map(stretch).fold(f64::NEG_INFINITY, f64::max)
    }
}

impl ForceTerm for Membrane {
    fn parts(&self) -> &[TermInfo] {
        if self.data.damping_time > 0.0 { &[MEMBRANE, DAMPING] } else { &[MEMBRANE] }
    }

    fn symmetric(&self) -> bool {
        self.data.damping_time == 0.0
    }

    /// The convex form leaves out compression where the stress turns with the triangle.
    fn tangent(&self, at: NodeState<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink) {
        for (i, &nodes) in self.data.triangles.iter().enumerate() {
            sink.triangle(nodes, &self.data.blocks(i, (at, None), w, form));
        }
    }

    fn mean(&self) -> Option<&dyn MeanForce> {
        Some(self)
    }

    fn sheets(&self) -> Option<&dyn SheetTerm> {
        Some(self)
    }

    fn add_stiffness(&self, nodes: &mut [f64]) {
        let Sheet { poisson, compliance, .. } = self.data.sheet;
        let [one, two] = self.data.squares();
        let largest = one.max(two) * (1.0 / (1.0 - poisson.abs())).max(2.0 / compliance);
        for (corners, shape) in self.data.triangles.iter().zip(self.data.shapes.iter()) {
            for (&node, g) in corners.iter().zip(shape.gradients()) {
                nodes[node as usize] += shape.area * g.norm_squared() * largest;
            }
        }
    }

    fn for_run(&self, _: &mut Copies) -> Box<dyn ForceTerm> {
        Box::new(self.clone())
    }
}
