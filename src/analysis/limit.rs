//! The largest stable step of a method, from the real code of the method on a damped oscillator.

use super::oscillator::Oscillator;
use super::rates::Rates;
use crate::integrate::Counters;
use crate::integrate::implicit::SolverSpec;
use crate::integrate::registry::{Family, MethodChoice};
use crate::integrate::stepper::{Attempt, Stepper};
use crate::model::point::Point;
use crate::model::system::{Abilities, System};

/// Steps over which growth is looked for.
const STEPS: usize = 2000;
/// Growth over that many steps that still counts as none.
const GROWTH: f64 = 1.001;

/// [s] Largest step at which `method` is stable on the fastest oscillation of `rates`; infinite for a method without limit.
///
/// The frequency and the damping rate are taken to belong to one mode, as if the scene were a single oscillator: an estimate.
pub fn critical_step(method: &MethodChoice, rates: Rates) -> f64 {
    if method.info.family == Family::MatrixFree || (rates.frequency == 0.0 && rates.damping == 0.0) {
        return f64::INFINITY;
    }
    // In units of the faster rate, so that the search interval is the same for every scene.
    let unit = rates.frequency.max(rates.damping);
    let oscillator = Oscillator { k: (rates.frequency / unit).powi(2), c: rates.damping / unit };
    let (mut stable, mut unstable) = (0.0, 8.0);
    if is_stable(method, oscillator, 1e4) && is_stable(method, oscillator, 37.0) {
        return f64::INFINITY;
    }
    for _ in 0..40 {
        let middle = 0.5 * (stable + unstable);
        if is_stable(method, oscillator, middle) { stable = middle } else { unstable = middle }
    }
    stable / unit
}

fn is_stable(method: &MethodChoice, oscillator: Oscillator, h: f64) -> bool {
    let abilities = Abilities { system: &oscillator as &(dyn System + 'static), tangent: &oscillator, graph: None };
    amplitude_is_bounded(method, abilities, h).unwrap_or(false)
}

/// `None` when a step cannot be made at all.
fn amplitude_is_bounded(method: &MethodChoice, abilities: Abilities<'_>, h: f64) -> Option<bool> {
    let system = abilities.system;
    let mut stepper = Stepper::bind(method.scheme(SolverSpec::default()), abilities).ok()?;
    let mut from = Point { state: system.initial_state(), forces: system.new_forces() };
    let mut counters = Counters::default();
    counters.evaluate(system, from.state.as_ref(), &mut from.forces);
    stepper.start(&from).ok()?;
    let mut to = from.clone();
    let mut largest = [0.0f64; 2];
    for half in &mut largest {
        for _ in 0..STEPS {
            let t_next = from.state.t + h;
            stepper.attempt(Attempt { from: &from, h, t_next }, &mut to, &mut counters).ok()?;
            stepper.accept();
            std::mem::swap(&mut from, &mut to);
            let size = from.state.x[0].abs().max(from.state.v[0].abs());
            if size.is_nan() || size >= 1e12 {
                return Some(false);
            }
            *half = half.max(size);
        }
    }
    Some(largest[1] <= GROWTH * largest[0])
}
