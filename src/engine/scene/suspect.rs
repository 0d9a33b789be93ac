//! What a failure report says about a node of a network, and the size of a network.

use super::adjoint::Adjoint;
use super::arrangement::TermPart;
use super::contact::CONTACT;
use super::network::{Network, by_node, node_state};
use super::stored_tangents::{StoredTangents, TangentProducts};
use super::{BoundBuffer, Controls, Scene, Suspect};
use crate::assembly::SceneInterfaces;
use crate::model::abilities::Events;
use crate::model::added_mass::AddedMass;
use crate::model::at_dof::AtDof;
use crate::model::bounds::extent;
use crate::model::forces::Role;
use crate::model::state::StateRef;
use crate::model::system::Weights;
use nalgebra::Vector3;

const AXES: [&str; 3] = ["x", "y", "z"];

impl Scene for Network {
    fn interfaces(&self) -> SceneInterfaces<'_> {
        SceneInterfaces { system: self, tangent: self, graph: Some(self) }
    }

    fn for_run(&self) -> Box<dyn Scene> {
        Box::new(self.copy())
    }

    fn events(&self) -> Option<&dyn Events> {
        Some(self)
    }

    fn controls(&self) -> Option<&dyn Controls> {
        Some(self)
    }

    fn controls_mut(&mut self) -> Option<&mut dyn Controls> {
        Some(self)
    }

    fn added_mass(&self) -> Option<AddedMass> {
        self.built.added_mass
    }

    fn size(&self) -> f64 {
        extent(bytemuck::cast_slice(&self.built.start), self.threads.workers()).max(self.built.reach)
    }

    fn extent(&self, at: StateRef<'_>) -> f64 {
        extent(bytemuck::cast_slice(at.x), self.threads.workers())
    }

    fn suspect(&self, at: StateRef<'_>, dof: usize) -> Suspect {
        let node = dof / 3;
        let mut strongest = (0.0, None);
        let mut f = vec![Vector3::zeros(); self.phase().fixed.len()];
        for (part, info) in self.arrangement.infos.iter().enumerate().filter(|(part, _)| self.term_of(*part).is_some())
        {
            self.pass_of(part, node_state(at), &mut f);
            let size = f[node].norm();
            // A force that is not finite counts as the strongest.
            let size = if size.is_finite() { size } else { f64::INFINITY };
            if size > strongest.0 {
                strongest = (size, Some(*info));
            }
        }
        if let Some(contact) = &self.contact {
            f.fill(Vector3::zeros());
            let mut dissipative = f.clone();
            contact.add(node_state(at), [&mut f, &mut dissipative], &mut []);
            if !f[node].norm().is_finite() || f[node].norm() > strongest.0 {
                strongest.1 = Some(CONTACT);
            }
        }
        Suspect {
            node: Some(self.built.numbering.user[node]),
            spring: self.most_strained_at(node as u32, at),
            term: strongest.1,
        }
    }

    fn term_alone(&self, term: usize, at: StateRef<'_>, f: &mut [f64]) -> Option<usize> {
        let forces = self.term_of(term)?.term;
        self.pass_of(term, node_state(at), bytemuck::cast_slice_mut(f));
        Some(forces.elements())
    }

    fn name_of(&self, dof: usize) -> (u32, &'static str) {
        (self.built.numbering.user[dof / 3], AXES[dof % 3])
    }

    fn load(&self, at: StateRef<'_>, f: &mut [f64]) {
        let loads = self
            .arrangement
            .infos
            .iter()
            .enumerate()
            .filter(|(_, info)| matches!(info.role, Role::Gravity | Role::External));
        let parts: Vec<TermPart<'_>> = loads.filter_map(|(part, _)| self.term_of(part)).collect();
        self.sum_of(&parts, node_state(at), bytemuck::cast_slice_mut(f), &mut []);
        self.add_laws(at, [bytemuck::cast_slice_mut(f), &mut []]);
        for (f, &fixed) in f.iter_mut().zip(self.phase().fixed.as_flattened()) {
            if fixed {
                *f = 0.0;
            }
        }
    }

    fn rate_bound(&self, at: StateRef<'_>, w: Weights, buffer: &mut BoundBuffer) -> AtDof {
        self.node_bound(at, w, buffer)
    }

    fn sharper_rate_bound(&self, at: StateRef<'_>, w: Weights) -> AtDof {
        self.sharper_node_bound(at, w)
    }

    fn adjoint(&self) -> Option<&dyn Adjoint> {
        Some(self)
    }

    fn tangent_times(&self, at: StateRef<'_>, w: Weights, p: &[f64], y: &mut [f64]) {
        self.product::<false>(at, w, p, y);
        self.hold(y);
    }

    fn tangent_products<'a>(&'a self, at: StateRef<'a>) -> Option<Box<dyn TangentProducts + 'a>> {
        Some(Box::new(StoredTangents::of(self, at)?))
    }
}

impl Network {
    /// Sets what belongs to held degrees of freedom to 0.
    pub(super) fn hold(&self, y: &mut [f64]) {
        let fixed = y.iter_mut().zip(self.phase().fixed.as_flattened()).filter(|(_, fixed)| **fixed);
        fixed.for_each(|(y, _)| *y = 0.0);
    }

    fn most_strained_at(&self, node: u32, at: StateRef<'_>) -> Option<u32> {
        let mut worst: Option<(f64, u32)> = None;
        for batch in self.carrying() {
            let springs = batch.data.at(at.t, by_node(at.x));
            for (i, nodes) in batch.data.nodes.iter().enumerate().filter(|(_, n)| n.contains(&node)) {
                let strain = batch.data.strain(springs, i).abs();
                if worst.is_none_or(|(w, _)| strain > w || strain.is_nan()) {
                    worst = Some((strain, batch.edges[i]));
                }
                debug_assert!(nodes.contains(&node));
            }
        }
        worst.map(|(_, edge)| edge)
    }
}
