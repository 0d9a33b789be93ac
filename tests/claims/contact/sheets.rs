//! Sheets: momentum between two that meet, no crossing, and the bits of runs.

use super::ground;
use crate::claim::Claim;
use crate::common::run::{Run, case_of, follow, run, run_with};
use canopy_fem::mesh::crossing::CrossingFinder;
use serde_json::{Value, json};

/// [m/s] of each of two sheets that meet
const SPEED: f64 = 0.5;
/// Cells along a side
const CELLS: u32 = 6;
const METHODS: [&str; 6] = ["newmark", "hht", "backward-euler", "velocity-verlet", "improved-euler", "rk4"];

/// Nodes and triangles of two square sheets of 0.3 m, one 30 mm above the other and turned by a little.
fn two_sheets() -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let (mut nodes, mut triangles) = (Vec::new(), Vec::new());
    for sheet in 0..2_u32 {
        let (sin, cos) = (0.2 * f64::from(sheet)).sin_cos();
        let first = sheet * (CELLS + 1).pow(2);
        for i in 0..(CELLS + 1).pow(2) {
            let [x, y] = [i % (CELLS + 1), i / (CELLS + 1)].map(|i| 0.3 * (f64::from(i) / f64::from(CELLS) - 0.5));
            nodes.push([x * cos - y * sin + 0.01 * f64::from(sheet), x * sin + y * cos, 0.03 * f64::from(sheet)]);
        }
        for i in 0..CELLS.pow(2) {
            let a = first + i / CELLS * (CELLS + 1) + i % CELLS;
            let [b, c, d] = [a + 1, a + CELLS + 2, a + CELLS + 1];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    (nodes, triangles)
}

/// Equations are solved to 1e-11: their residual is in the sum of momenta.
fn meeting(method: &str, step: f64) -> Value {
    let (nodes, triangles) = two_sheets();
    let half = nodes.len() / 2;
    let velocity: Vec<[f64; 3]> = (0..nodes.len()).map(|i| [0.0, 0.0, if i < half { SPEED } else { -SPEED }]).collect();
    json!({
        "name": "meeting",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": nodes, "triangles": triangles}},
            "mass": {"nodal": 0.01},
            "springs": [{"on": "all", "stiffness": 500.0}],
            "contact": [{"between": "self", "gap": 0.005, "friction": 0.3}],
            "initial": {"velocity": velocity}
        }},
        "solver": {"linear": "cholesky", "newton": {"relative": 1e-10}},
        "time": {"end": 0.06, "method": method, "step": step}
    })
}

/// Sum of momenta over the momentum of one sheet, the worst of all steps; how much of it they gave each other; and the
/// number of crossings at the ends of steps.
fn meet(method: &str, step: f64) -> (f64, f64, usize) {
    let (nodes, triangles) = two_sheets();
    let half = nodes.len() / 2;
    let mut finder = CrossingFinder::new(&triangles).expect("two sheets can meet");
    let (mut worst, mut given, mut crossings) = (0.0_f64, 0.0, 0);
    let own = SPEED * half as f64;
    let outcome = follow(&case_of(&meeting(method, step), &[]), |seen| {
        let sum = |c: usize, of: &[[f64; 3]]| of.iter().map(|v| v[c]).sum::<f64>();
        (0..3).for_each(|c| worst = worst.max((sum(c, seen.velocities) / own).abs()));
        given = 1.0 - sum(2, &seen.velocities[..half]) / own;
        crossings += finder.find(seen.positions).len();
    });
    assert!(outcome.failure.is_none(), "{method}: {outcome:?}");
    (worst, given, crossings)
}

pub fn meetings() -> Vec<Claim> {
    let mut claims = Vec::new();
    for method in METHODS {
        let implicit = ["newmark", "hht", "backward-euler"].contains(&method);
        let (worst, given, crossings) = meet(method, if implicit { 2.5e-4 } else { 5e-4 });
        claims.push(Claim::below(format!("{method}: two sheets meet head-on, sum of momenta [-]"), worst, 1e-13));
        claims.push(Claim::between(
            format!("{method}: and they have turned back, momentum given [-]"),
            given,
            1.0,
            2.1,
        ));
        claims.push(Claim::is(format!("{method}: without a crossing"), crossings == 0));
    }
    claims
}

/// A sheet that swings on two corners, with contact that it never reaches or without.
fn swinging(method: &str, contact: Value) -> Run {
    let case = json!({
        "name": "swinging",
        "system": {"network": {
            "mesh": {"rectangle": {"width": 0.6, "height": 0.6, "columns": 6, "rows": 6}},
            "mass": {"areal_density": 0.2},
            "springs": [{"on": "all", "stiffness": 300.0}],
            "supports": [{"on": {"ids": [0, 6]}, "fix": "xyz"}],
            "gravity": [0, 0, -9.81],
            "contact": contact
        }},
        "time": {"end": 0.1, "method": method, "step": 5e-4}
    });
    run(&case_of(&case, &[]))
}

/// Contact that nothing reaches changes no bit of a run.
pub fn bits() -> Vec<Claim> {
    let mut claims = Vec::new();
    let far = json!([
        {"between": ["all", {"plane": {"point": [0, 0, -9], "normal": [0, 0, 1]}}], "gap": 0.01, "friction": 0.3},
        {"between": ["all", {"sphere": {"center": [9, 0, 0], "radius": 1}}], "gap": 0.01, "friction": 0.3},
        {"between": "self", "gap": 0.002, "friction": 0.3}
    ]);
    for method in METHODS {
        let [with, without] = [far.clone(), json!([])].map(|contact| swinging(method, contact));
        let same = with.positions == without.positions && with.velocities == without.velocities;
        claims.push(Claim::is(format!("{method}: contact that nothing reaches changes no bit"), same));
    }
    claims
}

/// Row of nodes at which a sheet is folded
const FOLD: i32 = 42;
/// [m]
const GAP: f64 = 0.003;

/// A sheet of 2,209 nodes on the ground, one side of it folded over: the same bits on 1 and 2 threads.
pub fn threads() -> Vec<Claim> {
    let displacement: Vec<[f64; 3]> = (0..47_i32 * 47)
        .map(|i| {
            let row = i / 47;
            let back = if row > FOLD { -0.02 * f64::from(row - FOLD) } else { 0.0 };
            [0.0, back, 0.97 * GAP * (1.0 + 0.5 * f64::from(1 + (row - FOLD).signum()))]
        })
        .collect();
    let mut claims = Vec::new();
    for method in ["backward-euler", "velocity-verlet"] {
        let case = json!({
            "name": "threads",
            "system": {"network": {
                "mesh": {"rectangle": {"width": 0.46, "height": 0.46, "columns": 46, "rows": 46}},
                "mass": {"areal_density": 0.2},
                "springs": [{"on": "all", "stiffness": 300.0}],
                "gravity": [0, 0, -9.81],
                "contact": [
                    {"between": ["all", ground()], "gap": GAP, "friction": 0.3},
                    {"between": "self", "gap": 0.5 * GAP, "friction": 0.3}
                ],
                "initial": {"displacement": displacement}
            }},
            "time": {"end": 1e-4, "method": method, "step": 1e-4}
        });
        let case = case_of(&case, &[("time.step", if method == "backward-euler" { "1e-4" } else { "2e-5" })]);
        let [one, two] = [1, 2].map(|threads| run_with(&case, threads));
        let same = one.positions == two.positions && one.velocities == two.velocities;
        claims.push(Claim::is(format!("{method}: a sheet on the ground, the same bits on 1 and 2 threads"), same));
    }
    claims
}
