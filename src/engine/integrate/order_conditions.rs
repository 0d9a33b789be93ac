//! Order conditions of Runge-Kutta methods, for tests of their tableaux. `rows` are the a_ij, stage by stage.

/// A rooted tree: its elementary weights by stage, and its density gamma (Butcher; Hairer, Norsett & Wanner 1993,
/// section II.2).
pub(super) struct Tree {
    weights: Vec<f64>,
    density: f64,
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// All trees up to an order, by order; the root of each joins smaller ones.
pub(super) fn trees(rows: &[&[f64]], most: usize) -> Vec<Vec<Tree>> {
    let mut all: Vec<Vec<Tree>> = vec![Vec::new()];
    for order in 1..=most {
        let flat: Vec<(usize, &Tree)> =
            all.iter().enumerate().flat_map(|(n, trees)| trees.iter().map(move |t| (n, t))).collect();
        let mut found = Vec::new();
        let bare = Tree { weights: vec![1.0; rows.len()], density: order as f64 };
        join(rows, &flat, order - 1, bare, &mut found);
        all.push(found);
    }
    all
}

/// Hangs multisets of `branches` (order, tree) with `left` nodes in all on `root`.
fn join(rows: &[&[f64]], branches: &[(usize, &Tree)], left: usize, root: Tree, found: &mut Vec<Tree>) {
    if left == 0 {
        found.push(root);
        return;
    }
    for (i, (order, branch)) in branches.iter().enumerate().filter(|(_, (order, _))| *order <= left) {
        let weights = root.weights.iter().zip(rows).map(|(w, row)| w * dot(row, &branch.weights)).collect();
        let next = Tree { weights, density: root.density * branch.density };
        join(rows, &branches[i..], left - order, next, found);
    }
}

/// Largest |b . weights - 1/gamma| of every order from 1 to `most`.
fn defects(rows: &[&[f64]], b: &[f64], most: usize) -> Vec<f64> {
    let off = |tree: &Tree| (dot(b, &tree.weights) - 1.0 / tree.density).abs();
    trees(rows, most)[1..].iter().map(|trees| trees.iter().map(off).fold(0.0, f64::max)).collect()
}

/// The weights meet every condition up to the order, to rounding, and not all of the next.
pub(super) fn has_order(rows: &[&[f64]], b: &[f64], order: usize) {
    let defects = defects(rows, b, order + 1);
    assert!(defects[..order].iter().all(|d| *d < 2e-14), "order {order}: {defects:?}");
    assert!(defects[order] > 1e-6, "more than order {order}: {defects:?}");
}

/// Coefficient of z^k in what a step with weights `b` does to y' = z y.
pub(super) fn tall(rows: &[&[f64]], b: &[f64], k: usize) -> f64 {
    let mut weights = vec![1.0; rows.len()];
    for _ in 1..k {
        weights = rows.iter().map(|row| dot(row, &weights)).collect();
    }
    dot(b, &weights)
}
