//! Conjugate gradients: solutions, what they notice, the trajectories of runs that use them, and when `auto` takes
//! them.

use crate::common::run::{Run, apart, asset, case_of, changed, run, run_with};
use crate::common::{Random, spring_group, square};
use canopy_fem::assembly::{Pattern, TangentSystem};
use canopy_fem::case::Case;
use canopy_fem::drive::Status;
use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::integrate::registry::{Family, methods};
use canopy_fem::model::spec::*;
use canopy_fem::model::state::StateRef;
use canopy_fem::model::system::{System, Weights};
use canopy_fem::model::workers::ALONE;
use canopy_fem::scene::{Network, build_network};
use canopy_fem::solve::{
    Accuracy, ExpectedUse, Inertia, LinearChoice, LinearError, LinearSolver, reusing_solver_for, solver_for,
};
use std::sync::Arc;

/// A square sheet of plain springs; every fifth node is held in one or two directions.
fn sheet(side: u32) -> Network {
    let mut spec = square(side, 1e-3);
    spec.fixed[0] = [true; 3];
    for (i, fixed) in spec.fixed.iter_mut().enumerate().skip(1).step_by(5) {
        fixed[i % 3] = true;
        fixed[2] |= i % 2 == 0;
    }
    spec.springs = vec![spring_group(&spec, Slack::None)];
    build_network(spec, Threads::one()).expect("the fixture is sound")
}

fn cg(pattern: &Arc<Pattern>) -> Box<dyn LinearSolver> {
    solver_for(Arc::clone(pattern), LinearChoice::Cg, &ALONE).expect("a symmetric pattern")
}

fn random_vector(n: usize, seed: u64) -> Vec<f64> {
    let mut random = Random(seed);
    (0..n).map(|_| random.next()).collect()
}

/// Random entries on a sheet's pattern, made positive definite by the diagonal.
fn random_definite(pattern: &Pattern, seed: u64) -> Vec<f64> {
    let mut values = random_vector(pattern.nonzeros(), seed);
    let mut rows = vec![0.1; pattern.n()];
    for j in 0..pattern.n() {
        for (&i, value) in pattern.column(j).iter().zip(&values[pattern.col_ptr[j] as usize..]) {
            rows[i as usize] += value.abs();
            rows[j] += value.abs();
        }
    }
    for (j, row) in rows.iter().enumerate() {
        values[pattern.slot(j as u32, j as u32).expect("a diagonal entry") as usize] = *row;
    }
    values
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
    norm(&mut a.iter().zip(b).map(|(a, b)| a - b)) / norm(&mut b.iter().copied())
}

/// Solutions are those of Cholesky, to what was asked for, in fewer iterations where less was asked; nodes that are
/// partly held included.
#[test]
fn solutions_are_those_of_cholesky() {
    let pattern = sheet(12).assembler().expect("small").pattern;
    assert!(pattern.node_start.windows(2).any(|w| w[1] - w[0] < 3), "some nodes are partly held");
    let mut solver = cg(&pattern);
    let mut direct = solver_for(pattern.clone(), LinearChoice::Cholesky, &ALONE).expect("symmetric");
    for seed in 0..20 {
        let values = random_definite(&pattern, seed);
        let b = random_vector(pattern.n(), 100 + seed);
        let mut expected = b.clone();
        direct.factor(&values).expect("definite");
        direct.solve(&values, &mut expected).expect("definite");
        assert_eq!(solver.factor(&values), Ok(Inertia::Unknown));
        let mut before = 0;
        for relative in [1e-2, 1e-6, 1e-12] {
            solver.set_accuracy(Accuracy::to(relative));
            let (mut x, made) = (b.clone(), solver.work().iterations);
            solver.solve(&values, &mut x).expect("definite");
            let (off, iterations) = (difference(&x, &expected), solver.work().iterations - made);
            assert!(off < 30.0 * relative, "seed {seed}: {off:e} off where {relative:e} was asked for");
            assert!(iterations > before && iterations < 100, "seed {seed}: {iterations} after {before}");
            before = iterations;
        }
    }
    solver.solve(&random_definite(&pattern, 0), &mut vec![0.0; pattern.n()]).expect("nothing to do");
    assert_eq!(solver.work().factorizations, 0);
}

