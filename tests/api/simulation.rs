//! A simulation driven by a program: what it shares with a run of the command line, and what only a program does.

use canopy_fem::case::Case;
use canopy_fem::drive::clock::Tolerance;
use canopy_fem::simulation::{
    FollowSpec, NetworkBuilder, NodalForce, RunSpec, Simulation, SimulationError, SpringLaw, follow,
};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

const METHODS: [&str; 4] = ["velocity-verlet", "rk4", "newmark", "hht"];

/// A chain of six nodes, held at one end, that falls.
fn chain() -> NetworkBuilder {
    let nodes = (0..6).map(|i| [0.2 * f64::from(i), 0.0, 0.0]).collect();
    let pairs: Vec<[u32; 2]> = (0..5).map(|i| [i, i + 1]).collect();
    NetworkBuilder::new(nodes)
        .springs(&pairs, SpringLaw { stiffness: 400.0, ..SpringLaw::default() })
        .total_mass(0.6)
        .hold(|node, _| node == 0)
        .gravity([0.0, 0.0, -9.81])
}

fn falling(method: &str) -> Simulation {
    let settings = RunSpec::fixed(method, 1e-3, 1.0).expect("registered");
    Simulation::new(chain().build().expect("a mesh"), settings).expect("it starts")
}

fn adaptive() -> Simulation {
    let tolerance = Tolerance { relative: 1e-6, absolute: 1e-8 };
    let settings = RunSpec::adaptive("newmark", tolerance, 1.0).expect("registered");
    Simulation::new(chain().build().expect("a mesh"), settings).expect("it starts")
}

fn all() -> Vec<Simulation> {
    METHODS.into_iter().map(falling).chain([adaptive()]).collect()
}

fn assert_same(a: &Simulation, b: &Simulation) {
    assert_eq!((a.time(), a.step_count(), a.energies()), (b.time(), b.step_count(), b.energies()));
    assert_eq!((a.positions(), a.velocities()), (b.positions(), b.velocities()));
    assert_eq!((a.tensions(), a.reactions()), (b.tensions(), b.reactions()));
}

/// A step after the other, a number of steps, and a whole run have the same bits as a run of the case.
#[test]
fn steps_are_those_of_a_run() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/cases/oscillator-damped.json");
    let case = Case::from_file(&path, &[]).expect("a case");
    let mut ends = Vec::new();
    follow(case.problem(), FollowSpec::default(), |seen| ends.push((seen.t, seen.positions[1], seen.ledger)))
        .expect("it runs");
    let [mut by_step, mut by_many] = [(), ()].map(|()| Simulation::from_case(case.problem(), 1).expect("it starts"));
    for end in &ends[1..51] {
        by_step.step().expect("it goes on");
        assert_eq!((by_step.time(), by_step.positions()[1], by_step.energies()), *end);
    }
    by_many.steps(30).expect("it goes on");
    by_many.run_until(ends[50].0).expect("it goes on");
    assert_same(&by_step, &by_many);
    by_many.run_until(ends.last().expect("steps").0).expect("to the end");
    assert!(matches!(by_many.step(), Err(SimulationError::Ended { .. })));
}

/// A simulation may move to another thread between two steps.
#[test]
fn it_moves_between_threads() {
    fn assert_send<T: Send + 'static>(_: &T) {}
    for (mut moved, mut stayed) in all().into_iter().zip(all()) {
        assert_send(&moved);
        moved.steps(10).expect("it goes on");
        let mut moved = std::thread::spawn(move || {
            moved.steps(10).expect("it goes on");
            moved
        })
        .join()
        .expect("no panic");
        moved.steps(10).expect("it goes on");
        stayed.steps(30).expect("it goes on");
        assert_same(&moved, &stayed);
    }
}

