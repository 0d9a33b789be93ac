//! The spring pendulum of the thesis' Table 2: a mass M between two springs K of rest length l to anchors at (0, +-a).
//! Along the anchors' line y'' = -(2K/M) y exactly while nothing crosses an anchor; across it
//! M x'' = -2 K x (1 - l/sqrt(a^2 + x^2)) = -2 K ((1 - l/a) x + l x^3/(2 a^3) - ...), a Duffing oscillator
//! whose frequency rises by the share 3 l A^2/(16 a^3 (1 - l/a)) (Landau and Lifshitz, Mechanics, section 28).

use crate::claim::Claim;
use crate::common::run::{asset, changed};
use crate::linearised::Linearised;
use crate::signal::Signal;
use canopy_fem::case::Case;

/// [kg], [N/m], [m], [m] of the asset
const M: f64 = 1.0;
const K: f64 = 10.0;
const A: f64 = 1.0;
const REST: f64 = 0.5;

/// The asset from another place, with springs of another kind.
fn case(displacement: [f64; 2], rest_length: f64, slack: &str) -> Case {
    let [x, y] = displacement;
    asset(
        "spring-pendulum",
        &[
            ("system.network.initial.displacement", &format!("[{x}, {y}, 0]")),
            ("system.network.springs.0.rest_length", &rest_length.to_string()),
            ("system.network.springs.0.slack", slack),
            ("time.method", "rk4"),
            ("time.step", "0.001"),
            ("time.end", "20"),
        ],
    )
}

fn frequency(case: &Case, axis: usize) -> f64 {
    Signal::of(case, |seen| (seen.positions[0][axis], seen.velocities[0][axis])).frequency()
}

/// Stiffness over mass across and along the line, at the middle.
fn squares(rest_length: f64, slack: &str) -> [f64; 2] {
    let linear = Linearised::of(&case([0.0; 2], rest_length, slack));
    ["x", "y"].map(|axis| linear.modes(axis).squares[0])
}

pub fn claims() -> Vec<Claim> {
    let (across, along) = ((2.0 * K / M * (1.0 - REST / A)).sqrt(), (2.0 * K / M).sqrt());
    let mut claims = Vec::new();
    let [x, y] = squares(REST, "null");
    claims.push(Claim::relative("tangent: w across = sqrt(2K/M (1 - l/a))", x.sqrt(), across, 1e-14));
    claims.push(Claim::relative("tangent: w along = sqrt(2K/M)", y.sqrt(), along, 1e-14));
    // (w h)^4/120 is 2e-12 across and 3e-12 along; the zeros are found to rounding.
    let w = frequency(&case([0.0, 0.3], REST, "null"), 1);
    claims.push(Claim::relative("run: w along, amplitude 0.3 m (exactly linear)", w, along, 1e-11));
    // At 1e-5 m the Duffing share is 2e-11.
    let w = frequency(&case([1e-5, 0.0], REST, "null"), 0);
    claims.push(Claim::relative("run: w across, amplitude 10 um", w, across, 1e-10));
    for amplitude in [0.02, 0.04] {
        let share = frequency(&case([amplitude, 0.0], REST, "null"), 0) / across - 1.0;
        let duffing = 3.0 * REST * amplitude * amplitude / (16.0 * A.powi(3) * (1.0 - REST / A));
        // The next term is of the order of A^2 beside the first: 1.6e-3 at 4 cm.
        let what = format!("run: share by which w across rises at {amplitude} m, Duffing");
        claims.push(Claim::relative(what, share, duffing, 3e-3));
    }
    claims.extend(slack());
    claims
}

/// What the sign of the tension does, with springs longer than their places.
fn slack() -> Vec<Claim> {
    let mut claims = Vec::new();
    // l = 1.5 a: compressed springs push the mass off the line unless they are slack.
    let [x, y] = squares(1.5, "null");
    claims.push(Claim::relative("tangent, l = 1.5 a: w^2 across = 2K/M (1 - l/a), negative", x, -K / M, 1e-14));
    claims.push(Claim::relative("tangent, l = 1.5 a: w^2 along = 2K/M", y, 2.0 * K / M, 1e-14));
    let [x, y] = squares(1.5, "tension-only");
    claims.push(Claim::absolute("tangent, l = 1.5 a, tension-only: w^2 across", x, 0.0, 0.0));
    claims.push(Claim::absolute("tangent, l = 1.5 a, tension-only: w^2 along", y, 0.0, 0.0));
    let [x, y] = squares(REST, "tension-only");
    claims.push(Claim::relative("tangent, taut, tension-only: w^2 across as without slack", x, K / M, 1e-14));
    claims.push(Claim::relative("tangent, taut, tension-only: w^2 along as without slack", y, 2.0 * K / M, 1e-14));
    // l = a: one spring pulls at a time, so the force along the line is -K y on both sides.
    let w = frequency(&case([0.0, 0.1], A, "tension-only"), 1);
    claims.push(Claim::relative("run, l = a, tension-only: w along = sqrt(K/M)", w, (K / M).sqrt(), 1e-11));
    let w = frequency(&case([0.0, 0.1], A, "null"), 1);
    claims.push(Claim::relative("run, l = a, springs that push: w along = sqrt(2K/M)", w, (2.0 * K / M).sqrt(), 1e-11));
    // The unstable side grows as cosh(t sqrt(K/M)): from 1e-6 m, in 2 s to 2.8e-4, whose square is 8e-8.
    let grown = pushed_off();
    let expected = 1e-6 * (2.0 * (K / M).sqrt()).cosh();
    claims.push(Claim::relative(
        "run, l = 1.5 a: pushed off the line as cosh(t sqrt(K/M)), 2 s",
        grown,
        expected,
        1e-7,
    ));
    claims
}

/// [m] Displacement across the line, 2 s after 1e-6 m.
fn pushed_off() -> f64 {
    let case = changed(&case([1e-6, 0.0], 1.5, "null"), &[("time.end", "2")]);
    let run = Signal::of(&case, |seen| (seen.positions[0][0], seen.velocities[0][0]));
    run.x[run.x.len() - 1]
}
