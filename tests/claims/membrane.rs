//! A flat prestressed membrane: tension N, areal density sigma, w'' = (N/sigma) Laplace w across it.
//!
//! * Disc of radius R, fixed at its edge: w_mn = (j_mn/R) sqrt(N/sigma), j_mn the zeros of Bessel's J_m.
//! * Equilateral triangle of side s (Lame): w_mn = (4 pi/(3 s)) sqrt(m^2 + m n + n^2) sqrt(N/sigma). Lame's modes are sums of plane waves
//!   that an equilateral net has as well, with w^2 = (T/(a M)) [6 - 2 cos p - 2 cos q - 2 cos(p - q)], where
//!   p = (2 pi a/(3 s)) (2 m + n), q = (2 pi a/(3 s)) (m + 2 n).
//!
//! Springs with the same EA and the same `rest_scale` s on every edge pull with T = EA (1 - s)/s; in an equilateral net N = sqrt 3 T/a.

use crate::claim::Claim;
use crate::common::run::{case_of, follow};
use crate::lattice::Lattice;
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

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    let wave = (TENSION / DENSITY).sqrt();
    for n in [5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16] {
        let t = std::time::Instant::now();
        let m = modes(&Lattice::disc(n));
        for (k, j) in [
            2.404825557695773,
            3.831705970207512,
            3.831705970207512,
            5.135622301840683,
            5.135622301840683,
            5.520078110286311,
        ]
        .iter()
        .enumerate()
        {
            print!(" {:.4}", (m.rates[k] / wave / j - 1.0) * f64::from(n * n) / (j * j / 24.0));
        }
        println!("  {n} {} {:?}", m.rates.len(), t.elapsed());
    }
    for n in [6, 12, 24] {
        let m = modes(&Lattice::triangle(n));
        for (k, (p, q)) in [(1., 1.), (1., 2.), (1., 2.), (2., 2.)].iter().enumerate() {
            let w = 4.0 * PI / 3.0 * f64::sqrt(p * p + p * q + q * q);
            print!(" {:e}", (m.rates[k] / wave / w - 1.0));
        }
        println!();
    }
    let _ = follow;
    claims.push(Claim::below("", 0.0, 1.0));
    claims
}
