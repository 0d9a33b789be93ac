//! The vectors of conjugate gradients and the operations on them, by subdomains (`twisted_factorization`): both halves
//! in parallel, before or after the separator. Sums are added in the order of the subdomains, so that bits do not
//! depend on the number of threads.
//!
//! ```text
//! (I + L)^-1        forwards:   the halves, then the separator, which adds what they take from it
//! (I + L^T)^-1      backwards:  the separator, then the halves, which read it
//! ```

use super::bsr::{NodeBlocks, packed, unpacked};
use super::eisenstat::{Curvature, Sweep};
use super::twisted_factorization::{Subdomain, cut};
use crate::assembly::Pattern;
use crate::mesh::random::Lcg;
use crate::model::workers::Workers;
use nalgebra::Vector3;
use std::ops::Range;
use std::sync::Arc;
use wide::f32x4;

/// Nodes in each range that [`PartitionedSystem::runs_within`] checks: an error at a few nodes would not show in a sum
/// over the scene.
const RUN: usize = 256;

/// A subdomain of W with its part of all vectors; t and q also hold the separator beside it.
pub(super) struct SubdomainSystem {
    pub(super) blocks: NodeBlocks,
    x: Vec<f32x4>,
    pub(super) r: Vec<f32x4>,
    pub(super) p: Vec<f32x4>,
    t: Vec<f32x4>,
    pub(super) q: Vec<f32x4>,
    reductions: Reductions,
}

/// Results of an operation in a subdomain.
#[derive(Clone, Copy, Default)]
struct Reductions {
    /// whether the blocks are positive definite
    positive_definite: bool,
    /// r . r
    square: f64,
    curvature: Curvature,
}

impl SubdomainSystem {
    fn new(blocks: NodeBlocks) -> Self {
        let (own, all) = (vec![f32x4::ZERO; blocks.nodes()], vec![f32x4::ZERO; blocks.subdomain.n_local()]);
        SubdomainSystem {
            x: own.clone(),
            r: own.clone(),
            p: own,
            t: all.clone(),
            q: all,
            blocks,
            reductions: Reductions::default(),
        }
    }

    /// x^ <- 0, p <- 0
    fn begin(&mut self) {
        self.x.fill(f32x4::ZERO);
        self.p.fill(f32x4::ZERO);
    }

    /// Copies t of the separator.
    fn copy_separator(&mut self, separator: &SubdomainSystem) {
        self.t[self.blocks.nodes()..].copy_from_slice(&separator.t);
    }

    /// Adds the contributions of the halves to the separator's q.
    fn add_halves(&mut self, halves: &[SubdomainSystem; 2]) {
        for half in halves {
            for (q, other) in self.q.iter_mut().zip(&half.q[half.blocks.nodes()..]) {
                *q += *other;
            }
        }
    }

    /// t <- (I + L^T)^-1 x^
    fn backward(&mut self) {
        self.t[..self.blocks.nodes()].copy_from_slice(&self.x);
        self.blocks.backward(&mut self.t);
    }

    fn forward(&mut self) {
        self.blocks.forward(&mut self.q);
    }

    /// r <- q
    fn store_residual(&mut self) {
        self.r.copy_from_slice(&self.q[..self.blocks.nodes()]);
        self.reductions.square = squared(&self.r);
    }

    /// q <- E^-1 Y^-1 b
    fn gather(&mut self, b: impl Fn(usize) -> f32) {
        self.blocks.gather(b, &mut self.q);
        self.q[self.blocks.nodes()..].fill(f32x4::ZERO);
    }

    fn back(&mut self, beta: f32) {
        let sweep = Sweep { p: &mut self.p, t: &mut self.t, q: &mut self.q };
        self.blocks.back(&self.r, beta, sweep);
        self.q[self.blocks.nodes()..].fill(f32x4::ZERO);
    }

    fn forth(&mut self) {
        self.reductions.curvature = self.blocks.forth(Sweep { p: &mut self.p, t: &mut self.t, q: &mut self.q });
    }

