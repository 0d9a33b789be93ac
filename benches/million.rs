//! A velocity-Verlet step of a million nodes beside what the memory can do: a STREAM triad (McCalpin 1995) in the same
//! run, one thread and two, all in turn. Steps one by one, and in blocks of steps, with the summary of each that a run
//! takes.
//!
//! ```text
//! cargo bench -p canopy-fem-benches --bench million
//! cargo bench -p canopy-fem-benches --bench million -- --svg roofline.svg     # the roofline too
//! ```
//! The limits count what a step must move, as STREAM counts: each vector read or written once a pass, over the nodes in
//! two passes or, as a step does it, in one.
//! ```text
//! kick and drift: read x, v, f, 1/m, write x, v        forces and kick: read x, v, 1/m, write f, v        springs: 4 bytes of nodes, 8 of l0
//! in one:         read x, v, f, 1/m, write x, v, f
//! ```
//! The roofline (Williams, Waterman & Patterson 2009) has operations over time above operations over bytes. Its slopes
//! are the triads, its ceilings what steps reach whose scene stays in the caches. A root and a quotient count as one
//! operation each. Steps of a block cross memory together.

mod fixture;

use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::model::system::System;
use canopy_fem::model::workers::Workers;
use canopy_fem::plot::chart::{Align, Axis, Chart, Line, Marker, Note, Stroke};
use canopy_fem::scene::build_network;
use fixture::figure::{draw, wanted};
use fixture::sheet::sheet;
use fixture::steps::Steps;
use std::hint::black_box;
use std::time::Instant;

const SIDE: u32 = 999;
/// Nodes along a side of a scene that stays in the caches, less one.
const CACHED: u32 = 39;
const ROUNDS: usize = 15;

/// a = b + 3 c over three vectors far larger than any cache.
struct Triad(Vec<f64>, Vec<f64>, Vec<f64>);

impl Triad {
    fn run(&mut self, workers: &Workers) {
        let Triad(a, b, c) = self;
        workers.set(a, |r, a| {
            for ((a, b), c) in a.iter_mut().zip(&b[r.clone()]).zip(&c[r]) {
                *a = b + 3.0 * c;
            }
        });
        black_box(a);
    }
}

