//! Memory: of mesh files that ask for far more than they hold, and of steps.
//!
//! No allocation in a step after warm-up: explicit schemes, Kang, and Newton with Cholesky or conjugate gradients. LU
//! allocates inside the library.
//!
//! A plain `main` without the test harness, whose own thread allocates beside the measurement.

#[path = "alloc/bombs.rs"]
mod bombs;
mod common;

use canopy_fem::drive::clock::{Step, Tolerance};
use canopy_fem::drive::observer::{AcceptedStep, ObserveError, Observer};
use canopy_fem::drive::run;
use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::integrate::Counters;
use canopy_fem::integrate::implicit::SolverSpec;
use canopy_fem::integrate::registry::{Family, MethodChoice, methods};
use canopy_fem::integrate::stepper::{Attempt, Stepper};
use canopy_fem::model::point::Point;
use canopy_fem::model::spec::*;
use canopy_fem::model::step_block::StepSummary;
use canopy_fem::model::system::{System, longest_block};
use canopy_fem::scene::{Network, Scene, build_network};
use canopy_fem::simulation::{NodalForce, RunSpec, Simulation};
use canopy_fem::solve::LinearChoice;
use canopy_fem::solve::newton::{NewtonSpec, Strategy};
use common::{patch, spring_group, square};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

#[global_allocator]
static ALLOCATOR: dhat::Alloc = dhat::Alloc;

fn scene(with_air: bool) -> Network {
    let mut spec = patch();
    spec.springs = vec![with_dashpots(spring_group(&spec, Slack::TensionOnly))];
    spec.gravity = Some([0.0, 0.0, -9.81]);
    if with_air {
        spec.air = Some(air());
        spec.stream = Some(StreamSpec::of_wind(air().wind));
        spec.canopies = canopy(None);
    }
    build_network(spec, Threads::one()).expect("the fixture is sound")
}

fn canopy(apparent_mass: Option<f64>) -> Vec<CanopySpec> {
    let (triangles, pressure_coefficient) = ((0..6).collect(), vec![1.0; 6]);
    let (skirt, apex, confluence) = (vec![2, 5, 7], vec![0, 1], vec![8]);
    vec![CanopySpec {
        triangles,
        pressure_coefficient,
        skirt,
        apex,
        confluence,
        air: CanopyAir::Coefficient,
        apparent_mass,
        inflow_loss: None,
        glide: None,
        nominal_area: 1.0,
    }]
}

/// A canopy that takes air along, with a balance of the air inside.
fn heavy_canopy() -> Network {
    let mut spec = patch();
    spec.springs = vec![with_dashpots(spring_group(&spec, Slack::TensionOnly))];
    spec.displacement = (0..9).map(|i| [0.0, 0.0, 0.1 * f64::from(i % 4)]).collect();
    spec.stream = Some(StreamSpec::of_wind(air().wind));
    spec.canopies = canopy(Some(1.0));
    let cloth = Some(ClothSpec { linear: 160.0, quadratic: 48.0 });
    let cavity = CavitySpec { inflow: 0.7, outer_pressure_coefficient: -0.6, cloth };
    spec.canopies.iter_mut().for_each(|canopy| canopy.air = CanopyAir::Cavity(cavity));
    build_network(spec, Threads::one()).expect("the fixture is sound")
}

fn with_dashpots(mut group: SpringGroup) -> SpringGroup {
    group.dashpot = Some(DashpotSpec { kind: DashpotKind::Relative, coefficient: 0.5.into(), from_step: false });
    group
}

fn air() -> AirSpec {
    let wind = Series { t: vec![0.0], value: vec![[0.0, 0.0, 5.0]] };
    AirSpec { linear: 1.0, quadratic: 0.5, wind }
}

/// A sheet of springs; one of 5,041 nodes is large, so that force passes go over it strip by strip.
fn sheet(side: u32) -> Network {
    sheet_for(side, Threads::one(), false)
}

fn sheet_for(side: u32, threads: Threads, windy: bool) -> Network {
    let mut spec = square(side, 10.0);
    spec.fixed[0] = [true; 3];
    spec.springs = vec![spring_group(&spec, Slack::None)];
    spec.gravity = Some([0.0, 0.0, -9.81]);
    if windy {
        spec.springs = spec.springs.into_iter().map(with_dashpots).collect();
        spec.air = Some(air());
    }
    build_network(spec, threads).expect("the fixture is sound")
}

