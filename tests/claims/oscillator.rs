//! The oscillator of the thesis' Appendix A, k = 3 N/m, m = 2 kg, from 2 m with and without a speed, with and without a
//! dashpot. With s = -zeta w0 + i wd the complex motion Z = (x - i (v + zeta w0 x)/wd)/A is exp(s t) times a phase: x =
//! A exp(-zeta w0 t) sin(wd t + phi), phi = atan2(x0 wd, v0 + zeta w0 x0). A scheme of order p turns it by exp(s h + K
//! (s h)^(p+1) + ...) a step instead of exp(s h), so after a time T its error is |exp(K s^(p+1) h^p T) - 1| of what is
//! left: a closed form, no bound.

use crate::claim::Claim;
use crate::common::run::{asset, changed};
use crate::signal::Signal;
use canopy_fem::case::Case;
use canopy_fem::integrate::registry::methods;
use std::f64::consts::TAU;

/// [N/m], [kg], [m]
const K: f64 = 3.0;
const M: f64 = 2.0;
const X0: f64 = 2.0;
/// [m] where the spring has its rest length
const REST: f64 = 10.0;

/// A method with the leading term of its error. `pure`: one step is a function of s h alone, damping or not.
struct Scheme {
    name: &'static str,
    order: i32,
    constant: f64,
    pure: bool,
}

const fn scheme(name: &'static str, order: i32, constant: f64, pure: bool) -> Scheme {
    Scheme { name, order, constant, pure }
}

/// Runge-Kutta of order p: what z^(p+1) is multiplied by less 1/(p+1)!, which is -1/(p+1)! with as many stages as the
/// order. Two-step Adams-Bashforth, trapezium, Euler: the textbook's. Verlet turns by 2 asin(w h/2). Generalised alpha:
/// (beta - (af - am) af - 1/12)/2, by expansion of its characteristic polynomial; HHT is the case am = 0, af = -alpha.
/// Kang's sweeps are exact for one spring to an anchor: backward Euler.
const SCHEMES: [Scheme; 20] = [
    scheme("explicit-euler", 1, -1.0 / 2.0, true),
    scheme("backward-euler", 1, 1.0 / 2.0, true),
    scheme("kang", 1, 1.0 / 2.0, false),
    // backward Euler in ten short steps, and in one
    scheme("xpbd", 1, 1.0 / 20.0, true),
    scheme("vbd", 1, 1.0 / 2.0, true),
    scheme("euler-richardson", 2, -1.0 / 6.0, true),
    scheme("improved-euler", 2, -1.0 / 6.0, true),
    scheme("improved-euler-pec", 2, -5.0 / 12.0, true),
    scheme("velocity-verlet", 2, -1.0 / 24.0, false),
    scheme("beeman", 3, -1.0 / 24.0, false),
    scheme("central-difference", 2, -1.0 / 24.0, false),
    // the only spring is stiff, in six short steps
    scheme("multirate", 2, -1.0 / 864.0, false),
    scheme("newmark", 2, 1.0 / 12.0, true),
    scheme("energy-momentum", 2, 1.0 / 12.0, true),
    scheme("hht", 2, 0.5 * (0.3025 - 0.01 - 1.0 / 12.0), false),
    scheme("generalized-alpha", 2, 0.5 * (25.0 / 81.0 - 4.0 / 81.0 - 1.0 / 12.0), false),
    scheme("rk4", 4, -1.0 / 120.0, true),
    // exp(z) (1 - z/4)^5 from z^5 on, which ESDIRK4 leaves out
    scheme("esdirk4", 4, -13.0 / 15360.0, true),
    scheme("dormand-prince", 5, 1.0 / 600.0 - 1.0 / 720.0, true),
    scheme("dop853", 8, 2.691_692_2e-6 - 1.0 / 362_880.0, true),
];

/// A motion of Appendix A in closed form.
#[derive(Clone, Copy)]
struct Motion {
    /// [1/s] zeta w0
    decay: f64,
    /// [rad/s]
    wd: f64,
    /// [m] A
    amplitude: f64,
    /// [rad]
    phase: f64,
}

