//! Forces that a program adds to a network from outside: values by name, or a [`NodalForce`] of its own.
//!
//! Values are a term among the others: their sum over all names is added in the passes over the blocks, and blocks of
//! steps go on. A Verlet step of bare springs is 1.5 times as long with them, with relative dashpots 1.2 times.
//!
//! A law sees all nodes at one time. In a block of steps nodes are at different times, so a scene with a law makes its
//! steps one by one. Each is one pass over the nodes, or two in velocity Verlet if a force depends on velocity, and a
//! copy of all nodes to the user's numbering and back. A Verlet step with a law that does nothing takes so many times
//! one without it:
//!
//! | nodes | springs | law | times | |
//! |---|---|---|---|---|
//! | 703 | bare | of positions | 2.6 | 15 us |
//! | 703 | bare | of velocities | 5.0 | 29 us |
//! | 703 | with relative dashpots | either | 2.6 | 35 us |
//! | 10,000 | bare | of positions | 2.2 | 240 us |
//! | 10,000 | bare | of velocities | 4.1 | 450 us |
//! | 10,000 | with relative dashpots | either | 2.1 | 550 us |

use super::network::{Network, by_node};
use crate::force::law::nodal::SetForces;
use crate::force::{Copies, TangentForm, TangentSink};
use crate::model::forces::{Role, Tally};
use crate::model::state::StateRef;
use crate::model::system::{TermInfo, Weights};
use nalgebra::{Matrix3, Vector3};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock};

/// A force on the nodes that a program computes itself. Slices have shape `[n_nodes][3]` in the user's numbering.
///
/// It sees all nodes at one time, so steps are made one by one and not in blocks: a velocity Verlet step takes 2 to 5
/// times as long. The force counts as external in the energy account. Without
/// [derivatives](NodalForce::derivatives) implicit methods see it in the residual only, so a stiff force needs small
/// steps or an explicit method.
pub trait NodalForce: Send + Sync {
    /// Adds the force to `f` [N] at time `t` [s], positions `x` [m] and velocities `v` [m/s]. Must return the same
    /// values for the same arguments: a step may be attempted more than once.
    fn add(&self, t: f64, x: &[[f64; 3]], v: &[[f64; 3]], f: &mut [[f64; 3]]);

    /// Whether it depends on velocities. One that does not costs velocity Verlet one pass a step less. Asked once, when
    /// the force is set.
    fn velocity_dependent(&self) -> bool {
        true
    }

    /// Pairs of nodes `[i, j]`, each at most once: the force on `i` depends on position or velocity of `j`. `[i, i]` is
    /// such a pair. Asked once, when the force is set. None, as by default, if it has no derivatives.
    fn pairs(&self) -> Vec<[u32; 2]> {
        Vec::new()
    }

    /// Writes the derivatives of every pair into `out`, `[n_pairs]`, which holds zeros before. Newton's iteration then
    /// converges quadratically, with LU: the matrix counts as non-symmetric.
    /// [`derivative_error`](crate::simulation::derivative_error) compares them with differences of the force.
    fn derivatives(&self, t: f64, x: &[[f64; 3]], v: &[[f64; 3]], out: &mut [ForceDerivative]) {
        let _ = (t, x, v, out);
    }
}

/// How the force on one node changes with another node. Row: component of the force; column: that of the node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ForceDerivative {
    /// [N/m] by its position
    pub position: [[f64; 3]; 3],
    /// [N s/m] by its velocity
    pub velocity: [[f64; 3]; 3],
}

/// A force that the program computes.
#[derive(Clone)]
struct Law {
    name: String,
    force: Arc<dyn NodalForce>,
    /// user's numbering
    pairs: Vec<[u32; 2]>,
}

/// What a program adds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExternalKind {
    /// values
    Values,
    /// a [`NodalForce`]
    Law {
        /// whether it depends on velocities
        velocity_dependent: bool,
    },
}

/// What a law changes of the pairs of nodes that forces depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PairsChange {
    /// there are none
    None,
    /// there are the same
    Same,
    /// there are others
    Other,
}

/// All forces from outside, by name in the order in which they came.
#[derive(Default)]
pub struct ExternalForces {
    /// [N] `[n_nodes][3]`, user's numbering
    values: RwLock<Vec<(String, Vec<[f64; 3]>)>>,
    /// their sum, once there is a term of it
    sum: Option<SetForces>,
    laws: RwLock<Vec<Law>>,
    /// whether laws may depend on velocities, once the account has a place for them
    velocity_dependent: Option<bool>,
    /// user's number of every internal node
    user: Vec<u32>,
    buffers: Mutex<Buffers>,
}

