//! One full Newton iteration (residual, assembly, factorisation, solve) of the 703-node cloth without air, beside the
//! factorisation and solve alone; and whole implicit steps with and without the air.

use crate::fixture::steps::Steps;
use crate::fixture::{Contents, cloth};
use canopy_fem::assembly::TangentSystem;
use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::model::system::{System, Weights};
use canopy_fem::model::workers::ALONE;
use canopy_fem::scene::{Network, build_network};
use canopy_fem::solve::{LinearChoice, solver_for};
use criterion::{Criterion, criterion_group};

/// The weights of a Newmark step of 1 ms.
const W: Weights = Weights { m: 4e6, c: 2e3, k: 1.0 };

fn iteration(c: &mut Criterion) {
    let scene = build_network(cloth(703, 126, Contents::Dashpots), Threads::one()).expect("the fixture is sound");
    let (state, mut forces) = (scene.initial_state(), scene.new_forces());
    let mut assembler = scene.assembler().expect("small");
    let mut solver = solver_for(assembler.pattern.clone(), LinearChoice::Auto, &ALONE).expect("symmetric");
    scene.assemble(state.as_ref(), W, &mut assembler);
    let mut b = vec![1.0; assembler.pattern.n()];
    let mut group = c.benchmark_group("Newton iteration, 703 nodes, no air");
    group.bench_function("factor and solve alone", |bencher| {
        bencher.iter(|| {
            solver.factor(assembler.values()).expect("positive definite");
            b.fill(1.0);
            solver.solve(assembler.values(), &mut b).expect("positive definite");
        });
    });
    group.bench_function("residual, assembly, factor, solve", |bencher| {
        bencher.iter(|| {
            scene.evaluate(state.as_ref(), &mut forces);
            scene.assemble(state.as_ref(), W, &mut assembler);
            solver.factor(assembler.values()).expect("positive definite");
            b.fill(1.0);
            solver.solve(assembler.values(), &mut b).expect("positive definite");
        });
    });
    group.bench_function("assembly alone", |bencher| {
        bencher.iter(|| scene.assemble(state.as_ref(), W, &mut assembler));
    });
    group.finish();
}

fn implicit_steps(c: &mut Criterion) {
    let mut group = c.benchmark_group("newmark step of 1 ms, 703 nodes");
    group.sample_size(20);
    for (name, contents) in [("no air (Cholesky)", Contents::Dashpots), ("air (LU)", Contents::Everything)] {
        let scene = build_network(cloth(703, 126, contents), Threads::one()).expect("the fixture is sound");
        group.bench_function(name, |b| steps(b, &scene));
    }
    group.finish();
}

fn steps(b: &mut criterion::Bencher<'_>, scene: &Network) {
    let mut steps = Steps::new(scene, "newmark", 1e-3);
    b.iter(|| steps.step());
}

criterion_group!(benches, iteration, implicit_steps);