/// W of a sheet shrunk about the origin: springs in compression.
fn compressed(scene: &Network, scale: f64) -> (Arc<Pattern>, Vec<f64>) {
    let state = scene.initial_state();
    let x: Vec<f64> = state.x.iter().map(|x| scale * x).collect();
    let mut assembler = scene.assembler().expect("small");
    let w = Weights { m: 10.0, c: 0.0, k: 1.0 };
    scene.assemble(StateRef { t: 0.0, x: &x, v: &state.v }, w, &mut assembler);
    (assembler.pattern.clone(), assembler.values().to_vec())
}

/// An indefinite matrix is an error that leaves the right-hand side, or found before any solve; whichever is chosen
/// automatically says so.
#[test]
fn an_indefinite_matrix_is_noticed() {
    for scale in [0.9, 0.7, 0.3] {
        let (pattern, values) = compressed(&sheet(12), scale);
        let mut solver = cg(&pattern);
        let b = random_vector(pattern.n(), 3);
        let mut x = b.clone();
        let outcome = match solver.factor(&values).expect("finite") {
            Inertia::Indefinite => Err(LinearError::Indefinite { iterations: 0 }),
            _ => solver.solve(&values, &mut x),
        };
        assert!(matches!(outcome, Err(LinearError::Indefinite { .. })), "scale {scale}: {outcome:?}");
        assert_eq!(x, b, "scale {scale}");
        assert_eq!(solver.stats().indefinite, 1, "scale {scale}");
        let mut weighed = reusing_solver_for(pattern, LinearChoice::Auto, &ALONE).expect("symmetric");
        assert_eq!(weighed.prepare(&values), Ok(Inertia::Indefinite), "scale {scale}");
    }
}

#[test]
fn values_that_are_not_finite_are_refused_with_their_column() {
    let pattern = sheet(4).assembler().expect("small").pattern;
    let mut values = random_definite(&pattern, 1);
    values[pattern.col_ptr[17] as usize + 1] = f64::NAN;
    assert_eq!(cg(&pattern).factor(&values), Err(LinearError::NotFinite { unknown: 17 }));
}

/// However exact a solution is asked for, a right-hand side with a number that is none is refused and left as it was.
#[test]
fn a_right_hand_side_that_is_not_finite_is_refused() {
    let pattern = sheet(4).assembler().expect("small").pattern;
    let values = random_definite(&pattern, 1);
    let mut solver = cg(&pattern);
    solver.factor(&values).expect("definite");
    for relative in [1e-3, 1e-12] {
        solver.set_accuracy(Accuracy::to(relative));
        for bad in [f64::NAN, f64::INFINITY] {
            let mut b = random_vector(pattern.n(), 2);
            b[7] = bad;
            let mut x = b.clone();
            let outcome = solver.solve(&values, &mut x);
            assert_eq!(outcome, Err(LinearError::Singular { unknown: None }), "{bad} to {relative:e}");
            assert!(x.iter().zip(&b).all(|(x, b)| x.to_bits() == b.to_bits()), "{bad} to {relative:e}");
        }
    }
}

/// Nodes in a row that move along it.
fn chain(n: u32) -> Pattern {
    Pattern {
        col_ptr: (0..=n).map(|j| if j < n { 2 * j } else { 2 * n - 1 }).collect(),
        row_idx: (0..n).flat_map(|j| [j, j + 1]).take(2 * n as usize - 1).collect(),
        symmetric: true,
        dof: (0..n).map(|i| 3 * i).collect(),
        node_start: (0..=n).collect(),
        position: (0..n).map(|i| [f64::from(i), 0.0, 0.0]).collect(),
    }
}

