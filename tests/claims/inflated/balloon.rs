//! The Mylar balloon: two flat discs of radius a, joined at their rims, inflated. Its meridian is sin(phi) = (r/R)^2 up
//! to the equator (W. H. Paulsen, "What is the shape of a Mylar balloon?", American Mathematical Monthly 101, 1994).

use super::{DAMPING, PRESSURE, RIGIDITY, SETTLED, Settled, length, polygon, widest};
use crate::claim::Claim;
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};

const RADIALS: usize = 12;
/// [-] R/a, thickness over diameter, Vol/R^3
const BALLOON: [f64; 3] = [0.762_759_763_5, 0.599_070_117_4, 2.745_812_249_9];

/// Nodes: the upper apex, the rows of the upper disc to the rim, those of the lower disc to its apex.
fn case(rows: usize) -> Value {
    let all = 2 * rows - 1;
    let node = |row: usize, radial: usize| match row {
        0 => 0,
        row if row > all => 1 + all * RADIALS,
        row => 1 + (row - 1) * RADIALS + radial % RADIALS,
    };
    let mut nodes = vec![[0.0; 3]];
    for row in 1..=all {
        let r = row.min(2 * rows - row) as f64 / rows as f64;
        nodes.extend((0..RADIALS).map(|radial| {
            let angle = TAU * radial as f64 / RADIALS as f64;
            [r * angle.cos(), r * angle.sin(), 0.0]
        }));
    }
    nodes.push([0.0; 3]);
    let (mut springs, mut triangles) = (Vec::new(), Vec::new());
    for radial in 0..RADIALS {
        for row in 0..=all {
            let [a, b] = [node(row, radial), node(row, radial + 1)];
            let [c, d] = [node(row + 1, radial), node(row + 1, radial + 1)];
            springs.push([a, c]);
            triangles.extend([[a, c, d], [a, d, b]].into_iter().filter(|[a, b, c]| a != b && b != c && c != a));
        }
    }
    let mass = 0.16 / rows as f64;
    let mut masses = vec![mass; nodes.len()];
    for apex in [0, nodes.len() - 1] {
        masses[apex] = 0.5 * RADIALS as f64 * mass;
    }
    let step = 0.9 * (mass / (RIGIDITY * rows as f64)).sqrt();
    json!({
        "name": "balloon",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": nodes, "springs": springs, "triangles": triangles}},
            "mass": {"nodal": masses},
            "springs": [{"on": "all", "axial_rigidity": RIGIDITY}],
            "loads": [{"on": "all", "pressure": PRESSURE}],
            "damping": {"rayleigh": {"mass": DAMPING}}
        }},
        "time": {"end": SETTLED, "method": "velocity-verlet", "step": step}
    })
}

/// Radius over that of the discs, thickness over diameter, Vol/R^3; the mean tension of a radial [N].
fn settled(rows: usize) -> ([f64; 3], f64, Settled) {
    let at = Settled::of(&case(rows));
    let last = at.positions.len() - 1;
    let meridian = [at.rows(0, 1, 1), at.rows(1, RADIALS, 2 * rows - 1), at.rows(last, 1, 1)].concat();
    let radius = widest(&meridian);
    let thickness = at.positions[0].z - at.positions[last].z;
    let tension = at.tensions.iter().sum::<f64>() / at.tensions.len() as f64;
    let volume = at.cones() / polygon(RADIALS) / radius.powi(3);
    ([radius / (0.5 * length(&meridian)), thickness / (2.0 * radius), volume], tension, at)
}

pub fn claims() -> Vec<Claim> {
    let names = ["radius over that of the discs", "thickness over diameter", "Vol/R^3"];
    let all = [8, 16, 32].map(settled);
    let mut claims = Vec::new();
    let (found, tension, at) = &all[2];
    claims.push(Claim::below("speed of the fastest node [m/s]", at.fastest, 1e-6));
    for i in 0..3 {
        claims.push(Claim::relative(format!("32 rows: {}", names[i]), found[i], BALLOON[i], 1e-3));
        for (rows, pair) in [("8 to 16", 0), ("16 to 32", 1)] {
            let off = |which: usize| (all[which].0[i] - BALLOON[i]).abs();
            let order = (off(pair) / off(pair + 1)).log2();
            claims.push(Claim::between(format!("order of {} from {rows} rows", names[i]), order, 1.9, 2.1));
        }
    }
    let load = PRESSURE * polygon(RADIALS) * PI * BALLOON[0] * BALLOON[0];
    claims.push(Claim::relative("tension of all radials [N]", RADIALS as f64 * tension, load, 2e-3));
    claims
}
