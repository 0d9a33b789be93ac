//! Any order of calls of a simulation, by every method: each call ends with a value or an error, and what an error
//! refuses has not happened. What is saved goes on with the same bits, whatever was called before.

use super::config;
use canopy_fem::drive::clock::{Step, Tolerance};
use canopy_fem::integrate::registry::{self, MethodChoice};
use canopy_fem::model::spec::{AirSpec, DashpotKind, ReleaseSpec, Series, Slack};
use canopy_fem::simulation::{Load, NetworkBuilder, NodalForce, RunSpec, Simulation, SimulationError, SpringLaw};
use proptest::prelude::*;
use std::sync::Arc;

/// A call, with a number from 0 to 255 that its arguments are made of.
#[derive(Clone, Copy, Debug)]
enum Call {
    Step(u8),
    RunUntil(u8),
    Attempt,
    AttemptOf(u8),
    Accept,
    Drop,
    Force(u8),
    RemoveForce(u8),
    Law(u8),
    Wind(u8),
    Load(u8),
    RestLength(u8),
    State(u8),
    Snapshot,
    Restore(u8),
    Read,
}

fn call() -> impl Strategy<Value = Call> {
    prop_oneof![
        4 => any::<u8>().prop_map(Call::Step),
        1 => any::<u8>().prop_map(Call::RunUntil),
        2 => Just(Call::Attempt),
        1 => any::<u8>().prop_map(Call::AttemptOf),
        2 => Just(Call::Accept),
        2 => Just(Call::Drop),
        3 => any::<u8>().prop_map(Call::Force),
        1 => any::<u8>().prop_map(Call::RemoveForce),
        2 => any::<u8>().prop_map(Call::Law),
        2 => any::<u8>().prop_map(Call::Wind),
        2 => any::<u8>().prop_map(Call::Load),
        2 => any::<u8>().prop_map(Call::RestLength),
        1 => any::<u8>().prop_map(Call::State),
        2 => Just(Call::Snapshot),
        2 => any::<u8>().prop_map(Call::Restore),
        2 => Just(Call::Read),
    ]
}

/// [-] from -1 to 1; for some numbers not a number, or huge
fn value(number: u8) -> f64 {
    match number {
        254 => f64::NAN,
        255 => 1e300,
        _ => f64::from(number) / 127.0 - 1.0,
    }
}

/// Which name a number stands for: of forces and laws alike, so that they replace one another.
fn name(number: u8) -> &'static str {
    ["one", "two", "three"][usize::from(number % 3)]
}

/// A drag on every node, with derivatives or not.
struct Drag {
    coefficient: f64,
    of_velocity: bool,
    derivatives: bool,
}

impl NodalForce for Drag {
    fn add(&self, _t: f64, x: &[[f64; 3]], v: &[[f64; 3]], f: &mut [[f64; 3]]) {
        let of = if self.of_velocity { v } else { x };
        f.as_flattened_mut().iter_mut().zip(of.as_flattened()).for_each(|(f, of)| *f -= self.coefficient * of);
    }

    fn velocity_dependent(&self) -> bool {
        self.of_velocity
    }

    fn pairs(&self) -> Vec<[u32; 2]> {
        if self.derivatives { vec![[0, 0], [1, 2]] } else { Vec::new() }
    }
}

/// A small sheet, held at a corner that is released: with dashpots and air, or with neither.
fn simulation(method: usize, adaptive: bool, damped: bool) -> Simulation {
    let free = method.is_multiple_of(2);
    let dashpot = damped.then_some((DashpotKind::Axial, 0.05));
    let nodes = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.1]];
    let mut network = NetworkBuilder::new(nodes)
        .springs(&[[0, 1], [0, 2], [1, 3], [2, 3]], SpringLaw { stiffness: 50.0, dashpot, ..SpringLaw::default() })
        .springs(&[[1, 2]], SpringLaw { stiffness: 5e3, slack: Slack::TensionOnly, ..SpringLaw::default() })
        .masses(vec![0.5; 4])
        .hold(|node, _| node == 0)
        .gravity([0.0, 0.0, -9.81]);
    network.spec.mesh.triangles = vec![[0, 1, 2], [1, 3, 2]];
    if damped {
        let wind = Series { t: vec![0.0, 0.05], value: vec![[0.0, 0.0, 1.0], [0.0, 1.0, 3.0]] };
        network.spec.air = Some(AirSpec { linear: 0.1, quadratic: 0.05, wind });
    }
    network.spec.releases.push(ReleaseSpec { t: 0.031, nodes: vec![(0, [true; 3])], ..ReleaseSpec::default() });
    let methods = registry::methods();
    let method = MethodChoice::with_defaults(methods[method % methods.len()].name).expect("registered");
    let tolerance = Tolerance { relative: 1e-3, absolute: 1e-4 };
    let step = if adaptive { Step::Adaptive(tolerance) } else { Step::Fixed(2e-3) };
    let free_steps = !adaptive && free;
    let settings = RunSpec { free_steps, ..RunSpec::of(method, step, 0.1) };
    Simulation::new(network.build().expect("a mesh"), settings).expect("it starts")
}

