//! Time, positions and velocities: the state at the start and the end of a step.
//!
//! Degrees of freedom are in the engine's own numbering, which keeps neighbours together (`scene/numbering`), not in
//! that of the mesh. [`Scene::name_of`](crate::scene::Scene::name_of) names the node and axis of one,
//! [`Observables::trace`](crate::model::observables::Observables::trace) gives positions and velocities node by node as
//! the mesh has them.

/// Time, positions and velocities of all degrees of freedom (fixed ones included), `x0 y0 z0 x1 …` in the engine's
/// numbering ([above](self)).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// [s] time
    pub t: f64,
    /// [m] (or [rad], pendulum) positions
    pub x: Vec<f64>,
    /// [m/s] (or [rad/s]) velocities
    pub v: Vec<f64>,
}

/// A borrowed [`State`]; schemes evaluate forces at states they never store.
#[derive(Clone, Copy, Debug)]
pub struct StateRef<'a> {
    /// [s] time
    pub t: f64,
    /// [m] positions
    pub x: &'a [f64],
    /// [m/s] velocities
    pub v: &'a [f64],
}

impl State {
    /// Borrows the state.
    pub fn as_ref(&self) -> StateRef<'_> {
        StateRef { t: self.t, x: &self.x, v: &self.v }
    }

    /// Copies another state of the same size without allocating.
    pub fn copy_from(&mut self, other: StateRef<'_>) {
        self.t = other.t;
        self.x.copy_from_slice(other.x);
        self.v.copy_from_slice(other.v);
    }
}
