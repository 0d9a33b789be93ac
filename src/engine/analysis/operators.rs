//! A scene linearised about a state, in coordinates q = M^1/2 x that make the mass the identity: products with K and C,
//! by rows or by elements.

use super::rates::Rates;
use super::vectors::dot;
use crate::assembly::{Assembler, Pattern};
use crate::mesh::adjacency::Adjacency;
use crate::mesh::random::pseudo_random;
use crate::model::quad::{self, Pass, Quad, VectorUnit};
use crate::model::state::StateRef;
use crate::model::stop::Stop;
use crate::model::system::Weights;
use crate::scene::{Scene, TangentProducts};
use std::sync::Arc;

/// K alone.
pub(super) const STIFFNESS: Weights = Weights { m: 0.0, c: 0.0, k: 1.0 };
/// C alone.
pub(super) const DAMPING: Weights = Weights { m: 0.0, c: 1.0, k: 0.0 };
/// Degrees of freedom above which the matrices would take more memory than a run with an explicit method.
pub(super) const MOST_ASSEMBLED: usize = 400_000;

/// The operator M^-1/2 (c C + k K) M^-1/2 at a state.
pub(super) struct Linearised<'a> {
    pub scene: &'a dyn Scene,
    pub at: StateRef<'a>,
    /// [1/sqrt(kg)] diagonal of M^-1/2, 0 at fixed degrees of freedom `[n_dof]`
    pub root: Vec<f64>,
    /// K and C as matrices if that is cheaper than products by elements: with air and dashpots, not with springs alone
    pub matrices: Option<Arc<Matrices>>,
    /// products by elements, if there are no matrices and they can be prepared
    products: Option<Box<dyn TangentProducts + 'a>>,
    /// checked between products of an iteration
    pub stop: Stop<'a>,
}

impl<'a> Linearised<'a> {
    pub(super) fn of(scene: &'a dyn Scene, at: StateRef<'a>, stop: Stop<'a>) -> Self {
        let root: Vec<f64> = scene.inverse_mass().iter().map(|m| m.sqrt()).collect();
        let worth = (scene.velocity_dependent() || !scene.symmetric()) && root.len() <= MOST_ASSEMBLED;
        let matrices = if worth && !stop.asked() { Matrices::of(scene, at).map(Arc::new) } else { None };
        let products = if matrices.is_none() && !stop.asked() { scene.tangent_products(at) } else { None };
        Linearised { scene, at, root, matrices, products, stop }
    }

    /// A fixed start vector with a part of every mode, rich in high ones; 0 at fixed degrees of freedom.
    pub(super) fn start(&self) -> Vec<f64> {
        self.root.iter().enumerate().map(|(i, r)| if *r > 0.0 { pseudo_random(i) } else { 0.0 }).collect()
    }

    /// y = M^-1/2 (c C + k K) M^-1/2 q, all `[n_dof]`; `p` is a buffer for M^-1/2 q.
    pub(super) fn times(&self, w: Weights, q: &[f64], p: &mut [f64], y: &mut [f64]) {
        for ((p, q), r) in p.iter_mut().zip(q).zip(&self.root) {
            *p = r * q;
        }
        match (&self.matrices, &self.products) {
            (Some(matrices), _) => matrices.times([w.k, w.c], [p, p], y),
            (None, Some(products)) => products.times(w, p, y),
            (None, None) => self.scene.tangent_times(self.at, w, p, y),
        }
        for (y, r) in y.iter_mut().zip(&self.root) {
            *y *= r;
        }
    }

    /// Rayleigh quotients of K and C for a vector, as rates; `None` if not finite.
    pub(super) fn quotients(&self, shape: &[f64]) -> Option<Rates> {
        // The vector is empty if products with the tangent overflow.
        if shape.is_empty() {
            return None;
        }
        let (mut p, mut y) = (vec![0.0; shape.len()], vec![0.0; shape.len()]);
        let mut quotient = |w: Weights| {
            self.times(w, shape, &mut p, &mut y);
            dot(shape, &y) / dot(shape, shape)
        };
        let (k, c) = (quotient(STIFFNESS), quotient(DAMPING));
        let rates = Rates { frequency: k.max(0.0).sqrt(), damping: c.max(0.0), ..Rates::default() };
        (k.is_finite() && c.is_finite()).then_some(rates)
    }

    /// The degree of freedom that moves most in a vector `[n_dof]`.
    pub(super) fn most_moving_dof(&self, shape: &[f64]) -> usize {
        let moves = |i: usize| (shape[i] * self.root[i]).abs();
        (0..shape.len()).max_by(|&a, &b| moves(a).total_cmp(&moves(b))).unwrap_or(0)
    }
}

/// K and C by rows of 3x3 blocks, one for every pair of coupled nodes; fixed degrees of freedom have zeros.
pub(super) struct Matrices {
    /// block columns of every block row, ascending
    coupled: Adjacency,
    k: Vec<Block>,
    c: Vec<Block>,
}

