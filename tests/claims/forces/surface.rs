//! The air, pressures and given forces: on a flat square across the wind, where dp A is the whole force, and on an
//! inclined triangle with edges (1, 2, 2) and (2, 1, -2), of area 4.5 m^2 and normal N = (-2, 2, -1)/3, a third to each
//! vertex.

use super::{ROUNDING, agrees, forces};
use crate::claim::Claim;
use nalgebra::Vector3;
use serde_json::{Value, json};

/// [m^2]
const AREA: f64 = 4.5;

fn normal() -> Vector3<f64> {
    Vector3::new(-2.0, 2.0, -1.0) / 3.0
}

/// A law under its name, with dp/v and dp/(v |v|) by hand.
struct Law {
    name: &'static str,
    json: Value,
    linear: f64,
    quadratic: f64,
    /// [Pa] dp at 0.5 m/s and to how much of it
    check: (f64, f64),
}

impl Law {
    fn dp(&self, v: f64) -> f64 {
        self.linear * v + self.quadratic * v * v.abs()
    }
}

/// Ergun with eps 0.1, D 5e-5 m, e 1e-4 m: `power` of eps under the line, and v_s = `share` v_n.
fn ergun(form: &'static str, power: i32, share: f64, check: (f64, f64)) -> Law {
    let (porosity, pore, thickness, density, viscosity) = (0.1_f64, 5e-5_f64, 1e-4, 1.225, 1.81e-5);
    let solid = 1.0 - porosity;
    let below = porosity.powi(power);
    Law {
        name: form,
        json: json!({"ergun": {
            "porosity": porosity, "pore_diameter": pore, "thickness": thickness,
            "air_density": density, "air_viscosity": viscosity, "form": form
        }}),
        linear: thickness * 150.0 * viscosity * solid * solid / (pore * pore * below) * share,
        quadratic: thickness * 1.75 * density * solid / (pore * below) * share * share,
        check,
    }
}

fn laws() -> [Law; 4] {
    [
        // The check values are given to these digits.
        ergun("corrected", 3, 1.0, (44947.7, 0.05 / 44947.7)),
        ergun("paper", 2, 0.1, (440.79, 0.005 / 440.79)),
        Law {
            name: "permeable",
            json: json!({"permeable": {"a": 1.6e6, "b": 4.8e5, "thickness": 1e-4}}),
            linear: 160.0,
            quadratic: 48.0,
            check: (92.0, ROUNDING),
        },
        Law {
            name: "pressure coefficient",
            json: json!({"pressure_coefficient": {"cp": 1.2, "air_density": 1.225}}),
            linear: 0.0,
            quadratic: 0.735,
            check: (0.18375, ROUNDING),
        },
    ]
}

fn triangle(velocity: [Vector3<f64>; 3]) -> Value {
    json!({
        "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 2, 2], [2, 1, -2]], "springs": [], "triangles": [[0, 1, 2]]}},
        "springs": [],
        "initial": {"velocity": velocity.map(<[f64; 3]>::from)}
    })
}

fn air(claims: &mut Vec<Claim>) {
    for law in laws() {
        let Law { name, ref json, check: (dp, digits), .. } = law;
        let flat = json!({
            "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": 2, "rows": 2}},
            "springs": [], "aero": {"wind": [3.0, -2.0, 0.5], "law": json}
        });
        let total: Vector3<f64> = forces(flat, 1)[0].iter().sum();
        claims.push(Claim::relative(
            format!("air, {name}: 1 m^2 across 0.5 m/s, whole force [N] over 1 m^2"),
            total.z,
            dp,
            digits,
        ));
        // The vertices move apart, their mean with (0.5, -1, 0.5): v_n = N . (1 - 0.5, 1, -4 - 0.5) = 5.5/3.
        for side in [1.0, -1.0] {
            let own = [Vector3::new(1.5, -1.0, 0.5), Vector3::new(-0.5, -3.0, 0.5), Vector3::new(0.5, 1.0, 0.5)];
            let mut network = triangle(own.map(|v| side * v));
            network["aero"] = json!({"wind": [side, 0.0, -4.0 * side], "law": json});
            let found = forces(network, 1)[0].clone();
            let expected = law.dp(side * 5.5 / 3.0) * AREA / 3.0 * normal();
            let side = if side > 0.0 { "along" } else { "against" };
            for (vertex, found) in found.into_iter().enumerate() {
                claims.push(agrees(&format!("air, {name}: {side} the normal, vertex {vertex}"), found, expected));
            }
        }
    }
    // still for two steps, 0.5 m/s half way between the rows
    let gust = json!({
        "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": 2, "rows": 2}}, "springs": [],
        "aero": {"wind": {"table": [[0.125, 0, 0, 0], [0.375, 0, 0, 1]]},
                 "law": {"permeable": {"a": 1.6e6, "b": 4.8e5, "thickness": 1e-4}}}
    });
    for (step, (found, dp)) in forces(gust, 3).iter().zip([0.0, 0.0, 92.0]).enumerate() {
        let total = found.iter().sum();
        claims.push(agrees(&format!("wind by table, step {step}: whole force"), total, Vector3::new(0.0, 0.0, dp)));
    }
}

