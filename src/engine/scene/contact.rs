//! Contact in a network: its forces beside the passes over the blocks, its tangents, and how far nodes may move.
//!
//! Pairs that touch are nodes anywhere in the scene, so their forces are added after a pass, pair by pair in one order.
//! Friction in an implicit step is that of the pressures and normals at its start, so that its tangent is symmetric; in
//! an explicit step, that of the present ones.

use super::network::{Network, by_node, node_state};
use crate::contact::apart::Apart;
use crate::contact::bodies::Contacts;
use crate::contact::near::{Candidate, Form, NO_NODE, Near, Places, shifts};
use crate::contact::touch::{Blocks, Pressed, Touch};
use crate::force::{NodeState, TangentForm, TangentSink};
use crate::model::abilities::Touches;
use crate::model::forces::{Role, Tally};
use crate::model::state::StateRef;
use crate::model::system::{TermInfo, Weights};
use nalgebra::{Matrix3, Vector3};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The parts of the account.
const CONTACT: TermInfo = TermInfo::of("contact", Role::Elastic);
const FRICTION: TermInfo =
    TermInfo { velocity_dependent: true, ..TermInfo::of("friction of contact", Role::Dissipative) };

/// What may touch in a run.
pub(super) struct Touching {
    pub contacts: Arc<Contacts>,
    state: Mutex<TouchState>,
}

#[derive(Clone, Default)]
struct TouchState {
    near: Near,
    shifts: Vec<[Vector3<f64>; 2]>,
    /// whether steps are explicit
    explicit: bool,
    /// [s] their size, if it is fixed
    step: Option<f64>,
    /// what pressed at the start of an implicit step
    pressed: Option<Vec<Pressed>>,
    /// displacements and velocities of obstacles at another time
    shifts_later: Vec<[Vector3<f64>; 2]>,
    apart: Apart,
}

impl Touching {
    pub(super) fn new(contacts: Contacts) -> Self {
        Touching { contacts: Arc::new(contacts), state: Mutex::default() }
    }

    /// The same in another run.
    pub(super) fn for_run(&self) -> Self {
        let TouchState { explicit, step, .. } = *self.state();
        let state = TouchState { explicit, step, ..TouchState::default() };
        Touching { contacts: self.contacts.clone(), state: Mutex::new(state) }
    }

