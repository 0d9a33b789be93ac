//! Blocks of steps, and single steps, beside force passes and the scheme's equations one after the other.

use super::*;
use crate::force::kernel::batch::{Batch, BlockForces, BufferReads, Elements, Kernel, PARTS, Records};
use crate::force::kernel::element_block::ElementBlock;
use crate::force::kernel::local_buffer::{record, set_record};
use crate::force::law::curve::CurveKind;
use crate::force::law::damped_springs::{DampedSprings, Dashpots};
use crate::force::law::spring::{Coefficient, SpringData};
use crate::force::schedule::partition::Limits;
use crate::force::schedule::terms::{PartTarget, Term};
use crate::model::bounds::Bounds;
use crate::model::forces::Forces;
use crate::model::motion::{Motion, motion};
use crate::model::point::Point;
use crate::model::spec::{DashpotKind, Slack};
use crate::model::state::State;
use crate::model::step_block::{self, KickDriftScheme, NodeSums};
use crate::model::system::KickDriftBlock;
use bytemuck::cast_slice;
use bytemuck::cast_slice_mut;
use rayon::ThreadPoolBuildError;
use std::sync::atomic::{AtomicUsize, Ordering};

pub const NODES: usize = 800;

/// Links by their ends: they add to either end half of what is at the other.
pub struct LinkData(Vec<[u32; 2]>);

/// A batch of links.
pub type Links = Batch<LinkData, 2>;

pub fn links(nodes: Vec<[u32; 2]>) -> Links {
    Batch::new(LinkData(nodes))
}

impl Kernel<2> for LinkData {
    const READS: BufferReads = BufferReads { x: true, v: false };

    fn elements(&self) -> &[[u32; 2]] {
        &self.0
    }

    fn add(&self, block: Elements<'_, 2>, f: &mut Records) -> Tally {
        for &[a, b] in block.nodes {
            for (own, other) in [(a, b), (b, a)] {
                let (sum, x) = (record(f, own), record(block.x, other));
                set_record(f, own, std::array::from_fn(|i| sum[i] + 0.5 * x[i]));
            }
        }
        Tally::default()
    }
}

fn springs(nodes: Vec<[u32; 2]>) -> SpringData {
    let rest_length = vec![0.3; nodes.len()].into();
    SpringData {
        rest_length,
        nodes: nodes.into(),
        stiffness: Coefficient::Uniform(5.0),
        curve: CurveKind::Linear,
        slack: Slack::None,
        rest_scale: None,
    }
}

/// Dashpots of 2 N s/m as the second part of springs.
pub fn relative_dashpots(nodes: Vec<[u32; 2]>) -> DampedSprings {
    let dashpots = Dashpots { kind: DashpotKind::Relative, coefficient: Coefficient::Uniform(2.0) };
    DampedSprings::new(springs(nodes), Some(dashpots))
}

/// Springs to the node after the next 30 in the first sum, links to the next node in the first or in the last.
struct Pairs {
    springs: DampedSprings,
    links: Links,
    sum_of_links: usize,
}

impl Terms for Pairs {
    fn count(&self) -> usize {
        2
    }

    fn tallies(&self) -> usize {
        2
    }

    fn term(&self, i: usize) -> Term<'_> {
        let part = |sum| [Some(PartTarget { sum, tally: i }), None];
        match i {
            0 => Term { forces: &self.springs, parts: part(0) },
            _ => Term { forces: &self.links, parts: part(self.sum_of_links) },
        }
    }
}

fn terms_with(limits: Limits, sum_of_links: usize) -> (Pairs, Sweep) {
    let apart = |by: u32| (0..NODES as u32 - by).map(|i| [i, i + by]).collect();
    let springs = DampedSprings::new(springs(apart(31)), None);
    let mut terms = Pairs { springs, links: links(apart(1)), sum_of_links };
    let partition = Partition::within(limits, NODES, &mut [&mut terms.springs, &mut terms.links]);
    (terms, Sweep::of(partition))
}

/// Springs in the first sum, which count the blocks they are asked for, and their dashpots in the last.
struct Damped {
    springs: Counted,
    is_position_only: bool,
}

