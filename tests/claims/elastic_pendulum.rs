//! A mass that turns freely on a spring (Kuhl & Crisfield 1999: 10 kg, 3.0443 m, 7.72 m/s; EA = 1e10 N, nearly rigid,
//! or 1e4 N): the touchstone of schemes that are stable on linear problems only. Stretched by T = m v^2/r at the start
//! it turns evenly; so it does in the schemes, as x_n = r lambda^n with the root of their characteristic polynomial at
//! p = h^2 T/(m r):
//! * velocity Verlet has cos(theta) = 1 - p/2 and keeps L = m x cross v, all its kicks being central;
//! * Newmark (1/4, 1/2) has tan(theta/2) = sqrt(p)/2; as the midpoint rule in other variables it keeps L + m h^2/4 v
//!   cross a;
//! * a scheme with |lambda| < 1 brakes. A slowly changing oscillation keeps r^2 w, here L; the spring holds r, so that
//!   all of the scheme's shrinking shows in L, which falls by |lambda|^2 a step.
//!
//! On the stiff spring its invariant does not help Newmark: at h = 0.01 s the energy grows by orders of magnitude
//! within some turns. HHT and generalised alpha damp the swing along the spring and go on.

mod theory;

use crate::claim::Claim;
use crate::common::run::{case_of, changed, follow_on};
use canopy_fem::case::Case;
use serde_json::json;
use theory::{Braking, even};

/// [kg]
const MASS: f64 = 10.0;
/// [m]
const RADIUS: f64 = 3.0443;
/// [m/s]
const SPEED: f64 = 7.72;
/// [N] EA
const SOFT: f64 = 1e4;
const STIFF: f64 = 1e10;
/// [s] 100 turns
const END: f64 = 248.0;

/// The spring: k, and its length at rest.
#[derive(Clone, Copy)]
struct Spring {
    k: f64,
    rest: f64,
}

impl Spring {
    /// Stretched by the centrifugal force at the start.
    fn turning(rigidity: f64) -> Self {
        let k = rigidity / RADIUS;
        Spring { k, rest: RADIUS - MASS * SPEED * SPEED / RADIUS / k }
    }

    /// At rest at the start, as in the paper: the mass swings along the spring as well.
    fn unstretched(rigidity: f64) -> Self {
        Spring { k: rigidity / RADIUS, rest: RADIUS }
    }

    /// [1/s^2] T/(m r)
    fn pull(&self, r: f64) -> f64 {
        self.k * (r - self.rest) / (MASS * r)
    }

    fn case(&self) -> Case {
        let json = json!({
            "name": "elastic-pendulum",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": [[0, 0, 0], [RADIUS, 0, 0]], "springs": [[0, 1]]}},
                "mass": {"nodal": [0.0, MASS]},
                "springs": [{"on": "all", "stiffness": self.k, "rest_length": self.rest}],
                "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
                "initial": {"velocity": [[0, 0, 0], [0, SPEED, 0]]}
            }},
            "time": {"end": END, "method": "newmark", "step": 0.01},
            "solver": {"newton": {"relative": 1e-11}}
        });
        case_of(&json, &[])
    }
}

/// What a run left and how far it strayed.
struct Track {
    /// [rad]
    angle: f64,
    /// L over that of the start, at half of the time and at the end
    momentum: [f64; 2],
    /// [-] worst |L - L0|/L0
    momentum_off: f64,
    /// [-] the same of L + m h^2/4 v cross a
    midpoint_off: f64,
    /// [-] worst |E - E0|/E0 in the first and the second half
    energy_off: [f64; 2],
    /// largest E/E0
    energy: f64,
}

struct Plan<'a> {
    method: &'a str,
    h: f64,
    end: f64,
}

