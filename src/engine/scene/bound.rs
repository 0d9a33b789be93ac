//! A bound on the largest eigenvalue of M^-1 (c C + k K) from one pass over the elements, without an eigenproblem.
//!
//! A positive semidefinite element matrix of b x b blocks lies below b times its block diagonal. So the sum over all
//! elements lies below the largest eigenvalue of any node's 3 x 3 block (in the spirit of Irons & Treharne 1971, by
//! nodes). Fixed ends do not count in b. On a regular triangular net the bound is exact.
//!
//! An edge with the block B may be divided unequally: it lies below (1 + r) B at one end and (1 + 1/r) B at the other,
//! for any r > 0. The sharper bound takes for r the ratio of shares of the two nodes, and lowers these shares, round
//! after round, where eigenvalues are large (in the spirit of Collatz 1942, who bounds matrices without negative
//! entries so). It takes edges that are alike in all directions by triangles ([`super::bound_by_triangles`]).

use super::bound_by_triangles::AlikeEdges;
use super::network::{Network, by_node, node_state};
use crate::force::{TangentForm, TangentSink};
use crate::model::at_dof::AtDof;
use crate::model::state::StateRef;
use crate::model::system::{TermInfo, Weights};
use nalgebra::{Matrix3, Vector3};

/// Buffers of passes over one scene, and what stays the same between them.
#[derive(Clone, Debug, Default)]
pub struct BoundBuffer {
    /// one of every node
    blocks: Vec<Block>,
    /// the last bound on C alone, where C is the same at every state of a phase
    damping: Option<DampingBound>,
}

/// A bound on C, and what it belongs to.
#[derive(Clone, Copy, Debug)]
struct DampingBound {
    /// events that are passed
    passed: usize,
    /// weight of C
    c: f64,
    found: AtDof,
}

/// [-] Relative error of the largest eigenvalue where eigenvalues of a block nearly coincide, as in an isotropic net:
/// rounding moves them by some 1e-8. Larger values by less than this share count as equal, and the bound includes it.
const MARGIN: f64 = 1e-7;

/// The symmetric part of a 3 x 3 block: its diagonal, then xy, yz and zx.
type Block = [f64; 6];

impl Network {
    /// The bound [1/s^2 or 1/s, by the weights] and the degree of freedom where it is reached. Proved if K and C are
    /// symmetric (compressive geometric stiffness is dropped); else a measure that grows with the eigenvalue.
    pub(super) fn node_bound(&self, at: StateRef<'_>, w: Weights, buffer: &mut BoundBuffer) -> AtDof {
        let BoundBuffer { blocks, damping } = buffer;
        let emit = |sink: &mut dyn TangentSink| self.emit_for_bound(at, w, sink);
        let constant = |info: &TermInfo| info.constant_damping || !info.velocity_dependent;
        if w.k != 0.0 || !self.arrangement.infos.iter().all(constant) {
            return self.bound_in_pass(emit, blocks, None);
        }
        let (passed, c) = (self.passed(), w.c);
        let known = damping.filter(|known| known.passed == passed && known.c == c);
        let found = known.map_or_else(|| self.bound_in_pass(emit, blocks, None), |known| known.found);
        *damping = Some(DampingBound { passed, c, found });
        found
    }

    /// The same from up to [`ROUNDS`] passes, with edges divided unequally.
    pub(super) fn sharper_node_bound(&self, at: StateRef<'_>, w: Weights) -> AtDof {
        self.bound_in_rounds(|sink| self.emit_for_bound(at, w, sink))
    }

    fn emit_for_bound(&self, at: StateRef<'_>, w: Weights, sink: &mut dyn TangentSink) {
        self.emit_tangents(at, w, FORM, sink);
        self.force_terms().for_each(|term| term.coupling_bound(node_state(at), w, sink));
    }

