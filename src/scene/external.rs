//! Forces that a program adds to a network from outside: fixed values by name, or a [`NodalForce`] of its own.

use super::network::{Network, by_node};
use crate::model::forces::{Role, Tally};
use crate::model::state::StateRef;
use crate::model::system::TermInfo;
use nalgebra::Vector3;
use std::sync::{Arc, Mutex, PoisonError, RwLock};

/// A force on the nodes that a program computes itself. Slices have shape `[n_nodes][3]` in the user's numbering.
///
/// The force counts as external in the energy account. It has no tangent: implicit methods see it in the residual only,
/// so a stiff force needs small steps or an explicit method.
pub trait NodalForce: Send + Sync {
    /// Adds the force to `f` [N] at time `t` [s], positions `x` [m] and velocities `v` [m/s]. Must return the same
    /// values for the same arguments: a step may be attempted more than once.
    fn add(&self, t: f64, x: &[[f64; 3]], v: &[[f64; 3]], f: &mut [[f64; 3]]);
}

/// Where one force comes from.
#[derive(Clone)]
enum ForceSource {
    /// [N] `[n_nodes][3]`, user's numbering
    Values(Arc<[[f64; 3]]>),
    /// the program
    Law(Arc<dyn NodalForce>),
}

/// All forces from outside, by name in the order in which they came.
#[derive(Default)]
pub struct ExternalForces {
    sources: RwLock<Vec<(String, ForceSource)>>,
    buffers: Mutex<Buffers>,
}

/// Nodes of a pass in the user's numbering, `[n_nodes][3]`.
#[derive(Default)]
struct Buffers {
    /// [m] positions and [m/s] velocities, for laws
    x: Vec<[f64; 3]>,
    v: Vec<[f64; 3]>,
    /// [N] sum of all forces
    sum: Vec<[f64; 3]>,
}

/// What the account and failure reports call them.
pub(super) const EXTERNAL: TermInfo = TermInfo::of("external forces", Role::External);

impl ExternalForces {
    /// Sets the force [N] `[n_nodes][3]` of this name, user's numbering.
    pub(crate) fn set_values(&self, name: &str, force: &[[f64; 3]]) {
        self.set(name, ForceSource::Values(force.into()));
    }

    /// Sets the law of this name.
    pub(crate) fn set_law(&self, name: &str, law: Arc<dyn NodalForce>) {
        self.set(name, ForceSource::Law(law));
    }

    /// Removes a force; `false` if there is none of this name.
    pub(crate) fn remove(&self, name: &str) -> bool {
        let mut all = self.sources.write().unwrap_or_else(PoisonError::into_inner);
        let before = all.len();
        all.retain(|(other, _)| other != name);
        all.len() < before
    }

    /// Names and values of the forces that are fixed values.
    pub(crate) fn values(&self) -> Vec<(String, Vec<[f64; 3]>)> {
        let all = self.sources.read().unwrap_or_else(PoisonError::into_inner);
        let fixed = all.iter().filter_map(|(name, source)| match source {
            ForceSource::Values(force) => Some((name.clone(), force.to_vec())),
            ForceSource::Law(_) => None,
        });
        fixed.collect()
    }

    /// Removes all forces that are fixed values.
    pub(crate) fn clear_values(&self) {
        let mut all = self.sources.write().unwrap_or_else(PoisonError::into_inner);
        all.retain(|(_, source)| matches!(source, ForceSource::Law(_)));
    }

    fn set(&self, name: &str, source: ForceSource) {
        let mut all = self.sources.write().unwrap_or_else(PoisonError::into_inner);
        match all.iter_mut().find(|(other, _)| other == name) {
            Some((_, old)) => *old = source,
            None => all.push((name.to_owned(), source)),
        }
    }
}

impl Network {
    /// Adds the forces from outside to the sums of a pass: all forces, and the external ones [N] `[n_nodes]`. Returns
    /// their power.
    pub(super) fn add_external(&self, at: StateRef<'_>, sums: [&mut [Vector3<f64>]; 2]) -> Tally {
        let Some(external) = &self.external else { return Tally::default() };
        let sources = external.sources.read().unwrap_or_else(PoisonError::into_inner);
        let mut buffers = external.buffers.lock().unwrap_or_else(PoisonError::into_inner);
        let Buffers { x, v, sum } = &mut *buffers;
        sum.clear();
        sum.resize(self.mass.len(), [0.0; 3]);
        if sources.iter().any(|(_, source)| matches!(source, ForceSource::Law(_))) {
            for (nodes, dofs) in [(&mut *x, at.x), (&mut *v, at.v)] {
                nodes.resize(self.mass.len(), [0.0; 3]);
                self.numbering.to_user(by_node(dofs), nodes);
            }
        }
        for (_, source) in sources.iter() {
            match source {
                ForceSource::Values(force) => {
                    sum.as_flattened_mut().iter_mut().zip(force.as_flattened()).for_each(|(sum, f)| *sum += f);
                }
                ForceSource::Law(law) => law.add(at.t, x, v, sum),
            }
        }
        let forces = || self.numbering.user.iter().map(|&user| Vector3::from(sum[user as usize]));
        for to in sums {
            to.iter_mut().zip(forces()).for_each(|(to, f)| *to += f);
        }
        let power = forces().zip(by_node(at.v)).map(|(f, v)| f.dot(v)).sum();
        Tally { power, ..Tally::default() }
    }
}
