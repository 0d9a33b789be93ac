//! What a program changes while a simulation runs: factors of loads and rest lengths, and forces of its own with their
//! derivatives; and two simulations at once.

use canopy_fem::case::spec::SystemSpec;
use canopy_fem::drive::clock::Tolerance;
use canopy_fem::mesh::source::MeshSource;
use canopy_fem::model::spec::{DashpotKind, ReleaseSpec, Slack};
use canopy_fem::simulation::{
    ForceDerivative, Load, NetworkBuilder, NodalForce, RunSpec, Simulation, SimulationError, SpringLaw, build_scene,
    derivative_error,
};
use std::sync::Arc;

const METHODS: [&str; 6] = ["velocity-verlet", "rk4", "newmark", "hht", "improved-euler", "dormand-prince"];

/// A mass of 2 kg on a spring of 8 N/m and 1 m along x: 2 rad/s.
fn mass_on_spring() -> NetworkBuilder {
    NetworkBuilder::new(vec![[0.0; 3], [1.0, 0.0, 0.0]])
        .springs(&[[0, 1]], SpringLaw { stiffness: 8.0, ..SpringLaw::default() })
        .masses(vec![2.0; 2])
        .hold(|node, _| node == 0)
}

fn fixed(network: NetworkBuilder, method: &str, step: f64, end: f64, threads: usize) -> Simulation {
    let settings = RunSpec { threads, ..RunSpec::fixed(method, step, end).expect("registered") };
    Simulation::new(network.build().expect("a mesh"), settings).expect("it starts")
}

fn adaptive(network: NetworkBuilder, method: &str, end: f64) -> Simulation {
    let settings = RunSpec::adaptive(method, Tolerance { relative: 1e-7, absolute: 1e-9 }, end);
    Simulation::new(network.build().expect("a mesh"), settings.expect("registered")).expect("it starts")
}

/// In fixed steps by all methods, and in adaptive ones by two.
fn ways(network: fn() -> NetworkBuilder, end: f64) -> Vec<(&'static str, Simulation)> {
    let fixed = METHODS.map(|method| (method, fixed(network(), method, 1e-3, end, 1)));
    let adaptive = ["newmark", "dormand-prince"].map(|method| (method, adaptive(network(), method, end)));
    fixed.into_iter().chain(adaptive).collect()
}

/// A cloth with springs that go slack, dashpots, gravity and a force, of so many cells a side.
fn cloth(cells: u32) -> NetworkBuilder {
    let rectangle = format!(
        r#"{{"rectangle": {{"width": 1, "height": 1, "columns": {cells}, "rows": {cells}, "pattern": "crossed"}}}}"#
    );
    let mesh = serde_json::from_str::<MeshSource>(&rectangle).expect("a mesh").build(std::path::Path::new("."));
    let dashpot = Some((DashpotKind::Axial, 0.02));
    NetworkBuilder::from_mesh(mesh.expect("a mesh"))
        .springs_on_edges(SpringLaw { stiffness: 300.0, slack: Slack::TensionOnly, dashpot, ..SpringLaw::default() })
        .total_mass(0.2)
        .hold(|_, x| x[0] == 0.0)
        .gravity([0.0, 0.0, -9.81])
        .force(&[3, 5, 9], [0.01, 0.0, 0.02])
}

fn assert_same(a: &Simulation, b: &Simulation) {
    assert_eq!((a.time(), a.step_count(), a.energies()), (b.time(), b.step_count(), b.energies()));
    assert_eq!((a.positions(), a.velocities()), (b.positions(), b.velocities()));
    assert_eq!((a.tensions(), a.reactions()), (b.tensions(), b.reactions()));
}

