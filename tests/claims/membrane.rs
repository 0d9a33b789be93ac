//! A flat prestressed membrane: tension N, areal density sigma, w'' = (N/sigma) Laplace w across it.
//!
//! * Disc of radius R, fixed at its edge: w_mn = (j_mn/R) sqrt(N/sigma), j_mn the zeros of Bessel's J_m.
//! * Equilateral triangle of side s (Lame): w_mn = (4 pi/(3 s)) sqrt(m^2 + m n + n^2) sqrt(N/sigma). Lame's modes are
//!   sums of plane waves that an equilateral net has as well, with w^2 = (T/(a M)) [6 - 2 cos p - 2 cos q - 2 cos(p -
//!   q)], where p = (2 pi a/(3 s)) (2 m + n), q = (2 pi a/(3 s)) (m + 2 n).
//!
//! Springs with the same EA and the same `rest_scale` s on every edge pull with T = EA (1 - s)/s; in an equilateral net
//! N = sqrt 3 T/a.

use crate::claim::Claim;
use crate::common::run::{case_of, changed, follow};
use crate::lattice::Lattice;
use canopy_fem::case::Case;
use canopy_fem::model::system::Weights;
use canopy_fem::simulation::build_scene;
use faer::{Mat, Side};
use serde_json::{Value, json};
use std::f64::consts::PI;

/// [N/m] N
const TENSION: f64 = 50.0;
/// [kg/m^2] sigma
const DENSITY: f64 = 0.05;
/// [-] rest length over length: the sheet is strained by 1 %
const REST_SCALE: f64 = 0.99;

fn case(lattice: &Lattice) -> Value {
    let force = TENSION * lattice.edge / 3.0_f64.sqrt();
    json!({
        "name": "drum",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": lattice.nodes, "springs": lattice.springs}},
            "mass": {"nodal": DENSITY * lattice.cell()},
            "springs": [{
                "on": "all", "axial_rigidity": force * REST_SCALE / (1.0 - REST_SCALE), "rest_scale": REST_SCALE
            }],
            "supports": [{"on": {"ids": lattice.pinned}, "fix": "xyz"}]
        }},
        "time": {"end": 1.0, "method": "velocity-verlet", "step": 1e-3}
    })
}

/// Modes across the plane, of the tangent that the program assembles.
struct Modes {
    /// [rad/s] ascending
    rates: Vec<f64>,
    /// [m] z of every node (user's number) in the slowest mode, 1 at most
    slowest: Vec<[f64; 3]>,
}

fn modes(lattice: &Lattice) -> Modes {
    let mut problem = case_of(&case(lattice), &[]).problem().clone();
    let scene = build_scene(problem.take_system(), 1).expect("a sound case");
    let mut assembler = scene.assembler().expect("small");
    let start = scene.initial_state();
    scene.assemble(start.as_ref(), Weights { m: 0.0, c: 0.0, k: 1.0 }, &mut assembler);
    let (pattern, values) = (assembler.pattern.clone(), assembler.values());
    let nodes: Vec<Option<u32>> = pattern
        .dof
        .iter()
        .map(|&d| scene.name_of(d as usize))
        .map(|(node, axis)| (axis == "z").then_some(node))
        .collect();
    let mut row = vec![None; nodes.len()];
    let across: Vec<usize> = (0..nodes.len()).filter(|&i| nodes[i].is_some()).collect();
    across.iter().enumerate().for_each(|(r, &i)| row[i] = Some(r));
    // The lower half as stored; across and in the plane do not couple on a flat sheet.
    let mut k = Mat::<f64>::zeros(across.len(), across.len());
    for j in 0..nodes.len() {
        for s in pattern.col_ptr[j]..pattern.col_ptr[j + 1] {
            let (i, value) = (pattern.row_idx[s as usize] as usize, values[s as usize]);
            match (row[i], row[j]) {
                (Some(r), Some(c)) => {
                    k[(r, c)] = value;
                    k[(c, r)] = value;
                }
                (None, None) => {}
                _ => assert!(value == 0.0, "a flat sheet couples x, y and z: {value}"),
            }
        }
    }
    let eigen = k.self_adjoint_eigen(Side::Lower).expect("finite");
    let mass = DENSITY * lattice.cell();
    let rates = eigen.S().column_vector().iter().map(|l| (l / mass).sqrt()).collect();
    let mode: Vec<f64> = eigen.U().col(0).iter().copied().collect();
    let largest = mode.iter().fold(0.0, |m: f64, z| if z.abs() > m.abs() { *z } else { m });
    let mut slowest = vec![[0.0; 3]; lattice.nodes.len()];
    for (&i, z) in across.iter().zip(&mode) {
        slowest[nodes[i].expect("chosen so") as usize][2] = z / largest;
    }
    Modes { rates, slowest }
}

/// Zeros of J_m and how often they appear; the share of the plane waves' error that is left beside the cut edge.
const DISC: [(&str, usize, f64, [f64; 2]); 3] = [
    ("j01", 0, 2.404825557695773, [0.72, 0.84]),
    ("j11", 1, 3.831705970207512, [0.88, 0.94]),
    ("j21", 3, 5.135622301840683, [0.92, 0.97]),
];

