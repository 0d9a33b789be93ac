//! Pivots, blocks and the product, against their equations.

use super::*;
use crate::assembly::Pattern;
use crate::model::workers::{ALONE, Workers};
use crate::solve::bsr::unpacked;
use crate::solve::partitioned_cg::{PartitionedSystem, SubdomainSystem};
use crate::solve::sections::Cut;
use std::ops::Range;
use std::sync::Arc;
use wide::f32x4;

/// What node g may move along, of a row of nodes of which some are partly held.
fn free(g: usize) -> &'static [u32] {
    match g {
        3 => &[0, 2],
        5 => &[1],
        _ => &[0, 1, 2],
    }
}

const NODES: usize = 12;

/// Nodes with three neighbours ahead each, as in a net of triangles so many nodes across.
fn pattern(width: usize) -> Pattern {
    let (mut dof, mut node_start) = (Vec::new(), vec![0]);
    for g in 0..NODES {
        dof.extend(free(g).iter().map(|direction| 3 * g as u32 + direction));
        node_start.push(dof.len() as u32);
    }
    let (mut col_ptr, mut row_idx) = (vec![0], Vec::new());
    for g in 0..NODES {
        for u in node_start[g]..node_start[g + 1] {
            row_idx.extend(u..node_start[g + 1]);
            for other in [g + 1, g + width, g + width + 1].into_iter().filter(|&other| other < NODES) {
                row_idx.extend(node_start[other]..node_start[other + 1]);
            }
            col_ptr.push(row_idx.len() as u32);
        }
    }
    let position = vec![[0.0; 3]; NODES];
    Pattern { col_ptr, row_idx, symmetric: true, dof, node_start, position }
}

/// Random entries of sizes that differ by powers of ten, made positive definite by the diagonal.
fn values(pattern: &Pattern, seed: u64) -> Vec<f64> {
    let mut state = seed;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let size: Vec<f64> = (0..pattern.n()).map(|_| 10_f64.powf(3.0 * random())).collect();
    let (mut values, mut sums) = (vec![0.0; pattern.nonzeros()], vec![0.1; pattern.n()]);
    for u in 0..pattern.n() {
        let beside = pattern.col_ptr[u] as usize + 1..pattern.col_ptr[u + 1] as usize;
        for (value, &r) in values[beside].iter_mut().zip(&pattern.column(u)[1..]) {
            let (entry, r): (f64, usize) = (random(), r as usize);
            *value = entry * size[u] * size[r];
            sums[u] += entry.abs();
            sums[r] += entry.abs();
        }
    }
    for u in 0..pattern.n() {
        values[pattern.col_ptr[u] as usize] = sums[u] * size[u] * size[u];
    }
    values
}

/// The width of a net and the separators that cut it: none, an empty one, one between two sections with nodes that are
/// partly held, and two with a section between them.
#[expect(clippy::single_range_in_vec_init, reason = "one separator")]
const CUTS: [(usize, &[Range<usize>]); 4] = [(4, &[]), (4, &[NODES..NODES]), (4, &[4..9]), (2, &[1..4, 7..10])];

fn system((width, separators): (usize, &[Range<usize>]), workers: &Workers) -> PartitionedSystem {
    let pattern = Arc::new(pattern(width));
    let node = pattern.node_of_unknown();
    PartitionedSystem::of_cut(&pattern, Cut::at(NODES, separators), &node, workers)
}

fn all(system: &PartitionedSystem) -> impl Iterator<Item = &SubdomainSystem> {
    system.sections.iter().chain(&system.separators)
}

/// Nodes in the order of their elimination.
fn order(system: &PartitionedSystem) -> Vec<usize> {
    let nodes =
        |part: &SubdomainSystem| (0..part.blocks.nodes()).map(|g| part.blocks.subdomain.node(g)).collect::<Vec<_>>();
    all(system).flat_map(nodes).collect()
}

/// What a subdomain holds of each of its nodes, by node.
fn by_node<T: Copy + Default>(system: &PartitionedSystem, of: impl Fn(&SubdomainSystem) -> &[T]) -> Vec<T> {
    let mut found = vec![T::default(); NODES];
    for part in all(system) {
        (0..part.blocks.nodes()).for_each(|g| found[part.blocks.subdomain.node(g)] = of(part)[g]);
    }
    found
}

