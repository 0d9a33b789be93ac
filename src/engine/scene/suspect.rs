//! What a failure report says about a node of a network, and the size of a network.

use super::arrangement::TermPart;
use super::network::{Network, by_node, node_state};
use super::{BoundBuffer, Controls, Scene, Suspect};
use crate::assembly::{SceneInterfaces, TangentSystem};
use crate::force::{TangentForm, TangentSink};
use crate::model::abilities::Events;
use crate::model::added_mass::AddedMass;
use crate::model::at_dof::AtDof;
use crate::model::bounds::extent;
use crate::model::forces::Role;
use crate::model::state::StateRef;
use crate::model::system::Weights;
use nalgebra::{Matrix3, Vector3};

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

    fn tangent_times(&self, at: StateRef<'_>, w: Weights, p: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        let mut product = Product { p: by_node(p), y: bytemuck::cast_slice_mut(y) };
        self.emit_tangents(at, w, TangentForm::EXACT, &mut product);
        let mut part = [Vec::new(), Vec::new()];
        for which in 0..self.rank_ones() {
            let [u, g] = &mut part;
            u.resize(p.len(), 0.0);
            g.resize(p.len(), 0.0);
            self.rank_one(which, at, w, u, g);
            let amount: f64 = g.iter().zip(p).map(|(g, p)| g * p).sum();
            y.iter_mut().zip(u).for_each(|(y, u)| *y += amount * *u);
        }
        for (y, &fixed) in y.iter_mut().zip(self.phase().fixed.as_flattened()) {
            if fixed {
                *y = 0.0;
            }
        }
    }
}

impl Network {
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

/// Multiplies emitted blocks by a vector instead of storing them: y += A p.
struct Product<'a> {
    p: &'a [Vector3<f64>],
    y: &'a mut [Vector3<f64>],
}

impl Product<'_> {
    /// An element with any blocks.
    fn element<const N: usize>(&mut self, nodes: [u32; N], blocks: &[[Matrix3<f64>; N]; N]) {
        for (&i, row) in nodes.iter().zip(blocks) {
            for (&j, block) in nodes.iter().zip(row) {
                self.y[i as usize] += *block * self.p[j as usize];
            }
        }
    }
}

impl TangentSink for Product<'_> {
    fn pair(&mut self, [i, j]: [u32; 2], block: Matrix3<f64>) {
        self.y[i as usize] += block * self.p[j as usize];
    }

    fn edge(&mut self, [a, b]: [u32; 2], block: Matrix3<f64>) {
        let d = block * (self.p[a as usize] - self.p[b as usize]);
        self.y[a as usize] += d;
        self.y[b as usize] -= d;
    }

    fn segment(&mut self, nodes: [u32; 2], blocks: &[[Matrix3<f64>; 2]; 2]) {
        self.element(nodes, blocks);
    }

    fn triangle(&mut self, nodes: [u32; 3], blocks: &[[Matrix3<f64>; 3]; 3]) {
        self.element(nodes, blocks);
    }
}
