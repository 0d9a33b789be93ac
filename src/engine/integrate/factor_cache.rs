//! The factor that an implicit scheme reuses from step to step, as of the last accepted step and of the current
//! attempt. A dropped attempt must leave no trace, and a resumed run must have the factor of an uninterrupted one. Both
//! rebuild it from the state it was made at.

use crate::model::state::{State, StateRef};
use crate::model::system::Weights;
use crate::solve::ExpectedUse;
use crate::solve::quasi_newton::FactorHistory;

/// Ratio of mass weights beyond which the factor of one step size is of no use to another.
const OTHER_STEP: f64 = 2.0;

/// A reused factor without the state it was made at.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct CachedFactor {
    /// statistics of its use
    frozen: FactorHistory,
    /// [s] time of the state it was made at
    t: f64,
    /// its weights of M, C and K, in 1/s^2, 1/s and 1
    weights: [f64; 3],
    /// whether it is a factor of the convex tangent
    convex: bool,
    /// its expected use
    made_for: ExpectedUse,
}

/// How a reused factor is made.
#[derive(Clone, Copy, Debug)]
pub(super) struct FactorRequest {
    /// from the convex tangent
    pub convex: bool,
    /// its expected use
    pub expected: ExpectedUse,
}

/// Whether the factor in memory is that of the last accepted step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum CacheState {
    /// it is
    #[default]
    Valid,
    /// an attempt has overwritten it
    Replaced,
    /// the run was resumed, so it must be rebuilt
    Resumed,
}

/// The factor of the last accepted step and that of the current attempt.
#[derive(Debug, Default)]
pub(super) struct FactorCache {
    accepted: CachedFactor,
    accepted_at: State,
    attempted: CachedFactor,
    attempted_at: State,
    state: CacheState,
    /// whether the factor of the last accepted step is of laws that a program has changed since: it cannot be made
    /// again
    outlived: bool,
}

/// A factor to be made again.
pub(super) struct Refactor<'a> {
    pub at: StateRef<'a>,
    pub w: Weights,
    pub request: FactorRequest,
}

impl FactorCache {
    pub(super) fn new(n_dof: usize) -> Self {
        let state = || State { t: 0.0, x: vec![0.0; n_dof], v: vec![0.0; n_dof] };
        FactorCache { accepted_at: state(), attempted_at: state(), ..FactorCache::default() }
    }