/// At rest a quarter of the rest length is taken in: x = 0.75 + 0.25 cos(2 t), with 1/2 k 0.25^2 = 0.25 J, all of it
/// external work. Nothing was supplied before, and the watch still does not take it for a divergence. Let out again at
/// a turning point, x = 1, the mass stands still there and the work comes back.
#[test]
fn a_shorter_rest_length_is_work_from_outside() {
    let turn = std::f64::consts::PI;
    for (method, mut sim) in ways(mass_on_spring, 2.0 * turn) {
        sim.set_rest_scale(&[0], 0.75).expect("a spring");
        let at_once = sim.energies();
        assert_eq!((at_once.elastic, at_once.external_work), (0.25, 0.25), "{method}: before the next step");
        sim.run_until(1.3).expect("it goes on");
        let t = sim.time();
        let [x, energies] = [sim.positions()[1][0], sim.energies().kinetic + sim.energies().elastic];
        assert!((x - 0.75 - 0.25 * (2.0 * t).cos()).abs() < 2e-6, "{method}: {x} at {t}");
        assert!((energies - 0.25).abs() < 5e-6 && sim.energies().external_work == 0.25, "{method}: {energies}");
        assert!(sim.energies().numerical.abs() < 5e-6, "{method}: {:?}", sim.energies());
        sim.run_until(turn).expect("it goes on");
        sim.set_rest_scale(&[0], 1.0).expect("a spring");
        sim.run_until(1.5 * turn).expect("it goes on");
        assert!((sim.positions()[1][0] - 1.0).abs() < 4e-3, "{method}: {:?}", sim.positions());
        assert!(sim.energies().numerical.abs() < 5e-6, "{method}: {:?}", sim.energies());
        assert!(sim.energies().external_work.abs() < 6e-3, "{method}: {:?}", sim.energies());
    }
}

/// A mass that hangs at rest, l = 1 + m g/k, swings about 1 + 2 m g/k once weight is doubled. After half a turn weight
/// is as it was: from z = -(1 + 3 m g/k) it swings with 2 m g/k. Both changes and the energies of weight close the
/// account.
#[test]
fn gravity_can_be_scaled() {
    fn hanging() -> NetworkBuilder {
        NetworkBuilder::new(vec![[0.0; 3], [0.0, 0.0, -1.5]])
            .springs(&[[0, 1]], SpringLaw { stiffness: 8.0, rest_length: Some(1.0), ..SpringLaw::default() })
            .masses(vec![2.0; 2])
            .hold(|node, _| node == 0)
            .gravity([0.0, 0.0, -2.0])
    }
    for (method, mut sim) in ways(hanging, 4.0) {
        sim.run_until(0.5).expect("it goes on");
        assert!((sim.positions()[1][2] + 1.5).abs() < 1e-9, "{method}");
        sim.set_load_factor(Load::Gravity, 2.0).expect("a load");
        let doubled = sim.time();
        sim.run_until(2.0).expect("it goes on");
        let (z, t) = (sim.positions()[1][2], sim.time() - doubled);
        assert!((z + 2.0 - 0.5 * (2.0 * t).cos()).abs() < 4e-6, "{method}: {z}");
        assert_eq!(sim.energies().external_work, 0.0, "{method}: energy of weight counts from the start");
        let lowered = -1.5 - z;
        sim.set_load_factor(Load::Gravity, 1.0).expect("a load");
        sim.run_until(3.5).expect("it goes on");
        // Weight of 4 N less, at a node that is so much lower.
        assert!((sim.energies().external_work - 4.0 * lowered).abs() < 1e-12, "{method}: {:?}", sim.energies());
        assert!(sim.energies().numerical.abs() < 1e-5, "{method}: {:?}", sim.energies());
        let amplitude = ((sim.positions()[1][2] + 1.5).powi(2) + (sim.velocities()[1][2] / 2.0).powi(2)).sqrt();
        let before = (z + 1.5, (2.0 * t).sin());
        assert!((amplitude - before.0.hypot(0.5 * before.1)).abs() < 1e-5, "{method}: {amplitude}");
    }
}

