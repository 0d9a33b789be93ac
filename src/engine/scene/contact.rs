//! Contact in a network: its forces beside the passes over the blocks, and its tangents.
//!
//! Pairs that touch are nodes anywhere in the scene, so their forces are added after a pass, pair by pair in one order.
//! Friction in an implicit step is that of the pressures and normals at its start, so that its tangent is symmetric; in
//! an explicit step, that of the present ones.

mod ability;
mod report;

use super::network::{Network, by_node, node_state};
use crate::contact::apart::Apart;
use crate::contact::bodies::{Contacts, sides};
use crate::contact::mean::{MeanTouch, Step};
use crate::contact::near::{Candidate, Form, NO_NODE, Near, Places, shifts};
use crate::contact::touch::{Blocks, Held, Pressed, Touch, add_up};
use crate::force::{MeanStep, NodeState, TangentForm, TangentSink};
use crate::model::abilities::{NearFrom, Passage};
use crate::model::forces::{Role, Tally};
use crate::model::state::StateRef;
use crate::model::system::{StepMean, TermInfo, Weights};
use nalgebra::Vector3;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The parts of the account.
pub(super) const CONTACT: TermInfo = TermInfo::of("contact", Role::Elastic);
const FRICTION: TermInfo =
    TermInfo { velocity_dependent: true, ..TermInfo::of("friction of contact", Role::Dissipative) };

/// What may touch in a run.
pub(super) struct Touching {
    pub contacts: Arc<Contacts>,
    /// user's number of every node
    user: Arc<[u32]>,
    state: Mutex<TouchState>,
}

#[derive(Clone, Default)]
struct TouchState {
    near: Near,
    shifts: Vec<[Vector3<f64>; 2]>,
    /// from where they are to be found before the first step of a resumed run, whatever was looked at since
    resumed: Option<NearFrom>,
    /// whether steps are explicit
    explicit: bool,
    /// [s] their size, if it is fixed
    step: Option<f64>,
    /// what pressed at the start of an implicit step
    pressed: Option<Vec<Pressed>>,
    /// what presses in a pass
    now: Vec<Pressed>,
    /// whether anything touches in the last pass
    touched: bool,
    /// [N] mu lambda of all pairs at every node
    limits: Vec<f64>,
    /// displacements and velocities of obstacles at another time
    shifts_later: Vec<[Vector3<f64>; 2]>,
    /// [m] displacements of nodes
    way: Vec<Vector3<f64>>,
    ends: StepEnds,
    apart: Apart,
    /// whether a block of steps is made in which nothing can touch
    in_block: bool,
}

impl Touching {
    pub(super) fn new(contacts: Contacts, user: &[u32]) -> Self {
        Touching { contacts: Arc::new(contacts), user: user.into(), state: Mutex::default() }
    }

    /// The same in another run.
    pub(super) fn for_run(&self) -> Self {
        let TouchState { explicit, step, .. } = *self.state();
        let state = TouchState { explicit, step, ..TouchState::default() };
        Touching { contacts: self.contacts.clone(), user: self.user.clone(), state: Mutex::new(state) }
    }