struct Counted(DampedSprings, AtomicUsize);

impl BlockForces for Counted {
    fn elements(&self) -> usize {
        self.0.elements()
    }

    fn reads(&self, parts: [bool; PARTS]) -> BufferReads {
        self.0.reads(parts)
    }

    fn element(&self, number: usize) -> Option<&[u32]> {
        self.0.element(number)
    }

    fn assign_block(&mut self, block: usize, elements: Range<usize>, place: &dyn Fn(u32) -> u16) {
        self.0.assign_block(block, elements, place);
    }

    fn add(&self, block: &ElementBlock<'_>, sums: [Option<&mut Records>; PARTS]) -> [Tally; PARTS] {
        self.1.fetch_add(usize::from(sums[0].is_some()), Ordering::Relaxed);
        self.0.add(block, sums)
    }
}

impl Terms for Damped {
    fn count(&self) -> usize {
        1
    }

    fn tallies(&self) -> usize {
        2
    }

    fn term(&self, _: usize) -> Term<'_> {
        let parts = [(0, 0), (2, 1)].map(|(sum, tally)| Some(PartTarget { sum, tally }));
        Term { forces: &self.springs, parts }
    }

    fn is_position_only(&self) -> bool {
        self.is_position_only
    }
}

fn damped(limits: Limits, is_position_only: bool) -> (Damped, Sweep) {
    let nodes = (0..NODES as u32 - 31).map(|i| [i, i + 31]).collect();
    let springs = Counted(relative_dashpots(nodes), AtomicUsize::new(0));
    let mut terms = Damped { springs, is_position_only };
    let partition = Partition::within(limits, NODES, &mut [&mut terms.springs]);
    (terms, Sweep::of(partition))
}

const KICKS: KickDriftScheme = KickDriftScheme { begin: 0.2, drift: 0.01, end: Some(0.1), predicts: false };

/// [kg], and [1/kg] with every 50th degree of freedom fixed
fn masses() -> [Vec<f64>; 2] {
    let mass: Vec<f64> = (0..NODES).map(|i| 1.0 + (i % 7) as f64).collect();
    let inverse = (0..3 * NODES).map(|dof| if dof % 50 == 0 { 0.0 } else { 1.0 / mass[dof / 3] }).collect();
    [mass, inverse]
}

/// Where a step's first pass finds nodes, as equations.
fn begun(from: &Point, scheme: KickDriftScheme, to: &mut State) {
    let [_, inverse_mass] = masses();
    for (i, inverse_mass) in inverse_mass.into_iter().enumerate() {
        let (v_n, a_n) = (from.state.v[i], inverse_mass * from.forces.total[i]);
        let u = v_n + scheme.begin * a_n;
        to.x[i] = from.state.x[i] + scheme.drift * u;
        to.v[i] = if scheme.predicts { v_n + scheme.drift * a_n } else { u };
    }
}

/// The kick after it.
fn kicked(from: &Point, scheme: KickDriftScheme, v: &mut [f64], f: &[f64]) {
    let [_, inverse_mass] = masses();
    for (i, inverse_mass) in inverse_mass.into_iter().enumerate() {
        let a_n = inverse_mass * from.forces.total[i];
        let u = if scheme.predicts { from.state.v[i] + scheme.begin * a_n } else { v[i] };
        v[i] = u + scheme.end.unwrap_or_default() * (inverse_mass * f[i]);
    }
}

/// What a block leaves, and the summary of every step.
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

fn sums(forces: &mut Forces) -> [&mut [Vector3<f64>]; SUMS] {
    [&mut forces.total, &mut forces.external, &mut forces.dissipative].map(|sum| cast_slice_mut(sum))
}

/// Where what a block finds goes: nothing of it is read before.
fn nowhere(like: &Point) -> Point {
    let mut point = like.clone();
    let Point { state: State { x, v, .. }, forces: Forces { total, external, dissipative, .. } } = &mut point;
    [x, v, total, external, dissipative].into_iter().for_each(|numbers| numbers.fill(f64::NAN));
    point
}