    fn state(&self) -> MutexGuard<'_, TouchState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The state with the pairs that are near at these positions.
    fn at(&self, at: NodeState<'_>) -> MutexGuard<'_, TouchState> {
        let mut guard = self.state();
        let TouchState { near, shifts: moved, .. } = &mut *guard;
        shifts(&self.contacts, at.t, moved);
        near.refresh(Places { contacts: &self.contacts, x: at.x, shifts: moved });
        guard
    }

    /// Its parts of the account.
    pub(super) fn infos(&self) -> impl Iterator<Item = TermInfo> {
        [CONTACT].into_iter().chain(self.contacts.rubs().then_some(FRICTION))
    }

    /// The pairs that are near at a state.
    pub(super) fn near(&self, at: NodeState<'_>) -> Arc<[Candidate]> {
        self.at(at).near.list().clone()
    }

    /// The pairs that were near at the last state that was looked at.
    pub(super) fn last_near(&self) -> Arc<[Candidate]> {
        self.state().near.list().clone()
    }

    /// Emits these pairs without blocks.
    pub(super) fn record(&self, list: &[Candidate], sink: &mut dyn TangentSink) {
        list.iter().for_each(|candidate| emit(candidate, &Blocks::default(), &self.contacts, sink));
    }

    /// Adds its forces [N] `[n_nodes]` to all forces and the dissipative ones, and overwrites its part of the account.
    pub(super) fn add(&self, at: NodeState<'_>, [total, dissipative]: [&mut [Vector3<f64>]; 2], tallies: &mut [Tally]) {
        let guard = self.at(at);
        let TouchState { near, shifts, explicit, step, pressed, .. } = &*guard;
        let places = Places { contacts: &self.contacts, x: at.x, shifts };
        let (mut elastic, mut rubbed) = (Tally::default(), Tally::default());
        let mut rub = |place: &Pressed, total: &mut [Vector3<f64>]| {
            let Some(friction) = place.friction(places, step.filter(|_| *explicit)) else { return };
            let force = friction.force(place.velocity(places, at.v));
            for (node, w) in own(&place.candidate, place.weights, &self.contacts) {
                total[node] += force * w;
                dissipative[node] += force * w;
                rubbed.power += force.dot(&at.v[node]) * w;
            }
        };
        for candidate in near.list().iter() {
            let Some(touch) = Touch::of(candidate, places, *explicit) else { continue };
            elastic.energy += touch.energy();
            elastic.power += touch.pressure() * touch.normal.dot(&driven(candidate, touch.weights, places));
            for (node, slope) in own(candidate, touch.gradient(), &self.contacts) {
                total[node] -= slope;
            }
            if pressed.is_none() {
                rub(&touch.pressed(candidate), total);
            }
        }
        pressed.iter().flatten().for_each(|place| rub(place, total));
        tallies.iter_mut().zip([elastic, rubbed]).for_each(|(to, found)| *to = found);
    }

    /// Emits `w.c (-df/dv) + w.k (-df/dx)` of these pairs, in their order.
    pub(super) fn emit(
        &self,
        (at, list): (NodeState<'_>, &[Candidate]),
        w: Weights,
        form: TangentForm,
        sink: &mut dyn TangentSink,
    ) {
        if list.is_empty() {
            return;
        }
        let guard = self.at(at);
        let TouchState { shifts, explicit, step, pressed, .. } = &*guard;
        let places = Places { contacts: &self.contacts, x: at.x, shifts };
        for candidate in list {
            let touch = Touch::of(candidate, places, *explicit);
            let mut blocks = match &touch {
                Some(touch) if w.k != 0.0 => touch.tangent(form.convex).map(|row| row.map(|block| block * w.k)),
                _ => Blocks::default(),
            };
            let place = match pressed {
                None => touch.map(|touch| touch.pressed(candidate)),
                Some(pressed) => {
                    let found = pressed.binary_search_by_key(&candidate.key(), |place| place.candidate.key());
                    found.ok().map(|i| pressed[i])
                }
            };
            let friction = place.and_then(|place| Some((place, place.friction(places, step.filter(|_| *explicit))?)));
            if let Some((place, friction)) = friction.filter(|_| w.c != 0.0) {
                let block = friction.tangent(place.velocity(places, at.v)) * w.c;
                for (row, a) in blocks.iter_mut().zip(place.weights) {
                    row.iter_mut().zip(place.weights).for_each(|(sum, b)| *sum += block * (a * b));
                }
            }
            emit(candidate, &blocks, &self.contacts, sink);
        }
    }
}

/// The nodes of a pair that are in the scene, with a value of each.
fn own<T>(candidate: &Candidate, values: [T; 4], contacts: &Contacts) -> impl Iterator<Item = (usize, T)> {
    let count = contacts.rest.len();
    candidate.nodes.into_iter().zip(values).map(|(node, value)| (node as usize, value)).filter(move |(i, _)| *i < count)
}

/// [m/s] The velocity of an obstacle, with the sign that its pressure has on the scene; 0 between parts of the scene.
fn driven(candidate: &Candidate, weights: [f64; 4], places: Places<'_>) -> Vector3<f64> {
    let of_contact = places.shifts[usize::from(candidate.contact)][1];
    match candidate.form {
        Form::Plane => of_contact,
        Form::Pair(_) => {
            let corners = candidate.nodes.iter().zip(weights);
            let corners = corners.filter(|(node, _)| **node != NO_NODE && !places.contacts.is_node(**node));
            of_contact * -corners.map(|(_, w)| w).sum::<f64>()
        }
    }
}

/// Emits the blocks of the nodes of a pair that are in the scene.
fn emit(candidate: &Candidate, blocks: &Blocks, contacts: &Contacts, sink: &mut dyn TangentSink) {
    let mut places = [0; 4];
    let mut count = 0;
    for (i, _) in candidate.nodes.iter().enumerate().filter(|(_, node)| contacts.is_node(**node)) {
        places[count] = i;
        count += 1;
    }
    let block = |i: usize, j: usize| -> Matrix3<f64> { blocks[places[i]][places[j]] };
    let node = |i: usize| candidate.nodes[places[i]];
    match count {
        1 => sink.node(node(0), block(0, 0)),
        2 => sink.segment([0, 1].map(node), &[0, 1].map(|i| [0, 1].map(|j| block(i, j)))),
        3 => sink.triangle([0, 1, 2].map(node), &[0, 1, 2].map(|i| [0, 1, 2].map(|j| block(i, j)))),
        4 => sink.four(candidate.nodes, blocks),
        _ => {}
    }
}

impl Network {
    /// Adds contact to the sums of a pass.
    pub(super) fn add_contact(&self, at: StateRef<'_>, sums: [&mut [Vector3<f64>]; 2], tallies: &mut [Tally]) {
        if let Some(contact) = &self.contact {
            contact.add(node_state(at), sums, tallies);
        }
    }

    /// Emits the tangents of all pairs that are near.
    pub(super) fn emit_contact(&self, at: StateRef<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink) {
        if let Some(contact) = &self.contact {
            let list = contact.near(node_state(at));
            contact.emit((node_state(at), &list), w, form, sink);
        }
    }
}

impl Touches for Touching {
    fn set_explicit(&self, explicit: bool) {
        self.state().explicit = explicit;
    }

    fn set_step(&self, step: Option<f64>) {
        self.state().step = step;
    }

    fn begin_step(&self, from: StateRef<'_>) {
        if !self.contacts.rubs() {
            return;
        }
        let at = NodeState { t: from.t, x: by_node(from.x), v: by_node(from.v) };
        let mut guard = self.at(at);
        let TouchState { near, shifts, explicit, pressed, .. } = &mut *guard;
        let places = Places { contacts: &self.contacts, x: at.x, shifts };
        let pressed = pressed.get_or_insert_default();
        pressed.clear();
        let touching = near.list().iter().filter_map(|candidate| {
            let touch = Touch::of(candidate, places, *explicit)?;
            Some(touch.pressed(candidate))
        });
        pressed.extend(touching);
    }

    fn rubs(&self) -> bool {
        self.contacts.rubs()
    }

    fn keep_apart(&self, x: &[f64], [begun, ended]: [f64; 2], way: &mut [f64]) -> f64 {
        let mut guard = self.state();
        let TouchState { shifts: then, shifts_later, apart, .. } = &mut *guard;
        shifts(&self.contacts, begun, then);
        shifts(&self.contacts, ended, shifts_later);
        let way: &mut [Vector3<f64>] = bytemuck::cast_slice_mut(way);
        apart.shorten(Places { contacts: &self.contacts, x: by_node(x), shifts: then }, shifts_later, way)
    }
}