/// A 3x3 block, column by column, each filled up to the width of a register.
type Block = [[f64; 4]; 3];

impl Matrices {
    /// `None` if the matrix has too many entries.
    pub(super) fn of(scene: &dyn Scene, at: StateRef<'_>) -> Option<Self> {
        let mut assembler = scene.assembler().ok()?;
        let coupled = coupled(&assembler.pattern, scene.n_dof().div_ceil(3));
        let mut matrix = |w: Weights| {
            scene.assemble(at, w, &mut assembler);
            in_blocks(&coupled, &assembler)
        };
        let (k, c) = (matrix(STIFFNESS), matrix(DAMPING));
        Some(Matrices { coupled, k, c })
    }

    /// y = k K x + c C v, all `[n_dof]`; a matrix with the factor 0 is not read.
    pub(super) fn times(&self, [k, c]: [f64; 2], [x, v]: [&[f64]; 2], y: &mut [f64]) {
        y.fill(0.0);
        for (factor, blocks, x) in [(k, &self.k, x), (c, &self.c, v)] {
            if factor != 0.0 {
                quad::run(Product { coupled: &self.coupled, blocks, factor, x, y: &mut *y });
            }
        }
    }

    /// Entry `[k, c]` of a row and a column.
    pub(super) fn entry(&self, row: u32, column: u32) -> [f64; 2] {
        let place = place(&self.coupled, row / 3, column / 3);
        let entry = |blocks: &[Block], place: usize| blocks[place][column as usize % 3][row as usize % 3];
        place.map_or([0.0; 2], |place| [entry(&self.k, place), entry(&self.c, place)])
    }
}

/// y += factor A x.
struct Product<'a> {
    coupled: &'a Adjacency,
    blocks: &'a [Block],
    factor: f64,
    x: &'a [f64],
    y: &'a mut [f64],
}

impl Pass for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn run<U: VectorUnit>(self, unit: U) {
        for (y, ends) in self.y.chunks_mut(3).zip(self.coupled.start.windows(2)) {
            let row = ends[0] as usize..ends[1] as usize;
            let mut sums = [unit.splat(0.0); 3];
            for (&node, block) in self.coupled.items[row.clone()].iter().zip(&self.blocks[row]) {
                for ((sum, column), x) in sums.iter_mut().zip(block).zip(&self.x[3 * node as usize..]) {
                    *sum = *sum + unit.quad(*column) * unit.splat(*x);
                }
            }
            let [a, b, c] = sums;
            for (y, sum) in y.iter_mut().zip((a + b + c).numbers()) {
                *y += self.factor * sum;
            }
        }
    }
}

/// Block columns of `n` block rows, ascending, those above the diagonal of a symmetric pattern too.
fn coupled(pattern: &Pattern, n: usize) -> Adjacency {
    // All unknowns of a node are coupled with the same nodes.
    let columns = &pattern.node_start[..pattern.node_start.len().saturating_sub(1)];
    let pairs = columns.iter().flat_map(|&j| {
        let column = pattern.dof[j as usize] / 3;
        let rows = pattern
            .column(j as usize)
            .chunk_by(move |&a, &b| pattern.dof[a as usize] / 3 == pattern.dof[b as usize] / 3);
        rows.flat_map(move |rows| {
            let row = pattern.dof[rows[0] as usize] / 3;
            let mirrored = pattern.symmetric && row != column;
            std::iter::once((row, column)).chain(mirrored.then_some((column, row)))
        })
    });
    Adjacency::new(n, pairs)
}

/// Where the block of a block row and a block column is.
fn place(coupled: &Adjacency, row: u32, column: u32) -> Option<usize> {
    let at = coupled.row(row).binary_search(&column).ok()?;
    Some(coupled.start[row as usize] as usize + at)
}

/// Values on a pattern as blocks; entries of a symmetric pattern are mirrored.
fn in_blocks(coupled: &Adjacency, assembler: &Assembler) -> Vec<Block> {
    let pattern = &assembler.pattern;
    let mut blocks = vec![[[0.0; 4]; 3]; coupled.items.len()];
    for (j, &column) in pattern.dof.iter().enumerate() {
        let values = &assembler.values()[pattern.col_ptr[j] as usize..];
        let (mut last, mut places) = (u32::MAX, [None; 2]);
        for (&i, &value) in pattern.column(j).iter().zip(values) {
            let row = pattern.dof[i as usize];
            if row / 3 != last {
                last = row / 3;
                let mirrored = if pattern.symmetric { place(coupled, column / 3, last) } else { None };
                places = [place(coupled, last, column / 3), mirrored];
            }
            let ends = [[row, column], [column, row]].map(|ends| ends.map(|dof| dof as usize % 3));
            for (place, [row, column]) in places.iter().zip(ends) {
                if let Some(place) = place {
                    blocks[*place][column][row] = value;
                }
            }
        }
    }
    blocks
}