    /// x += alpha p, r -= alpha q
    fn advance(&mut self, alpha: f32) {
        let mut sum = Vector3::zeros();
        for (((x, r), p), q) in self.x.iter_mut().zip(&mut self.r).zip(&self.p).zip(&self.q) {
            *x += *p * alpha;
            *r -= *q * alpha;
            sum += unpacked(*r * *r).cast::<f64>();
        }
        self.reductions.square = sum.sum();
    }
}

/// All of W.
pub(super) struct PartitionedSystem {
    pub(super) halves: [SubdomainSystem; 2],
    pub(super) separator: SubdomainSystem,
    /// Y^-1: one over the root of W's diagonal
    pub(super) scale: Vec<f64>,
    workers: Workers,
}

impl PartitionedSystem {
    /// For matrices of a pattern, cut where that pays.
    pub(super) fn new(pattern: &Arc<Pattern>, workers: &Workers) -> Self {
        let node = pattern.node_of_unknown();
        Self::of_subdomains(pattern, cut(pattern, &node), workers)
    }

    /// `subdomains` are both halves and the separator.
    pub(super) fn of_subdomains(pattern: &Arc<Pattern>, subdomains: [Subdomain; 3], workers: &Workers) -> Self {
        let node = pattern.node_of_unknown();
        // A single subdomain needs no threads.
        let workers = if subdomains[1].own.is_empty() { Workers::default() } else { workers.clone() };
        let part = |number: usize| {
            SubdomainSystem::new(NodeBlocks::new(Arc::clone(pattern), subdomains[number].clone(), &node))
        };
        let separator = part(2);
        let (first, second) = workers.join(|| part(0), || part(1));
        let scale = vec![0.0; pattern.n()];
        PartitionedSystem { halves: [first, second], separator, scale, workers }
    }

    fn all(&self) -> impl Iterator<Item = &SubdomainSystem> {
        self.halves.iter().chain([&self.separator])
    }

    fn sum(&self, of: impl Fn(&Reductions) -> f64) -> f64 {
        self.all().map(|part| of(&part.reductions)).sum()
    }

    /// Factorises W: `values` [nonzeros], with the share `omega` [-] of the fill added to the pivots. Returns `false`
    /// if a diagonal block is not positive definite or an off-diagonal one is too large for that.
    pub(super) fn set_values(&mut self, values: &[f64], omega: f64) -> bool {
        let PartitionedSystem { halves, separator, scale, workers, .. } = self;
        let diagonals = &separator.blocks.pattern.col_ptr;
        workers.each(scale, |range, scale| {
            for (scale, &first) in scale.iter_mut().zip(&diagonals[range]) {
                // Rows ascend from the diagonal.
                *scale = values[first as usize].sqrt().recip();
            }
            0.0
        });
        let scale = &*scale;
        both(workers, halves, |half| {
            half.reductions.positive_definite =
                half.blocks.begin(values, scale) && half.blocks.eliminate(values, scale, omega);
        });
        let mut well =
            halves.iter().all(|half| half.reductions.positive_definite) && separator.blocks.begin(values, scale);
        halves.iter().for_each(|half| separator.blocks.add_elimination_of(&half.blocks));
        well = well && separator.blocks.eliminate(values, scale, omega) && separator.blocks.scale_rows();
        if well {
            both(workers, halves, |half| {
                half.blocks.copy_separator_pivots(&separator.blocks);
                half.reductions.positive_definite = half.blocks.scale_rows();
            });
        }
        well && halves.iter().all(|half| half.reductions.positive_definite)
    }

    /// r <- (I + L)^-1 E^-1 Y^-1 b / s, where s is the largest entry of Y^-1 b; `b` `[n]`. Returns s and r . r.
    pub(super) fn set_right_hand_side(&mut self, b: &[f64]) -> [f64; 2] {
        let PartitionedSystem { halves, separator, scale, workers } = self;
        let most = |range: Range<usize>| {
            b[range.clone()].iter().zip(&scale[range]).fold(0.0_f64, |most, (b, scale)| most.max((b * scale).abs()))
        };
        let size = workers.fold(b.len(), 0.0, most, f64::max);
        let inverse = if size >= f64::MIN_POSITIVE { size.recip() } else { 0.0 };
        let single = |u: usize| (b[u] * scale[u] * inverse) as f32;
        both(workers, halves, |half| {
            half.gather(single);
            half.forward();
            half.store_residual();
        });
        separator.gather(single);
        separator.add_halves(halves);
        separator.forward();
        separator.store_residual();
        [size, self.sum(|found| found.square)]
    }

