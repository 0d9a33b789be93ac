//! A regular triangular net of springs k, length a, pull T, masses m. A wave u exp(i q x) meets the dynamical matrix
//!
//! D(q) = 2/m sum over the 3 bonds r of (1 - cos q r) (k n n^T + T/a (I - n n^T)), n = r/a
//!
//! (Ashcroft and Mermin, Solid State Physics, chapter 22). Without pull: long waves have c_p^2 = 9 k a^2/(8 m), c_s^2 =
//! 3 k a^2/(8 m), in every direction, so c_p/c_s = sqrt 3, Poisson's ratio 1/3; the fastest has w^2 = 6 k/m, at q = 2
//! pi/(a sqrt 3) across a bond. Verlet is stable below 2/w = 0.816 sqrt(m/k); the thesis' rule, Eq. 72, is pi
//! sqrt(m/k).

use crate::claim::Claim;
use crate::common::run::case_of;
use crate::linearised::Linearised;
use crate::signal::Signal;
use canopy_fem::analysis::spectrum::Spectrum;
use canopy_fem::case::Case;
use canopy_fem::simulation::build_scene;
use nalgebra::{Matrix3, Vector3};
use serde_json::json;
use std::f64::consts::{PI, SQRT_2, TAU};

/// [m], [N/m], [kg]
const A: f64 = 0.3;
const K: f64 = 50.0;
const M: f64 = 0.2;
/// nodes a side of the rhombus
const SIDE: usize = 12;
const BONDS: [Vector3<f64>; 3] =
    [Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.5, HALF_ROOT3, 0.0), Vector3::new(-0.5, HALF_ROOT3, 0.0)];
const HALF_ROOT3: f64 = 0.866_025_403_784_438_6;

/// How a net is started and run.
struct Start<'a> {
    displacement: &'a [[f64; 3]],
    step: f64,
    steps: u32,
}

/// A rhombus of SIDE x SIDE nodes, free in all directions, with a pull `tension` in every spring.
fn net(tension: f64, start: &Start<'_>) -> Case {
    let nodes: Vec<[f64; 3]> = (0..SIDE * SIDE).map(|i| place(i).into()).collect();
    let mut springs = Vec::new();
    for (i, j) in (0..SIDE * SIDE).map(|n| (n % SIDE, n / SIDE)) {
        let node = |i: usize, j: usize| i + SIDE * j;
        let ends =
            [(i + 1 < SIDE, i + 1, j), (j + 1 < SIDE, i, j + 1), (j + 1 < SIDE && i > 0, i.wrapping_sub(1), j + 1)];
        springs.extend(ends.iter().filter(|e| e.0).map(|e| [node(i, j), node(e.1, e.2)]));
    }
    let case = json!({
        "name": "net",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": nodes, "springs": springs}},
            "mass": {"nodal": M},
            "springs": [{"on": "all", "stiffness": K, "rest_length": A - tension / K}],
            "initial": {"displacement": start.displacement}
        }},
        "time": {"end": start.step * f64::from(start.steps), "method": "velocity-verlet", "step": start.step}
    });
    case_of(&case, &[])
}

fn still(tension: f64) -> Case {
    net(tension, &Start { displacement: &[[0.0; 3]; SIDE * SIDE], step: 1.0, steps: 1 })
}

fn place(node: usize) -> Vector3<f64> {
    A * ((node % SIDE) as f64 * BONDS[0] + (node / SIDE) as f64 * BONDS[1])
}

/// Nodes with all six neighbours.
fn inside(node: usize) -> bool {
    [node % SIDE, node / SIDE].iter().all(|&i| i > 0 && i + 1 < SIDE)
}

/// [1/s^2] D(q).
fn dynamical(q: Vector3<f64>, tension: f64) -> Matrix3<f64> {
    let bond = |n: &Vector3<f64>| {
        let along = Matrix3::from_columns(&[*n * n.x, *n * n.y, *n * n.z]);
        // 1 - cos without its cancellation at long waves.
        let turn = 2.0 * (0.5 * A * q.dot(n)).sin().powi(2);
        turn * (K * along + tension / A * (Matrix3::identity() - along))
    };
    BONDS.iter().map(bond).fold(Matrix3::zeros(), |sum, b| sum + b) * (2.0 / M)
}

/// [1/s^2] M^-1 K e cos(q (x - x_c) + phase) at every node over the same cosine's amplitude.
fn answer(linear: &Linearised, q: Vector3<f64>, e: Vector3<f64>, phase: f64) -> Vec<Vector3<f64>> {
    let u: Vec<[f64; 3]> = (0..SIDE * SIDE).map(|i| (e * wave(q, i, phase)).into()).collect();
    linear.times(&u).iter().map(|f| Vector3::from(*f) / M).collect()
}

fn wave(q: Vector3<f64>, node: usize, phase: f64) -> f64 {
    (q.dot(&(place(node) - place(CENTRE))) + phase).cos()
}

const CENTRE: usize = SIDE / 2 * (SIDE + 1);

