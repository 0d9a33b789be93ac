//! What every scheme does to the energy of an undamped oscillator, W = w h: kinetic, elastic and numerical of the
//! program's own account against the closed forms of the schemes (Hairer, Lubich & Wanner 2006, chapters I and IX;
//! Hughes 1987, chapter 9).

use crate::claim::Claim;
use crate::common::polynomials::{esdirk4_size, size, stability_polynomial};
use crate::common::run::{case_of, follow_on};
use crate::linear_theory::{generalized_alpha, hht, newmark};
use crate::one_mass::{Row, frequency, rows};
use faer::c64;
use serde_json::{Value, json};

/// Rounding of l - l0, which is 1/16 to 1/64 of l, squared in the energy.
const ROUNDING: f64 = 5e-14;

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    for wh in [0.1, 0.5, 1.0] {
        claims.extend(fixed_factors(wh));
    }
    for wh in [0.1, 0.5, 1.5] {
        euler_cromer(wh, &mut claims);
        verlet(wh, &mut claims);
    }
    predicted_only(&mut claims);
    for (name, method) in [("newmark 1/4", "newmark"), ("energy-momentum", "energy-momentum")] {
        for wh in [0.1, 1.0, 10.0] {
            let kept = worst(&rows(&json!(method), wh, 10_000), Row::energy);
            // The map's coefficients 4/h^2, 4/h, 2/h are rounded once for all steps, which makes growth or decay of
            // some eps a step.
            claims.push(Claim::below(
                format!("{name}: w h {wh}: energy over 10^4 steps, worst share off"),
                kept,
                1e-11,
            ));
        }
    }
    claims.push(Claim::below(
        "newmark 1/4: chain of 12 masses, w h 0.5 to 4, h = 2 s: energy over 10^4 steps, worst share off",
        chain(),
        5e-12,
    ));
    for named in [
        newmark(0.3025, 0.6),
        hht(-0.1),
        hht(-0.3),
        generalized_alpha(0.8),
        generalized_alpha(0.3),
        generalized_alpha(0.0),
    ] {
        for wh in [0.3, 1.5] {
            claims.push(decay(&named.name(), &named.method, wh, named.member.character(wh).radius));
        }
    }
    for wh in [0.1, 0.3, 1.0] {
        claims.push(decay("beeman", &json!("beeman"), wh, beeman_radius(wh)));
    }
    claims
}

/// |R(iW)|^2
fn runge_kutta(method: &str, wh: f64) -> f64 {
    stability_polynomial(method).map_or(f64::NAN, |coefficients| size(&coefficients, (0.0, wh)).powi(2))
}

/// Schemes that are one complex number on an oscillator: they multiply the energy by the same factor in every step.
fn fixed_factors(wh: f64) -> Vec<Claim> {
    let w2 = wh * wh;
    // |1 + iW|^2, |1 + iW - W^2/2|^2, |1 + iW - W^2/2 - iW^3/6 + W^4/24|^2 and 1/|1 - iW|^2;
    // Kang's filter on one mass with an anchor is backward Euler, and so are the other methods that go along springs,
    // one of them in ten short steps.
    let factors = [
        ("explicit-euler", 1.0 + w2),
        ("euler-richardson", 1.0 + w2 * w2 / 4.0),
        ("improved-euler", 1.0 + w2 * w2 / 4.0),
        ("rk4", 1.0 - w2.powi(3) / 72.0 + w2.powi(4) / 576.0),
        ("dormand-prince", runge_kutta("dormand-prince", wh)),
        ("dop853", runge_kutta("dop853", wh)),
        ("esdirk4", esdirk4_size(wh).powi(2)),
        ("backward-euler", 1.0 / (1.0 + w2)),
        ("kang", 1.0 / (1.0 + w2)),
        ("xpbd", (1.0 + w2 / 100.0).powi(-10)),
        ("vbd", 1.0 / (1.0 + w2)),
    ];
    let mut claims = Vec::new();
    for (method, factor) in factors {
        // So many steps that the amplitude stays between a quarter of the first and four times it.
        let steps = (16f64.ln() / factor.ln().abs()).clamp(2.0, 200.0) as usize;
        let rows = rows(&json!(method), wh, steps);
        let ratios = rows.windows(2).map(|w| w[1].energy() / w[0].energy());
        let farthest = ratios.max_by(|a, b| (a - factor).abs().total_cmp(&(b - factor).abs())).unwrap_or(f64::NAN);
        claims.push(Claim::relative(format!("{method}: w h {wh}: energy a step"), farthest, factor, ROUNDING));
        let lost = rows[steps].ledger.numerical / rows[0].energy();
        let what = format!("{method}: w h {wh}: numerical after {steps} steps over the first energy");
        let grown = factor.powi(steps as i32);
        // The stages of dop853 have weights up to 43, which cancel; the energy of all steps adds up what they round.
        // esdirk4 solves five times a step.
        let digits = match method {
            "dop853" => 20.0,
            "esdirk4" => 10.0,
            _ => 2.0,
        };
        claims.push(Claim::absolute(what, lost, 1.0 - grown, digits * ROUNDING * grown.max(1.0)));
    }
    claims
}

