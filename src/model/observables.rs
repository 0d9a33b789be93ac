//! A system as a person sees it: nodes in space, in the user's numbering. Output is written against this.

use super::state::StateRef;
use super::system::System;
use crate::model::forces::Forces;

/// How a system looks. All slices are in the user's numbering and as long as the counts say.
pub trait Observables: System {
    /// [m] node positions at t = 0 on the mesh as given (displacements count from here); bob position for a pendulum.
    fn reference(&self) -> &[[f64; 3]];

    /// Triangles of the picture.
    fn triangles(&self) -> &[[u32; 3]];

    /// Edges of the picture; edge `i` is spring `i` where it carries one.
    fn edges(&self) -> &[[u32; 2]];

    /// Node positions [m] and velocities [m/s] of a state.
    fn trace(&self, at: StateRef<'_>, positions: &mut [[f64; 3]], velocities: &mut [[f64; 3]]);

    /// Net force [N] on every node (elastic, gravity, air, loads, damping), zero at fixed degrees of freedom.
    fn node_forces(&self, at: StateRef<'_>, forces: &Forces, out: &mut [[f64; 3]]);

    /// Support reaction [N] on every node, zero at free degrees of freedom.
    fn node_reactions(&self, forces: &Forces, out: &mut [[f64; 3]]);

    /// Tension [N] (elastic part) and strain [-] of every edge; NaN on an edge without spring.
    fn edge_tension(&self, at: StateRef<'_>, tension: &mut [f64], strain: &mut [f64]);

    /// Adds to the elastic tension [N] of every edge the force of the dashpot along it, if it has one. What acts
    /// between its ends in other directions too is no tension.
    fn add_axial_damping(&self, at: StateRef<'_>, tension: &mut [f64]) {
        let _ = (at, tension);
    }

    /// [-] largest strain (l - l0)/l0 over all springs, 0 without springs; what `history.csv` shows.
    fn max_strain(&self, at: StateRef<'_>) -> f64;

    /// [m/s] largest node speed.
    fn max_speed(&self, at: StateRef<'_>) -> f64;
}