/// A plane wave of wave number k is slower by the share (k a)^2/32 in the net. The cut edge makes up for some of it,
/// the more the fewer waves there are, differently from net to net; the bounds hold for R/a = 5 .. 16.
fn disc(claims: &mut Vec<Claim>) {
    let wave = (TENSION / DENSITY).sqrt();
    for n in [8, 16] {
        let Modes { rates, .. } = modes(&Lattice::disc(n));
        for (name, mode, zero, [low, high]) in DISC {
            let error = rates[mode] / (zero * wave) - 1.0;
            claims.push(Claim::between(
                format!("disc, edge R/{n}: error of the rate {name} sqrt(N/sigma)/R = -C (j edge/R)^2/32, C"),
                -32.0 * error * (f64::from(n) / zero).powi(2),
                low,
                high,
            ));
        }
        // The net keeps the symmetry of a hexagon, which these pairs are irreducible under.
        for (name, mode) in [("j11", 1), ("j21", 3)] {
            let split = rates[mode + 1] / rates[mode] - 1.0;
            claims.push(Claim::below(
                format!("disc, edge R/{n}: the two modes of {name} differ by the share"),
                split,
                1e-13,
            ));
        }
    }
}

fn triangle(claims: &mut Vec<Claim>) {
    let wave = (TENSION / DENSITY).sqrt();
    let [coarse, fine] = [10_u16, 20].map(|n| (n, modes(&Lattice::triangle(n)).rates));
    for (m, n, mode) in [(1.0, 1.0, 0), (1.0, 2.0, 1), (2.0, 2.0, 3)] {
        let continuum = 4.0 * PI / 3.0 * f64::sqrt(m * m + m * n + n * n) * wave;
        for (edges, rates) in [&coarse, &fine] {
            let [p, q] = [2.0 * m + n, m + 2.0 * n].map(|c| 2.0 * PI / (3.0 * f64::from(*edges)) * c);
            // T/(a M) = (N/sqrt 3)/(sigma (sqrt 3/2) a^2)
            let spring = 2.0 / 3.0 * (wave * f64::from(*edges)).powi(2);
            let net = (spring * (6.0 - 2.0 * p.cos() - 2.0 * q.cos() - 2.0 * (p - q).cos())).sqrt();
            claims.push(Claim::relative(
                format!("triangle of {edges} edges a side: rate of Lame's mode ({m}, {n}) of the net [rad/s]"),
                rates[mode],
                net,
                1e-14,
            ));
        }
        let error = |rates: &[f64]| (rates[mode] / continuum - 1.0).abs();
        // The next term of the cosines raises it by about (k a)^2/60 of it.
        claims.push(Claim::absolute(
            format!("triangle, 10 and 20 edges a side: order towards the membrane's mode ({m}, {n})"),
            (error(&coarse.1) / error(&fine.1)).log2(),
            2.0,
            0.05,
        ));
    }
}

/// [rad/s] of a node that swings across the plane, from its first and last passage through z = 0 in a run of 20
/// periods; `rate` places the passage between two steps.
fn swing(case: &Case, node: usize, rate: f64, step: f64) -> f64 {
    let (mut last, mut passages) = (None, Vec::new());
    follow(case, |seen| {
        let z = seen.positions[node][2];
        if let Some(before) = last.filter(|before: &f64| before * z < 0.0) {
            let (sin, cos) = (rate * step).sin_cos();
            let ahead = (before * sin / (before * cos - z)).atan() / rate;
            passages.push(seen.t - step + ahead);
        }
        last = Some(z);
    });
    let [first, .., end] = passages.as_slice() else { panic!("{} passages", passages.len()) };
    PI * (passages.len() - 1) as f64 / (end - first)
}

/// The slowest mode let go in a run: the scheme's own frequency is that of an oscillator of the tangent's rate.
fn motion(claims: &mut Vec<Claim>) {
    let lattice = Lattice::disc(8);
    let Modes { rates, slowest } = modes(&lattice);
    let node = slowest.iter().position(|u| u[2] == 1.0).expect("scaled to it");
    let (rate, fastest) = (rates[0], rates.last().copied().expect("many"));
    let step = 1.6 / fastest;
    let half = 0.5 * rate * step;
    let mut json = case(&lattice);
    // Stretching the springs by a swing of 1e-7 raises the frequency by a share below 1e-12.
    let small: Vec<[f64; 3]> = slowest.iter().map(|u| u.map(|c| 1e-7 * c)).collect();
    json["system"]["network"]["initial"] = json!({"displacement": small});
    // The motion is so small that rounded positions hide the last digits of the residual, where an iteration would
    // stop.
    json["solver"] = json!({"linear": "cholesky", "newton": {"strategy": "full"}});
    // Waves in the plane are ten times faster and not asked about.
    json["system"]["network"]["supports"].as_array_mut().expect("a list").push(json!({"on": "all", "fix": "xy"}));
    let case = case_of(&json, &[]);
    for (method, own, tolerance) in
        [("velocity-verlet", half.asin() * 2.0 / step, 2e-12), ("newmark", half.atan() * 2.0 / step, 2e-12)]
    {
        let end = (20.0 * 2.0 * PI / rate).to_string();
        let run = changed(&case, &[("time.method", method), ("time.step", &step.to_string()), ("time.end", &end)]);
        claims.push(Claim::relative(
            format!(
                "disc swinging in its slowest mode, {method}, w h = {:.3}: its own frequency over 20 periods",
                rate * step
            ),
            swing(&run, node, own, step),
            own,
            tolerance,
        ));
    }
}

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    disc(&mut claims);
    triangle(&mut claims);
    motion(&mut claims);
    claims
}
