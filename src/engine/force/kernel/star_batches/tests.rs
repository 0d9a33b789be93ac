//! Stars, beside their elements one by one.

use super::*;
use crate::force::kernel::element_block::place;
use crate::force::kernel::fixtures::{NODES, elements, random, vectors};
use crate::force::kernel::local_buffer::{LocalBuffer, RECORD, rows};
use crate::model::quad::{Portable, run};

/// A node block of triangles, two nodes wide.
fn node_block(nodes: usize) -> Vec<[u16; 2]> {
    let to = |i: usize, by: usize| (i + by < nodes).then(|| [place(i), place(i + by)]);
    (0..nodes).flat_map(|i| [1, 2].into_iter().filter_map(move |by| to(i, by))).collect()
}

/// Rows of triangles with all three directions.
fn net(columns: usize, lines: usize) -> Vec<[u16; 2]> {
    let mut all = Vec::new();
    for (i, j) in (0..lines).flat_map(|j| (0..columns).map(move |i| (i, j))) {
        for (di, dj) in [(1, 0), (0, 1), (1, 1)] {
            if i + di < columns && j + dj < lines {
                all.push([place(columns * j + i), place(columns * (j + dj) + i + di)]);
            }
        }
    }
    all
}

fn in_order(ends: &[[u16; 2]]) -> (Vec<[u16; 2]>, usize, Vec<PlacedElement>) {
    let (order, groups) = arrange(ends);
    let turn = |placed: &PlacedElement| {
        let [a, b] = ends[placed.element];
        if placed.turned { [b, a] } else { [a, b] }
    };
    (order.iter().map(turn).collect(), groups, order)
}

#[test]
fn every_element_has_one_place_and_stars_have_one_node() {
    let star: Vec<[u16; 2]> = (1..20).map(|i| [place(0), place(i)]).collect();
    let chain: Vec<[u16; 2]> = (1..20).map(|i| [place(i - 1), place(i)]).collect();
    let random = elements::<2>(200, 5);
    for (ends, least) in
        [(net(20, 10), 0.9), (node_block(50), 0.8), (star, 0.6), (random, 0.7), (chain, 0.0), (Vec::new(), 0.0)]
    {
        let (arranged, groups, order) = in_order(&ends);
        let mut numbers: Vec<usize> = order.iter().map(|placed| placed.element).collect();
        numbers.sort_unstable();
        assert!(numbers.into_iter().eq(0..ends.len()));
        let in_stars = STAR * STARS * groups;
        let stars: &[Group<STAR>] = arranged[..in_stars].as_chunks().0.as_chunks().0;
        for (group, q) in stars.iter().flat_map(|group| (0..STARS).map(move |q| (group, q))) {
            assert!(group.iter().all(|elements| elements[q][0] == group[0][q][0]), "{group:?}");
        }
        assert!(in_stars as f64 >= least * ends.len() as f64, "{groups} groups of {}", ends.len());
        assert!(order[in_stars..].is_sorted_by_key(|placed| placed.element));
    }
}

/// An elastic force of k - 0.25 [N] whatever the length, and a damping force of c (d . u).
struct Law;

impl AxialLaw for Law {
    const ELASTIC: bool = true;
    const DAMPED: bool = true;

    #[inline(always)]
    fn axial_force<R: Real>(&self, [k, less, c]: [R; 3], Measured { square, rate }: Measured<R>) -> AxialForce<R> {
        let (l, force) = (square.sqrt(), k - less);
        let damping = c * rate;
        AxialForce { elastic: (force / l).where_positive(l), energy: force * l, damping, power: damping * rate }
    }
}

/// Sums of all nodes, elastic and damping, and what was returned.
type Found = ([Vec<PaddedVec3>; 2], [f64; 2]);

fn found(add: impl Fn([Option<&mut Records>; 2]) -> [f64; 2]) -> Found {
    let [mut f, mut g] = [0, 8].map(LocalBuffer::new);
    let sums = add([Some(f.records()), Some(g.records())]);
    ([f, g].map(|mut f| rows(f.records(), NODES).to_vec()), sums)
}

/// The same as one would write it.
fn one_by_one(ends: &[[u16; 2]], k: &[f64], [x, v]: [&Records; 2]) -> Found {
    let (mut sums, mut amounts) = ([0; 2].map(|_| vec![[0.0; RECORD]; NODES]), [0.0; 2]);
    for (&[a, b], k) in ends.iter().zip(k) {
        let [d, u] = [x, v].map(|of| [0, 1, 2].map(|i| record(of, b)[i] - record(of, a)[i]));
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let (l, rate) = (dot(d, d).sqrt(), dot(d, u));
        let scales = [if l > 0.0 { (k - 0.25) / l } else { 0.0 }, 2.0 * rate];
        amounts = [amounts[0] + (k - 0.25) * l, amounts[1] + 2.0 * rate * rate];
        let [a, b] = [a, b].map(|place| usize::from(place) / RECORD);
        for (sum, scale) in sums.iter_mut().zip(scales) {
            for i in 0..3 {
                sum[a][i] += scale * d[i];
                sum[b][i] -= scale * d[i];
            }
        }
    }
    (sums, amounts)
}

fn assert_near((a, amounts_a): &Found, (b, amounts_b): &Found) {
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-14 * (1.0 + a.abs()) * 50.0;
    assert!((0..2).all(|i| close(amounts_a[i], amounts_b[i])), "{amounts_a:?} for {amounts_b:?}");
    for (i, (a, b)) in a.iter().flatten().zip(b.iter().flatten()).enumerate() {
        assert!((0..3).all(|k| close(a[k], b[k])), "node {}: {a:?} for {b:?}", i % NODES);
    }
}

/// Stars of `N` elements: all units have the same bits, which are those of a plain loop but for its order.
fn assert_pulls<const N: usize>(ends: &[[u16; 2]], k: &[f64]) {
    let groups: &[Group<N>] = ends.as_chunks().0.as_chunks().0;
    let (mut x, mut v) = (vectors(2), vectors(3));
    let (x, v) = (&*x.records(), &*v.records());
    let [less, c] = [[[0.25; STARS]; STAR], [[2.0; STARS]; STAR]];
    let numbers = [Column::each(k.as_chunks().0), Column::uniform(&less), Column::uniform(&c)];
    let pulled = found(|sums| run(Stars { law: &Law, groups, numbers, x, v, sums }));
    let portable = found(|sums| Stars { law: &Law, groups, numbers, x, v, sums }.run(Portable));
    assert_eq!(pulled, portable, "{} elements", ends.len());
    assert_near(&pulled, &one_by_one(ends, k, [x, v]));
}

/// From none to many groups, of stars of three and of one.
#[test]
fn stars_pull_as_their_elements_do() {
    let mut all = elements::<2>(400, 1);
    all.push([place(NODES - 2), place(NODES - 1)]);
    for n in [0, 12, 30, 60, 100, 401] {
        let (ends, groups, _) = in_order(&all[all.len() - n..]);
        assert!(n < 100 || groups > 2, "{groups} groups of {n}");
        let (stars, others) = ends.split_at(STAR * STARS * groups);
        let k: Vec<f64> = std::iter::repeat_with(random(3)).take(n).collect();
        assert_pulls::<STAR>(stars, &k[..stars.len()]);
        let singles = others.len() / STARS * STARS;
        assert_pulls::<1>(&others[..singles], &k[..singles]);
    }
}