/// Row, column and value of every block of L.
fn below(system: &PartitionedSystem) -> Vec<(usize, usize, Matrix3<f64>)> {
    let mut found = Vec::new();
    for blocks in all(system).map(|part| &part.blocks) {
        for (g, k) in (0..blocks.nodes()).flat_map(|g| blocks.column(g).map(move |k| (g, k))) {
            let (row, column) = (blocks.subdomain.node(blocks.row[k] as usize), blocks.subdomain.node(g));
            found.push((row, column, blocks.block(k).cast::<f64>()));
        }
    }
    found
}

/// E (I + J) E^T and E L E^T are the blocks of W, entry by entry, whatever the pivots.
#[test]
fn the_blocks_are_those_of_w() {
    for cut in CUTS {
        let (mut system, pattern) = (system(cut, &ALONE), pattern(cut.0));
        let mut lost = 0;
        for seed in 1..20 {
            let values = values(&pattern, seed);
            assert!(system.set_values(&values, RELAXATION), "seed {seed}");
            let surplus = by_node(&system, |part| &part.blocks.surplus);
            lost += surplus.iter().filter(|surplus| surplus.diagonal().max() > 0.1).count();
            let inverse = by_node(&system, |part| &part.blocks.inverse_root);
            let root: Vec<Matrix3<f64>> =
                inverse.iter().map(|inverse| inverse.cast::<f64>().try_inverse().unwrap_or_default()).collect();
            let (w, _) = scaled(&system, &values);
            let own = |g: usize| (g, g, Matrix3::identity() + surplus[g].matrix().cast::<f64>());
            let blocks: Vec<_> = below(&system).into_iter().chain((0..NODES).map(own)).collect();
            let stored = (0..NODES).map(|g| (g..NODES).filter(|&s| w[s][g] != Matrix3::zeros()).count()).sum::<usize>();
            assert_eq!(blocks.len(), stored, "each block once");
            for (row, column, block) in blocks {
                let off = root[row] * block * root[column].transpose() - w[row][column];
                assert!(
                    most(off) < 1e-6 * (1.0 + most(root[row]) * most(root[column])),
                    "seed {seed}, {cut:?}: block {row}, {column} is {off} off"
                );
            }
        }
        assert!(lost > 20, "{lost} pivots that lose");
    }
}

fn most(m: Matrix3<f64>) -> f64 {
    m.amax()
}

/// W scaled by its diagonal, block by block, with the identity in idle places; and Y^-1, 0 in idle places.
fn scaled(system: &PartitionedSystem, values: &[f64]) -> (Vec<Vec<Matrix3<f64>>>, Vec<Matrix3<f64>>) {
    let pattern = &system.sections[0].blocks.pattern;
    let place = |u: usize| (pattern.dof[u] as usize / 3, pattern.dof[u] as usize % 3);
    let (mut w, mut scale) = (vec![vec![Matrix3::zeros(); NODES]; NODES], vec![Matrix3::zeros(); NODES]);
    for (g, row) in w.iter_mut().enumerate() {
        row[g] = Matrix3::identity();
    }
    for u in 0..pattern.n() {
        let (g, column) = place(u);
        scale[g][(column, column)] = system.scale[u];
        for (&r, value) in pattern.column(u).iter().zip(&values[pattern.col_ptr[u] as usize..]) {
            let (other, row) = place(r as usize);
            w[other][g][(row, column)] = value * system.scale[u] * system.scale[r as usize];
            w[g][other][(column, row)] = w[other][g][(row, column)];
        }
    }
    (w, scale)
}

