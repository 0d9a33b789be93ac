//! The tangent of a network: its pattern, W = cm M + cc C + ck K, and what solvers ask of forces besides.

use super::network::{Network, by_node, node_state};
use crate::assembly::{Assembler, MixedSystem, Nodes, PatternError, Recorder, TangentSystem};
use crate::contact::near::Candidate;
use crate::force::{ForceTerm, MeanStep, RankOne, TangentForm, TangentSink};
use crate::model::forces::Forces;
use crate::model::state::StateRef;
use crate::model::system::{StepMean, System, Weights};
use crate::startup::{Phase, timed};
use std::ops::Range;
use std::sync::Arc;

impl Network {
    fn pattern_of(&self, symmetric: bool) -> Result<Assembler, PatternError> {
        timed(Phase::Pattern, || self.record(symmetric))
    }

    fn record(&self, symmetric: bool) -> Result<Assembler, PatternError> {
        let state = self.initial_state();
        let mut recorder = Recorder::default();
        let nothing = Weights { m: 0.0, c: 0.0, k: 0.0 };
        self.emit_terms(state.as_ref(), nothing, TangentForm::EXACT, &mut recorder);
        let near = self.contact.as_ref().map(|contact| contact.last_near()).unwrap_or_default();
        self.contact.iter().for_each(|contact| contact.record(&near, &mut recorder));
        let nodes = Nodes { position: bytemuck::cast_slice(&self.built.start), fixed: &self.phase().fixed };
        let mut assembler = Assembler::new(nodes, &recorder, symmetric, self.threads.workers())?;
        assembler.near = near;
        Ok(assembler)
    }

    /// The rank-one parts of the tangents of terms: the term, and which of its scene numbers.
    fn couplings(&self) -> impl Iterator<Item = (&dyn ForceTerm, usize)> {
        let numbers = |term: &dyn ForceTerm| term.scene_numbers().map_or(0, |numbers| numbers.count());
        self.force_terms().flat_map(move |term| (0..numbers(term)).map(move |number| (term, number)))
    }

    fn assemble_form(&self, at: StateRef<'_>, w: Weights, form: TangentForm, assembler: &mut Assembler) {
        let near = assembler.near.clone();
        let mut sink = assembler.sink(|dof| w.m * self.built.mass[dof / 3]);
        self.emit_terms(at, w, form, &mut sink);
        self.emit_near(&near, (at, None), w, form, &mut sink);
    }

    /// Tangents of everything that acts.
    pub(super) fn emit_tangents(&self, at: StateRef<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink) {
        self.emit_terms(at, w, form, sink);
        self.emit_contact(at, w, form, sink);
    }

    /// Those of all terms and of the program's laws, element by element, always in the same order.
    fn emit_terms(&self, at: StateRef<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink) {
        self.acting.terms.iter().for_each(|term| term.tangent(node_state(at), w, form, sink));
        self.emit_law_tangents(at, w, form, sink);
    }

    /// Those of pairs that a pattern was made with.
    pub(super) fn emit_near(
        &self,
        near: &[Candidate],
        (at, mean): (StateRef<'_>, Option<StepMean>),
        w: Weights,
        form: TangentForm,
        sink: &mut dyn TangentSink,
    ) {
        if let Some(contact) = &self.contact {
            contact.emit((node_state(at), mean.map(|mean| mean.half), near), w, form, sink);
        }
    }
}

impl TangentSystem for Network {
    fn symmetric(&self) -> bool {
        self.acting.terms.iter().all(|t| t.symmetric())
            && !self.external.as_ref().is_some_and(|external| external.has_derivatives(None))
    }

    fn assembler(&self) -> Result<Assembler, PatternError> {
        self.pattern_of(self.symmetric())
    }

    fn outgrown(&self, assembler: &Assembler) -> bool {
        let differs = |near: &Arc<[Candidate]>, other: &Arc<[Candidate]>| {
            !Arc::ptr_eq(near, other) && !near.iter().map(Candidate::key).eq(other.iter().map(Candidate::key))
        };
        self.contact.as_ref().is_some_and(|contact| differs(&contact.last_near(), &assembler.near))
    }

    fn symmetric_assembler(&self) -> Result<Option<Assembler>, PatternError> {
        self.pattern_of(true).map(Some)
    }

    fn assemble_symmetric(&self, at: StateRef<'_>, w: Weights, convex: bool, assembler: &mut Assembler) {
        self.assemble_form(at, w, TangentForm { convex, symmetric: true }, assembler);
    }

    fn assemble(&self, at: StateRef<'_>, w: Weights, assembler: &mut Assembler) {
        self.assemble_form(at, w, TangentForm::EXACT, assembler);
    }

