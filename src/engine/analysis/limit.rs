//! The largest stable step of a method, from the real code of the method on a damped oscillator.
//!
//! One step is a linear map of (x, v, carried variables, forces that lag). Its columns are steps from unit states, and
//! the method is stable if the spectral radius of the map is at most 1.

use super::oscillator::Oscillator;
use super::rates::Rates;
use crate::assembly::SceneInterfaces;
use crate::integrate::implicit::SolverSpec;
use crate::integrate::registry::{Family, MethodChoice};
use crate::integrate::stepper::{Attempt, Stepper};
use crate::integrate::{CarriedState, Counters};
use crate::model::point::Point;
use crate::model::system::System;

/// Excess of the spectral radius over 1 that is rounding.
const ROUNDING: f64 = 1e-10;
/// Below this w h the growth of an undamped oscillation hides in [`ROUNDING`]: the limit is 0.
const NO_LIMIT_BELOW: f64 = 1e-2;
/// Steps over which the energy is followed.
const SWING: u32 = 64;
/// Squarings of the map: its power 2^40 is taken.
const SQUARINGS: usize = 40;

/// [s] Largest step at which `method` is stable on the fastest oscillation of `rates`; infinite for a method without
/// limit, 0 for one that grows at every step.
///
/// The frequency and the damping rate are taken to belong to one mode, as if the scene were a single oscillator: an
/// estimate. Kang's filter has no limit of its own; what acts outside it may set one that is not found here.
pub fn critical_step(method: &MethodChoice, rates: Rates) -> f64 {
    if method.info.family == Family::MatrixFree || (rates.frequency == 0.0 && rates.damping == 0.0) {
        return f64::INFINITY;
    }
    // In units of the faster rate, so that the search interval is the same for every scene.
    let unit = rates.frequency.max(rates.damping);
    let oscillator = Oscillator { k: (rates.frequency / unit).powi(2), c: rates.damping / unit };
    if !limited_on(method, oscillator) {
        return f64::INFINITY;
    }
    // The farthest limit is that of dop853: w h = 6.4 at damping ratio 1, where the faster rate is the damping, twice
    // w. Substeps make it longer.
    let (mut stable, mut unstable) = (0.0, 16.0 * method.substeps());
    for _ in 0..40 {
        let middle = 0.5 * (stable + unstable);
        if stable_at(method, oscillator, middle, ROUNDING) { stable = middle } else { unstable = middle }
    }
    // Damping below rounding in such a step is none: that of modes which air or dashpots do not act on.
    let undamped = 0.5 * oscillator.c * stable <= ROUNDING;
    if undamped && stable < NO_LIMIT_BELOW { 0.0 } else { stable / unit }
}

/// Whether a method has a stability limit on an undamped oscillator. Kang's filter has none; forces outside it may set
/// one that is not found here.
pub fn has_limit(method: &MethodChoice) -> bool {
    method.info.family != Family::MatrixFree && limited_on(method, Oscillator { k: 1.0, c: 0.0 })
}

/// Whether `method` has a limit on an oscillator whose faster rate is 1.
fn limited_on(method: &MethodChoice, oscillator: Oscillator) -> bool {
    // At large steps the map is badly scaled and its radius carries more rounding; an unstable method is far above 1
    // there.
    let [first, second] = [37.0, 400.0].map(|h| h * method.substeps());
    !(stable_at(method, oscillator, first, 1e-6) && stable_at(method, oscillator, second, 1e-4))
}

fn stable_at(method: &MethodChoice, oscillator: Oscillator, h: f64, tolerance: f64) -> bool {
    spectral_radius(method, oscillator, h).is_some_and(|r| r <= 1.0 + tolerance)
}

/// Whether `method` is stable at step `h` [s] on the oscillator of `rates`.
pub(super) fn stable(method: &MethodChoice, rates: Rates, h: f64) -> bool {
    let unit = rates.frequency.max(rates.damping);
    let oscillator = Oscillator { k: (rates.frequency / unit).powi(2), c: rates.damping / unit };
    unit == 0.0 || stable_at(method, oscillator, h * unit, ROUNDING)
}

/// [-] Growth of the oscillation of `rates` in one step of `h` [s]; below 1 it dies out. `None` when a step cannot be
/// made.
pub fn growth(method: &MethodChoice, rates: Rates, h: f64) -> Option<f64> {
    let unit = rates.frequency.max(rates.damping);
    let oscillator = Oscillator { k: (rates.frequency / unit).powi(2), c: rates.damping / unit };
    if unit > 0.0 { spectral_radius(method, oscillator, h * unit) } else { Some(1.0) }
}

