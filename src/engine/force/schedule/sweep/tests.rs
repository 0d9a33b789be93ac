//! Passes over blocks, beside element after element.

use super::*;
use crate::force::kernel::batch::PARTS;
use crate::force::kernel::fixtures::random;
use crate::force::law::damped_springs::DampedSprings;
use crate::force::law::gravity::Gravity;
use crate::force::schedule::partition::Limits;
use crate::force::schedule::step_block::tests::{Links, links, relative_dashpots};
use crate::force::schedule::terms::PartTarget;
use rayon::ThreadPoolBuildError;

const NODES: usize = 200;

/// A star, a chain and weight, each for a sum of its own.
struct Mixed {
    star: DampedSprings,
    chain: Links,
    weight: Gravity,
}

impl Terms for Mixed {
    fn count(&self) -> usize {
        3
    }

    fn tallies(&self) -> usize {
        3
    }

    fn term(&self, i: usize) -> Term<'_> {
        let part = |sum| Some(PartTarget { sum, tally: i });
        match i {
            0 => Term { forces: &self.star, parts: [None, part(2)] },
            1 => Term { forces: &self.chain, parts: [part(0), None] },
            _ => Term { forces: &self.weight, parts: [part(1), None] },
        }
    }
}

/// Some parts, which all add to the only sum.
struct Only<'a>(&'a [(&'a dyn BlockForces, usize)]);

impl Terms for Only<'_> {
    fn count(&self) -> usize {
        self.0.len()
    }

    fn tallies(&self) -> usize {
        self.0.len()
    }

    fn term(&self, i: usize) -> Term<'_> {
        let (forces, part) = self.0[i];
        let mut parts = [None; PARTS];
        parts[part] = Some(PartTarget { sum: 0, tally: i });
        Term { forces, parts }
    }
}

fn mixed(limits: Limits) -> (Mixed, Sweep) {
    let ends = |pair: &dyn Fn(u32) -> [u32; 2]| (1..NODES as u32).map(pair).collect();
    let (star, chain) = (relative_dashpots(ends(&|i| [i, 0])), links(ends(&|i| [i, i - 1])));
    let weight = Gravity::new(
        Vector3::new(0.0, 0.5, -2.0),
        Default::default(),
        (0..NODES).map(|i| i as f64),
        vec![Vector3::x(); NODES].into(),
    );
    let mut terms = Mixed { star, chain, weight };
    let partition = Partition::within(limits, NODES, &mut [&mut terms.star, &mut terms.chain, &mut terms.weight]);
    (terms, Sweep::of(partition))
}

fn vectors(seed: u64) -> Vec<Vector3<f64>> {
    let mut random = random(seed);
    std::iter::repeat_with(|| Vector3::new(random(), random(), random())).take(NODES).collect()
}

/// What element after element gives, without blocks.
fn one_by_one(at: NodeState<'_>) -> ([Vec<Vector3<f64>>; 3], [Tally; 3]) {
    let mut sums = [0; 3].map(|_| vec![Vector3::zeros(); NODES]);
    let mut tallies = [Tally::default(); 3];
    for i in 0..NODES {
        if i > 0 {
            let dv = at.v[0] - at.v[i];
            sums[2][i] += 2.0 * dv;
            sums[2][0] -= 2.0 * dv;
            tallies[0].power -= 2.0 * dv.norm_squared();
            sums[0][i] += 0.5 * at.x[i - 1];
            sums[0][i - 1] += 0.5 * at.x[i];
        }
        let weight = i as f64 * Vector3::new(0.0, 0.5, -2.0);
        sums[1][i] += weight;
        tallies[2].energy -= weight.dot(&(at.x[i] - Vector3::x()));
    }
    let (others, total) = ([sums[1].clone(), sums[2].clone()], &mut sums[0]);
    others.iter().flatten().zip((0..NODES).cycle()).for_each(|(f, i)| total[i] += *f);
    (sums, tallies)
}

