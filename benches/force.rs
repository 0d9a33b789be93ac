//! Force passes and explicit steps of the 703-node cloth, the spring pass beside a plain C loop compiled in this run
//! with `cc -O3` (left out, with a message, where there is no C compiler).
//!
//! ```text
//! cargo bench -p canopy-fem-benches --bench force
//! ```

mod fixture;

use canopy_fem::force::NodeState;
use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::model::system::System;
use canopy_fem::scene::{Network, build_network};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use fixture::steps::Steps;
use fixture::{Contents, PlainC, cloth};
use nalgebra::Vector3;
use std::hint::black_box;
use std::time::Instant;

/// [s]
const H: f64 = 1e-4;

fn spring_pass(c: &mut Criterion) {
    let arrays = fixture::SpringArrays::of_cloth(703, 126);
    let scene = build_network(cloth(703, 126, Contents::Springs), Threads::one()).expect("the fixture is sound");
    // Springs come first.
    let springs = 0;
    // The same net as the C loop sees it, in the order a scene keeps it in.
    let state = scene.initial_state();
    let raised: Vec<Vector3<f64>> = bytemuck::cast_slice::<f64, Vector3<f64>>(&state.x)
        .iter()
        .map(|p| Vector3::new(p.x, p.y, 0.3 * (1.0 - p.x * p.x - p.y * p.y)))
        .collect();
    let (mut f, mut g) = (vec![Vector3::zeros(); arrays.x.len()], vec![Vector3::zeros(); arrays.x.len()]);
    let mut group = c.benchmark_group("spring pass, 703 nodes");
    group.throughput(Throughput::Elements(arrays.nodes.len() as u64));
    group.bench_function("canopy-fem, with energy", |b| {
        b.iter(|| scene.pass_of(springs, NodeState { t: 0.0, x: black_box(&raised), v: &[] }, &mut f));
    });
    match PlainC::compile() {
        Ok(plain) => {
            group.bench_function("plain C loop, -O3", |b| b.iter(|| plain.spring_forces(black_box(&arrays), &mut f)));
            // On a noisy machine only times taken in turn can be compared.
            let ratio = median_ratio(
                &mut || {
                    let at = NodeState { t: 0.0, x: black_box(&raised), v: &[] };
                    black_box(scene.pass_of(springs, at, black_box(&mut f)));
                },
                &mut || plain.spring_forces(black_box(&arrays), black_box(&mut g)),
            );
            println!("spring pass, 703 nodes: canopy-fem / plain C, taken in turn: {ratio:.3}");
        }
        Err(why) => eprintln!("plain C loop left out: {why}"),
    }
    group.finish();
}

/// Whole steps against each other, taken in turn.
fn ratios(_: &mut Criterion) {
    let build = |contents| build_network(cloth(703, 126, contents), Threads::one()).expect("the fixture is sound");
    let (springs, no_air, all) = (build(Contents::BareSprings), build(Contents::Dashpots), build(Contents::Everything));
    let mut pairs = vec![
        ("kang / explicit-euler, springs", Steps::new(&springs, "kang", H), Steps::new(&springs, "explicit-euler", H)),
        ("kang / explicit-euler, everything", Steps::new(&all, "kang", H), Steps::new(&all, "explicit-euler", H)),
        (
            "velocity-verlet, with air / without",
            Steps::new(&all, "velocity-verlet", H),
            Steps::new(&no_air, "velocity-verlet", H),
        ),
    ];
    for (what, a, b) in &mut pairs {
        println!("step, 703 nodes, {what}, taken in turn: {:.3}", median_ratio(&mut || a.step(), &mut || b.step()));
    }
    if let Ok(plain) = PlainC::compile() {
        let mut arrays = fixture::SpringArrays::of_cloth(703, 126);
        let mut f = vec![Vector3::zeros(); arrays.x.len()];
        let mut verlet = Steps::new(&springs, "velocity-verlet", H);
        let ratio = median_ratio(&mut || verlet.step(), &mut || plain.verlet_step(&mut arrays, &mut f));
        println!("velocity-verlet step, 703 nodes, springs: canopy-fem / plain C, taken in turn: {ratio:.3}");
        let mut made = 0;
        let ratio = median_ratio(&mut || made = verlet.advance_block(), &mut || plain.verlet_step(&mut arrays, &mut f));
        println!("the same, a step of a block with the account of each: {:.3}", ratio / made as f64);
    }
}

/// Nanoseconds an element of every kind of force, taken in turn.
fn passes(_: &mut Criterion) {
    let scene = build_network(cloth(703, 126, Contents::Everything), Threads::one()).expect("the fixture is sound");
    let mut state = scene.initial_state();
    for (i, (x, v)) in state.x.iter_mut().zip(&mut state.v).enumerate() {
        (*x, *v) = (*x + 0.01 * (i as f64).sin(), (i as f64).cos());
    }
    let at = NodeState { t: 0.0, x: bytemuck::cast_slice(&state.x), v: bytemuck::cast_slice(&state.v) };
    let mut f = vec![Vector3::zeros(); 703];
    for (part, info) in scene.terms().iter().enumerate() {
        let Some(found) = scene.term_of(part) else { continue };
        let mut ns: Vec<f64> = (0..200)
            .map(|_| {
                let start = Instant::now();
                (0..20).for_each(|_| _ = black_box(scene.pass_of(part, black_box(at), &mut f)));
                start.elapsed().as_secs_f64() * 1e9 / (20 * found.term.elements()) as f64
            })
            .collect();
        ns.sort_unstable_by(f64::total_cmp);
        println!("{:20} {:6.2} ns an element, least {:6.2}", info.name, ns[100], ns[0]);
    }
}

/// Median over 400 rounds of the time of `a` over that of `b`, 20 calls each a round.
fn median_ratio(a: &mut dyn FnMut(), b: &mut dyn FnMut()) -> f64 {
    let time = |f: &mut dyn FnMut()| {
        let start = Instant::now();
        (0..20).for_each(|_| f());
        start.elapsed().as_secs_f64()
    };
    let mut ratios: Vec<f64> = (0..400).map(|_| time(a) / time(b)).collect();
    ratios.sort_unstable_by(f64::total_cmp);
    ratios[ratios.len() / 2]
}

fn explicit_steps(c: &mut Criterion) {
    let mut group = c.benchmark_group("explicit step, 703 nodes");
    for (name, contents) in [("springs", Contents::Springs), ("springs, dashpots, air, gravity", Contents::Everything)]
    {
        let scene = build_network(cloth(703, 126, contents), Threads::one()).expect("the fixture is sound");
        for method in ["velocity-verlet", "rk4", "kang"] {
            group.bench_function(format!("{method}: {name}"), |b| steps(b, &scene, method));
        }
    }
    if let Ok(plain) = PlainC::compile() {
        let mut arrays = fixture::SpringArrays::of_cloth(703, 126);
        let mut f = vec![Vector3::zeros(); arrays.x.len()];
        group
            .bench_function("velocity-verlet: plain C, springs", |b| b.iter(|| plain.verlet_step(&mut arrays, &mut f)));
    }
    group.finish();
}

fn steps(b: &mut criterion::Bencher<'_>, scene: &Network, method: &str) {
    let mut steps = Steps::new(scene, method, H);
    b.iter(|| steps.step());
}

criterion_group!(benches, spring_pass, passes, ratios, explicit_steps);
criterion_main!(benches);