/// A long chain without inertia whose stiffness jumps up and down by ten powers of ten: rounding keeps conjugate
/// gradients from its solution. Their error has its numbers, and the solver that chooses gives the matrix to Cholesky.
#[test]
fn a_solve_that_does_not_converge_ends_with_its_numbers() {
    let n = 600;
    let pattern = Arc::new(chain(n));
    let stiffness = |i: u32| 10_f64.powi((7 * i % 11) as i32);
    let mut values = Vec::new();
    for j in 0..n {
        values.push(stiffness(j) + stiffness(j + 1));
        values.extend((j + 1 < n).then(|| -stiffness(j + 1)));
    }
    let mut solver = cg(&pattern);
    solver.factor(&values).expect("definite");
    solver.set_accuracy(Accuracy::to(1e-10));
    let b = random_vector(n as usize, 5);
    match solver.solve(&values, &mut b.clone()) {
        Err(error @ LinearError::Stalled { iterations, residual, asked }) => {
            assert!(iterations >= n && residual > asked && asked == 1e-10, "{error:?}");
            assert!(error.to_string().contains("\"cholesky\" or \"auto\", or a smaller step"), "{error}");
        }
        other => panic!("{other:?}"),
    }
    let mut weighed = reusing_solver_for(pattern.clone(), LinearChoice::Auto, &ALONE).expect("symmetric");
    assert_eq!(weighed.prepare(&values), Ok(Inertia::Definite));
    let mut x = b;
    weighed.solve(&values, &mut x).expect("definite");
    let stats = weighed.stats();
    assert!(stats.name == "cholesky" && stats.prediction.is_some_and(|p| !p.cg_converged), "{stats:?}");
}

/// W of a sheet at rest, `side` springs along an edge, with unit springs and m of a node's mass; every `nth` spring is
/// `stiffer` times as stiff.
fn at_rest(side: u32, m: f64, springs: (usize, f64)) -> (Arc<Pattern>, Vec<f64>) {
    of_unit_springs(square(side, m), springs, 1.0)
}

/// W of springs of 1 N/m, every `nth` of them `stiffer` times as stiff, all `scale` times as long as at rest.
fn of_unit_springs(mut spec: NetworkSpec, (nth, stiffer): (usize, f64), scale: f64) -> (Arc<Pattern>, Vec<f64>) {
    let mut springs = spring_group(&spec, Slack::None);
    springs.stiffness = (0..springs.edges.len()).map(|i| if i % nth == 0 { stiffer } else { 1.0 }).collect();
    spec.springs = vec![springs];
    let scene = build_network(spec, Threads::one()).expect("the fixture is sound");
    let (mut assembler, mut state) = (scene.assembler().expect("small"), scene.initial_state());
    state.x.iter_mut().for_each(|x| *x *= scale);
    scene.assemble(state.as_ref(), Weights { m: 1.0, c: 0.0, k: 1.0 }, &mut assembler);
    (assembler.pattern.clone(), assembler.values().to_vec())
}

/// A right-hand side that has a part of every motion, its solution to a relative residual, and the iterations that
/// took.
fn solution((pattern, values): &(Arc<Pattern>, Vec<f64>), relative: f64) -> (Vec<f64>, Vec<f64>, u64) {
    let (mut solver, b) = (cg(pattern), random_vector(pattern.n(), 7));
    assert_eq!(solver.factor(values), Ok(Inertia::Unknown));
    solver.set_accuracy(Accuracy::to(relative));
    let (mut x, before) = (b.clone(), solver.work().iterations);
    solver.solve(values, &mut x).expect("definite");
    (b, x, solver.work().iterations - before)
}

/// The preconditioner is a factorisation but for its fill, of which a chain has none, and a shift of a hundredth:
/// iterations stay few however long it is. Pivots that were blocks of W (symmetric Gauss-Seidel) took 37, 210 and 244.
/// The longest chain gets multigrid, and takes 51 iterations without.
#[test]
fn a_long_chain_takes_few_iterations() {
    let found = [100, 1000, 10_000].map(|n| {
        let values: Vec<f64> =
            (0..n).flat_map(|j| [2.0001, -1.0].into_iter().take(if j + 1 < n { 2 } else { 1 })).collect();
        solution(&(Arc::new(chain(n)), values), 1e-3).2
    });
    assert_eq!(found, [10, 45, 3]);
}

/// On sheets the fill comes to the diagonal, and smooth motions meet it as they meet W; the widest is eliminated in two
/// sections, and takes 14 in one. Symmetric Gauss-Seidel took 21, 19, 19 and 39, 30. The widest and stiffest gets
/// multigrid, and takes 31 iterations without.
#[test]
fn sheets_take_few_iterations() {
    let found = [1e-2, 1e-3].map(|m| [20, 40, 80].map(|side| solution(&at_rest(side, m, (1, 1.0)), 1e-3).2));
    assert_eq!(found, [[14, 13, 14], [25, 23, 4]]);
}

