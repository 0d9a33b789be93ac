//! Steps in one go, beside steps one by one.

use super::*;
use crate::force::NodeState;
use crate::force::around::tests::{NODES, Pairs, terms_with};
use crate::force::tiling::Limits;
use crate::model::bounds::Bounds;
use crate::model::forces::Tally;
use crate::model::motion::{Motion, motion};
use crate::model::system::Around;
use rayon::ThreadPoolBuildError;

/// Moves nodes by numbers of their own.
struct Scheme;

impl Around for Scheme {
    fn before(&self, dofs: Range<usize>, x: &mut [f64], v: &mut [f64]) {
        for ((x, v), i) in x.iter_mut().zip(v).zip(dofs) {
            *x += (i as f64).sin();
            *v -= (i as f64).cos();
        }
    }
}

const KICKS: Kicks = Kicks { begin: 0.2, drift: 0.01, end: Some(0.1) };

/// [kg], and [1/kg] with every 50th degree of freedom fixed
fn masses() -> [Vec<f64>; 2] {
    let mass: Vec<f64> = (0..NODES).map(|i| 1.0 + (i % 7) as f64).collect();
    let inverse = (0..3 * NODES).map(|dof| if dof % 50 == 0 { 0.0 } else { 1.0 / mass[dof / 3] }).collect();
    [mass, inverse]
}

/// What is told of all nodes, strip after strip.
fn told(sweep: &Sweep, [x, v, f]: [&[f64]; 3]) -> NodeSums {
    let [mass, _] = masses();
    let of = |strip: usize| {
        let nodes = sweep.tiling.nodes_of(strip..strip + 1);
        let Motion { kinetic, largest_square } = motion(&v[3 * nodes.start..3 * nodes.end], &mass[nodes.clone()]);
        let nodes = nodes.map(|i| [x[3 * i], x[3 * i + 1], x[3 * i + 2]]);
        let bounds = nodes.fold(Bounds::default(), |all, x| all.and(Bounds { low: x, high: x }));
        NodeSums { kinetic, largest_square, bounds, finite: f.iter().all(|f| f.is_finite()) }
    };
    sweep.tiling.strips().map(of).fold(NodeSums::default(), NodeSums::and)
}

/// Sums of forces, state, and what was told of every step.
#[derive(Debug, PartialEq)]
struct Found {
    forces: [Vec<DVec3>; 3],
    x: Vec<f64>,
    v: Vec<f64>,
    told: Vec<(NodeSums, Vec<Tally>)>,
}

impl Found {
    fn start() -> Self {
        let start = |phase: f64| (0..3 * NODES).map(|i| (0.37 * i as f64 + phase).sin()).collect::<Vec<_>>();
        let mut forces = [0; 3].map(|_| vec![DVec3::NAN; NODES]);
        forces[1].clear();
        Found { forces, x: start(0.0), v: start(1.0), told: Vec::new() }
    }
}

fn in_a_stride((terms, sweep): &(Pairs, Sweep), threads: &Threads, steps: usize) -> Found {
    let mut found = Found::start();
    let mut passed = vec![Passed::default(); steps];
    let Found { forces, x, v, told } = &mut found;
    let moving = Moving { t: 0.0, first: 0, x, v, around: &Scheme };
    let [mass, inverse_mass] = masses();
    let between = Between { kicks: KICKS, mass: &mass, inverse_mass: &inverse_mass };
    sweep.stride((terms, moving), between, threads, forces.each_mut().map(Vec::as_mut_slice), &mut passed);
    told.extend(passed.into_iter().map(|passed| (passed.nodes, passed.tallies)));
    found
}

fn one_by_one((terms, sweep): &(Pairs, Sweep), steps: usize) -> Found {
    let mut found = Found::start();
    let Found { forces, x, v, told: of_steps } = &mut found;
    let [_, inverse_mass] = masses();
    let kick = |by: f64, v: &mut [f64], f: &[DVec3]| {
        let f = bytemuck::cast_slice::<_, f64>(f);
        v.iter_mut().zip(f).zip(&inverse_mass).for_each(|((v, f), m)| *v += by * (m * f));
    };
    for step in 0..steps {
        let mut tallies = vec![Tally::default(); 2];
        if step == 0 {
            Scheme.before(0..3 * NODES, x, v);
        } else {
            kick(0.2, v, &forces[0]);
            x.iter_mut().zip(&*v).for_each(|(x, v)| *x += 0.01 * v);
        }
        let at = NodeState { t: 0.0, x: bytemuck::cast_slice(x), v: bytemuck::cast_slice(v) };
        let out = forces.each_mut().map(Vec::as_mut_slice);
        sweep.pass((terms, at), &Threads::one(), out, &mut tallies);
        kick(0.1, v, &forces[0]);
        of_steps.push((told(sweep, [x, v, bytemuck::cast_slice(&forces[0])]), tallies));
    }
    found
}

/// Whatever the tiles, the threads and the number of steps: also where elements reach many strips ahead, so that levels wait for each other, and in one
/// tile whose nodes stay in its windows.
#[test]
fn steps_in_one_go_have_the_bits_of_steps_one_by_one() -> Result<(), ThreadPoolBuildError> {
    for (strip, records, sum_of_links) in [
        (NODES, 900, 0),
        (NODES, 900, 2),
        (250, 600, 2),
        (64, 300, 0),
        (32, 300, 0),
        (16, 300, 2),
        (16, 60, 2),
        (40, 50, 2),
    ] {
        let scene = terms_with(Limits { strip, records }, sum_of_links);
        assert_eq!(scene.1.resides(&scene.0), strip == NODES && sum_of_links == 0);
        for steps in [1, 2, 3, 8] {
            let expected = one_by_one(&scene, steps);
            assert!(expected.forces[0].iter().chain(&expected.forces[2]).all(|f| f.is_finite()));
            for threads in [1, 2, 3, 4] {
                let found = in_a_stride(&scene, &Threads::new(threads)?, steps);
                assert!(found == expected, "{steps} steps, strips of {strip}, {threads} threads");
            }
        }
    }
    Ok(())
}