/// Heap blocks allocated by `steps` steps after ten steps of warm-up.
fn blocks(scene: &Network, method: &str, steps: u32, (strategy, linear): (Strategy, LinearChoice)) -> u64 {
    let choice = MethodChoice::with_defaults(method).expect("registered");
    let newton = NewtonSpec { strategy, ..NewtonSpec::default() };
    let solver = SolverSpec { newton, linear };
    let mut stepper = Stepper::bind(choice.scheme(solver), scene.interfaces()).expect("a network");
    let mut from = Point { state: scene.initial_state(), forces: scene.new_forces() };
    scene.evaluate(from.state.as_ref(), &mut from.forces);
    stepper.start(&from).expect("a small scene");
    let (mut to, mut counters, h) = (from.clone(), Counters::default(), 1e-3);
    let mut advance = |n: u32| {
        for _ in 0..n {
            let t_next = from.state.t + h;
            stepper.attempt(Attempt { from: &from, h, t_next }, &mut to, &mut counters).expect("an easy step");
            stepper.accept();
            std::mem::swap(&mut from, &mut to);
        }
    };
    advance(10);
    let before = dhat::HeapStats::get().total_blocks;
    advance(steps);
    dhat::HeapStats::get().total_blocks - before
}

/// Heap blocks allocated by five blocks of steps after one: the least of several measurements, because on a busy
/// machine a thread may take part for the first time, and make its buffers, only in a later block.
fn heap_blocks(scene: &Network, method: &str) -> u64 {
    let choice = MethodChoice::with_defaults(method).expect("registered");
    let mut stepper = Stepper::bind(choice.scheme(SolverSpec::default()), scene.interfaces()).expect("a network");
    let mut from = Point { state: scene.initial_state(), forces: scene.new_forces() };
    scene.evaluate(from.state.as_ref(), &mut from.forces);
    let (mut to, mut counters, h) = (from.clone(), Counters::default(), 1e-3);
    let mut summaries = vec![StepSummary::default(); longest_block(scene)];
    let mut advance = |n: u32| {
        for _ in 0..n {
            let t = from.state.t;
            summaries.iter_mut().zip(1..).for_each(|(summary, step)| summary.t = t + f64::from(step) * h);
            let attempt = Attempt { from: &from, h, t_next: summaries.last().map_or(t, |last| last.t) };
            assert!(
                stepper.advance_block(attempt, &mut to, &mut summaries, &mut counters),
                "{method} has blocks of steps"
            );
            std::mem::swap(&mut from, &mut to);
        }
    };
    advance(1);
    let mut measure = || {
        let before = dhat::HeapStats::get().total_blocks;
        advance(5);
        dhat::HeapStats::get().total_blocks - before
    };
    (0..5).map(|_| measure()).min().unwrap_or(0)
}

/// A force that the program computes.
struct Drag;

impl NodalForce for Drag {
    fn add(&self, _t: f64, _x: &[[f64; 3]], v: &[[f64; 3]], f: &mut [[f64; 3]]) {
        f.as_flattened_mut().iter_mut().zip(v.as_flattened()).for_each(|(f, v)| *f -= 1e-3 * v);
    }
}

/// Heap blocks that a simulation with a fixed external force, and with a law, allocates in one call for `steps` steps,
/// after 60: the first block of steps of a length makes its summaries.
fn external_blocks(steps: u64, law: bool) -> u64 {
    let mut spec = square(20, 10.0);
    spec.fixed[0] = [true; 3];
    spec.springs = vec![spring_group(&spec, Slack::None)];
    let push = vec![[0.0, 0.0, 1e-3]; spec.mass.len()];
    let settings = RunSpec::fixed("velocity-verlet", 1e-4, 1.0).expect("registered");
    let mut sim = Simulation::new(spec, settings).expect("a network");
    sim.set_force("push", &push).expect("a network takes forces");
    if law {
        sim.set_force_law("drag", Arc::new(Drag)).expect("a network takes laws");
    }
    sim.steps(60).expect("easy steps");
    let before = dhat::HeapStats::get().total_blocks;
    sim.steps(steps).expect("easy steps");
    dhat::HeapStats::get().total_blocks - before
}

/// Heap blocks at the first accepted step after 60 and after 120, where the run is stopped.
struct Marks<'a> {
    blocks: [u64; 2],
    stop: &'a AtomicBool,
}

impl Observer for Marks<'_> {
    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        for (mark, at) in self.blocks.iter_mut().zip([60, 120]) {
            if step.step >= at && *mark == 0 {
                *mark = dhat::HeapStats::get().total_blocks;
            }
        }
        self.stop.store(self.blocks[1] > 0, Ordering::Relaxed);
        Ok(())
    }
}

