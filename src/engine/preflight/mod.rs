//! Warnings about a specification, before anything is computed. One file a topic; every function returns plain data
//! that displays as text. All checks are O(n log n) in the number of nodes and elements.

pub mod air;
pub mod canopies;
pub mod coincident;
pub mod contact;
pub mod crossing;
pub mod damping;
pub mod edges;
pub mod events;
pub mod parts;
pub mod roofs;
pub mod units;

use crate::mesh::Topology;
use crate::model::spec::{NetworkSpec, PendulumSpec};
use crate::warning::Warning;
use parts::Parts;

/// All warnings about a network; `topology` is that of its mesh, `step` [s] the fixed step, if there is one.
pub fn network(spec: &NetworkSpec, topology: &Topology, step: Option<f64>) -> Vec<Warning> {
    let parts = Parts::new(spec);
    let mut warnings = Vec::new();
    warnings.extend(parts::unsupported(&parts).map(Warning::from));
    warnings.extend(parts::loose_lines(spec, &parts).map(Warning::from));
    warnings.extend(coincident::coincident(spec).map(Warning::from));
    warnings.extend(crossing::at_start(spec));
    warnings.extend(contact::at_start(spec).into_iter().map(Warning::from));
    warnings.extend(air::wind_in_plane(spec).map(Warning::from));
    warnings.extend(roofs::roofs(spec).map(Warning::from));
    warnings.extend(roofs::calm_zones(spec).map(Warning::from));
    warnings.extend(roofs::inside_out(spec).map(Warning::from));
    warnings.extend(air::closing(spec).map(Warning::from));
    warnings.extend(air::cavities(spec).map(Warning::from));
    warnings.extend(canopies::drag_coefficients(spec).into_iter().map(Warning::from));
    warnings.extend(canopies::reefing_lines(spec).into_iter().map(Warning::from));
    warnings.extend(canopies::height(spec).map(Warning::from));
    warnings.extend(events::at_start(spec).into_iter().map(Warning::from));
    warnings.extend(edges::branching(spec, topology).map(Warning::from));
    warnings.extend(damping::braked(spec, &parts).map(Warning::from));
    warnings.extend(units::network(spec, step).into_iter().map(Warning::from));
    warnings
}

/// All warnings about a pendulum; `step` [s] is the fixed step, if there is one.
pub fn pendulum(spec: &PendulumSpec, step: Option<f64>) -> Vec<Warning> {
    units::pendulum(spec, step).into_iter().map(Warning::from).collect()
}