#[test]
fn a_pass_adds_up_all_terms_whatever_the_tiles_and_threads() -> Result<(), ThreadPoolBuildError> {
    let (x, v) = (vectors(1), vectors(2));
    let at = NodeState { t: 0.0, x: &x, v: &v };
    let (expected, amounts) = one_by_one(at);
    // Of one node block, of many, and of node blocks whose nodes need several blocks.
    for (node_block, records, blocks) in [(200, 400, 1..2), (16, 300, 13..14), (16, 40, 20..200)] {
        let (terms, sweep) = mixed(Limits { node_block, records });
        assert!(blocks.contains(&sweep.partition.blocks().len()), "{}", sweep.partition.blocks().len());
        let mut bits = Vec::new();
        for threads in [1, 2, 3] {
            let threads = Threads::new(threads)?;
            let mut sums = [0; 3].map(|_| vec![Vector3::repeat(f64::NAN); NODES]);
            let mut tallies = [Tally { energy: f64::NAN, power: f64::NAN }; 3];
            sweep.pass(&terms, at, &threads, sums.each_mut().map(Vec::as_mut_slice), &mut tallies);
            for (found, expected) in sums.iter().flatten().zip(expected.iter().flatten()) {
                assert!((*found - *expected).norm() < 1e-12 * (1.0 + expected.norm()), "{found} {expected}");
            }
            for (found, expected) in tallies.iter().zip(&amounts) {
                assert!((found.energy - expected.energy).abs() < 1e-10, "{found:?} {expected:?}");
                assert!((found.power - expected.power).abs() < 1e-10, "{found:?} {expected:?}");
            }
            let all = sums.iter().flatten().flat_map(|f| [f.x, f.y, f.z]);
            bits.push(all.chain(tallies.map(|t| t.energy + t.power)).map(f64::to_bits).collect::<Vec<_>>());
        }
        assert!(bits[0] == bits[1] && bits[0] == bits[2], "node blocks of {node_block}");
    }
    Ok(())
}

#[test]
fn passes_over_other_terms_leave_nothing_behind() -> Result<(), ThreadPoolBuildError> {
    let (x, v) = (vectors(3), vectors(4));
    let at = NodeState { t: 0.0, x: &x, v: &v };
    let (terms, sweep) = mixed(Limits { node_block: 16, records: 40 });
    for threads in [1, 2] {
        let threads = Threads::new(threads)?;
        let all = || {
            let mut sums = [0; 3].map(|_| vec![Vector3::repeat(f64::NAN); NODES]);
            let mut tallies = [Tally::default(); 3];
            sweep.pass(&terms, at, &threads, sums.each_mut().map(Vec::as_mut_slice), &mut tallies);
            (sums, tallies)
        };
        let before = all();
        let (mut sum, mut tally) = (vec![Vector3::repeat(f64::NAN); NODES], [Tally::default()]);
        let star: [(&dyn BlockForces, usize); 1] = [(&terms.star, 1)];
        sweep.pass(&Only(&star), at, &threads, [&mut sum, &mut [], &mut []], &mut tally);
        assert_eq!((&sum, tally[0]), (&before.0[2], before.1[0]));
        sweep.pass(&Only(&[]), at, &threads, [&mut sum, &mut [], &mut []], &mut []);
        assert!(sum.iter().all(|f| *f == Vector3::zeros()));
        assert_eq!(all(), before);
    }
    Ok(())
}

#[test]
fn a_batch_can_be_cut_again() {
    let (x, v) = (vectors(5), vectors(6));
    let at = NodeState { t: 0.0, x: &x, v: &v };
    let (mut terms, _) = mixed(Limits { node_block: 16, records: 40 });
    let partition = Partition::within(Limits { node_block: 64, records: 300 }, NODES, &mut [&mut terms.star]);
    let sweep = Sweep::of(partition);
    let mut sum = vec![Vector3::repeat(f64::NAN); NODES];
    let star: [(&dyn BlockForces, usize); 1] = [(&terms.star, 1)];
    sweep.pass(&Only(&star), at, &Threads::one(), [&mut sum, &mut [], &mut []], &mut []);
    let (expected, _) = one_by_one(at);
    assert!(sum.iter().zip(&expected[2]).all(|(a, b)| (*a - *b).norm() < 1e-12 * (1.0 + b.norm())));
}

#[test]
fn weight_alone_needs_no_elements() {
    let (x, v) = (vectors(3), vectors(4));
    let at = NodeState { t: 0.0, x: &x, v: &v };
    let (mut terms, _) = mixed(Limits { node_block: 16, records: 40 });
    let forces: &mut [&mut dyn BlockForces] = &mut [&mut terms.weight];
    let sweep = Sweep::of(Partition::within(Limits { node_block: 16, records: 40 }, NODES, forces));
    let mut sum = vec![Vector3::repeat(f64::NAN); NODES];
    sweep.pass(&Only(&[(&terms.weight, 0)]), at, &Threads::one(), [&mut sum, &mut [], &mut []], &mut []);
    assert!(sum.iter().enumerate().all(|(i, f)| *f == i as f64 * Vector3::new(0.0, 0.5, -2.0)));
}