    fn rank_ones(&self) -> usize {
        self.mass_parts() + self.couplings().count()
    }

    fn mass_parts(&self) -> usize {
        3 * self.acting.apparent.len()
    }

    fn kept_parts(&self) -> usize {
        let strong = self.acting.terms.iter().any(|term| term.couples_strongly());
        if strong { self.rank_ones() } else { self.mass_parts() }
    }

    fn with_apparent_mass(&self, at: StateRef<'_>, residual: &mut [f64]) {
        self.with_apparent(node_state(at), bytemuck::cast_slice_mut(residual));
    }

    fn apparent_force(&self, at: StateRef<'_>, a: &[f64], out: &mut [f64]) {
        self.apparent_force_of(node_state(at), by_node(a), bytemuck::cast_slice_mut(out));
    }

    fn rank_one(&self, which: usize, at: StateRef<'_>, w: Weights, u: &mut [f64], g: &mut [f64]) {
        if which < self.mass_parts() {
            self.apparent_part(which, node_state(at), [&mut *u, &mut *g]);
            return u.iter_mut().for_each(|u| *u *= w.m);
        }
        let Some((term, number)) = self.couplings().nth(which - self.mass_parts()) else { return };
        let part = RankOne { u: bytemuck::cast_slice_mut(u), g: bytemuck::cast_slice_mut(g) };
        term.rank_one(number, node_state(at), w, part);
    }

    fn mean_rank_one(
        &self,
        which: usize,
        (middle, mean): (StateRef<'_>, StepMean),
        w: Weights,
        u: &mut [f64],
        g: &mut [f64],
    ) {
        let coupling = which.checked_sub(self.mass_parts()).and_then(|which| self.couplings().nth(which));
        let Some((of_mean, number)) = coupling.and_then(|(term, number)| Some((term.mean()?, number))) else {
            return self.rank_one(which, middle, w, u, g);
        };
        let part = RankOne { u: bytemuck::cast_slice_mut(u), g: bytemuck::cast_slice_mut(g) };
        of_mean.mean_rank_one(number, MeanStep { at: node_state(middle), mean }, w, part);
    }

    fn assemble_convex(&self, at: StateRef<'_>, w: Weights, assembler: &mut Assembler) {
        self.assemble_form(at, w, TangentForm { convex: true, symmetric: false }, assembler);
    }

    fn mean_forces(&self, middle: StateRef<'_>, mean: StepMean, out: &mut Forces) {
        self.evaluate_with(Some(mean), middle, out);
    }

    fn mean_assembler(&self) -> Result<Assembler, PatternError> {
        self.pattern_of(false)
    }

    fn assemble_mean(
        &self,
        middle: StateRef<'_>,
        mean: StepMean,
        w: Weights,
        form: TangentForm,
        assembler: &mut Assembler,
    ) {
        let near = assembler.near.clone();
        let mut sink = assembler.sink(|dof| w.m * self.built.mass[dof / 3]);
        self.emit_mean_tangents(MeanStep { at: node_state(middle), mean }, w, form, &mut sink);
        self.emit_law_tangents(middle, w, form, &mut sink);
        self.emit_near(&near, (middle, Some(mean)), w, form, &mut sink);
    }

    fn mixed(&self) -> Option<&dyn MixedSystem> {
        (!self.acting.springs.is_empty() || self.sheets() > 0).then_some(self)
    }

    fn turns_over(&self, from: &[f64], to: &[f64]) -> bool {
        self.acting.springs.iter().any(|batch| batch.data.turns_over(&batch.cut, [from, to].map(by_node)))
    }

    fn nodal_stiffness(&self) -> Vec<f64> {
        let mut nodes = vec![0.0; self.built.mass.len()];
        self.acting.terms.iter().for_each(|t| t.add_stiffness(&mut nodes));
        nodes.into_iter().flat_map(|k| [k; 3]).collect()
    }

    fn force_scale(&self, forces: &Forces) -> f64 {
        let (total, inverse_mass) = (by_node(&forces.total), by_node(&self.phase().inverse_mass));
        let (gravity, other) = (self.gravity(), by_node(&forces.external));
        let parts = |nodes: Range<usize>| {
            nodes.fold([0.0; 2], |[internal, external], i| {
                let free = inverse_mass[i].map(|inverse| f64::from(inverse > 0.0));
                let weight = self.built.weighed[i] * gravity;
                let load = other.get(i).map_or(weight, |e| *e + weight).component_mul(&free);
                [internal + (total[i] - load).norm_squared(), external + load.norm_squared()]
            })
        };
        let both = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a + c, b + d];
        let [internal, external] = self.threads.workers().fold(total.len(), [0.0; 2], parts, both);
        f64::max(internal, external).sqrt()
    }
}