/// Largest change of `kept` over a run, as a share of its first value.
fn worst(rows: &[Row], kept: impl Fn(&Row) -> f64) -> f64 {
    let first = kept(&rows[0]);
    rows.iter().map(|r| (kept(r) / first - 1.0).abs()).fold(0.0, f64::max)
}

/// Largest and smallest energy over the first.
fn extremes(rows: &[Row]) -> [f64; 2] {
    let shares = rows.iter().map(|r| r.energy() / rows[0].energy());
    shares.fold([f64::INFINITY, 0.0], |[low, high], e| [low.min(e), high.max(e)])
}

/// 10^4 steps pass within some 1e-3 rad of every phase (W is no fraction of a turn), and energy is level at its
/// extremes.
const PHASES: f64 = 3e-6;

/// Keeps v^2 + w^2 x^2 - w^2 h x v (thesis Eq. 15-16). On that ellipse the energy is I/2/(1 - W/2 sin 2 phi).
fn euler_cromer(wh: f64, claims: &mut Vec<Claim>) {
    let w = frequency();
    let rows = rows(&json!("euler-cromer"), wh, 10_000);
    let kept = worst(&rows, |r| r.v.powi(2) + (w * r.x).powi(2) - wh * w * r.x * r.v);
    claims.push(Claim::below(
        format!("euler-cromer: w h {wh}: v^2 + w^2 x^2 - w^2 h x v over 10^4 steps"),
        kept,
        1e-12,
    ));
    let [low, high] = extremes(&rows);
    let name = |which| format!("euler-cromer: w h {wh}: {which} energy over the first");
    claims.push(Claim::relative(name("largest"), high, 1.0 / (1.0 - wh / 2.0), PHASES));
    claims.push(Claim::relative(name("smallest"), low, 1.0 / (1.0 + wh / 2.0), PHASES));
}

/// Keeps v^2 + w^2 x^2 (1 - W^2/4): the energy is lower by W^2/4 where the spring is at rest.
fn verlet(wh: f64, claims: &mut Vec<Claim>) {
    let w = frequency();
    let rows = rows(&json!("velocity-verlet"), wh, 10_000);
    let kept = worst(&rows, |r| r.v.powi(2) + (w * r.x).powi(2) * (1.0 - wh * wh / 4.0));
    claims.push(Claim::below(
        format!("velocity-verlet: w h {wh}: v^2 + w^2 x^2 (1 - W^2/4) over 10^4 steps"),
        kept,
        1e-12,
    ));
    let [low, high] = extremes(&rows);
    let name = |which| format!("velocity-verlet: w h {wh}: {which} energy over the first");
    claims.push(Claim::relative(name("largest"), high, 1.0, 1e-12));
    claims.push(Claim::relative(name("smallest"), low, 1.0 - wh * wh / 4.0, PHASES));
}

