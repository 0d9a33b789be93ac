//! A small flat circular parachute without a vent: nodes along the radials only, lines from the skirt to one payload.

use serde_json::{Value, json};
use std::f64::consts::PI;

/// Nodes, springs and triangles.
pub type ExplicitMesh = (Vec<[f64; 3]>, Vec<[usize; 2]>, Vec<[usize; 3]>);

/// Its size. Everything starts flat, with straight lines, at z = 0 and below.
#[derive(Clone, Copy, Debug)]
pub struct Parachute {
    /// number of gores
    pub gores: usize,
    /// nodes along a radial, without the apex
    pub rings: usize,
    /// segments of a line
    pub line_segments: usize,
    /// [m] D0, from the area of the cloth
    pub nominal_diameter: f64,
    /// [m] length of the lines
    pub line_length: f64,
}

impl Parachute {
    /// [m^2] S0
    pub fn area(&self) -> f64 {
        0.25 * PI * self.nominal_diameter.powi(2)
    }

    /// [m] length of a radial: S0 = n R^2 sin(2 pi/n)/2
    pub fn radius(&self) -> f64 {
        let n = self.gores as f64;
        (2.0 * self.area() / (n * (2.0 * PI / n).sin())).sqrt()
    }

    fn ring(&self, ring: usize, gore: usize) -> usize {
        1 + ring * self.gores + gore % self.gores
    }

    /// Nodes of the skirt.
    pub fn skirt(&self) -> Vec<usize> {
        (0..self.gores).map(|gore| self.ring(self.rings - 1, gore)).collect()
    }

    /// The node of the payload, where the lines meet.
    pub fn payload(&self) -> usize {
        1 + self.rings * self.gores + (self.line_segments - 1) * self.gores
    }

    /// The mesh, `at` metres to the side.
    pub fn mesh(&self, at: f64) -> ExplicitMesh {
        let (n, radius) = (self.gores, self.radius());
        let depth = (self.line_length.powi(2) - radius.powi(2)).sqrt();
        let place = |r: f64, gore: usize, z: f64| {
            let angle = 2.0 * PI * gore as f64 / n as f64;
            [at + r * angle.cos(), r * angle.sin(), z]
        };
        let mut nodes = vec![[at, 0.0, 0.0]];
        for ring in 1..=self.rings {
            let r = radius * ring as f64 / self.rings as f64;
            nodes.extend((0..n).map(|gore| place(r, gore, 0.0)));
        }
        for segment in 1..self.line_segments {
            let share = segment as f64 / self.line_segments as f64;
            nodes.extend((0..n).map(|gore| place(radius * (1.0 - share), gore, -depth * share)));
        }
        nodes.push([at, 0.0, -depth]);
        let (mut edges, mut triangles) = (Vec::new(), Vec::new());
        for gore in 0..n {
            edges.push([0, self.ring(0, gore)]);
            triangles.push([0, self.ring(0, gore), self.ring(0, gore + 1)]);
            for ring in 0..self.rings {
                edges.push([self.ring(ring, gore), self.ring(ring, gore + 1)]);
                if ring + 1 < self.rings {
                    let [a, b] = [gore, gore + 1].map(|gore| self.ring(ring, gore));
                    let [c, d] = [gore, gore + 1].map(|gore| self.ring(ring + 1, gore));
                    edges.push([a, c]);
                    edges.push([b, c]);
                    triangles.push([a, c, b]);
                    triangles.push([b, c, d]);
                }
            }
            // The rings of the lines follow those of the canopy.
            for segment in 0..self.line_segments {
                let end = self.ring(self.rings + segment, gore);
                let end = if segment + 1 == self.line_segments { self.payload() } else { end };
                edges.push([self.ring(self.rings - 1 + segment, gore), end]);
            }
        }
        (nodes, edges, triangles)
    }

    /// Positions of the nodes at line stretch: radials and lines straight, the skirt at `radius` [m] from the axis.
    pub fn stretched(&self, radius: f64) -> Vec<[f64; 3]> {
        let place = |from_apex: f64, gore: usize| {
            let (to_skirt, n) = (self.radius(), self.gores as f64);
            let on_line = (from_apex - to_skirt).max(0.0) / self.line_length;
            let share = if on_line > 0.0 { 1.0 - on_line } else { from_apex / to_skirt };
            let down = |length: f64| (length.powi(2) - radius.powi(2)).sqrt();
            let depth = down(to_skirt) * (from_apex / to_skirt).min(1.0) + down(self.line_length) * on_line;
            let angle = 2.0 * PI * gore as f64 / n;
            [radius * share * angle.cos(), radius * share * angle.sin(), -depth]
        };
        let rings = (1..=self.rings).map(|ring| self.radius() * ring as f64 / self.rings as f64);
        let segments = (1..self.line_segments).map(|segment| segment as f64 / self.line_segments as f64);
        let lengths = rings.chain(segments.map(|share| self.radius() + share * self.line_length));
        let mut nodes = vec![[0.0; 3]];
        nodes.extend(
            lengths.flat_map(|length| (0..self.gores).map(move |gore| (length, gore))).map(|(l, g)| place(l, g)),
        );
        nodes.push(place(self.radius() + self.line_length, 0));
        nodes
    }

    /// The displacements to positions of the nodes.
    pub fn displaced_to(&self, positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let (nodes, _, _) = self.mesh(0.0);
        nodes.iter().zip(positions).map(|(from, to)| [0, 1, 2].map(|i| to[i] - from[i])).collect()
    }

    /// A case: the parachute falls with `speed` [m/s] from the start under a payload of `mass` [kg] in still air, with
    /// the pressure coefficient `dcp` [-].
    pub fn case(&self, dcp: f64, mass: f64, speed: f64) -> Value {
        let (nodes, edges, triangles) = self.mesh(0.0);
        let mut masses = vec![0.0; nodes.len()];
        masses[self.payload()] = mass;
        json!({
            "name": "parachute",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": nodes, "springs": edges, "triangles": triangles}},
                "mass": {"areal_density": 0.05, "nodal": masses},
                "springs": [
                    {"on": "lines", "axial_rigidity": 2e4, "linear_density": 0.003, "slack": "tension-only",
                     "dashpot": {"relative": {"time": 2e-5}}},
                    {"on": "all", "axial_rigidity": 2e4, "slack": "tension-only", "dashpot": {"relative": {"time": 2e-5}}}
                ],
                "gravity": [0, 0, -9.81],
                "aero": {"canopy": {
                    "on": "all", "table": {"pressure_coefficient": dcp}, "confluence": {"ids": [self.payload()]}
                }},
                "initial": {"velocity": [0, 0, -speed]}
            }},
            "time": {"end": 1.0, "method": "velocity-verlet", "step": 1e-4}
        })
    }
}
