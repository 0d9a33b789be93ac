//! Chains of N equal beads hanging at rest, the double pendulum among them. A link that carries n beads pulls with n m
//! g, so the transverse tangent is m g/l times the matrix with the Laguerre polynomials' recurrence, and w^2 = (g/l) x
//! with L_N(x) = 0; bead j from the free end moves as L_j(x). For N = 2, w^2 = (2 -+ sqrt 2) g/l: the double pendulum
//! (Landau and Lifshitz, Mechanics, section 23). With many beads the slowest tends to Bessel's chain, w = j01/2
//! sqrt(g/L) (D. Bernoulli 1733).
//!
//! Along itself the chain is a rod held at one end: w = 2 sqrt(k/m) sin((2j - 1) pi/(2 (2N + 1))).

use crate::chain::{G, Hanging};
use crate::claim::Claim;
use crate::linearised::{Linearised, worst_share};
use crate::signal::Signal;
use std::f64::consts::{PI, TAU};

/// L_n(x) by its recurrence, n = 0 ..= `last`.
fn laguerre(last: usize, x: f64) -> Vec<f64> {
    let mut l = vec![1.0, 1.0 - x];
    for k in 1..last {
        let k1 = k as f64;
        l.push(((2.0 * k1 + 1.0 - x) * l[k] - k1 * l[k - 1]) / (k1 + 1.0));
    }
    l.truncate(last + 1);
    l
}

/// Zeros of L_n: those of L_(n-1) part them, and bisection of the recurrence finds them. No matrix is asked, because
/// the chain's own tangent is the matrix one would ask.
pub fn zeros(n: usize) -> Vec<f64> {
    let mut between = vec![0.0, 4.0 * n as f64 + 2.0];
    for degree in 1..=n {
        let value = |x: f64| laguerre(degree, x)[degree];
        let bisect = |ends: &[f64]| {
            let (mut low, mut high) = (ends[0], ends[1]);
            while 0.5 * (low + high) > low && 0.5 * (low + high) < high {
                let middle = 0.5 * (low + high);
                *if (value(middle) < 0.0) == (value(ends[0]) < 0.0) { &mut low } else { &mut high } = middle;
            }
            low
        };
        let found: Vec<f64> = between.windows(2).map(bisect).collect();
        between = [&[0.0], found.as_slice(), &[4.0 * n as f64 + 2.0]].concat();
    }
    between[1..=n].to_vec()
}

/// A chain of 1 m and 1 kg with links 200 N times stiffer than m g/l.
fn chain(beads: usize) -> Hanging {
    let n = beads as f64;
    Hanging { beads, mass: 1.0 / n, link: 1.0 / n, stiffness: 2000.0 * n }
}

/// Frequency of a run that starts in a mode along x, its lowest bead `amplitude` times its link aside.
fn measured(c: &Hanging, zero: f64, amplitude: f64) -> f64 {
    let shape = laguerre(c.beads, zero);
    // Node i has N - i beads below it.
    let at = |i: usize| [if i == 0 { 0.0 } else { amplitude * c.link * shape[c.beads - i] }, 0.0, 0.0];
    let displacement: Vec<[f64; 3]> = (0..=c.beads).map(at).collect();
    let period = TAU / (zero * G / c.link).sqrt();
    let case = c.case(&displacement, 5.25 * period, 5e-4);
    Signal::of(&case, |seen| (seen.positions[c.beads][0], seen.velocities[c.beads][0])).frequency()
}

pub fn double_pendulum() -> Vec<Claim> {
    let c = Hanging { beads: 2, mass: 1.5, link: 0.8, stiffness: 3000.0 };
    let linear = Linearised::of(&c.at_rest());
    let exact = [2.0 - 2f64.sqrt(), 2.0 + 2f64.sqrt()];
    let mut claims = Vec::new();
    for (i, (zero, name)) in exact.into_iter().zip(["slow", "fast"]).enumerate() {
        let sign = ["-", "+"][i];
        // k l eps/T: the tension is a difference of lengths.
        let square = linear.modes("x").squares[i] * c.link / G;
        claims.push(Claim::relative(format!("tangent: w^2 l/g = 2 {sign} sqrt 2"), square, zero, 4e-14));
        // (w h)^4/120 = 1e-12 at worst for the fast one; (amplitude over link)^2 is 1e-14.
        let w = measured(&c, zero, 1e-7);
        let expected = (zero * G / c.link).sqrt();
        claims.push(Claim::relative(format!("run: {name} mode, amplitude 1e-7 l"), w, expected, 1e-11));
        let share = |amplitude| measured(&c, zero, amplitude) / expected - 1.0;
        // Next to the square of the amplitude comes its fourth.
        let order = (share(0.004) / share(0.002)).log2();
        claims.push(Claim::absolute(
            format!("run: {name} mode, power of the amplitude in its shift"),
            order,
            2.0,
            0.01,
        ));
    }
    let along = linear.modes("z").squares;
    let root5 = 5f64.sqrt();
    let expected = [(3.0 - root5) / 2.0, (3.0 + root5) / 2.0].map(|x| x * c.stiffness / c.mass);
    claims.push(Claim::below(
        "tangent: w^2 m/k along = (3 -+ sqrt 5)/2, worst share",
        worst_share(&along, expected),
        1e-14,
    ));
    claims
}

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    for beads in [1, 2, 5, 20] {
        let c = chain(beads);
        let linear = Linearised::of(&c.at_rest());
        let n = beads as f64;
        for axis in ["x", "y"] {
            let off = worst_share(&linear.modes(axis).squares, zeros(beads).iter().map(|x| x * G / c.link));
            // Tensions are differences of lengths: they carry a rounding of k l eps beside m g.
            let rounding = c.stiffness * c.link / (c.mass * G) * f64::EPSILON;
            let what = format!("tangent, N = {beads}: all w^2 along {axis} = (g/l) zeros of L_N, worst share");
            claims.push(Claim::below(what, off, 4.0 * rounding));
        }
        let rod = (1..=beads).map(|j| {
            let phase = (2 * j - 1) as f64 * PI / (2.0 * (2.0 * n + 1.0));
            4.0 * c.stiffness / c.mass * phase.sin().powi(2)
        });
        let off = worst_share(&linear.modes("z").squares, rod);
        claims.push(Claim::below(format!("tangent, N = {beads}: all w^2 along z, a rod, worst share"), off, 1e-13));
    }
    // x = j01^2/(4 n) (1 + (j01^2 - 2)/(48 n^2)) + O(n^-5), n = N + 1/2 (Abramowitz and Stegun 22.16.8).
    let (bessel2, n) = (2.404_825_557_695_773_f64.powi(2), 20.5);
    let lowest = Linearised::of(&chain(20).at_rest()).modes("x").squares[0].sqrt();
    let continuum = 0.5 * (bessel2 * G * 20.0 / n).sqrt();
    let expected = continuum * (1.0 + (bessel2 - 2.0) / (48.0 * n * n)).sqrt();
    claims.push(Claim::relative(
        "N = 20: lowest w is Bessel's j01/2 sqrt(g/L), corrected to 1/N^2",
        lowest,
        expected,
        2e-7,
    ));
    let (c, x) = (chain(5), zeros(5));
    for j in [0, 1] {
        let w = measured(&c, x[j], 1e-6);
        // (w h)^4/120 = 3e-13 for the second; 1e-12 of amplitude squared.
        let what = format!("run, N = 5: w of mode {} over five periods", j + 1);
        claims.push(Claim::relative(what, w, (x[j] * G / c.link).sqrt(), 1e-11));
    }
    claims
}
