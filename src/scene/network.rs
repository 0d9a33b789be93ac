//! A spring network: mass, force terms and fixed degrees of freedom.

use super::apparent::ApparentMass;
use super::external::ExternalForces;
use super::graph::Graph;
use super::numbering::Numbering;
use crate::force::kernel::batch::{BlockForces, PARTS};
use crate::force::law::series::SampledTable;
use crate::force::law::spring::{Coefficient, SpringData};
use crate::force::law::stream::Stream;
use crate::force::schedule::step_block::NodeStateMut;
use crate::force::schedule::step_boundary::StepBoundary;
use crate::force::schedule::sweep::{PartTarget, Sweep, Term, Terms};
use crate::force::schedule::threads::{SUMS, Threads};
use crate::force::{ForceTerm, NodeState};
use crate::mesh::Mesh;
use crate::model::forces::{Forces, Role, Tally};
use crate::model::motion::motion;
use crate::model::state::{State, StateRef};
use crate::model::step_block::{self, StepSummary};
use crate::model::system::{KickDriftBlock, System, TermInfo, single_step};
use crate::model::workers::Workers;
use nalgebra::Vector3;
use std::sync::{Arc, OnceLock};

/// A scene of springs, masses and what acts on them.
pub struct Network {
    pub(super) numbering: Numbering,
    /// which of x, y, z is fixed, by internal node
    pub(super) fixed: Vec<[bool; 3]>,
    fixed_dofs: Vec<u32>,
    pub(super) mass: Arc<[f64]>,
    pub(super) inverse_mass: Vec<f64>,
    pub(super) start: Arc<[Vector3<f64>]>,
    velocity: Vec<[f64; 3]>,
    pub(super) gravity: Option<Vector3<f64>>,
    corners: Vec<f64>,
    tables: Vec<Arc<dyn SampledTable>>,
    pub(super) terms: Vec<Box<dyn ForceTerm>>,
    /// of every part of every term
    pub(super) infos: Vec<TermInfo>,
    /// sum of every part of every term, and its place among these
    parts: Vec<[Option<PartTarget>; PARTS]>,
    pub(super) springs: Vec<SpringBatch>,
    /// whether some edge has several springs
    pub(super) shared_edges: bool,
    /// set once a program adds forces from outside
    pub(super) external: Option<ExternalForces>,
    /// the air around it, shared with the terms
    pub(super) stream: Option<Arc<Stream>>,
    /// whether steps are made one by one: a force depends on all others, or in a scene of several blocks on nodes of
    /// the whole scene
    couples_blocks: bool,
    /// air that canopies take along
    pub(super) apparent: Vec<ApparentMass>,
    sweep: Sweep,
    pub(super) threads: Threads,
    /// the user's mesh, for pictures
    pub(super) mesh: Mesh,
    /// made when a scheme first asks for it
    pub(super) graph: OnceLock<Graph>,
}

/// Springs of one rule, as the terms hold them, with their way back to the user's edges.
#[derive(Clone, Debug)]
pub struct SpringBatch {
    /// arrays shared with the terms
    pub data: SpringData,
    /// user's edge of every spring
    pub edges: Vec<u32>,
    /// [N s/m] dashpot coefficients, 0 without
    pub dashpot: Coefficient,
    /// whether the dashpots act along the springs
    pub axial: bool,
    /// whether the dashpots are relative with c = k h, which Kang's filter contains
    pub in_filter: bool,
}

/// What `build` hands over; all arrays in internal numbering but the mesh.
pub(super) struct Parts {
    pub numbering: Numbering,
    pub fixed: Vec<[bool; 3]>,
    pub mass: Arc<[f64]>,
    pub start: Arc<[Vector3<f64>]>,
    pub velocity: Vec<[f64; 3]>,
    pub gravity: Option<Vector3<f64>>,
    /// [s] rows of load and wind tables
    pub corners: Vec<f64>,
    /// load and wind tables, shared with the terms
    pub tables: Vec<Arc<dyn SampledTable>>,
    pub stream: Option<Arc<Stream>>,
    pub apparent: Vec<ApparentMass>,
    pub terms: Vec<Box<dyn ForceTerm>>,
    pub springs: Vec<SpringBatch>,
    pub threads: Threads,
    pub mesh: Mesh,
}

pub(super) fn by_node(dofs: &[f64]) -> &[Vector3<f64>] {
    bytemuck::cast_slice(dofs)
}

