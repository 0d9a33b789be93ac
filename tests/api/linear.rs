//! The linear solvers on tangents of real networks: positive definite, indefinite (compressed springs), singular,
//! non-symmetric; and the fill-reducing ordering.

use crate::common::{Random, patch, spring_group, square};
use canopy_fem::assembly::{Assembler, Pattern, TangentSystem};
use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::model::spec::*;
use canopy_fem::model::state::StateRef;
use canopy_fem::model::system::{System, Weights};
use canopy_fem::model::workers::{ALONE, Workers};
use canopy_fem::scene::{Network, build_network};
use canopy_fem::solve::{Accuracy, Inertia, LinearChoice, LinearError, fill_reducing, solver_for};
use std::sync::Arc;

/// A square sheet of plain springs, one corner held.
fn sheet(side: u32) -> Network {
    let mut spec = square(side, 1e-3);
    spec.fixed[0] = [true; 3];
    spec.springs = vec![spring_group(&spec, Slack::None)];
    build_network(spec, Threads::one()).expect("the fixture is sound")
}

/// W of a state scaled about the origin: below 1 all springs are compressed and K is indefinite.
fn tangent(scene: &Network, scale: f64, w: Weights) -> Assembler {
    let state = scene.initial_state();
    let x: Vec<f64> = state.x.iter().map(|x| scale * x).collect();
    let mut assembler = scene.assembler().expect("small");
    scene.assemble(StateRef { t: 0.0, x: &x, v: &state.v }, w, &mut assembler);
    assembler
}

fn right_hand_side(n: usize) -> Vec<f64> {
    let mut random = Random(7);
    (0..n).map(|_| random.next()).collect()
}

fn relative_residual(pattern: &Pattern, values: &[f64], x: &[f64], b: &[f64]) -> f64 {
    let mut product = vec![0.0; b.len()];
    pattern.multiply(values, x, &mut product);
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
    norm(&mut product.iter().zip(b).map(|(p, b)| p - b)) / norm(&mut b.iter().copied())
}

fn solve(assembler: &Assembler, choice: LinearChoice) -> (f64, u64) {
    let mut solver = solver_for(assembler.pattern.clone(), choice, &ALONE).expect("the choice fits");
    let b = right_hand_side(assembler.pattern.n());
    let mut x = b.clone();
    solver.factor(assembler.values()).expect("regular");
    solver.solve(assembler.values(), &mut x).expect("regular");
    (relative_residual(&assembler.pattern, assembler.values(), &x, &b), solver.stats().indefinite)
}

#[test]
fn cholesky_and_lu_solve_a_positive_definite_tangent() {
    let w = tangent(&sheet(12), 1.1, Weights { m: 1e6, c: 0.0, k: 1.0 });
    for choice in [LinearChoice::Auto, LinearChoice::Cholesky, LinearChoice::Lu] {
        let (residual, indefinite) = solve(&w, choice);
        assert!(residual < 1e-12, "{choice:?}: {residual}");
        assert_eq!(indefinite, 0, "{choice:?}");
    }
}

#[test]
fn an_indefinite_tangent_is_noticed_and_still_solved() {
    for scale in [0.9, 0.7, 0.3] {
        let w = tangent(&sheet(12), scale, Weights { m: 10.0, c: 0.0, k: 1.0 });
        let (residual, indefinite) = solve(&w, LinearChoice::Cholesky);
        assert!(residual < 1e-9, "scale {scale}: {residual}");
        assert_eq!(indefinite, 1, "scale {scale}: Cholesky must have stepped down");
    }
}

#[test]
fn a_singular_tangent_is_an_error_not_a_number() {
    // A flat net without inertia has no stiffness across its plane.
    let w = tangent(&sheet(6), 1.0, Weights { m: 0.0, c: 0.0, k: 1.0 });
    for choice in [LinearChoice::Cholesky, LinearChoice::Lu] {
        let mut solver = solver_for(w.pattern.clone(), choice, &ALONE).expect("the choice fits");
        let mut b = right_hand_side(w.pattern.n());
        let outcome = solver.factor(w.values()).and_then(|_| solver.solve(w.values(), &mut b));
        assert!(matches!(outcome, Err(LinearError::Singular { .. })), "{choice:?}: {outcome:?}");
    }
}

#[test]
fn values_that_are_not_finite_are_refused_with_their_column() {
    let w = tangent(&sheet(4), 1.1, Weights { m: 1.0, c: 0.0, k: 1.0 });
    let column = 17;
    let mut values = w.values().to_vec();
    values[w.pattern.col_ptr[column] as usize + 1] = f64::NAN;
    for choice in [LinearChoice::Cholesky, LinearChoice::Lu] {
        let mut solver = solver_for(w.pattern.clone(), choice, &ALONE).expect("the choice fits");
        assert_eq!(solver.factor(&values), Err(LinearError::NotFinite { unknown: column }), "{choice:?}");
    }
}