    /// The same of what `emit` gives.
    pub(super) fn bound_in_rounds(&self, emit: impl Fn(&mut dyn TangentSink)) -> AtDof {
        let (mut blocks, mut best) = (Vec::new(), AtDof { value: f64::INFINITY, dof: 0 });
        let mut unequal = Unequal { share: vec![1.0; self.phase().fixed.len()], alike: AlikeEdges::default() };
        for _ in 0..ROUNDS {
            let found = self.bound_in_pass(&emit, &mut blocks, Some(&mut unequal));
            let settled = found.value.is_nan() || found.value >= SETTLED * best.value;
            if found.value.is_nan() || found.value < best.value {
                best = found;
            }
            if settled {
                break;
            }
            let shares = unequal.share.iter_mut().zip(&blocks);
            for ((share, block), inverse) in shares.zip(by_node(&self.phase().inverse_mass)) {
                let size = (size(&scaled(block, *inverse)) / found.value).max(LEAST);
                // The power 3/2 of it; shares swing from 2 on.
                *share /= size * size.sqrt();
            }
        }
        best
    }

    fn bound_in_pass(
        &self,
        emit: impl FnOnce(&mut dyn TangentSink),
        blocks: &mut Vec<Block>,
        mut unequal: Option<&mut Unequal>,
    ) -> AtDof {
        sum_blocks(blocks, &self.phase().fixed, unequal.as_deref_mut(), emit);
        if let Some(Unequal { share, alike }) = unequal {
            alike.bound(share, |node, value| {
                blocks[node as usize].iter_mut().take(3).for_each(|sum| *sum += value);
            });
        }
        let (mut most, mut dof) = (0.0, 0);
        for (i, (block, inverse)) in blocks.iter().zip(by_node(&self.phase().inverse_mass)).enumerate() {
            let block = scaled(block, *inverse);
            // Much cheaper than the eigenvalue, which is then needed only a few times in a uniform net.
            if !lies_below(&block, (1.0 + 0.5 * MARGIN) * most) {
                let largest = largest_root(&block);
                if largest.is_nan() || largest > most {
                    (most, dof) = (largest, 3 * i + (0..3).max_by(|&a, &b| block[a].total_cmp(&block[b])).unwrap_or(0));
                }
            }
        }
        AtDof { value: (1.0 + MARGIN) * most, dof }
    }
}

/// Most passes of the sharper bound.
const ROUNDS: usize = 8;
/// [-] A bound above this share of the best one before ends them.
const SETTLED: f64 = 0.99;
/// [-] Smallest eigenvalue of a node, over the largest, that its share follows.
const LEAST: f64 = 0.3;

/// A mean of the eigenvalues of a positive semidefinite block in which the largest count most: tr A^2/tr A.
fn size([xx, yy, zz, xy, yz, zx]: &Block) -> f64 {
    let squares = xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + yz * yz + zx * zx);
    if squares > 0.0 { squares / (xx + yy + zz) } else { 0.0 }
}

/// What is emitted for a bound.
pub(super) const FORM: TangentForm = TangentForm { convex: true, symmetric: false };

/// The blocks of a matrix that `emit` gives element by element.
fn sum_blocks(
    blocks: &mut Vec<Block>,
    fixed: &[[bool; 3]],
    unequal: Option<&mut Unequal>,
    emit: impl FnOnce(&mut dyn TangentSink),
) {
    blocks.clear();
    blocks.resize(fixed.len(), Block::default());
    emit(&mut Diagonal { blocks, fixed, unequal });
}

/// Bounds by node: the matrix that `emit` gives lies below the diagonal one with these numbers, in the directions that
/// are not fixed.
pub(super) fn largest_by_node(fixed: &[[bool; 3]], emit: impl FnOnce(&mut dyn TangentSink)) -> Vec<f64> {
    let mut blocks = Vec::new();
    sum_blocks(&mut blocks, fixed, None, emit);
    let free = |fixed: &[bool; 3]| Vector3::from(fixed.map(|fixed| f64::from(!fixed)));
    let bound = |(block, fixed): (&Block, &[bool; 3])| (1.0 + MARGIN) * largest_root(&scaled(block, free(fixed)));
    blocks.iter().zip(fixed).map(bound).collect()
}

/// M^-1/2 A M^-1/2.
fn scaled([xx, yy, zz, xy, yz, zx]: &Block, inverse: Vector3<f64>) -> Block {
    let [x, y, z] = inverse.into();
    if x == y && y == z {
        return [xx, yy, zz, xy, yz, zx].map(|a| x * a);
    }
    [x * xx, y * yy, z * zz, (x * y).sqrt() * xy, (y * z).sqrt() * yz, (z * x).sqrt() * zx]
}

