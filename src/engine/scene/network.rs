//! A spring network: mass, force terms and fixed degrees of freedom.

use super::Load;
use super::acting::{Acting, SpringBatch};
use super::arrangement::Arrangement;
use super::build_surface::MembraneBatch;
use super::contact::Touching;
use super::events::Phases;
use super::external::ExternalForces;
use super::graph::{Graph, KnownGraph};
use super::numbering::Numbering;
use super::triggers::Triggers;
use crate::contact::bodies::Contacts;
use crate::force::schedule::step_block::StepBlockResults;
use crate::force::schedule::step_boundary::NodeStateMut;
use crate::force::schedule::step_boundary::StepBoundary;
use crate::force::schedule::sweep::Sweep;
use crate::force::schedule::terms::Terms;
use crate::force::schedule::threads::{SUMS, Threads};
use crate::force::{Copies, ForceTerm, MeanStep, NodeState};
use crate::mesh::Mesh;
use crate::model::abilities::Touches;
use crate::model::added_mass::AddedMass;
use crate::model::forces::{Forces, Role, Tally};
use crate::model::motion::motion;
use crate::model::state::{State, StateRef};
use crate::model::step_block::{self, StepSummary};
use crate::model::system::{KickDriftBlock, StepBlocks, StepMean, StiffSprings, System, TermInfo};
use crate::model::workers::Workers;
use nalgebra::Vector3;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

/// A scene of springs, masses and what acts on them, in a run. Another run has a copy of its own, by
/// [`Scene::for_run`](super::Scene::for_run).
pub struct Network {
    pub(super) built: Arc<Built>,
    pub(super) acting: Acting,
    /// set once a program adds forces from outside
    pub(super) external: Option<ExternalForces>,
    /// what may touch
    pub(super) contact: Option<Touching>,
    pub(super) arrangement: Arrangement,
    /// events that are passed
    pub(super) passed: AtomicUsize,
    /// which of the phases that events began it is in, counted from 1; 0 for none of them
    pub(super) later: AtomicUsize,
    /// that of its springs, once some are cut or have broken
    pub(super) graph: KnownGraph,
    pub(super) sweep: Sweep,
    pub(super) threads: Threads,
    /// the user's mesh, for pictures
    pub(super) mesh: Arc<Mesh>,
}

/// What is the same in all runs of a scene; all arrays in internal numbering.
#[derive(Default)]
pub(super) struct Built {
    pub numbering: Numbering,
    pub phases: Phases,
    pub triggers: Triggers,
    /// [kg] inertia of every node
    pub mass: Arc<[f64]>,
    /// [kg] mass of every node that has weight: the same but for masses that are scaled
    pub weighed: Arc<[f64]>,
    pub added_mass: Option<AddedMass>,
    pub start: Arc<[Vector3<f64>]>,
    pub velocity: Vec<[f64; 3]>,
    /// [m/s^2]
    pub gravity: Vector3<f64>,
    /// [s] rows of load and wind tables
    pub corners: Vec<f64>,
    /// [s] beginnings and ends of all changes over time
    pub changing: Vec<[f64; 2]>,
    pub membranes: Vec<MembraneBatch>,
    /// fixed at t = 0
    pub fixed_dofs: Vec<u32>,
    /// [m] half of what rest lengths let it extend to
    pub reach: f64,
    /// the graph of all springs
    pub graph: OnceLock<Arc<Graph>>,
    /// whether some edge has several springs
    pub shared_edges: bool,
}

pub(super) fn by_node(dofs: &[f64]) -> &[Vector3<f64>] {
    bytemuck::cast_slice(dofs)
}

