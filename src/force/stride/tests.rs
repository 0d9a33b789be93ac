//! Steps in one go, beside steps one by one.

use super::*;
use crate::force::around::tests::{NODES, damped, terms_with};
use crate::force::tiling::Limits;
use crate::model::bounds::Bounds;
use crate::model::forces::{Forces, Tally};
use crate::model::motion::{Motion, motion};
use crate::model::point::Point;
use crate::model::state::State;
use crate::model::stride::{self, NodeSums};
use crate::model::system::{Around, Onward};
use bytemuck::cast_slice_mut;
use rayon::ThreadPoolBuildError;

const KICKS: Kicks = Kicks { begin: 0.2, drift: 0.01, end: Some(0.1), predicts: false };

/// [kg], and [1/kg] with every 50th degree of freedom fixed
fn masses() -> [Vec<f64>; 2] {
    let mass: Vec<f64> = (0..NODES).map(|i| 1.0 + (i % 7) as f64).collect();
    let inverse = (0..3 * NODES).map(|dof| if dof % 50 == 0 { 0.0 } else { 1.0 / mass[dof / 3] }).collect();
    [mass, inverse]
}

/// A step from a point, as equations.
struct Scheme {
    from: Point,
    kicks: Kicks,
    inverse_mass: Vec<f64>,
}

impl Scheme {
    fn new(from: Point, kicks: Kicks) -> Self {
        let [_, inverse_mass] = masses();
        Scheme { from, kicks, inverse_mass }
    }

    /// Position, velocity and acceleration at the start.
    fn at(&self, i: usize) -> [f64; 3] {
        let Point { state, forces } = &self.from;
        [state.x[i], state.v[i], self.inverse_mass[i] * forces.total[i]]
    }
}

impl Around for Scheme {
    fn before(&self, dofs: Range<usize>, x: &mut [f64], v: &mut [f64]) {
        for ((x, v), i) in x.iter_mut().zip(v).zip(dofs) {
            let ([x_n, v_n, a_n], Kicks { begin, drift, predicts, .. }) = (self.at(i), self.kicks);
            let u = v_n + begin * a_n;
            (*x, *v) = (x_n + drift * u, if predicts { v_n + drift * a_n } else { u });
        }
    }

    fn after(&self, dofs: Range<usize>, v: &mut [f64], f: &[f64]) {
        for ((v, f), i) in v.iter_mut().zip(f).zip(dofs) {
            let [_, v_n, a_n] = self.at(i);
            let u = if self.kicks.predicts { v_n + self.kicks.begin * a_n } else { *v };
            *v = u + self.kicks.end.unwrap_or_default() * (self.inverse_mass[i] * f);
        }
    }
}

impl Onward for Scheme {
    fn kicks(&self) -> Kicks {
        self.kicks
    }

    fn from(&self) -> &Point {
        &self.from
    }
}

/// What a stride leaves, and what was told of every step.
#[derive(Debug, PartialEq)]
struct Found {
    forces: Forces,
    state: State,
    told: Vec<(NodeSums, Vec<Tally>)>,
}

/// A point with sums that are there.
fn start(present: [bool; 2]) -> Point {
    let numbers = |phase: f64| (0..3 * NODES).map(|i| (0.37 * i as f64 + phase).sin()).collect::<Vec<_>>();
    let [external, dissipative] = [2.0, 3.0].map(numbers);
    let [external, dissipative] =
        [(external, present[0]), (dissipative, present[1])].map(|(f, present)| if present { f } else { Vec::new() });
    let forces = Forces { total: numbers(4.0), external, dissipative, ..Forces::default() };
    Point { state: State { t: 0.0, x: numbers(0.0), v: numbers(1.0) }, forces }
}

fn sums(forces: &mut Forces) -> [&mut [DVec3]; SUMS] {
    [&mut forces.total, &mut forces.external, &mut forces.dissipative].map(|sum| cast_slice_mut(sum))
}

/// Where what a stride finds goes: nothing of it is read before.
fn nowhere(like: &Point) -> Point {
    let mut point = like.clone();
    let Point { state: State { x, v, .. }, forces: Forces { total, external, dissipative, .. } } = &mut point;
    [x, v, total, external, dissipative].into_iter().for_each(|numbers| numbers.fill(f64::NAN));
    point
}

fn in_a_stride<T: Terms>(
    (terms, sweep): &(T, Sweep),
    threads: &Threads,
    (kicks, present): (Kicks, [bool; 2]),
    steps: usize,
) -> Found {
    let scheme = Scheme::new(start(present), kicks);
    let mut passed = vec![Passed::default(); steps];
    let Point { mut state, mut forces } = nowhere(&scheme.from);
    let moving = Moving { t: 0.0, first: 0, x: &mut state.x, v: &mut state.v, around: &scheme };
    let [mass, inverse_mass] = masses();
    let between = Between { scheme: &scheme, mass: &mass, inverse_mass: &inverse_mass };
    sweep.stride((terms, moving), between, threads, sums(&mut forces), &mut passed);
    let told = passed.into_iter().map(|passed| (passed.nodes, passed.tallies)).collect();
    Found { forces, state, told }
}

