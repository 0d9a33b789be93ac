//! Where the forces of a network add to: blocks of nodes, sums by role, and an account for every part of every term.

use super::motion::SUPPORTS;
use super::network::Network;
use crate::force::kernel::batch::{BlockForces, PARTS};
use crate::force::schedule::sweep::Sweep;
use crate::force::schedule::terms::{PartTarget, Term, Terms};
use crate::force::{ForceTerm, NodeState};
use crate::model::forces::{Role, Tally};
use crate::model::system::TermInfo;
use nalgebra::Vector3;

/// A part of a force term.
#[derive(Clone, Copy)]
pub struct TermPart<'a> {
    pub term: &'a dyn ForceTerm,
    /// which of its parts
    pub part: usize,
}

/// Where the terms of a pass add to.
#[derive(Clone, Default)]
pub(super) struct Arrangement {
    /// of every part of every term
    pub infos: Vec<TermInfo>,
    /// sum of every part of every term, and its place among these
    pub parts: Vec<[Option<PartTarget>; PARTS]>,
    /// whether steps are made one by one: supports move, a force depends on all others, or in a scene of several
    /// blocks on nodes of the whole scene
    pub couples_blocks: bool,
}

impl Network {
    /// Cuts the scene into blocks and gives every part of every term its sum and its place in the account.
    pub(super) fn arrange(&mut self) {
        let mut forces: Vec<&mut dyn BlockForces> =
            self.acting.terms.iter_mut().map(|t| &mut **t as &mut dyn BlockForces).collect();
        self.sweep = Sweep::new(self.built.mass.len(), &mut forces);
        let couples = self.acting.terms.iter().any(|term| term.scene_numbers().is_some());
        let moves = self.built.phases.move_supports();
        self.arrangement.couples_blocks =
            moves || !self.acting.apparent.is_empty() || couples && !self.sweep.is_single_block();
        let own = self.acting.terms.iter().flat_map(|term| term.parts()).copied();
        let contact = self.contact.iter().flat_map(|contact| contact.infos());
        self.arrangement.infos = own.chain(contact).chain(self.law_info()).chain(moves.then_some(SUPPORTS)).collect();
        let mut tallies = 0..;
        let mut part = |info: &TermInfo| Some(PartTarget { sum: sum_of_role(info.role), tally: tallies.next()? });
        let parts = self.acting.terms.iter().map(|term| {
            let mut parts = [None; PARTS];
            parts.iter_mut().zip(term.parts()).for_each(|(to, info)| *to = part(info));
            parts
        });
        self.arrangement.parts = parts.collect();
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
        parts: &[TermPart<'_>],
        at: NodeState<'_>,
        f: &mut [Vector3<f64>],
        tallies: &mut [Tally],
    ) {
        self.sweep.pass(&SelectedTerms(parts), at, &self.threads, [f, &mut [], &mut []], tallies);
    }

    /// What one of [`System::terms`] is.
    pub fn term_of(&self, part: usize) -> Option<TermPart<'_>> {
        let places =
            |parts: &[Option<PartTarget>; PARTS]| parts.iter().position(|p| p.is_some_and(|p| p.tally == part));
        let mut terms = self.acting.terms.iter().zip(&self.arrangement.parts);
        terms.find_map(|(term, parts)| Some(TermPart { term: &**term, part: places(parts)? }))
    }

    /// Which energy and power is that of the first part of a term.
    pub(super) fn tally_of(&self, term: usize) -> Option<usize> {
        Some(self.arrangement.parts.get(term)?[0]?.tally)
    }
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
        self.acting.terms.len()
    }

    fn tallies(&self) -> usize {
        self.arrangement.parts.iter().flatten().flatten().count()
    }

    fn term(&self, i: usize) -> Term<'_> {
        Term { forces: &*self.acting.terms[i], parts: self.arrangement.parts[i] }
    }

    fn is_position_only(&self) -> bool {
        self.arrangement.infos.iter().all(|info| sum_of_role(info.role) > 0 || !info.velocity_dependent)
    }
}

/// Some of the parts of terms, in one sum.
struct SelectedTerms<'a>(&'a [TermPart<'a>]);

impl Terms for SelectedTerms<'_> {
    fn count(&self) -> usize {
        self.0.len()
    }

    fn tallies(&self) -> usize {
        self.0.len()
    }

    fn term(&self, i: usize) -> Term<'_> {
        let TermPart { term, part } = self.0[i];
        let mut parts = [None; PARTS];
        parts[part] = Some(PartTarget { sum: 0, tally: i });
        Term { forces: term, parts }
    }
}
