//! The observable quantities of a system: nodes in space, in the user's numbering. Output uses this interface.

use super::abilities::{Air, Springs};
use super::gauge::NodeQuantity;
use super::state::StateRef;
use super::system::System;
use crate::mesh::{Groups, NamedParts, with_groups};
use crate::model::forces::Forces;
use crate::model::point::Point;

/// What a membrane triangle shows of itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MembranePicture {
    /// [Pa] principal stresses, the larger first: force per current width over the thickness at rest
    pub stress: [f64; 2],
    /// [-] principal Green strains, the larger first
    pub strain: [f64; 2],
    /// 0 taut, 1 wrinkled, 2 slack; -1 for a triangle without a membrane
    pub wrinkling: f64,
    /// unit vector along the warp
    pub warp: [f64; 3],
    /// [m^2] area at rest
    pub area: f64,
}

impl MembranePicture {
    /// [-] The larger principal strain as elongation over rest length.
    pub fn elongation(&self) -> f64 {
        (1.0 + 2.0 * self.strain[0]).max(0.0).sqrt() - 1.0
    }
}

impl Default for MembranePicture {
    fn default() -> Self {
        MembranePicture { stress: [0.0; 2], strain: [0.0; 2], wrinkling: -1.0, warp: [0.0; 3], area: 0.0 }
    }
}

/// Observable quantities of a system. All slices are in the user's numbering.
pub trait Observables: System {
    /// [m] node positions at t = 0 on the mesh as given (displacements count from here); bob position for a pendulum.
    fn reference(&self) -> &[[f64; 3]];

    /// Triangles to show.
    fn triangles(&self) -> &[[u32; 3]];

    /// Edges to show; edge `i` is spring `i` if it carries one.
    fn edges(&self) -> &[[u32; 2]];

    /// Named parts to show.
    fn groups(&self) -> &Groups {
        static NONE: Groups = Groups::new();
        &NONE
    }

    /// What its groups name.
    fn parts(&self) -> NamedParts<'_> {
        NamedParts { groups: self.groups(), edges: self.edges(), triangles: self.triangles() }
    }

    /// A node with the groups it belongs to: "node 136 (skirt)".
    fn node_in_words(&self, node: u32) -> String {
        with_groups("node", node, &self.parts().of_node(node))
    }

    /// A spring with the groups it belongs to: "spring 812 (lines)".
    fn spring_in_words(&self, spring: u32) -> String {
        with_groups("spring", spring, &self.parts().of_edge(spring))
    }

    /// Its springs; `None` if it has none.
    fn springs(&self) -> Option<&dyn Springs> {
        None
    }

    /// The air around it; `None` if there is none.
    fn air(&self) -> Option<&dyn Air> {
        None
    }

    /// What the membranes show on every triangle `[n_triangles]`.
    fn triangle_membranes(&self, at: StateRef<'_>, out: &mut [MembranePicture]) {
        let _ = at;
        out.fill(MembranePicture::default());
    }

    /// Node positions [m] and velocities [m/s] of a state.
    fn trace(&self, at: StateRef<'_>, positions: &mut [[f64; 3]], velocities: &mut [[f64; 3]]);

    /// Net force [N] on every node (elastic, gravity, air, loads, damping), zero at fixed degrees of freedom.
    fn node_forces(&self, at: StateRef<'_>, forces: &Forces, out: &mut [[f64; 3]]);

    /// Support reaction [N] on every node, zero at free degrees of freedom.
    fn node_reactions(&self, forces: &Forces, out: &mut [[f64; 3]]);

    /// Tension [N] (elastic part) and strain [-] of every edge, both `[n_edges]`; NaN on an edge without spring.
    fn edge_tension(&self, at: StateRef<'_>, tension: &mut [f64], strain: &mut [f64]);

    /// [N] The sums of the tensions of springs at every node, by size `[n_nodes]`. Allocates.
    fn tension_sums(&self, at: StateRef<'_>) -> Vec<f64> {
        let (mut tension, mut strain) = (vec![0.0; self.edges().len()], vec![0.0; self.edges().len()]);
        self.edge_tension(at, &mut tension, &mut strain);
        let mut sums = vec![0.0; self.reference().len()];
        for (edge, tension) in self.edges().iter().zip(&tension).filter(|(_, tension)| !tension.is_nan()) {
            edge.iter().for_each(|&node| sums[node as usize] += tension.abs());
        }
        sums
    }

    /// [-] largest strain (l - l0)/l0 over all springs, 0 without springs; what `history.csv` shows.
    fn max_strain(&self, at: StateRef<'_>) -> f64;

    /// [m/s] largest node speed.
    fn max_speed(&self, at: StateRef<'_>) -> f64;

    /// A quantity of one node (user's number). `at` is an accepted point.
    fn node_value(&self, quantity: NodeQuantity, at: &Point, node: u32) -> [f64; 3] {
        let n = self.reference().len();
        let (mut a, mut b) = (vec![[0.0; 3]; n], vec![[0.0; 3]; n]);
        let state = at.state.as_ref();
        match quantity {
            NodeQuantity::Force => self.node_forces(state, &at.forces, &mut a),
            NodeQuantity::Reaction => self.node_reactions(&at.forces, &mut a),
            NodeQuantity::Velocity => self.trace(state, &mut b, &mut a),
            NodeQuantity::Position | NodeQuantity::Displacement => self.trace(state, &mut a, &mut b),
            NodeQuantity::Acceleration => {}
        }
        let node = node as usize;
        match quantity {
            NodeQuantity::Displacement => std::array::from_fn(|i| a[node][i] - self.reference()[node][i]),
            _ => a[node],
        }
    }
}