/// The pivots are those of the equation above, in the order of elimination.
#[test]
fn the_pivots_are_those_of_the_equation() {
    for cut in CUTS {
        let (mut system, pattern) = (system(cut, &ALONE), pattern(cut.0));
        let order = order(&system);
        let mut filled = 0;
        for seed in 1..20 {
            let values = values(&pattern, seed);
            assert!(system.set_values(&values, RELAXATION), "seed {seed}");
            let (w, scale) = scaled(&system, &values);
            let found = by_node(&system, |part| &part.blocks.inverse_root);
            let weight = |g: usize| {
                let entry = |c: usize| if scale[g][(c, c)] > 0.0 { scale[g][(c, c)].recip() } else { 0.0 };
                Matrix3::from_diagonal(&Vector3::new(entry(0), entry(1), entry(2)))
            };
            let mut inverse = [Matrix3::zeros(); NODES];
            for (turn, &g) in order.iter().enumerate() {
                let (mut taken, mut fill) = (Matrix3::zeros(), Matrix3::zeros());
                for (earlier, &j) in order[..turn].iter().enumerate() {
                    let row = w[g][j] * inverse[j];
                    taken += row * w[g][j].transpose();
                    for &s in order[earlier + 1..].iter().filter(|&&s| s != g) {
                        fill += row * w[s][j].transpose() * weight(s) * scale[g];
                    }
                }
                let bare = w[g][g] * (1.0 + SHIFT) - taken;
                let pivot = less_fill(&bare, &((fill + fill.transpose()) * (0.5 * RELAXATION)));
                filled += u32::from(pivot != bare);
                let root = found[g].cast::<f64>().try_inverse().unwrap_or_default();
                let off = most(root * root.transpose() - pivot);
                assert!(off < 1e-6 * (1.0 + most(fill)), "seed {seed}, {cut:?}, node {g}: {off:e} off");
                inverse[g] = pivot.try_inverse().unwrap_or_default();
            }
        }
        assert!(filled > 50, "{filled} pivots with fill");
    }
}

/// Fill is taken as far as it leaves enough, then halved, then left out.
#[test]
fn pivots_keep_enough() {
    let one = Matrix3::identity();
    let most = 1.0 - LEAST_LEFT;
    for (fill, share) in [(0.9 * most, 1.0), (-5.0, 1.0), (1.5 * most, 0.5), (7.0 * most, 0.125), (9.0 * most, 0.0)] {
        let found = less_fill(&one, &(one * fill));
        assert!((found.m11 - (1.0 - share * fill)).abs() < 1e-12, "{fill}: {found}");
    }
}