impl Motion {
    /// `c` in N s/m, `v0` in m/s.
    fn of(c: f64, v0: f64) -> Self {
        let decay = c / (2.0 * M);
        let wd = (K / M - decay * decay).sqrt();
        let b = (v0 + decay * X0) / wd;
        Motion { decay, wd, amplitude: X0.hypot(b), phase: X0.atan2(b) }
    }

    /// x and v.
    fn at(&self, t: f64) -> (f64, f64) {
        let envelope = self.amplitude * (-self.decay * t).exp();
        let (sin, cos) = (self.wd * t + self.phase).sin_cos();
        (envelope * sin, envelope * (self.wd * cos - self.decay * sin))
    }

    /// [-] |Z/Z_exact - 1| of a state.
    fn error(&self, t: f64, (x, v): (f64, f64)) -> f64 {
        let (ex, ev) = self.at(t);
        let turned = |x: f64, v: f64| (v + self.decay * x) / self.wd;
        (x - ex).hypot(turned(x, v) - turned(ex, ev)) / (self.amplitude * (-self.decay * t).exp())
    }

    /// [-] The same as the leading term predicts it.
    fn predicted(&self, s: &Scheme, h: f64, t: f64) -> f64 {
        let (size, angle) = (self.wd.hypot(self.decay), self.wd.atan2(-self.decay));
        let n = f64::from(s.order + 1);
        let (sin, cos) = (n * angle).sin_cos();
        let drift = s.constant * size.powf(n) * h.powi(s.order) * t;
        let (growth, turn) = ((drift * cos).exp(), drift * sin);
        (growth * turn.cos() - 1.0).hypot(growth * turn.sin())
    }
}

/// Steps a period and periods of a run.
#[derive(Clone, Copy)]
struct Pace {
    steps: u32,
    periods: u32,
}

fn follow(case: &Case, motion: Motion, method: &str, pace: Pace) -> Signal {
    let h = TAU / motion.wd / f64::from(pace.steps);
    let end = h * f64::from(pace.steps * pace.periods);
    let sets = [("time.method", method), ("time.step", &h.to_string()), ("time.end", &end.to_string())];
    Signal::of(&changed(case, &sets), |seen| (seen.positions[1][0] - REST, seen.velocities[1][0]))
}

fn last_error(motion: Motion, signal: &Signal) -> f64 {
    let i = signal.t.len() - 1;
    motion.error(signal.t[i], (signal.x[i], signal.v[i]))
}

/// What a case says of the motion.
struct Example {
    title: &'static str,
    case: Case,
    motion: Motion,
}

fn examples() -> [Example; 3] {
    let pushed = [("system.network.initial.velocity", "[1.5, 0, 0]")];
    [
        Example { title: "from rest", case: asset("oscillator", &[]), motion: Motion::of(0.0, 0.0) },
        Example { title: "v0 1.5 m/s", case: asset("oscillator", &pushed), motion: Motion::of(0.0, 1.5) },
        Example {
            title: "damped, v0 1.5 m/s",
            case: asset("oscillator-damped", &pushed),
            motion: Motion::of(0.5, 1.5),
        },
    ]
}

pub fn claims() -> Vec<Claim> {
    // The error of euler-cromer has no leading term of this kind, and claims of its own.
    let has_term = |name: &str| SCHEMES.iter().any(|s| s.name == name) || name == "euler-cromer";
    let without: Vec<&str> = methods().iter().map(|m| m.name).filter(|name| !has_term(name)).collect();
    assert!(without.is_empty(), "SCHEMES wants the leading error term of {without:?}");
    let mut claims = Vec::new();
    for Example { title, case, motion } in examples() {
        let damped = motion.decay > 0.0;
        // The drift of 10 periods (40 without damping) stands far above what a start or a velocity is off once, which
        // the leading term leaves out: 1 in 100. First order takes finer steps, so that its square does not count
        // either.
        for s in SCHEMES.iter().filter(|s| s.pure || !damped) {
            let pace = match (s.order, damped) {
                (1, _) => Pace { steps: 1000, periods: 10 },
                // Any finer and rounding would show.
                (8, _) => Pace { steps: 30, periods: if damped { 10 } else { 40 } },
                (_, true) => Pace { steps: 100, periods: 10 },
                (_, false) => Pace { steps: 100, periods: 40 },
            };
            let run = follow(&case, motion, s.name, pace);
            let expected = motion.predicted(s, run.t[1], run.t[run.t.len() - 1]);
            claims.push(Claim::relative(
                format!("{title}, {}: error after {} periods, {} steps each", s.name, pace.periods, pace.steps),
                last_error(motion, &run),
                expected,
                match s.order {
                    1 => 2e-3,
                    // At w h = 0.2 the next term is a tenth of the first.
                    8 => 0.1,
                    _ => 0.02,
                },
            ));
        }
        claims.extend(closed_form(title, &case, motion));
        if damped {
            claims.extend(orders(&case, motion));
        } else {
            claims.extend(euler_cromer(title, &case, motion));
        }
    }
    claims
}

