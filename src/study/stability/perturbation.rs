//! Where measured runs start.
//!
//! ```text
//! as given      the scene's own state
//! small motion  its equilibrium x with f(x, v = 0) = 0
//! both          every free coordinate moved by up to 1e-8 of the scene's size
//! ```
//! The displacement gives every motion something to grow from, also in a scene at rest, and is pseudo-random so that
//! none is left out. Near its limit a step (or a stage within it) may reach far beyond the motion there is: from the
//! start as given it may leave the range in which a scene's forces are linear although the scene's own motion never
//! does. Such a scene is measured from small motion, where the limit of the linear scene shows.

use super::StabilitySpec;
use super::measure::PASSES;
use crate::drive::Status;
use crate::drive::clock::Step;
use crate::drive::observer::AcceptedStep;
use crate::experiment::{self, Event, Experiment};
use crate::integrate::Counters;
use crate::integrate::registry::MethodChoice;
use crate::integrate::stepper::{Attempt, Stepper};
use crate::mesh::random::pseudo_random;
use crate::model::forces::Forces;
use crate::model::point::Point;
use crate::model::state::{State, StateRef};
use crate::model::system::Weights;
use crate::scene::Scene;
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicBool, Ordering};

/// [-] share of the scene's size by which coordinates are moved, and by which rounding may.
const SEED: f64 = 1e-8;
/// Share of the reference step at which the scene's own motion is followed.
const FINE: f64 = 0.25;
/// Times the scene's tangent is compared on its way.
const LOOKS: u64 = 64;
/// Relative change of a tangent that is none.
const SAME: f64 = 0.01;
/// An implicit step that is so many times the run finds the equilibrium of a linear scene; the second time to rounding.
const LONG: f64 = 1e3;
const SETTLING: usize = 3;
/// Share of the force at the start that may be left.
const BALANCED: f64 = 1e-6;
/// Share of all forces that rounding may leave.
const ROUNDING: f64 = 1e-12;

/// Where runs began.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Start {
    /// at the scene's own start
    #[default]
    AsGiven,
    /// at the scene's equilibrium, which may be its own start
    SmallMotion,
}

/// [m] (or [rad], pendulum) How far rounding may move a node, and a start is moved.
pub(super) fn displacement(scene: &dyn Scene) -> f64 {
    let size = scene.size();
    SEED * if size > 0.0 { size } else { 1.0 }
}

/// A state with every free coordinate moved a little.
pub(super) fn seeded(scene: &dyn Scene, mut state: State) -> State {
    let far = displacement(scene);
    let free = scene.inverse_mass().iter().map(|m| *m > 0.0);
    state
        .x
        .iter_mut()
        .zip(free)
        .enumerate()
        .filter(|(_, (_, free))| *free)
        .for_each(|(i, (x, _))| *x += far * pseudo_random(i));
    state
}

/// [N] The size of the forces that act, those that balance each other too.
fn acting(scene: &dyn Scene, state: &State, forces: &Forces) -> f64 {
    scene.tension_sums(state.as_ref()).into_iter().fold(scene.force_scale(forces), f64::max)
}

/// Whether nothing moves a scene from its own start.
pub(super) fn at_rest(scene: &dyn Scene, state: &State) -> bool {
    let mut forces = scene.new_forces();
    scene.evaluate(state.as_ref(), &mut forces);
    let allowed = ROUNDING * acting(scene, state, &forces);
    state.v.iter().all(|v| *v == 0.0)
        && forces.total.iter().all(|f| f.abs() <= allowed)
        && scene.events().is_none_or(|events| events.corners().is_empty())
}

/// The start of small motion about the equilibrium, for a scene whose own motion is linear and that has an equilibrium.
pub(super) fn small_motion(spec: &StabilitySpec<'_>, reference: f64, stop: &AtomicBool) -> Option<State> {
    let tangent = Tangent::at(spec.scene, spec.scene.initial_state().as_ref());
    if !moves_linearly(spec, tangent.clone(), FINE * reference, stop)? {
        return None;
    }
    let rest = equilibrium(spec)?;
    tangent.is_same(spec.scene, rest.as_ref()).then(|| seeded(spec.scene, rest))
}