/// PEC is Adams-Bashforth 2 on linear problems: z^2 - (1 + 3/2 iW) z + iW/2. Its second root is about iW/2 and dies
/// out.
fn predicted_only(claims: &mut Vec<Claim>) {
    for wh in [0.1, 0.3] {
        let z = c64::new(0.0, wh);
        let b = c64::new(1.0, 0.0) + z * 1.5;
        let root = (b + (b * b - z * 2.0).sqrt()) * 0.5;
        let rows = rows(&json!("improved-euler-pec"), wh, 60);
        let growth = (rows[60].energy() / rows[40].energy()).powf(1.0 / 20.0);
        let what = format!("improved-euler-pec: w h {wh}: energy a step, after 40 steps");
        claims.push(Claim::relative(what, growth, root.re.powi(2) + root.im.powi(2), ROUNDING));
    }
}

/// x_n^2 - x_{n-1} x_{n+1} of an oscillation c z^n is |z|^2 times itself a step: the spectral radius without any phase
/// in it, once the third root has died out.
fn decay(name: &str, method: &Value, wh: f64, expected: f64) -> Claim {
    let (first, last) = (40, 60);
    let rows = rows(method, wh, last + 1);
    let q = |n: usize| rows[n].x.powi(2) - rows[n - 1].x * rows[n + 1].x;
    let radius = (q(last) / q(first)).powf(0.5 / (last - first) as f64);
    // Rounding of the force is 1e-16 of that at x = l0, x is down to START radius^60; the root of 20 steps takes most
    // of it back.
    let digits = 2e-14 + 1e-17 * expected.powi(-(last as i32));
    Claim::relative(format!("{name}: w h {wh}: amplitude a step"), radius, expected, digits)
}

/// Beeman's step has the roots of z^3 - 2 z^2 + z + W^2 (13 z^2 - 2 z + 1)/12: a pair, and a small real one by Newton's
/// iteration. The product of all is -W^2/12.
fn beeman_radius(wh: f64) -> f64 {
    let w2 = wh * wh / 12.0;
    let mut root = -w2;
    for _ in 0..50 {
        let value = ((root - 2.0 + 13.0 * w2) * root + 1.0 - 2.0 * w2) * root + w2;
        root -= value / ((3.0 * root + 2.0 * (13.0 * w2 - 2.0)) * root + 1.0 - 2.0 * w2);
    }
    (-w2 / root).sqrt()
}

/// A chain between two anchors, moving along itself: linear, with frequencies from 0.12 to 2 times the fastest of one
/// spring.
fn chain() -> f64 {
    let n = 12;
    let nodes: Vec<Value> = (0..n + 2).map(|i| json!([i, 0, 0])).collect();
    let springs: Vec<Value> = (0..=n).map(|i| json!([i, i + 1])).collect();
    let speed = |i: i32| if i == 0 || i == n + 1 { 0.0 } else { 0.02 * (1.7 * f64::from(i * i)).sin() };
    let velocity: Vec<Value> = (0..n + 2).map(|i| json!([speed(i), 0.0, 0.0])).collect();
    let case = json!({
        "name": "chain",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": nodes, "springs": springs}},
            "mass": {"nodal": 1.0},
            "springs": [{"on": "all", "stiffness": 1.0}],
            "supports": [{"on": {"ids": [0, n + 1]}, "fix": "xyz"}, {"on": "all", "fix": "yz"}],
            "initial": {"velocity": velocity}
        }},
        "time": {"end": 20_000.0, "method": "newmark", "step": 2.0}
    });
    let (mut first, mut off) = (None, 0.0_f64);
    follow_on(&case_of(&case, &[]), |seen| {
        let energy = seen.ledger.kinetic + seen.ledger.elastic;
        let first: f64 = *first.get_or_insert(energy);
        off = off.max((energy / first - 1.0).abs());
    });
    off
}
