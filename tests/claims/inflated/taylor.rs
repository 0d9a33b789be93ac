//! Taylor's parachute (G. I. Taylor, "On the shapes of parachutes", 1919): sin(phi) = (r/R)^2 up to the skirt, where
//! the meridian meets the lines. Its D0 is twice the length of a radial. That of the area of n flat gores is smaller,
//! by 0.4 % for 28 gores: with it, the same shape seems wider.

use super::{DAMPING, PRESSURE, RIGIDITY, SETTLED, Settled, Vector, length, polygon, widest};
use crate::claim::Claim;
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};

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

/// A parachute of radials 1 m long, flat at the start.
#[derive(Clone, Copy)]
pub(super) struct Canopy {
    pub gores: usize,
    /// nodes along a radial, without the apex
    pub rows: usize,
    /// [-] L/D0
    pub ratio: f64,
    /// whether all edges of the cloth are bars that go slack; else only its radials are bars
    pub cloth: bool,
}

impl Canopy {
    pub fn case(self) -> Value {
        let Canopy { gores, rows, ratio, cloth } = self;
        let n = gores as f64;
        // S0 = n sin(2 pi/n)/2 for radials of 1 m
        let nominal_diameter = (2.0 * n * (TAU / n).sin() / PI).sqrt();
        // The parachute has the same mass for all meshes, and is heavier at the apex, where all radials pull.
        let mass = 12.0 / n * 0.16 / rows as f64;
        let rigidity = 12.0 / n * RIGIDITY;
        let bars = |group: &str| json!({"on": {"group": group}, "axial_rigidity": rigidity, "slack": "tension-only"});
        // Edges across the gores are short at the apex. Bars that go slack bear only 0.6 of the step that others do.
        let shortest = if cloth { 0.2 / rows as f64 } else { 1.0 / rows as f64 };
        json!({
            "name": "taylor",
            "system": {"network": {
                "mesh": {"parachute": {
                    "type": "flat-circular", "nominal_diameter": nominal_diameter, "gores": gores,
                    "radial_segments": rows, "lines": {"length": 2.0 * ratio}
                }},
                "mass": {"nodal": mass, "points": [{"on": {"group": "apex"}, "mass": 0.5 * n * mass}]},
                "springs": [bars(if cloth { "cloth" } else { "radials" }), bars("lines")],
                "supports": [{"on": {"group": "confluence"}, "fix": "xyz"}],
                "loads": [{"on": {"group": "canopy"}, "pressure": PRESSURE}],
                "damping": {"rayleigh": {"mass": DAMPING}}
            }},
            "time": {
                "end": SETTLED, "method": "velocity-verlet", "step": 0.5 * (mass * shortest / rigidity).sqrt()
            }
        })
    }

    fn settled(self) -> Settled {
        Settled::of(&self.case())
    }

    /// Its meridian from the apex to the skirt.
    pub fn meridian(self, at: &Settled) -> Vec<[f64; 2]> {
        [at.rows(0, 1, 1), at.rows(1, self.gores, self.rows)].concat()
    }

    /// The columns of the table but the first.
    fn shape(self, at: &Settled) -> [f64; 5] {
        let Canopy { gores, rows, .. } = self;
        let meridian = self.meridian(at);
        // Radials and lines are strained alike, so the ratio of their lengths stays.
        let (d0, dp) = (2.0 * length(&meridian), 2.0 * widest(&meridian));
        let ([_, top], [skirt, bottom]) = (meridian[0], meridian[rows]);
        let confluence = at.positions[1 + gores * rows].z;
        // The flat face of the mouth closes the volume.
        let mouth = polygon(gores) * PI * skirt * skirt;
        let volume = at.cones() - mouth * bottom / 3.0;
        [
            dp / d0,
            2.0 * skirt / d0,
            (top - bottom) / dp,
            skirt.atan2(bottom - confluence).to_degrees(),
            volume / polygon(gores) / (0.5 * dp).powi(3),
        ]
    }

    /// [N] Sums of tensions: of the radials by row, and of the lines along the axis.
    pub fn sums(self, at: &Settled) -> (Vec<f64>, f64) {
        let Canopy { gores, rows, .. } = self;
        let mut radials = vec![0.0; rows];
        for &edge in &at.mesh.groups["radials"].edges {
            let [a, b] = at.mesh.edges[edge as usize];
            radials[(a.max(b) as usize - 1) / gores] += at.tensions[edge as usize];
        }
        let axial = |&edge: &u32| {
            let [from, to] = at.mesh.edges[edge as usize].map(|node| at.positions[node as usize]);
            at.tensions[edge as usize] * (to - from).normalize().z.abs()
        };
        (radials, at.mesh.groups["lines"].edges.iter().map(axial).sum())
    }
}

