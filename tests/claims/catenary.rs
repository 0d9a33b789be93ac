//! A chain of n elastic links between two points of equal height, brought to rest by backward Euler with damping. Its
//! forces are those of the funicular polygon: one horizontal pull H in all links, and a vertical one that changes by m
//! g at every bead. With a link's length l0 (1 + T/EA) its form follows exactly, whatever n. For many links it tends to
//! the elastic catenary (Irvine, Cable Structures, section 1.3) from the half length s, of weight W in all:
//!
//! x = H s/EA + H/w asinh(w s/H), z = w s^2/(2 EA) + H/w (sqrt(1 + (w s/H)^2) - 1), w = W/S
//!
//! and without elasticity to z = a cosh(x/a). The polygon takes the integrals behind it by the midpoint rule: its error
//! falls with n^-2.

use crate::claim::Claim;
use crate::common::run::{Run, case_of, run};
use canopy_fem::drive::Status;
use serde_json::json;

/// [m] span and length of the chain
const SPAN: f64 = 1.0;
const LENGTH: f64 = 1.4;
/// [N] weight of the whole chain
const WEIGHT: f64 = 9.81;
/// [N] a stretch of some 1e-5
const EA: f64 = 1e4 * WEIGHT;
/// [m/s^2]
const G: f64 = 9.81;

/// Root of a function that rises from below 0 at `low` to above 0 at `high`.
fn root(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        *if f(middle) < 0.0 { &mut low } else { &mut high } = middle;
    }
    0.5 * (low + high)
}

/// The run's start: links of their rest length on an arc of a circle, which is no funicular of a weight.
fn arc(links: usize) -> Vec<[f64; 3]> {
    let n = links as f64;
    // A link sees 2 p of the circle: span = l0 sin(n p)/sin(p), which falls with p.
    let p = root(1e-3 / n, 3.0 / n, |p| SPAN - LENGTH / n * (n * p).sin() / p.sin());
    let radius = LENGTH / n / (2.0 * p.sin());
    let angle = |i: usize| p * (2.0 * i as f64 - n);
    (0..=links).map(|i| [radius * angle(i).sin(), 0.0, radius * ((n * p).cos() - angle(i).cos())]).collect()
}

fn at_rest(links: usize) -> Run {
    let edges: Vec<[usize; 2]> = (0..links).map(|i| [i, i + 1]).collect();
    let case = json!({
        "name": "catenary",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": arc(links), "springs": edges}},
            "mass": {"nodal": WEIGHT / G / links as f64},
            "springs": [{"on": "all", "axial_rigidity": EA, "rest_length": LENGTH / links as f64}],
            "supports": [{"on": {"ids": [0, links]}, "fix": "xyz"}],
            "gravity": [0, 0, -G],
            "damping": {"rayleigh": {"mass": 10.0}}
        }},
        // The slowest oscillation, 5 rad/s, is critically damped; exp(-40) is left.
        "time": {"end": 8.0, "method": "backward-euler", "step": 0.01},
        "solver": {"newton": {"relative": 1e-13, "max_iterations": 100}}
    });
    let run = run(&case_of(&case, &[]));
    assert_eq!(run.outcome.status, Status::Completed, "{:?}", run.outcome.failure);
    run
}

/// [N] Horizontal and vertical part of every link's pull, from the positions alone.
fn pulls(positions: &[[f64; 3]]) -> Vec<[f64; 2]> {
    let rest = LENGTH / (positions.len() - 1) as f64;
    let pull = |ends: &[[f64; 3]]| {
        let (dx, dz) = (ends[1][0] - ends[0][0], ends[1][2] - ends[0][2]);
        let l = dx.hypot(dz);
        let tension = EA * (l / rest - 1.0);
        [tension * dx / l, tension * dz / l]
    };
    positions.windows(2).map(pull).collect()
}

/// [m] Extent of half a polygon of `links` links under the horizontal pull `h`: half the span, and the sag.
fn half_polygon(links: usize, h: f64) -> [f64; 2] {
    let (load, rest) = (WEIGHT / links as f64, LENGTH / links as f64);
    let mut extent = [0.0; 2];
    for i in 0..links / 2 {
        let v = (i as f64 + 0.5) * load;
        let tension = h.hypot(v);
        let length = rest * (1.0 + tension / EA);
        extent[0] += length * h / tension;
        extent[1] += length * v / tension;
    }
    extent
}

