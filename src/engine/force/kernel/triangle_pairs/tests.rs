//! Pairs, beside their triangles one by one.

use super::*;
use crate::force::kernel::element_block::{place, vector};
use crate::force::kernel::fixtures::{NODES, elements, vectors};
use crate::force::kernel::local_buffer::{LocalBuffer, rows};
use crate::model::quad::{Portable, run};
use nalgebra::Vector3;

/// Rows of squares, each two triangles that are turned alike.
fn net(columns: usize, lines: usize) -> Vec<[u16; 3]> {
    let corners = (1..lines).flat_map(|j| (1..columns).map(move |i| columns * j + i));
    let squares = corners.map(|i| [i - columns - 1, i - columns, i, i - 1].map(place));
    squares.flat_map(|[a, b, c, d]| [[a, b, c], [c, d, a]]).collect()
}

/// A triangle by its node with the lowest place, turned as it was.
fn turned([a, b, c]: [u16; 3]) -> [u16; 3] {
    [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap_or_default()
}

/// The triangles of groups but for those that fill up pairs and groups.
fn triangles(groups: &[Group]) -> Vec<[u16; 3]> {
    let pairs = groups.as_flattened().iter().filter(|[a, b, ..]| a != b);
    pairs.flat_map(|&[a, b, c, d]| [Some([a, b, c]), (c != d).then_some([a, c, d])]).flatten().collect()
}

/// Pressure 2 Pa, a third to each vertex.
struct Law;

impl PressureLaw for Law {
    #[inline(always)]
    fn pressure_force<R: Real>(&self, s: [R; 3], v: [R; 3]) -> PressureForce<R> {
        let share = s[0].all(2.0 / 3.0);
        PressureForce { share, amount: share * (s[0] * v[0] + s[1] * v[1] + s[2] * v[2]) }
    }
}

/// Forces [N] of [`Law`] by node, and its power, written as one would: a triangle after the other.
fn one_by_one(triangles: &[[u16; 3]], [x, v]: [&Records; 2]) -> (Vec<Vector3<f64>>, f64) {
    let (mut forces, mut power) = (vec![Vector3::zeros(); NODES], 0.0);
    for nodes in triangles {
        let [a, b, c] = nodes.map(|i| vector(x, i));
        let s = 0.5 * (b - a).cross(&(c - a));
        for &node in nodes {
            forces[node as usize / 4] += 2.0 / 3.0 * s;
            power += 2.0 / 3.0 * s.dot(&vector(v, node));
        }
    }
    (forces, power)
}

#[test]
fn every_triangle_has_one_place_and_keeps_its_sense() {
    let fan: Vec<[u16; 3]> = (1..20).map(|i| [place(0), place(i), place(i + 1)]).collect();
    let against: Vec<[u16; 3]> = net(9, 7)
        .into_iter()
        .enumerate()
        .map(|(i, [a, b, c])| if i % 2 == 0 { [a, b, c] } else { [a, c, b] })
        .collect();
    let three_at_a_side: Vec<[u16; 3]> = (2..40)
        .map(|i| if i % 2 == 0 { [place(0), place(1), place(i)] } else { [place(1), place(0), place(i)] })
        .collect();
    let random = elements::<3>(300, 5).into_iter().filter(|[a, b, c]| a != b && b != c && c != a).collect();
    for (name, all, least) in [
        ("net", net(20, 10), 0.95),
        ("fan", fan, 0.8),
        ("every second turned", against, 0.0),
        ("three at a side", three_at_a_side, 0.8),
        ("random", random, 0.0),
        ("none", Vec::new(), 0.0),
    ] {
        let (groups, _) = arrange(&all);
        let (mut found, mut expected) = (triangles(&groups), all.clone());
        for list in [&mut found, &mut expected] {
            list.iter_mut().for_each(|nodes| *nodes = turned(*nodes));
            list.sort_unstable();
        }
        assert_eq!(found, expected, "{name}");
        let full = groups.as_flattened().iter().filter(|[a, b, c, d]| a != b && c != d).count();
        assert!((2 * full) as f64 >= least * all.len() as f64, "{name}: {full} pairs of {}", all.len());
    }
}

/// From none to many groups: all units have the same bits, which are those of a plain loop but for its order.
#[test]
fn pairs_push_as_their_triangles_do() {
    for (columns, lines) in [(2, 1), (3, 3), (5, 3), (5, 5), (7, 7)] {
        let (groups, _) = arrange(&net(columns, lines));
        assert!(columns < 5 || groups.len() > 1);
        let (mut x, mut v) = (vectors(2), vectors(3));
        let (x, v) = (&*x.records(), &*v.records());
        let found = |pass: &dyn Fn(&mut Records) -> f64| {
            let mut f = LocalBuffer::new(0);
            let power = pass(f.records());
            (rows(f.records(), NODES).to_vec(), power)
        };
        let pushed = found(&|f| run(PressurePass { law: &Law, groups: &groups, factors: &[], x, v, f }));
        assert_eq!(
            pushed,
            found(&|f| PressurePass { law: &Law, groups: &groups, factors: &[], x, v, f }.run(Portable))
        );
        let (forces, power) = one_by_one(&triangles(&groups), [x, v]);
        assert!((pushed.1 - power).abs() < 1e-12, "{} for {power}", pushed.1);
        for (i, (found, force)) in pushed.0.iter().zip(&forces).enumerate() {
            assert!((0..3).all(|k| (found[k] - force[k]).abs() < 1e-13), "node {i}: {found:?} for {force}");
        }
    }
}

/// Each adds what it has to: nothing is lost where two pairs of a group have nodes in common, or a triangle has one
/// twice.
#[test]
fn nodes_may_be_met_again() {
    let group: Group = [[0, 4, 8, 12], [0, 8, 12, 16], [4, 0, 8, 8], [4, 4, 8, 12]];
    let (mut x, mut v) = (vectors(7), vectors(8));
    let (x, v) = (&*x.records(), &*v.records());
    let mut f = LocalBuffer::new(0);
    let power = run(PressurePass { law: &Law, groups: &[group], factors: &[], x, v, f: f.records() });
    let each = group.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect::<Vec<_>>();
    let (forces, expected) = one_by_one(&each, [x, v]);
    assert!((power - expected).abs() < 1e-13);
    for (found, force) in rows(f.records(), NODES).iter().zip(&forces) {
        assert!((0..3).all(|k| (found[k] - force[k]).abs() < 1e-13));
    }
}