/// A sheet in waves of unit springs, or flat but for a patch of so many nodes' width.
fn wrinkled(side: u32, m: f64, amplitude: f64, patch: Option<f64>) -> (Arc<Pattern>, Vec<f64>) {
    let mut spec = square(side, m);
    let (side, middle) = (f64::from(side), 0.55 * f64::from(side));
    for x in &mut spec.mesh.nodes {
        let [i, j] = [side * x[0], side * x[1]];
        let off = (i - middle).abs().max((j - middle).abs());
        let share = patch.map_or(1.0, |width| (1.0 - (2.0 * off / width).powi(6)).max(0.0));
        let wave = (0.6 * i).sin() * (0.42 * j + 1.0).cos() + 0.5 * (1.02 * (i + j)).sin();
        x[2] = share * amplitude / side * wave;
    }
    of_unit_springs(spec, (1, 1.0), 1.0)
}

/// In waves, low motions are no translations: fill on the diagonal would make M nearly singular, and its residual tell
/// nothing (1,107 iterations in the second case, 2,176 in the last), so pivots are made without. Symmetric Gauss-Seidel
/// took 26, 83, 33 and 104 in the first four.
#[test]
fn wrinkled_sheets() {
    let waves = [(0.3, 1e-2, 35), (0.3, 1e-3, 90), (1.0, 1e-2, 35), (1.0, 1e-3, 115)];
    let waves = waves.map(|(amplitude, m, most)| (wrinkled(70, m, amplitude, None), most));
    let patches = [(10.0, 45), (40.0, 60)].map(|(width, most)| (wrinkled(200, 1e-3, 1.0, Some(width)), most));
    for (i, (system, most)) in waves.into_iter().chain(patches).enumerate() {
        let (off, made) = apart_from_cholesky(&system, 1e-3);
        assert!(off < 5e-3 && made < most, "case {i}: {off:e} off after {made}");
    }
}

/// So it is in eight sections. With fill the trial would fail, and multigrid take 9 iterations.
#[test]
fn a_wrinkled_sheet_in_eight_sections() {
    assert_eq!(solution(&wrinkled(520, 0.03, 1.0, None), 1e-3).2, 18);
}

/// How far a solution to a relative residual is from that of Cholesky, and after how many iterations.
fn apart_from_cholesky(system: &(Arc<Pattern>, Vec<f64>), relative: f64) -> (f64, u64) {
    let (pattern, values) = system;
    let (mut expected, x, iterations) = solution(system, relative);
    let mut direct = solver_for(pattern.clone(), LinearChoice::Cholesky, &ALONE).expect("symmetric");
    direct.factor(values).expect("definite");
    direct.solve(values, &mut expected).expect("definite");
    (difference(&x, &expected), iterations)
}

/// Where springs a thousand times stiffer than their neighbours meet them, fill would leave nothing of pivots, and is
/// left out: solutions are those of Cholesky, as near as residuals of 1e-6 tell there. Symmetric Gauss-Seidel took 699,
/// 605 and 155.
#[test]
fn stiff_springs_among_soft_ones() {
    for (springs, near, most) in [((7, 1e3), 1e-3, 450), ((37, 1e5), 1e-2, 580), ((3, 1e-3), 1e-3, 180)] {
        let (off, made) = apart_from_cholesky(&at_rest(40, 1e-3, springs), 1e-6);
        assert!(off < near && made < most, "{springs:?}: {off:e} off after {made} iterations");
    }
}

const DEAD: &str = r#"[{"on": "all", "pressure": 60.0, "kind": "dead", "direction": [0, 0, 1]}]"#;