/// Whether all eigenvalues are below `most`: `most I - A` is positive definite (Sylvester's criterion). False for NaN.
fn lies_below([xx, yy, zz, xy, yz, zx]: &Block, most: f64) -> bool {
    let [x, y, z] = [most - xx, most - yy, most - zz];
    let minor = x * y - xy * xy;
    let determinant = z * minor - x * yz * yz - y * zx * zx - 2.0 * xy * yz * zx;
    x > 0.0 && minor > 0.0 && determinant > 0.0
}

/// Largest eigenvalue (Smith 1961).
fn largest_root([xx, yy, zz, xy, yz, zx]: &Block) -> f64 {
    let mean = (xx + yy + zz) / 3.0;
    let [x, y, z] = [xx - mean, yy - mean, zz - mean];
    let p = ((x * x + y * y + z * z + 2.0 * (xy * xy + yz * yz + zx * zx)) / 6.0).sqrt();
    if p == 0.0 {
        return mean;
    }
    let [x, y, z, xy, yz, zx] = [x, y, z, *xy, *yz, *zx].map(|a| a / p);
    let half = 0.5 * (x * (y * z - yz * yz) - xy * (xy * z - yz * zx) + zx * (xy * yz - y * zx));
    mean + 2.0 * p * (half.clamp(-1.0, 1.0).acos() / 3.0).cos()
}

/// How edges are divided.
struct Unequal {
    /// [-] of every node in its edges
    share: Vec<f64>,
    /// those that are taken by triangles
    alike: AlikeEdges,
}

/// Sums the diagonal blocks of elements, each times the number of its ends that can move.
struct Diagonal<'a> {
    blocks: &'a mut [Block],
    fixed: &'a [[bool; 3]],
    /// else all edges are divided equally
    unequal: Option<&'a mut Unequal>,
}

impl Diagonal<'_> {
    fn moving<const N: usize>(&self, nodes: [u32; N]) -> f64 {
        nodes.iter().filter(|&&i| self.fixed[i as usize] != [true; 3]).count() as f64
    }

    /// An element with any blocks.
    fn element<const N: usize>(&mut self, nodes: [u32; N], blocks: &[[Matrix3<f64>; N]; N]) {
        let moving = self.moving(nodes);
        for (p, &i) in nodes.iter().enumerate() {
            self.add(i, &symmetric(moving, &blocks[p][p]));
        }
    }

    fn add(&mut self, i: u32, block: &Block) {
        for (sum, added) in self.blocks[i as usize].iter_mut().zip(block) {
            *sum += added;
        }
    }
}

/// The symmetric part of `times A`.
fn symmetric(times: f64, a: &Matrix3<f64>) -> Block {
    let half = 0.5 * times;
    [
        times * a.m11,
        times * a.m22,
        times * a.m33,
        half * (a.m21 + a.m12),
        half * (a.m32 + a.m23),
        half * (a.m13 + a.m31),
    ]
}

