//! Random small scenes of sensible magnitudes: w h between 0.01 and 0.5, a few steps.

use proptest::prelude::*;
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// A scene in units of the case: everything that a change of units, place or numbering touches.
#[derive(Clone, Debug)]
pub struct Net {
    /// [m]
    pub nodes: Vec<[f64; 3]>,
    /// every edge of the triangles once, and others
    pub springs: Vec<[usize; 2]>,
    pub triangles: Vec<[usize; 3]>,
    /// [kg] one a node
    pub masses: Vec<f64>,
    /// [m/s] one a node
    pub velocity: Vec<[f64; 3]>,
    /// nodes that are held
    pub held: Vec<usize>,
    /// [N/m]
    pub stiffness: f64,
    /// [N s/m] of the dashpot `kind`: 0 none, 1 axial, 2 relative
    pub dashpot: f64,
    pub kind: u8,
    pub tension_only: bool,
    /// [-]
    pub rest_scale: f64,
    /// [m/s^2]
    pub gravity: [f64; 3],
    /// [m/s], with air if `air`
    pub wind: [f64; 3],
    pub air: bool,
    /// [kg/m^3]
    pub air_density: f64,
    /// [N/m^2] follower pressure; none if 0
    pub pressure: f64,
    /// [1/s] and [s]
    pub rayleigh: [f64; 2],
    /// [s]
    pub step: f64,
    pub steps: u32,
}

impl Net {
    /// The case file.
    pub fn case(&self) -> Value {
        let dashpot = json!({ if self.kind == 1 { "axial" } else { "relative" }: {"coefficient": self.dashpot} });
        let mut rule = json!({"on": "all", "stiffness": self.stiffness, "rest_scale": self.rest_scale});
        if self.kind > 0 {
            rule["dashpot"] = dashpot;
        }
        if self.tension_only {
            rule["slack"] = json!("tension-only");
        }
        let mut network = json!({
            "mesh": {"explicit": {"nodes": self.nodes, "springs": self.springs, "triangles": self.triangles}},
            "mass": {"nodal": self.masses},
            "springs": [rule],
            "supports": [{"on": {"ids": self.held}, "fix": "xyz"}],
            "gravity": self.gravity,
            "initial": {"velocity": self.velocity},
            "damping": {"rayleigh": {"mass": self.rayleigh[0], "stiffness": self.rayleigh[1]}}
        });
        if self.air {
            let law = json!({"pressure_coefficient": {"cp": 1.2, "air_density": self.air_density}});
            network["aero"] = json!({"wind": self.wind, "law": law});
        }
        if self.pressure != 0.0 {
            network["loads"] = json!([{"on": "all", "pressure": self.pressure, "kind": "follower"}]);
        }
        json!({
            "name": "net",
            "system": {"network": network},
            "time": {"end": self.step * f64::from(self.steps), "method": "newmark", "step": self.step},
            // Two numberings differ by what Newton leaves.
            "solver": {"newton": {"relative": 1e-12}}
        })
    }
}

/// Sheets of 2 x 2 to 4 x 5 nodes with uneven places, held at a corner and perhaps elsewhere, and a tail of springs.
pub fn net() -> impl Strategy<Value = Net> {
    (2_usize..=4, 2_usize..=5, 0_usize..=3, any::<u64>()).prop_flat_map(|(rows, columns, tail, picks)| {
        let n = rows * columns + tail;
        let vector = |size: f64| prop::array::uniform3(-size..size);
        let shape = (prop::collection::vec(vector(0.2), n), prop::collection::vec(vector(1.0), n));
        let masses = prop::collection::vec(0.5..2.0, n);
        let springs = (10.0..1000.0_f64, 0.0..0.05_f64, 0_u8..3, any::<bool>(), 0.8..1.1_f64);
        let outside = (vector(10.0), vector(5.0), any::<bool>(), prop_oneof![Just(0.0), -2.0..2.0_f64]);
        let time = (0.01..0.3_f64, 1_u32..8, 0.0..0.5_f64, 0.0..0.05_f64);
        (shape, masses, springs, outside, time).prop_map(
            move |((jitter, velocity), masses, springs, (gravity, wind, air, pressure), time)| {
                let (stiffness, ratio, kind, tension_only, rest_scale) = springs;
                let (wh, steps, alpha, beta) = time;
                // A node in the middle of a sheet has about eight springs.
                let frequency = (8.0 * stiffness / 0.5_f64).sqrt();
                let (nodes, triangles, springs) = sheet([rows, columns], tail, &jitter);
                let held: Vec<usize> = (0..n).filter(|i| *i == 0 || picks >> (i % 64) & 7 == 7 && i + 1 < n).collect();
                let mut velocity = velocity;
                held.iter().for_each(|&i| velocity[i] = [0.0; 3]);
                Net {
                    nodes,
                    springs,
                    triangles,
                    masses,
                    velocity,
                    held,
                    stiffness,
                    dashpot: ratio * stiffness / frequency,
                    kind,
                    tension_only,
                    rest_scale,
                    gravity,
                    wind,
                    air,
                    air_density: 1.25,
                    pressure,
                    rayleigh: [alpha * frequency * 0.1, beta / frequency],
                    step: wh / frequency,
                    steps,
                }
            },
        )
    })
}

type Sheet = (Vec<[f64; 3]>, Vec<[usize; 3]>, Vec<[usize; 2]>);

/// Two triangles a cell, and `tail` more nodes in a row on a spring each.
fn sheet([rows, columns]: [usize; 2], tail: usize, jitter: &[[f64; 3]]) -> Sheet {
    let number = |r: usize, c: usize| r * columns + c;
    let on_grid = (0..rows * columns).map(|i| [(i % columns) as f64, (i / columns) as f64, 0.0]);
    let hanging = (1..=tail).map(|i| [-(i as f64), -0.5, -0.5 * i as f64]);
    let nodes = on_grid.chain(hanging).zip(jitter).map(|(p, j)| std::array::from_fn(|c| p[c] + j[c])).collect();
    let cells = (0..rows - 1).flat_map(|r| (0..columns - 1).map(move |c| (r, c)));
    let triangles: Vec<[usize; 3]> = cells
        .flat_map(|(r, c)| {
            let [a, b, d, e] = [number(r, c), number(r, c + 1), number(r + 1, c), number(r + 1, c + 1)];
            [[a, b, e], [a, e, d]]
        })
        .collect();
    let sides = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).map(|[a, b]| [a.min(b), a.max(b)]);
    let sides: BTreeSet<[usize; 2]> = sides.collect();
    let first = rows * columns;
    let hung = (0..tail).map(|i| [if i == 0 { 0 } else { first + i - 1 }, first + i]);
    let springs = sides.into_iter().chain(hung).collect();
    (nodes, triangles, springs)
}