fn track(spring: Spring, Plan { method, h, end }: Plan<'_>) -> Track {
    let sets = [("time.method", method), ("time.step", &h.to_string()), ("time.end", &end.to_string())];
    // What a scheme keeps is compared to rounding, and Newton may not leave more.
    let case = changed(&changed(&spring.case(), &sets), &[("solver.newton.relative", "1e-13")]);
    let mut t = Track {
        angle: 0.0,
        momentum: [1.0; 2],
        momentum_off: 0.0,
        midpoint_off: 0.0,
        energy_off: [0.0; 2],
        energy: 1.0,
    };
    let (mut first, mut last) = (None, [1.0, 0.0]);
    follow_on(&case, |seen| {
        let ([x, y, _], [u, v, _]) = (seen.positions[1], seen.velocities[1]);
        let turning = x * v - y * u;
        let midpoint = turning * (1.0 + 0.25 * h * h * spring.pull(x.hypot(y)));
        let energy = seen.ledger.kinetic + seen.ledger.elastic;
        let (l0, m0, e0) = *first.get_or_insert((turning, midpoint, energy));
        t.angle += (last[0] * y - last[1] * x).atan2(last[0] * x + last[1] * y);
        last = [x, y];
        t.momentum_off = t.momentum_off.max((turning / l0 - 1.0).abs());
        t.midpoint_off = t.midpoint_off.max((midpoint / m0 - 1.0).abs());
        t.energy = t.energy.max(energy / e0);
        let half = usize::from(seen.t > 0.5 * end);
        t.momentum[half] = turning / l0;
        t.energy_off[half] = t.energy_off[half].max((energy / e0 - 1.0).abs());
    });
    t
}

/// What Verlet and Newmark keep, and the pace of their even turning.
fn invariants(claims: &mut Vec<Claim>) {
    let (spring, l0) = (Spring::turning(SOFT), RADIUS * SPEED);
    for h in [0.02, 0.01] {
        let verlet = track(spring, Plan { method: "velocity-verlet", h, end: END });
        let newmark = track(spring, Plan { method: "newmark", h, end: END });
        let exact = SPEED / RADIUS * END;
        let p0 = h * h * spring.pull(RADIUS);
        let of_verlet = even(spring, h, l0, |p| (1.0 - (1.0 - 0.5 * p).powi(2)).sqrt(), |p| (1.0 - 0.5 * p).acos());
        let momentum = |p: f64| p.sqrt() * (1.0 + 0.25 * p);
        let of_newmark = even(spring, h, l0 * (1.0 + 0.25 * p0), momentum, |p| 2.0 * (0.5 * p.sqrt()).atan());
        // Rounding of 25,000 steps: one by one at random, or, where a first guess is so good that no more than rounding
        // of positions is left to Newton, on one side.
        claims.push(Claim::below(
            format!("soft, velocity-verlet, h {h}: worst relative change of L in 100 turns"),
            verlet.momentum_off,
            1e-13,
        ));
        claims.push(Claim::below(
            format!("soft, newmark, h {h}: worst relative change of L + m h^2/4 v x a in 100 turns"),
            newmark.midpoint_off,
            2e-11,
        ));
        // Starting off the scheme's own radius by h^2/4 of it leaves a swing along the spring: its square and end are
        // seen.
        for (name, t, own) in [("velocity-verlet", verlet, of_verlet), ("newmark", newmark, of_newmark)] {
            claims.push(Claim::relative(
                format!("soft, {name}, h {h}: angle gained or lost in 100 turns [rad]"),
                t.angle - exact,
                own - exact,
                2e-5,
            ));
        }
    }
}

/// Runge and Kutta's scheme loses L with order 5 and angle with order 4.
fn runge_kutta(claims: &mut Vec<Claim>) {
    let run = |h: f64| track(Spring::turning(SOFT), Plan { method: "rk4", h, end: END });
    let (coarse, fine) = (run(0.01), run(0.005));
    let order = |a: f64, b: f64| (a / b).log2();
    let off = |t: &Track| t.angle - SPEED / RADIUS * END;
    // w h of the swing along the spring is 0.18: the next term is of that share.
    claims.push(Claim::absolute(
        "soft, rk4, h 0.01 and 0.005: order of the angle",
        order(off(&coarse), off(&fine)),
        4.0,
        0.2,
    ));
    let lost = order(coarse.momentum_off, fine.momentum_off);
    claims.push(Claim::absolute("soft, rk4, h 0.01 and 0.005: order of the lost L", lost, 5.0, 0.2));
}