/// Steps in one block; without summaries a single step.
fn in_a_block<T: Terms>(
    (terms, sweep): &(T, Sweep),
    threads: &Threads,
    (scheme, from): (KickDriftScheme, &Point),
    summaries: usize,
) -> (Found, Vec<Tally>) {
    let (mut summaries, mut tallies) = (vec![StepSummary::default(); summaries], vec![Tally::default(); 2]);
    let Point { mut state, mut forces } = nowhere(from);
    let moving = NodeStateMut { t: 0.0, first: 0, x: &mut state.x, v: &mut state.v };
    let [mass, inverse_mass] = masses();
    let block = KickDriftBlock { scheme, from };
    let boundary = StepBoundary { block, mass: &mass, inverse_mass: &inverse_mass };
    let results = StepBlockResults { sums: sums(&mut forces), tallies: &mut tallies, summaries: &mut summaries };
    sweep.advance(terms, moving, boundary, threads, results);
    let told = summaries.into_iter().map(|summary| (summary.nodes, summary.tallies)).collect();
    (Found { forces, state, told }, tallies)
}

/// Sums over all nodes at the end of a step, node block after node block; where it is the last, their bounds too.
fn told(sweep: &Sweep, from: &Point, to: &Point, last: bool) -> NodeSums {
    let [mass, _] = masses();
    let of = |node_block: usize| {
        let nodes = sweep.partition.nodes_of(node_block..node_block + 1);
        let dofs = 3 * nodes.start..3 * nodes.end;
        let Motion { kinetic, largest_square } = motion(&to.state.v[dofs.clone()], &mass[nodes.clone()]);
        let half = |forces: &Forces| {
            let of_nodes = |sum: &Vec<f64>| sum.get(dofs.clone()).map_or_else(Vec::new, <[f64]>::to_vec);
            let forces = [&forces.external, &forces.dissipative].map(of_nodes);
            let [before, after] = [from, to].map(|at| &at.state.x[dofs.clone()]);
            step_block::Work::of::<3>(forces.each_ref().map(Vec::as_slice), before, after)
        };
        let nodes = nodes.map(|i| [to.state.x[3 * i], to.state.x[3 * i + 1], to.state.x[3 * i + 2]]);
        let nodes = nodes.filter(|_| last);
        let bounds = nodes.fold(Bounds::default(), |all, x| all.and(Bounds { low: x, high: x }));
        let (finite, work) = (true, half(&from.forces).and(half(&to.forces)).halved());
        NodeSums { kinetic, largest_square, bounds, finite, work }
    };
    sweep.partition.node_blocks().map(of).fold(NodeSums::default(), NodeSums::and)
}

/// Single steps, and what their summaries are to hold.
fn one_by_one<T: Terms>(scene: &(T, Sweep), (scheme, present): (KickDriftScheme, [bool; 2]), steps: usize) -> Found {
    let (mut from, mut of_steps) = (start(present), Vec::new());
    for step in 1..=steps {
        let (Found { state, forces, .. }, tallies) = in_a_block(scene, &Threads::one(), (scheme, &from), 0);
        let to = Point { state, forces };
        of_steps.push((told(&scene.1, &from, &to, step == steps), tallies));
        from = to;
    }
    Found { forces: from.forces, state: from.state, told: of_steps }
}

/// Of one node block and of many, of node blocks with several blocks, and such that elements reach many node blocks
/// ahead, so that levels wait for each other.
const LIMITS: [(usize, usize); 7] = [(NODES, 900), (250, 600), (64, 300), (32, 300), (16, 300), (16, 60), (40, 50)];

fn assert_same<T: Terms>(
    scene: &(T, Sweep),
    scheme: (KickDriftScheme, [bool; 2]),
    what: &str,
) -> Result<(), ThreadPoolBuildError> {
    for steps in [1, 2, 3, 8] {
        let expected = one_by_one(scene, scheme, steps);
        assert!(expected.state.v.iter().chain(&expected.forces.total).all(|f| f.is_finite()));
        for threads in [1, 2, 3, 4] {
            let (found, tallies) = in_a_block(scene, &Threads::new(threads)?, (scheme.0, &start(scheme.1)), steps);
            assert!(
                found == expected && found.told.last().is_some_and(|(_, last)| *last == tallies),
                "{steps} steps, {what}, {threads} threads"
            );
        }
    }
    Ok(())
}