/// Makes a call. Snapshots go to `saved`, and restored ones come from there.
fn make(sim: &mut Simulation, call: Call, saved: &mut Vec<Vec<u8>>) -> Result<(), SimulationError> {
    let nodes = sim.node_count();
    match call {
        Call::Step(n) => sim.steps(u64::from(n % 5)).map(|_| ()),
        Call::RunUntil(n) => sim.run_until(0.0005 * f64::from(n)).map(|_| ()),
        Call::Attempt => sim.attempt(),
        Call::AttemptOf(n) => sim.attempt_with_step(1e-3 * value(n)),
        Call::Accept => sim.accept().map(|_| ()),
        Call::Drop => sim.drop_attempt(),
        Call::Force(n) => {
            let mut force = vec![[0.0; 3]; nodes + usize::from(n == 7)];
            force[3] = [value(n), 0.0, value(n / 2)];
            sim.set_force(name(n), &force)
        }
        Call::RemoveForce(n) => sim.remove_force(name(n)).map(|_| ()),
        Call::Law(n) => {
            let (of_velocity, derivatives) = (n % 2 == 0, n % 8 == 1);
            sim.set_force_law(name(n), Arc::new(Drag { coefficient: 0.01 * f64::from(n), of_velocity, derivatives }))
        }
        Call::Wind(n) => sim.set_wind((n % 7 > 0).then(|| [value(n), 0.0, 2.0])),
        Call::Load(n) => sim.set_load_factor(if n % 5 > 0 { Load::Gravity } else { Load::Pressure(3) }, 1.0 + value(n)),
        Call::RestLength(n) => sim.set_rest_scale(&[u32::from(n % 6)], 1.0 + 0.1 * value(n)),
        Call::State(n) => {
            let (mut x, mut v) = (sim.positions(), sim.velocities());
            (x[3][2], v[3][0]) = (x[3][2] + 0.01 * value(n), value(n));
            sim.set_state(&x, &v)
        }
        Call::Snapshot => sim.snapshot().map(|bytes| saved.push(bytes)),
        Call::Restore(n) => match saved.len() {
            0 => sim.restore(&[n; 9]).map(drop),
            count => sim.restore(&saved[usize::from(n) % count]).map(drop),
        },
        Call::Read => {
            let rows = (sim.positions(), sim.velocities(), sim.reactions(), sim.tensions(), sim.attempted());
            assert_eq!((rows.0.len(), rows.1.len(), rows.2.len()), (nodes, nodes, nodes));
            let _ = (sim.energies(), sim.counters(), sim.load_factors(), sim.rest_scales(), sim.attempted_time());
            Ok(())
        }
    }
}

/// Where it is: bits of time, positions and velocities.
fn place(sim: &Simulation) -> Vec<u64> {
    let (x, v) = (sim.positions(), sim.velocities());
    [sim.time()].iter().chain(x.as_flattened()).chain(v.as_flattened()).map(|value| value.to_bits()).collect()
}

proptest! {
    #![proptest_config(config(256))]

    /// No order of calls ends in a panic. A refused call moves nothing, but that an attempt that is not accepted is
    /// dropped. Afterwards the simulation still goes on, or says why not.
    #[test]
    fn any_order_of_calls_ends_well(
        method in 0..100_usize,
        adaptive in any::<bool>(),
        damped in any::<bool>(),
        calls in prop::collection::vec(call(), 1..40),
    ) {
        let (mut sim, mut saved) = (simulation(method, adaptive, damped), Vec::new());
        for call in calls {
            let before = place(&sim);
            let waits = sim.attempted().is_some();
            let moves = matches!(call, Call::Step(_) | Call::RunUntil(_) | Call::Accept);
            match make(&mut sim, call, &mut saved) {
                Err(SimulationError::Broken) => prop_assert!(false, "{call:?} finds it broken"),
                Err(_) if !moves && !waits => prop_assert_eq!(place(&sim), before, "{:?} was refused", call),
                Err(_) | Ok(()) => {}
            }
        }
        let _ = sim.drop_attempt();
        sim.snapshot().map_err(|e| TestCaseError::fail(e.to_string()))?;
    }

    /// A simulation that is restored takes the same calls with the same bits as the one that was saved.
    #[test]
    fn what_is_saved_takes_the_same_calls(
        method in 0..100_usize,
        adaptive in any::<bool>(),
        damped in any::<bool>(),
        first in prop::collection::vec(call(), 1..20),
        then in prop::collection::vec(call(), 1..20),
    ) {
        let [mut sim, mut other] = [(); 2].map(|()| simulation(method, adaptive, damped));
        let mut saved = Vec::new();
        // A law is the program's own, and no part of a snapshot.
        let kept = |calls: Vec<Call>| calls.into_iter().filter(|call| !matches!(call, Call::Law(_) | Call::Restore(_)));
        for call in kept(first) {
            let _ = make(&mut sim, call, &mut saved);
        }
        let _ = sim.drop_attempt();
        let bytes = sim.snapshot().map_err(|e| TestCaseError::fail(e.to_string()))?;
        other.restore(&bytes).map_err(|e| TestCaseError::fail(e.to_string()))?;
        for call in kept(then) {
            let made = [make(&mut sim, call, &mut saved).is_ok(), make(&mut other, call, &mut saved).is_ok()];
            prop_assert_eq!(made[0], made[1], "{:?}", call);
            prop_assert_eq!(place(&sim), place(&other), "{:?}", call);
        }
    }
}
