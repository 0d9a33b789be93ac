//! What a program sets in a network.

use super::network::Network;
use super::{Controls, ExternalForces, ExternalKind, ScaledLoad};
use crate::model::state::State;

impl Controls for Network {
    fn loads(&self) -> &[ScaledLoad] {
        &self.acting.loads
    }

    fn fill_gases(&self, share: f64) -> bool {
        self.acting.gases.iter().for_each(|(_, gas)| gas.law.filled.set(share));
        !self.acting.gases.is_empty()
    }

    fn external(&self) -> Option<&ExternalForces> {
        self.external.as_ref()
    }

    fn enable_external(&mut self, kind: ExternalKind) {
        self.enable(kind);
    }

    fn set_rest_length_factors(&mut self, factors: &[f64]) {
        self.scale_rest_lengths(factors);
    }

    fn state_of(&self, t: f64, positions: &[[f64; 3]], velocities: &[[f64; 3]]) -> Option<State> {
        let n = self.built.numbering.user.len();
        if [positions.len(), velocities.len()] != [n; 2] {
            return None;
        }
        let own = |values: &[[f64; 3]]| -> Vec<f64> {
            self.built.numbering.user.iter().flat_map(|&user| values[user as usize]).collect()
        };
        let (x, mut v) = (own(positions), own(velocities));
        let held = v.iter_mut().zip(self.phase().fixed.as_flattened()).filter(|(_, held)| **held);
        held.for_each(|(v, _)| *v = 0.0);
        let mut state = State { t, x, v };
        self.put_moved(&mut state, 1.0);
        Some(state)
    }
}
