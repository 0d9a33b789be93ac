//! Pivots, blocks and the product, against their equations.

use super::*;
use crate::assembly::Pattern;
use crate::solve::eisenstat::Sweep;
use std::sync::Arc;

/// What node g may move along, of a row of nodes of which some are partly held.
fn free(g: usize) -> &'static [u32] {
    match g {
        3 => &[0, 2],
        5 => &[1],
        _ => &[0, 1, 2],
    }
}

const NODES: usize = 12;

/// Nodes with three neighbours ahead each, as in a net of triangles.
fn pattern() -> Pattern {
    let (mut dof, mut node_start) = (Vec::new(), vec![0]);
    for g in 0..NODES {
        dof.extend(free(g).iter().map(|direction| 3 * g as u32 + direction));
        node_start.push(dof.len() as u32);
    }
    let (mut col_ptr, mut row_idx) = (vec![0], Vec::new());
    for g in 0..NODES {
        for u in node_start[g]..node_start[g + 1] {
            row_idx.extend(u..node_start[g + 1]);
            for other in [g + 1, g + 4, g + 5].into_iter().filter(|&other| other < NODES) {
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

/// E (I + J) E^T and E L E^T are the blocks of W, entry by entry, whatever the pivots.
#[test]
fn the_blocks_are_those_of_w() {
    let pattern = Arc::new(pattern());
    let mut blocks = NodeBlocks::new(Arc::clone(&pattern));
    let mut lost = 0;
    for seed in 1..20 {
        let values = values(&pattern, seed);
        assert!(blocks.fill(&values, RELAXATION), "seed {seed}");
        lost += (0..NODES).filter(|&g| blocks.surplus[g].diagonal().max_element() > 0.1).count();
        let root: Vec<DMat3> = blocks.inverse_root.iter().map(|inverse| inverse.as_dmat3().inverse()).collect();
        for g in 0..NODES {
            let own = DMat3::IDENTITY + blocks.surplus[g].matrix().as_dmat3();
            let beside = blocks.column(g).map(|k| (blocks.row[k] as usize, blocks.below[k].matrix().as_dmat3()));
            for (other, block) in beside.chain([(g, own)]) {
                let found = root[other] * block * root[g].transpose();
                for u in pattern.node_start[g]..pattern.node_start[g + 1] {
                    for r in (pattern.node_start[other]..pattern.node_start[other + 1]).filter(|&r| r >= u) {
                        // What is not stored is no number, and then nothing is near.
                        let value = pattern.slot(r, u).map_or(f64::NAN, |slot| values[slot as usize]);
                        let scales = blocks.scale[u as usize] * blocks.scale[r as usize];
                        let (column, row) = (blocks.direction(u as usize), blocks.direction(r as usize));
                        let off = found.col(column)[row] - value * scales;
                        assert!(off.abs() < 2e-6, "seed {seed}: entry {r}, {u} is {off:e} off");
                    }
                }
            }
        }
    }
    assert!(lost > 20, "{lost} pivots that lose");
}

/// W scaled by its diagonal, block by block, with the identity in idle places; and Y^-1, 0 in idle places.
fn scaled(blocks: &NodeBlocks, values: &[f64]) -> (Vec<Vec<DMat3>>, Vec<DMat3>) {
    let (pattern, place) = (&blocks.pattern, |u: usize| (blocks.pattern.dof[u] as usize / 3, blocks.direction(u)));
    let (mut w, mut scale) = (vec![vec![DMat3::ZERO; NODES]; NODES], vec![DMat3::ZERO; NODES]);
    for (g, row) in w.iter_mut().enumerate() {
        row[g] = DMat3::IDENTITY;
    }
    for u in 0..pattern.n() {
        let (g, column) = place(u);
        scale[g].col_mut(column)[column] = blocks.scale[u];
        for (&r, value) in pattern.column(u).iter().zip(&values[pattern.col_ptr[u] as usize..]) {
            let (other, row) = place(r as usize);
            w[other][g].col_mut(column)[row] = value * blocks.scale[u] * blocks.scale[r as usize];
            w[g][other].col_mut(row)[column] = w[other][g].col(column)[row];
        }
    }
    (w, scale)
}

/// The pivots are those of the equation above.
#[test]
fn the_pivots_are_those_of_the_equation() {
    let pattern = Arc::new(pattern());
    let mut blocks = NodeBlocks::new(Arc::clone(&pattern));
    let mut filled = 0;
    for seed in 1..20 {
        let values = values(&pattern, seed);
        assert!(blocks.fill(&values, RELAXATION), "seed {seed}");
        let (w, scale) = scaled(&blocks, &values);
        let weight = |g: usize| {
            let entry = |c: usize| if scale[g].col(c)[c] > 0.0 { scale[g].col(c)[c].recip() } else { 0.0 };
            DMat3::from_diagonal(DVec3::new(entry(0), entry(1), entry(2)))
        };
        let mut inverse: Vec<DMat3> = Vec::new();
        for g in 0..NODES {
            let (mut taken, mut fill) = (DMat3::ZERO, DMat3::ZERO);
            for j in 0..g {
                let row = w[g][j] * inverse[j];
                taken += row * w[g][j].transpose();
                for s in (j + 1..NODES).filter(|&s| s != g) {
                    fill += row * w[s][j].transpose() * weight(s) * scale[g];
                }
            }
            let bare = w[g][g] * (1.0 + SHIFT) - taken;
            let pivot = less_fill(&bare, &((fill + fill.transpose()) * (0.5 * RELAXATION)));
            filled += u32::from(pivot != bare);
            let root = blocks.inverse_root[g].as_dmat3().inverse();
            let most = |m: DMat3| m.to_cols_array().into_iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let off = most(root * root.transpose() - pivot);
            assert!(off < 1e-6 * (1.0 + most(fill)), "seed {seed}, node {g}: {off:e} off");
            inverse.push(pivot.inverse());
        }
    }
    assert!(filled > 50, "{filled} pivots with fill");
}

/// Fill is taken as far as it leaves enough, then halved, then left out.
#[test]
fn pivots_keep_enough() {
    let one = DMat3::IDENTITY;
    let most = 1.0 - LEAST_LEFT;
    for (fill, share) in [(0.9 * most, 1.0), (-5.0, 1.0), (1.5 * most, 0.5), (7.0 * most, 0.125), (9.0 * most, 0.0)] {
        let found = less_fill(&one, &(one * fill));
        assert!((found.x_axis.x - (1.0 - share * fill)).abs() < 1e-12, "{fill}: {found}");
    }
}

/// Eisenstat's product is the one of its three factors.
#[test]
fn the_product_is_that_of_its_factors() {
    let pattern = Arc::new(pattern());
    let mut blocks = NodeBlocks::new(Arc::clone(&pattern));
    assert!(blocks.fill(&values(&pattern, 1), RELAXATION));
    let z: Vec<Vec3A> = (0..NODES).map(|i| Vec3A::new(1.0, -2.0, 0.5) * (i as f32).cos()).collect();
    let [mut p, mut t, mut q] = [z.clone(), z.clone(), z.clone()];
    let curvature = blocks.times(&z, 0.5, Sweep { p: &mut p, t: &mut t, q: &mut q });
    assert!(p.iter().zip(&z).all(|(p, z)| *p == *z * 1.5), "p <- z + beta p");
    let mut u = p.clone();
    blocks.backward(&mut u);
    let mut product: Vec<Vec3A> = (0..NODES).map(|g| u[g] + blocks.surplus[g].matrix() * u[g]).collect();
    for g in 0..NODES {
        for k in blocks.column(g) {
            let (row, block) = (blocks.row[k] as usize, blocks.below[k].matrix());
            product[row] += block * u[g];
            product[g] += block.transpose() * u[row];
        }
    }
    blocks.forward(&mut product);
    for (g, (a, b)) in product.iter().zip(&q).enumerate() {
        assert!((*a - *b).length() < 1e-5 * (1.0 + a.length()), "node {g}: {a} and {b}");
    }
    let along: f64 = p.iter().zip(&q).map(|(p, q)| f64::from(p.dot(*q))).sum();
    let squares: f64 = p.iter().map(|p| f64::from(p.length_squared())).sum();
    assert!((curvature.along - along).abs() < 1e-5 * along && (curvature.squares - squares).abs() < 1e-5 * squares);
}

/// A W that single precision cannot hold is told, and leaves nothing behind for the next one.
#[test]
fn overflow_is_told_and_forgotten() {
    let pattern = Arc::new(pattern());
    let good = values(&pattern, 1);
    for u in 0..pattern.n() {
        let mut blocks = NodeBlocks::new(Arc::clone(&pattern));
        let mut bad = good.clone();
        bad[pattern.col_ptr[u] as usize] = 1e-90;
        assert!(!blocks.fill(&bad, RELAXATION) && blocks.fill(&good, RELAXATION), "unknown {u}");
        assert!(blocks.below.iter().flat_map(|block| block.0).all(f32::is_finite), "unknown {u}");
    }
}