/// Nodes of a pass in the user's numbering, `[n_nodes][3]`.
#[derive(Default)]
struct Buffers {
    /// [m] positions and [m/s] velocities
    x: Vec<[f64; 3]>,
    v: Vec<[f64; 3]>,
    /// [N] sum of all laws
    sum: Vec<[f64; 3]>,
    /// of one law, `[n_pairs]`
    derivatives: Vec<ForceDerivative>,
}

impl ExternalForces {
    /// Those of another run, at first the same.
    pub(super) fn for_run(&self, copies: &mut Copies) -> Self {
        ExternalForces {
            values: RwLock::new(self.values.read().unwrap_or_else(PoisonError::into_inner).clone()),
            sum: self.sum.as_ref().map(|sum| sum.for_run(copies)),
            laws: RwLock::new(self.laws.read().unwrap_or_else(PoisonError::into_inner).clone()),
            velocity_dependent: self.velocity_dependent,
            user: self.user.clone(),
            buffers: Mutex::default(),
        }
    }

    /// Whether forces of this kind have their place.
    pub fn takes(&self, kind: ExternalKind) -> bool {
        match kind {
            ExternalKind::Values => self.sum.is_some(),
            ExternalKind::Law { velocity_dependent } => {
                self.velocity_dependent.is_some_and(|already| already || !velocity_dependent)
            }
        }
    }

    /// Sets the force [N] `[n_nodes][3]` of this name, user's numbering. Returns whether that changes anything.
    pub fn set_values(&self, name: &str, force: &[[f64; 3]]) -> bool {
        let had_law = self.remove_law(name);
        let mut all = self.values.write().unwrap_or_else(PoisonError::into_inner);
        let changed = match all.iter_mut().find(|(other, _)| other == name) {
            Some((_, old)) if old == force => false,
            Some((_, old)) => {
                old.copy_from_slice(force);
                true
            }
            None => {
                all.push((name.to_owned(), force.to_vec()));
                force.as_flattened().iter().any(|f| *f != 0.0)
            }
        };
        if changed {
            self.add_up(&all);
        }
        changed || had_law
    }

    /// Sets the law of this name, with its pairs, in the place of one that had it. Returns what that changes of the
    /// pairs.
    pub fn set_law(&self, name: &str, force: Arc<dyn NodalForce>, pairs: Vec<[u32; 2]>) -> PairsChange {
        let mut all = self.values.write().unwrap_or_else(PoisonError::into_inner);
        all.retain(|(other, _)| other != name);
        self.add_up(&all);
        let mut laws = self.laws.write().unwrap_or_else(PoisonError::into_inner);
        let law = Law { name: name.to_owned(), force, pairs };
        let (same, none) = match laws.iter_mut().find(|other| other.name == name) {
            Some(old) => {
                let found = (old.pairs == law.pairs, old.pairs.is_empty() && law.pairs.is_empty());
                *old = law;
                found
            }
            None => {
                let none = law.pairs.is_empty();
                laws.push(law);
                (none, none)
            }
        };
        match (none, same) {
            (true, _) => PairsChange::None,
            (false, true) => PairsChange::Same,
            (false, false) => PairsChange::Other,
        }
    }

    /// Removes a force; `false` if there is none of this name.
    pub fn remove(&self, name: &str) -> bool {
        let mut all = self.values.write().unwrap_or_else(PoisonError::into_inner);
        let before = all.len();
        all.retain(|(other, _)| other != name);
        self.add_up(&all);
        all.len() < before || self.remove_law(name)
    }

    fn remove_law(&self, name: &str) -> bool {
        let mut laws = self.laws.write().unwrap_or_else(PoisonError::into_inner);
        let before = laws.len();
        laws.retain(|law| law.name != name);
        laws.len() < before
    }

    /// Whether some law has derivatives; of this name, if one is given.
    pub fn has_derivatives(&self, name: Option<&str>) -> bool {
        let laws = self.laws.read().unwrap_or_else(PoisonError::into_inner);
        laws.iter().any(|law| !law.pairs.is_empty() && name.is_none_or(|name| name == law.name))
    }