/// The triangle starts displaced, with edges (1, 2, 2) and (4, 2, -4); a step later they are (2, 4, 4) and (4, 2, -3).
fn pressures(claims: &mut Vec<Claim>) {
    let p = 5.0;
    let run = |load: Value| {
        let mut network = triangle([Vector3::zeros(), Vector3::new(8.0, 16.0, 16.0), Vector3::new(0.0, 0.0, 8.0)]);
        network["initial"]["displacement"] = json!([[0, 0, 0], [0, 0, 0], [2, 1, -2]]);
        network["loads"] = json!([load]);
        forces(network, 2)
    };
    let table = json!([[0.0, 1.0], [0.25, 5.0]]);
    // 1/2 of the products of the edges by hand, times p/3; the table's factors are 1 and 3
    let (start, later) = (p / 6.0 * Vector3::new(-12.0, 12.0, -6.0), p / 6.0 * Vector3::new(-20.0, 22.0, -12.0));
    let across: Vector3<f64> = p / 3.0 * 9.0 * Vector3::new(0.0, 0.6, 0.8);
    for (what, load, expected) in [
        ("follower pressure", json!({"on": "all", "pressure": p, "kind": "follower"}), [start, later]),
        (
            "follower pressure with a table",
            json!({"on": "all", "pressure": p, "kind": "follower", "table": table}),
            [start, 3.0 * later],
        ),
        ("dead pressure along the first normal", json!({"on": "all", "pressure": p, "kind": "dead"}), [start, start]),
        (
            "dead pressure along (0, 3, 4) with a table",
            json!({"on": "all", "pressure": p, "kind": "dead", "direction": [0, 3, 4], "table": table}),
            [across, 3.0 * across],
        ),
    ] {
        for (when, found, expected) in
            run(load).into_iter().zip(expected).zip(["at the start", "deformed"]).map(|((f, e), w)| (w, f, e))
        {
            let off = |a: &Vector3<f64>| (a - expected).norm();
            let worst = found.into_iter().max_by(|a, b| off(a).total_cmp(&off(b)));
            claims.push(agrees(
                &format!("{what}, {when}, worst vertex"),
                worst.unwrap_or(Vector3::repeat(f64::NAN)),
                expected,
            ));
        }
    }
}

fn nodal(claims: &mut Vec<Claim>) {
    let force = Vector3::new(1.0, -2.0, 2.0);
    let mut network = triangle([Vector3::zeros(); 3]);
    let table = json!([[0.25, 1], [0.5, -2], [0.75, 4]]);
    network["loads"] = json!([{"on": {"ids": [1]}, "force": force.as_slice(), "table": table}]);
    let found = forces(network, 8);
    // constant before the first row and after the last, linear between
    for (step, factor) in [1.0, 1.0, 1.0, -0.5, -2.0, 1.0, 4.0, 4.0].into_iter().enumerate() {
        let t = super::H * step as f64;
        claims.push(agrees(
            &format!("force on a node, factor {factor} of its table at {t} s"),
            found[step][1],
            factor * force,
        ));
        let others = found[step][0] + found[step][2];
        claims.push(agrees(&format!("force on a node, the others at {t} s"), others, Vector3::zeros()));
    }
}

/// k = E t A/l0^2 of the one triangle beside the edge, 100 * 0.5 * 4.5/9 = 25 N/m, pulled by 0.3 m.
fn membrane() -> Claim {
    let mut network = triangle([Vector3::zeros(); 3]);
    network["mesh"]["explicit"]["springs"] = json!([[0, 1]]);
    network["springs"] = json!([{"on": "all", "membrane": {"modulus": 100.0, "thickness": 0.5}}]);
    network["initial"]["displacement"] = json!([[0, 0, 0], [0.1, 0.2, 0.2], [0, 0, 0]]);
    let expected = -25.0 * Vector3::new(0.1, 0.2, 0.2);
    agrees("membrane, E t A/l0^2 e on a triangle's edge", forces(network, 1)[0][1], expected)
}

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    air(&mut claims);
    pressures(&mut claims);
    nodal(&mut claims);
    claims.push(membrane());
    claims
}
