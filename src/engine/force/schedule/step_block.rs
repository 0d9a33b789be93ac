//! Force passes of one step, or of a block of steps, each a few node blocks behind the one before it (time skewing).
//! The updates of nodes before and after a pass are made in the same sweep.
//!
//! A node is moved before the first round whose elements reach it. The scheme continues with the nodes of a round's own
//! node blocks as soon as their forces are complete. So a large scene is read from memory once per step, or once per
//! block of steps.
//!
//! The node blocks of every level ([`crate::force::schedule::wavefront`]) are done in rounds. A round can begin as soon
//! as all nodes that its elements reach are complete in the level before, and were moved, or their velocities
//! corrected. Since elements belong to the node block of their smallest node, the level before does not need these
//! nodes any more. So all updates are in place, and the sums of a level overwrite those of the level before.

use crate::force::NodeState;
use crate::force::kernel::element_block::PassNumbers;
use crate::force::schedule::partition::{Halo, Partition};
use crate::force::schedule::pass_kind::PassKind;
use crate::force::schedule::step_boundary::{NodeStateMut, StepBoundary};
use crate::force::schedule::sweep::{PassSpec, Sweep, reads};
use crate::force::schedule::terms::Terms;
use crate::force::schedule::threads::{SUMS, Threads};
use crate::force::schedule::tuning::{LEVELS, ROUND, SEAMS_SIDE_BY_SIDE};
use crate::force::schedule::wavefront::Wavefront;
use crate::force::schedule::workspace::{Workspace, WorkspaceSize, WorkspaceView};
use crate::model::forces::Tally;
use crate::model::step_block::{LONGEST, StepSummary};
use crate::model::workers::{ALONE, Workers};
use nalgebra::Vector3;
use std::ops::Range;

/// What a block of steps overwrites.
pub(crate) struct StepBlockResults<'a> {
    /// [N] sums of forces at its end
    pub sums: [&'a mut [Vector3<f64>]; SUMS],
    /// of every term at its end
    pub tallies: &'a mut [Tally],
    /// one for every step; empty for a single step of which none is made
    pub summaries: &'a mut [StepSummary],
}

/// The steps of a block.
struct Steps<'a, T: ?Sized> {
    terms: &'a T,
    boundary: StepBoundary<'a>,
    /// empty for a single step of which no summary is made
    summaries: &'a [StepSummary],
    threads: &'a Threads,
}

/// The force pass of a level.
struct LevelPass {
    kind: PassKind,
    /// [s]
    t: f64,
    /// whether the largest stretch is computed
    stretch: bool,
}

impl<T: Terms + ?Sized> Steps<'_, T> {
    fn at(&self, level: usize, t_end: f64) -> LevelPass {
        let scheme = self.boundary.block.scheme;
        let (t, wanted) =
            self.summaries.get(level / scheme.passes()).map_or((t_end, false), |step| (step.t, step.stretch_wanted));
        match level % scheme.passes() {
            0 if scheme.predicts => LevelPass { kind: PassKind::TotalOnly, t, stretch: wanted },
            0 => LevelPass { kind: PassKind::Full, t, stretch: wanted },
            _ if self.terms.is_position_only() => LevelPass { kind: PassKind::ReusePosition, t, stretch: false },
            _ => LevelPass { kind: PassKind::Full, t, stretch: false },
        }
    }
}

/// Node blocks whose nodes are complete in a level.
struct CompletedBlocks<'a> {
    level: usize,
    kind: PassKind,
    /// the blocks that add forces to these nodes
    blocks: Range<usize>,
    halo: [Halo<'a>; SUMS],
}

/// Some node blocks, and the state of their nodes.
struct BlockSpan<'a> {
    part: WorkspaceView<'a>,
    moving: NodeStateMut<'a>,
}

impl BlockSpan<'_> {
    fn within(&mut self, partition: &Partition, node_blocks: Range<usize>) -> BlockSpan<'_> {
        let moving = self.moving.within(partition.nodes_of(node_blocks.clone()));
        BlockSpan { part: self.part.within(partition, node_blocks), moving }
    }

    /// Splits the node blocks at one of them.
    fn split(self, partition: &Partition, at: usize) -> [Self; 2] {
        let [before, after] = self.moving.split(partition.nodes_of(at..at).start);
        let [part, others] = self.part.split(partition, at);
        [BlockSpan { part, moving: before }, BlockSpan { part: others, moving: after }]
    }
}