#[test]
fn a_tangent_that_is_not_symmetric_takes_lu_and_refuses_cholesky() {
    let mut spec = patch();
    spec.springs = vec![spring_group(&spec, Slack::None)];
    let wind = Series { t: vec![0.0], value: vec![[1.0, 2.0, 20.0]] };
    spec.air = Some(AirSpec { linear: 3.0, quadratic: 1.0, wind });
    let scene = build_network(spec, Threads::one()).expect("the fixture is sound");
    let w = tangent(&scene, 1.05, Weights { m: 1e3, c: 10.0, k: 1.0 });
    assert!(!w.pattern.symmetric);
    let (residual, _) = solve(&w, LinearChoice::Auto);
    assert!(residual < 1e-12, "{residual}");
    let refused = solver_for(w.pattern, LinearChoice::Cholesky, &ALONE).err();
    assert_eq!(refused, Some(LinearError::NotSymmetric));
}

/// Dissection of parts side by side finds the same order.
#[test]
fn the_ordering_does_not_depend_on_threads() {
    let pattern = sheet(150).assembler().expect("small").pattern;
    let [one, two, three] =
        [1, 2, 3].map(|threads| fill_reducing(&pattern, &Workers::new(threads).expect("threads")).expect("ordered"));
    assert!(one == two && one == three);
}

#[test]
fn the_ordering_is_a_permutation_that_keeps_nodes_together_and_saves_fill() {
    // 13 x 13 nodes are ordered by minimum degree, 61 x 61 by dissection.
    for side in [12, 60] {
        let scene = sheet(side);
        let pattern = scene.assembler().expect("small").pattern;
        let elimination = fill_reducing(&pattern, &ALONE).expect("ordered");
        let order = &elimination.order;
        let mut sorted = order.new_to_old.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().copied().eq(0..pattern.n() as u32), "side {side}: not a permutation");
        for (new, &old) in order.new_to_old.iter().enumerate() {
            assert_eq!(order.old_to_new[old as usize] as usize, new);
        }
        for node in order.new_to_old.chunks(3) {
            assert!(
                node[0] + 1 == node[1] && node[1] + 1 == node[2],
                "side {side}: the unknowns of a node were parted"
            );
        }
        let fill = solver_for(Arc::clone(&pattern), LinearChoice::Cholesky, &ALONE)
            .expect("symmetric")
            .stats()
            .factor_nonzeros;
        let banded = 3 * (side as usize + 2) * pattern.n();
        let fill = fill.expect("known from the analysis");
        let (counted, ratio) = (elimination.nonzeros, fill as f64 / elimination.nonzeros);
        assert!((1.0..1.6).contains(&ratio), "side {side}: {counted} entries counted, {fill} stored");
        assert!(fill < banded, "side {side}: {fill} entries, a band would have {banded}");
    }
}

/// A factor that is kept solves in single precision where that is enough, and exactly where more is asked for or single
/// precision is not enough.
#[test]
fn a_kept_factor_solves_as_exactly_as_it_is_asked_to() {
    for (side, scale, soft) in [(3, 1.0, true), (12, 1e-12, true), (40, 1e12, true), (40, 1.0, false)] {
        // A sheet without tension and almost without inertia is conditioned too badly for seven digits.
        let (stretch, m) = if soft { (1.1, 1e5) } else { (1.0 + 1e-9, 1e-3) };
        let w = tangent(&sheet(side), stretch, Weights { m, c: 0.0, k: 1.0 });
        let (pattern, values) = (&w.pattern, w.values().iter().map(|v| scale * v).collect::<Vec<f64>>());
        let [mut exact, mut kept] =
            [0; 2].map(|_| solver_for(pattern.clone(), LinearChoice::Cholesky, &ALONE).expect("symmetric"));
        assert_eq!(exact.factor(&values), Ok(Inertia::Definite));
        assert_eq!(kept.prepare(&values), Ok(Inertia::Definite));
        let b = right_hand_side(pattern.n());
        let mut expected = b.clone();
        exact.solve(&values, &mut expected).expect("definite");
        let size = expected.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        for asked in [1e-3, 1e-9] {
            kept.set_accuracy(Accuracy::to(asked));
            let mut x = b.clone();
            kept.solve(&values, &mut x).expect("definite");
            let off = x.iter().zip(&expected).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs())) / size;
            let single = soft && asked == 1e-3;
            let expected = if single { 1e-9..1e-4 } else { 0.0..1e-12 };
            assert!(expected.contains(&off), "{side} nodes wide, scale {scale}, asked for {asked}: {off:e} off");
        }
    }
}
