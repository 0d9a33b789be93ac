//! The same bytes for every number of threads, for every scheme, with every kind of term.

use crate::common::{spring_group, square};
use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::integrate::Counters;
use canopy_fem::integrate::implicit::SolverSpec;
use canopy_fem::integrate::registry::{MethodChoice, methods};
use canopy_fem::integrate::stepper::{Attempt, Stepper};
use canopy_fem::model::point::Point;
use canopy_fem::model::spec::*;
use canopy_fem::model::system::System;
use canopy_fem::scene::{Scene, build_network};

/// A sheet with every kind of term, of more than one strip of nodes.
fn sheet() -> NetworkSpec {
    let mut spec = square(70, 1e-3);
    spec.fixed[0] = [true; 3];
    let mut group = spring_group(&spec, Slack::TensionOnly);
    let count = group.edges.len();
    group.stiffness = (0..count).map(|i| 50.0 + (i % 7) as f64).collect();
    let mut relative = group.clone();
    let split = count / 2;
    for g in [&mut group, &mut relative] {
        g.dashpot = Some(DashpotSpec { kind: DashpotKind::Axial, coefficient: 1e-3.into(), from_step: false });
    }
    let cut = |g: &mut SpringGroup, range: std::ops::Range<usize>| {
        g.edges = g.edges[range.clone()].to_vec();
        g.stiffness = range.clone().filter_map(|i| g.stiffness.get(i)).collect();
        g.rest_length = g.rest_length[range].to_vec();
    };
    cut(&mut group, 0..split);
    cut(&mut relative, split..count);
    relative.dashpot.iter_mut().for_each(|d| d.kind = DashpotKind::Relative);
    spec.springs = vec![group, relative];
    spec.gravity = Some([0.1, 0.2, -9.81]);
    let wind = Series { t: vec![0.0, 1.0], value: vec![[0.0, 1.0, 5.0], [1.0, 0.0, 8.0]] };
    spec.air = Some(AirSpec { linear: 0.1, quadratic: 0.05, wind });
    let triangles = (0..spec.mesh.triangles.len() as u32).collect();
    let dead = PressureLoad {
        triangles: (100..9000).collect(),
        pressure: 2.0,
        kind: PressureKind::Dead(Some([0.0, 0.6, 0.8])),
        factor: None,
    };
    spec.pressures = vec![PressureLoad { triangles, pressure: 3.0, kind: PressureKind::Follower, factor: None }, dead];
    let nodes = (0..spec.mesh.nodes.len() as u32).step_by(3).collect();
    spec.forces = vec![NodalLoad { nodes, force: [1e-4, 0.0, 2e-4], factor: None }];
    let wind = Series { t: vec![0.0, 1.0], value: vec![[0.0, 1.0, 5.0], [1.0, 0.0, 8.0]] };
    spec.stream = Some(StreamSpec::of_wind(wind));
    spec.canopies = vec![CanopySpec {
        triangles: (500..2500).collect(),
        pressure_coefficient: (500..2500).map(|t| 1.0 + 1e-4 * f64::from(t)).collect(),
        skirt: vec![0, 69, 2000, 4000],
        apex: vec![300],
        confluence: vec![4900, 17],
        air: CanopyAir::Coefficient,
        apparent_mass: None,
        inflow_loss: None,
        glide: None,
        nominal_area: 1.0,
    }];
    let coefficient = Series { t: vec![0.0, 1.5, 3.0], value: vec![0.8, -1.2, -0.3] };
    spec.surface_pressures = vec![SurfacePressureSpec { triangles: (50..9500).collect(), coefficient }];
    spec.line_drag = vec![LineDragSpec { edges: (0..4000).collect(), diameter: 0.01, coefficient: 1.1 }];
    spec.node_drag = vec![NodeDragSpec { nodes: (7..4500).collect(), drag_area: 1e-4, glide: None }];
    spec.rayleigh = Some(RayleighSpec { mass: 0.1, stiffness: 1e-4 });
    spec.membranes = vec![MembraneSpec {
        triangles: (300..8000).collect(),
        thickness: 1e-3,
        modulus: [3e4, 2e4],
        poisson: 0.2,
        shear: 5e3,
        warp: Some([1.0, 0.3, 0.0]),
        wrinkling: true,
        damping_time: 1e-4,
        strength: None,
    }];
    spec
}

fn bits_after(threads: usize, method: &str, steps: u32) -> Vec<u64> {
    let scene = build_network(sheet(), Threads::new(threads).expect("threads")).expect("the fixture is sound");
    let choice = MethodChoice::with_defaults(method).expect("registered");
    let mut stepper = Stepper::bind(choice.scheme(SolverSpec::default()), scene.interfaces()).expect("a network");
    let mut from = Point { state: scene.initial_state(), forces: scene.new_forces() };
    scene.evaluate(from.state.as_ref(), &mut from.forces);
    stepper.start(&from).expect("a small scene");
    let (mut to, mut counters, h) = (from.clone(), Counters::default(), 2e-4);
    for _ in 0..steps {
        let t_next = from.state.t + h;
        stepper.attempt(Attempt { from: &from, h, t_next }, &mut to, &mut counters).expect("an easy step");
        stepper.accept();
        std::mem::swap(&mut from, &mut to);
    }
    let tallies = from.forces.tallies.iter().flat_map(|t| [t.energy, t.power]);
    from.state.x.iter().chain(&from.state.v).copied().chain(tallies).map(f64::to_bits).collect()
}

#[test]
fn one_two_and_three_threads_give_the_same_bits() {
    for method in methods() {
        let steps = if method.evaluations == [0, 0] { 3 } else { 40 };
        let one = bits_after(1, method.name, steps);
        assert!(one.iter().any(|&b| f64::from_bits(b).abs() > 1e-3), "{} moved", method.name);
        for threads in [2, 3] {
            assert!(one == bits_after(threads, method.name, steps), "{} differs with {threads} threads", method.name);
        }
    }
}

/// Sums over all nodes decide on the size of adaptive steps.
#[test]
fn adaptive_steps_are_the_same_for_every_number_of_threads() {
    let tolerance = ("time.tolerance", r#"{"relative": 1e-3, "absolute": 1e-5}"#);
    for method in ["velocity-verlet", "rk4", "generalized-alpha"] {
        // More nodes than are summed in one chunk.
        let sets = [
            ("system.network.mesh.annulus.nodes", "9000"),
            ("system.network.mesh.annulus.boundary_nodes", "450"),
            ("time.step", "null"),
            tolerance,
            ("time.end", "0.004"),
            ("time.method", method),
        ];
        let case = crate::common::run::asset("cloth-k1000", &sets);
        let [one, two] = [1, 2].map(|threads| crate::common::run::run_with(&case, threads));
        assert!(one.outcome.steps > 5, "{method}: {} steps", one.outcome.steps);
        assert_eq!((one.outcome.steps, one.outcome.ledger), (two.outcome.steps, two.outcome.ledger), "{method}");
        let bits = |run: &crate::common::run::Run| {
            run.state.x.iter().chain(&run.state.v).map(|v| v.to_bits()).collect::<Vec<_>>()
        };
        assert!(bits(&one) == bits(&two), "{method} differs with two threads");
    }
}
