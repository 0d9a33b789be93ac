//! A state together with the forces there.

use super::forces::Forces;
use super::state::State;

/// An accepted state with the forces there.
#[derive(Clone, Debug, Default)]
pub struct Point {
    /// time, positions, velocities
    pub state: State,
    /// forces at `state`; always valid when an observer sees the point. Those of schemes whose forces lag behind the
    /// state, such as `central-difference`, are forces at other velocities
    pub forces: Forces,
}

impl Point {
    /// Copies another point of the same scene without allocating.
    pub fn copy_from(&mut self, other: &Point) {
        self.state.copy_from(other.state.as_ref());
        self.forces.copy_from(&other.forces);
    }
}