/// Force and pressure act with their factors from there on: a free mass under 4 N is at rest after as long under -4 N;
/// under a pressure of 0 nothing moves.
#[test]
fn forces_and_pressures_can_be_scaled() {
    use canopy_fem::model::spec::{PressureKind, PressureLoad};
    for method in METHODS {
        let mut network = NetworkBuilder::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
            .springs(&[[0, 1]], SpringLaw { stiffness: 1e-9, ..SpringLaw::default() })
            .masses(vec![2.0; 3])
            .force(&[0, 1, 2], [0.0, 0.0, 4.0]);
        network.spec.mesh.triangles = vec![[0, 1, 2]];
        for kind in [PressureKind::Follower, PressureKind::Dead(None)] {
            network.spec.pressures.push(PressureLoad { triangles: vec![0], pressure: 24.0, kind, factor: None });
        }
        let mut sim = fixed(network, method, 1e-2, 4.0, 1);
        assert_eq!(sim.load_factors().len(), 3);
        for load in [Load::Pressure(0), Load::Pressure(1)] {
            sim.set_load_factor(load, 0.0).expect("a load");
        }
        sim.run_until(1.0).expect("it goes on");
        sim.set_load_factor(Load::Forces(0), -1.0).expect("a load");
        sim.run_until(2.0).expect("it goes on");
        let (z, v) = (sim.positions()[1][2], sim.velocities()[1][2]);
        assert!((z - 2.0).abs() < 1e-6 && v.abs() < 1e-6, "{method}: {z} {v}");
        // 24 Pa on 1/2 m^2, a third to each node, twice: 8 N.
        sim.set_load_factor(Load::Forces(0), 0.0).expect("a load");
        for load in [Load::Pressure(0), Load::Pressure(1)] {
            sim.set_load_factor(load, 1.0).expect("a load");
        }
        sim.run_until(3.0).expect("it goes on");
        assert!((sim.positions()[1][2] - 4.0).abs() < 1e-6, "{method}: {:?}", sim.positions());
        assert!(sim.energies().numerical.abs() < 1e-6, "{method}: {:?}", sim.energies());
    }
}

/// Factors are in the snapshot: a simulation that is restored goes on with the same bits, and one without factors
/// before gets them; with one thread and with two.
#[test]
fn factors_are_part_of_snapshots() {
    for method in ["velocity-verlet", "newmark", "hht", "kang", "rk4"] {
        for (cells, step, threads) in [(6, 5e-4, [1, 1]), (40, 2e-4, [1, 2])] {
            let [mut sim, mut other] = threads.map(|n| fixed(cloth(cells), method, step, 1.0, n));
            let edges: Vec<u32> = sim.spring_edges().into_iter().step_by(3).collect();
            sim.steps(12).expect("it goes on");
            sim.set_rest_scale(&edges, 0.97).expect("springs");
            sim.set_load_factor(Load::Gravity, 1.5).expect("a load");
            sim.set_load_factor(Load::Forces(0), -0.5).expect("a load");
            sim.steps(11).expect("it goes on");
            let bytes = sim.snapshot().expect("idle");
            sim.steps(13).expect("it goes on");
            other.restore(&bytes).expect("the same scene");
            assert_eq!(other.rest_scales()[edges[1] as usize], 0.97);
            other.steps(13).expect("it goes on");
            assert_same(&sim, &other);
            sim.restore(&bytes).expect("its own");
            sim.steps(13).expect("it goes on");
            assert_same(&sim, &other);
        }
    }
    for method in ["newmark", "velocity-verlet", "dormand-prince"] {
        let [mut sim, mut other] = [(); 2].map(|()| adaptive(cloth(4), method, 0.3));
        sim.steps(9).expect("it goes on");
        sim.set_rest_scale(&[2, 7], 1.1).expect("springs");
        sim.set_load_factor(Load::Gravity, -1.0).expect("a load");
        sim.steps(7).expect("it goes on");
        other.restore(&sim.snapshot().expect("idle")).expect("the same scene");
        for sim in [&mut sim, &mut other] {
            sim.steps(8).expect("it goes on");
        }
        assert_same(&sim, &other);
    }
}

/// A change right before a snapshot is in it; a dropped attempt leaves no trace of steps after a change.
#[test]
fn a_change_meets_snapshots_and_attempts() {
    for method in METHODS {
        let [mut sim, mut other] = [(); 2].map(|()| fixed(cloth(4), method, 5e-4, 1.0, 1));
        for sim in [&mut sim, &mut other] {
            sim.steps(5).expect("it goes on");
        }
        sim.set_rest_scale(&[1, 2, 3], 0.9).expect("springs");
        other.restore(&sim.snapshot().expect("idle")).expect("the same scene");
        sim.attempt().expect("it is made");
        assert!(matches!(sim.set_load_factor(Load::Gravity, 2.0), Err(SimulationError::Attempt { .. })));
        assert!(matches!(sim.set_rest_scale(&[0], 2.0), Err(SimulationError::Attempt { .. })));
        sim.drop_attempt().expect("it waits");
        for sim in [&mut sim, &mut other] {
            sim.steps(5).expect("it goes on");
        }
        assert_same(&sim, &other);
    }
}

