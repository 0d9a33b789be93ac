//! A scene linearised about a state, in coordinates q = M^1/2 x that make the mass the identity: products with K and C,
//! matrix-free or by rows.

use super::rates::Rates;
use super::vectors::dot;
use crate::assembly::Pattern;
use crate::mesh::adjacency::row_starts;
use crate::mesh::random::pseudo_random;
use crate::model::state::StateRef;
use crate::model::stop::Stop;
use crate::model::system::Weights;
use crate::scene::Scene;
use std::sync::Arc;

/// K alone.
pub(super) const STIFFNESS: Weights = Weights { m: 0.0, c: 0.0, k: 1.0 };
/// C alone.
pub(super) const DAMPING: Weights = Weights { m: 0.0, c: 1.0, k: 0.0 };
/// Degrees of freedom above which the matrices would take more memory than a run with an explicit method.
const MOST_ASSEMBLED: usize = 400_000;

/// The operator M^-1/2 (c C + k K) M^-1/2 at a state.
pub(super) struct Linearised<'a> {
    pub scene: &'a dyn Scene,
    pub at: StateRef<'a>,
    /// [1/sqrt(kg)] diagonal of M^-1/2, 0 at fixed degrees of freedom `[n_dof]`
    pub root: Vec<f64>,
    /// K and C as matrices if that is cheaper than passes over the elements: with air and dashpots, not with springs
    /// alone
    pub matrices: Option<Arc<Matrices>>,
    /// checked between products of an iteration
    pub stop: Stop<'a>,
}

impl<'a> Linearised<'a> {
    pub fn of(scene: &'a dyn Scene, at: StateRef<'a>, stop: Stop<'a>) -> Self {
        let root: Vec<f64> = scene.inverse_mass().iter().map(|m| m.sqrt()).collect();
        let worth = (scene.velocity_dependent() || !scene.symmetric()) && root.len() <= MOST_ASSEMBLED;
        let matrices = if worth && !stop.asked() { Matrices::of(scene, at).map(Arc::new) } else { None };
        Linearised { scene, at, root, matrices, stop }
    }

    /// A fixed start vector with a part of every mode, rich in high ones; 0 at fixed degrees of freedom.
    pub fn start(&self) -> Vec<f64> {
        self.root.iter().enumerate().map(|(i, r)| if *r > 0.0 { pseudo_random(i) } else { 0.0 }).collect()
    }

    /// y = M^-1/2 (c C + k K) M^-1/2 q, all `[n_dof]`; `p` is a buffer for M^-1/2 q.
    pub fn times(&self, w: Weights, q: &[f64], p: &mut [f64], y: &mut [f64]) {
        for ((p, q), r) in p.iter_mut().zip(q).zip(&self.root) {
            *p = r * q;
        }
        match &self.matrices {
            Some(matrices) => matrices.times([w.k, w.c], [p, p], y),
            None => self.scene.tangent_times(self.at, w, p, y),
        }
        for (y, r) in y.iter_mut().zip(&self.root) {
            *y *= r;
        }
    }

    /// Rayleigh quotients of K and C for a vector, as rates; `None` if not finite.
    pub fn quotients(&self, shape: &[f64]) -> Option<Rates> {
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
    pub fn most_moving_dof(&self, shape: &[f64]) -> usize {
        let moves = |i: usize| (shape[i] * self.root[i]).abs();
        (0..shape.len()).max_by(|&a, &b| moves(a).total_cmp(&moves(b))).unwrap_or(0)
    }
}

/// K and C as one sparse matrix of pairs `[k, c]` by rows, as both are used at once. Rows and columns are degrees of
/// freedom; fixed ones have no entries.
pub(super) struct Matrices {
    start: Vec<u32>,
    column: Vec<u32>,
    values: Vec<[f64; 2]>,
}

impl Matrices {
    /// `None` if the matrix has too many entries.
    pub fn of(scene: &dyn Scene, at: StateRef<'_>) -> Option<Self> {
        let mut assembler = scene.assembler().ok()?;
        let mut values = |c: f64, k: f64| {
            scene.assemble(at, Weights { m: 0.0, c, k }, &mut assembler);
            assembler.values().to_vec()
        };
        let (c, k) = (values(1.0, 0.0), values(0.0, 1.0));
        Some(by_rows(&assembler.pattern, scene.n_dof(), [&k, &c]))
    }

    /// y = k K x + c C v, all `[n_dof]`
    pub fn times(&self, [k, c]: [f64; 2], [x, v]: [&[f64]; 2], y: &mut [f64]) {
        for (y, ends) in y.iter_mut().zip(self.start.windows(2)) {
            let row = ends[0] as usize..ends[1] as usize;
            let (mut of_k, mut of_c) = (0.0, 0.0);
            for (&j, [stiffness, damping]) in self.column[row.clone()].iter().zip(&self.values[row]) {
                of_k += stiffness * x[j as usize];
                of_c += damping * v[j as usize];
            }
            *y = k * of_k + c * of_c;
        }
    }

    /// Entry `[k, c]` of a row and a column.
    pub fn entry(&self, row: u32, column: u32) -> [f64; 2] {
        let ends = |i: usize| self.start.get(i).map_or(0, |&end| end as usize);
        let places = ends(row as usize)..ends(row as usize + 1);
        places.into_iter().find(|&place| self.column[place] == column).map_or([0.0; 2], |place| self.values[place])
    }
}

/// Converts a column pattern to rows; entries of a symmetric pattern are mirrored.
fn by_rows(pattern: &Pattern, n: usize, [k, c]: [&[f64]; 2]) -> Matrices {
    let entries = (0..pattern.n()).flat_map(|j| {
        let first = pattern.col_ptr[j];
        pattern.column(j).iter().zip(first..).flat_map(move |(&i, slot)| {
            let (row, column) = (pattern.dof[i as usize], pattern.dof[j]);
            let mirrored = pattern.symmetric && row != column;
            std::iter::once((row, column, slot)).chain(mirrored.then_some((column, row, slot)))
        })
    });
    let start = row_starts(n, entries.clone().map(|(row, ..)| row));
    let total = start[n] as usize;
    let (mut column, mut values) = (vec![0; total], vec![[0.0; 2]; total]);
    let mut next = start.clone();
    for (row, other, slot) in entries {
        let at = next[row as usize] as usize;
        (column[at], values[at]) = (other, [k[slot as usize], c[slot as usize]]);
        next[row as usize] += 1;
    }
    Matrices { start, column, values }
}