fn seconds(f: impl FnOnce()) -> f64 {
    let start = Instant::now();
    f();
    start.elapsed().as_secs_f64()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Operations of a spring: difference, length, tension, forces on both ends, energy.
const OF_A_SPRING: f64 = 24.0;
/// Operations of a node: acceleration, two kicks, drift, weight, kinetic energy and that of its weight.
const OF_A_NODE: f64 = 43.0;

/// What a thread, or two, can do and does.
struct Reached {
    threads: usize,
    /// [B/s] of the triad
    rate: f64,
    /// [1/s] operations in the caches
    ceiling: f64,
    /// [1/B] and [1/s] of steps one by one and in a block
    points: [(f64, f64); 2],
}

/// [1/s] Operations of steps whose scene stays in the caches, on one thread.
fn in_caches() -> f64 {
    let scene = build_network(sheet(CACHED, 2e-3), Threads::one()).expect("the fixture is sound");
    let mut steps = Steps::new(&scene, "velocity-verlet", 1e-5);
    let mut of_one = || {
        let mut made = 0;
        let time = seconds(|| made = (0..20).map(|_| steps.advance_block()).sum());
        made as f64 * operations(&scene) / time
    };
    median((0..ROUNDS).map(|_| of_one()).collect())
}

fn operations(scene: &canopy_fem::scene::Network) -> f64 {
    let springs = scene.force_terms().next().expect("springs").elements();
    OF_A_SPRING * springs as f64 + OF_A_NODE * (scene.n_dof() / 3) as f64
}

fn roofline(reached: &[Reached]) -> Chart {
    let (least, most) = (0.05, 20.0);
    let lines = reached.iter().flat_map(|r| {
        let corner = r.ceiling / r.rate;
        let threads = if r.threads == 1 { "one thread" } else { "two threads" };
        let roof = vec![(least, least * r.rate), (corner, r.ceiling), (most, r.ceiling)];
        let marker = if r.threads == 1 { Marker::Dot } else { Marker::Square };
        [
            Line { stroke: Stroke::Fine, ..Line::new(format!("{threads}: the limit"), roof) },
            Line { points: r.points.to_vec(), stroke: Stroke::None, marker, ..Line::default() },
        ]
    });
    let note = |(x, y): (f64, f64), text: &str| Note { at: (x, y), text: text.into(), align: Align::RightBelow };
    let [alone, together] = reached[0].points;
    Chart {
        x: Axis { range: Some((least, most)), ..Axis::log("operations a byte that crosses memory [1/B]") },
        y: Axis::log("operations a second [1/s]"),
        lines: lines.collect(),
        notes: vec![note(alone, "steps one by one"), note(together, "in blocks of steps")],
        ..Chart::default()
    }
}

fn main() {
    let picture = wanted();
    let build =
        |n| build_network(sheet(SIDE, 2e-6), Threads::with_caller(n).expect("threads")).expect("the fixture is sound");
    let (one, two) = (build(1), build(2));
    let (nodes, springs) = (one.n_dof() / 3, one.force_terms().next().expect("springs").elements());
    let mut steps = [&one, &two].map(|scene| Steps::new(scene, "velocity-verlet", 1e-6));
    let workers = [Workers::default(), Workers::with_caller(2).expect("threads")];
    let n = 8_000_000;
    let mut triad = Triad(vec![0.0; n], vec![1.0; n], vec![2.0; n]);
    let (mut times, mut longest) = ([const { Vec::new() }; 6], 0);
    for _ in 0..ROUNDS {
        for i in 0..2 {
            times[i].push(seconds(|| triad.run(&workers[i])));
            times[2 + i].push(seconds(|| steps[i].step()));
            let mut made = 0;
            let block = seconds(|| made = steps[i].advance_block());
            times[4 + i].push(block / made as f64);
            longest = made;
        }
    }
    let [triad_1, triad_2, step_1, step_2, block_1, block_2] = times.map(median);
    let (vector, of_springs) = ((24 * nodes) as f64, 12.0 * springs as f64);
    println!("{nodes} nodes, {springs} springs");
    for (threads, kind, triad, step) in [
        (1, "step", triad_1, step_1),
        (1, "step of a block", triad_1, block_1),
        (2, "step", triad_2, step_2),
        (2, "step of a block", triad_2, block_2),
    ] {
        let rate = (24 * n) as f64 / triad;
        let [two_passes, one_pass] = [11.0, 7.0].map(|vectors| (vectors * vector + of_springs) / rate);
        println!(
            "{threads} thread(s): triad {:.1} GB/s, {kind} {:.1} ms, limit of two passes {:.1} ms: {:.0} % of it, of one {:.1} ms: {:.0} %",
            rate / 1e9,
            1e3 * step,
            1e3 * two_passes,
            100.0 * two_passes / step,
            1e3 * one_pass,
            100.0 * one_pass / step
        );
    }
    println!(
        "two threads against one: triad {:.2}, step {:.2}, step of a block {:.2} times as fast",
        triad_1 / triad_2,
        step_1 / step_2,
        block_1 / block_2
    );
    draw(picture, || {
        let (operations, bytes, in_caches) = (operations(&one), 7.0 * vector + of_springs, in_caches());
        let point = |step: f64, crossings: f64| (operations / (bytes * crossings), operations / step);
        let of = |threads, triad: f64, [step, block]: [f64; 2]| Reached {
            threads,
            rate: (24 * n) as f64 / triad,
            // Every thread could have a scene of its own.
            ceiling: threads as f64 * in_caches,
            points: [point(step, 1.0), point(block, 1.0 / longest as f64)],
        };
        roofline(&[of(1, triad_1, [step_1, block_1]), of(2, triad_2, [step_2, block_2])])
    });
}