/// Free steps of one size have the bits of fixed ones, end at events, and go on from snapshots of either side of one.
#[test]
fn free_steps_are_those_a_program_gives() {
    let (h, event) = (0.5_f64.powi(11), 5.5 * 0.5_f64.powi(11));
    for method in METHODS {
        let mut network = cloth(4).build().expect("a mesh");
        network.releases.push(ReleaseSpec { t: event, nodes: vec![(0, [true; 3])], ..ReleaseSpec::default() });
        let settings = RunSpec::fixed(method, h, 1.0).expect("registered");
        let mut fixed = Simulation::new(network.clone(), settings.clone()).expect("it starts");
        let mut free = Simulation::new(network, RunSpec { free_steps: true, ..settings }).expect("it starts");
        assert!(matches!(fixed.attempt_with_step(h), Err(SimulationError::NotFree)));
        for bad in [0.0, -h, f64::NAN, f64::INFINITY] {
            assert!(matches!(free.attempt_with_step(bad), Err(SimulationError::Run(_))), "{bad}");
        }
        let before = free.snapshot().expect("idle");
        for _ in 0..2 {
            for end in [1.0, 2.0, 3.0, 4.0, 5.0, 5.5] {
                free.attempt_with_step(h).expect("it is made");
                assert_eq!(free.attempted_time(), Some(end * h), "{method}");
                free.accept().expect("it is right");
            }
            let after = free.snapshot().expect("idle");
            free.restore(&before).expect("the same scene");
            assert_eq!(free.time(), 0.0);
            free.restore(&after).expect("the same scene");
            free.attempt_with_step(0.5 * h).expect("it is made");
            free.accept().expect("it is right");
            fixed.run_until(6.0 * h).expect("it goes on");
            assert_eq!((free.time(), free.positions()), (fixed.time(), fixed.positions()), "{method}");
            free.restore(&before).expect("the same scene");
        }
    }
}

/// Wrong factors are refused with their numbers, and change nothing.
#[test]
fn wrong_factors_are_refused() {
    let [mut sim, mut other] = [(); 2].map(|()| fixed(cloth(3), "newmark", 5e-4, 1.0, 1));
    let none = sim.edges().len() as u32;
    assert!(matches!(sim.set_rest_scale(&[0, none], 0.5), Err(SimulationError::NoSpring { edge }) if edge == none));
    for factor in [0.0, -1.0] {
        let refused = sim.set_rest_scale(&[0], factor);
        assert!(matches!(refused, Err(SimulationError::NotPositive { factor: found }) if found == factor));
    }
    for factor in [f64::NAN, f64::INFINITY] {
        let refused = sim.set_rest_scale(&[4], factor);
        assert!(matches!(refused, Err(SimulationError::NotFinite { row: 4, .. })));
        assert!(matches!(sim.set_load_factor(Load::Gravity, factor), Err(SimulationError::NotFinite { .. })));
    }
    assert!(matches!(sim.set_load_factor(Load::Forces(1), 1.0), Err(SimulationError::NoLoad(Load::Forces(1)))));
    assert!(matches!(sim.set_load_factor(Load::Pressure(0), 1.0), Err(SimulationError::NoLoad(_))));
    let held = sim.scene();
    assert!(matches!(sim.set_rest_scale(&[0], 0.5), Err(SimulationError::SceneInUse)));
    drop(held);
    for sim in [&mut sim, &mut other] {
        sim.steps(5).expect("it goes on");
    }
    assert_same(&sim, &other);
}

/// Values that a program sets act in blocks of steps: many steps in one go have the bits of one after the other.
#[test]
fn forces_from_outside_act_in_blocks_of_steps() {
    for (method, cells, threads) in [("velocity-verlet", 5, 1), ("euler-cromer", 40, 2)] {
        let [mut blocks, mut single] = [threads, 1].map(|n| fixed(cloth(cells), method, 2e-4, 1.0, n));
        let mut force = vec![[0.0; 3]; blocks.node_count()];
        for push in [0.01, -0.02] {
            force[7] = [0.0, push, 0.3 * push];
            for sim in [&mut blocks, &mut single] {
                sim.set_force("push", &force).expect("a network");
            }
            blocks.steps(60).expect("it goes on");
            for _ in 0..60 {
                single.step().expect("it goes on");
            }
            assert_same(&blocks, &single);
        }
        assert!(blocks.energies().external_work != 0.0);
    }
}