/// The 703-node cloth in the wind, whose tangent is not symmetric; and under a dead pressure, with springs that go
/// slack.
fn scenes() -> [(&'static str, Case); 2] {
    let base = asset("cloth-k1000", &[("time.end", "0.05"), ("output", "{}")]);
    let calm = [
        ("system.network.aero", "null"),
        ("system.network.loads", DEAD),
        ("system.network.springs.0.slack", "tension-only"),
    ];
    [("air", base.clone()), ("calm", changed(&base, &calm))]
}

fn solved(case: &Case, sets: &[(&str, &str)]) -> Run {
    let found = run(&changed(case, sets));
    let outcome = &found.outcome;
    assert_eq!(outcome.status, Status::Completed, "{sets:?}: {:?}", outcome.failure);
    found
}

/// However the linear systems are solved, steps end at the same residual: trajectories agree to 1e-6 of the motion, as
/// those of the strategies do, and nothing is factorised.
#[test]
fn trajectories_are_those_of_direct_solvers() {
    for (scene, case) in scenes() {
        for method in methods().iter().filter(|m| m.family == Family::Implicit) {
            for step in ["1e-3", "1e-2"] {
                let common = [("time.method", method.name), ("time.step", step)];
                let with = |linear, strategy| {
                    let own = [("solver.linear", linear), ("solver.newton.strategy", strategy)];
                    solved(&case, &[&common[..], &own].concat())
                };
                let direct = with("auto", "full");
                // The tangent of a discrete gradient is not symmetric even in calm air.
                let symmetric = scene == "calm" && method.name != "energy-momentum";
                let strategies: &[&str] = if symmetric { &["auto", "modified", "full"] } else { &["auto", "modified"] };
                for strategy in strategies {
                    let found = with("cg", strategy);
                    let (off, counters) = (apart(&direct, &found), found.outcome.counters);
                    let what = format!("{} at {step}, {scene}, {strategy}", method.name);
                    assert!(off < 1e-6, "{what}: {off:e} apart");
                    assert!(counters.factorizations == 0 && counters.cg_iterations > 0, "{what}: {counters:?}");
                    assert_eq!(found.outcome.linear.map(|l| l.name), Some("cg"), "{what}");
                }
            }
        }
    }
}

/// Buckled springs make the tangent indefinite; the convex one takes over. Such a net has several ways to bulge, which
/// differ by less than a hundredth in energy; either solver finds one.
#[test]
fn compressed_springs_are_no_obstacle() {
    let case = asset(
        "cloth-k100",
        &[
            ("time.end", "0.06"),
            ("time.step", "0.03"),
            ("time.method", "backward-euler"),
            ("output", "{}"),
            ("system.network.aero", "null"),
            ("system.network.springs.0.rest_scale", "1.05"),
            ("system.network.loads", DEAD),
        ],
    );
    let direct = solved(&case, &[("solver.linear", "cholesky"), ("solver.newton.strategy", "full")]);
    for strategy in ["full", "auto"] {
        let found = solved(&case, &[("solver.linear", "cg"), ("solver.newton.strategy", strategy)]);
        let [own, other] = [&found, &direct].map(|run| run.outcome.ledger.elastic);
        assert!((own - other).abs() < 0.02 * other, "{strategy}: {own} J, {other} J by Cholesky");
        let stats = found.outcome.linear.expect("an implicit run");
        assert!(stats.indefinite > 0, "{strategy}: the case must have an indefinite tangent on its way: {stats:?}");
    }
}

/// `auto` takes conjugate gradients in small steps of soft cloths and Cholesky in long ones of stiff cloths, and tells
/// both prices.
#[test]
fn auto_takes_what_costs_less() {
    let base = asset("cloth-k1000", &[("time.end", "0.01"), ("time.method", "newmark"), ("output", "{}")]);
    for (stiffness, step, expected) in [("1e3", "1e-3", "cg"), ("1e5", "5e-3", "cholesky")] {
        let found = solved(&base, &[("system.network.springs.0.stiffness", stiffness), ("time.step", step)]).outcome;
        let stats = found.linear.expect("an implicit run");
        let prediction = stats.prediction.expect("there was a choice");
        assert_eq!(stats.name, expected, "K {stiffness} at {step}: {prediction:?}");
        assert_eq!(prediction.cg_converged, expected == "cg");
        assert_eq!(prediction.cg_work < prediction.cholesky_work, prediction.cg_converged, "{prediction:?}");
        assert_eq!(stats.factor_nonzeros.is_some(), expected == "cholesky");
        assert_eq!(found.counters.factorizations > 0, expected == "cholesky", "{:?}", found.counters);
    }
}

/// W of a sheet at rest whose hem is `stiffer` times as stiff as its cloth.
fn hemmed(side: u32, stiffer: f64) -> (Arc<Pattern>, Vec<f64>) {
    let mut spec = square(side, 1.0);
    let mut springs = spring_group(&spec, Slack::None);
    let nodes = &spec.mesh.nodes;
    let ends = [0, 1].map(|axis| {
        let along = nodes.iter().map(|x| x[axis]);
        [along.clone().fold(f64::INFINITY, f64::min), along.fold(f64::NEG_INFINITY, f64::max)]
    });
    let on_hem = |&[a, b]: &[u32; 2]| {
        let [a, b] = [nodes[a as usize], nodes[b as usize]];
        (0..2).any(|axis| a[axis] == b[axis] && ends[axis].contains(&a[axis]))
    };
    let k = |&edge: &u32| if on_hem(&spec.mesh.edges[edge as usize]) { stiffer } else { 1.0 };
    springs.stiffness = springs.edges.iter().map(k).collect();
    spec.springs = vec![springs];
    let scene = build_network(spec, Threads::one()).expect("the fixture is sound");
    let (mut assembler, state) = (scene.assembler().expect("small"), scene.initial_state());
    scene.assemble(state.as_ref(), Weights { m: 1.0, c: 0.0, k: 1.0 }, &mut assembler);
    (assembler.pattern.clone(), assembler.values().to_vec())
}

/// The trial does not see how long a chain of stiff nodes takes, so `auto` does not begin with conjugate gradients; a
/// payload, or a hem as stiff as its cloth, is no such chain.
#[test]
fn a_stiff_hem_gets_cholesky_at_once() {
    for (stiffer, far_apart) in [(1.0, false), (100.0, false), (1e4, true)] {
        let (pattern, values) = hemmed(40, stiffer);
        let mut solver = reusing_solver_for(pattern.clone(), LinearChoice::Auto, &ALONE).expect("symmetric");
        solver.prepare(&values).expect("definite");
        let prediction = solver.stats().prediction.expect("there was a choice");
        assert_eq!(prediction.far_apart, far_apart, "{stiffer}: {prediction:?}");
        assert_eq!(solver.work().iterations == 0, far_apart, "{stiffer}: {:?}", solver.work());
        assert!(!far_apart || solver.stats().name == "cholesky", "{:?}", solver.stats());
    }
}

/// A solve by conjugate gradients that costs more than a factor is given up for one: most of its iterations are not
/// made, they count for the next choice, and the next solve does not begin with them again.
#[test]
fn no_solve_costs_more_than_a_factor() {
    let (pattern, values) = at_rest(40, 1e-3, (7, 1e3));
    let b = random_vector(pattern.n(), 7);
    let mut alone = cg(&pattern);
    alone.factor(&values).expect("definite");
    let mut solver = reusing_solver_for(pattern.clone(), LinearChoice::Auto, &ALONE).expect("symmetric");
    // As if earlier solves had taken one iteration.
    solver.set_expected_use(ExpectedUse { cg_iterations: 1.0, ..ExpectedUse::default() });
    solver.prepare(&values).expect("definite");
    assert_eq!((solver.stats().name, solver.work().factorizations), ("cg", 0));
    let [whole, given_up] = [&mut alone, &mut solver].map(|solver| {
        let before = solver.work().iterations;
        solver.set_accuracy(Accuracy::to(1e-6));
        solver.solve(&values, &mut b.clone()).expect("definite");
        solver.work().iterations - before
    });
    assert!(given_up > 0 && 3 * given_up < whole, "{given_up} of {whole} iterations");
    assert_eq!(solver.work().factorizations, 1);
    assert!(solver.cg_cost() > alone.cg_cost());
    let after = solver.work();
    let mut x = b.clone();
    solver.solve(&values, &mut x).expect("definite");
    assert_eq!(solver.work(), after);
    let mut left = vec![0.0; x.len()];
    pattern.multiply(&values, &x, &mut left);
    assert!(difference(&left, &b) < 1e-3, "{}", difference(&left, &b));
}

/// A large matrix that is solved with once is left to conjugate gradients. Where the solve finds it indefinite, it says
/// so, or a factor does if the matrix was said to be definite.
#[test]
fn a_large_matrix_that_is_solved_with_once_may_be_left_to_gradients() {
    // Compressed springs take 0.67 from the diagonal of W, and more from motions of short waves.
    for (scale, m, indefinite) in [(1.0, 0.1, false), (0.9, 0.8, true)] {
        let (pattern, values) = of_unit_springs(square(64, m), (1, 1.0), scale);
        let b = random_vector(pattern.n(), 3);
        for definite in [false, true] {
            let mut solver = reusing_solver_for(pattern.clone(), LinearChoice::Auto, &ALONE).expect("symmetric");
            solver.set_accuracy(Accuracy::to(1e-8));
            let expected = ExpectedUse { cg_iterations: 4.0, ..ExpectedUse::default() };
            assert_eq!(solver.factor_once(&values, definite, expected), Ok(Inertia::Unknown), "scale {scale}");
            assert_eq!(solver.work().factorizations, 0);
            let mut x = b.clone();
            let outcome = solver.solve(&values, &mut x);
            let factors = solver.work().factorizations;
            if indefinite {
                assert!(matches!(outcome, Err(LinearError::Indefinite { .. })), "{outcome:?}");
                assert_eq!((factors, x == b), (u64::from(definite), true), "definite: {definite}");
            } else {
                assert_eq!((outcome, factors), (Ok(()), 0));
                let mut left = vec![0.0; x.len()];
                pattern.multiply(&values, &x, &mut left);
                assert!(difference(&left, &b) < 1e-6, "{}", difference(&left, &b));
            }
        }
    }
}

/// A factor is worth its work where many iterations are to come, not where the run ends after a few.
#[test]
fn the_end_of_a_run_decides_whether_a_factor_is_worth_it() {
    let (pattern, values) = at_rest(40, 1e-3, (7, 1e3));
    let names = [f64::INFINITY, 1e3, 2.0].map(|left| {
        let mut solver = reusing_solver_for(pattern.clone(), LinearChoice::Auto, &ALONE).expect("symmetric");
        let expected = ExpectedUse { cg_iterations: 30.0, left, ..ExpectedUse::default() };
        solver.set_expected_use(expected);
        solver.prepare(&values).expect("definite");
        assert_eq!(solver.prefers_other_solver(ExpectedUse { left: f64::INFINITY, ..expected }), left == 2.0);
        solver.stats().name
    });
    assert_eq!(names, ["cholesky", "cholesky", "cg"]);
}

/// Work repeats exactly, on any machine and with any number of threads; so do the bits.
#[test]
fn the_work_of_conjugate_gradients() {
    let case = asset("cloth-k1000", &[("time.end", "0.1"), ("output", "{}"), ("solver.linear", "cg")]);
    let case = changed(&case, &[("time.method", "newmark"), ("time.step", "1e-3")]);
    let [one, two] = [1, 2].map(|threads| run_with(&case, threads));
    assert!(one.state == two.state && one.outcome.counters == two.outcome.counters);
    let c = one.outcome.counters;
    assert_eq!(
        [c.force_evaluations, c.tangent_assemblies, c.factorizations, c.linear_solves, c.cg_iterations],
        [307, 3, 0, 206, 385],
        "{c:?}"
    );
}

/// Nets of 4,096 nodes or more are eliminated in two sections, and those of 262,144 or more in eight, which threads
/// share: the bits and the work do not depend on their number. Both nets have fill in their pivots, and take 41
/// and 72 iterations without.
#[test]
fn sections_of_a_net_give_the_same_bits_on_any_number_of_threads() {
    let net = |side: u32| {
        let net = serde_json::json!({"name": "net", "system": {"network": {
            "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": side, "rows": side}},
            "mass": {"areal_density": 2.0}, "springs": [{"on": "all", "stiffness": 1000.0}],
            "supports": [{"on": "boundary", "fix": "xyz"}], "gravity": [3, 2, -9]}},
            "time": {"end": 1e-3, "step": 1e-3, "method": "newmark"}, "solver": {"linear": "cg"}, "output": {}});
        case_of(&net, &[])
    };
    let annulus = asset("big/annulus-10k", &[("time.end", "4e-3"), ("output", "{}"), ("solver.linear", "cg")]);
    for (case, exact) in [(annulus, None), (net(300), Some(29)), (net(520), Some(52))] {
        let [one, two, three] = [1, 2, 3].map(|threads| run_with(&case, threads));
        let counters = one.outcome.counters;
        assert!(counters.cg_iterations > 20, "{counters:?}");
        assert!(exact.is_none_or(|exact| counters.cg_iterations == exact), "{counters:?}");
        for other in [two, three] {
            assert!(one.state == other.state && one.outcome.counters == other.outcome.counters);
        }
    }
}