impl Sweep {
    /// Largest useful number of steps in a block, with this many force passes per step.
    pub(crate) fn longest_block(&self, passes: usize) -> usize {
        if self.is_single_block() { LONGEST } else { LEVELS / passes }
    }

    /// Makes as many steps as there are entries of `summaries`, or a single one of which no summary is made. Sums,
    /// state, tallies and summaries have the bits of steps made one by one.
    pub(crate) fn advance<T: Terms + ?Sized>(
        &self,
        terms: &T,
        moving: NodeStateMut<'_>,
        boundary: StepBoundary<'_>,
        threads: &Threads,
        results: StepBlockResults<'_>,
    ) {
        let StepBlockResults { sums: out, tallies, summaries } = results;
        if self.is_single_block() && summaries.len() > 1 {
            self.advance_single_block(terms, moving, boundary, threads, out, summaries);
        } else {
            let scheme = boundary.block.scheme;
            let works = !summaries.is_empty() && out[1..].iter().any(|sum| !sum.is_empty());
            let (several, is_position_only) = (summaries.len() > 1, terms.is_position_only());
            let needs = WorkspaceSize {
                terms: terms.tallies(),
                levels: scheme.passes() * summaries.len().max(1),
                threads: if several { threads.count() } else { 1 },
                keeps: scheme.predicts && is_position_only,
                aside: [works, scheme.predicts && several],
            };
            let mut workspace = self.workspace(needs, &out);
            self.steps(Steps { terms, boundary, summaries, threads }, moving, out, &mut workspace);
            // Terms of the first sum are evaluated once per step if they depend on position only; that pass has their
            // energies.
            let tallies_at = if is_position_only { 0 } else { scheme.passes() - 1 };
            for (step, summary) in summaries.iter_mut().enumerate() {
                let first = scheme.passes() * step;
                summary.tallies.resize(terms.tallies(), Tally::default());
                workspace.add_up(first + tallies_at, &mut summary.tallies);
                summary.largest_stretch = workspace.largest_stretch(first);
                summary.nodes = workspace.node_sums(first + scheme.passes() - 1);
            }
            if summaries.is_empty() {
                workspace.add_up(tallies_at, tallies);
            }
        }
        if let Some(last) = summaries.last() {
            tallies.copy_from_slice(&last.tallies);
        }
    }

    /// Makes all levels of the workspace.
    fn steps<T: Terms + ?Sized>(
        &self,
        steps: Steps<'_, T>,
        moving: NodeStateMut<'_>,
        out: [&mut [Vector3<f64>]; SUMS],
        workspace: &mut Workspace,
    ) {
        let partition = &self.partition;
        let (part, wavefronts) = workspace.parts(partition, out);
        let mut span = BlockSpan { part, moving };
        let pool = steps.threads.workers().pool().filter(|_| partition.node_blocks().len() > 1);
        let [parts, others] = wavefronts.all();
        let Some(pool) = pool else { return self.side_by_side(&steps, others, span) };
        pool.install(|| {
            self.side_by_side(&steps, parts, span.within(partition, partition.node_blocks()));
            if others.len() >= SEAMS_SIDE_BY_SIDE {
                return self.side_by_side(&steps, others, span);
            }
            for wavefront in others {
                let span = span.within(partition, wavefront.node_blocks.clone());
                let node_blocks = ROUND[usize::from(wavefront.levels.len() > 1)] * pool.current_num_threads();
                self.rounds(&steps, wavefront, node_blocks, span, steps.threads.workers());
            }
        });
    }

    /// Each wavefront on one thread, or all on the only thread.
    fn side_by_side<T: Terms + ?Sized>(&self, steps: &Steps<'_, T>, wavefronts: &mut [Wavefront], span: BlockSpan<'_>) {
        match wavefronts {
            [] => {}
            [wavefront] => self.rounds(steps, wavefront, 1, span, &ALONE),
            _ => {
                let (left, right) = wavefronts.split_at_mut(wavefronts.len() / 2);
                let [before, after] = span.split(&self.partition, right[0].node_blocks.start);
                rayon::join(|| self.side_by_side(steps, left, before), || self.side_by_side(steps, right, after));
            }
        }
    }