/// [m] The same of the elastic catenary.
fn half_catenary(h: f64) -> [f64; 2] {
    let (s, w) = (0.5 * LENGTH, WEIGHT / LENGTH);
    let u = w * s / h;
    [h * s / EA + h / w * u.asinh(), 0.5 * w * s * s / EA + h / w * (1.0f64.hypot(u) - 1.0)]
}

/// Horizontal pull and sag for which half the span is right.
fn solved(extent: impl Fn(f64) -> [f64; 2]) -> [f64; 2] {
    let h = root(1e-3 * WEIGHT, 10.0 * WEIGHT, |h| extent(h)[0] - 0.5 * SPAN);
    [h, extent(h)[1]]
}

/// [m] Sag of z = a cosh(x/a) of the given length.
fn inextensible() -> f64 {
    // 2 a sinh(span/(2 a)) falls with a.
    let a = root(0.05, 10.0, |a| LENGTH - 2.0 * a * (SPAN / (2.0 * a)).sinh());
    a * ((SPAN / (2.0 * a)).cosh() - 1.0)
}

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    let continuous = solved(half_catenary)[1];
    let mut errors = Vec::new();
    for links in [20, 40, 80] {
        let rest = at_rest(links);
        let sag = -rest.positions[links / 2][2];
        errors.push(sag - continuous);
        claims.extend(polygon(links, &rest, sag));
    }
    for (i, n) in [(0, 20), (1, 40)] {
        let order = (errors[i] / errors[i + 1]).log2();
        // The midpoint rule's next term is (w l0/H)^2 of the first or a share of it: 0.03 at 20 links.
        claims.push(Claim::absolute(format!("order of the sag's error, {n} and {} links", 2 * n), order, 2.0, 0.02));
    }
    // What the orders lack of 2 is an error of n^-4, b = 0.001 of the finest one; extrapolation leaves 4/3 b of it,
    // 1e-7.
    let extrapolated = continuous + (4.0 * errors[2] - errors[1]) / 3.0;
    let what = "sag extrapolated from 40 and 80 links: the elastic catenary";
    claims.push(Claim::relative(what, extrapolated, continuous, 3e-7));
    let what = "the same over the sag of a cosh(x/a), less 1: the stretch of the elastic one";
    let flat = inextensible();
    claims.push(Claim::relative(what, extrapolated / flat - 1.0, continuous / flat - 1.0, 4e-3));
    claims
}

fn polygon(links: usize, rest: &Run, sag: f64) -> [Claim; 4] {
    let [pull, exact] = solved(|h| half_polygon(links, h));
    let forces = pulls(&rest.positions);
    let load = WEIGHT / links as f64;
    let worst = |off: Vec<f64>| off.into_iter().fold(0.0, f64::max);
    let level = worst(forces.iter().map(|f| (f[0] / pull - 1.0).abs()).collect());
    let steps = worst(forces.windows(2).map(|f| ((f[1][1] - f[0][1]) / load - 1.0).abs()).collect());
    // Positions of 0.5 m are rounded to 1e-16 m, so a link's pull to EA n 1e-16 or a few of them, beside m g = W/n.
    // Along the chain n such beads, of either sign, change the horizontal pull.
    let n = links as f64;
    let rounding = EA / WEIGHT * n * f64::EPSILON;
    [
        Claim::below(
            format!("{links} links: horizontal pull in all links, worst share off"),
            level,
            0.4 * n * rounding,
        ),
        Claim::below(
            format!("{links} links: vertical pull changes by m g, worst share off"),
            steps,
            6.0 * n * rounding,
        ),
        Claim::relative(format!("{links} links: sag of the elastic polygon"), sag, exact, 5e-15),
        Claim::below(
            format!("{links} links: speed left [m/s]"),
            worst(rest.velocities.iter().map(|v| v[0].hypot(v[2])).collect()),
            3e-13,
        ),
    ]
}