/// Multigrid on a large stiff net: few iterations, the trajectory of Cholesky, and the same bits on any number of
/// threads.
#[test]
fn multigrid_on_a_large_stiff_net() {
    let net = serde_json::json!({"name": "net", "system": {"network": {
        "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": 249, "rows": 249}},
        "mass": {"areal_density": 0.1}, "springs": [{"on": "all", "stiffness": 1e4}],
        "supports": [{"on": "boundary", "fix": "xyz"}], "gravity": [0, 0, -9.81]}},
        "time": {"end": 4e-3, "step": 2e-3, "method": "newmark"}, "output": {}});
    let case = case_of(&net, &[]);
    let case = changed(&case, &[("solver.linear", "cg")]);
    let [one, two] = [1, 2].map(|threads| run_with(&case, threads));
    assert!(one.state == two.state && one.outcome.counters == two.outcome.counters);
    let c = one.outcome.counters;
    assert!(c.cg_iterations < 15 * c.linear_solves, "{c:?}");
    let exact = run(&changed(&case, &[("solver.linear", "cholesky")]));
    let sag = exact.state.x.iter().skip(2).step_by(3).fold(0.0_f64, |most, z| most.max(z.abs()));
    // Newton's last iterations ask for more than single precision has.
    let full = run(&changed(&case, &[("solver.newton.strategy", "full"), ("solver.newton.relative", "1e-11")]));
    let auto = run(&changed(&case, &[("solver.linear", "auto"), ("time.end", "0.016")]));
    let (c, linear) = (auto.outcome.counters, auto.outcome.linear.expect("an implicit run"));
    let seen = c.cg_iterations as f64 / c.linear_solves as f64;
    let told = linear.prediction.map(|p| f64::from(p.cg_iterations));
    let well_told = linear.name == "cg" && told.is_some_and(|told| (told / seen - 1.0).abs() < 0.5);
    // Here a factor is as much work, so that either may be taken.
    let alike = linear.prediction.is_some_and(|p| (p.cg_work / p.cholesky_work - 1.0).abs() < 0.1);
    assert!(well_told || alike, "{linear:?} {c:?}");
    // It buckles at 0.014 s, where matrices of true Newton iterations are solved with once.
    assert!(c.tangent_assemblies > 2 * c.factorizations, "{c:?}");
    for (found, most) in [(one, 1e-6), (full, 1e-8)] {
        let off = found.state.x.iter().zip(&exact.state.x).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        assert!(off < most * sag, "{off:e} of {sag:e}");
    }
}

