//! What is known of the factor that an implicit scheme keeps from step to step, as accepted and as attempted: a dropped
//! attempt must leave no bit, and a resumed run must have the factor of one that was never stopped. Both make it again
//! from the state it was made at.

use crate::model::state::{State, StateRef};
use crate::model::system::Weights;
use crate::solve::Expected;
use crate::solve::quasi_newton::FactorHistory;

/// Ratio of two steps' mass weights beyond which a factor of one is of no use to the other.
const OTHER_STEP: f64 = 2.0;

/// Where a kept factor was made, but for the state.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct CachedFactor {
    /// what its use has shown
    frozen: FactorHistory,
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
pub(super) struct FactorRequest {
    /// of the convex tangent
    pub convex: bool,
    /// what is expected of it
    pub expected: Expected,
}

/// Why the factor is not the accepted one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum CacheState {
    /// it is
    #[default]
    Valid,
    /// an attempt has made another
    Replaced,
    /// the run was resumed
    Resumed,
}

/// The factor of the last accepted step and that of the present attempt.
#[derive(Debug, Default)]
pub(super) struct FactorCache {
    accepted: CachedFactor,
    accepted_at: State,
    attempted: CachedFactor,
    attempted_at: State,
    state: CacheState,
}

impl FactorCache {
    pub fn new(n_dof: usize) -> Self {
        let state = || State { t: 0.0, x: vec![0.0; n_dof], v: vec![0.0; n_dof] };
        FactorCache { accepted_at: state(), attempted_at: state(), ..FactorCache::default() }
    }

    /// The factor that has to be made before an attempt, if any.
    pub fn to_rebuild(&mut self) -> Option<(StateRef<'_>, Weights, FactorRequest)> {
        self.attempted = self.accepted;
        if self.state == CacheState::Valid {
            return None;
        }
        if !self.accepted.frozen.made {
            self.state = CacheState::Valid;
            return None;
        }
        let make = FactorRequest { convex: self.accepted.convex, expected: self.accepted.made_for };
        Some((self.accepted_at.as_ref(), weights(self.accepted), make))
    }

    /// It was made; whether that is work that a run without dropped attempts would not have had, and is counted.
    pub fn rebuilt(&mut self) -> bool {
        std::mem::take(&mut self.state) == CacheState::Replaced
    }

    /// What is known of the factor, for a step with these weights.
    pub fn history_for(&self, w: Weights) -> FactorHistory {
        let ratio = w.m / weights(self.accepted).m;
        let near = ratio < OTHER_STEP && ratio > 1.0 / OTHER_STEP;
        if near { self.accepted.frozen } else { self.accepted.frozen.of_another_step() }
    }

    /// A factor was made in this attempt.
    pub fn store(&mut self, at: StateRef<'_>, w: Weights, FactorRequest { convex, expected }: FactorRequest) {
        self.state = CacheState::Replaced;
        self.attempted_at.copy_from(at);
        self.attempted = CachedFactor {
            frozen: FactorHistory::default(),
            t: at.t,
            weights: [w.m, w.c, w.k],
            convex,
            made_for: expected,
        };
    }

    /// The factor is made again where it was made, of the convex tangent: the state and the weights to do so; nothing
    /// if it is of that already.
    pub fn turn_convex(&mut self) -> Option<(StateRef<'_>, Weights, FactorRequest)> {
        if self.attempted.convex {
            return None;
        }
        if self.state != CacheState::Replaced {
            self.attempted_at.copy_from(self.accepted_at.as_ref());
            self.state = CacheState::Replaced;
        }
        self.attempted.convex = true;
        let make = FactorRequest { convex: true, expected: self.attempted.made_for };
        Some((self.attempted_at.as_ref(), weights(self.attempted), make))
    }

    /// Another matrix is factorised; if in the same room, there is no kept one any more.
    pub fn discard(&mut self, same_room: bool) {
        if same_room {
            self.state = CacheState::Replaced;
            self.attempted = CachedFactor::default();
        }
    }

    /// [1/s^2, 1/s, 1] weights of the factor of this attempt.
    pub fn weights(&self) -> Weights {
        weights(self.attempted)
    }

    /// What its use in this attempt has shown.
    pub fn set_history(&mut self, frozen: FactorHistory) {
        self.attempted.frozen = frozen;
    }

    /// The attempt was accepted.
    pub fn accept(&mut self) {
        if self.state == CacheState::Replaced {
            std::mem::swap(&mut self.accepted_at, &mut self.attempted_at);
        }
        (self.accepted, self.state) = (self.attempted, CacheState::Valid);
    }

    /// Adds the state of the factor to `vectors` and returns the rest; nothing if there is none and none was attempted.
    pub fn save(&self, vectors: &mut Vec<Vec<f64>>) -> Option<CachedFactor> {
        if self.accepted.frozen == FactorHistory::default() {
            return None;
        }
        vectors.extend([self.accepted_at.x.clone(), self.accepted_at.v.clone()]);
        Some(self.accepted)
    }

    /// Room for the vectors of a saved factor.
    pub fn state_vectors(&mut self) -> [&mut Vec<f64>; 2] {
        [&mut self.accepted_at.x, &mut self.accepted_at.v]
    }

    /// Takes the rest of a saved factor.
    pub fn restore(&mut self, factor: CachedFactor) {
        self.accepted_at.t = factor.t;
        (self.accepted, self.state) = (factor, CacheState::Resumed);
    }
}

fn weights(factor: CachedFactor) -> Weights {
    let [m, c, k] = factor.weights;
    Weights { m, c, k }
}
