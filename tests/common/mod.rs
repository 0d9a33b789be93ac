//! Shared by the integration tests: small networks as plain specifications, and a random source without state.
#![allow(dead_code)] // every test binary uses its own part

pub mod gores;
pub mod parachute;
pub mod polynomials;
pub mod read_vtu;
pub mod run;

use canopy_fem::mesh::Mesh;
use canopy_fem::mesh::source::MeshSource;
use canopy_fem::model::spec::{NetworkSpec, Slack, SpringGroup};
use std::path::Path;

/// Numbers in [-1, 1) from a counter (splitmix64), the same on every machine.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)) as f64 / (1u64 << 63) as f64 - 1.0
    }

    pub fn vector(&mut self) -> [f64; 3] {
        [self.next(), self.next(), self.next()]
    }
}

/// Writes an .obj file of four triangles on six vertices, the third at `x` [m].
pub fn write_net(path: &Path, x: f64) {
    let text = format!("v 0 0 0\nv 1 0 0\nv {x} 1 0\nv 1 1 0\nv 2 0 0\nv 2 1 0\nf 1 2 4\nf 1 4 3\nf 2 5 6\nf 2 6 4\n");
    std::fs::write(path, text).expect("written");
}

/// A square with `side` springs along an edge and a mass at every node; none is held.
pub fn square(side: u32, mass: f64) -> NetworkSpec {
    let json = serde_json::json!({"rectangle": {
        "width": 1.0, "height": 1.0, "columns": side, "rows": side, "pattern": "regular"
    }});
    let source: MeshSource = serde_json::from_value(json).expect("a known generator");
    let mesh = source.build(Path::new(".")).expect("a rectangle");
    let n = mesh.nodes.len();
    NetworkSpec { mesh, mass: vec![mass; n], fixed: vec![[false; 3]; n], ..Default::default() }
}

/// A case's network: an octahedron of springs on the axes, 0.7 m from its middle, a closed surface of eight triangles.
pub fn octahedron() -> serde_json::Value {
    let r = 0.7;
    serde_json::json!({
        "mesh": {"explicit": {
            "nodes": [[r, 0, 0], [-r, 0, 0], [0, r, 0], [0, -r, 0], [0, 0, r], [0, 0, -r]],
            "triangles": [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
        }},
        "mass": {"nodal": 0.4},
        "springs": [{"on": "all", "stiffness": 800.0}]
    })
}

/// A 3 x 3 grid of nodes with diagonals: 9 nodes, 16 edges, 8 triangles, all masses different, one corner held.
pub fn patch() -> NetworkSpec {
    let nodes: Vec<[f64; 3]> = (0..9).map(|i| [f64::from(i % 3), f64::from(i / 3), 0.0]).collect();
    let mut triangles = Vec::new();
    for i in [0u32, 1, 3, 4] {
        triangles.push([i, i + 1, i + 4]);
        triangles.push([i, i + 4, i + 3]);
    }
    let mut edges = Vec::new();
    for t in &triangles {
        for e in [[t[0], t[1]], [t[1], t[2]], [t[0], t[2]]] {
            if !edges.contains(&e) && !edges.contains(&[e[1], e[0]]) {
                edges.push(e);
            }
        }
    }
    let mut fixed = vec![[false; 3]; 9];
    fixed[0] = [true; 3];
    fixed[2] = [false, true, false];
    let mass = (0..9).map(|i| 0.3 + 0.05 * f64::from(i)).collect();
    NetworkSpec { mesh: Mesh { nodes, edges, triangles, ..Mesh::default() }, mass, fixed, ..Default::default() }
}

/// Springs on all edges of a specification.
pub fn spring_group(spec: &NetworkSpec, slack: Slack) -> SpringGroup {
    let n = spec.mesh.edges.len();
    let length = |e: &[u32; 2]| {
        let [a, b] = e.map(|i| spec.mesh.nodes[i as usize]);
        (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
    };
    SpringGroup {
        edges: (0..n as u32).collect(),
        stiffness: (0..n).map(|i| 40.0 + 3.0 * i as f64).collect(),
        rest_length: spec.mesh.edges.iter().map(length).collect(),
        slack,
        ..SpringGroup::default()
    }
}

/// One mass on one spring from an anchor: x'' = -(k/m) (x - l0) along x; displaced by `x0`.
pub struct OscillatorSpec {
    pub stiffness: f64,
    pub mass: f64,
    pub displacement: f64,
}

pub fn oscillator(o: OscillatorSpec) -> NetworkSpec {
    let mesh = Mesh { nodes: vec![[0.0; 3], [5.0, 0.0, 0.0]], edges: vec![[0, 1]], ..Default::default() };
    NetworkSpec {
        mesh,
        mass: vec![0.0, o.mass],
        fixed: vec![[true; 3], [false; 3]],
        springs: vec![SpringGroup {
            edges: vec![0],
            stiffness: o.stiffness.into(),
            rest_length: vec![5.0],
            ..SpringGroup::default()
        }],
        displacement: vec![[0.0; 3], [o.displacement, 0.0, 0.0]],
        ..Default::default()
    }
}