/// K and C, as they act on one pseudo-random vector.
#[derive(Clone)]
struct Tangent {
    pseudo_random: Vec<f64>,
    products: [Vec<f64>; 2],
}

impl Tangent {
    fn at(scene: &dyn Scene, at: StateRef<'_>) -> Self {
        let pseudo_random: Vec<f64> = (0..scene.n_dof()).map(pseudo_random).collect();
        let products = Self::products(scene, at, &pseudo_random);
        Tangent { pseudo_random, products }
    }

    fn products(scene: &dyn Scene, at: StateRef<'_>, pseudo_random: &[f64]) -> [Vec<f64>; 2] {
        [[1.0, 0.0], [0.0, 1.0]].map(|[k, c]| {
            let mut y = vec![0.0; pseudo_random.len()];
            scene.tangent_times(at, Weights { m: 0.0, c, k }, pseudo_random, &mut y);
            y
        })
    }

    fn is_same(&self, scene: &dyn Scene, at: StateRef<'_>) -> bool {
        let now = Self::products(scene, at, &self.pseudo_random);
        self.products.iter().zip(&now).all(|(was, is)| {
            let largest = was.iter().fold(0.0_f64, |most, y| most.max(y.abs()));
            was.iter().zip(is).all(|(was, is)| (was - is).abs() <= SAME * largest)
        })
    }
}

/// Whether the scene's tangent stays what it is at the start, along its own motion; `None` where that cannot be
/// followed.
fn moves_linearly(spec: &StabilitySpec<'_>, tangent: Tangent, h: f64, stop: &AtomicBool) -> Option<bool> {
    let method = MethodChoice::with_defaults("rk4").ok()?;
    let passes = (PASSES[0] / spec.scene.n_dof().max(1) as f64).min(PASSES[1]);
    let steps = (spec.end / h).min(passes / f64::from(method.info.evaluations[1].max(1))).ceil().max(1.0);
    let every = (steps as u64).div_ceil(LOOKS) | 1;
    let mut linear = true;
    let same = |state: &State| tangent.is_same(spec.scene, state.as_ref());
    let mut interrupted = false;
    let experiment = Experiment::new(spec.scene, &method, spec.solver, Step::Fixed(h), steps * h);
    let outcome = experiment.run(experiment::Start::Initial, None, &mut |event, _| {
        match event {
            Event::Step(AcceptedStep { step, end: Some(end), .. }) => {
                interrupted |= stop.load(Ordering::Relaxed);
                linear &= !step.is_multiple_of(every) || same(&end.state);
            }
            Event::Finished(last) => linear &= same(&last.state),
            _ => {}
        }
        interrupted || !linear
    });
    Some(outcome.ok()?.status == Status::Completed && linear && !interrupted)
}

/// The state without velocities in which the forces at t = 0 are balanced: what an endless implicit step comes to rest
/// in.
fn equilibrium(spec: &StabilitySpec<'_>) -> Option<State> {
    let scene = spec.scene;
    let method = MethodChoice::with_defaults("backward-euler").ok()?;
    let mut from = Point { state: scene.initial_state(), forces: scene.new_forces() };
    let largest = |f: &[f64]| f.iter().fold(0.0_f64, |most, f| most.max(f.abs()));
    from.state.v.fill(0.0);
    scene.evaluate(from.state.as_ref(), &mut from.forces);
    let allowed = (BALANCED * largest(&from.forces.total)).max(ROUNDING * acting(scene, &from.state, &from.forces));
    let mut to = from.clone();
    for _ in 0..SETTLING {
        if largest(&from.forces.total) <= allowed {
            break;
        }
        let mut stepper = Stepper::bind(method.scheme(spec.solver), scene.interfaces()).ok()?;
        stepper.start(&from).ok()?;
        // Loads are those at the start: time does not go on.
        let endless = Attempt { from: &from, h: LONG * spec.end, t_next: from.state.t };
        stepper.attempt(endless, &mut to, &mut Counters::default()).ok()?;
        std::mem::swap(&mut from, &mut to);
        from.state.v.fill(0.0);
        scene.evaluate(from.state.as_ref(), &mut from.forces);
    }
    (largest(&from.forces.total) <= allowed).then_some(from.state)
}