/// A hardening tether along y from node to node, f = -k d - c d^3, and a drag -b |v| v.
struct Tether {
    k: f64,
    c: f64,
    b: f64,
    derivatives: bool,
}

impl Tether {
    fn dv(&self, v: [f64; 3]) -> [[f64; 3]; 3] {
        let speed = v.iter().map(|v| v * v).sum::<f64>().sqrt();
        let entry = |i: usize, j: usize| {
            let along = if speed > 0.0 { v[i] * v[j] / speed } else { 0.0 };
            -self.b * (along + if i == j { speed } else { 0.0 })
        };
        std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
    }
}

impl NodalForce for Tether {
    fn add(&self, _t: f64, x: &[[f64; 3]], v: &[[f64; 3]], f: &mut [[f64; 3]]) {
        let d = x[1][1] - x[0][1];
        let pull = self.k * d + self.c * d.powi(3);
        f[0][1] += pull;
        f[1][1] -= pull;
        for (f, v) in f.iter_mut().zip(v) {
            let speed = v.iter().map(|v| v * v).sum::<f64>().sqrt();
            (0..3).for_each(|i| f[i] -= self.b * speed * v[i]);
        }
    }

    fn pairs(&self) -> Vec<[u32; 2]> {
        if self.derivatives { vec![[0, 0], [0, 1], [1, 0], [1, 1]] } else { Vec::new() }
    }

    fn derivatives(&self, _t: f64, x: &[[f64; 3]], v: &[[f64; 3]], out: &mut [ForceDerivative]) {
        let slope = self.k + 3.0 * self.c * (x[1][1] - x[0][1]).powi(2);
        for (d, sign) in out.iter_mut().zip([-1.0, 1.0, 1.0, -1.0]) {
            d.position[1][1] = sign * slope;
        }
        out[0].velocity = self.dv(v[0]);
        out[3].velocity = self.dv(v[1]);
    }
}

/// Two masses that a soft spring and the tether connect, apart along y.
fn tethered(tether: Tether, step: f64) -> Simulation {
    let network = NetworkBuilder::new(vec![[0.0; 3], [0.3, 1.0, 0.2]])
        .springs(&[[0, 1]], SpringLaw { stiffness: 1.0, ..SpringLaw::default() })
        .masses(vec![1.0, 2.0]);
    let mut sim = fixed(network, "newmark", step, 10.0, 1);
    sim.set_force_law("tether", Arc::new(tether)).expect("a network");
    sim
}

/// Derivatives are those of the force; where one is wrong or a pair is missing, the check says where.
#[test]
fn derivatives_are_checked_by_differences() {
    struct Wrong(Tether);
    impl NodalForce for Wrong {
        fn add(&self, t: f64, x: &[[f64; 3]], v: &[[f64; 3]], f: &mut [[f64; 3]]) {
            self.0.add(t, x, v, f);
        }
        fn pairs(&self) -> Vec<[u32; 2]> {
            vec![[0, 0], [1, 1]]
        }
        fn derivatives(&self, _t: f64, x: &[[f64; 3]], v: &[[f64; 3]], out: &mut [ForceDerivative]) {
            let mut all = [ForceDerivative::default(); 4];
            self.0.derivatives(0.0, x, v, &mut all);
            (out[0], out[1]) = (all[0], all[3]);
        }
    }
    let tether = || Tether { k: 30.0, c: 40.0, b: 0.7, derivatives: true };
    let (x, v) = ([[0.1, 0.2, 0.3], [0.3, -0.9, 0.4]], [[0.5, 0.1, -0.3], [-0.2, 0.8, 0.4]]);
    let right = derivative_error(&tether(), 0.0, &x, &v);
    assert!(right.relative < 1e-8, "{right:?}");
    let wrong = derivative_error(&Wrong(tether()), 0.0, &x, &v);
    assert!((wrong.relative - 1.0).abs() < 1e-6 && wrong.pair[0] != wrong.pair[1], "{wrong:?}");
}