/// Heap blocks allocated by 60 adaptive steps after 60 of warm-up.
fn adaptive_blocks(scene: &Network, method: &str) -> u64 {
    let choice = MethodChoice::with_defaults(method).expect("registered");
    let mut stepper = Stepper::bind(choice.scheme(SolverSpec::default()), scene.interfaces()).expect("a network");
    let relative = if choice.order() > 2 { 1e-9 } else { 1e-6 };
    let step = Step::Adaptive(Tolerance { relative, absolute: 0.01 * relative });
    let stop = AtomicBool::new(false);
    let mut marks = Marks { blocks: [0; 2], stop: &stop };
    let spec = RunSpec::of(choice, step, 100.0);
    run(scene, &mut stepper, &spec, &mut [&mut marks], &stop).expect("it starts");
    let [first, last] = marks.blocks;
    assert!(last > 0, "{method} makes 120 steps");
    last - first
}

fn main() {
    bombs::defuse();
    let _profiler = dhat::Profiler::builder().testing().build();
    let (calm, windy, large, heavy) = (scene(false), scene(true), sheet(70), heavy_canopy());
    let full = (Strategy::Full, LinearChoice::Auto);
    for method in methods() {
        assert_eq!(blocks(&calm, method.name, 50, full), 0, "{} on a symmetric scene", method.name);
        assert_eq!(adaptive_blocks(&calm, method.name), 0, "adaptive steps of {}", method.name);
        if method.family != Family::Implicit {
            assert_eq!(blocks(&large, method.name, 5, full), 0, "{} on a large scene", method.name);
            assert_eq!(blocks(&windy, method.name, 50, full), 0, "{} with air", method.name);
            // Methods that solve springs one by one refuse air that joins all nodes.
            let heavy_blocks = || blocks(&heavy, method.name, 50, full);
            let of_heavy = if method.linear.solves_dashpots { 0 } else { heavy_blocks() };
            assert_eq!(of_heavy, 0, "{} with a cavity and an apparent mass", method.name);
        } else {
            let kept = [
                (Strategy::Modified, LinearChoice::Auto),
                (Strategy::Quasi, LinearChoice::Auto),
                (Strategy::Auto, LinearChoice::Cg),
            ];
            for strategy in kept {
                assert_eq!(blocks(&calm, method.name, 50, strategy), 0, "{}, {strategy:?}", method.name);
                assert_eq!(blocks(&windy, method.name, 50, strategy), 0, "{} with air, {strategy:?}", method.name);
            }
            // The tangent of a discrete gradient is not symmetric.
            if method.name != "energy-momentum" {
                let newton = (Strategy::Full, LinearChoice::Cg);
                assert_eq!(blocks(&calm, method.name, 50, newton), 0, "{} by conjugate gradients", method.name);
            }
        }
    }
    // So many nodes that each of two threads has a part of its own in a block.
    let two = || Threads::with_caller(2).expect("threads");
    let (shared, windy_sheet) = (sheet_for(260, two(), false), sheet_for(260, two(), true));
    for method in ["velocity-verlet", "central-difference", "euler-cromer"] {
        assert_eq!(heap_blocks(&windy, method), 0, "blocks of steps of {method} with air");
        assert_eq!(heap_blocks(&windy_sheet, method), 0, "blocks of steps of {method} with air on two threads");
        assert_eq!(heap_blocks(&shared, method), 0, "blocks of steps of {method} on two threads");
        assert_eq!(heap_blocks(&large, method), 0, "blocks of steps of {method}");
        assert_eq!(heap_blocks(&sheet(20), method), 0, "blocks of steps of {method} in the local buffers of one block");
    }
    // Conjugate gradients in two sections, one for each thread. The least of several runs, as above.
    let sections = sheet_for(70, two(), false);
    for strategy in [Strategy::Full, Strategy::Auto] {
        let shared_blocks = || blocks(&sections, "newmark", 5, (strategy, LinearChoice::Cg));
        assert_eq!((0..5).map(|_| shared_blocks()).min(), Some(0), "conjugate gradients on two threads, {strategy:?}");
    }
    for law in [false, true] {
        assert_eq!(
            external_blocks(10, law),
            external_blocks(60, law),
            "steps with an external force, and a law: {law}"
        );
    }
    // The measurement itself sees an allocation when there is one.
    let before = dhat::HeapStats::get().total_blocks;
    drop(std::hint::black_box(vec![0u8; 100]));
    assert_eq!(dhat::HeapStats::get().total_blocks - before, 1, "the counter is dead");
    println!("steps of {} methods allocate nothing", methods().len());
}
