//! What contact tells of itself: what is near, and what its sides do to each other.

use super::{TouchState, Touching};
use crate::contact::near::{Candidate, Places, shifts};
use crate::contact::touch::{Held, Pressed, Touch, add_up};
use crate::force::NodeState;
use crate::model::abilities::{ContactLoad, ContactSurvey};
use nalgebra::Vector3;

impl Touching {
    /// See [`Touches::survey`](crate::model::abilities::Touches::survey).
    pub(super) fn survey_at(&self, at: NodeState<'_>) -> Vec<ContactSurvey> {
        let mut guard = self.state();
        let TouchState { near, shifts: moved, explicit, .. } = &mut *guard;
        shifts(&self.contacts, at.t, moved);
        let places = Places { contacts: &self.contacts, t: at.t, x: at.x, shifts: moved };
        near.look(places, 0.0);
        let of_contact = |number: usize| {
            let pairs = || near.list().iter().filter(move |pair| usize::from(pair.contact) == number);
            let touches = |pair: &&Candidate| Touch::of(pair, places, *explicit).is_some();
            let [first, second] = self.contacts.elements(number);
            ContactSurvey {
                first,
                second,
                near: pairs().count(),
                touching: pairs().filter(touches).count(),
                at_one_node: self.contacts.most_at_a_node(pairs()),
                rate: self.contacts.most_rate(number),
            }
        };
        (0..self.contacts.list.len()).map(of_contact).collect()
    }

    /// See [`Touches::pressed_most`](crate::model::abilities::Touches::pressed_most).
    pub(super) fn pressed_most_at(&self, at: NodeState<'_>, node: usize) -> Option<String> {
        let guard = self.at(at);
        let TouchState { near, shifts, explicit, .. } = &*guard;
        let places = Places { contacts: &self.contacts, t: at.t, x: at.x, shifts };
        let on_node = near.close().filter(|pair| pair.nodes.contains(&(node as u32)));
        let pressing = on_node.filter_map(|pair| Some((Touch::of(pair, places, *explicit)?.pressure(), pair)));
        let (_, pair) = pressing.max_by(|(one, _), (other, _)| one.total_cmp(other))?;
        Some(self.in_words(pair))
    }

    /// See [`Touches::load_of`](crate::model::abilities::Touches::load_of).
    pub(super) fn load_at(&self, contact: usize, at: NodeState<'_>) -> ContactLoad {
        if contact >= self.contacts.list.len() {
            return ContactLoad::NONE;
        }
        let mut guard = self.at(at);
        let TouchState { near, shifts, explicit, step, pressed, limits, .. } = &mut *guard;
        let places = Places { contacts: &self.contacts, t: at.t, x: at.x, shifts };
        let of_contact = |place: &&Pressed| usize::from(place.candidate.contact) == contact;
        let close = near.close().filter_map(|pair| Some(Touch::of(pair, places, *explicit)?.pressed(pair)));
        let now: Vec<Pressed> = close.collect();
        // [N] on the first elements of pairs
        let (mut force, mut pressure) = (Vector3::zeros(), 0.0);
        for place in now.iter().filter(of_contact) {
            force += place.normal * (place.pressure * self.contacts.direction(&place.candidate));
            pressure += place.pressure;
        }
        let held = step.filter(|_| *explicit).map(|h| {
            add_up(&now, &self.contacts, limits);
            Held { h, limits: &*limits }
        });
        let rubbing = pressed.as_ref().unwrap_or(&now);
        for place in rubbing.iter().filter(of_contact) {
            let Some(friction) = place.friction(places, held) else { continue };
            force += friction.force(place.velocity(places, at.v)) * self.contacts.direction(&place.candidate);
        }
        ContactLoad { force: (-force).into(), pressure }
    }
}