    /// x^ <- 0, p <- 0
    pub(super) fn begin(&mut self) {
        both(&self.workers, &mut self.halves, SubdomainSystem::begin);
        self.separator.begin();
    }

    /// p <- r + beta p, q <- (I + L)^-1 (I + J + L + L^T) (I + L^T)^-1 p
    pub(super) fn product(&mut self, beta: f32) -> Curvature {
        let PartitionedSystem { halves, separator, workers, .. } = self;
        separator.back(beta);
        both(workers, halves, |half| {
            half.copy_separator(separator);
            half.back(beta);
            half.forth();
        });
        separator.add_halves(halves);
        separator.forth();
        Curvature { along: self.sum(|found| found.curvature.along), squares: self.sum(|found| found.curvature.squares) }
    }

    /// x^ += alpha p, r -= alpha q; returns r . r.
    pub(super) fn advance(&mut self, alpha: f32) -> f64 {
        both(&self.workers, &mut self.halves, |half| half.advance(alpha));
        self.separator.advance(alpha);
        self.sum(|found| found.square)
    }

    /// b <- s Y^-1 E^-T (I + L^T)^-1 x^
    pub(super) fn finish(&mut self, s: f64, b: &mut [f64]) {
        let PartitionedSystem { halves, separator, scale, workers } = self;
        let (first, rest) = b.split_at_mut(separator.blocks.unknowns()[0].start);
        let (middle, second) = rest.split_at_mut(separator.blocks.unknowns()[0].len());
        separator.backward();
        let scatter = |part: &SubdomainSystem, b: &mut [f64]| part.blocks.scatter(&part.t, s, scale, b);
        scatter(separator, middle);
        let [one, other] = halves;
        join(workers, (one, first), (other, second), |(half, b)| {
            half.copy_separator(separator);
            half.backward();
            scatter(half, b);
        });
    }

    /// Sets r to a fixed pseudo-random vector, which has a part of every mode; returns r . r.
    pub(super) fn set_trial_right_hand_side(&mut self) -> f64 {
        let mut random = Lcg::default();
        for part in self.halves.iter_mut().chain([&mut self.separator]) {
            part.r.fill_with(|| packed(Vector3::from_fn(|_, _| random.draw())));
            part.reductions.square = squared(&part.r);
        }
        self.sum(|found| found.square)
    }

    /// Whether p . q <= most * p . p in every range of [`RUN`] nodes.
    pub(super) fn runs_within(&self, most: f64) -> bool {
        let mut runs = self.all().flat_map(|part| part.p.chunks(RUN).zip(part.q.chunks(RUN)));
        runs.all(|(p, q)| product(p, q) <= most * squared(p))
    }
}

fn both(workers: &Workers, [one, other]: &mut [SubdomainSystem; 2], work: impl Fn(&mut SubdomainSystem) + Sync) {
    join(workers, one, other, work);
}

/// Does the work on both, on two threads if available.
fn join<T: Send>(workers: &Workers, one: T, other: T, work: impl Fn(T) + Sync) {
    match workers.pool() {
        None => {
            work(one);
            work(other);
        }
        Some(pool) => {
            pool.install(|| rayon::join(|| work(one), || work(other)));
        }
    }
}

fn product(a: &[f32x4], b: &[f32x4]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(unpacked(*a).dot(&unpacked(*b)))).sum()
}

fn squared(v: &[f32x4]) -> f64 {
    v.iter().fold(Vector3::zeros(), |sum, v| sum + unpacked(*v * *v).cast::<f64>()).sum()
}
