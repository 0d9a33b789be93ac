//! A velocity-Verlet step of a million nodes beside what the memory can do: a STREAM triad (McCalpin 1995) in the same run, one thread and
//! two, all in turn. Steps one by one, and in strides, with the account that a run takes of each.
//!
//! ```text
//! cargo bench --bench million
//! ```
//! The limits count what a step must move, as STREAM counts: each vector read or written once a pass, over the nodes in two passes or, as a step does
//! it, in one.
//! ```text
//! kick and drift: read x, v, f, 1/m, write x, v        forces and kick: read x, v, 1/m, write f, v        springs: 4 bytes of nodes, 8 of l0
//! in one:         read x, v, f, 1/m, write x, v, f
//! ```

use canopy_fem::force::threads::Threads;
use canopy_fem::integrate::Counters;
use canopy_fem::integrate::implicit::SolverSpec;
use canopy_fem::integrate::registry::MethodChoice;
use canopy_fem::integrate::stepper::{Attempt, Stepper};
use canopy_fem::mesh::source::MeshSource;
use canopy_fem::model::point::Point;
use canopy_fem::model::spec::*;
use canopy_fem::model::stride::{Passed, longest};
use canopy_fem::model::system::System;
use canopy_fem::model::workers::Workers;
use canopy_fem::scene::{Network, Scene, build_network};
use std::collections::BTreeMap;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

const SIDE: u32 = 999;
const ROUNDS: usize = 15;

fn sheet() -> NetworkSpec {
    let json = serde_json::json!({"rectangle": {
        "width": 1.0, "height": 1.0, "columns": SIDE, "rows": SIDE, "pattern": "regular"
    }});
    let source: MeshSource = serde_json::from_value(json).expect("a known generator");
    let mesh = source.build(Path::new(".")).expect("a rectangle");
    let at = |i: u32| glam::DVec3::from_array(mesh.nodes[i as usize]);
    let rest_length = mesh.edges.iter().map(|&[a, b]| at(a).distance(at(b))).collect();
    let m = mesh.edges.len();
    let springs = vec![SpringGroup {
        edges: (0..m as u32).collect(),
        stiffness: vec![1000.0; m],
        rest_length,
        slack: Slack::None,
        dashpot: None,
    }];
    let n = mesh.nodes.len();
    let fixed = mesh.nodes.iter().map(|p| [p[0] < 1e-9; 3]).collect();
    NetworkSpec { mesh, mass: vec![2e-6; n], fixed, springs, gravity: Some([0.0, 0.0, -9.81]), ..Default::default() }
}

struct Steps<'a> {
    stepper: Stepper<'a>,
    from: Point,
    to: Point,
    passed: Vec<Passed>,
    longest: usize,
}

impl<'a> Steps<'a> {
    fn new(scene: &'a Network) -> Self {
        let choice = MethodChoice::new("velocity-verlet", &BTreeMap::new()).expect("registered");
        let mut stepper = Stepper::bind(choice.scheme(SolverSpec::default()), scene.abilities()).expect("a network");
        let mut from = Point { state: scene.initial_state(), forces: scene.new_forces() };
        scene.evaluate(from.state.as_ref(), &mut from.forces);
        stepper.start(&from).expect("explicit");
        let longest = longest(scene.workers());
        Steps { stepper, to: from.clone(), from, passed: vec![Passed::default(); longest], longest }
    }

    fn step(&mut self) {
        let h = 1e-6;
        let attempt = Attempt { from: &self.from, h, t_next: self.from.state.t + h };
        self.stepper.attempt(attempt, &mut self.to, &mut Counters::default()).expect("explicit");
        self.stepper.accept();
        std::mem::swap(&mut self.from, &mut self.to);
    }

    fn stride(&mut self) {
        let h = 1e-6;
        let attempt = Attempt { from: &self.from, h, t_next: self.from.state.t + self.longest as f64 * h };
        assert!(self.stepper.stride(attempt, &mut self.to, &mut self.passed, &mut Counters::default()));
        std::mem::swap(&mut self.from, &mut self.to);
    }
}

/// a = b + 3 c over three vectors far larger than any cache.
struct Triad(Vec<f64>, Vec<f64>, Vec<f64>);

impl Triad {
    fn run(&mut self, workers: &Workers) {
        let Triad(a, b, c) = self;
        workers.each(a, |r, a| {
            for ((a, b), c) in a.iter_mut().zip(&b[r.clone()]).zip(&c[r]) {
                *a = b + 3.0 * c;
            }
            0.0
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

fn main() {
    let build = |n| build_network(sheet(), Threads::new(n).expect("threads")).expect("the fixture is sound");
    let (one, two) = (build(1), build(2));
    let (nodes, springs) = (one.n_dof() / 3, one.force_terms().next().expect("springs").elements());
    let mut steps = [Steps::new(&one), Steps::new(&two)];
    let workers = [Workers::default(), Workers::new(2).expect("threads")];
    let n = 8_000_000;
    let mut triad = Triad(vec![0.0; n], vec![1.0; n], vec![2.0; n]);
    let mut times = [const { Vec::new() }; 6];
    for _ in 0..ROUNDS {
        for i in 0..2 {
            times[i].push(seconds(|| triad.run(&workers[i])));
            times[2 + i].push(seconds(|| steps[i].step()));
            times[4 + i].push(seconds(|| steps[i].stride()) / steps[i].longest as f64);
        }
    }
    let [triad_1, triad_2, step_1, step_2, stride_1, stride_2] = times.map(median);
    let (vector, of_springs) = ((24 * nodes) as f64, 12.0 * springs as f64);
    println!("{nodes} nodes, {springs} springs");
    for (threads, kind, triad, step) in [
        (1, "step", triad_1, step_1),
        (1, "step of a stride", triad_1, stride_1),
        (2, "step", triad_2, step_2),
        (2, "step of a stride", triad_2, stride_2),
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
        "two threads against one: triad {:.2}, step {:.2}, step of a stride {:.2} times as fast",
        triad_1 / triad_2,
        step_1 / step_2,
        stride_1 / stride_2
    );
}