/// Schemes with |lambda| < 1, on the soft and on the stiff spring, with the step that Newmark does not survive there.
fn braking(claims: &mut Vec<Claim>) {
    for (name, rigidity) in [("soft", SOFT), ("stiff", STIFF)] {
        let spring = Spring::turning(rigidity);
        for (method, scheme) in [
            ("hht", Braking::Alpha { am: 0.0, af: 0.1 }),
            // rho_inf 0.8
            ("generalized-alpha", Braking::Alpha { am: 0.6 / 1.8, af: 0.8 / 1.8 }),
            ("backward-euler", Braking::BackwardEuler),
        ] {
            let h = 0.01;
            // The first turns are not even yet.
            let [half, end] = track(spring, Plan { method, h, end: END }).momentum;
            claims.push(Claim::relative(
                format!("{name}, {method}, h {h}: share of L lost from turn 50 to 100, by |lambda|^2 a step"),
                1.0 - end / half,
                1.0 - scheme.momentum(spring, h, half) / half,
                // p = (h v/r)^2 = 6e-4 of it lies between L and the amplitude of x
                2e-3,
            ));
        }
    }
}

/// The paper's start, unstretched: no drift of the energy where the axial swing is resolved.
fn bounded(claims: &mut Vec<Claim>) {
    for method in ["velocity-verlet", "newmark"] {
        let run = |h: f64| track(Spring::unstretched(SOFT), Plan { method, h, end: END }).energy_off;
        let ([early, late], [half, _]) = (run(0.02), run(0.01));
        claims.push(Claim::between(
            format!("soft, unstretched, {method}: worst energy error of the second 50 turns over that of the first"),
            late / early,
            0.99,
            1.01,
        ));
        claims.push(Claim::absolute(
            format!("soft, unstretched, {method}, h 0.02 and 0.01: order of the worst energy error"),
            (early / half).log2(),
            2.0,
            0.1,
        ));
    }
}

fn stiff(claims: &mut Vec<Claim>) {
    let spring = Spring::unstretched(STIFF);
    let limit = 2.0 / (spring.k / MASS).sqrt();
    let verlet = |share: f64| track(spring, Plan { method: "velocity-verlet", h: share * limit, end: 2.48 });
    let (below, above) = (verlet(0.9), verlet(1.01));
    claims.push(Claim::below(
        "stiff, velocity-verlet, 0.9 of the limit: worst relative change of L in a turn",
        below.momentum_off,
        1e-13,
    ));
    claims.push(Claim::below(
        "stiff, velocity-verlet, 0.9 of the limit: worst energy error in a turn",
        below.energy_off[1],
        1e-7,
    ));
    claims.push(Claim::between(
        "stiff, velocity-verlet, 1.01 of the limit: energy over that of the start in a turn",
        above.energy,
        10.0,
        f64::MAX,
    ));
    let small = track(spring, Plan { method: "newmark", h: 0.005, end: END });
    claims.push(Claim::below("stiff, newmark, h 0.005: worst energy error in 100 turns", small.energy_off[1], 5e-4));
    let large = track(spring, Plan { method: "newmark", h: 0.01, end: END });
    // Rounding decides when and how far; 65 to 1e5 have been seen.
    claims.push(Claim::between(
        "stiff, newmark, h 0.01: largest energy over that of the start, it blows up",
        large.energy,
        10.0,
        f64::MAX,
    ));
    claims.push(Claim::below(
        "stiff, newmark, h 0.01: worst change of L + m h^2/4 v x a up to there",
        large.midpoint_off,
        1e-7,
    ));
}

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    for part in [invariants, runge_kutta, braking, bounded, stiff] {
        part(&mut claims);
    }
    claims
}
