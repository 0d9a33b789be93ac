//! The steps that contact leaves to explicit methods.
//! ```text
//! a mass in a gap that is closed by 60 % or more:   w^2 = b''(0.4) kappa/m,   b''(0.4) = 10.08;   Verlet: w h = 2
//! ```

use super::{G, ground};
use crate::claim::Claim;
use crate::common::run::{case_of, follow_on};
use canopy_fem::analysis::contact::{limiting, surveys};
use canopy_fem::analysis::critical::ElementBounds;
use canopy_fem::analysis::spectrum::Spectrum;
use canopy_fem::integrate::registry::MethodChoice;
use canopy_fem::simulation::build_scene;
use serde_json::{Value, json};

/// [m]
const GAP: f64 = 1e-3;
/// [-] Share of the gap at which a load holds the mass, and how far it sways
const SHARE: f64 = 0.2;
const SWAY: f64 = 0.02;
/// [-] Largest slope over kappa
const MOST: f64 = 10.082_581_463_748_308;

/// A mass that a load presses far into the gap of a plane, where explicit contact is a linear spring.
fn pressed(method: &str, step: f64, steps: u32) -> Value {
    // At s = 0.4 the force is 1.9995 kappa g0, and it goes on with the slope there; kappa g0 = m g.
    let left = 0.6_f64;
    let at_limit = left * left / 0.4 - 2.0 * left * 0.4_f64.ln();
    let load = 2.0 * G * (at_limit + MOST * (0.4 - SHARE) - 1.0);
    json!({
        "name": "pressed",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0.0, 0.0, (SHARE + SWAY) * GAP]]}},
            "mass": {"nodal": [2.0]},
            "gravity": [0.0, 0.0, -G],
            "loads": [{"on": "all", "force": [0.0, 0.0, -load]}],
            "contact": [{"between": ["all", ground()], "gap": GAP}]
        }},
        "time": {"end": f64::from(steps) * step, "method": method, "step": step}
    })
}

/// [s] The step that contact allows, by the bound that `check` prints.
fn allowed(case: &Value, method: &str) -> f64 {
    let scene = build_scene(case_of(case, &[]).problem().system.clone(), 1).expect("the case is good");
    let method = MethodChoice::with_defaults(method).expect("a method");
    let rates = surveys(&*scene).into_iter().map(|contact| contact.rate);
    limiting(&method, rates).map_or(f64::INFINITY, |(_, step)| step)
}

/// [-] How far the mass sways at most upwards and downwards, over the gap; it begins above its place of rest.
fn sway(method: &str, step: f64, steps: u32) -> [f64; 2] {
    let mut most = [0.0_f64; 2];
    let _ = follow_on(&case_of(&pressed(method, step, steps), &[]), |seen| {
        let up = seen.positions[0][2] / GAP - SHARE;
        most = [most[0].max(up), most[1].max(-up)];
    });
    most
}

/// Two square nets, the second one above the first by a share of the gap and moved by a part of a cell.
fn nets(shift: [f64; 2], gap: f64, between: &Value) -> Value {
    let (side, cell) = (7_u32, 0.05);
    let (mut nodes, mut triangles) = (Vec::new(), Vec::new());
    for sheet in 0..2_u32 {
        let first = sheet * side * side;
        let [dx, dy] = shift.map(|share| share * cell * f64::from(sheet));
        for i in 0..side * side {
            let [x, y] = [i % side, i / side].map(|i| cell * f64::from(i));
            nodes.push([x + dx, y + dy, SHARE * gap * f64::from(sheet)]);
        }
        for i in (0..side * side).filter(|i| i % side + 1 < side && i / side + 1 < side) {
            let [a, b, c, d] = [i, i + 1, i + side + 1, i + side].map(|i| first + i);
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let half = triangles.len() / 2;
    let groups = json!({
        "lower": {"triangles": (0..half).collect::<Vec<_>>()},
        "upper": {"triangles": (half..2 * half).collect::<Vec<_>>()}
    });
    json!({
        "name": "nets",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": nodes, "triangles": triangles, "groups": groups}},
            "mass": {"nodal": 0.01},
            "springs": [{"on": "all", "stiffness": 500.0}],
            "contact": [{"between": between, "gap": gap}]
        }},
        "time": {"end": 0.01, "method": "velocity-verlet", "step": 1e-4}
    })
}

