//! Small scenes that the table spoils.

use serde_json::{Value, json};

fn timed(name: &str, network: Value) -> Value {
    json!({
        "name": name,
        "system": {"network": network},
        "time": {"end": 0.02, "method": "newmark", "step": 0.001}
    })
}

/// A hanging net: 25 nodes, 56 springs, its upper edge held; w h is about 0.2.
pub fn net() -> Value {
    timed(
        "net",
        json!({
            "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": 4, "rows": 4, "pattern": "regular"}},
            "mass": {"areal_density": 0.5},
            "springs": [{"on": "all", "stiffness": 100.0}],
            "supports": [{"on": {"box": [[-9, 0.99, -9], [9, 9, 9]]}, "fix": "xyz"}],
            "gravity": [0, 0, -9.81]
        }),
    )
}

/// The same net held at its boundary, in wind.
pub fn sail() -> Value {
    let mut sail = net();
    let network = &mut sail["system"]["network"];
    network["supports"] = json!([{"on": "boundary", "fix": "xyz"}]);
    network["aero"] = json!({
        "wind": [0, 0, 10.0],
        "law": {"pressure_coefficient": {"cp": 1.2, "air_density": 1.225}}
    });
    sail
}

/// A net pinned at a corner only, without gravity: six springs, two triangles, all by hand, its first node at `origin`.
pub fn patch(origin: f64) -> Value {
    let nodes: Vec<[f64; 3]> = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
        .iter()
        .map(|[x, y]| [origin + x, origin + y, origin])
        .collect();
    timed(
        "patch",
        json!({
            "mesh": {"explicit": {"nodes": nodes, "triangles": [[0, 1, 2], [0, 2, 3]]}},
            "mass": {"nodal": 0.1},
            "springs": [{"on": "all", "stiffness": 100.0}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
            "initial": {"velocity": [[0, 0, 0], [0.1, 0, 0], [0, 0, 1], [0, 0, 0]]}
        }),
    )
}

/// Five nodes on a line, the first held.
pub fn chain() -> Value {
    timed(
        "chain",
        json!({
            "mesh": {"explicit": {
                "nodes": [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0], [4, 0, 0]],
                "springs": [[0, 1], [1, 2], [2, 3], [3, 4]]
            }},
            "mass": {"nodal": 0.1},
            "springs": [{"on": "all", "stiffness": 100.0}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
            "gravity": [0, 0, -9.81]
        }),
    )
}

/// One free mass.
pub fn mote() -> Value {
    timed(
        "mote",
        json!({
            "mesh": {"explicit": {"nodes": [[0, 0, 0]], "springs": []}},
            "mass": {"nodal": 0.1},
            "gravity": [0, 0, -9.81]
        }),
    )
}

/// A simple pendulum of 1 m and 1 kg.
pub fn pendulum() -> Value {
    json!({
        "name": "pendulum",
        "system": {"pendulum": {"length": 1.0, "mass": 1.0, "damping": 0.1, "gravity": 9.81, "angle": 1.0, "rate": 0.0}},
        "time": {"end": 0.02, "method": "newmark", "step": 0.001}
    })
}
