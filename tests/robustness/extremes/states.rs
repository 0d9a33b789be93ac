//! Hostile shapes, loads, damping and numbers: more rows of the table.

use super::scenes::{chain, mote, net, patch, pendulum, sail};
use super::table::{END, GRAVITY, Hostile, K, Must, NODAL, STEP, WIND, hostile, steps};
use serde_json::Value;

const REST: &str = "system.network.springs.0.rest_scale";
const LENGTH: &str = "system.network.springs.0.rest_length";
const SLACK: &str = "system.network.springs.0.slack";
const DASHPOT: &str = "system.network.springs.0.dashpot";
const SUPPORTS: &str = "system.network.supports";
const DAMPING: &str = "system.network.damping";
const LOADS: &str = "system.network.loads";
const MOVED: &str = "system.network.initial.displacement";
const SPEED: &str = "system.network.initial.velocity";
const NODES: &str = "system.network.mesh.explicit.nodes";

pub fn geometry() -> Vec<Hostile> {
    vec![
        hostile("offset by 1e9 m", patch(1e9), Must::Complete, &[]),
        hostile("offset by 1e15 m, all digits gone", patch(1e15), Must::Refuse("rounded"), &[]),
        hostile("offset by 1e300 m", patch(1e300), Must::Refuse("length"), &[]),
        hostile(
            "a scene of 1e-12 m",
            patch(0.0),
            Must::End,
            &[(NODES, "[[0,0,0],[1e-12,0,0],[1e-12,1e-12,0],[0,1e-12,0]]")],
        ),
        hostile(
            "a scene of 1e12 m",
            patch(0.0),
            Must::End,
            &[(NODES, "[[0,0,0],[1e12,0,0],[1e12,1e12,0],[0,1e12,0]]")],
        ),
        hostile(
            "lengths whose squares overflow",
            chain(),
            Must::End,
            &[(NODES, "[[0,0,0],[1e200,0,0],[2e200,0,0],[3e200,0,0],[4e200,0,0]]")],
        ),
        hostile(
            "lengths whose squares vanish",
            chain(),
            Must::End,
            &[(NODES, "[[0,0,0],[1e-200,0,0],[2e-200,0,0],[3e-200,0,0],[4e-200,0,0]]")],
        ),
        hostile(
            "springs compressed to nothing",
            chain(),
            Must::End,
            &[(MOVED, "[[0,0,0],[-1,0,0],[-2,0,0],[-3,0,0],[-4,0,0]]")],
        ),
        hostile(
            "springs of length zero on the way",
            chain(),
            Must::End,
            &[(SPEED, "[[0,0,0],[-1e3,0,0],[0,0,0],[0,0,0],[0,0,0]]")],
        ),
        hostile("a spring inside out", chain(), Must::End, &[(MOVED, "[[0,0,0],[-2,0,0],[0,0,0],[0,0,0],[0,0,0]]")]),
        hostile("rest length 1e12 times the length", chain(), Must::End, &[(REST, "1e12")]),
        hostile("rest length 1e-12 times the length", chain(), Must::End, &[(REST, "1e-12")]),
        hostile("rest length 1e300 m", chain(), Must::Refuse("/system/network/springs"), &[(LENGTH, "1e300")]),
        hostile(
            "collinear triangles",
            patch(0.0),
            Must::Refuse("triangle"),
            &[(NODES, "[[0,0,0],[1,0,0],[2,0,0],[3,0,0]]")],
        ),
        hostile(
            "triangles moved onto a line",
            sail_patch(),
            Must::End,
            &[(MOVED, "[[0,0,0],[0,0,0],[0,-1,0],[2,-1,0]]")],
        ),
        hostile(
            "triangles moved onto a point",
            sail_patch(),
            Must::End,
            &[(MOVED, "[[0,0,0],[-1,0,0],[-1,-1,0],[0,-1,0]]")],
        ),
        hostile("a triangle turned over", sail_patch(), Must::End, &[(MOVED, "[[0,0,0],[0,0,0],[0,0,0],[2,-2,0]]")]),
    ]
}

/// The patch in wind.
fn sail_patch() -> Value {
    let mut scene = patch(0.0);
    scene["system"]["network"]["aero"] = sail()["system"]["network"]["aero"].clone();
    scene["system"]["network"]["initial"] = serde_json::json!({});
    scene
}

