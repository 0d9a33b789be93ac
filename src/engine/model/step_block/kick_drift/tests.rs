//! KickDriftScheme of nodes four by four, beside a degree of freedom after the other.

use super::*;
use crate::model::motion::{Motion, motion};
use crate::model::quad::{Pass as _, Portable};

const SIZES: [f64; 2] = [0.3, 0.01];

/// Nodes with `W` numbers a vector, the fourth of them 0.
#[derive(Clone, Debug, PartialEq)]
struct Net<const W: usize> {
    mass: Vec<f64>,
    inverse_mass: Vec<f64>,
    x: Vec<f64>,
    v: Vec<f64>,
    kicked: Vec<f64>,
    f: Vec<f64>,
}

impl<const W: usize> Net<W> {
    fn new(nodes: usize) -> Self {
        let vectors = |phase: f64| {
            let number = |i: usize| if i % W < 3 { (0.7 * i as f64 + phase).sin() } else { 0.0 };
            (0..W * nodes).map(number).collect::<Vec<f64>>()
        };
        let mass: Vec<f64> = (0..nodes).map(|i| 1.0 + (i % 5) as f64).collect();
        // Every seventh is fixed.
        let inverse = |i: usize| if i.is_multiple_of(7) || i % W == 3 { 0.0 } else { 1.0 / mass[i / W] };
        let inverse_mass = (0..W * nodes).map(inverse).collect();
        Net { mass, inverse_mass, x: vectors(0.0), v: vectors(1.0), kicked: vectors(3.0), f: vectors(2.0) }
    }

    fn nodes(&mut self, kicks: KickDriftScheme) -> Nodes<'_, W> {
        let Net { mass, inverse_mass, x, v, kicked, f } = self;
        Nodes { mass, inverse_mass, x, v, kicked: if kicks.predicts { kicked } else { &mut [] }, f, works: None }
    }

    fn one_by_one(&mut self, kicks: KickDriftScheme, another: bool) -> NodeSums {
        let kick = |net: &mut Self, by: f64| {
            for i in 0..net.v.len() {
                net.v[i] += by * (net.inverse_mass[i] * net.f[i]);
            }
        };
        if let Some(l) = kicks.end.filter(|_| !kicks.predicts) {
            kick(self, l);
        }
        let packed: Vec<f64> = self.v.chunks(W).flat_map(|v| [v[0], v[1], v[2]]).collect();
        let Motion { kinetic, largest_square } = motion(&packed, &self.mass);
        let boxes = self.x.chunks(W).map(|x| [x[0], x[1], x[2]]).map(|x| Bounds { low: x, high: x });
        let bounds = if another { Bounds::default() } else { boxes.fold(Bounds::default(), Bounds::and) };
        let finite = another || self.f.iter().all(|f| f.is_finite());
        if another {
            let before = self.v.clone();
            kick(self, kicks.begin);
            self.x.iter_mut().zip(&self.v).for_each(|(x, v)| *x += kicks.drift * v);
            if kicks.predicts {
                self.kicked = std::mem::replace(&mut self.v, before);
                kick(self, kicks.drift);
            }
            if W == 4 {
                self.f.fill(0.0);
            }
        }
        NodeSums { kinetic, largest_square, bounds, finite, work: Work::default() }
    }
}

fn every_way(mut of: impl FnMut(KickDriftScheme, bool)) {
    let [begin, drift] = SIZES;
    for (end, predicts) in [(None, false), (Some(0.2), false), (Some(0.2), true), (None, true)] {
        for another in [false, true] {
            of(KickDriftScheme { begin, drift, end, predicts }, another);
        }
    }
}

/// To the bit on this machine's unit and on any, whatever is left over of four nodes and of a block.
fn assert_same<const W: usize>() {
    every_way(|kicks, another| {
        for nodes in (0..10).chain([63, 64, 65, 130]) {
            let mut expected = Net::<W>::new(nodes);
            let (mut best, mut portable) = (expected.clone(), expected.clone());
            let sums = expected.one_by_one(kicks, another);
            assert_eq!(kicks.end(best.nodes(kicks), another).nodes, sums, "{nodes} nodes, {kicks:?}, {another}");
            assert_eq!(
                Pass { scheme: kicks, nodes: portable.nodes(kicks), another }.run(Portable).nodes,
                sums,
                "{nodes} nodes, any machine"
            );
            assert_eq!((&best, &portable), (&expected, &expected), "{nodes} nodes, {kicks:?}, {another}");
        }
    });
}

#[test]
fn packed_vectors_are_kicked_as_one_by_one() {
    assert_same::<3>();
}

#[test]
fn records_are_kicked_as_one_by_one() {
    assert_same::<4>();
}

/// Also at fixed degrees of freedom, where nothing moves: where a step is the last at once, else by the kinetic energy,
/// in the next step at the latest.
fn a_wrong_force_is_told<const W: usize>() {
    every_way(|kicks, another| {
        for (at, wrong) in (0..6 * W).flat_map(|at| [f64::NAN, f64::INFINITY, f64::NEG_INFINITY].map(|f| (at, f))) {
            if at % W == 3 {
                continue;
            }
            let mut net = Net::<W>::new(6);
            net.f[at] = wrong;
            let mut sums = kicks.end(net.nodes(kicks), another).nodes;
            assert_eq!(sums.finite, another, "{wrong} at {at}, {kicks:?}");
            if another && sums.kinetic.is_finite() {
                assert!(kicks.end.is_none() || kicks.predicts);
                net.f.fill(0.0);
                if kicks.predicts {
                    let Net { inverse_mass, v, kicked, f, .. } = &mut net;
                    kicks.correct(v, kicked, inverse_mass, f);
                }
                sums = kicks.end(net.nodes(kicks), another).nodes;
            }
            assert!(!sums.finite || !sums.kinetic.is_finite(), "{wrong} at {at}, {kicks:?}, {another}");
        }
        let sums = kicks.end(Net::<W>::new(6).nodes(kicks), another).nodes;
        assert!(sums.finite && sums.kinetic.is_finite());
    });
}

#[test]
fn a_force_that_is_not_finite_is_told_wherever_it_is() {
    a_wrong_force_is_told::<3>();
    a_wrong_force_is_told::<4>();
}

/// v = u + l M^-1 f, to the bit, with whatever velocities were there.
#[test]
fn predicted_steps_are_corrected() {
    let Net { inverse_mass, mut v, kicked, f, .. } = Net::<3>::new(11);
    let kicks = KickDriftScheme { begin: 0.3, drift: 0.01, end: Some(0.2), predicts: true };
    kicks.correct(&mut v, &kicked, &inverse_mass, &f);
    for (i, v) in v.into_iter().enumerate() {
        assert_eq!(v, kicked[i] + 0.2 * (inverse_mass[i] * f[i]), "{i}");
    }
    assert_eq!([kicks.passes(), KickDriftScheme { predicts: false, ..kicks }.passes()], [2, 1]);
}