/// A net so stiff that single precision holds hardly three digits of a solution takes the trajectory of Cholesky.
#[test]
fn multigrid_on_a_very_stiff_net() {
    let net = serde_json::json!({"name": "net", "system": {"network": {
        "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": 240, "rows": 240}},
        "mass": {"areal_density": 2.0},
        "springs": [{"on": "all", "stiffness": 1e9, "dashpot": {"relative": {"time": 5e-4}}}],
        "supports": [{"on": "boundary", "fix": "xyz"}], "gravity": [3, 2, -9]}},
        "time": {"end": 3e-3, "step": 1e-3, "method": "newmark"}, "output": {}});
    let case = case_of(&net, &[]);
    let [iterated, exact] = ["cg", "cholesky"].map(|solver| run(&changed(&case, &[("solver.linear", solver)])));
    let c = iterated.outcome.counters;
    assert_eq!((iterated.outcome.status, c.factorizations), (Status::Completed, 0), "{c:?}");
    assert!(c.cg_iterations < 25 * c.linear_solves, "{c:?}");
    let most = |from: &[[f64; 3]], axis: usize| {
        let off = exact.positions.iter().zip(from).map(|(x, other)| (x[axis] - other[axis]).abs());
        off.fold(0.0, f64::max)
    };
    for axis in 0..3 {
        let (off, moved) = (most(&iterated.positions, axis), most(&exact.reference, axis));
        assert!(off < 1e-5 * moved, "axis {axis}: {off:e} of {moved:e}");
    }
}
