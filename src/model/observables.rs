//! The observable quantities of a system: nodes in space, in the user's numbering. Output uses this interface.

use super::state::StateRef;
use super::system::System;
use crate::model::forces::Forces;

/// Observable quantities of a system. All slices are in the user's numbering.
pub trait Observables: System {
    /// [m] node positions at t = 0 on the mesh as given (displacements count from here); bob position for a pendulum.
    fn reference(&self) -> &[[f64; 3]];

    /// Triangles to show.
    fn triangles(&self) -> &[[u32; 3]];

    /// Edges to show; edge `i` is spring `i` if it carries one.
    fn edges(&self) -> &[[u32; 2]];

    /// Node positions [m] and velocities [m/s] of a state.
    fn trace(&self, at: StateRef<'_>, positions: &mut [[f64; 3]], velocities: &mut [[f64; 3]]);

    /// Net force [N] on every node (elastic, gravity, air, loads, damping), zero at fixed degrees of freedom.
    fn node_forces(&self, at: StateRef<'_>, forces: &Forces, out: &mut [[f64; 3]]);

    /// Support reaction [N] on every node, zero at free degrees of freedom.
    fn node_reactions(&self, forces: &Forces, out: &mut [[f64; 3]]);

    /// Tension [N] (elastic part) and strain [-] of every edge, both `[n_edges]`; NaN on an edge without spring.
    fn edge_tension(&self, at: StateRef<'_>, tension: &mut [f64], strain: &mut [f64]);

    /// Adds to the elastic tension [N] of every edge `[n_edges]` the force of the dashpot along it, if it has one.
    /// Forces between its ends that also have other directions are not included.
    fn add_axial_damping(&self, at: StateRef<'_>, tension: &mut [f64]) {
        let _ = (at, tension);
    }

    /// [-] largest strain (l - l0)/l0 over all springs, 0 without springs; what `history.csv` shows.
    fn max_strain(&self, at: StateRef<'_>) -> f64;

    /// [m/s] largest node speed.
    fn max_speed(&self, at: StateRef<'_>) -> f64;
}
