//! Taylor's parachute (G. I. Taylor, "On the shapes of parachutes", 1919): sin(phi) = (r/R)^2 up to the skirt, where the
//! meridian meets the lines. Its D0 is twice the length of a radial. That of the area of n flat gores is smaller, by
//! 0.4 % for 28 gores: with it, the same shape seems wider.

use super::{DAMPING, PRESSURE, RIGIDITY, SETTLED, Settled, Vector, length, polygon, widest};
use crate::claim::Claim;
use serde_json::json;
use std::f64::consts::PI;

const GORES: usize = 12;
/// [-] L/D0, Dp/D0, Ds/D0, depth/Dp, half cone angle [degrees], Vol/R^3, from the closed form with elliptic integrals
const TABLE: [[f64; 6]; 6] = [
    [0.8, 0.659242, 0.631880, 0.399632, 23.2613, 1.984887],
    [0.9, 0.668202, 0.645591, 0.390212, 21.0180, 1.930066],
    [1.0, 0.675720, 0.656719, 0.382394, 19.1692, 1.883940],
    [1.2, 0.687634, 0.673670, 0.370184, 16.3017, 1.810874],
    [1.5, 0.700401, 0.690923, 0.357372, 13.3152, 1.733054],
    [2.0, 0.714136, 0.708468, 0.343931, 10.2019, 1.650388],
];
const NAMES: [&str; 5] = ["Dp/D0", "Ds/D0", "depth/Dp", "half cone angle", "Vol/R^3"];

/// A parachute of radials 1 m long and lines `ratio` times as long as two of them, flat, then settled.
fn settled(ratio: f64, rows: usize) -> Settled {
    let n = GORES as f64;
    // S0 = n sin(2 pi/n)/2 for radials of 1 m
    let nominal_diameter = (2.0 * n * (2.0 * PI / n).sin() / PI).sqrt();
    // Of the same mass for all meshes, and heavier at the apex, where all radials pull.
    let mass = 0.16 / rows as f64;
    let step = 0.9 * (mass / (RIGIDITY * rows as f64)).sqrt();
    Settled::of(&json!({
        "name": "taylor",
        "system": {"network": {
            "mesh": {"parachute": {
                "type": "flat-circular", "nominal_diameter": nominal_diameter, "gores": GORES, "radial_segments": rows,
                "lines": {"length": 2.0 * ratio}
            }},
            "mass": {"nodal": mass, "points": [{"on": {"group": "apex"}, "mass": 0.5 * n * mass}]},
            "springs": [
                {"on": {"group": "radials"}, "axial_rigidity": RIGIDITY},
                {"on": {"group": "lines"}, "axial_rigidity": RIGIDITY}
            ],
            "supports": [{"on": {"group": "confluence"}, "fix": "xyz"}],
            "loads": [{"on": {"group": "canopy"}, "pressure": PRESSURE}],
            "damping": {"rayleigh": {"mass": DAMPING}}
        }},
        "time": {"end": SETTLED, "method": "velocity-verlet", "step": step}
    }))
}

/// Its meridian from the apex to the skirt.
fn meridian(at: &Settled, rows: usize) -> Vec<[f64; 2]> {
    [at.rows(0, 1, 1), at.rows(1, GORES, rows)].concat()
}

/// The columns of the table but the first.
fn shape(at: &Settled, rows: usize) -> [f64; 5] {
    let meridian = meridian(at, rows);
    // Radials and lines are strained alike, so the ratio of their lengths stays.
    let (d0, dp) = (2.0 * length(&meridian), 2.0 * widest(&meridian));
    let ([_, top], [skirt, bottom]) = (meridian[0], meridian[rows]);
    let confluence = at.positions[1 + GORES * rows].z;
    // The flat face of the mouth closes the volume.
    let mouth = polygon(GORES) * PI * skirt * skirt;
    let volume = at.cones() - mouth * bottom / 3.0;
    [
        dp / d0,
        2.0 * skirt / d0,
        (top - bottom) / dp,
        skirt.atan2(bottom - confluence).to_degrees(),
        volume / polygon(GORES) / (0.5 * dp).powi(3),
    ]
}

/// [N] Sums of tensions: of the radials by row, and of the lines along the axis.
fn sums(at: &Settled, rows: usize) -> (Vec<f64>, f64) {
    let mut radials = vec![0.0; rows];
    for &edge in &at.mesh.groups["radials"].edges {
        let [a, b] = at.mesh.edges[edge as usize];
        radials[(a.max(b) as usize - 1) / GORES] += at.tensions[edge as usize];
    }
    let axial = |&edge: &u32| {
        let [from, to] = at.mesh.edges[edge as usize].map(|node| at.positions[node as usize]);
        at.tensions[edge as usize] * (to - from).normalize().z.abs()
    };
    (radials, at.mesh.groups["lines"].edges.iter().map(axial).sum())
}

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    let rows = 32;
    for expected in TABLE {
        let [ratio, ..] = expected;
        let at = settled(ratio, rows);
        claims.push(Claim::below(format!("L/D0 {ratio}: speed of the fastest node [m/s]"), at.fastest, 1e-6));
        for ((name, found), stated) in NAMES.iter().zip(shape(&at, rows)).zip(&expected[1..]) {
            claims.push(Claim::relative(format!("L/D0 {ratio}, {rows} rows: {name}"), found, *stated, 1e-3));
        }
        let circle = |radius: f64| PRESSURE * polygon(GORES) * PI * radius * radius;
        let (radials, axial) = sums(&at, rows);
        let load = circle(expected[1]);
        let worst = radials.iter().max_by(|a, b| (*a - load).abs().total_cmp(&(*b - load).abs()));
        let worst = worst.copied().unwrap_or(f64::NAN);
        claims.push(Claim::relative(format!("L/D0 {ratio}: tension of all radials [N], worst row"), worst, load, 2e-3));
        let drag = circle(expected[2]);
        claims.push(Claim::relative(
            format!("L/D0 {ratio}: tension of all lines along the axis [N]"),
            axial,
            drag,
            1e-3,
        ));
        let pull: Vector = at.reactions.iter().sum();
        claims.push(Claim::relative(format!("L/D0 {ratio}: pull on the confluence [N]"), -pull.z, drag, 1e-3));
    }
    claims.extend(orders());
    claims
}

/// Chords of a smooth meridian: errors fall as the square of their length.
fn orders() -> Vec<Claim> {
    let [_, stated @ ..] = TABLE[2];
    let errors = [8, 16, 32].map(|rows| {
        let found = shape(&settled(1.0, rows), rows);
        [0, 1, 2, 3, 4].map(|i| (found[i] - stated[i]).abs())
    });
    let pairs = [("8 to 16", 0), ("16 to 32", 1)];
    let order = |from: usize, i: usize| (errors[from][i] / errors[from + 1][i]).log2();
    let claim = |(rows, from): (&str, usize), i: usize| {
        Claim::between(format!("order of {} from {rows} rows", NAMES[i]), order(from, i), 1.9, 2.1)
    };
    pairs.into_iter().flat_map(|pair| (0..5).map(move |i| claim(pair, i))).collect()
}
