//! Taylor's parachute with a reefing line. The skirt has the radius r_s of the ring; the meridian is the same curve:
//!
//! ```text
//! R [K + int_{r_s/R}^1 dx/sqrt(1 - x^4)] = length of a radial,      K = 1.3110287771461
//! ```
//! At each of the n corners, radial, line and ring are in balance: with the tension T = p pi R^2 f/n of a radial, f the
//! factor of the polygon, and sin(phi) = (r_s/R)^2 there, the lines pull with p pi r_s^2 f in all, and the ring with
//!
//! ```text
//! N = T (sqrt(1 - (r_s/R)^4) - (r_s/R)^2 tan(beta))/(2 sin(pi/n)),      sin(beta) = r_s/L
//! ```

use super::taylor::{Canopy, load};
use super::{RIGIDITY, Settled, length, widest};
use crate::claim::Claim;
use serde_json::json;
use std::f64::consts::{FRAC_PI_2, PI};

/// [m] for radials of 1 m, whose skirt would have a radius of 0.657 m without the ring
const RADIUS: f64 = 0.35;

/// [-] int_{x}^1 dx/sqrt(1 - x^4), with x = sin(a) that of da/sqrt(1 + sin(a)^2), by Simpson's rule
fn beyond(x: f64) -> f64 {
    let from = x.asin();
    let n = 200;
    let h = (FRAC_PI_2 - from) / f64::from(n);
    let weight = |i: i32| match i {
        0 => 1.0,
        i if i == n => 1.0,
        i => 2.0 + 2.0 * f64::from(i % 2),
    };
    let at = |i: i32| 1.0 / (1.0 + (from + h * f64::from(i)).sin().powi(2)).sqrt();
    (0..=n).map(|i| weight(i) * at(i)).sum::<f64>() * h / 3.0
}

/// [m] R
fn largest_radius() -> f64 {
    let (mut low, mut high) = (RADIUS, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let arc = middle * (beyond(0.0) + beyond(RADIUS / middle));
        if arc < 1.0 { low = middle } else { high = middle }
    }
    low
}

pub fn claims() -> Vec<Claim> {
    let canopy = Canopy { gores: 12, rows: 32, ratio: 1.0, cloth: false };
    let n = canopy.gores as f64;
    // The ring's length is pi times its diameter, along the chords between corners.
    let chord = 2.0 * RADIUS * (PI / n).sin();
    let mut case = canopy.case();
    let network = &mut case["system"]["network"];
    network["mesh"]["parachute"]["reefing"] = json!({"diameter": n * chord / PI});
    network["mesh"]["parachute"]["start"] = json!("inflated");
    let ring = json!({"on": {"group": "reefing"}, "axial_rigidity": RIGIDITY, "rest_length": chord});
    network["springs"].as_array_mut().expect("rules").push(ring);
    let at = Settled::of(&case);
    let meridian = canopy.meridian(&at);
    let (long, [skirt, _]) = (length(&meridian), meridian[canopy.rows]);
    let tensions = &at.mesh.groups["reefing"].edges;
    let pull = tensions.iter().map(|&edge| at.tensions[edge as usize]).sum::<f64>() / n;
    let (radials, axial) = canopy.sums(&at);
    let radius = largest_radius();
    let (share, lean) = ((RADIUS / radius).powi(2), (0.5 * RADIUS / canopy.ratio).asin());
    let tension = load(canopy.gores, radius) / n;
    let expected = tension * ((1.0 - share * share).sqrt() - share * lean.tan()) / (2.0 * (PI / n).sin());
    let mean = radials.iter().sum::<f64>() / radials.len() as f64;
    vec![
        Claim::below("K", beyond(0.0) - 1.311_028_777_146_1, 1e-12),
        Claim::below("speed of the fastest node [m/s]", at.fastest, 1e-5),
        Claim::relative("largest radius over the length of a radial", widest(&meridian) / long, radius, 1e-3),
        Claim::relative("radius of the skirt [m]", skirt, RADIUS, 1e-3),
        Claim::relative("tension of all radials [N]", mean, load(canopy.gores, radius), 1e-3),
        Claim::relative("tension of all lines along the axis [N]", axial, load(canopy.gores, RADIUS), 3e-3),
        Claim::relative("tension of the reefing line [N]", pull, expected, 3e-3),
    ]
}
