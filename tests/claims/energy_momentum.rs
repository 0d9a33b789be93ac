//! What the energy-momentum method keeps at any step, on scenes where the schemes that are stable on linear scenes make
//! energy: a stiff pendulum that turns, nets that fall and go slack, free bodies of every law. Energy, momentum and
//! angular momentum are those of the program's states; what is left of them is what Newton's iteration leaves.

use crate::claim::Claim;
use crate::common::run::{case_of, changed, follow};
use canopy_fem::case::Case;
use canopy_fem::drive::{Outcome, Status};
use nalgebra::Vector3;
use serde_json::{Value, json};

const METHOD: &str = r#""energy-momentum""#;
/// Stable on linear scenes.
const OTHERS: [&str; 3] = [r#""newmark""#, r#""hht""#, r#""generalized-alpha""#];
const STEPS: usize = 1000;

/// How far a run strayed.
struct Track {
    outcome: Outcome,
    steps: usize,
    /// [-] worst change of kinetic, elastic and potential energy less the work of loads, over the largest kinetic one
    energy: f64,
    /// [-] most energy gained in a step, over the same
    gained: f64,
    /// [-] share of the energy that is gone at the end
    lost: f64,
    /// [-] worst change of momentum and angular momentum over their first values
    linear: f64,
    angular: f64,
    /// [-] largest stretch of the way: the scene is nonlinear
    moved: f64,
}

fn track(case: &Case, mass: &[f64], method: &str) -> Track {
    let mut energies = Vec::new();
    let (mut first, mut largest) = (None, 0.0_f64);
    let [mut linear, mut angular, mut moved] = [0.0_f64; 3];
    let mut start: Option<Vec<[f64; 3]>> = None;
    let outcome = follow(&changed(case, &[("time.method", method)]), |seen| {
        let l = &seen.ledger;
        energies.push(l.kinetic + l.elastic + l.gravity - l.external_work);
        largest = largest.max(l.kinetic);
        let nodes = seen.positions.iter().zip(seen.velocities).zip(mass);
        let p: Vector3<f64> = nodes.clone().map(|((_, v), m)| *m * Vector3::from(*v)).sum();
        let turning = |((x, v), m): ((&[f64; 3], &[f64; 3]), &f64)| *m * Vector3::from(*x).cross(&Vector3::from(*v));
        let l: Vector3<f64> = nodes.map(turning).sum();
        let [p0, l0] = *first.get_or_insert([p, l]);
        linear = linear.max((p - p0).norm() / p0.norm());
        angular = angular.max((l - l0).norm() / l0.norm());
        let start = start.get_or_insert_with(|| seen.positions.to_vec());
        let way = start.iter().zip(seen.positions).map(|(a, b)| (Vector3::from(*a) - Vector3::from(*b)).norm());
        moved = way.fold(moved, f64::max);
    });
    let e0 = energies[0];
    let over = |of: f64| of / largest;
    Track {
        outcome,
        steps: energies.len() - 1,
        energy: over(energies.iter().fold(0.0, |most, e| most.max((e - e0).abs()))),
        gained: over(energies.windows(2).fold(0.0, |most, e| most.max(e[1] - e[0]))),
        lost: over(e0 - energies[energies.len() - 1]),
        linear,
        angular,
        moved,
    }
}

fn timed(network: &Value, step: f64) -> Case {
    let end = (STEPS as f64 + 0.5) * step;
    let case = json!({
        "name": "kept",
        "system": {"network": network},
        "time": {"end": end, "method": "newmark", "step": step},
        "solver": {"newton": {"relative": 1e-12}}
    });
    case_of(&case, &[])
}

/// Claims what the method keeps in all steps.
fn kept(name: &str, track: &Track, energy: f64, claims: &mut Vec<Claim>) {
    let why = format!("{:?}", track.outcome.failure.as_ref().map(|failure| &failure.cause));
    claims.push(Claim::is(format!("{name}: all steps are made ({why})"), track.steps > STEPS));
    claims.push(Claim::below(format!("{name}: worst change of energy in {STEPS} steps"), track.energy, energy));
}

/// At least one of the others makes so much energy on the same scene in the same steps that the program stops it.
fn others_fail(name: &str, case: &Case, mass: &[f64], claims: &mut Vec<Claim>) {
    for other in OTHERS {
        let track = track(case, mass, other);
        let (status, at) = (track.outcome.status, track.steps);
        claims.push(Claim::is(format!("{name}: {other} diverges, here after {at} steps"), status == Status::Diverged));
    }
}

/// The pendulum of [`crate::elastic_pendulum`], nearly rigid: w h = 181 along the spring.
fn pendulum(claims: &mut Vec<Claim>) {
    let (mass, radius) = (10.0, 3.0443);
    let network = json!({
        "mesh": {"explicit": {"nodes": [[0, 0, 0], [radius, 0, 0]], "springs": [[0, 1]]}},
        "mass": {"nodal": [0.0, mass]},
        "springs": [{"on": "all", "axial_rigidity": 1e10}],
        "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
        "initial": {"velocity": [[0, 0, 0], [0, 7.72, 0]]}
    });
    let (case, masses) = (timed(&network, 0.01), [0.0, mass]);
    let found = track(&case, &masses, METHOD);
    // Positions are rounded to 4e-16 m, which the spring turns into 1e-6 N: some 1e-13 of the energy a step.
    kept("stiff pendulum", &found, 1e-9, claims);
    claims.push(Claim::below("stiff pendulum: worst change of angular momentum", found.angular, 1e-10));
    let newmark = track(&case, &masses, OTHERS[0]);
    claims.push(Claim::is("stiff pendulum: newmark diverges", newmark.outcome.status == Status::Diverged));
}

/// Cloth of springs that cannot push falls from a level start about two corners: w h = 100 for the fastest.
fn slack_net(claims: &mut Vec<Claim>) {
    let network = json!({
        "mesh": {"rectangle": {"columns": 6, "rows": 6, "width": 1.0, "height": 1.0}},
        "mass": {"areal_density": 0.05},
        "springs": [{"on": "all", "stiffness": 1e5, "slack": "tension-only"}],
        "supports": [{"on": {"ids": [0, 6]}, "fix": "xyz"}],
        "gravity": [0, 0, -9.81]
    });
    let case = timed(&network, 2e-3);
    kept("slack net", &track(&case, &[], METHOD), 1e-9, claims);
    others_fail("slack net", &case, &[], claims);
}

/// A sheet that wrinkles does the same, and an airbag opens from flat without damping (a quarter of its upper sheet,
/// that of the guide with half as many cells).
fn wrinkled(claims: &mut Vec<Claim>) {
    let sheet = json!({
        "mesh": {"rectangle": {"columns": 6, "rows": 6, "width": 1.0, "height": 1.0}},
        "mass": {"areal_density": 0.05},
        "membranes": [{"on": "all", "modulus": 6e8, "thickness": 6e-5, "poisson": 0.3, "wrinkling": true}],
        "supports": [{"on": {"ids": [0, 6]}, "fix": "xyz"}],
        "gravity": [0, 0, -9.81]
    });
    let airbag = json!({
        "mesh": {"rectangle": {"width": 0.42, "height": 0.42, "columns": 8, "rows": 8}},
        "mass": {"areal_density": 0.6},
        "membranes": [{"on": "all", "thickness": 6e-4, "modulus": 588e6, "poisson": 0.4, "wrinkling": true}],
        "supports": [
            {"on": {"box": [[0, 0, 0], [0, 0.42, 0]]}, "fix": "x"},
            {"on": {"box": [[0, 0, 0], [0.42, 0, 0]]}, "fix": "y"},
            {"on": {"box": [[0.42, 0, 0], [0.42, 0.42, 0]]}, "fix": "z"},
            {"on": {"box": [[0, 0.42, 0], [0.42, 0.42, 0]]}, "fix": "z"}
        ],
        "loads": [{"on": "all", "pressure": 5000.0}]
    });
    for (name, network) in [("falling sheet", sheet), ("airbag", airbag)] {
        let case = timed(&network, 1e-3);
        kept(name, &track(&case, &[], METHOD), 1e-8, claims);
        others_fail(name, &case, &[], claims);
    }
}

/// [kg]
const FREE: f64 = 0.3;

/// A net of twelve triangles without anything that holds it, thrown and turning, with waves of its own.
fn free(parts: &Value) -> (Value, Vec<f64>) {
    let (columns, rows) = (2, 3);
    let mut velocity = Vec::new();
    for i in 0..(columns + 1) * (rows + 1) {
        let s = f64::from(i);
        let wave = |of: f64| (of * s + 1.0).sin();
        velocity.push([2.0 + wave(1.7), 1.0 + 2.0 * wave(2.3), 3.0 * wave(0.9) + 0.5 * s - 2.0]);
    }
    let mut network = json!({
        "mesh": {"rectangle": {"columns": columns, "rows": rows, "width": 1.0, "height": 1.4}},
        "mass": {"nodal": FREE},
        "initial": {"velocity": velocity}
    });
    for (key, value) in parts.as_object().into_iter().flatten() {
        network[key] = value.clone();
    }
    (network, vec![FREE; velocity.len()])
}

/// Scenes of one law each, in steps that jump over their fastest motions.
fn bodies() -> Vec<(&'static str, Value)> {
    let springs = |more: Value| {
        let mut rule = json!({"on": "all", "axial_rigidity": 4e4});
        for (key, value) in more.as_object().into_iter().flatten() {
            rule[key] = value.clone();
        }
        json!({"springs": [rule]})
    };
    let sheet = |wrinkling: bool| {
        json!({"membranes": [{
            "on": "all", "thickness": 1e-4, "modulus": [4e8, 2e8], "poisson": 0.3, "shear": 8e7, "warp": [1, 0.4, 0],
            "wrinkling": wrinkling
        }]})
    };
    let mut bent = sheet(false);
    bent["bending"] = json!([{"on": "all", "stiffness": 0.3}]);
    vec![
        ("springs", springs(json!({}))),
        ("tension-only springs", springs(json!({"slack": "tension-only"}))),
        ("springs with a dead zone", springs(json!({"slack": {"dead_zone": 0.01}}))),
        ("springs with a limit", springs(json!({"slack": {"compression_limit": 0.002}}))),
        ("springs that push only", springs(json!({"slack": "compression-only"}))),
        ("green bars", springs(json!({"law": "green"}))),
        (
            "tabled bars",
            json!({"springs": [{
                "on": "all", "law": {"table": [[-0.1, -2000], [-0.01, -400], [0, 0], [0.01, 100], [0.1, 6000]]}
            }]}),
        ),
        ("sheet with bending", bent),
        ("sheet that wrinkles", sheet(true)),
    ]
}

fn free_bodies(claims: &mut Vec<Claim>) {
    for (name, parts) in bodies() {
        let (network, mass) = free(&parts);
        let case = timed(&network, 5e-3);
        let found = track(&case, &mass, METHOD);
        kept(&format!("free {name}"), &found, 1e-9, claims);
        claims.push(Claim::below(format!("free {name}: worst change of momentum"), found.linear, 1e-12));
        claims.push(Claim::below(format!("free {name}: worst change of angular momentum"), found.angular, 1e-11));
        claims.push(Claim::is(format!("free {name}: flies and turns"), found.moved > 1.0));
        let damped = track(&case, &mass, r#"{"energy-momentum": {"dissipation": 0.2}}"#);
        claims.push(Claim::is(format!("free {name}, dissipation 0.2: all steps are made"), damped.steps > STEPS));
        claims.push(Claim::below(format!("free {name}, dissipation 0.2: most gained in a step"), damped.gained, 1e-11));
        claims.push(Claim::between(format!("free {name}, dissipation 0.2: share lost"), damped.lost, 1e-3, 1.0));
        claims.push(Claim::below(format!("free {name}, dissipation 0.2: momentum"), damped.linear, 1e-12));
        claims.push(Claim::below(format!("free {name}, dissipation 0.2: angular momentum"), damped.angular, 1e-11));
    }
}

/// Damping takes energy in every step, however long.
fn damped(claims: &mut Vec<Claim>) {
    let (mut network, mass) = free(&bodies().swap_remove(1).1);
    network["springs"][0]["dashpot"] = json!({"axial": {"time": 0.01}});
    network["damping"] = json!({"rayleigh": {"stiffness": 1e-3}});
    let case = timed(&network, 5e-3);
    let found = track(&case, &mass, METHOD);
    claims.push(Claim::is("damped net: all steps are made", found.steps > STEPS));
    claims.push(Claim::below("damped net: most energy gained in a step", found.gained, 1e-11));
    claims.push(Claim::between("damped net: share lost", found.lost, 1e-2, 1.0));
}

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    for part in [pendulum, slack_net, wrinkled, free_bodies, damped] {
        part(&mut claims);
    }
    claims
}
