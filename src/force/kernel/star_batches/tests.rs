//! StarBatches, beside their elements one by one.

use super::*;
use crate::force::kernel::axial_kernel::tests::{LESS, Law, blocks};
use crate::force::kernel::element_block::place;
use crate::force::kernel::lane_batches::tests::{NODES, elements, random, vectors};
use crate::force::kernel::local_buffer::{LocalBuffer, RECORD, rows};
use crate::model::quad::Portable;

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

fn in_order(ends: &[[u16; 2]]) -> (Vec<[u16; 2]>, usize, Vec<Placed>) {
    let (order, groups) = arrange(ends);
    let turn = |placed: &Placed| {
        let [a, b] = ends[placed.element];
        if placed.turned { [b, a] } else { [a, b] }
    };
    (order.iter().map(turn).collect(), groups, order)
}

#[test]
fn every_element_has_one_place_and_fans_have_one_node() {
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
        let (stars, _) = arranged[..GROUP * groups].as_chunks::<GROUP>();
        for (group, q) in stars.iter().flat_map(|group| (0..STARS).map(move |q| (group, q))) {
            assert!((0..STAR).all(|j| group[STARS * j + q][0] == group[q][0]), "{group:?}");
        }
        assert!((GROUP * groups) as f64 >= least * ends.len() as f64, "{groups} groups of {}", ends.len());
        assert!(order[GROUP * groups..].is_sorted_by_key(|placed| placed.element));
    }
}

/// Sums of all nodes, and what was returned.
type Found = (Vec<PaddedVec3>, f64);

fn found(add: impl Fn(&mut Records) -> f64) -> Found {
    let mut f = LocalBuffer::new(0);
    let sum = add(f.records());
    (rows(f.records(), NODES).to_vec(), sum)
}

fn assert_near((a, energy_a): &Found, (b, energy_b): &Found) {
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-14 * (1.0 + a.abs()) * 50.0;
    assert!(close(*energy_a, *energy_b), "{energy_a} for {energy_b}");
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        assert!((0..3).all(|k| close(a[k], b[k])), "node {i}: {a:?} for {b:?}");
    }
}

/// From none to many groups: all units have the same bits, which are those of a plain loop but for its order.
#[test]
fn fans_pull_as_their_elements_do() {
    let mut all = elements::<2>(400, 1);
    all.push([place(NODES - 2), place(NODES - 1)]);
    for n in [0, 12, 30, 60, 100, 401] {
        let (ends, groups, _) = in_order(&all[all.len() - n..]);
        let (stars, mut window) = (ends[..GROUP * groups].as_chunks::<GROUP>().0, vectors(2));
        assert!(n < 100 || groups > 2, "{groups} groups of {n}");
        let numbers: Vec<f64> = std::iter::repeat_with(random(3)).take(GROUP * groups).collect();
        let (u, in_blocks) = (&*window.records(), blocks(&numbers));
        let pulling = || (stars, [Column::each(&in_blocks), Column::uniform(&LESS)]);
        let pulled = found(|f| quad::run(Pulling { law: &Law, stars: pulling(), u, f }));
        let portable = found(|f| Pulling { law: &Law, stars: pulling(), u, f }.run(Portable));
        assert_eq!(pulled, portable, "{n} elements");
        let mut energy = 0.0;
        let mut pulls = vec![[0.0; RECORD]; NODES];
        for (&[a, b], k) in stars.as_flattened().iter().zip(&numbers) {
            let (u_a, u_b) = (record(u, a), record(u, b));
            let l = (0..3).map(|i| (u_b[i] - u_a[i]).powi(2)).sum::<f64>().sqrt();
            let pull = k - LESS[0][0];
            energy += pull * l;
            let [a, b] = [a, b].map(|place| usize::from(place) / RECORD);
            for i in 0..3 {
                let force = if l > 0.0 { pull / l * (u_b[i] - u_a[i]) } else { 0.0 };
                pulls[a][i] += force;
                pulls[b][i] -= force;
            }
        }
        assert_near(&pulled, &(pulls, energy));
    }
}
