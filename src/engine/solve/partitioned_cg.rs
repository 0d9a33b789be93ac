//! The vectors of conjugate gradients and the operations on them, by subdomains (`sections`): all sections at once,
//! before or after the separators. Sums are added in the order of the subdomains, so that bits do not depend on the
//! number of threads.
//!
//! ```text
//! (I + L)^-1        forwards:   the sections, then the separators, which add what they take from them
//! (I + L^T)^-1      backwards:  the separators, then the sections, which read them
//! ```

use super::bsr::{NodeBlocks, packed, unpacked};
use super::eisenstat::{Curvature, Sweep};
use super::sections::{Cut, Subdomain};
use crate::assembly::Pattern;
use crate::mesh::random::Lcg;
use crate::model::workers::Workers;
use nalgebra::Vector3;
use std::ops::Range;
use std::sync::Arc;
use wide::f32x4;

/// Least number of nodes in a range that [`PartitionedSystem::runs_within`] checks: an error at a few nodes would not
/// show in a sum over the scene, and fewer nodes are no average.
const RUN: usize = 256;

/// A subdomain of W with its part of all vectors; t and q also hold the separators beside it.
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

    /// Copies t of the separators beside this section.
    fn copy_separators(&mut self, beside: Separators<'_>) {
        for (separator, here) in beside.in_local_vectors_of(&self.blocks.subdomain) {
            self.t[here].copy_from_slice(&separator.t);
        }
    }

    /// Adds to q what the sections beside this separator contribute.
    fn add_sections(&mut self, beside: Sections<'_>) {
        for (section, here) in beside.with_local_separator() {
            for (q, other) in self.q.iter_mut().zip(&section.q[here]) {
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

/// The separators before and behind a section.
#[derive(Clone, Copy)]
struct Separators<'a>([Option<&'a SubdomainSystem>; 2]);

impl<'a> Separators<'a> {
    /// With their places in the local vectors of the section.
    fn in_local_vectors_of(
        self,
        section: &Subdomain,
    ) -> impl Iterator<Item = (&'a SubdomainSystem, Range<usize>)> + use<'a> {
        let places = self.0.into_iter().zip(section.local_separators());
        places.filter_map(|(separator, here)| Some((separator?, here)))
    }
}

/// The sections before and behind a separator.
#[derive(Clone, Copy)]
struct Sections<'a>(&'a [SubdomainSystem]);

impl<'a> Sections<'a> {
    /// With the place of the separator in their local vectors.
    fn with_local_separator(self) -> impl Iterator<Item = (&'a SubdomainSystem, Range<usize>)> {
        // The one before it has it behind itself.
        let sides = self.0.iter().zip([1, 0]);
        sides.map(|(section, side)| (section, section.blocks.subdomain.local_separators()[side].clone()))
    }
}

/// All of W.
pub(super) struct PartitionedSystem {
    pub(super) sections: Vec<SubdomainSystem>,
    /// those between them, one less
    pub(super) separators: Vec<SubdomainSystem>,
    /// Y^-1: one over the root of W's diagonal
    pub(super) scale: Vec<f64>,
    pattern: Arc<Pattern>,
    workers: Workers,
}

impl PartitionedSystem {
    /// For matrices of a pattern, cut where that pays.
    pub(super) fn new(pattern: &Arc<Pattern>, workers: &Workers) -> Self {
        let node = pattern.node_of_unknown();
        Self::of_cut(pattern, Cut::new(pattern, &node), &node, workers)
    }

    pub(super) fn of_cut(pattern: &Arc<Pattern>, cut: Cut, node: &[u32], workers: &Workers) -> Self {
        let [sections, separators] = [cut.sections, cut.separators].map(|subdomains| {
            let mut parts: Vec<_> = subdomains.into_iter().map(|subdomain| (subdomain, None)).collect();
            workers.each_section(parts.iter_mut(), |(subdomain, part)| {
                *part = Some(SubdomainSystem::new(NodeBlocks::new(Arc::clone(pattern), subdomain.clone(), node)));
            });
            parts.into_iter().filter_map(|(_, part)| part).collect()
        });
        let (scale, pattern, workers) = (vec![0.0; pattern.n()], Arc::clone(pattern), workers.clone());
        PartitionedSystem { sections, separators, scale, pattern, workers }
    }

    fn all(&self) -> impl Iterator<Item = &SubdomainSystem> {
        self.sections.iter().chain(&self.separators)
    }

    fn sum(&self, of: impl Fn(&Reductions) -> f64) -> f64 {
        self.all().map(|part| of(&part.reductions)).sum()
    }

    fn positive_definite(&self) -> bool {
        self.all().all(|part| part.reductions.positive_definite)
    }

    fn in_sections(&mut self, work: impl Fn(&mut SubdomainSystem) + Sync) {
        self.workers.each_section(self.sections.iter_mut(), work);
    }

    /// In all sections, which may read the separators beside them.
    fn after_separators(&mut self, work: impl Fn(&mut SubdomainSystem, Separators<'_>) + Sync) {
        let separators = &self.separators;
        let sections = self.sections.iter_mut().enumerate();
        self.workers.each_section(sections, |(i, section)| work(section, beside(separators, i)));
    }

    /// In all separators, which may read the sections beside them.
    fn after_sections(&mut self, work: impl Fn(&mut SubdomainSystem, Sections<'_>) + Sync) {
        let separators = self.separators.iter_mut().zip(self.sections.windows(2));
        self.workers.each_section(separators, |(separator, sections)| work(separator, Sections(sections)));
    }

    /// Factorises W: `values` [nonzeros], with the share `omega` [-] of the fill added to the pivots. Returns `false`
    /// if a diagonal block is not positive definite or an off-diagonal one is too large for that.
    pub(super) fn set_values(&mut self, values: &[f64], omega: f64) -> bool {
        let mut scale = std::mem::take(&mut self.scale);
        self.workers.set(&mut scale, |range, scale| {
            for (scale, &first) in scale.iter_mut().zip(&self.pattern.col_ptr[range]) {
                // Rows ascend from the diagonal.
                *scale = values[first as usize].sqrt().recip();
            }
        });
        self.in_sections(|section| {
            let blocks = &mut section.blocks;
            section.reductions.positive_definite =
                blocks.begin(values, &scale) && blocks.eliminate(values, &scale, omega);
        });
        self.after_sections(|separator, beside| {
            let blocks = &mut separator.blocks;
            let small = blocks.begin(values, &scale);
            beside.with_local_separator().for_each(|(section, here)| blocks.add_elimination_of(&section.blocks, here));
            separator.reductions.positive_definite =
                small && blocks.eliminate(values, &scale, omega) && blocks.scale_rows();
        });
        self.scale = scale;
        if self.positive_definite() {
            self.after_separators(|section, beside| {
                for (separator, here) in beside.in_local_vectors_of(&section.blocks.subdomain) {
                    section.blocks.copy_separator_pivots(&separator.blocks, here);
                }
                section.reductions.positive_definite = section.blocks.scale_rows();
            });
        }
        self.positive_definite()
    }

    /// r <- (I + L)^-1 E^-1 Y^-1 b / s, where s is the largest entry of Y^-1 b; `b` `[n]`. Returns s and r . r.
    pub(super) fn set_right_hand_side(&mut self, b: &[f64]) -> [f64; 2] {
        let scale = std::mem::take(&mut self.scale);
        let most = |range: Range<usize>| {
            b[range.clone()].iter().zip(&scale[range]).fold(0.0_f64, |most, (b, scale)| most.max((b * scale).abs()))
        };
        let size = self.workers.fold(b.len(), 0.0, most, f64::max);
        let inverse = if size >= f64::MIN_POSITIVE { size.recip() } else { 0.0 };
        let single = |u: usize| (b[u] * scale[u] * inverse) as f32;
        self.in_sections(|section| {
            section.gather(single);
            section.forward();
            section.store_residual();
        });
        self.after_sections(|separator, beside| {
            separator.gather(single);
            separator.add_sections(beside);
            separator.forward();
            separator.store_residual();
        });
        self.scale = scale;
        [size, self.sum(|found| found.square)]
    }

    /// x^ <- 0, p <- 0
    pub(super) fn begin(&mut self) {
        self.in_sections(SubdomainSystem::begin);
        self.after_sections(|separator, _| separator.begin());
    }

    /// p <- r + beta p, q <- (I + L)^-1 (I + J + L + L^T) (I + L^T)^-1 p
    pub(super) fn product(&mut self, beta: f32) -> Curvature {
        self.after_sections(|separator, _| separator.back(beta));
        self.after_separators(|section, beside| {
            section.copy_separators(beside);
            section.back(beta);
            section.forth();
        });
        self.after_sections(|separator, beside| {
            separator.add_sections(beside);
            separator.forth();
        });
        Curvature { along: self.sum(|found| found.curvature.along), squares: self.sum(|found| found.curvature.squares) }
    }

    /// x^ += alpha p, r -= alpha q; returns r . r.
    pub(super) fn advance(&mut self, alpha: f32) -> f64 {
        self.in_sections(|section| section.advance(alpha));
        self.after_sections(|separator, _| separator.advance(alpha));
        self.sum(|found| found.square)
    }

    /// b <- s Y^-1 E^-T (I + L^T)^-1 x^
    pub(super) fn finish(&mut self, s: f64, b: &mut [f64]) {
        self.after_sections(|separator, _| separator.backward());
        let PartitionedSystem { sections, separators, scale, workers, .. } = self;
        let scatter = |part: &SubdomainSystem, b: &mut [f64]| part.blocks.scatter(&part.t, s, scale, b);
        let mut left = b;
        let mut unknowns_of = |part: &SubdomainSystem| {
            let (own, behind) = std::mem::take(&mut left).split_at_mut(part.blocks.unknowns()[0].len());
            left = behind;
            own
        };
        let sections = sections.iter_mut().enumerate().map(|(i, section)| {
            let (own, behind) = (unknowns_of(section), separators.get(i));
            (section, own, beside(separators, i), behind.map(|separator| (separator, unknowns_of(separator))))
        });
        workers.each_section(sections, |(section, own, beside, behind)| {
            behind.into_iter().for_each(|(separator, b)| scatter(separator, b));
            section.copy_separators(beside);
            section.backward();
            scatter(section, own);
        });
    }

    /// Sets r to a fixed pseudo-random vector, which has a part of every mode; returns r . r.
    pub(super) fn set_trial_right_hand_side(&mut self) -> f64 {
        let mut random = Lcg::default();
        for part in self.sections.iter_mut().chain(&mut self.separators) {
            part.r.fill_with(|| packed(Vector3::from_fn(|_, _| random.draw())));
            part.reductions.square = squared(&part.r);
        }
        self.sum(|found| found.square)
    }

    /// Whether p . q <= most * p . p in every range of nodes.
    pub(super) fn runs_within(&self, most: f64) -> bool {
        let within = |part: &SubdomainSystem, range: Range<usize>| {
            let p = &part.p[range.clone()];
            product(p, &part.q[range]) <= most * squared(p)
        };
        self.all().all(|part| runs(part.blocks.nodes()).all(|range| within(part, range)))
    }
}

/// The separators beside a section.
fn beside(separators: &[SubdomainSystem], section: usize) -> Separators<'_> {
    Separators([section.checked_sub(1), Some(section)].map(|i| i.and_then(|i| separators.get(i))))
}

/// Ranges of nearly one length, of [`RUN`] nodes or more each. Fewer nodes are one range.
fn runs(nodes: usize) -> impl Iterator<Item = Range<usize>> {
    let count = (nodes / RUN).max(1);
    (0..count).map(move |i| i * nodes / count..(i + 1) * nodes / count)
}

fn product(a: &[f32x4], b: &[f32x4]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(unpacked(*a).dot(&unpacked(*b)))).sum()
}

fn squared(v: &[f32x4]) -> f64 {
    v.iter().fold(Vector3::zeros(), |sum, v| sum + unpacked(*v * *v).cast::<f64>()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One after another, none too short for an average, and none twice as long.
    #[test]
    fn runs_cover_all_nodes() {
        for nodes in [0, 1, 255, 256, 257, 511, 512, 769, 45_150, 65_793] {
            let ends = runs(nodes).fold(0, |end, run| {
                assert_eq!(run.start, end);
                assert!(run.len() == nodes || (RUN..2 * RUN).contains(&run.len()), "{run:?} of {nodes}");
                run.end
            });
            assert_eq!(ends, nodes);
        }
    }
}