/// [-] How far a step of `h` [s] swings the energy of the oscillation of `rates`: the largest energy of some tens of
/// steps over that at the start, from x and from v alone. At most 1 where the energy never rises; large just below the
/// limit of a symplectic scheme.
pub fn swing(method: &MethodChoice, rates: Rates, h: f64) -> Option<f64> {
    let unit = rates.frequency.max(rates.damping);
    if unit == 0.0 {
        return Some(1.0);
    }
    let oscillator = Oscillator { k: (rates.frequency / unit).powi(2), c: rates.damping / unit };
    let from_x = highest(method, oscillator, h * unit, [1.0, 0.0])?;
    let from_v = highest(method, oscillator, h * unit, [0.0, oscillator.k.sqrt()])?;
    Some(from_x.max(from_v))
}

/// Largest energy of a motion from (x, v), in units of that of x = 1.
fn highest(method: &MethodChoice, oscillator: Oscillator, h: f64, [x, v]: [f64; 2]) -> Option<f64> {
    let system = &oscillator;
    let interfaces = SceneInterfaces { system, tangent: system, graph: None };
    let mut from = Point { state: system.initial_state(), forces: system.new_forces() };
    (from.state.x[0], from.state.v[0]) = (x, v);
    system.evaluate(from.state.as_ref(), &mut from.forces);
    let mut stepper = Stepper::bind(method.scheme(SolverSpec::default()), interfaces).ok()?;
    stepper.start(&from).ok()?;
    let mut to = from.clone();
    let mut most = 0.0_f64;
    for n in 1..=SWING {
        let attempt = Attempt { from: &from, h, t_next: f64::from(n) * h };
        let report = stepper.attempt(attempt, &mut to, &mut Counters::default()).ok()?;
        stepper.accept();
        if !report.forces_at_end {
            system.evaluate(to.state.as_ref(), &mut to.forces);
        }
        std::mem::swap(&mut from, &mut to);
        let (x, v) = (from.state.x[0], from.state.v[0]);
        most = most.max(x * x + v * v / oscillator.k.max(f64::MIN_POSITIVE));
    }
    Some(most).filter(|most| most.is_finite())
}

/// Spectral radius of one step; `None` when a step cannot be made at all.
fn spectral_radius(method: &MethodChoice, oscillator: Oscillator, h: f64) -> Option<f64> {
    let columns = step_map(method, oscillator, h)?;
    let n = columns.len();
    let (mut map, mut square) = (columns.concat(), vec![0.0; n * n]);
    let mut log = 0.0;
    let mut weight = 1.0;
    for _ in 0..=SQUARINGS {
        let size = map.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        if size == 0.0 {
            return Some(0.0);
        }
        if !size.is_finite() {
            return None;
        }
        log += weight * size.ln();
        weight *= 0.5;
        map.iter_mut().for_each(|x| *x /= size);
        // Columns: (A A) e_j = sum over k of A_kj (A e_k).
        for (j, column) in square.chunks_mut(n).enumerate() {
            for (i, entry) in column.iter_mut().enumerate() {
                *entry = (0..n).map(|k| map[k * n + i] * map[j * n + k]).sum();
            }
        }
        std::mem::swap(&mut map, &mut square);
    }
    Some(log.exp())
}

