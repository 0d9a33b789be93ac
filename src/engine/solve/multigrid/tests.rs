use super::*;
use crate::model::workers::ALONE;
use nalgebra::Matrix3;
use std::collections::BTreeMap;

/// Nodes along a side: more than one section, so that some blocks lie between sections.
const SIDE: usize = 140;

/// A triangulated net of springs with inertia and a thousandth of their stiffness across them. Of the nodes of the
/// first side the first half has no unknown, the second one along y only.
fn net() -> (Arc<Pattern>, Vec<f64>) {
    let mut blocks: BTreeMap<(usize, usize), Matrix3<f64>> = BTreeMap::new();
    let mut spring = |a: usize, b: usize, x: f64, y: f64| {
        let along = Vector3::new(x, y, 0.0).normalize();
        let stiffness = along * along.transpose() + Matrix3::identity() * 1e-3;
        for (row, column, sign) in [(a, a, 1.0), (b, b, 1.0), (b, a, -1.0)] {
            *blocks.entry((column, row)).or_default() += stiffness * sign;
        }
    };
    for i in 0..SIDE * SIDE {
        let inner = [i % SIDE + 1 < SIDE, i / SIDE + 1 < SIDE];
        let beside = [(1, 1.0, 0.0, inner[0]), (SIDE, 0.0, 1.0, inner[1]), (SIDE + 1, 1.0, 1.0, inner[0] && inner[1])];
        for (ahead, x, y, _) in beside.into_iter().filter(|(.., there)| *there) {
            spring(i, i + ahead, x, y);
        }
    }
    let free = |g: usize, direction: usize| g >= SIDE || g >= SIDE / 2 && direction == 1;
    let (mut pattern, mut values) = (Pattern { symmetric: true, ..Pattern::default() }, Vec::new());
    let mut number = BTreeMap::new();
    for g in 0..SIDE * SIDE {
        let first = pattern.dof.len() as u32;
        for direction in (0..3).filter(|&direction| free(g, direction)) {
            number.insert((g, direction), pattern.dof.len() as u32);
            pattern.dof.push((3 * g + direction) as u32);
        }
        if pattern.dof.len() as u32 > first {
            pattern.node_start.push(first);
            pattern.position.push([(g % SIDE) as f64, (g / SIDE) as f64, 0.0]);
        }
    }
    pattern.node_start.push(pattern.dof.len() as u32);
    pattern.col_ptr.push(0);
    for (&(g, j), &u) in &number {
        for (&(_, row), block) in blocks.range((g, 0)..(g + 1, 0)) {
            for i in 0..3 {
                if let Some(&r) = number.get(&(row, i)).filter(|r| **r >= u) {
                    pattern.row_idx.push(r);
                    values.push(block[(i, j)] + if r == u { 1e-4 } else { 0.0 });
                }
            }
        }
        pattern.col_ptr.push(pattern.row_idx.len() as u32);
    }
    (Arc::new(pattern), values)
}

/// B is symmetric and positive definite, and few iterations solve for a smooth right-hand side, with the same bits on
/// any number of threads.
#[test]
fn iterations_are_few_and_b_is_symmetric() -> Result<(), LinearError> {
    let (pattern, values) = net();
    let b: Vec<f64> = (0..pattern.n()).map(|u| if pattern.dof[u] % 3 == 2 { -1.0 } else { 0.3 }).collect();
    let rough: Vec<f64> = (0..pattern.n()).map(pseudo_random).collect();
    let mut solutions = Vec::new();
    for threads in 1..=3 {
        let workers = Workers::new(threads).unwrap_or_default();
        let mut grid = Multigrid::new(&pattern, &workers)?;
        assert!(grid.levels.len() > 1 && grid.along.len() > 1);
        assert!(grid.set_values(&values)?);
        let mut preconditioned = |b: &[f64]| {
            let [s, square] = grid.set_right_hand_side(b)?;
            grid.x.clone_from(&grid.levels[0].z);
            let mut z = vec![0.0; b.len()];
            grid.finish(s, &mut z);
            assert!(square > 0.0);
            Ok::<_, LinearError>(z)
        };
        let (smoothed, other) = (preconditioned(&b)?, preconditioned(&rough)?);
        let sizes = (ALONE.dot(&b, &smoothed) * ALONE.dot(&rough, &other)).sqrt();
        let (one, other) = (ALONE.dot(&rough, &smoothed), ALONE.dot(&b, &other));
        assert!((one - other).abs() < 5e-8 * sizes, "{one:e} and {other:e}, of {sizes:e}");

        let [s, first] = grid.set_right_hand_side(&b)?;
        grid.begin();
        let (mut square, mut beta, mut iterations) = (first, 0.0, 0);
        while (square / first).sqrt() > 1e-5 {
            iterations += 1;
            assert!(iterations <= 11);
            let curvature = grid.product(beta);
            assert!(
                curvature.along > 0.0 && curvature.along < 3.0 * curvature.squares,
                "B is near to the inverse of W"
            );
            let before = square;
            square = grid.advance((square / curvature.along) as f32)?;
            beta = (square / before) as f32;
        }
        let mut x = vec![0.0; b.len()];
        grid.finish(s, &mut x);
        let mut left = vec![0.0; b.len()];
        pattern.multiply(&values, &x, &mut left);
        left.iter_mut().zip(&b).for_each(|(left, b)| *left -= b);
        assert!(ALONE.norm(&left) < 0.01 * ALONE.norm(&b), "{:e} of {:e}", ALONE.norm(&left), ALONE.norm(&b));
        solutions.push(x);
    }
    assert!(solutions[0] == solutions[1] && solutions[0] == solutions[2]);
    Ok(())
}

/// A matrix that is not positive definite is told, as a whole and at a node.
#[test]
fn an_indefinite_matrix_is_told() -> Result<(), LinearError> {
    let (pattern, values) = net();
    let mut grid = Multigrid::new(&pattern, &Workers::default())?;
    let shifted = |by: f64, of: &dyn Fn(usize) -> bool| {
        let mut shifted = values.clone();
        (0..pattern.n()).filter(|u| of(*u)).for_each(|u| shifted[pattern.col_ptr[u] as usize] -= by);
        shifted
    };
    // Every node alone is definite, a smooth motion is not.
    assert!(!grid.set_values(&shifted(1e-2, &|_| true))?);
    assert!(!grid.set_values(&shifted(10.0, &|u| u == 1000))?);
    assert!(grid.set_values(&values)?);
    Ok(())
}
