//! Blocks of steps of a scene that is one block: its nodes stay in the block's local buffers from the first step to the
//! last.

use crate::force::kernel::element_block::{ElementBlock, PassNumbers};
use crate::force::kernel::local_buffer::{LocalBuffer, PaddedVec3, RECORD, Records, fill, rows, store_rows};
use crate::force::schedule::pass_kind::{PassKind, Sums};
use crate::force::schedule::step_boundary::NodeStateMut;
use crate::force::schedule::step_boundary::StepBoundary;
use crate::force::schedule::sweep::Sweep;
use crate::force::schedule::terms::Terms;
use crate::force::schedule::threads::{LocalBuffers, SUMS, SingleBlockBuffers, Threads};
use crate::model::forces::Tally;
use crate::model::step_block::BoundarySums;
use crate::model::step_block::{KickDriftScheme, NodeSums, Nodes, StepSummary, Work, Working};
use crate::model::system::KickDriftBlock;
use bytemuck::cast_slice_mut;
use nalgebra::Vector3;

impl Sweep {
    /// Whether all nodes and elements are in one block.
    pub(crate) fn is_single_block(&self) -> bool {
        self.partition.blocks().len() == 1
    }

    /// [`Sweep::advance`] of several steps of such a scene.
    pub(in crate::force) fn advance_single_block<T: Terms + ?Sized>(
        &self,
        terms: &T,
        moving: NodeStateMut<'_>,
        StepBoundary { block: KickDriftBlock { scheme, from }, mass, inverse_mass }: StepBoundary<'_>,
        threads: &Threads,
        out: [&mut [Vector3<f64>]; SUMS],
        summaries: &mut [StepSummary],
    ) {
        let n = mass.len();
        let present = out.each_ref().map(|sum| !sum.is_empty());
        let local_buffers = &mut *threads.local_buffers(0);
        let LocalBuffers { x, v, sums, single_block: SingleBlockBuffers { inverse_mass: m, before, kicked, kept } } =
            local_buffers;
        let [x, v, m, before, kicked, kept] = [x, v, m, before, kicked, kept].map(LocalBuffer::records);
        let mut sums = sums.each_mut().map(LocalBuffer::records);
        let forces = [&from.forces.total, &from.forces.external, &from.forces.dissipative];
        for ((from, to), _) in forces.into_iter().zip(&mut sums).zip(present).filter(|(_, present)| *present) {
            fill(from, rows(to, n));
        }
        for (from, to) in [(&from.state.x[..], &mut *x), (&from.state.v, &mut *v), (inverse_mass, &mut *m)] {
            fill(from, rows(to, n));
        }
        let mut net =
            SceneInBlock { terms, mass, present, x, v, m, before, kicked, kept, sums, begun: Work::default() };
        // Begins the first step without ending one: these sums belong to no step.
        net.go_on(KickDriftScheme { end: None, ..scheme }, true);
        let steps = summaries.len();
        for (step, summary) in summaries.iter_mut().enumerate() {
            net.find(scheme, summary);
            summary.nodes = net.go_on(scheme, step + 1 < steps);
        }
        let SceneInBlock { x, v, sums, .. } = net;
        for (from, to) in [(x, cast_slice_mut(moving.x)), (v, cast_slice_mut(moving.v))] {
            store_rows(rows(from, n), to);
        }
        for ((from, to), _) in sums.into_iter().zip(out).zip(present).filter(|(_, present)| *present) {
            store_rows(rows(from, n), to);
        }
    }
}

/// A scene in its local buffers.
struct SceneInBlock<'a, T: ?Sized> {
    terms: &'a T,
    /// [kg] `[n_nodes]`
    mass: &'a [f64],
    /// which sums the scene has
    present: [bool; SUMS],
    /// [m]
    x: &'a mut Records,
    /// [m/s]
    v: &'a mut Records,
    /// [1/kg] by degree of freedom
    m: &'a mut Records,
    /// [m] positions at the start of the step
    before: &'a mut Records,
    /// [m/s] kicked velocities
    kicked: &'a mut Records,
    /// [N] forces of terms that depend on position only
    kept: &'a mut Records,
    /// [N] all forces, external ones, dissipative ones
    sums: [&'a mut Records; SUMS],
    /// [J] work of the forces at the start of the step
    begun: Work,
}

impl<T: Terms + ?Sized> SceneInBlock<'_, T> {
    /// The forces at the end of a step; with corrected velocities, if the scheme predicts them.
    fn find(&mut self, scheme: KickDriftScheme, summary: &mut StepSummary) {
        summary.tallies.resize(self.terms.tallies(), Tally::default());
        let n = self.mass.len();
        if scheme.predicts {
            self.add(PassKind::TotalOnly, summary);
            let numbers = RECORD * n;
            scheme.correct(
                &mut self.v[..numbers],
                &self.kicked[..numbers],
                &self.m[..numbers],
                &self.sums[0][..numbers],
            );
            if self.terms.is_position_only() {
                self.add(PassKind::ReusePosition, summary);
            } else {
                rows(self.sums[0], n).fill(PaddedVec3::default());
                self.add(PassKind::Full, summary);
            }
        } else {
            self.add(PassKind::Full, summary);
        }
        let block = ElementBlock { number: 0, own: 0..n, t: summary.t, x: self.x, v: self.v, scene_numbers: &[] };
        summary.largest_stretch = self.terms.largest_stretch(&block, summary.stretch_wanted);
    }

    fn add(&mut self, kind: PassKind, summary: &mut StepSummary) {
        let n = self.mass.len();
        let block = ElementBlock { number: 0, own: 0..n, t: summary.t, x: self.x, v: self.v, scene_numbers: &[] };
        let sums = self.sums.each_mut().map(|sum| &mut **sum);
        let (kept, numbers) = (rows(self.kept, n), PassNumbers::InBlock);
        let mut sums = Sums { n, sums, present: self.present, kept, numbers };
        sums.add(self.terms, kind, &block, &mut summary.tallies);
    }

    /// Ends a step and begins another.
    fn go_on(&mut self, scheme: KickDriftScheme, another: bool) -> NodeSums {
        let (n, works) = (self.mass.len(), self.present[1] || self.present[2]);
        let flat = |records| rows(records, n).as_flattened_mut();
        let [total, external, dissipative] = self.sums.each_mut().map(|sum| flat(sum));
        let nodes: Nodes<'_, RECORD> = Nodes {
            mass: self.mass,
            inverse_mass: flat(self.m),
            x: flat(self.x),
            v: flat(self.v),
            kicked: if scheme.predicts { flat(self.kicked) } else { &mut [] },
            f: total,
            works: works.then(|| Working {
                forces: [if self.present[1] { external } else { &[] }, if self.present[2] { dissipative } else { &[] }],
                before: flat(self.before),
            }),
        };
        let BoundarySums { nodes, next } = scheme.end(nodes, another);
        let work = std::mem::replace(&mut self.begun, next).and(nodes.work).halved();
        NodeSums { work, ..nodes }
    }
}