pub(super) fn node_state(at: StateRef<'_>) -> NodeState<'_> {
    NodeState { t: at.t, x: by_node(at.x), v: by_node(at.v) }
}

impl Network {
    /// A network at t = 0. What follows from its parts need not be given.
    pub(super) fn new(built: Built, acting: Acting, may_touch: Option<Contacts>, mesh: Mesh, threads: Threads) -> Self {
        let fixed = built.phases.after(0).fixed.as_flattened();
        let fixed_dofs: Vec<u32> = (0..).zip(fixed).filter(|&(_, &f)| f).map(|(i, _)| i).collect();
        let shared_edges = shares_edges(&acting.springs);
        let mut network = Network {
            built: Arc::new(Built { fixed_dofs, shared_edges, ..built }),
            acting,
            external: None,
            contact: None,
            arrangement: Arrangement::default(),
            passed: AtomicUsize::new(0),
            later: AtomicUsize::new(0),
            graph: KnownGraph::default(),
            sweep: Sweep::new(0, &mut []),
            threads,
            mesh: Arc::new(mesh),
        };
        network.contact = may_touch.map(|contacts| Touching::new(contacts, &network.built.numbering.user));
        network.arrange();
        network
    }

    /// See [`super::Scene::for_run`].
    pub(super) fn copy(&self) -> Self {
        let copies = &mut Copies::default();
        Network {
            built: self.built.clone(),
            acting: self.acting.for_run(copies),
            external: self.external.as_ref().map(|external| external.for_run(copies)),
            contact: self.contact.as_ref().map(|contact| contact.for_run()),
            arrangement: self.arrangement.clone(),
            passed: AtomicUsize::new(self.passed()),
            later: AtomicUsize::new(self.later.load(Ordering::Relaxed)),
            graph: KnownGraph::default(),
            sweep: self.sweep.again(),
            threads: self.threads.again(),
            mesh: self.mesh.clone(),
        }
    }

    /// [m/s^2] Acceleration of free fall, with the program's factor; 0 without gravity.
    pub(super) fn gravity(&self) -> Vector3<f64> {
        let scale = self.acting.loads.iter().find(|found| found.load == Load::Gravity);
        self.built.gravity * scale.map_or(1.0, |found| found.scale.get())
    }

    /// Multiplies rest lengths by factors, `[n_edges]`. What was made from them before does not fit any more.
    pub(super) fn scale_rest_lengths(&mut self, factors: &[f64]) {
        // Springs are the first terms, one a batch.
        for (batch, term) in self.acting.springs.iter_mut().zip(&mut self.acting.terms) {
            let scaled = batch.given.iter().zip(batch.edges.iter()).map(|(l0, &edge)| l0 * factors[edge as usize]);
            batch.data.rest_length = scaled.collect();
            term.set_rest_lengths(&batch.data.rest_length);
        }
    }

    /// Gives the memory of the picture back; frames can then not be drawn any more.
    pub fn forget_picture(&mut self) {
        self.mesh = Arc::default();
        self.acting.pressures = Vec::new();
    }

    /// The terms.
    pub fn force_terms(&self) -> impl Iterator<Item = &dyn ForceTerm> {
        self.acting.terms.iter().map(|t| &**t)
    }

    /// A pass over all terms at a state; elastic forces are means over the step around it, if one is given.
    pub(super) fn evaluate_with(&self, mean: Option<StepMean>, at: StateRef<'_>, out: &mut Forces) {
        self.pass_into(out, |[total, external, dissipative], tallies| {
            let (own, outside) = tallies.split_at_mut(self.tallies());
            let sums = [&mut *total, &mut *external, &mut *dissipative];
            match mean {
                None => self.sweep.pass(self, node_state(at), &self.threads, sums, own),
                Some(mean) => self.mean_pass(MeanStep { at: node_state(at), mean }, sums, own),
            }
            let (of_contact, of_laws) = outside.split_at_mut(self.contact.iter().flat_map(|c| c.infos()).count());
            self.add_contact((at, mean), [&mut *total, dissipative], of_contact);
            if let Some(tally) = of_laws.first_mut() {
                *tally = self.add_laws(at, [&mut *total, &mut *external]);
            }
            self.add_apparent(node_state(at), [total, external], own);
        });
        self.add_supports(at, out);
    }

    /// A pass over all terms, with the forces at fixed degrees of freedom turned into reactions.
    fn pass_into(&self, out: &mut Forces, pass: impl FnOnce([&mut [Vector3<f64>]; SUMS], &mut [Tally])) {
        let Forces { total, external, dissipative, reactions, tallies } = out;
        pass([&mut *total, external, dissipative].map(|sum| bytemuck::cast_slice_mut(sum)), tallies);
        for (reaction, &dof) in reactions.iter_mut().zip(&self.built.fixed_dofs) {
            *reaction = -std::mem::take(&mut total[dof as usize]);
        }
        let released = self.phase().released.iter().zip(reactions).zip(&self.built.fixed_dofs);
        for ((_, reaction), &dof) in released.filter(|((released, _), _)| **released) {
            // Minus twice keeps every bit.
            total[dof as usize] = -std::mem::take(reaction);
        }
    }

    /// [N] Reaction at a degree of freedom; 0 where it is free.
    pub(super) fn reaction(&self, forces: &Forces, dof: u32) -> f64 {
        self.built.fixed_dofs.binary_search(&dof).map_or(0.0, |place| forces.reactions[place])
    }

    fn has_role(&self, role: Role) -> bool {
        self.arrangement.infos.iter().any(|i| i.role == role)
    }
}

/// Whether two springs are on one edge.
fn shares_edges(springs: &[SpringBatch]) -> bool {
    let edges = || springs.iter().flat_map(|batch| batch.edges.iter());
    let mut taken = vec![false; edges().max().map_or(0, |&last| last as usize + 1)];
    edges().any(|&edge| std::mem::replace(&mut taken[edge as usize], true))
}

impl System for Network {
    fn n_dof(&self) -> usize {
        3 * self.built.mass.len()
    }

    fn initial_state(&self) -> State {
        let mut x: Vec<f64> = self.built.start.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
        self.settle(&mut x);
        let v = match self.built.velocity.as_slice() {
            [] => vec![0.0; self.n_dof()],
            v => v.as_flattened().to_vec(),
        };
        State { t: 0.0, x, v }
    }

    fn terms(&self) -> &[TermInfo] {
        &self.arrangement.infos
    }

    fn new_forces(&self) -> Forces {
        let sized = |role| if self.has_role(role) { vec![0.0; self.n_dof()] } else { Vec::new() };
        Forces {
            total: vec![0.0; self.n_dof()],
            external: sized(Role::External),
            dissipative: sized(Role::Dissipative),
            // As many in every phase.
            reactions: vec![0.0; self.built.fixed_dofs.len()],
            tallies: vec![Tally::default(); self.arrangement.infos.len()],
        }
    }

    fn evaluate(&self, at: StateRef<'_>, out: &mut Forces) {
        self.evaluate_with(None, at, out);
    }

    fn inverse_mass(&self) -> &[f64] {
        &self.phase().inverse_mass
    }

    fn moved(&self) -> &[u32] {
        &self.phase().moved.dofs
    }

    fn mass_times(&self, a: &[f64], out: &mut [f64]) {
        self.threads.workers().set(out, |range, out| {
            let masses = &self.built.mass[range.start / 3..];
            for ((out, a), m) in out.chunks_exact_mut(3).zip(a[range].chunks_exact(3)).zip(masses) {
                out.iter_mut().zip(a).for_each(|(out, a)| *out = m * a);
            }
        });
    }

    fn kinetic_energy(&self, v: &[f64]) -> f64 {
        self.sweep.by_node_blocks(&self.threads, |nodes| {
            motion(&v[3 * nodes.start..3 * nodes.end], &self.built.mass[nodes]).kinetic
        })
    }

    fn work(&self, forces: [&[f64]; 2], [x_n, x_n1]: [&[f64]; 2]) -> f64 {
        if forces[0].is_empty() {
            return 0.0;
        }
        self.sweep.by_node_blocks(&self.threads, |nodes| {
            let dofs = 3 * nodes.start..3 * nodes.end;
            let forces = forces.map(|f| &f[dofs.clone()]);
            let [begun, ended] = step_block::work::<3, 2>(forces, &x_n[dofs.clone()], &x_n1[dofs]);
            0.5 * (begun + ended)
        })
    }

    fn reeling_power(&self, [t0, t1]: [f64; 2], tallies: &[Tally]) -> f64 {
        // Springs are the first terms, one a batch.
        let changes = self.acting.springs.iter().zip(&self.arrangement.parts).filter_map(|(batch, [part, _])| {
            let table = batch.data.rest_scale.as_ref()?;
            let rate = (table.at(t1)[0] - table.at(t0)[0]) / (t1 - t0);
            Some(-rate * tallies.get((*part)?.tally)?.power)
        });
        let filled = self.acting.gases.iter().filter_map(|(term, gas)| {
            let rate = (gas.law.amount(t1) - gas.law.amount(t0)) / (t1 - t0);
            Some(rate * tallies.get(self.tally_of(*term)?)?.power)
        });
        // A moving obstacle does work on what it touches.
        let pushed = self
            .contact
            .as_ref()
            .filter(|contact| contact.contacts.moves())
            .and_then(|_| tallies.get(self.tallies()).map(|tally| tally.power));
        changes.chain(filled).chain(pushed).sum()
    }

    fn workers(&self) -> &Workers {
        self.threads.workers()
    }

    fn blocks(&self) -> Option<&dyn StepBlocks> {
        let single = self.law_info().is_some() || self.contact.as_ref().is_some_and(|contact| !contact.in_block());
        let single = single || self.arrangement.couples_blocks;
        (!single).then_some(self)
    }

    fn stiff(&self) -> Option<&dyn StiffSprings> {
        (!self.acting.springs.is_empty()).then_some(self)
    }

    fn touches(&self) -> Option<&dyn Touches> {
        Some(self.contact.as_ref()?)
    }

    fn velocity_dependent(&self) -> bool {
        self.arrangement.infos.iter().any(|i| i.velocity_dependent)
    }
}

impl StepBlocks for Network {
    fn longest_block(&self) -> usize {
        self.sweep.longest_block(if self.velocity_dependent() { 2 } else { 1 })
    }

    fn advance(&self, at: &mut State, out: &mut Forces, block: KickDriftBlock<'_>, summaries: &mut [StepSummary]) {
        let moving = NodeStateMut { t: at.t, first: 0, x: &mut at.x, v: &mut at.v };
        let boundary = StepBoundary { block, mass: &self.built.mass, inverse_mass: &self.phase().inverse_mass };
        let own = self.tallies();
        self.pass_into(out, |sums, tallies| {
            let (tallies, of_contact) = tallies.split_at_mut(own);
            of_contact.fill(Tally::default());
            let results = StepBlockResults { sums, tallies, summaries };
            self.sweep.advance(self, moving, boundary, &self.threads, results);
        });
    }
}