/// x and v apart, with the scheme of smallest error: w^5 h^4/120 times the largest t exp(-zeta w t) of the run.
fn closed_form(title: &str, case: &Case, motion: Motion) -> [Claim; 2] {
    let run = follow(case, motion, "rk4", Pace { steps: 1000, periods: 10 });
    let (mut x, mut v) = (0.0_f64, 0.0_f64);
    for i in 0..run.t.len() {
        let (ex, ev) = motion.at(run.t[i]);
        x = x.max((run.x[i] - ex).abs() / motion.amplitude);
        v = v.max((run.v[i] - ev).abs() / (motion.amplitude * motion.wd));
    }
    let expected = run.t.iter().map(|&t| t * (-motion.decay * t).exp()).fold(0.0, f64::max)
        * motion.wd.hypot(motion.decay).powi(5)
        * run.t[1].powi(4)
        / 120.0;
    // The worst is found where the error's own oscillation peaks, up to a quarter period from the envelope's.
    [("x", x), ("v", v)].map(|(what, off)| {
        Claim::relative(format!("{title}, rk4: worst {what} off the closed form, over A"), off, expected, 0.1)
    })
}

/// Where one step of the scheme is no function of s h alone, its order: halved steps leave 1/2^p of the error.
fn orders(case: &Case, motion: Motion) -> Vec<Claim> {
    let methods = [
        ("euler-cromer", 1.0),
        ("central-difference", 1.0),
        ("multirate", 1.0),
        ("kang", 1.0),
        ("velocity-verlet", 2.0),
        ("beeman", 3.0),
        ("hht", 2.0),
        ("generalized-alpha", 2.0),
    ];
    let claim = |(name, order): (&str, f64)| {
        let error = |steps| last_error(motion, &follow(case, motion, name, Pace { steps, periods: 1 }));
        // The next term of the error is w h = 0.006 of the first, or a few times that.
        Claim::absolute(
            format!("damped, {name}: order from 1000 and 2000 steps a period"),
            (error(1000) / error(2000)).log2(),
            order,
            0.02,
        )
    };
    methods.map(claim).to_vec()
}

/// Euler-Cromer's speeds belong to half a step earlier. Its first-order error is that and does not grow: w h/2 of x0 in
/// x, w h/2 of v0/w in v/w. The phase turns in second order only, w h/12 of that in one period; the step's own end is w
/// h/2.
fn euler_cromer(title: &str, case: &Case, motion: Motion) -> Vec<Claim> {
    let run = follow(case, motion, "euler-cromer", Pace { steps: 1000, periods: 1 });
    let z = motion.wd * run.t[1];
    let v0 = motion.at(0.0).1;
    let worst = |off: &dyn Fn(usize) -> f64| (0..run.t.len()).map(off).fold(0.0_f64, |m, e| m.max(e.abs()));
    let x = worst(&|i| run.x[i] - motion.at(run.t[i]).0);
    let v = worst(&|i| run.v[i] - motion.at(run.t[i]).1);
    let mut claims = vec![Claim::relative(
        format!("{title}, euler-cromer: worst x in one period over x0 w h/2"),
        x / (X0 * z / 2.0),
        1.0,
        0.01,
    )];
    if v0 > 1e-9 {
        let share = v / (v0 * z / 2.0);
        claims.push(Claim::relative(
            format!("{title}, euler-cromer: worst v in one period over v0 w h/2"),
            share,
            1.0,
            0.01,
        ));
    }
    claims
}