/// What is told of all nodes at the end of a step, strip after strip; where it is the last, their bounds too.
fn told(sweep: &Sweep, from: &Point, to: &Point, last: bool) -> NodeSums {
    let [mass, _] = masses();
    let of = |strip: usize| {
        let nodes = sweep.tiling.nodes_of(strip..strip + 1);
        let dofs = 3 * nodes.start..3 * nodes.end;
        let Motion { kinetic, largest_square } = motion(&to.state.v[dofs.clone()], &mass[nodes.clone()]);
        let half = |forces: &Forces| {
            let of_nodes = |sum: &Vec<f64>| sum.get(dofs.clone()).map_or_else(Vec::new, <[f64]>::to_vec);
            let forces = [&forces.external, &forces.dissipative].map(of_nodes);
            let [before, after] = [from, to].map(|at| &at.state.x[dofs.clone()]);
            stride::Work::of::<3>(forces.each_ref().map(Vec::as_slice), before, after)
        };
        let nodes = nodes.map(|i| [to.state.x[3 * i], to.state.x[3 * i + 1], to.state.x[3 * i + 2]]);
        let nodes = nodes.filter(|_| last);
        let bounds = nodes.fold(Bounds::default(), |all, x| all.and(Bounds { low: x, high: x }));
        let (finite, work) = (true, half(&from.forces).and(half(&to.forces)).halved());
        NodeSums { kinetic, largest_square, bounds, finite, work }
    };
    sweep.tiling.strips().map(of).fold(NodeSums::default(), NodeSums::and)
}

fn one_by_one<T: Terms>((terms, sweep): &(T, Sweep), (kicks, present): (Kicks, [bool; 2]), steps: usize) -> Found {
    let (mut from, mut of_steps) = (start(present), Vec::new());
    for step in 1..=steps {
        let (scheme, mut to) = (Scheme::new(from, kicks), nowhere(&start(present)));
        let mut tallies = vec![Tally::default(); 2];
        let State { x, v, .. } = &mut to.state;
        let out = sums(&mut to.forces);
        if kicks.predicts {
            let moving = Moving { t: 0.0, first: 0, x, v, around: &scheme };
            sweep.pass_twice((terms, moving), &Threads::one(), out, &mut tallies);
        } else {
            scheme.before(0..3 * NODES, x, v);
            let at = NodeState { t: 0.0, x: cast_slice(x), v: cast_slice(v) };
            sweep.pass((terms, at), &Threads::one(), out, &mut tallies);
            scheme.after(0..3 * NODES, v, &to.forces.total);
        }
        of_steps.push((told(sweep, &scheme.from, &to, step == steps), tallies));
        from = to;
    }
    Found { forces: from.forces, state: from.state, told: of_steps }
}

/// Of one strip and of many, of strips with several tiles, and such that elements reach many strips ahead, so that
/// levels wait for each other.
const LIMITS: [(usize, usize); 7] = [(NODES, 900), (250, 600), (64, 300), (32, 300), (16, 300), (16, 60), (40, 50)];

fn assert_same<T: Terms>(
    scene: &(T, Sweep),
    scheme: (Kicks, [bool; 2]),
    what: &str,
) -> Result<(), ThreadPoolBuildError> {
    for steps in [1, 2, 3, 8] {
        let expected = one_by_one(scene, scheme, steps);
        assert!(expected.state.v.iter().chain(&expected.forces.total).all(|f| f.is_finite()));
        for threads in [1, 2, 3, 4] {
            let found = in_a_stride(scene, &Threads::new(threads)?, scheme, steps);
            assert!(found == expected, "{steps} steps, {what}, {threads} threads");
        }
    }
    Ok(())
}

/// Whatever the tiles, the threads and the number of steps, and whichever sums there are.
#[test]
fn steps_in_one_go_have_the_bits_of_steps_one_by_one() -> Result<(), ThreadPoolBuildError> {
    for ((strip, records), sum_of_links) in LIMITS.into_iter().flat_map(|limits| [(limits, 0), (limits, 2)]) {
        let scene = terms_with(Limits { strip, records }, sum_of_links);
        assert_eq!(scene.1.resides(), strip == NODES);
        let (what, dissipates) = (format!("strips of {strip}, links in {sum_of_links}"), sum_of_links == 2);
        assert_same(&scene, (KICKS, [false, dissipates]), &what)?;
        assert_same(&scene, (Kicks { end: None, ..KICKS }, [true, dissipates]), &what)?;
    }
    Ok(())
}

/// The same where velocities are predicted and corrected.
#[test]
fn predicted_steps_in_one_go_have_the_bits_of_steps_one_by_one() -> Result<(), ThreadPoolBuildError> {
    let kicks = Kicks { predicts: true, ..KICKS };
    for (strip, records) in LIMITS {
        let scene = damped(Limits { strip, records }, true);
        for external in [false, true] {
            assert_same(&scene, (kicks, [external, true]), &format!("strips of {strip}, external: {external}"))?;
        }
    }
    Ok(())
}

/// With steps in which forces work, so that the test above compares more than zeros.
#[test]
fn forces_work() {
    let scene = damped(Limits { strip: 40, records: 300 }, true);
    let kicks = Kicks { predicts: true, ..KICKS };
    let found = in_a_stride(&scene, &Threads::one(), (kicks, [true, true]), 2);
    let [first, last] = [0, 1].map(|i| found.told[i].0.work);
    // No term is external, so that it works only by what was there before the first step.
    assert!(first.external != 0.0 && last.external == 0.0, "{first:?}, {last:?}");
    assert!(first.dissipative != 0.0 && last.dissipative != 0.0, "{first:?}, {last:?}");
}