/// Eisenstat's product is the one of its three factors, and the solution's way in and out those of both of its solves.
#[test]
fn the_operations_are_those_of_their_factors() {
    for cut in CUTS {
        let (mut system, pattern) = (system(cut, &ALONE), pattern(cut.0));
        assert!(system.set_values(&values(&pattern, 1), RELAXATION));
        let mut order = order(&system);
        let below = below(&system);
        let forward = |v: &mut [Vector3<f64>], order: &[usize]| {
            for &g in order {
                let column: Vec<_> = below.iter().filter(|(_, column, _)| *column == g).collect();
                column.into_iter().for_each(|(row, _, block)| v[*row] -= *block * v[g]);
            }
        };
        let backward = |v: &mut [Vector3<f64>], order: &[usize]| {
            for &g in order.iter().rev() {
                let row: Vector3<f64> = below.iter().filter(|b| b.1 == g).map(|b| b.2.transpose() * v[b.0]).sum();
                v[g] -= row;
            }
        };
        let b: Vec<f64> = (0..pattern.n()).map(|u| (u as f64).cos()).collect();
        let [s, square] = system.set_right_hand_side(&b);
        let root = by_node(&system, |part| &part.blocks.inverse_root);
        let mut r = vec![Vector3::zeros(); NODES];
        (0..pattern.n())
            .for_each(|u| r[pattern.dof[u] as usize / 3][pattern.dof[u] as usize % 3] = b[u] * system.scale[u]);
        r.iter_mut().zip(&root).for_each(|(r, root)| *r = root.cast::<f64>() * *r / s);
        forward(&mut r, &order);
        let near = |what: &str, found: &[f32x4], expected: &[Vector3<f64>]| {
            for (g, (found, expected)) in found.iter().zip(expected).enumerate() {
                let off = (unpacked(*found).cast::<f64>() - *expected).norm();
                assert!(off < 1e-5 * (1.0 + expected.norm()), "{what}, {cut:?}, node {g}: {off:e} off");
            }
        };
        near("r", &by_node(&system, |part| &part.r), &r);
        let squares: f64 = r.iter().map(|r| r.norm_squared()).sum();
        assert!((square - squares).abs() < 1e-5 * squares);

        system.begin();
        system.product(0.0);
        let curvature = system.product(0.5);
        let p: Vec<Vector3<f64>> = r.iter().map(|r| *r * 1.5).collect();
        near("p <- r + beta p", &by_node(&system, |part| &part.p), &p);
        let mut u = p.clone();
        backward(&mut u, &order);
        let surplus = by_node(&system, |part| &part.blocks.surplus);
        let mut q: Vec<Vector3<f64>> = (0..NODES).map(|g| u[g] + surplus[g].matrix().cast::<f64>() * u[g]).collect();
        for (row, column, block) in &below {
            q[*row] += *block * u[*column];
            q[*column] += block.transpose() * u[*row];
        }
        forward(&mut q, &order);
        near("q", &by_node(&system, |part| &part.q), &q);
        let along: f64 = p.iter().zip(&q).map(|(p, q)| p.dot(q)).sum();
        let squares: f64 = p.iter().map(|p| p.norm_squared()).sum();
        assert!((curvature.along - along).abs() < 1e-5 * along && (curvature.squares - squares).abs() < 1e-5 * squares);

        let left = system.advance(0.25);
        let r: Vec<Vector3<f64>> = r.iter().zip(&q).map(|(r, q)| *r - *q * 0.25).collect();
        near("r -= alpha q", &by_node(&system, |part| &part.r), &r);
        let squares: f64 = r.iter().map(|r| r.norm_squared()).sum();
        assert!((left - squares).abs() < 1e-5 * squares);
        let mut x: Vec<Vector3<f64>> = p.iter().map(|p| *p * 0.25).collect();
        backward(&mut x, &order);
        let mut found = vec![f64::NAN; pattern.n()];
        system.finish(s, &mut found);
        for (u, found) in found.into_iter().enumerate() {
            let g = pattern.dof[u] as usize / 3;
            let own = (root[g].cast::<f64>().transpose() * x[g])[pattern.dof[u] as usize % 3] * system.scale[u] * s;
            assert!(
                (found - own).abs() < 1e-5 * x[g].norm() * system.scale[u] * s + 1e-12,
                "{cut:?}: {found} at {u}, not {own}"
            );
        }
        order.sort_unstable();
        assert!(order.into_iter().eq(0..NODES), "every node once");
    }
}

/// All operations give the same bits on any number of threads.
#[test]
fn threads_change_no_bits() -> Result<(), rayon::ThreadPoolBuildError> {
    let workers = [Workers::new(1)?, Workers::new(2)?, Workers::new(3)?];
    for cut in CUTS {
        let pattern = pattern(cut.0);
        let found = workers.each_ref().map(|workers| {
            let mut system = system(cut, workers);
            assert!(system.set_values(&values(&pattern, 1), RELAXATION));
            let mut x: Vec<f64> = (0..pattern.n()).map(|u| (u as f64).cos()).collect();
            let [scale, square] = system.set_right_hand_side(&x);
            system.begin();
            let curvature = system.product(0.0);
            let left = system.advance((square / curvature.along) as f32);
            system.finish(scale, &mut x);
            x.extend([scale, square, curvature.along, curvature.squares, left]);
            x.into_iter().map(f64::to_bits).collect::<Vec<_>>()
        });
        assert!(found[0] == found[1] && found[0] == found[2], "{cut:?}");
    }
    Ok(())
}

/// A W that single precision cannot hold is told, and leaves nothing behind for the next one.
#[test]
fn overflow_is_told_and_forgotten() {
    for cut in CUTS {
        let pattern = pattern(cut.0);
        let good = values(&pattern, 1);
        for u in 0..pattern.n() {
            let mut system = system(cut, &ALONE);
            let mut bad = good.clone();
            bad[pattern.col_ptr[u] as usize] = 1e-90;
            assert!(!system.set_values(&bad, RELAXATION) && system.set_values(&good, RELAXATION), "unknown {u}");
            assert!(
                below(&system).iter().all(|(.., block)| block.iter().all(|entry| entry.is_finite())),
                "unknown {u}"
            );
        }
    }
}
