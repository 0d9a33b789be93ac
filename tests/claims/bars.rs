//! Bars that are not linear, against closed forms: the bar of finite strain, T = EA lambda (lambda^2 - 1)/2 with lambda
//! = l/l0; a bar by a table of strain and force; one that only pushes.

use crate::claim::Claim;
use crate::common::run::{at_rest, case_of, follow};
use serde_json::{Value, json};

/// [N], [m]
const EA: f64 = 40.0;
const L0: f64 = 1.3;

fn case(network: Value) -> Value {
    json!({
        "name": "bar",
        "system": {"network": network},
        "time": {"end": 1.0, "method": "newmark", "step": 0.01},
        "solver": {"newton": {"relative": 1e-14}}
    })
}

/// [-] Stretch of one bar under a force along it.
fn stretch(rule: Value, force: f64) -> f64 {
    let mut rule = rule;
    rule["on"] = json!("all");
    let rest = at_rest(&case_of(
        &case(json!({
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [L0, 0, 0]], "springs": [[0, 1]]}},
            "mass": {"nodal": 1.0},
            "springs": [rule],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}, {"on": {"ids": [1]}, "fix": "yz"}],
            "loads": [{"on": {"ids": [1]}, "force": [force, 0, 0]}]
        })),
        &[],
    ));
    rest.positions[1][0] / L0
}

/// lambda^3 - lambda = 2 T/EA, by Cardano's formula and, where there are three roots, the cosine's.
fn cubic(force: f64) -> f64 {
    let half = force / EA;
    let discriminant = half * half - 1.0 / 27.0;
    if discriminant >= 0.0 {
        let root = discriminant.sqrt();
        return (half + root).cbrt() + (half - root).cbrt();
    }
    2.0 / 3f64.sqrt() * ((half * 27f64.sqrt()).acos() / 3.0).cos()
}

fn green(claims: &mut Vec<Claim>) {
    // Down to two thirds of the load at which it snaps through, EA/sqrt 27.
    for force in [-5.0, 0.5, 7.0, 40.0, 400.0] {
        let found = stretch(json!({"axial_rigidity": EA, "law": "green"}), force);
        claims.push(Claim::relative(format!("green bar under {force} N: stretch"), found, cubic(force), 1e-12));
    }
    let linear = stretch(json!({"axial_rigidity": EA}), 7.0);
    claims.push(Claim::relative("linear bar under 7 N: stretch", linear, 1.0 + 7.0 / EA, 1e-12));
    let n = 20;
    let (h, weight) = (L0 / n as f64, EA);
    let nodes: Vec<[f64; 3]> = (0..=n).map(|i| [0.0, 0.0, -h * i as f64]).collect();
    let springs: Vec<[usize; 2]> = (0..n).map(|i| [i, i + 1]).collect();
    let rest = at_rest(&case_of(
        &case(json!({
            "mesh": {"explicit": {"nodes": nodes, "springs": springs}},
            "springs": [{"on": "all", "axial_rigidity": EA, "law": "green", "linear_density": weight / 10.0 / L0}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
            "gravity": [0, 0, -10.0]
        })),
        &[],
    ));
    // Every bar carries the weight below its middle.
    let length: f64 = (0..n).map(|i| h * cubic(weight * (n as f64 - i as f64 - 0.5) / n as f64)).sum();
    claims.push(Claim::relative("hanging green bar, weight EA: length [m]", -rest.positions[n][2], length, 1e-12));
}

const ROWS: [[f64; 2]; 5] = [[-0.3, -12.0], [-0.1, -8.0], [0.0, 0.0], [0.05, 1.0], [0.2, 19.0]];

fn table(claims: &mut Vec<Claim>) {
    // Between all rows, at one, and beyond both ends.
    for (force, strain) in
        [(-14.0, -0.4), (-10.0, -0.2), (-2.0, -0.025), (0.5, 0.025), (1.0, 0.05), (10.0, 0.125), (31.0, 0.3)]
    {
        let found = stretch(json!({"law": {"table": ROWS}}), force) - 1.0;
        claims.push(Claim::absolute(format!("bar by a table under {force} N: strain"), found, strain, 1e-12));
    }
}

/// A mass thrown against a strut that only pushes: it flies, is stopped over half a period of sin, flies back.
fn strut(claims: &mut Vec<Claim>) {
    let pressed = stretch(json!({"axial_rigidity": EA, "slack": "compression-only"}), -6.0);
    claims.push(Claim::relative("strut that only pushes, under -6 N: stretch", pressed, 1.0 - 6.0 / EA, 1e-12));
    let (gap, speed, mass) = (0.1, 1.0, 0.5);
    let contact = std::f64::consts::PI * (mass * L0 / EA).sqrt();
    let end = 2.0 * gap / speed + contact;
    let mut thrown = case(json!({
        "mesh": {"explicit": {"nodes": [[0, 0, 0], [L0, 0, 0]], "springs": [[0, 1]]}},
        "mass": {"nodal": mass},
        "springs": [{"on": "all", "axial_rigidity": EA, "slack": "compression-only"}],
        "supports": [{"on": {"ids": [0]}, "fix": "xyz"}, {"on": {"ids": [1]}, "fix": "yz"}],
        "initial": {"displacement": [[0, 0, 0], [gap, 0, 0]], "velocity": [[0, 0, 0], [-speed, 0, 0]]}
    }));
    thrown["time"] = json!({"end": end, "method": "velocity-verlet", "step": end / 4096.0});
    let (mut nearest, mut last) = (f64::MAX, [0.0; 2]);
    follow(&case_of(&thrown, &[]), |seen| {
        nearest = nearest.min(seen.positions[1][0]);
        last = [seen.positions[1][0], seen.velocities[1][0]];
    });
    let depth = speed * (mass * L0 / EA).sqrt();
    claims.push(Claim::relative("mass thrown at the strut: greatest shortening [m]", L0 - nearest, depth, 1e-5));
    claims.push(Claim::relative("mass thrown at the strut: speed when it is back [m/s]", last[1], speed, 1e-5));
    claims.push(Claim::relative("mass thrown at the strut: place then [m]", last[0], L0 + gap, 1e-5));
}

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    green(&mut claims);
    table(&mut claims);
    strut(&mut claims);
    claims
}
