//! Damping that brakes the rotation of an unsupported body.
//!
//! A relative dashpot acts on all of v_b - v_a, and Rayleigh's K0 keeps the directions of the given mesh. Both do work
//! in a rigid rotation and remove angular momentum without an external moment. Two masses m rotating on a spring with a
//! relative dashpot c lose L = L0 exp(-2 c t/m).

use std::fmt;

use super::parts::Parts;
use crate::format_number::first_few;
use crate::model::spec::{DashpotKind, NetworkSpec, RayleighSpec};
use crate::warning::{Warning, WarningCode};

/// What brakes the rotation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RotationDamping {
    /// relative dashpots
    pub relative: bool,
    /// stiffness-proportional Rayleigh damping
    pub rayleigh_stiffness: bool,
    /// mass-proportional Rayleigh damping, which brakes translation too
    pub rayleigh_mass: bool,
}

/// A free body with such damping.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DampedRotation {
    /// nodes at the springs concerned, ascending
    pub nodes: Vec<u32>,
    /// what brakes them
    pub brakes: RotationDamping,
}

/// Finds unsupported parts whose rotation is braked.
pub fn braked(spec: &NetworkSpec, parts: &Parts) -> Option<DampedRotation> {
    let rayleigh = spec.rayleigh.unwrap_or(RayleighSpec { mass: 0.0, stiffness: 0.0 });
    let mut brakes = RotationDamping { relative: false, rayleigh_stiffness: false, rayleigh_mass: false };
    let mut nodes = Vec::new();
    for group in &spec.springs {
        let relative = group.dashpot.as_ref().filter(|dashpot| dashpot.kind == DashpotKind::Relative);
        for (i, edge) in group.edges.iter().enumerate() {
            let Some(ends) = spec.mesh.edges.get(*edge as usize).filter(|[a, _]| parts.is_free(*a)) else { continue };
            let dashpot = relative.and_then(|dashpot| dashpot.coefficient.get(i)).is_some_and(|c| c > 0.0);
            brakes.relative |= dashpot;
            brakes.rayleigh_stiffness |= rayleigh.stiffness > 0.0;
            brakes.rayleigh_mass |= rayleigh.mass > 0.0;
            if dashpot || rayleigh.stiffness > 0.0 || rayleigh.mass > 0.0 {
                nodes.extend(ends);
            }
        }
    }
    nodes.sort_unstable();
    nodes.dedup();
    (!nodes.is_empty()).then_some(DampedRotation { nodes, brakes })
}

impl fmt::Display for DampedRotation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let RotationDamping { relative, rayleigh_stiffness, rayleigh_mass } = self.brakes;
        let causes = [
            (relative, "relative dashpots brake the rotation"),
            (rayleigh_stiffness, "Rayleigh damping with the stiffness brakes the rotation"),
            (rayleigh_mass, "Rayleigh damping with the mass brakes rotation and translation"),
        ];
        let causes: Vec<&str> = causes.into_iter().filter(|(there, _)| *there).map(|(_, words)| words).collect();
        let cure = if relative { "\"axial\" dashpots do not" } else { "\"axial\" dashpots in its place do not" };
        write!(f, "no support holds nodes {}, and {}; {cure}", first_few(&self.nodes), causes.join(", "))
    }
}

impl From<DampedRotation> for Warning {
    fn from(found: DampedRotation) -> Self {
        Warning::new(WarningCode::BrakedRotation, found.to_string())
    }
}