/// [N] p pi r^2 through the polygon of the gores
pub(super) fn load(gores: usize, radius: f64) -> f64 {
    PRESSURE * polygon(gores) * PI * radius * radius
}

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    let fine = Canopy { gores: 12, rows: 32, ratio: 1.0, cloth: false };
    for expected in TABLE {
        let [ratio, ..] = expected;
        let canopy = Canopy { ratio, ..fine };
        let at = canopy.settled();
        claims.push(Claim::below(format!("L/D0 {ratio}: speed of the fastest node [m/s]"), at.fastest, 1e-5));
        for ((name, found), stated) in NAMES.iter().zip(canopy.shape(&at)).zip(&expected[1..]) {
            claims.push(Claim::relative(format!("L/D0 {ratio}: {name}"), found, *stated, 1e-3));
        }
        let [whole, drag] = [expected[1], expected[2]].map(|radius| load(canopy.gores, radius));
        let (radials, axial) = canopy.sums(&at);
        let worst = radials.iter().max_by(|a, b| (*a - whole).abs().total_cmp(&(*b - whole).abs()));
        let worst = worst.copied().unwrap_or(f64::NAN);
        let pull: Vector = at.reactions.iter().sum();
        claims.push(Claim::relative(
            format!("L/D0 {ratio}: tension of all radials [N], worst row"),
            worst,
            whole,
            2e-3,
        ));
        claims.push(Claim::relative(
            format!("L/D0 {ratio}: tension of all lines along the axis [N]"),
            axial,
            drag,
            1e-3,
        ));
        claims.push(Claim::relative(format!("L/D0 {ratio}: pull on the confluence [N]"), -pull.z, drag, 1e-3));
    }
    claims.extend(orders(fine));
    claims.extend(others(Canopy { rows: 16, ..fine }));
    claims
}

/// Without time: Newton's iteration from the flat canopy, whose tangent is singular. The mesh is that of the runs; bars
/// are strained by 2e-4.
pub fn static_claims() -> Vec<Claim> {
    let fine = Canopy { gores: 12, rows: 32, ratio: 1.0, cloth: false };
    let mut claims = Vec::new();
    for expected in [TABLE[0], TABLE[2], TABLE[5]] {
        let [ratio, stated @ ..] = expected;
        let canopy = Canopy { ratio, ..fine };
        let at = Settled::found(&canopy.case());
        for ((name, found), stated) in NAMES.iter().zip(canopy.shape(&at)).zip(stated) {
            claims.push(Claim::relative(format!("L/D0 {ratio}: {name}"), found, stated, 1e-3));
        }
        let pull: Vector = at.reactions.iter().sum();
        let drag = load(canopy.gores, expected[2]);
        claims.push(Claim::relative(format!("L/D0 {ratio}: pull on the confluence [N]"), -pull.z, drag, 1e-3));
    }
    let cloth = Canopy { gores: 28, rows: 16, cloth: true, ..fine };
    let at = Settled::found(&cloth.case());
    for ((name, found), stated) in NAMES.iter().zip(cloth.shape(&at)).zip(&TABLE[2][1..]) {
        claims.push(Claim::relative(format!("28 gores of stiff cloth: {name}"), found, *stated, 3e-3));
    }
    claims
}

/// Chords of a smooth meridian: errors fall as the square of their length.
fn orders(fine: Canopy) -> Vec<Claim> {
    let [_, stated @ ..] = TABLE[2];
    let errors = [8, 16, 32].map(|rows| {
        let canopy = Canopy { rows, ..fine };
        let found = canopy.shape(&canopy.settled());
        [0, 1, 2, 3, 4].map(|i| (found[i] - stated[i]).abs())
    });
    let pairs = [("8 to 16", 0), ("16 to 32", 1)];
    let order = |from: usize, i: usize| (errors[from][i] / errors[from + 1][i]).log2();
    let claim = |(rows, from): (&str, usize), i: usize| {
        Claim::between(format!("order of {} from {rows} rows", NAMES[i]), order(from, i), 1.9, 2.1)
    };
    pairs.into_iter().flat_map(|pair| (0..5).map(move |i| claim(pair, i))).collect()
}

/// Any number of gores takes the same shape, up to the size of the triangles. So does cloth that is stiff along all its
/// edges, as it is slack across the gores; but around the apex, where it is as wide as the shape, stretched radials
/// pull it taut.
fn others(canopy: Canopy) -> Vec<Claim> {
    let shape = canopy.shape(&canopy.settled());
    let mut claims = Vec::new();
    for (what, other, tolerance) in [
        ("5 gores", Canopy { gores: 5, ..canopy }, 5e-4),
        ("28 gores", Canopy { gores: 28, ..canopy }, 1e-4),
        ("stiff cloth", Canopy { cloth: true, ..canopy }, 1e-3),
    ] {
        let at = other.settled();
        for ((name, found), same) in NAMES.iter().zip(other.shape(&at)).zip(shape) {
            claims.push(Claim::relative(
                format!("{what}: {name} as with 12 gores of radials alone"),
                found,
                same,
                tolerance,
            ));
        }
        let [.., drag] = [TABLE[2][1], TABLE[2][2]].map(|radius| load(other.gores, radius));
        let (_, axial) = other.sums(&at);
        claims.push(Claim::relative(format!("{what}: tension of all lines along the axis [N]"), axial, drag, 2e-3));
    }
    claims
}
