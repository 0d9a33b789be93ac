//! The plane pendulum at every amplitude: T = 4 sqrt(L/g) K(sin(a/2)) = 2 pi sqrt(L/g)/agm(1, cos(a/2)), with the
//! arithmetic-geometric mean (Gauss); and the energy, read from where it turns and how fast it passes its lowest point,
//! v^2 = 2 g L (1 - cos a).
//!
//! Velocity Verlet moves exactly by H + h^2 (p^2 V''/12 - V'^2/24) + O(h^4) (Hairer, Lubich, Wanner, Geometric
//! Numerical Integration, IX). With T = dJ/dE at the energy of the start this makes its period wrong by the share -(w
//! h)^2/24 (3 E/K - 2 + k^2), k = sin(a/2): too short at first, too long above 153 degrees. The trapezium rule,
//! Newmark's, is the midpoint rule seen from half a step aside: minus twice that.

use crate::claim::Claim;
use crate::common::run::case_of;
use crate::signal::Signal;
use serde_json::json;
use std::f64::consts::{PI, TAU};

/// [m], [m/s^2]
const L: f64 = 1.0;
const G: f64 = 9.81;

/// Complete elliptic integrals of the modulus sin(a/2).
struct Elliptic {
    first: f64,
    second: f64,
}

impl Elliptic {
    /// E/K = 1 - sum of 2^(n-1) c_n^2 over the differences of the means (Abramowitz and Stegun 17.6).
    fn of(angle: f64) -> Self {
        let (mut a, mut b) = (1.0, (0.5 * angle).cos());
        let (mut sum, mut power) = (0.5 * (0.5 * angle).sin().powi(2), 0.5);
        while a - b > 1e-15 * a {
            let c = 0.5 * (a - b);
            (a, b) = (0.5 * (a + b), f64::sqrt(a * b));
            power *= 2.0;
            sum += power * c * c;
        }
        let first = 0.5 * PI / a;
        Elliptic { first, second: first * (1.0 - sum) }
    }
}

/// [s]
fn period(angle: f64) -> f64 {
    4.0 * (L / G).sqrt() * Elliptic::of(angle).first
}

struct Swing {
    degrees: f64,
    method: &'static str,
    /// [s]
    step: f64,
}

impl Swing {
    fn angle(&self) -> f64 {
        self.degrees.to_radians()
    }

    /// Two and a half periods of the angle.
    fn run(&self) -> Signal {
        let case = case_of(
            &json!({
                "name": "pendulum",
                "system": {"pendulum": {
                    "length": L, "mass": 2.0, "damping": 0.0, "gravity": G, "angle": self.angle(), "rate": 0.0
                }},
                "time": {"end": 2.5 * period(self.angle()), "method": self.method, "step": self.step},
                // Next to the upright position an error grows by exp(sqrt(g/L) t); Newton's must not show.
                "solver": {"newton": {"relative": 1e-13}}
            }),
            &[],
        );
        Signal::of(&case, |seen| {
            let ([x, _, z], [vx, _, vz]) = (seen.positions[0], seen.velocities[0]);
            (x.atan2(-z), (vx * -z + vz * x) / (L * L))
        })
    }

    /// [s]
    fn period(&self) -> f64 {
        TAU / self.run().frequency()
    }
}

/// [rad], [rad/s] Worst turning angle from the first one, and speed at the lowest point.
fn turns_and_speed(run: &Signal, angle: f64) -> (f64, f64) {
    let acceleration = run.x.iter().map(|x| -G / L * x.sin()).collect();
    let rate = Signal { t: run.t.clone(), x: run.v.clone(), v: acceleration };
    let half = 0.25 * period(angle);
    // The start is a turning point too, but no crossing to be sure of.
    let turns = rate.crossings().into_iter().filter(|&t| t > half);
    let off = turns.map(|t| (run.at(t).abs() - angle).abs()).fold(0.0, f64::max);
    (off, rate.at(run.crossings()[0]).abs())
}

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    for degrees in [10.0, 90.0, 150.0, 170.0, 179.0_f64] {
        let swing = Swing { degrees, method: "rk4", step: 1e-3 };
        let (exact, run) = (period(swing.angle()), swing.run());
        // (w h)^4/120 = 8e-13; near the top what is wrong with the angle grows as 1/cos(a/2), to 115 times at 179
        // degrees.
        let gain = 1.0 / (0.5 * swing.angle()).cos();
        let from = format!("from {degrees} degrees");
        claims.push(Claim::relative(format!("rk4, 1 ms: period {from}"), TAU / run.frequency(), exact, 2e-12 * gain));
        let (off, speed) = turns_and_speed(&run, swing.angle());
        claims.push(Claim::below(format!("rk4, 1 ms: turning angle {from}, off by [rad]"), off, 1e-13 * gain));
        let lowest = 2.0 * (G / L).sqrt() * (0.5 * swing.angle()).sin();
        claims.push(Claim::relative(format!("rk4, 1 ms: rate at the lowest point {from}"), speed, lowest, 4e-12));
        for (method, factor) in [("velocity-verlet", -1.0 / 24.0), ("newmark", 1.0 / 12.0)] {
            claims.extend(second_order(method, factor, degrees));
        }
    }
    claims
}

/// The share by which the period is off, its order, and what is left after extrapolation.
fn second_order(method: &'static str, factor: f64, degrees: f64) -> [Claim; 3] {
    let h = 0.005;
    let angle = f64::to_radians(degrees);
    let (exact, elliptic) = (period(angle), Elliptic::of(angle));
    let [coarse, fine] = [h, 0.5 * h].map(|step| Swing { degrees, method, step }.period());
    let order = ((coarse - exact) / (fine - exact)).abs().log2();
    let z2 = G / L * h * h;
    let share = factor * z2 * (3.0 * elliptic.second / elliptic.first - 2.0 + (0.5 * angle).sin().powi(2));
    // What these leave out is of the size (w h)^4 = 6e-8, with constants as small as those of the second order.
    let next = 0.2 * z2 * z2;
    let what = format!("{method}, 5 ms, from {degrees} degrees");
    [
        Claim::absolute(format!("{what}: share by which the period is off"), coarse / exact - 1.0, share, next),
        Claim::absolute(format!("{what}: order of the period"), order, 2.0, 0.01),
        Claim::relative(
            format!("{what}: period extrapolated with half the step"),
            (4.0 * fine - coarse) / 3.0,
            exact,
            next,
        ),
    ]
}
