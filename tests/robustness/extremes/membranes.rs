//! Hostile membranes, bars that are not linear, and bending: more rows of the table.

use super::scenes::{chain, net, patch};
use super::table::{Hostile, Must, hostile, steps};
use serde_json::{Value, json};

const MOVED: &str = "system.network.initial.displacement";
const SPEED: &str = "system.network.initial.velocity";
const NODES: &str = "system.network.mesh.explicit.nodes";
const MODULUS: &str = "system.network.membranes.0.modulus";
const TIME: &str = "system.network.membranes.0.damping_time";
const STEP: &str = "time.step";
const END: &str = "time.end";

/// A scene with a membrane in place of its springs.
fn sheet(mut scene: Value, wrinkling: bool) -> Value {
    let network = scene["system"]["network"].as_object_mut().expect("a network");
    network.remove("springs");
    let rule = json!({"on": "all", "thickness": 1e-3, "modulus": 1e5, "poisson": 0.3, "wrinkling": wrinkling});
    network.insert("membranes".to_owned(), json!([rule]));
    scene
}

/// The same of woven cloth, damped.
fn cloth(scene: Value) -> Value {
    let mut scene = sheet(scene, true);
    let rule = json!({
        "on": "all", "thickness": 1e-3, "modulus": [1e5, 2e4], "poisson": 0.2, "shear": 1e3, "warp": [1, 1, 0],
        "wrinkling": true, "damping_time": 1e-3
    });
    scene["system"]["network"]["membranes"] = json!([rule]);
    scene
}

pub fn membranes() -> Vec<Hostile> {
    let mut all = Vec::new();
    for (name, of) in [
        ("membrane", (|scene| sheet(scene, false)) as fn(Value) -> Value),
        ("membrane that wrinkles", |scene| sheet(scene, true)),
        ("woven cloth", cloth),
    ] {
        let mut add = |what: &str, scene: Value, must: Must, sets: &[(&str, &str)]| {
            all.push(hostile(&format!("{name}, {what}"), of(scene), must, sets));
        };
        add("as it is", net(), Must::Complete, &[]);
        for (what, moved) in [
            ("triangles moved onto a line", "[[0,0,0],[0,0,0],[0,-1,0],[2,-1,0]]"),
            ("triangles moved onto a point", "[[0,0,0],[-1,0,0],[-1,-1,0],[0,-1,0]]"),
            ("a triangle turned over", "[[0,0,0],[0,0,0],[0,0,0],[2,-2,0]]"),
            ("stretched 1e3 times", "[[0,0,0],[999,0,0],[999,999,0],[0,999,0]]"),
            ("stretched 1e8 times", "[[0,0,0],[1e8,0,0],[1e8,1e8,0],[0,1e8,0]]"),
            ("pressed to a thousandth", "[[0,0,0],[-0.999,0,0],[-0.999,-0.999,0],[0,-0.999,0]]"),
            ("drawn along and pressed across", "[[0,0,0],[9,0,0],[9,-0.999,0],[0,-0.999,0]]"),
        ] {
            add(what, patch(0.0), Must::End, &[(MOVED, moved)]);
        }
        for speed in ["1e3", "1e8", "1e100"] {
            let sets = [(SPEED, format!("[[0,0,0],[-{speed},0,0],[0,0,{speed}],[0,0,0]]"))];
            add(&format!("thrown at {speed} m/s"), patch(0.0), Must::End, &[(sets[0].0, &sets[0].1)]);
        }
        for nodes in ["1e-9", "1e9"] {
            let nodes = format!("[[0,0,0],[{nodes},0,0],[{nodes},{nodes},0],[0,{nodes},0]]");
            add(&format!("nodes {nodes}"), patch(0.0), Must::End, &[(NODES, &nodes)]);
        }
        for h in [1e-100, 1e-9, 1.0, 1e6] {
            let [step, end] = steps(h);
            let must = if h < 1e-3 { Must::Complete } else { Must::End };
            add(&format!("in steps of {h:e} s"), net(), must, &[(STEP, &step.1), (END, &end.1)]);
        }
    }
    for modulus in ["1e-12", "1e9", "1e15", "1e100", "1e300"] {
        for wrinkling in [false, true] {
            let what = format!("membrane of E {modulus} Pa, wrinkling: {wrinkling}");
            all.push(hostile(&what, sheet(net(), wrinkling), Must::End, &[(MODULUS, modulus)]));
        }
    }
    for time in ["1e-12", "1", "1e12", "1e300"] {
        let what = format!("cloth with a damping time of {time} s");
        all.push(hostile(&what, cloth(net()), Must::End, &[(TIME, time)]));
    }
    all
}

pub fn bars() -> Vec<Hostile> {
    let mut all = Vec::new();
    let rows = r#"{"table": [[-0.5, -20], [0, 0], [0.1, 1], [0.2, 1], [0.3, 1e4]]}"#;
    for (name, rule) in [
        ("green bars", json!({"on": "all", "axial_rigidity": 100.0, "law": "green"})),
        (
            "green bars without compression",
            json!({
                "on": "all", "axial_rigidity": 100.0, "law": "green", "slack": "tension-only"
            }),
        ),
        ("bars by a table", json!({"on": "all", "law": serde_json::from_str::<Value>(rows).expect("JSON")})),
        ("springs that only push", json!({"on": "all", "axial_rigidity": 100.0, "slack": "compression-only"})),
    ] {
        let mut scene = chain();
        scene["system"]["network"]["springs"] = json!([rule]);
        for (what, moved) in [
            ("as they are", "[0,0,0]"),
            ("pressed to nothing", "[[0,0,0],[-1,0,0],[-2,0,0],[-3,0,0],[-4,0,0]]"),
            (
                "pressed to where they snap",
                "[[0,0,0],[-0.42264973,0,0],[-0.84529946,0,0],[-1.2679492,0,0],[-1.6905989,0,0]]",
            ),
            ("inside out", "[[0,0,0],[-2,0,0],[0,0,0],[0,0,0],[0,0,0]]"),
            ("stretched 1e3 times", "[[0,0,0],[999,0,0],[1998,0,0],[2997,0,0],[3996,0,0]]"),
            ("stretched 1e60 times", "[[0,0,0],[1e60,0,0],[2e60,0,0],[3e60,0,0],[4e60,0,0]]"),
        ] {
            all.push(hostile(&format!("{name}, {what}"), scene.clone(), Must::End, &[(MOVED, moved)]));
        }
        for h in [1e-9, 1.0, 1e6] {
            let [step, end] = steps(h);
            let sets = [(STEP, step.1.as_str()), (END, end.1.as_str())];
            all.push(hostile(&format!("{name} in steps of {h:e} s"), scene.clone(), Must::End, &sets));
        }
    }
    all
}

pub fn bending() -> Vec<Hostile> {
    let mut all = Vec::new();
    for stiffness in ["1e-12", "1", "1e6", "1e15", "1e300"] {
        let mut line = chain();
        line["system"]["network"]["bending"] = json!([{"on": "all", "flexural_rigidity": 1.0}]);
        let key = "system.network.bending.0.flexural_rigidity";
        all.push(hostile(&format!("a line of EI {stiffness} N m^2"), line, Must::End, &[(key, stiffness)]));
        let mut stiff = sheet(net(), true);
        stiff["system"]["network"]["bending"] = json!([{"on": "all", "stiffness": 1.0}]);
        let key = "system.network.bending.0.stiffness";
        all.push(hostile(
            &format!("cloth of bending stiffness {stiffness} N m"),
            stiff,
            Must::End,
            &[(key, stiffness)],
        ));
    }
    all
}