pub(super) fn node_state(at: StateRef<'_>) -> NodeState<'_> {
    NodeState { t: at.t, x: by_node(at.x), v: by_node(at.v) }
}

impl Network {
    pub(super) fn assemble_parts(mut p: Parts) -> Self {
        let mut forces: Vec<&mut dyn BlockForces> =
            p.terms.iter_mut().map(|t| &mut **t as &mut dyn BlockForces).collect();
        let sweep = Sweep::new(p.mass.len(), &mut forces);
        let fixed_dofs: Vec<u32> = (0..).zip(p.fixed.as_flattened()).filter(|&(_, &f)| f).map(|(i, _)| i).collect();
        let inverse_mass =
            p.fixed.iter().zip(p.mass.iter()).flat_map(|(f, &m)| f.map(|f| if f { 0.0 } else { 1.0 / m }));
        let infos: Vec<TermInfo> = p.terms.iter().flat_map(|term| term.parts()).copied().collect();
        let mut tallies = 0..;
        let mut part = |info: &TermInfo| Some(PartTarget { sum: sum_of_role(info.role), tally: tallies.next()? });
        let parts = p.terms.iter().map(|term| {
            let mut parts = [None; PARTS];
            parts.iter_mut().zip(term.parts()).for_each(|(to, info)| *to = part(info));
            parts
        });
        let parts = parts.collect();
        let couples_blocks = !p.apparent.is_empty()
            || !sweep.is_single_block() && p.terms.iter().any(|term| term.scene_number().is_some());
        Network {
            inverse_mass: inverse_mass.collect(),
            fixed_dofs,
            infos,
            parts,
            numbering: p.numbering,
            fixed: p.fixed,
            mass: p.mass,
            start: p.start,
            velocity: p.velocity,
            gravity: p.gravity,
            corners: p.corners,
            tables: p.tables,
            terms: p.terms,
            shared_edges: shares_edges(&p.springs, p.mesh.edges.len()),
            springs: p.springs,
            external: None,
            stream: p.stream,
            couples_blocks,
            apparent: p.apparent,
            sweep,
            threads: p.threads,
            mesh: p.mesh,
            graph: OnceLock::new(),
        }
    }

    /// Gives the memory of the picture back; frames can then not be drawn any more.
    pub fn forget_picture(&mut self) {
        self.mesh = Mesh::default();
    }

    /// The terms.
    pub fn force_terms(&self) -> impl Iterator<Item = &dyn ForceTerm> {
        self.terms.iter().map(|t| &**t)
    }

    /// `f =` the forces [N] of one of [`System::terms`] alone; returns its energy [J] or power [W]. 0 beyond the last.
    pub fn pass_of(&self, part: usize, at: NodeState<'_>, f: &mut [Vector3<f64>]) -> Tally {
        let mut tally = [Tally::default()];
        self.sum_of(self.term_of(part).as_slice(), at, f, &mut tally);
        tally[0]
    }

    /// `f =` the forces [N] of some terms, of one of the parts of each.
    pub(super) fn sum_of(
        &self,
        parts: &[(&dyn ForceTerm, usize)],
        at: NodeState<'_>,
        f: &mut [Vector3<f64>],
        tallies: &mut [Tally],
    ) {
        self.sweep.pass((&SelectedTerms(parts), at), &self.threads, [f, &mut [], &mut []], tallies);
    }

    /// The force term that one of [`System::terms`] is a part of, and which part it is.
    pub fn term_of(&self, part: usize) -> Option<(&dyn ForceTerm, usize)> {
        let places =
            |parts: &[Option<PartTarget>; PARTS]| parts.iter().position(|p| p.is_some_and(|p| p.tally == part));
        let mut terms = self.terms.iter().zip(&self.parts);
        terms.find_map(|(term, parts)| Some((&**term, places(parts)?)))
    }

    /// Which energy and power is that of the first part of a term.
    pub(super) fn tally_of(&self, term: usize) -> Option<usize> {
        Some(self.parts.get(term)?[0]?.tally)
    }

    /// A pass over all terms, with the forces at fixed degrees of freedom turned into reactions.
    fn pass_into(&self, out: &mut Forces, pass: impl FnOnce([&mut [Vector3<f64>]; SUMS], &mut [Tally])) {
        let Forces { total, external, dissipative, reactions, tallies } = out;
        pass([&mut *total, external, dissipative].map(|sum| bytemuck::cast_slice_mut(sum)), tallies);
        for (reaction, &dof) in reactions.iter_mut().zip(&self.fixed_dofs) {
            *reaction = -std::mem::take(&mut total[dof as usize]);
        }
    }

    fn has_role(&self, role: Role) -> bool {
        self.infos.iter().any(|i| i.role == role)
    }
}

/// Whether two springs are on one of so many edges.
fn shares_edges(springs: &[SpringBatch], edges: usize) -> bool {
    let mut taken = vec![false; edges];
    springs.iter().flat_map(|batch| &batch.edges).any(|&edge| std::mem::replace(&mut taken[edge as usize], true))
}

/// The sum of a pass that terms of a role add to.
fn sum_of_role(role: Role) -> usize {
    match role {
        Role::Elastic | Role::Gravity => 0,
        Role::External => 1,
        Role::Dissipative => 2,
    }
}

/// The terms, each part with the sum of its role.
impl Terms for Network {
    fn count(&self) -> usize {
        self.terms.len()
    }

    fn tallies(&self) -> usize {
        self.parts.iter().flatten().flatten().count()
    }

    fn term(&self, i: usize) -> Term<'_> {
        Term { forces: &*self.terms[i], parts: self.parts[i] }
    }

    fn is_position_only(&self) -> bool {
        self.infos.iter().all(|info| sum_of_role(info.role) > 0 || !info.velocity_dependent)
    }
}