/// Largest difference of the tangent and D(q), inside, over k/m.
fn difference(linear: &Linearised, q: Vector3<f64>, tension: f64) -> f64 {
    let mut worst = 0.0_f64;
    for e in [Vector3::x(), Vector3::y(), Vector3::z()] {
        for phase in [0.0, 0.5 * PI] {
            let expected = dynamical(q, tension) * e;
            for (node, found) in answer(linear, q, e, phase).iter().enumerate().filter(|(node, _)| inside(*node)) {
                worst = worst.max((found - expected * wave(q, node, phase)).norm());
            }
        }
    }
    worst * M / K
}

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    for tension in [0.0, 0.2 * K * A, -0.1 * K * A] {
        let linear = Linearised::of(&still(tension));
        for (x, y) in [(0.3, 0.1), (2.0, -1.3), (3.9, 0.4), (0.0, TAU / (2.0 * HALF_ROOT3))] {
            let q = Vector3::new(x, y, 0.0) / A;
            // Rounding of the phases, up to 40, and of n, 1e-16 each.
            let what = format!(
                "tangent on waves of q a = ({x:.2}, {y:.2}), T = {:.1} k a: off D(q), over k/m",
                tension / K / A
            );
            claims.push(Claim::below(what, difference(&linear, q, tension), 5e-14));
        }
    }
    let linear = Linearised::of(&still(0.0));
    claims.extend(long_waves(&linear));
    claims.extend(fastest(&linear));
    claims
}

/// [m/s] Speed of a long wave by the tangent; `e` along or across `direction`.
fn speed(linear: &Linearised, direction: Vector3<f64>, e: Vector3<f64>) -> f64 {
    let q = LONG * direction / A;
    (answer(linear, q, e, 0.0)[CENTRE].dot(&e)).sqrt() / q.norm()
}

/// [-] q a of a long wave.
const LONG: f64 = 0.01;

fn long_waves(linear: &Linearised) -> Vec<Claim> {
    let mut claims = Vec::new();
    let unit = A * (K / M).sqrt();
    for degrees in [0.0, 17.0, 30.0_f64] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let (along, across) = (Vector3::new(cos, sin, 0.0), Vector3::new(-sin, cos, 0.0));
        let [p, s] = [along, across].map(|e| speed(linear, along, e) / unit);
        // The next term of cos is (q a)^2/12 of the first in w^2: 4e-6 in w, times at most 1.
        let at = format!("long waves at {degrees} degrees");
        claims.push(Claim::relative(format!("{at}: c_p/(a sqrt(k/m)) = 3/sqrt 8"), p, 3.0 / (2.0 * SQRT_2), 5e-6));
        claims.push(Claim::relative(format!("{at}: c_s/(a sqrt(k/m)) = sqrt(3/8)"), s, 0.375_f64.sqrt(), 5e-6));
        claims.push(Claim::relative(format!("{at}: c_p/c_s = sqrt 3, Poisson's ratio 1/3"), p / s, 3f64.sqrt(), 5e-6));
    }
    claims
}

fn fastest(linear: &Linearised) -> Vec<Claim> {
    let unit = K / M;
    let q = Vector3::new(0.0, TAU / (2.0 * HALF_ROOT3 * A), 0.0);
    let square = answer(linear, q, Vector3::y(), 0.0)[CENTRE].y / unit;
    let modes = linear.modes("xy");
    let top = modes.squares.len() - 1;
    let w = modes.squares[top].sqrt();
    let scene = build_scene(still(0.0).problem().clone().take_system(), 1).expect("the case is good");
    let estimated = Spectrum::of(&*scene, scene.initial_state().as_ref()).rates().frequency;
    let mut claims = vec![
        Claim::relative("tangent: fastest wave, w^2 m/k = 6", square, 6.0, 1e-14),
        // w^2 m/k = 6 - 3/8 (dq_x a)^2 - 9/8 (dq_y a)^2 about the fastest, and a net of n a side lets in half a wave
        // each way: 6 - 3/2 (pi/12)^2. The sides are not along x and y: a third of the difference.
        Claim::absolute(
            "a free net of 12 x 12: largest w^2 m/k",
            modes.squares[top] / unit,
            6.0 - 1.5 * (PI / SIDE as f64).powi(2),
            0.03,
        ),
        Claim::relative("the program's own estimate of its fastest rate [rad/s]", estimated, w, 0.01),
        Claim::relative(
            "Eq. 72's step pi sqrt(m/k) over Verlet's limit 2/w",
            PI / unit.sqrt() / (2.0 / w),
            3.848,
            0.01,
        ),
    ];
    // Beyond the limit x(n+1) + x(n-1) = (2 - (w h)^2) x(n) grows, below it turns. Steps enough to tell, few enough to
    // stay small.
    for (share, steps) in [(0.98, 100), (1.02, 40), (PI / (2.0 / 6f64.sqrt()), 4)] {
        let h = share * 2.0 / w;
        let shape = &modes.shapes[top];
        let size: f64 = shape.iter().flatten().map(|x| x * x).sum();
        let displacement: Vec<[f64; 3]> = shape.iter().map(|u| u.map(|x| 1e-9 * A * x / size.sqrt())).collect();
        let case = net(0.0, &Start { displacement: &displacement, step: h, steps });
        let run = Signal::of(&case, |seen| {
            let project = |values: &[[f64; 3]], rest: &dyn Fn(usize) -> Vector3<f64>| -> f64 {
                let moved = |i: usize| Vector3::from(values[i]) - rest(i);
                (0..SIDE * SIDE).map(|i| moved(i).dot(&Vector3::from(shape[i]))).sum()
            };
            (project(seen.positions, &place), project(seen.velocities, &|_| Vector3::zeros()))
        });
        // Positions of 5 m are rounded to 1e-15 m, beside an amplitude of 3e-10 m shared by 144 nodes.
        let what = format!("Verlet at {share:.2} times 2/w: x(n+1) + x(n-1) over 2 x(n) = 1 - (w h)^2/2");
        claims.push(Claim::relative(what, run.cosine(), 1.0 - 0.5 * (w * h).powi(2), 2e-6));
    }
    claims
}
