//! The loads, at once or in steps: weight, pressures, forces and displacements of supports grow together from 0, in
//! steps that grow where they are easy and are cut where they fail. A gas is filled with them, from the ambient
//! pressure in the volume at the start. Wind acts in full from the start, as it has no factor.

use super::continuation::Continuation;
use super::failure::StaticFailure;
use super::put_supports;
use crate::scene::loads;

/// [-] Forces left at a level of the loads that is not the last, as a share of all.
const ON_THE_WAY: f64 = 1e-3;
/// Steps that replace an application at once that has failed.
const STEPS: u32 = 10;
/// [-] Factor of a step after one that succeeded.
const GROW: f64 = 1.5;
/// Failed steps after which the path ends.
const MOST_CUTS: u32 = 8;

/// Finds the equilibrium under the full loads.
pub(super) fn follow(search: &mut Continuation<'_>) -> Result<(), StaticFailure> {
    let relative = search.spec.relative;
    if search.spec.load_steps > 1 {
        return in_steps(search, search.spec.load_steps);
    }
    search.load_steps = 1;
    let failure = match search.settle(relative) {
        Err(failure @ (StaticFailure::NotConverged { .. } | StaticFailure::Left { .. })) => failure,
        done => return done,
    };
    let moves = put_supports(search.scene, &mut search.at.state, 1.0);
    if loads(search.scene).is_empty() && !moves && !fill(search, 1.0) {
        return Err(failure);
    }
    log::info!("not in equilibrium with the full loads at once; they are applied in steps");
    // Another search that gets as many iterations; the first failure says more than that of a share of the loads.
    search.spec.max_iterations = search.spec.max_iterations.saturating_mul(2);
    let best = search.at.clone();
    search.restart();
    match in_steps(search, STEPS) {
        Err(StaticFailure::Interrupted) => Err(StaticFailure::Interrupted),
        Err(_) => {
            search.at = best;
            Err(failure)
        }
        Ok(()) => Ok(()),
    }
}

/// The loads in steps, at first of equal size.
fn in_steps(search: &mut Continuation<'_>, steps: u32) -> Result<(), StaticFailure> {
    let given: Vec<f64> = loads(search.scene).iter().map(|load| load.scale.get()).collect();
    let followed = levels(search, steps, &given);
    apply(search, &given, 1.0);
    followed
}

fn levels(search: &mut Continuation<'_>, steps: u32, given: &[f64]) -> Result<(), StaticFailure> {
    let (mut reached, mut step, mut cuts) = (0.0, 1.0 / f64::from(steps.max(1)), 0);
    while reached < 1.0 {
        // The rest is not left to a step that rounding makes tiny.
        let level = if reached + 1.01 * step >= 1.0 { 1.0 } else { reached + step };
        let before = search.at.clone();
        apply(search, given, level);
        search.level = level;
        let relative = if level == 1.0 { search.spec.relative } else { ON_THE_WAY };
        log::info!("loads times {level:.4}");
        match search.settle(relative) {
            Ok(()) => {
                search.load_steps += 1;
                reached = level;
                step *= GROW;
            }
            Err(failure @ (StaticFailure::NotConverged { .. } | StaticFailure::Left { .. })) if cuts == MOST_CUTS => {
                return Err(failure);
            }
            Err(StaticFailure::NotConverged { .. } | StaticFailure::Left { .. }) => {
                cuts += 1;
                step = 0.5 * (level - reached);
                search.at = before;
            }
            Err(failure) => return Err(failure),
        }
    }
    Ok(())
}

/// Fills gases to a level. Returns whether there are any.
fn fill(search: &Continuation<'_>, level: f64) -> bool {
    search.scene.controls().is_some_and(|controls| controls.fill_gases(level))
}

/// Scales the loads, `given` at full size, fills gases, and moves the supports.
fn apply(search: &mut Continuation<'_>, given: &[f64], level: f64) {
    loads(search.scene).iter().zip(given).for_each(|(load, given)| load.scale.set(level * given));
    fill(search, level);
    put_supports(search.scene, &mut search.at.state, level);
    search.refresh();
}