impl TangentSink for Diagonal<'_> {
    /// A block B beside the diagonal, with its transpose, lies below |B| at both nodes; half of it comes from each.
    fn pair(&mut self, [i, j]: [u32; 2], block: Matrix3<f64>) {
        if i == j {
            return self.add(i, &symmetric(1.0, &block));
        }
        let half = 0.5 * block.norm();
        for node in [i, j] {
            self.add(node, &[half, half, half, 0.0, 0.0, 0.0]);
        }
    }

    fn edge(&mut self, nodes: [u32; 2], block: Matrix3<f64>) {
        let (moving, mut times) = (self.moving(nodes), [1.0; 2]);
        if moving == 2.0 {
            times = [2.0; 2];
            // Between the nodes of a hinge some blocks are c I with c below 0, which lies below 0.
            if block.m11 < 0.0 && block == Matrix3::from_diagonal_element(block.m11) {
                return;
            }
            if let Some(Unequal { share, alike }) = &mut self.unequal {
                if block == Matrix3::from_diagonal_element(block.m11) {
                    return alike.push(nodes, block.m11);
                }
                let [a, b] = nodes.map(|i| share[i as usize]);
                times = [1.0 + a / b, 1.0 + b / a];
            }
        }
        for (i, times) in nodes.into_iter().zip(times) {
            self.add(i, &symmetric(times, &block));
        }
    }

    fn segment(&mut self, nodes: [u32; 2], blocks: &[[Matrix3<f64>; 2]; 2]) {
        self.element(nodes, blocks);
    }

    fn triangle(&mut self, nodes: [u32; 3], blocks: &[[Matrix3<f64>; 3]; 3]) {
        self.element(nodes, blocks);
    }

    fn none(&mut self, _: &[u32]) {}

    /// An element L L^T with the blocks B_jj = L_j L_j^T lies below B_jj sum(a)/a_j at its nodes, for any a > 0: here
    /// the root of the trace of B_jj, which is right for one of rank one.
    fn few(&mut self, nodes: &[u32], blocks: &[[Matrix3<f64>; 4]; 4]) {
        let moves = |node: u32| self.fixed[node as usize] != [true; 3];
        let size = |j: usize| if moves(nodes[j]) { blocks[j][j].trace().max(0.0).sqrt() } else { 0.0 };
        let all: f64 = (0..nodes.len()).map(size).sum();
        let parts: [f64; 4] = std::array::from_fn(|j| if j < nodes.len() { size(j) } else { 0.0 });
        for (j, (&node, part)) in nodes.iter().zip(parts).enumerate().filter(|(_, (_, part))| *part > 0.0) {
            self.add(node, &symmetric(all / part, &blocks[j][j]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    fn block(a: &Matrix3<f64>) -> Block {
        [a.m11, a.m22, a.m33, a.m21, a.m32, a.m13]
    }

    fn turned(roots: [f64; 3], rotation: Matrix3<f64>) -> Block {
        block(&(rotation * Matrix3::from_diagonal(&Vector3::from(roots)) * rotation.transpose()))
    }

    /// In a hundred directions, within the margin where roots meet and to 1e-12 where they do not.
    #[test]
    fn roots_and_what_lies_above_them_in_all_directions() {
        for roots in
            [[3.0, 2.0, 1.0], [5.0, 5.0, -2.0], [1.0, 1.0, 0.0], [0.0, 0.0, 0.0], [-1.0, -4.0, -4.0], [7.0, 7.0, 7.0]]
        {
            for turn in 0..100 {
                let angle = f64::from(turn);
                let axis = Vector3::new(angle.sin(), 2.0 + angle.cos(), (2.0 * angle).sin()).normalize();
                let rotation = *Rotation3::new(axis * 0.7 * angle).matrix();
                let a = turned(roots, rotation);
                let apart = roots[0] > roots[1] && roots[1] > roots[2];
                let close = if apart { 1e-12 } else { 0.4 * MARGIN * (1.0 + roots[0].abs()) };
                assert!((largest_root(&a) - roots[0]).abs() < close, "{roots:?}: {}", largest_root(&a));
                assert!(lies_below(&a, roots[0] + 1e-6), "{roots:?}");
                // Below the largest and above the others, below two, and below all of them.
                for most in [roots[0] - 1e-6, roots[1] - 1e-6, roots[2] - 1e-6] {
                    assert!(!lies_below(&a, most), "{roots:?}, {most}");
                }
            }
        }
        for at in 0..6 {
            let mut a: Block = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
            a[at] = f64::NAN;
            assert!(!lies_below(&a, 10.0) && largest_root(&a).is_nan(), "{at}");
        }
    }

    /// M^-1/2 A M^-1/2 has the roots of M^-1 A, whatever the masses.
    #[test]
    fn blocks_are_scaled_by_masses() {
        let a = Matrix3::new(4.0, 1.0, -2.0, 1.0, 3.0, 0.5, -2.0, 0.5, 5.0);
        for inverse in [Vector3::repeat(0.7), Vector3::new(0.7, 0.2, 1.3), Vector3::new(0.0, 0.2, 1.3)] {
            let root = inverse.map(f64::sqrt);
            let expected = block(&(Matrix3::from_diagonal(&root) * a * Matrix3::from_diagonal(&root)));
            for (found, expected) in scaled(&block(&a), inverse).into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-14, "{found} for {expected}");
            }
        }
    }
}