/// Whatever the blocks, the threads and the number of steps, and whichever sums there are.
#[test]
fn steps_in_one_go_have_the_bits_of_steps_one_by_one() -> Result<(), ThreadPoolBuildError> {
    for ((node_block, records), sum_of_links) in LIMITS.into_iter().flat_map(|limits| [(limits, 0), (limits, 2)]) {
        let scene = terms_with(Limits { node_block, records }, sum_of_links);
        assert_eq!(scene.1.is_single_block(), node_block == NODES);
        let (what, dissipates) = (format!("node blocks of {node_block}, links in {sum_of_links}"), sum_of_links == 2);
        assert_same(&scene, (KICKS, [false, dissipates]), &what)?;
        assert_same(&scene, (KickDriftScheme { end: None, ..KICKS }, [true, dissipates]), &what)?;
    }
    Ok(())
}

/// The same where velocities are predicted and corrected.
#[test]
fn predicted_steps_in_one_go_have_the_bits_of_steps_one_by_one() -> Result<(), ThreadPoolBuildError> {
    let kicks = KickDriftScheme { predicts: true, ..KICKS };
    for (node_block, records) in LIMITS {
        let scene = damped(Limits { node_block, records }, true);
        for external in [false, true] {
            assert_same(
                &scene,
                (kicks, [external, true]),
                &format!("node blocks of {node_block}, external: {external}"),
            )?;
        }
    }
    Ok(())
}

/// With steps in which forces work, so that the test above compares more than zeros.
#[test]
fn forces_work() {
    let scene = damped(Limits { node_block: 40, records: 300 }, true);
    let kicks = KickDriftScheme { predicts: true, ..KICKS };
    let (found, _) = in_a_block(&scene, &Threads::one(), (kicks, &start([true, true])), 2);
    let [first, last] = [0, 1].map(|i| found.told[i].0.work);
    // No term is external, so that it works only by what was there before the first step.
    assert!(first.external != 0.0 && last.external == 0.0, "{first:?}, {last:?}");
    assert!(first.dissipative != 0.0 && last.dissipative != 0.0, "{first:?}, {last:?}");
}

/// The largest difference of two results, in terms of what is there.
fn apart(a: &Found, b: &Found) -> f64 {
    let numbers = |Found { forces, state, .. }: &Found| {
        let all = [&forces.total, &forces.dissipative, &state.x, &state.v];
        all.into_iter().flatten().copied().collect::<Vec<f64>>()
    };
    let off = |(a, b): (f64, f64)| (a - b).abs() / (1.0 + b.abs());
    numbers(a).into_iter().zip(numbers(b)).map(off).fold(0.0, f64::max)
}

/// A step as equations with whole passes between, of which the last is summarised.
fn apart_from_passes<T: Terms>(
    (terms, sweep): &(T, Sweep),
    (scheme, from): (KickDriftScheme, &Point),
) -> (Found, Vec<Tally>) {
    let (Point { mut state, mut forces }, mut tallies) = (nowhere(from), vec![Tally::default(); 2]);
    let mut pass = |State { x, v, .. }: &State, forces: &mut Forces| {
        let at = NodeState { t: 0.0, x: cast_slice(x), v: cast_slice(v) };
        sweep.pass(terms, at, &Threads::one(), sums(forces), &mut tallies);
    };
    begun(from, scheme, &mut state);
    pass(&state, &mut forces);
    kicked(from, scheme, &mut state.v, &forces.total);
    if scheme.predicts {
        pass(&state, &mut forces);
    }
    (Found { forces, state, told: Vec::new() }, tallies)
}