/// Columns of the linear map that one step of the scheme is on (x, v, carried numbers, and a force that lags).
fn step_map(method: &MethodChoice, oscillator: Oscillator, h: f64) -> Option<Vec<Vec<f64>>> {
    let system = &oscillator;
    let interfaces = SceneInterfaces { system, tangent: system, graph: None };
    let start = Point { state: system.initial_state(), forces: system.new_forces() };
    let mut probe = Stepper::bind(method.scheme(SolverSpec::default()), interfaces).ok()?;
    probe.start(&start).ok()?;
    let carried = probe.save().vectors.len();
    // Forces that lag behind the state are part of what a step begins with.
    let lags = probe.lags();
    let column = |j: usize| {
        let unit = |i: usize| if i == j { 1.0 } else { 0.0 };
        let mut stepper = Stepper::bind(method.scheme(SolverSpec::default()), interfaces).ok()?;
        let mut from = start.clone();
        (from.state.x[0], from.state.v[0]) = (unit(0), unit(1));
        system.evaluate(from.state.as_ref(), &mut from.forces);
        stepper.start(&from).ok()?;
        let vectors = (0..carried).map(|i| vec![unit(2 + i)]).collect();
        stepper.restore(&CarriedState { vectors, made_with: h, ..CarriedState::default() }).ok()?;
        if lags {
            from.forces.total[0] = unit(2 + carried);
        }
        let mut to = from.clone();
        stepper.attempt(Attempt { from: &from, h, t_next: h }, &mut to, &mut Counters::default()).ok()?;
        stepper.accept();
        let after = stepper.save().vectors;
        let motion = [to.state.x[0], to.state.v[0]];
        let carried = after.into_iter().flatten();
        let forces = lags.then(|| to.forces.total[0]);
        Some(motion.into_iter().chain(carried).chain(forces).collect::<Vec<f64>>())
    };
    (0..2 + carried + usize::from(lags)).map(column).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::registry::methods;
    use std::collections::BTreeMap;

    /// All methods that an oscillator can be stepped with (Kang's needs springs), some with parameters of either kind.
    fn steppable() -> Vec<MethodChoice> {
        let plain = methods().iter().filter(|info| info.family != Family::MatrixFree).map(|info| (info.name, None));
        let other = [
            ("newmark", Some(("beta", 1.0 / 6.0))),
            ("newmark", Some(("gamma", 0.6))),
            ("hht", Some(("alpha", 0.0))),
            ("generalized-alpha", Some(("rho_inf", 1.0))),
            ("energy-momentum", Some(("dissipation", 0.5))),
            ("multirate", Some(("substeps", 3.0))),
        ];
        let given = |p: Option<(&str, f64)>| p.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
        plain.chain(other).map(|(name, p)| MethodChoice::new(name, &given(p)).unwrap()).collect()
    }

    /// States (x, v) of steps of `h` [s] from x = 1, the start among them.
    fn states(method: &MethodChoice, oscillator: Oscillator, v: f64, h: f64, steps: u32) -> Vec<[f64; 2]> {
        let system = &oscillator;
        let interfaces = SceneInterfaces { system, tangent: system, graph: None };
        let mut from = Point { state: system.initial_state(), forces: system.new_forces() };
        from.state.v[0] = v;
        system.evaluate(from.state.as_ref(), &mut from.forces);
        let mut stepper = Stepper::bind(method.scheme(SolverSpec::default()), interfaces).unwrap();
        stepper.start(&from).unwrap();
        let mut states = vec![[1.0, v]];
        for n in 1..=steps {
            let mut to = from.clone();
            let attempt = Attempt { from: &from, h, t_next: f64::from(n) * h };
            stepper.attempt(attempt, &mut to, &mut Counters::default()).unwrap();
            stepper.accept();
            system.evaluate(to.state.as_ref(), &mut to.forces);
            from = to;
            states.push([from.state.x[0], from.state.v[0]]);
        }
        states
    }

    /// A function of h L leaves x e^(lambda t) in its own direction (1, lambda), and makes the same of it whatever the
    /// other eigenvalue is.
    #[test]
    fn a_step_is_a_function_of_h_l_unless_the_method_is_partitioned() {
        for method in steppable() {
            let with = |fast: f64| Oscillator { k: -0.9 * fast, c: 0.9 - fast };
            let [one, other] = [-1.6, -2.3].map(|fast| states(&method, with(fast), -0.9, 0.4, 5));
            let apart = |[x, v]: [f64; 2], [y, _]: [f64; 2]| (x - y).abs().max((v + 0.9 * x).abs());
            let most = one.iter().zip(&other).map(|(a, b)| apart(*a, *b)).fold(0.0, f64::max);
            let name = (method.info.name, method.parameters().collect::<Vec<_>>());
            match method.partitioned() {
                true => assert!(most > 1e-5, "{name:?}: no function of h L, but {most:e} apart"),
                false => assert!(most < 1e-12, "{name:?}: a function of h L, but {most:e} apart"),
            }
        }
    }

    #[test]
    fn energy_falls_in_every_step_where_a_method_says_so() {
        let oscillator = Oscillator { k: 1.0, c: 0.0 };
        for info in methods().iter().filter(|info| info.family != Family::MatrixFree) {
            let method = MethodChoice::with_defaults(info.name).unwrap();
            let falls = |wh: f64| {
                let energies = states(&method, oscillator, 0.0, wh, SWING).into_iter().map(|[x, v]| x * x + v * v);
                energies.is_sorted_by(|before, after| after < before)
            };
            let always = [0.3, 0.6, 1.0, 1.5, 2.0].into_iter().all(falls);
            assert_eq!(always, info.linear.always_dissipates, "{}", info.name);
        }
    }

    #[test]
    fn a_pencil_is_singular_at_the_limit() {
        for info in methods() {
            let (name, method) = (info.name, MethodChoice::with_defaults(info.name).unwrap());
            let Some(pencil) = method.pencil() else { continue };
            // Short steps are one map of several, which near the limit is worse conditioned.
            let close = if method.substeps() > 1.0 { 1e-3 } else { 1e-7 };
            // Undamped, two eigenvalues meet at the limit, where rounding counts by its root.
            for zeta in [0.0, 0.05, 0.4, 1.0, 3.0] {
                let (frequency, damping) = (20.0, 40.0 * zeta);
                let found = critical_step(&method, Rates { frequency, damping, ..Rates::default() });
                let expected = pencil.singular_at(frequency * frequency, damping);
                assert!((found / expected - 1.0).abs() < close, "{name} at {zeta}: {found}, {expected}");
            }
        }
    }

    /// The step map has the eigenvalue 1 there, and is not near it elsewhere.
    #[test]
    fn a_velocity_is_kept_where_a_method_says_so() {
        let given = methods().iter().filter_map(|info| info.linear.fixed_velocity.map(|hc| (info.name, hc)));
        for (name, hc) in given {
            let method = MethodChoice::with_defaults(name).unwrap();
            for k in [-3.0, 2.0, 90.0] {
                let away = |hc: f64| {
                    let map = step_map(&method, Oscillator { k, c: 20.0 }, hc / 20.0).unwrap();
                    (map[0][0] - 1.0) * (map[1][1] - 1.0) - map[0][1] * map[1][0]
                };
                assert!(away(hc).abs() < 1e-12 && away(0.9 * hc).abs() > 1e-3, "{name} with k = {k}: {}", away(hc));
            }
        }
    }

    /// The table "Critical steps" of structural dynamics: w h at damping ratio 0, 0.1 and 1.
    #[test]
    fn limits_equal_the_known_ones() {
        let known: [(&str, [f64; 3]); 12] = [
            ("explicit-euler", [0.0, 0.2, 2.0]),
            ("euler-cromer", [2.0, 1.8099, 0.8284]),
            ("improved-euler", [0.0, 1.0497, 2.0]),
            ("euler-richardson", [0.0, 1.0497, 2.0]),
            ("improved-euler-pec", [0.0, 0.6492, 1.0]),
            ("velocity-verlet", [2.0, 1.8435, 1.0]),
            ("central-difference", [2.0, 1.8099, 0.8284]),
            // Six times those.
            ("multirate", [12.0, 10.8594, 4.9706]),
            ("beeman", [1.7321, 1.2673, 0.2663]),
            ("rk4", [2.8284, 2.9508, 2.7853]),
            ("dormand-prince", [0.9972, 2.6814, 3.3066]),
            ("dop853", [5.9604, 6.2810, 6.3937]),
        ];
        let all = methods().iter().filter(|info| info.family == Family::Explicit).map(|info| info.name);
        for name in all {
            assert!(known.iter().any(|(known, _)| *known == name), "the limits of {name} are to be added here");
        }
        for (name, limits) in known {
            let method = MethodChoice::with_defaults(name).unwrap();
            for (zeta, limit) in [0.0, 0.1, 1.0].into_iter().zip(limits) {
                let frequency = 250.0;
                let rates = Rates { frequency, damping: 2.0 * zeta * frequency, ..Default::default() };
                let found = critical_step(&method, rates) * frequency;
                let close = 2e-4 * method.substeps();
                assert!((found - limit).abs() < close, "{name} at damping ratio {zeta}: {found}, known {limit}");
            }
        }
    }

    /// Just below its limit Verlet swings the energy by 1/(1 - (w h/2)^2), Euler-Cromer by (1 + w h/2)/(1 - w h/2); a
    /// Runge-Kutta scheme never raises it.
    #[test]
    fn energy_swings_where_the_map_is_not_normal() {
        let rates = Rates { frequency: 3.0, ..Rates::default() };
        let of = |name: &str, wh: f64| {
            let method = MethodChoice::with_defaults(name).unwrap();
            swing(&method, rates, wh / 3.0).unwrap()
        };
        let (verlet, cromer) = (of("velocity-verlet", 1.96), of("euler-cromer", 1.96));
        assert!((verlet / 25.25 - 1.0).abs() < 0.05, "{verlet}");
        assert!(cromer > 25.0 && cromer < 99.1, "{cromer}");
        assert!(of("rk4", 2.8) <= 1.0 && of("velocity-verlet", 0.1) < 1.01);
    }

    #[test]
    fn unconditionally_stable_methods_have_no_limit_and_linear_acceleration_has_its_own() {
        let rates = Rates { frequency: 10.0, damping: 0.0, ..Default::default() };
        for name in ["newmark", "hht", "backward-euler", "generalized-alpha", "esdirk4", "energy-momentum"] {
            let method = MethodChoice::with_defaults(name).unwrap();
            assert_eq!(critical_step(&method, rates), f64::INFINITY, "{name}");
        }
        let linear_acceleration = BTreeMap::from([("beta".to_owned(), 1.0 / 6.0)]);
        let method = MethodChoice::new("newmark", &linear_acceleration).unwrap();
        let periods = critical_step(&method, rates) * 10.0 / std::f64::consts::TAU;
        assert!((periods - 0.5513).abs() < 1e-3, "{periods}");
    }
}
