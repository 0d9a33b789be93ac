//! The columns of the account on a damped, forced, nonlinear net, for every scheme, against an account of our own.
//!
//! The reference is a Runge-Kutta trajectory of the test's own, 4 to 32 times finer than the runs. On it kinetic,
//! elastic and gravity energy are computed from the numbers of the case, and external work and dissipation are the
//! integrals by Simpson's rule of powers that [`crate::rich_power`] computes from them too; only the total force that
//! moves the net comes from the program. Every column of a scheme must tend to it with the scheme's order, and
//! `numerical`, which is nothing but error, to 0.

use crate::claim::Claim;
use crate::common::run::{case_of, changed, follow};
use crate::rich_net::{GRAVITY, MASS, NODES, SPRINGS, net, rule};
use crate::rich_power::{Moving, dissipated, external};
use canopy_fem::drive::Status;
use canopy_fem::drive::observer::Energies;
use canopy_fem::integrate::registry::{MethodInfo, methods};
use canopy_fem::model::forces::Forces;
use canopy_fem::model::state::State;
use canopy_fem::scene::Scene;
use canopy_fem::simulation::build_scene;
use nalgebra::Vector3;

/// [1/s] accounts are compared 16 times, at the same times whatever the step is
const ROWS: f64 = 16.0;
const COLUMNS: [&str; 6] = ["kinetic", "elastic", "gravity", "external work", "dissipated", "numerical"];

/// [-] The next term of the error bends these slopes by up to 0.11.
const TOLERANCE: f64 = 0.15;

/// [J] in the order of [`COLUMNS`].
type Account = [f64; 6];

fn columns(row: Energies) -> Account {
    [row.kinetic, row.elastic, row.gravity, row.external_work, row.dissipated, row.numerical]
}

pub fn claims() -> Vec<Claim> {
    let (coarse, reference) = (reference(12), reference(13));
    // Both the trajectory and Simpson's rule are of order 4.
    let own_error = distance(&coarse, &reference).map(|d| d / 15.0);
    let mut claims = vec![Claim::below(
        "the reference's own error, worst column [J]",
        own_error.into_iter().fold(0.0, f64::max),
        1e-11,
    )];
    for method in methods() {
        one(method, &reference, &mut claims);
    }
    claims
}

fn one(method: &MethodInfo, reference: &[Account], claims: &mut Vec<Claim>) {
    // -log2 of the steps, fine enough for the slope and coarse enough for the reference: a triangle that turns its edge
    // to the wind has a jump in the curvature of v|v| and leaves an error of h^3, small but noticed by order 4 in finer
    // steps.
    let first = match method.order {
        1 => 11,
        2 => 10,
        3 => 9,
        4 => 7,
        5 => 6,
        _ => 5,
    };
    let (coarse, fine) = (run(method.name, first), run(method.name, first + 1));
    let (e1, e2) = (distance(&coarse.rows, reference), distance(&fine.rows, reference));
    let slope = |i: usize| (e1[i] / e2[i]).log2();
    let order = f64::from(method.order);
    let accurate = method.order > 4 || method.name == "esdirk4";
    for (i, column) in COLUMNS.iter().enumerate() {
        let name = format!("{}: {column}: order", method.name);
        if method.name == "energy-momentum" && *column == "numerical" {
            // It makes and loses none, whatever the step.
            claims.push(Claim::below(format!("{name} has none: worst [J]"), e1[i].max(e2[i]), 1e-11));
            continue;
        }
        claims.push(if !accurate {
            // Central differences lose no energy in first order: their dashpots take it at other velocities.
            let lags = ["central-difference", "multirate"].contains(&method.name);
            // The account's work of a step is of second order.
            let works = method.order == 3 && ["external work", "dissipated", "numerical"].contains(column);
            let second = works || lags && *column == "numerical";
            Claim::absolute(name, slope(i), if second { 2.0 } else { order }, TOLERANCE)
        } else {
            // That jump, and the reference, hide smaller errors; `order.rs` measures them, two-sided, on a net without
            // it.
            Claim::between(name, slope(i), order.min(5.0) - 0.5, 20.0)
        });
    }
    claims.push(Claim::below(
        format!("{}: sum of the columns less its first value, worst row, over the largest column", method.name),
        coarse.open.max(fine.open),
        8.0 * f64::EPSILON,
    ));
}

/// Root mean square over the rows, column by column.
fn distance(a: &[Account], b: &[Account]) -> Account {
    assert_eq!((a.len(), b.len()), (ROWS as usize, ROWS as usize));
    let mean = |i: usize| a.iter().zip(b).map(|(a, b)| (a[i] - b[i]).powi(2)).sum::<f64>() / ROWS;
    [0, 1, 2, 3, 4, 5].map(|i| mean(i).sqrt())
}

struct Measured {
    rows: Vec<Account>,
    /// [-] by how much the account does not close
    open: f64,
}

