//! Supports that move: x(t) = x(0) + u(t) with a displacement u that is linear between the rows of a table. One that
//! has settled begins at x(0) = X + s, with a settlement s from where the mesh and the initial displacement put it.
//!
//! So a support has a constant velocity between two rows, and every scheme carries it along exactly: at held degrees
//! of freedom M^-1 is 0, and a step adds h v. At a row the velocity jumps, which is an event of the scene: the driver
//! ends a step there. The support's force on the scene is external in the ledger; its work over a step is that of the
//! reaction, R . (x_{n+1} - x_n). The jump of a held node's own kinetic energy is external work too, but no part of
//! the reaction.

use super::network::Network;
use super::numbering::Numbering;
use crate::model::forces::{Forces, Role};
use crate::model::spec::{MotionSpec, NetworkSpec, Series};
use crate::model::state::{State, StateRef};
use crate::model::system::TermInfo;

/// The force of moving supports.
pub(super) const SUPPORTS: TermInfo = TermInfo::of("supports", Role::External);

/// A support that moves, by the degrees of freedom that it moves.
#[derive(Clone, Debug)]
pub(super) struct Support {
    dofs: Vec<u32>,
    /// [m] displacement from where the nodes are at t = 0
    displacement: Series<[f64; 3]>,
    /// [m] displacement from the start
    settlement: [f64; 3],
}

/// Supports that hold their nodes in one phase.
#[derive(Debug, Default)]
pub(super) struct Moved {
    supports: Vec<Support>,
    /// all their degrees of freedom
    pub dofs: Vec<u32>,
    /// where the reaction of each of them is
    reactions: Vec<u32>,
}

impl Support {
    /// Those of a specification.
    pub(super) fn all(spec: &NetworkSpec, numbering: &Numbering) -> Vec<Self> {
        let of = |MotionSpec { nodes, displacement, settlement }: &MotionSpec| {
            let dofs = nodes.iter().flat_map(|&(node, axes)| {
                let first = 3 * numbering.internal[node as usize];
                (first..).zip(axes).filter(|(_, moved)| *moved).map(|(dof, _)| dof)
            });
            Support { dofs: dofs.collect(), displacement: displacement.clone(), settlement: *settlement }
        };
        spec.motions.iter().map(of).collect()
    }
}

impl Moved {
    /// Degrees of freedom whose positions and velocities are given with every state.
    pub(super) fn from_outside(dofs: Vec<u32>, fixed: &[[bool; 3]]) -> Self {
        let held = |dof: &u32| fixed.as_flattened()[..*dof as usize].iter().filter(|fixed| **fixed).count() as u32;
        let reactions = dofs.iter().map(held).collect();
        Moved { supports: Vec::new(), dofs, reactions }
    }

    /// Those of `supports` that hold something where this is `fixed`, `[n_nodes][3]`; `at_first` is what is fixed at t
    /// = 0.
    pub(super) fn new(supports: &[Support], fixed: &[[bool; 3]], at_first: &[[bool; 3]]) -> Self {
        if supports.is_empty() {
            return Moved::default();
        }
        let holds = |dof: &&u32| fixed.as_flattened().get(**dof as usize) == Some(&true);
        let held = supports.iter().map(|support| {
            let dofs = support.dofs.iter().filter(holds).copied().collect();
            Support { dofs, ..support.clone() }
        });
        let supports: Vec<Support> = held.filter(|support| !support.dofs.is_empty()).collect();
        let dofs: Vec<u32> = supports.iter().flat_map(|support| support.dofs.iter().copied()).collect();
        let mut next = 0;
        let place = |fixed: &bool| {
            let place = next;
            next += u32::from(*fixed);
            place
        };
        let places: Vec<u32> = at_first.as_flattened().iter().map(place).collect();
        let reactions = dofs.iter().map(|&dof| places[dof as usize]).collect();
        Moved { supports, dofs, reactions }
    }
}

impl Network {
    /// Puts what supports move where it is at the time of a state, with its velocity, after a `share` [-] of the
    /// displacement. Returns whether they move anything.
    pub(super) fn put_moved(&self, state: &mut State, share: f64) -> bool {
        // The clock of a run may pass an event a rounding error early or late.
        let [begun, next] = self.built.phases.around(self.passed());
        let t = state.t.max(begun);
        let before_next = f64::min(t, next.next_down());
        for Support { dofs, displacement, settlement } in &self.phase().moved.supports {
            let (moved, velocity) = (displacement.at(t), displacement.slope_after(before_next));
            for &dof in dofs {
                let (dof, axis) = (dof as usize, dof as usize % 3);
                state.x[dof] = self.built.start.as_ref()[dof / 3][axis] + share * (settlement[axis] + moved[axis]);
                state.v[dof] = velocity[axis];
            }
        }
        !self.phase().moved.supports.is_empty()
    }

    /// Adds their settlement to where supports hold nodes at the start, `x` [m] `[n_dof]`.
    pub(super) fn settle(&self, x: &mut [f64]) {
        for Support { dofs, settlement, .. } in &self.built.phases.after(0).moved.supports {
            dofs.iter().for_each(|&dof| x[dof as usize] += settlement[dof as usize % 3]);
        }
    }

    /// Adds the reactions of moving supports [N] to the external forces of a pass, and their power.
    pub(super) fn add_supports(&self, at: StateRef<'_>, out: &mut Forces) {
        let Moved { dofs, reactions, .. } = &self.phase().moved;
        let mut power = 0.0;
        for (&dof, &place) in dofs.iter().zip(reactions) {
            let reaction = out.reactions[place as usize];
            out.external[dof as usize] += reaction;
            power += reaction * at.v[dof as usize];
        }
        if self.arrangement.infos.last() == Some(&SUPPORTS)
            && let Some(tally) = out.tallies.last_mut()
        {
            tally.power = power;
        }
    }
}