pub fn slack() -> Vec<Hostile> {
    let tension = r#""tension-only""#;
    let mut all = vec![
        hostile("a slack net", net(), Must::Complete, &[(SLACK, tension), (REST, "2")]),
        hostile(
            "a slack net without gravity",
            net(),
            Must::Complete,
            &[(SLACK, tension), (REST, "2"), (GRAVITY, "[0,0,0]")],
        ),
        hostile("a slack sail", sail(), Must::Complete, &[(SLACK, tension), (REST, "1.1")]),
        hostile("a dead zone wider than the springs", net(), Must::Complete, &[(SLACK, r#"{"dead_zone": 1e6}"#)]),
        hostile("no support", net(), Must::Complete, &[(SUPPORTS, "[]")]),
        hostile("no support, sail", sail(), Must::Complete, &[(SUPPORTS, "[]")]),
        hostile("no support, no load", net(), Must::Complete, &[(SUPPORTS, "[]"), (GRAVITY, "[0, 0, 0]")]),
        hostile("one node", mote(), Must::End, &[]),
        hostile("one node, no load", mote(), Must::Complete, &[(GRAVITY, "[0, 0, 0]")]),
    ];
    for (name, h) in [("slack", 1.0), ("slack", 1e6)] {
        let [step, end] = steps(h);
        let sets = [(SLACK, tension), (REST, "2"), (step.0, step.1.as_str()), (end.0, &end.1)];
        all.push(hostile(&format!("a {name} net in steps of {h:e} s"), net(), Must::End, &sets));
    }
    all
}

pub fn loads() -> Vec<Hostile> {
    let pressure = |p: &str, kind: &str| format!(r#"[{{"on": "all", "pressure": {p}, "kind": "{kind}"}}]"#);
    let mut all = Vec::new();
    for p in ["1e6", "1e12", "1e100", "1e200", "1e308"] {
        let load = pressure(p, "follower");
        all.push(hostile(&format!("pressure {p} Pa"), net(), Must::End, &[(LOADS, &load)]));
        let load = format!(r#"[{{"on": {{"ids": [7]}}, "force": [0, 0, {p}]}}]"#);
        all.push(hostile(&format!("force {p} N"), net(), Must::End, &[(LOADS, &load)]));
        all.push(hostile(&format!("gravity {p} m/s^2"), net(), Must::End, &[(GRAVITY, &format!("[0, 0, -{p}]"))]));
        all.push(hostile(
            &format!("speed {p} m/s"),
            chain(),
            Must::End,
            &[(SPEED, &format!("[[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,{p}]]"))],
        ));
        all.push(hostile(
            &format!("moved by {p} m"),
            chain(),
            Must::End,
            &[(MOVED, &format!("[[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,{p}]]"))],
        ));
        all.push(hostile(&format!("a mote at {p} m/s"), mote(), Must::End, &[(SPEED, &format!("[0, 0, {p}]"))]));
    }
    all
}

pub fn damping() -> Vec<Hostile> {
    let mut all = Vec::new();
    for c in ["1e-12", "1e6", "1e15", "1e100", "1e300"] {
        for kind in ["axial", "relative"] {
            let dashpot = format!(r#"{{"{kind}": {{"coefficient": {c}}}}}"#);
            all.push(hostile(&format!("{kind} dashpot {c} N s/m"), patch(0.0), Must::End, &[(DASHPOT, &dashpot)]));
        }
        for share in ["mass", "stiffness"] {
            let rayleigh = format!(r#"{{"rayleigh": {{"{share}": {c}}}}}"#);
            all.push(hostile(&format!("Rayleigh {share} {c}"), patch(0.0), Must::End, &[(DAMPING, &rayleigh)]));
        }
    }
    all
}

pub fn denormals() -> Vec<Hostile> {
    vec![
        hostile("a denormal stiffness", net(), Must::Refuse("stiffness"), &[(K, "5e-324")]),
        hostile("a denormal mass", chain(), Must::Refuse("mass"), &[(NODAL, "5e-324")]),
        hostile("a denormal rest length", chain(), Must::Refuse("length"), &[(LENGTH, "5e-324")]),
        hostile("a denormal step", net(), Must::Refuse("/time/end"), &[(STEP, "5e-324"), (END, "1e-322")]),
        hostile("a denormal gravity", net(), Must::Complete, &[(GRAVITY, "[0, 0, 5e-324]")]),
        hostile("a denormal wind", sail(), Must::Complete, &[(WIND, "[0, 0, 5e-324]")]),
        hostile(
            "a denormal speed",
            chain(),
            Must::Complete,
            &[(SPEED, "[[0,0,0],[0,0,5e-324],[0,0,0],[0,0,0],[0,0,0]]")],
        ),
        hostile(
            "a denormal displacement",
            chain(),
            Must::Complete,
            &[(MOVED, "[[0,0,0],[0,0,5e-324],[0,0,0],[0,0,0],[0,0,0]]")],
        ),
        hostile(
            "a denormal pressure",
            net(),
            Must::Complete,
            &[(LOADS, r#"[{"on": "all", "pressure": 5e-324, "kind": "follower"}]"#)],
        ),
        hostile("a denormal time constant", patch(0.0), Must::Complete, &[(DASHPOT, r#"{"axial": {"time": 5e-324}}"#)]),
        hostile("the smallest normal stiffness", net(), Must::Complete, &[(K, "2.3e-308")]),
        hostile("the smallest normal mass", chain(), Must::End, &[(NODAL, "2.3e-308")]),
    ]
}

pub fn pendulums() -> Vec<Hostile> {
    let one = |key: &str, value: &str, must: Must| {
        let at = format!("system.pendulum.{key}");
        hostile(&format!("a pendulum with {key} {value}"), pendulum(), must, &[(&at, value)])
    };
    let mut all = vec![
        one("rate", "1e200", Must::Refuse("pendulum")),
        one("length", "1e-200", Must::Refuse("pendulum")),
        one("rate", "1e12", Must::End),
        one("damping", "1e15", Must::End),
        one("gravity", "1e15", Must::End),
        one("gravity", "1e300", Must::End),
        one("length", "1e-12", Must::End),
        one("length", "1e12", Must::End),
        one("mass", "1e-12", Must::End),
        one("mass", "1e200", Must::End),
        one("angle", "1e15", Must::End),
    ];
    for h in [1e-100, 1e-15, 1.0, 1e6, 1e100] {
        let [step, end] = steps(h);
        let sets = [(step.0, step.1.as_str()), (end.0, &end.1)];
        all.push(hostile(&format!("a pendulum in steps of {h:e} s"), pendulum(), Must::End, &sets));
    }
    all
}
