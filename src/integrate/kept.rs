//! What is known of the factor that an implicit scheme keeps from step to step, as accepted and as attempted: a dropped
//! attempt must leave no bit, and a resumed run must have the factor of one that was never stopped. Both make it again
//! from the state it was made at.

use crate::model::state::{State, StateRef};
use crate::model::system::Weights;
use crate::solve::Expected;
use crate::solve::quasi::Frozen;

/// Ratio of two steps' mass weights beyond which a factor of one is of no use to the other.
const OTHER_STEP: f64 = 2.0;

/// Where a kept factor was made, but for the state.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct KeptFactor {
    /// what its use has shown
    frozen: Frozen,
    /// [s] time of the state it was made at
    t: f64,
    /// its weights of M, C and K
    weights: [f64; 3],
    /// whether it is of the convex tangent
    convex: bool,
    /// what was expected of it
    made_for: Expected,
}

/// How a kept factor is made.
#[derive(Clone, Copy, Debug)]
pub(super) struct Make {
    /// of the convex tangent
    pub convex: bool,
    /// what is expected of it
    pub expected: Expected,
}

/// Why the factor is not the accepted one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Place {
    /// it is
    #[default]
    Held,
    /// an attempt has made another
    Taken,
    /// the run was resumed
    Resumed,
}

/// The factor of the last accepted step and that of the present attempt.
#[derive(Debug, Default)]
pub(super) struct Kept {
    held: KeptFactor,
    at: State,
    tried: KeptFactor,
    tried_at: State,
    place: Place,
}

impl Kept {
    pub fn new(n_dof: usize) -> Self {
        let state = || State { t: 0.0, x: vec![0.0; n_dof], v: vec![0.0; n_dof] };
        Kept { at: state(), tried_at: state(), ..Kept::default() }
    }

    /// The factor that has to be made before an attempt, if any.
    pub fn missing(&mut self) -> Option<(StateRef<'_>, Weights, Make)> {
        self.tried = self.held;
        if self.place == Place::Held {
            return None;
        }
        if !self.held.frozen.made {
            self.place = Place::Held;
            return None;
        }
        let make = Make { convex: self.held.convex, expected: self.held.made_for };
        Some((self.at.as_ref(), weights(self.held), make))
    }

    /// It was made; whether that is work that a run without dropped attempts would not have had, and is counted.
    pub fn recalled(&mut self) -> bool {
        std::mem::take(&mut self.place) == Place::Taken
    }

    /// What is known of the factor, for a step with these weights.
    pub fn usable(&self, w: Weights) -> Frozen {
        let ratio = w.m / weights(self.held).m;
        let near = ratio < OTHER_STEP && ratio > 1.0 / OTHER_STEP;
        if near { self.held.frozen } else { self.held.frozen.of_another_step() }
    }

    /// A factor was made in this attempt.
    pub fn take(&mut self, at: StateRef<'_>, w: Weights, Make { convex, expected }: Make) {
        self.place = Place::Taken;
        self.tried_at.copy_from(at);
        self.tried =
            KeptFactor { frozen: Frozen::default(), t: at.t, weights: [w.m, w.c, w.k], convex, made_for: expected };
    }

    /// The factor is made again where it was made, of the convex tangent: the state and the weights to do so; nothing
    /// if it is of that already.
    pub fn turn_convex(&mut self) -> Option<(StateRef<'_>, Weights, Make)> {
        if self.tried.convex {
            return None;
        }
        if self.place != Place::Taken {
            self.tried_at.copy_from(self.at.as_ref());
            self.place = Place::Taken;
        }
        self.tried.convex = true;
        let make = Make { convex: true, expected: self.tried.made_for };
        Some((self.tried_at.as_ref(), weights(self.tried), make))
    }

    /// Another matrix is factorised; if in the same room, there is no kept one any more.
    pub fn is_lost(&mut self, same_room: bool) {
        if same_room {
            self.place = Place::Taken;
            self.tried = KeptFactor::default();
        }
    }

    /// [1/s^2, 1/s, 1] weights of the factor of this attempt.
    pub fn weights(&self) -> Weights {
        weights(self.tried)
    }

    /// What its use in this attempt has shown.
    pub fn learn(&mut self, frozen: Frozen) {
        self.tried.frozen = frozen;
    }

    /// The attempt was accepted.
    pub fn accept(&mut self) {
        if self.place == Place::Taken {
            std::mem::swap(&mut self.at, &mut self.tried_at);
        }
        (self.held, self.place) = (self.tried, Place::Held);
    }

    /// Adds the state of the factor to `vectors` and returns the rest; nothing if there is none and none was tried.
    pub fn save(&self, vectors: &mut Vec<Vec<f64>>) -> Option<KeptFactor> {
        if self.held.frozen == Frozen::default() {
            return None;
        }
        vectors.extend([self.at.x.clone(), self.at.v.clone()]);
        Some(self.held)
    }

    /// Room for the vectors of a saved factor.
    pub fn room(&mut self) -> [&mut Vec<f64>; 2] {
        [&mut self.at.x, &mut self.at.v]
    }

    /// Takes the rest of a saved factor.
    pub fn restore(&mut self, factor: KeptFactor) {
        self.at.t = factor.t;
        (self.held, self.place) = (factor, Place::Resumed);
    }
}

fn weights(factor: KeptFactor) -> Weights {
    let [m, c, k] = factor.weights;
    Weights { m, c, k }
}