/// What was saved goes on with the same bits, in the same simulation and in another; damaged bytes are refused.
#[test]
fn a_snapshot_goes_on_with_the_same_bits() {
    for (mut sim, mut other) in all().into_iter().zip(all()) {
        let force = vec![[0.0, 0.1, 0.0]; sim.node_count()];
        sim.set_force("wake", &force).expect("a network");
        sim.steps(17).expect("it goes on");
        let mut bytes = sim.snapshot().expect("idle");
        sim.steps(20).expect("it goes on");
        other.restore(&bytes).expect("the same scene");
        other.steps(20).expect("it goes on");
        assert_same(&sim, &other);
        sim.restore(&bytes).expect("its own");
        sim.steps(20).expect("it goes on");
        assert_same(&sim, &other);
        bytes[40] ^= 1;
        assert!(matches!(sim.restore(&bytes), Err(SimulationError::Snapshot(_))));
        assert_same(&sim, &other);
    }
}

/// A snapshot says of which method and scene it is. A run with another method, step, mass or stiffness goes on from its
/// state as one that was put there, and says what differs; a scene with other nodes refuses it.
#[test]
fn a_snapshot_of_another_method_or_scene_is_a_start() {
    let made = |method: &str, stiffness: f64, step: f64| {
        let network = NetworkBuilder::new(vec![[0.0; 3], [1.0, 0.0, 0.0]])
            .springs(&[[0, 1]], SpringLaw { stiffness, ..SpringLaw::default() })
            .masses(vec![2.0; 2])
            .hold(|node, _| node == 0);
        let settings = RunSpec::fixed(method, step, 1.0).expect("registered");
        Simulation::new(network.build().expect("a mesh"), settings).expect("it starts")
    };
    let mut sim = made("velocity-verlet", 8.0, 1e-3);
    sim.set_state(&[[0.0; 3], [1.1, 0.0, 0.0]], &[[0.0; 3], [0.2, 0.0, 0.0]]).expect("idle");
    sim.steps(10).expect("it goes on");
    let bytes = sim.snapshot().expect("idle");
    for (method, stiffness, step, count, word) in [
        ("rk4", 8.0, 1e-3, 10, "velocity-verlet, now rk4"),
        ("velocity-verlet", 9.0, 1e-3, 10, "other stiffnesses"),
        ("newmark", 8.0, 5e-3, 2, "steps of 0.001 s, now steps of 0.005 s"),
        ("velocity-verlet", 8.0, 4e-3, 2, "now steps of 0.004 s"),
    ] {
        let mut other = made(method, stiffness, step);
        let differs = other.restore(&bytes).expect("the same nodes").join("; ");
        assert!(differs.contains(word), "{differs}");
        assert_eq!((other.step_count(), other.time()), (count, 0.01));
        let mut put = made(method, stiffness, step);
        put.set_state_at(0.01, &sim.positions(), &sim.velocities()).expect("idle");
        let next = other.step().expect("it goes on");
        // The third step of 4 ms ends at 12 ms.
        assert_eq!(next.time, if step == 4e-3 { 0.012 } else { 0.01 + step });
        put.step().expect("it goes on");
        assert_same(&other, &put);
        // Between two ends of steps, a snapshot is taken up as anywhere.
        let mut again = made(method, stiffness, step);
        put.set_state_at(0.0111, &sim.positions(), &sim.velocities()).expect("idle");
        assert!(again.restore(&put.snapshot().expect("idle")).expect("the same").is_empty());
        assert_same(&again, &put);
    }
    assert!(made("velocity-verlet", 8.0, 1e-3).restore(&bytes).expect("the same").is_empty());
    let three = NetworkBuilder::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]).masses(vec![2.0; 3]);
    let settings = RunSpec::fixed("velocity-verlet", 1e-3, 1.0).expect("registered");
    let mut other = Simulation::new(three.build().expect("a mesh"), settings).expect("it starts");
    assert!(matches!(other.restore(&bytes), Err(SimulationError::Snapshot(_))));
    for t in [-0.1, 1.1, f64::NAN] {
        assert!(sim.set_state_at(t, &sim.positions(), &sim.velocities()).is_err(), "{t}");
    }
}