    fn state(&self) -> MutexGuard<'_, TouchState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The state with the pairs that are near at these positions.
    fn at(&self, at: NodeState<'_>) -> MutexGuard<'_, TouchState> {
        let mut guard = self.state();
        let TouchState { near, shifts: moved, .. } = &mut *guard;
        shifts(&self.contacts, at.t, moved);
        near.refresh(Places { contacts: &self.contacts, t: at.t, x: at.x, shifts: moved });
        guard
    }

    /// Whether a block of steps is made in which nothing can touch.
    pub(super) fn in_block(&self) -> bool {
        self.state().in_block
    }

    fn look_from(&self, NearFrom { t, more, x }: &NearFrom) {
        let mut guard = self.state();
        let TouchState { near, shifts: moved, .. } = &mut *guard;
        shifts(&self.contacts, *t, moved);
        near.look(Places { contacts: &self.contacts, t: *t, x: by_node(x), shifts: moved }, *more);
    }

    fn place_of(&self, pair: &Candidate) -> Option<Passage> {
        let node = pair.nodes.into_iter().find(|node| self.contacts.is_node(*node))?;
        let gap = self.contacts.list[usize::from(pair.contact)].gap;
        Some(Passage { dof: 3 * node as usize, pair: self.in_words(pair), gap })
    }

    /// A pair, by nodes in the user's numbering.
    fn in_words(&self, pair: &Candidate) -> String {
        let name = |node: u32| match self.user.get(node as usize) {
            Some(user) => format!("node {user}"),
            None => format!("obstacle {}", pair.contact),
        };
        let names = |nodes: &[u32]| match nodes {
            [first, ..] if !self.contacts.is_node(*first) => name(*first),
            [only] => name(*only),
            nodes => {
                let of: Vec<String> = nodes.iter().map(|node| self.user[*node as usize].to_string()).collect();
                format!("the {} of nodes {}", if nodes.len() == 2 { "edge" } else { "triangle" }, of.join(", "))
            }
        };
        match pair.form {
            Form::Plane => format!("{} and obstacle {}", name(pair.nodes[0]), pair.contact),
            Form::Pair(kind) => sides(kind, &pair.nodes).map(names).join(" and "),
        }
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
        list.iter().for_each(|candidate| emit(candidate, None, &self.contacts, sink));
    }

    /// Adds its forces [N] `[n_nodes]` to all forces and the dissipative ones, and overwrites its part of the account.
    pub(super) fn add(&self, at: NodeState<'_>, [total, dissipative]: [&mut [Vector3<f64>]; 2], tallies: &mut [Tally]) {
        let mut guard = self.at(at);
        let TouchState { near, shifts, explicit, step, pressed, now, limits, touched, .. } = &mut *guard;
        let places = Places { contacts: &self.contacts, t: at.t, x: at.x, shifts };
        let rubs = self.contacts.rubs() && pressed.is_none();
        let mut elastic = Tally::default();
        now.clear();
        for candidate in near.close() {
            let Some(touch) = Touch::of(candidate, places, *explicit) else { continue };
            elastic.energy += touch.energy();
            elastic.power += touch.pressure() * touch.normal.dot(&driven(candidate, touch.weights, places));
            for (node, slope) in own(candidate, touch.gradient(), &self.contacts) {
                total[node] -= slope;
            }
            now.extend(rubs.then(|| touch.pressed(candidate)));
        }
        *touched = elastic.energy > 0.0;
        let held = step.filter(|_| *explicit).map(|h| {
            add_up(now, &self.contacts, limits);
            Held { h, limits: &*limits }
        });
        let mut rub = Rubbing { at, places, held, sums: [total, dissipative], power: 0.0 };
        pressed.as_ref().unwrap_or(now).iter().for_each(|place| rub.add(place));
        let rubbed = Tally { power: rub.power, ..Tally::default() };
        tallies.iter_mut().zip([elastic, rubbed]).for_each(|(to, found)| *to = found);
    }

    /// The same of a step with the state in its middle: means of the elastic forces, friction as in the middle.
    fn add_mean(
        &self,
        MeanStep { at, mean }: MeanStep<'_>,
        [total, dissipative]: [&mut [Vector3<f64>]; 2],
        tallies: &mut [Tally],
    ) {
        let mut guard = self.along(at, mean.half);
        let TouchState { near, shifts, ends, pressed, touched, .. } = &mut *guard;
        let places = Places { contacts: &self.contacts, t: at.t, x: at.x, shifts };
        *touched = false;
        let step = ends.around(places);
        for candidate in near.close() {
            let Some(touch) = MeanTouch::of(candidate, &step) else { continue };
            *touched = true;
            for (node, slope) in own(candidate, touch.gradient(), &self.contacts) {
                total[node] -= slope;
            }
        }
        let mut rub = Rubbing { at, places, held: None, sums: [total, dissipative], power: 0.0 };
        pressed.iter().flatten().for_each(|place| rub.add(place));
        let rubbed = Tally { power: rub.power, ..Tally::default() };
        tallies.iter_mut().zip([Tally::default(), rubbed]).for_each(|(to, found)| *to = found);
    }

    /// The state with the pairs that are near anywhere on the ways `half * v` to both sides.
    fn along(&self, at: NodeState<'_>, half: f64) -> MutexGuard<'_, TouchState> {
        let mut guard = self.state();
        let TouchState { near, shifts: moved, ends, .. } = &mut *guard;
        shifts(&self.contacts, at.t, moved);
        ends.fit(&self.contacts, at, half);
        let [begin, middle, end] = ends.around(Places { contacts: &self.contacts, t: at.t, x: at.x, shifts: moved });
        near.refresh_along(middle, [begin, end]);
        guard
    }

    /// Emits `w.c (-df/dv) + w.k (-df/dx)` of these pairs, in their order; `half` [s] is half a step over which elastic
    /// forces are means.
    pub(super) fn emit(
        &self,
        (at, half, list): (NodeState<'_>, Option<f64>, &[Candidate]),
        w: Weights,
        form: TangentForm,
        sink: &mut dyn TangentSink,
    ) {
        if list.is_empty() {
            return;
        }
        // An old factor is made again at its own state, which must leave no trace: pairs are not looked for.
        let mut guard = self.state();
        let TouchState { near, shifts: moved, explicit, step, pressed, ends, .. } = &mut *guard;
        shifts(&self.contacts, at.t, moved);
        half.iter().for_each(|half| ends.fit(&self.contacts, at, *half));
        let places = Places { contacts: &self.contacts, t: at.t, x: at.x, shifts: moved };
        let around = half.map(|_| ends.around(places));
        let known = match around {
            Some([begin, _, end]) => near.covers(&[begin, end], 1.0),
            None => near.covers(&[places], 1.0),
        };
        let mut close = near.close().map(Candidate::key).peekable();
        for candidate in list {
            let key = candidate.key();
            while close.next_if(|other| *other < key).is_some() {}
            // What pressed at the start rubs to the end of the step, wherever it is by then.
            let rubs = pressed.as_ref().and_then(|pressed| pressed.binary_search_by_key(&key, Pressed::key).ok());
            if known && rubs.is_none() && close.peek() != Some(&key) {
                emit(candidate, None, &self.contacts, sink);
                continue;
            }
            let touch = Touch::of(candidate, places, *explicit);
            let blocks = match (&around, &touch) {
                _ if w.k == 0.0 => None,
                (Some(step), _) => {
                    MeanTouch::of(candidate, step).map(|touch| touch.tangent(form.convex || form.symmetric))
                }
                (None, touch) => touch.as_ref().map(|touch| touch.tangent(form.convex)),
            };
            let mut blocks = blocks.map_or(Blocks::default(), |blocks| blocks.map(|row| row.map(|block| block * w.k)));
            let place = match pressed {
                None => touch.map(|touch| touch.pressed(candidate)),
                Some(pressed) => rubs.map(|i| pressed[i]),
            };
            // That of an explicit step is as small as the step needs it.
            let place = place.filter(|_| !(*explicit && step.is_some()));
            let friction = place.and_then(|place| Some((place, place.friction(places, None)?)));
            if let Some((place, friction)) = friction.filter(|_| w.c != 0.0) {
                let block = friction.tangent(place.velocity(places, at.v)) * w.c;
                for (row, a) in blocks.iter_mut().zip(place.weights) {
                    row.iter_mut().zip(place.weights).for_each(|(sum, b)| *sum += block * (a * b));
                }
            }
            emit(candidate, Some(&blocks), &self.contacts, sink);
        }
    }
}

/// Adds friction to sums of forces.
struct Rubbing<'a> {
    at: NodeState<'a>,
    places: Places<'a>,
    /// what an explicit step can follow
    held: Option<Held<'a>>,
    /// [N] all forces, and the dissipative ones
    sums: [&'a mut [Vector3<f64>]; 2],
    /// [W]
    power: f64,
}

impl Rubbing<'_> {
    fn add(&mut self, place: &Pressed) {
        let Some(friction) = place.friction(self.places, self.held) else { return };
        let force = friction.force(place.velocity(self.places, self.at.v));
        for (node, w) in own(&place.candidate, place.weights, self.places.contacts) {
            self.sums.iter_mut().for_each(|sum| sum[node] += force * w);
            self.power += force.dot(&self.at.v[node]) * w;
        }
    }
}

/// Nodes and obstacles at both ends of a step.
#[derive(Clone, Default)]
struct StepEnds {
    /// [m]
    x: [Vec<Vector3<f64>>; 2],
    shifts: [Vec<[Vector3<f64>; 2]>; 2],
}

impl StepEnds {
    /// Of a step of twice `half` [s] with a state in its middle.
    fn fit(&mut self, contacts: &Contacts, at: NodeState<'_>, half: f64) {
        let StepEnds { x, shifts: moved } = self;
        for ((x, moved), half) in x.iter_mut().zip(moved).zip([-half, half]) {
            x.clear();
            x.extend(at.x.iter().zip(at.v).map(|(x, v)| x + v * half));
            shifts(contacts, at.t + half, moved);
        }
    }

    fn around<'a>(&'a self, middle: Places<'a>) -> Step<'a> {
        let end = |i: usize| Places { x: &self.x[i], shifts: &self.shifts[i], ..middle };
        [end(0), middle, end(1)]
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

/// Emits the blocks of the nodes of a pair that are in the scene; zeros without.
fn emit(candidate: &Candidate, blocks: Option<&Blocks>, contacts: &Contacts, sink: &mut dyn TangentSink) {
    let mut places = [0; 4];
    let mut count = 0;
    for (i, _) in candidate.nodes.iter().enumerate().filter(|(_, node)| contacts.is_node(**node)) {
        places[count] = i;
        count += 1;
    }
    let nodes = places.map(|i| candidate.nodes[i]);
    match blocks {
        None => sink.none(&nodes[..count]),
        Some(blocks) if places == [0, 1, 2, 3] => sink.few(&nodes, blocks),
        Some(blocks) => sink.few(&nodes[..count], &places.map(|i| places.map(|j| blocks[i][j]))),
    }
}

impl Network {
    /// Adds contact to the sums of a pass; as a mean over the step around the state, if one is given.
    pub(super) fn add_contact(
        &self,
        (at, mean): (StateRef<'_>, Option<StepMean>),
        sums: [&mut [Vector3<f64>]; 2],
        tallies: &mut [Tally],
    ) {
        let at = node_state(at);
        match (&self.contact, mean) {
            (None, _) => {}
            (Some(contact), None) => contact.add(at, sums, tallies),
            (Some(contact), Some(mean)) => contact.add_mean(MeanStep { at, mean }, sums, tallies),
        }
    }

    /// Emits the tangents of all pairs that are near.
    pub(super) fn emit_contact(&self, at: StateRef<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink) {
        if let Some(contact) = &self.contact {
            let list = contact.near(node_state(at));
            contact.emit((node_state(at), None, &list), w, form, sink);
        }
    }
}