/// [-] Critical steps of Verlet with the gaps closed by 80 %: of the scene over that without contact, and what bounds
/// say over it: from the elements, contact among them, and for the pairs that share a node.
fn with_contact(case: &Value) -> [f64; 3] {
    let verlet = MethodChoice::with_defaults("velocity-verlet").expect("a method");
    let critical = |case: &Value| {
        let scene = build_scene(case_of(case, &[]).problem().system.clone(), 1).expect("the case is good");
        scene.touches().into_iter().for_each(|touches| touches.set_explicit(true));
        let state = scene.initial_state();
        let found = Spectrum::of(&*scene, state.as_ref()).critical_step(&verlet).step;
        let by_elements = ElementBounds::of(&*scene, state.as_ref()).critical_step(&verlet).step;
        let contact = surveys(&*scene).first().copied().unwrap_or_default();
        (found, by_elements, contact.rate * contact.at_one_node as f64)
    };
    let mut without = case.clone();
    without["system"]["network"].as_object_mut().expect("an object").remove("contact");
    let ((with, by_elements, rate), (without, ..)) = (critical(case), critical(&without));
    // Of Verlet, 4/h^2 of both parts add up.
    let by_pairs = 2.0 / (4.0 / (without * without) + rate).sqrt();
    [with / without, by_elements / with, by_pairs / with]
}

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    for (method, wh) in [("velocity-verlet", 2.0), ("rk4", 2.8284)] {
        let step = allowed(&pressed(method, 1e-4, 1), method);
        let right = wh / (MOST * G / GAP).sqrt();
        claims.push(Claim::relative(format!("{method}: step that a plane allows a mass [s]"), step, right, 1e-4));
        let what = format!("{method}: 2 % below it a pressed mass sways on, over its sway at the start [-]");
        let [up, down] = sway(method, 0.98 * step, 2000);
        claims.push(Claim::between(what, up.max(down) / SWAY, 0.999, 1.001));
        claims.push(Claim::between(format!("{method}: and it sways to both sides [-]"), down / SWAY, 0.3, 1.001));
        let what = format!("{method}: 2 % above it the sway grows within 60 steps [-]");
        claims.push(Claim::between(
            what,
            sway(method, 1.02 * step, 60).into_iter().fold(0.0, f64::max) / SWAY,
            5.0,
            f64::INFINITY,
        ));
    }
    let plane = json!({"plane": {"point": [0, 0, -SHARE * 0.01], "normal": [0, 0, 1]}});
    let [ratio, ..] = with_contact(&nets([0.0; 2], 0.01, &json!(["lower", plane])));
    claims.push(Claim::relative(
        "net pressed on a plane: critical step over that without contact [-]",
        ratio,
        1.0,
        1e-6,
    ));
    // Ten pairs and more share a node there.
    for shift in [[0.0, 0.0], [0.5, 0.5], [0.33, 0.17], [0.03, 0.02]] {
        let [ratio, by_elements, by_pairs] = with_contact(&nets(shift, 0.01, &json!(["lower", "upper"])));
        let what =
            format!("nets pressed on each other, moved by {shift:?} of a cell: critical step over that without [-]");
        claims.push(Claim::between(what, ratio, 0.15, 0.4));
        claims.push(Claim::between("and what the elements prove over it [-]", by_elements, 0.3, 1.0 + 1e-6));
        claims.push(Claim::below("and the bound for the pairs near a node over it [-]", by_pairs, 1.0));
    }
    claims
}
