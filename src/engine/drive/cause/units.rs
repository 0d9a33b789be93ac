//! Impossible numbers, which come from a wrong unit.

use super::DiagnosisInput;
use crate::format_number::figures;
use crate::model::state::State;

/// [m/s] speed of light
const LIGHT: f64 = 299_792_458.0;
/// Number of steps that no user intends.
const ENDLESS: f64 = 1e12;

impl DiagnosisInput<'_> {
    /// Impossible numbers of a scene: what they are, and what to check.
    pub(super) fn units(&self, start: &State, steps: f64) -> Option<(String, &'static str)> {
        let mut f = vec![0.0; self.scene.n_dof()];
        self.scene.load(start.as_ref(), &mut f);
        let speeds = f.iter().zip(self.scene.inverse_mass()).map(|(f, m)| (f * m * self.h).abs());
        let (dof, speed) = speeds.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let already = self.scene.max_speed(start.as_ref());
        if !speed.is_finite() {
            let why = format!(
                "the loads at the start would bring node {} to more speed in one step than a number can hold",
                self.scene.name_of(dof).0
            );
            return Some((why, "loads, wind, masses and the step"));
        }
        if speed > LIGHT {
            let why = format!(
                "the loads at the start bring node {} to {} m/s in one step, {} times the speed of light",
                self.scene.name_of(dof).0,
                figures(speed, 3),
                figures(speed / LIGHT, 3)
            );
            return Some((why, "loads, wind, masses and the step"));
        }
        if already > LIGHT && already.is_finite() {
            let why = format!(
                "nodes start with up to {} m/s, {} times the speed of light",
                figures(already, 3),
                figures(already / LIGHT, 3)
            );
            return Some((why, "the initial velocities"));
        }
        (steps > ENDLESS && steps.is_finite()).then(|| {
            let why = format!("a run of {} s would take {} such steps", figures(self.end, 4), figures(steps, 2));
            (why, "stiffness, damping and masses")
        })
    }
}