/// Some of the parts of terms, in one sum.
struct SelectedTerms<'a>(&'a [(&'a dyn ForceTerm, usize)]);

impl Terms for SelectedTerms<'_> {
    fn count(&self) -> usize {
        self.0.len()
    }

    fn tallies(&self) -> usize {
        self.0.len()
    }

    fn term(&self, i: usize) -> Term<'_> {
        let (term, part) = self.0[i];
        let mut parts = [None; PARTS];
        parts[part] = Some(PartTarget { sum: 0, tally: i });
        Term { forces: term, parts }
    }
}

impl System for Network {
    fn n_dof(&self) -> usize {
        3 * self.mass.len()
    }

    fn initial_state(&self) -> State {
        let x = self.start.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
        let v = match self.velocity.as_slice() {
            [] => vec![0.0; self.n_dof()],
            v => v.as_flattened().to_vec(),
        };
        State { t: 0.0, x, v }
    }

    fn terms(&self) -> &[TermInfo] {
        &self.infos
    }

    fn new_forces(&self) -> Forces {
        let sized = |role| if self.has_role(role) { vec![0.0; self.n_dof()] } else { Vec::new() };
        Forces {
            total: vec![0.0; self.n_dof()],
            external: sized(Role::External),
            dissipative: sized(Role::Dissipative),
            reactions: vec![0.0; self.fixed_dofs.len()],
            tallies: vec![Tally::default(); self.infos.len()],
        }
    }

    fn evaluate(&self, at: StateRef<'_>, out: &mut Forces) {
        self.pass_into(out, |[total, external, dissipative], tallies| {
            let (own, outside) = tallies.split_at_mut(self.tallies());
            let sums = [&mut *total, &mut *external, dissipative];
            self.sweep.pass((self, node_state(at)), &self.threads, sums, own);
            outside.fill(self.add_external(at, [&mut *total, &mut *external]));
            self.add_apparent(node_state(at), [total, external], own);
        });
    }

    fn longest_block(&self) -> usize {
        if self.external.is_some() || self.couples_blocks {
            return 0;
        }
        self.sweep.longest_block(if self.velocity_dependent() { 2 } else { 1 })
    }

    fn advance(&self, at: &mut State, out: &mut Forces, block: KickDriftBlock<'_>, summaries: &mut [StepSummary]) {
        if self.external.is_some() || self.couples_blocks {
            return single_step(self, at, out, block);
        }
        let moving = NodeStateMut { t: at.t, first: 0, x: &mut at.x, v: &mut at.v };
        let boundary = StepBoundary { block, mass: &self.mass, inverse_mass: &self.inverse_mass };
        self.pass_into(out, |sums, tallies| {
            self.sweep.advance((self, moving), boundary, &self.threads, sums, (tallies, summaries));
        });
    }

    fn inverse_mass(&self) -> &[f64] {
        &self.inverse_mass
    }

    fn mass_times(&self, a: &[f64], out: &mut [f64]) {
        for ((out, a), m) in out.chunks_exact_mut(3).zip(a.chunks_exact(3)).zip(self.mass.iter()) {
            for (out, a) in out.iter_mut().zip(a) {
                *out = m * a;
            }
        }
    }

    fn kinetic_energy(&self, v: &[f64]) -> f64 {
        self.sweep.by_node_blocks(&self.threads, |nodes| {
            motion(&v[3 * nodes.start..3 * nodes.end], &self.mass[nodes]).kinetic
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

    fn workers(&self) -> &Workers {
        self.threads.workers()
    }

    fn sample_tables(&self, h: Option<f64>) {
        self.tables.iter().for_each(|table| table.sample(h));
    }

    fn corners(&self) -> Vec<f64> {
        self.corners.clone()
    }

    fn velocity_dependent(&self) -> bool {
        self.infos.iter().any(|i| i.velocity_dependent)
    }
}