/// Whatever the blocks and threads, a single step has the bits of whole passes and of the scheme's equations one after
/// the other.
#[test]
fn a_single_step_has_the_bits_of_its_equations() -> Result<(), ThreadPoolBuildError> {
    for (node_block, records) in LIMITS {
        let scene = terms_with(Limits { node_block, records }, 2);
        let from = start([false, true]);
        for scheme in [KICKS, KickDriftScheme { end: None, ..KICKS }] {
            let expected = apart_from_passes(&scene, (scheme, &from));
            for threads in [1, 2, 3] {
                let found = in_a_block(&scene, &Threads::new(threads)?, (scheme, &from), 0);
                assert!(found == expected, "node blocks of {node_block}, {threads} threads, {scheme:?}");
            }
        }
    }
    Ok(())
}

/// The same where velocities are predicted, but for the order in which the first pass adds forces. Terms that depend on
/// position alone are asked once a step, others twice; the second pass has every bit of one alone, so that a run can go
/// on from its end.
#[test]
fn a_second_pass_goes_over_what_velocities_change() -> Result<(), ThreadPoolBuildError> {
    let scheme = KickDriftScheme { predicts: true, ..KICKS };
    for ((node_block, records), is_position_only) in
        LIMITS.into_iter().flat_map(|limits| [(limits, true), (limits, false)])
    {
        let (scene, from) = (damped(Limits { node_block, records }, is_position_only), start([false, true]));
        let asked = || scene.0.springs.1.swap(0, Ordering::Relaxed);
        let (expected, _) = apart_from_passes(&scene, (scheme, &from));
        let asked_apart = asked();
        for threads in [1, 2, 3] {
            let (found, tallies) = in_a_block(&scene, &Threads::new(threads)?, (scheme, &from), 0);
            let what = format!("node blocks of {node_block}, {threads} threads, position only: {is_position_only}");
            assert_eq!(asked() * if is_position_only { 2 } else { 1 }, asked_apart, "{what}");
            let off = apart(&found, &expected);
            assert!(off < 1e-14, "{what}: {off:e}");
            let (mut alone, mut told) = (found.forces.clone(), vec![Tally::default(); 2]);
            let at = NodeState { t: 0.0, x: cast_slice(&found.state.x), v: cast_slice(&found.state.v) };
            scene.1.pass(&scene.0, at, &Threads::one(), sums(&mut alone), &mut told);
            assert!((&alone, &told) == (&found.forces, &tallies), "{what}");
            asked();
        }
    }
    Ok(())
}

/// The same steps in one block where terms of the first sum depend on velocity too.
#[test]
fn blocks_of_terms_that_are_not_still() -> Result<(), ThreadPoolBuildError> {
    let scheme = KickDriftScheme { predicts: true, ..KICKS };
    for (node_block, records) in LIMITS {
        assert_same(
            &damped(Limits { node_block, records }, false),
            (scheme, [false, true]),
            &format!("node blocks of {node_block}"),
        )?;
    }
    Ok(())
}

/// Several callers of one scene find what each finds alone, whether they make a step or a pass, on threads of the pool
/// and on others.
#[test]
fn callers_do_not_meet() -> Result<(), ThreadPoolBuildError> {
    let (scene, from) = (terms_with(Limits { node_block: 16, records: 60 }, 2), start([false, true]));
    let threads = Threads::new(2)?;
    let (step, _) = in_a_block(&scene, &Threads::one(), (KICKS, &from), 0);
    let pass = |threads: &Threads| {
        let at = NodeState { t: 0.0, x: cast_slice(&from.state.x), v: cast_slice(&from.state.v) };
        let (mut forces, mut tallies) = (nowhere(&from).forces, vec![Tally::default(); 2]);
        scene.1.pass(&scene.0, at, threads, sums(&mut forces), &mut tallies);
        forces
    };
    let alone = pass(&Threads::one());
    assert!(step.forces.total.iter().chain(&alone.total).all(|f| f.is_finite()));
    let call = |i: usize| match i {
        0 => assert!(pass(&threads) == alone),
        _ => assert!(in_a_block(&scene, &threads, (KICKS, &from), 0).0 == step),
    };
    std::thread::scope(|scope| {
        for i in 0..4 {
            scope.spawn(move || (0..300).for_each(|_| call(usize::from(i > 0))));
        }
        (0..300).for_each(|i| call(i % 2));
    });
    Ok(())
}