    /// The factor that must be rebuilt before an attempt, if any.
    pub(super) fn outdated(&mut self) -> Option<Refactor<'_>> {
        if self.state != CacheState::Valid {
            self.drop_unsaved();
        }
        self.attempted = self.accepted;
        if self.state == CacheState::Valid {
            return None;
        }
        if !self.accepted.frozen.made {
            self.state = CacheState::Valid;
            return None;
        }
        let request = FactorRequest { convex: self.accepted.convex, expected: self.accepted.made_for };
        Some(Refactor { at: self.accepted_at.as_ref(), w: weights(self.accepted), request })
    }

    /// Marks the factor as rebuilt. Returns whether this work counts: a run without dropped attempts would not have had
    /// it.
    pub(super) fn rebuilt(&mut self) -> bool {
        std::mem::take(&mut self.state) == CacheState::Replaced
    }

    /// Statistics of the factor for a step with these weights.
    pub(super) fn history_for(&self, w: Weights) -> FactorHistory {
        let ratio = w.m / weights(self.accepted).m;
        let near = ratio < OTHER_STEP && ratio > 1.0 / OTHER_STEP;
        if near { self.accepted.frozen } else { self.accepted.frozen.after_step_change() }
    }

    /// Statistics of the factor of this attempt.
    pub(super) fn attempted_history(&self) -> FactorHistory {
        self.attempted.frozen
    }

    /// Records a new factor of this attempt.
    pub(super) fn store(&mut self, at: StateRef<'_>, w: Weights, FactorRequest { convex, expected }: FactorRequest) {
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

    /// The factor from the convex tangent, to be rebuilt; `None` if it is convex already.
    pub(super) fn turn_convex(&mut self) -> Option<Refactor<'_>> {
        if self.attempted.convex {
            return None;
        }
        if self.state != CacheState::Replaced {
            self.attempted_at.copy_from(self.accepted_at.as_ref());
            self.state = CacheState::Replaced;
        }
        self.attempted.convex = true;
        let request = FactorRequest { convex: true, expected: self.attempted.made_for };
        Some(Refactor { at: self.attempted_at.as_ref(), w: weights(self.attempted), request })
    }

    /// Records that another matrix was factorised; if in the same memory, the reused factor is gone.
    pub(super) fn discard(&mut self, same_room: bool) {
        if same_room {
            self.state = CacheState::Replaced;
            // What was learnt from it holds for steps of its size.
            self.attempted = CachedFactor { weights: self.attempted.weights, ..CachedFactor::default() };
        }
    }

    /// Forgets the factor.
    pub(super) fn forget(&mut self) {
        (self.accepted, self.state, self.outlived) = (CachedFactor::default(), CacheState::Valid, false);
    }

    /// The matrix has got another pattern: its factor is gone.
    pub(super) fn outgrow(&mut self) {
        self.accepted.frozen = self.accepted.frozen.without_factor();
        (self.state, self.outlived) = (CacheState::Valid, false);
    }

    /// A program has changed how forces depend on the state. The factor is as good as the iteration finds it, but it
    /// cannot be made again.
    pub(super) fn outlive_laws(&mut self) {
        self.outlived = self.accepted.frozen.made;
    }

    /// Forgets the factor if [`FactorCache::save`] leaves it out.
    pub(super) fn drop_unsaved(&mut self) {
        if self.outlived {
            (self.accepted, self.state, self.outlived) = (self.to_save(), CacheState::Valid, false);
        }
    }

    /// The factor of the last accepted step; without it, what was learnt from it, if it cannot be made again.
    fn to_save(&self) -> CachedFactor {
        let CachedFactor { frozen, .. } = self.accepted;
        CachedFactor { frozen: if self.outlived { frozen.without_factor() } else { frozen }, ..self.accepted }
    }

    /// Weights of the factor of this attempt.
    pub(super) fn weights(&self) -> Weights {
        weights(self.attempted)
    }

    /// Sets the statistics after this attempt.
    pub(super) fn set_history(&mut self, frozen: FactorHistory) {
        self.attempted.frozen = frozen;
    }

    /// The attempt was accepted.
    pub(super) fn accept(&mut self) {
        if self.state == CacheState::Replaced {
            std::mem::swap(&mut self.accepted_at, &mut self.attempted_at);
            self.outlived = false;
        }
        (self.accepted, self.state) = (self.attempted, CacheState::Valid);
    }

    /// Appends the state of the factor to `vectors` and returns the rest; `None` if there is nothing to be known of it.
    pub(super) fn save(&self, vectors: &mut Vec<Vec<f64>>) -> Option<CachedFactor> {
        let saved = self.to_save();
        if saved.frozen == FactorHistory::default() {
            return None;
        }
        vectors.extend([self.accepted_at.x.clone(), self.accepted_at.v.clone()]);
        Some(saved)
    }

    /// Positions and velocities of the factor's state, to be restored `[n_dof]`.
    pub(super) fn state_vectors(&mut self) -> [&mut Vec<f64>; 2] {
        [&mut self.accepted_at.x, &mut self.accepted_at.v]
    }

    /// Restores a saved factor except for its state.
    pub(super) fn restore(&mut self, factor: CachedFactor) {
        self.accepted_at.t = factor.t;
        (self.accepted, self.state, self.outlived) = (factor, CacheState::Resumed, false);
    }
}

fn weights(factor: CachedFactor) -> Weights {
    let [m, c, k] = factor.weights;
    Weights { m, c, k }
}