fn run(method: &str, refinement: i32) -> Measured {
    let step = format!("{:e}", (-f64::from(refinement)).exp2());
    let case = changed(&case_of(&net(), &[]), &[("time.method", method), ("time.step", &step)]);
    let mut measured = Measured { rows: Vec::new(), open: 0.0 };
    let mut first = None;
    let outcome = follow(&case, |seen| {
        let account = columns(seen.ledger);
        let [kinetic, elastic, gravity, external, dissipated, numerical] = account;
        let sum = kinetic + elastic + gravity - external + dissipated + numerical;
        let size = account.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
        measured.open = measured.open.max((sum - *first.get_or_insert(sum)).abs() / size);
        if seen.t > 0.0 && seen.t * ROWS % 1.0 == 0.0 {
            measured.rows.push(account);
        }
    });
    assert_eq!(outcome.status, Status::Completed, "{method}, step {step}");
    assert_eq!(columns(outcome.ledger), measured.rows[measured.rows.len() - 1], "{method}: the last row");
    measured
}

/// The accounts of a classical Runge-Kutta trajectory with a step of 2^-refinement.
fn reference(refinement: i32) -> Vec<Account> {
    let case = case_of(&net(), &[]);
    let scene = build_scene(case.problem().clone().take_system(), 1).expect("the case is good");
    let h = (-f64::from(refinement)).exp2();
    let steps = 1usize << refinement;
    let every = steps / ROWS as usize;
    let mut at = scene.initial_state();
    let mut forces = scene.new_forces();
    let start = positions(&*scene, &at).0;
    let mut powers = vec![power(&*scene, &at)];
    let mut rows = Vec::new();
    for k in 1..=steps {
        at = rk4(&*scene, &at, h, &mut forces);
        powers.push(power(&*scene, &at));
        if k % every == 0 {
            let [external, dissipated] = [0, 1].map(|i| simpson(&powers, h, i));
            let [kinetic, elastic, gravity] = energies(&*scene, &at, &start);
            rows.push([kinetic, elastic, gravity, external, dissipated, 0.0]);
        }
    }
    rows
}

/// [W] of the external forces and into dashpots and Rayleigh damping.
fn power(scene: &dyn Scene, at: &State) -> [f64; 2] {
    let (x, v) = positions(scene, at);
    let vectors = |list: Vec<[f64; 3]>| list.into_iter().map(Vector3::from).collect();
    let moving = Moving { t: at.t, x: vectors(x), v: vectors(v) };
    [external(&moving), dissipated(&moving)]
}

/// Composite rule over an even number of intervals, no kink of a table inside a pair.
fn simpson(powers: &[[f64; 2]], h: f64, i: usize) -> f64 {
    powers.windows(3).step_by(2).map(|p| h / 3.0 * (p[0][i] + 4.0 * p[1][i] + p[2][i])).sum()
}

fn rk4(scene: &dyn Scene, n: &State, h: f64, forces: &mut Forces) -> State {
    let mut slopes: Vec<[Vec<f64>; 2]> = Vec::new();
    for c in [0.0, 0.5, 0.5, 1.0] {
        let stage = match slopes.last() {
            Some(last) => moved(n, c * h, last),
            None => n.clone(),
        };
        scene.evaluate(stage.as_ref(), forces);
        let a = forces.total.iter().zip(scene.inverse_mass()).map(|(f, m)| f * m).collect();
        slopes.push([stage.v, a]);
    }
    let mean = [0, 1].map(|i| {
        let at = |j: usize| (slopes[0][i][j] + 2.0 * slopes[1][i][j] + 2.0 * slopes[2][i][j] + slopes[3][i][j]) / 6.0;
        (0..n.x.len()).map(at).collect::<Vec<f64>>()
    });
    moved(n, h, &mean)
}

fn moved(n: &State, h: f64, [dx, dv]: &[Vec<f64>; 2]) -> State {
    let add = |y: &[f64], d: &[f64]| y.iter().zip(d).map(|(y, d)| y + h * d).collect();
    State { t: n.t + h, x: add(&n.x, dx), v: add(&n.v, dv) }
}

/// Positions and velocities in the user's numbering.
fn positions(scene: &dyn Scene, at: &State) -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
    let (mut x, mut v) = (vec![[0.0; 3]; NODES.len()], vec![[0.0; 3]; NODES.len()]);
    scene.trace(at.as_ref(), &mut x, &mut v);
    (x, v)
}

/// m v^2/2, k (l - l0)^2/2 with l0 from the mesh as given, and m g times the height above the start.
fn energies(scene: &dyn Scene, at: &State, start: &[[f64; 3]]) -> [f64; 3] {
    let (x, v) = positions(scene, at);
    let length = |x: &[[f64; 3]], [a, b]: [usize; 2]| (0..3).map(|c| (x[a][c] - x[b][c]).powi(2)).sum::<f64>().sqrt();
    let kinetic = v.iter().zip(MASS).map(|(v, m)| 0.5 * m * v.iter().map(|v| v * v).sum::<f64>()).sum();
    let elastic = SPRINGS.iter().enumerate().map(|(i, &s)| {
        let rule = rule(i);
        0.5 * rule.stiffness * (length(&x, s) - rule.rest_scale * length(&NODES, s)).powi(2)
    });
    let gravity = x.iter().zip(start).zip(MASS).map(|((x, o), m)| m * GRAVITY * (x[2] - o[2]));
    [kinetic, elastic.sum(), gravity.sum()]
}