/// An attempt that is accepted is a step; one that is dropped leaves no trace.
#[test]
fn attempts_are_accepted_or_dropped() {
    for (mut sim, mut stepped) in all().into_iter().zip(all()) {
        for _ in 0..5 {
            sim.attempt().expect("it is made");
            let tried = sim.attempted().expect("it waits");
            assert!(matches!(sim.step(), Err(SimulationError::Attempt { pending: true })));
            sim.drop_attempt().expect("it waits");
            assert_eq!(sim.positions(), stepped.positions());
            sim.attempt().expect("it is made");
            assert_eq!(sim.attempted().expect("it waits"), tried);
            sim.accept().expect("it waits");
            stepped.step().expect("it goes on");
            assert_same(&sim, &stepped);
        }
        assert!(matches!(sim.accept(), Err(SimulationError::Attempt { pending: false })));
    }
}

/// A constant force on a free mass: x = 1/2 f/m t^2, and the account has its work. From halfway on the opposite force
/// brings the mass to rest.
#[test]
fn a_force_from_outside_does_its_work() {
    for method in METHODS {
        let network = NetworkBuilder::new(vec![[0.0; 3], [1.0, 0.0, 0.0]])
            .springs(&[[0, 1]], SpringLaw { stiffness: 1e-9, ..SpringLaw::default() })
            .masses(vec![2.0; 2])
            .hold(|node, _| node == 0);
        let settings = RunSpec::fixed(method, 1e-2, 2.0).expect("registered");
        let mut sim = Simulation::new(network.build().expect("a mesh"), settings).expect("it starts");
        sim.set_force("push", &[[0.0; 3], [0.0, 4.0, 0.0]]).expect("a network");
        sim.run_until(1.0).expect("it goes on");
        assert!((sim.positions()[1][1] - 1.0).abs() < 1e-6, "{method}: {:?}", sim.positions());
        assert!((sim.energies().external_work - 4.0).abs() < 1e-6, "{method}: {:?}", sim.energies());
        sim.set_force("push", &[[0.0; 3], [0.0, -4.0, 0.0]]).expect("a network");
        sim.run_until(2.0).expect("it goes on");
        assert!((sim.positions()[1][1] - 2.0).abs() < 1e-6, "{method}: {:?}", sim.positions());
        assert!(sim.velocities()[1][1].abs() < 1e-6, "{method}: {:?}", sim.velocities());
        assert!(sim.energies().numerical.abs() < 1e-6, "{method}: {:?}", sim.energies());
        assert!(sim.remove_force("push").expect("idle") && !sim.remove_force("push").expect("idle"));
    }
}

/// A spring to the origin that the program computes.
struct Tether(f64);

impl NodalForce for Tether {
    fn add(&self, _t: f64, x: &[[f64; 3]], _v: &[[f64; 3]], f: &mut [[f64; 3]]) {
        for (f, x) in f.iter_mut().zip(x) {
            f[1] -= self.0 * x[1];
        }
    }
}

/// A law of the program's own acts on explicit and implicit methods alike: x = cos(2 t).
#[test]
fn a_law_of_ones_own_acts() {
    for method in METHODS {
        let network = NetworkBuilder::new(vec![[0.0, 1.0, 0.0], [0.5, 1.0, 0.0]])
            .springs(&[[0, 1]], SpringLaw { stiffness: 1.0, ..SpringLaw::default() })
            .masses(vec![2.0; 2]);
        let settings = RunSpec::fixed(method, 1e-3, 1.0).expect("registered");
        let mut sim = Simulation::new(network.build().expect("a mesh"), settings).expect("it starts");
        sim.set_force_law("tether", Arc::new(Tether(8.0))).expect("a network");
        sim.run_until(1.0).expect("it goes on");
        for x in sim.positions() {
            assert!((x[1] - 2.0_f64.cos()).abs() < 1e-3, "{method}: {x:?}");
        }
    }
}

/// A force that fails once and says so.
struct Failing(Arc<AtomicBool>);

impl NodalForce for Failing {
    fn add(&self, _t: f64, _x: &[[f64; 3]], _v: &[[f64; 3]], f: &mut [[f64; 3]]) {
        f.as_flattened_mut().fill(f64::NAN);
        self.0.store(true, Ordering::Relaxed);
    }
}