    /// Makes a wavefront to its end, this many node blocks per round.
    fn rounds<T: Terms + ?Sized>(
        &self,
        steps: &Steps<'_, T>,
        wavefront: &mut Wavefront,
        node_blocks: usize,
        mut span: BlockSpan<'_>,
        workers: &Workers,
    ) {
        let partition = &self.partition;
        while let Some(ahead) = wavefront.ahead(partition, node_blocks) {
            let level = ahead.level;
            let moved = wavefront.move_for(&ahead);
            if !moved.is_empty() {
                steps.boundary.begin(span.moving.within(moved), workers);
            }
            let LevelPass { kind, t, stretch } = steps.at(level, span.moving.t);
            let job = PassSpec {
                terms: steps.terms,
                reads: reads(steps.terms, kind),
                stretch,
                kind,
                // A scene of several blocks whose terms have scene numbers makes steps one by one, by whole passes.
                numbers: PassNumbers::InBlock,
                // The energies of reused forces are already included.
                level: if kind == PassKind::ReusePosition { level - 1 } else { level },
                at: NodeState { t, ..span.moving.state() },
                first: span.moving.first,
                threads: steps.threads,
                workers,
                partition,
            };
            job.run(span.part.within(partition, ahead.node_blocks.clone()));
            let blocks = wavefront.advance(partition, &ahead);
            let first = partition.halo_of(partition.blocks_of(span.part.node_blocks.clone())).start;
            let halo = std::mem::take(&mut span.part.halo);
            let sums = halo.each_ref().map(|sums| Halo { first, sums });
            let completed = CompletedBlocks { level, kind, blocks, halo: sums };
            self.complete(steps, &completed, span.within(partition, ahead.completed), workers);
            span.part.halo = halo;
        }
    }

    /// Adds the halo sums of other node blocks to the sums of nodes, and makes the update after the pass, node block by
    /// node block.
    fn complete<T: Terms + ?Sized>(
        &self,
        steps: &Steps<'_, T>,
        completed: &CompletedBlocks<'_>,
        mut span: BlockSpan<'_>,
        workers: &Workers,
    ) {
        let node_blocks = span.part.node_blocks.clone();
        match workers.pool().filter(|_| node_blocks.len() > 1) {
            None => {
                for node_block in node_blocks {
                    self.complete_node_block(
                        steps,
                        completed,
                        span.within(&self.partition, node_block..node_block + 1),
                    );
                }
            }
            Some(_) => {
                let [left, right] = span.split(&self.partition, node_blocks.start + node_blocks.len() / 2);
                rayon::join(
                    || self.complete(steps, completed, left, workers),
                    || self.complete(steps, completed, right, workers),
                );
            }
        }
    }

    fn complete_node_block<T: Terms + ?Sized>(
        &self,
        steps: &Steps<'_, T>,
        CompletedBlocks { level, kind, blocks, halo }: &CompletedBlocks<'_>,
        BlockSpan { mut part, moving }: BlockSpan<'_>,
    ) {
        let nodes = self.partition.nodes_of(part.node_blocks.clone());
        for (out, halo) in part.out.iter_mut().zip(halo).take(kind.sums()) {
            if !out.is_empty() {
                self.partition.add_halo(blocks.clone(), *halo, (nodes.start, out));
            }
        }
        let (boundary, summarized) = (&steps.boundary, !steps.summaries.is_empty());
        match (*kind, *level) {
            (PassKind::TotalOnly, 0) => boundary.kick_again(&part, moving),
            (PassKind::TotalOnly, _) => boundary.correct(&part, moving),
            _ if summarized => boundary.end(*level, part, moving),
            (_, 0) => boundary.kick_again(&part, moving),
            // A single step that predicts: its second pass ends it.
            _ => {}
        }
    }
}

#[cfg(test)]
pub(in crate::force) mod tests;