/// With derivatives Newton squares the error: stiff and nonlinear, it takes a few iterations a step. Without, where the
/// force is soft, it converges to the same motion in more of them; where it is stiff the step is refused, and says why.
#[test]
fn newton_uses_the_derivatives_of_a_law() {
    let run = |k: f64, derivatives: bool| {
        let mut sim = tethered(Tether { k, c: k, b: 0.3, derivatives }, 2e-2);
        let made = sim.steps(50);
        let iterations = sim.counters().newton_iterations as f64 / 50.0;
        (sim, made, iterations)
    };
    let (with, made, few) = run(300.0, true);
    made.expect("it converges");
    let (without, made, many) = run(300.0, false);
    made.expect("it converges");
    assert!(few <= 5.0 && many > 2.0 * few, "{few} and {many}");
    let apart = (with.positions()[1][1] - without.positions()[1][1]).abs();
    assert!(apart < 1e-6, "{apart}");
    let (_, made, few) = run(3e5, true);
    made.expect("it converges");
    assert!(few <= 8.0, "{few}");
    let (_, made, _) = run(3e5, false);
    let error = made.expect_err("the matrix knows nothing of the force");
    assert!(matches!(error, SimulationError::Failed(_)) && error.to_string().contains("converge"), "{error}");
}

/// A law with derivatives may come, go and be replaced while the simulation runs, on a net whose factors are reused
/// too; pairs of nodes that do not exist are refused.
#[test]
fn the_pattern_follows_the_laws() {
    let laws: [fn() -> Option<Tether>; 4] = [
        || Some(Tether { k: 1.0, c: 0.0, b: 0.0, derivatives: true }),
        || None,
        || Some(Tether { k: 2.0, c: 1.0, b: 0.1, derivatives: false }),
        || Some(Tether { k: 1.0, c: 1.0, b: 0.0, derivatives: true }),
    ];
    let run = |method: &str| {
        let mut sim = fixed(cloth(12), method, 2e-4, 1.0, 1);
        for law in laws {
            match law() {
                Some(law) => sim.set_force_law("tether", Arc::new(law)).expect("a network"),
                None => assert!(sim.remove_force("tether").expect("idle")),
            }
            sim.steps(100).expect("it goes on");
        }
        sim
    };
    let (implicit, explicit) = (run("newmark"), run("velocity-verlet"));
    let pairs = implicit.positions().into_iter().zip(explicit.positions());
    let apart = pairs.flat_map(|(a, b)| [0, 1, 2].map(|c| (a[c] - b[c]).abs())).fold(0.0, f64::max);
    assert!(apart < 2e-5, "{apart:e}");

    struct Beyond;
    impl NodalForce for Beyond {
        fn add(&self, _t: f64, _x: &[[f64; 3]], _v: &[[f64; 3]], _f: &mut [[f64; 3]]) {}
        fn pairs(&self) -> Vec<[u32; 2]> {
            vec![[0, 0], [0, 2]]
        }
    }
    let refused = fixed(mass_on_spring(), "newmark", 1e-3, 1.0, 1).set_force_law("beyond", Arc::new(Beyond));
    assert!(matches!(refused, Err(SimulationError::NoNode { place: 1, node: 2, nodes: 2, .. })));
}

/// Two simulations on two threads at the same time write the bytes of those made one after the other: nothing between
/// them is shared. Each has two threads of its own beside, or both have those that a thread's scenes share.
#[test]
fn two_simulations_at_once_are_those_one_after_the_other() {
    fn assert_send<T: Send + 'static>() {}
    assert_send::<Simulation>();
    fn made(method: &str, shared: bool) -> Simulation {
        if !shared {
            return fixed(cloth(40), method, 2e-4, 1.0, 2);
        }
        let network = SystemSpec::Network(Box::new(cloth(40).build().expect("a mesh")));
        let scene = build_scene(network, 2).expect("a scene");
        Simulation::from_scene(&*scene, RunSpec::fixed(method, 2e-4, 1.0).expect("registered")).expect("it starts")
    }
    fn run(mut sim: Simulation) -> Vec<u8> {
        sim.steps(40).expect("it goes on");
        sim.set_rest_scale(&[5, 6], 0.98).expect("springs");
        sim.steps(20).expect("it goes on");
        sim.snapshot().expect("idle")
    }
    for methods in [["velocity-verlet", "newmark"], ["newmark", "newmark"], ["kang", "rk4"]] {
        let alone = methods.map(|method| run(made(method, false)));
        for shared in [false, true] {
            let simulations = methods.map(|method| made(method, shared));
            let at_once = simulations.map(|sim| std::thread::spawn(move || run(sim)));
            assert!(alone == at_once.map(|thread| thread.join().expect("no panic")), "{methods:?} {shared}");
        }
    }
}