/// A step that a force of the program's own gives up on fails without a search for its cause, and has not happened.
#[test]
fn a_step_that_is_given_up_on_is_not_looked_into() {
    for (method, given_up) in [("velocity-verlet", true), ("velocity-verlet", false), ("rk4", true), ("rk4", false)] {
        let mut sim = falling(method);
        sim.steps(5).expect("it goes on");
        let before = (sim.step_count(), sim.positions());
        let flag = Arc::new(AtomicBool::new(false));
        if given_up {
            sim.stop_on(flag.clone());
        }
        sim.set_force_law("failing", Arc::new(Failing(flag.clone()))).expect("a network");
        match sim.step() {
            Err(SimulationError::Failed(failure)) => {
                assert_eq!(failure.cause.contains("cut short"), given_up, "{failure:?}");
            }
            other => panic!("{other:?}"),
        }
        assert_eq!(before, (sim.step_count(), sim.positions()));
        flag.store(false, Ordering::Relaxed);
        assert!(sim.remove_force("failing").expect("idle"));
        sim.steps(5).expect("it goes on");
    }
}

/// A state that is set is where the motion goes on from; wrong ones are refused.
#[test]
fn a_state_can_be_set() {
    let mut sim = falling("velocity-verlet");
    let (x, v) = (sim.positions(), sim.velocities());
    let mut fresh = falling("velocity-verlet");
    sim.steps(50).expect("it goes on");
    sim.set_state(&x, &v).expect("it fits");
    assert_eq!((sim.time(), sim.step_count()), (0.05, 50));
    sim.steps(20).expect("it goes on");
    fresh.steps(20).expect("it goes on");
    assert_eq!(sim.positions(), fresh.positions());
    assert!(matches!(sim.set_state(&x[1..], &v), Err(SimulationError::Shape { found: 5, needed: 6, .. })));
    let mut wrong = x.clone();
    wrong[3][1] = f64::NAN;
    assert!(matches!(sim.set_state(&wrong, &v), Err(SimulationError::NotFinite { row: 3, .. })));
    assert!(matches!(sim.set_wind(Some([1.0; 3])), Err(SimulationError::Unsupported(_))));
    assert_eq!(sim.positions(), fresh.positions());
}

/// A step that diverges is refused: the error says so, and the state is the last good one.
#[test]
fn a_step_that_diverges_is_refused() {
    let settings = RunSpec::fixed("velocity-verlet", 0.2, 20.0).expect("registered");
    let mut sim = Simulation::new(chain().build().expect("a mesh"), settings).expect("it starts");
    let error = sim.steps(100).expect_err("far above the critical step");
    assert!(matches!(&error, SimulationError::Failed(failure) if failure.step == sim.step_count() + 1), "{error}");
    assert!(sim.positions().as_flattened().iter().all(|x| x.is_finite()));
}

/// A run that pauses after every step or block of steps has the bits of one that does not; it stops at a step number,
/// at a time, or where the program says so.
#[test]
fn pauses_change_nothing() {
    for (mut paused, mut whole) in all().into_iter().zip(all()) {
        let mut pauses = 0;
        while paused.run_until_or(u64::MAX, 0.3, || true).expect("it goes on").time < 0.3 - 1e-12 {
            pauses += 1;
        }
        assert!(pauses > 2, "{pauses}");
        whole.run_until(0.3).expect("it goes on");
        assert_same(&paused, &whole);
        let step = paused.step_count();
        assert_eq!(paused.run_until_or(step + 7, f64::INFINITY, || false).expect("it goes on").step, step + 7);
        assert!(matches!(paused.run_until_or(0, f64::NAN, || false), Err(SimulationError::NotFinite { .. })));
    }
}

/// Positions and velocities are written into slices of the program, if they have a row for each node.
#[test]
fn nodes_are_read_into_slices() {
    let mut sim = falling("newmark");
    sim.steps(20).expect("it goes on");
    let (mut x, mut v) = ([[0.0; 3]; 6], [[0.0; 3]; 6]);
    sim.read_nodes(&mut x, &mut v).expect("six nodes");
    assert_eq!((x.to_vec(), v.to_vec()), (sim.positions(), sim.velocities()));
    let refused = sim.read_nodes(&mut x, &mut v[..5]);
    assert!(matches!(refused, Err(SimulationError::Shape { what: "velocities", found: 5, needed: 6 })), "{refused:?}");
    assert_eq!(sim.end(), 1.0);
}
