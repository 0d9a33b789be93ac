//! Contact as the schemes and the run see it: the ability [`Touches`].

use super::{TouchState, Touching};
use crate::contact::near::{Candidate, Places, shifts};
use crate::contact::touch::Touch;
use crate::model::abilities::{ContactLoad, ContactSurvey, NearFrom, Passage, Touches};
use crate::model::state::StateRef;
use crate::scene::network::{by_node, node_state};
use nalgebra::Vector3;

/// [-] Share of what patches may come nearer, up to which a block of steps begins.
const BEGIN_BLOCK: f64 = 0.5;

impl Touches for Touching {
    fn set_explicit(&self, explicit: bool) {
        self.state().explicit = explicit;
    }

    fn set_step(&self, step: Option<f64>) {
        self.state().step = step;
    }

    fn begin_step(&self, from: StateRef<'_>) {
        let resumed = self.state().resumed.take();
        resumed.iter().for_each(|near| self.look_from(near));
        if !self.contacts.rubs() {
            return;
        }
        let at = node_state(from);
        let mut guard = self.at(at);
        let TouchState { near, shifts, explicit, pressed, .. } = &mut *guard;
        let places = Places { contacts: &self.contacts, t: at.t, x: at.x, shifts };
        let pressed = pressed.get_or_insert_default();
        pressed.clear();
        let touching = near.close().filter_map(|candidate| {
            let touch = Touch::of(candidate, places, *explicit)?;
            Some(touch.pressed(candidate))
        });
        pressed.extend(touching);
    }

    fn rubs(&self) -> bool {
        self.contacts.rubs()
    }

    fn presses(&self) -> bool {
        self.state().touched
    }

    fn is_rubbing(&self) -> bool {
        let state = self.state();
        self.contacts.rubs() && (state.touched || state.pressed.as_ref().is_some_and(|pressed| !pressed.is_empty()))
    }

    fn keep_apart(&self, x: &[f64], [begun, ended]: [f64; 2], way: &mut [f64]) -> f64 {
        let mut guard = self.state();
        let TouchState { near, shifts: then, shifts_later, apart, .. } = &mut *guard;
        shifts(&self.contacts, begun, then);
        shifts(&self.contacts, ended, shifts_later);
        let way: &mut [Vector3<f64>] = bytemuck::cast_slice_mut(way);
        let places = Places { contacts: &self.contacts, t: begun, x: by_node(x), shifts: then };
        apart.shorten(places, shifts_later, way, near)
    }

    fn begin_block(&self, from: StateRef<'_>) -> bool {
        let at = node_state(from);
        let mut guard = self.state();
        let TouchState { near, shifts: moved, in_block, explicit, .. } = &mut *guard;
        // Patterns of implicit steps follow from where pairs were looked for.
        if !*explicit {
            return false;
        }
        shifts(&self.contacts, at.t, moved);
        let places = Places { contacts: &self.contacts, t: at.t, x: at.x, shifts: moved };
        if !near.covers(&[places], BEGIN_BLOCK) {
            near.look(places, 0.0);
        }
        *in_block = near.list().is_empty();
        *in_block
    }

    fn leave_block(&self) {
        self.state().in_block = false;
    }

    fn covers(&self, to: StateRef<'_>) -> bool {
        let at = node_state(to);
        let mut guard = self.state();
        let TouchState { near, shifts: moved, .. } = &mut *guard;
        shifts(&self.contacts, at.t, moved);
        near.covers(&[Places { contacts: &self.contacts, t: at.t, x: at.x, shifts: moved }], 1.0)
    }

    fn passage(&self, from: StateRef<'_>, to: StateRef<'_>) -> Option<Passage> {
        let mut guard = self.state();
        let TouchState { near, shifts: then, shifts_later, apart, way, .. } = &mut *guard;
        shifts(&self.contacts, from.t, then);
        shifts(&self.contacts, to.t, shifts_later);
        way.clear();
        way.extend(by_node(to.x).iter().zip(by_node(from.x)).map(|(to, from)| to - from));
        let places = Places { contacts: &self.contacts, t: from.t, x: by_node(from.x), shifts: then };
        let pair = apart.first_touch(places, shifts_later, way, near)?;
        self.place_of(&pair)
    }

    fn survey(&self, at: StateRef<'_>) -> Vec<ContactSurvey> {
        self.survey_at(node_state(at))
    }

    fn most_rates(&self) -> Vec<f64> {
        (0..self.contacts.list.len()).map(|contact| self.contacts.most_rate(contact)).collect()
    }

    fn press(&self, at: StateRef<'_>, f: &mut [f64]) {
        let mut dissipative = vec![Vector3::zeros(); if self.contacts.rubs() { f.len() / 3 } else { 0 }];
        self.add(node_state(at), [bytemuck::cast_slice_mut(f), &mut dissipative], &mut []);
    }

    fn load_of(&self, contact: usize, at: StateRef<'_>) -> ContactLoad {
        self.load_at(contact, node_state(at))
    }

    fn pressed_most(&self, at: StateRef<'_>, dof: usize) -> Option<String> {
        self.pressed_most_at(node_state(at), dof / 3)
    }

    fn closed(&self, at: StateRef<'_>) -> Option<Passage> {
        let at = node_state(at);
        let guard = self.at(at);
        let TouchState { near, shifts, .. } = &*guard;
        let places = Places { contacts: &self.contacts, t: at.t, x: at.x, shifts };
        let closed = |pair: &&Candidate| Touch::of(pair, places, true).is_some_and(|touch| touch.gap <= 0.0);
        self.place_of(near.close().find(closed)?)
    }

    fn save(&self) -> Option<NearFrom> {
        let state = self.state();
        let (t, x, more) = state.near.reference();
        let x: Vec<f64> = bytemuck::cast_slice(x).to_vec();
        (!x.is_empty()).then_some(NearFrom { t, more, x })
    }

    fn restore(&self, near: &NearFrom) {
        if near.x.len() == 3 * self.contacts.rest.len() {
            self.look_from(near);
            self.state().resumed = Some(near.clone());
        }
    }
}