    /// Names and values of the forces that are values.
    pub fn values(&self) -> Vec<(String, Vec<[f64; 3]>)> {
        self.values.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Replaces all forces that are values. Laws of the same names are removed.
    pub fn replace_values(&self, values: Vec<(String, Vec<[f64; 3]>)>) {
        values.iter().for_each(|(name, _)| _ = self.remove_law(name));
        let mut all = self.values.write().unwrap_or_else(PoisonError::into_inner);
        *all = values;
        self.add_up(&all);
    }

    fn add_up(&self, all: &[(String, Vec<[f64; 3]>)]) {
        let Some(sum) = &self.sum else { return };
        let of = |&user: &u32| all.iter().map(|(_, force)| Vector3::from(force[user as usize])).sum();
        sum.set(self.user.iter().map(of));
    }

    /// The nodes of a state in the user's numbering.
    fn in_user_numbering(&self, network: &Network, at: StateRef<'_>) -> MutexGuard<'_, Buffers> {
        let mut buffers = self.buffers.lock().unwrap_or_else(PoisonError::into_inner);
        let Buffers { x, v, .. } = &mut *buffers;
        for (nodes, dofs) in [(x, at.x), (v, at.v)] {
            nodes.resize(self.user.len(), [0.0; 3]);
            network.built.numbering.to_user(by_node(dofs), nodes);
        }
        buffers
    }
}

impl Network {
    /// Makes a place for forces from outside of a kind.
    pub(super) fn enable(&mut self, kind: ExternalKind) {
        let user = self.built.numbering.user.clone();
        let external = self.external.get_or_insert_with(|| ExternalForces { user, ..ExternalForces::default() });
        match kind {
            ExternalKind::Values if external.sum.is_none() => {
                let forces = SetForces::zero(self.built.mass.len());
                external.sum = Some(forces.clone());
                self.acting.terms.push(Box::new(forces));
            }
            ExternalKind::Values => {}
            ExternalKind::Law { velocity_dependent } => {
                external.velocity_dependent = Some(velocity_dependent || external.velocity_dependent == Some(true));
            }
        }
        self.arrange();
    }

    /// What the account and failure reports call the program's laws, if they have a place.
    pub(super) fn law_info(&self) -> Option<TermInfo> {
        let velocity_dependent = self.external.as_ref()?.velocity_dependent?;
        Some(TermInfo { velocity_dependent, ..TermInfo::of("external forces", Role::External) })
    }

    /// Adds the program's laws to the sums of a pass: all forces, and the external ones [N] `[n_nodes]`. Returns their
    /// power.
    pub(super) fn add_laws(&self, at: StateRef<'_>, sums: [&mut [Vector3<f64>]; 2]) -> Tally {
        let Some(external) = self.external.as_ref().filter(|external| external.velocity_dependent.is_some()) else {
            return Tally::default();
        };
        let laws = external.laws.read().unwrap_or_else(PoisonError::into_inner);
        let mut buffers = external.in_user_numbering(self, at);
        let Buffers { x, v, sum, .. } = &mut *buffers;
        sum.clear();
        sum.resize(x.len(), [0.0; 3]);
        laws.iter().for_each(|law| law.force.add(at.t, x, v, sum));
        let forces = || external.user.iter().map(|&user| Vector3::from(sum[user as usize]));
        for to in sums {
            to.iter_mut().zip(forces()).for_each(|(to, f)| *to += f);
        }
        let power = forces().zip(by_node(at.v)).map(|(f, v)| f.dot(v)).sum();
        Tally { power, ..Tally::default() }
    }

    /// Emits -w.c df/dv - w.k df/dx of the program's laws, pair by pair. Their symmetric form has the blocks on the
    /// diagonal alone, and of these the part that is positive definite.
    pub(super) fn emit_law_tangents(
        &self,
        at: StateRef<'_>,
        w: Weights,
        form: TangentForm,
        sink: &mut dyn TangentSink,
    ) {
        let Some(external) = self.external.as_ref().filter(|external| external.has_derivatives(None)) else { return };
        let laws = external.laws.read().unwrap_or_else(PoisonError::into_inner);
        let mut buffers = external.in_user_numbering(self, at);
        let Buffers { x, v, derivatives, .. } = &mut *buffers;
        for law in laws.iter() {
            derivatives.clear();
            derivatives.resize(law.pairs.len(), ForceDerivative::default());
            law.force.derivatives(at.t, x, v, derivatives);
            for (pair, d) in law.pairs.iter().zip(derivatives.iter()) {
                let [position, velocity] = [d.position, d.velocity].map(|rows| Matrix3::from(rows).transpose());
                let exact = position * -w.k - velocity * w.c;
                let block = match pair {
                    _ if !form.symmetric => exact,
                    [i, j] if i == j => positive_part(&exact),
                    _ => Matrix3::zeros(),
                };
                sink.pair(pair.map(|node| self.built.numbering.internal[node as usize]), block);
            }
        }
    }
}

/// The symmetric part without its negative eigenvalues; zero where it is not finite.
fn positive_part(block: &Matrix3<f64>) -> Matrix3<f64> {
    let symmetric = (block + block.transpose()) * 0.5;
    if !symmetric.iter().all(|entry| entry.is_finite()) {
        return Matrix3::zeros();
    }
    let mut eigen = symmetric.symmetric_eigen();
    eigen.eigenvalues.apply(|value| *value = value.max(0.0));
    eigen.recompose()
}
