//! Canopies and balloons whose radials alone carry: no stress across them, an even pressure inside. They start flat (a
//! reefed one near its shape) and settle under mass damping in closed forms for inextensible radials.
//!
//! Between two neighbouring radials of the same shape the cloth is flat. So n radials take the shape of infinitely
//! many, while pressure and volume act through a polygon: every load and every volume is (n/2 pi) sin(2 pi/n) times as
//! large.

mod balloon;
mod reefed;
mod taylor;

pub use balloon::claims as balloon;
pub use reefed::claims as reefed;
pub use taylor::{claims as taylor, static_claims as taylor_static};

use crate::common::run::case_of;
use crate::equilibrium::AtRest;
use canopy_fem::case::spec::SystemSpec;
use canopy_fem::mesh::Mesh;
use canopy_fem::simulation::Simulation;
use nalgebra::Vector3;
use serde_json::Value;
use std::f64::consts::TAU;

type Vector = Vector3<f64>;

/// [Pa] pressure inside
const PRESSURE: f64 = 20.0;
/// [N] EA of radials and lines, which their loads of some 2 N strain by 2e-4
const RIGIDITY: f64 = 1e4;
/// [1/s] of the mass damping: the slowest motion is damped critically
const DAMPING: f64 = 12.0;
/// [s] until nothing moves by more than 1e-5 m/s
const SETTLED: f64 = 3.0;

/// [-] area of a regular polygon of n corners over that of the circle through them
fn polygon(n: usize) -> f64 {
    let angle = TAU / n as f64;
    angle.sin() / angle
}

/// A scene at rest.
struct Settled {
    mesh: Mesh,
    /// [m]
    positions: Vec<Vector>,
    /// [N] of the edges; not a number where there is no spring
    tensions: Vec<f64>,
    /// [N]
    reactions: Vec<Vector>,
    /// [m/s]
    fastest: f64,
}

impl Settled {
    /// The equilibrium of `canopy-fem static`.
    fn found(case: &Value) -> Self {
        let case = case_of(case, &[]);
        let SystemSpec::Network(network) = &case.problem().system else { panic!("a network") };
        let mesh = network.mesh.clone();
        let AtRest { positions, tensions, reactions, .. } = AtRest::of(&case);
        let vectors = |list: Vec<[f64; 3]>| list.into_iter().map(Vector::from).collect::<Vec<_>>();
        Settled { mesh, positions: vectors(positions), tensions, reactions: vectors(reactions), fastest: 0.0 }
    }

    fn of(case: &Value) -> Self {
        let case = case_of(case, &[]);
        let SystemSpec::Network(network) = &case.problem().system else { panic!("a network") };
        let mut simulation = Simulation::from_case(case.problem(), 1).expect("it starts");
        simulation.run_until(SETTLED).expect("it settles");
        let vectors = |list: Vec<[f64; 3]>| list.into_iter().map(Vector::from).collect::<Vec<_>>();
        Settled {
            mesh: network.mesh.clone(),
            positions: vectors(simulation.positions()),
            tensions: simulation.tensions(),
            reactions: vectors(simulation.reactions()),
            fastest: vectors(simulation.velocities()).iter().map(Vector::norm).fold(0.0, f64::max),
        }
    }

    /// [m] Mean distance from the axis of each of consecutive rows of `n` nodes, the first of which is `first`, and
    /// their mean height.
    fn rows(&self, first: usize, n: usize, count: usize) -> Vec<[f64; 2]> {
        let rows = self.positions[first..first + n * count].chunks(n);
        let mean = |row: &[Vector], of: &dyn Fn(&Vector) -> f64| row.iter().map(of).sum::<f64>() / n as f64;
        rows.map(|row| [mean(row, &|p| p.xy().norm()), mean(row, &|p| p.z)]).collect()
    }

    /// [m^3] Volume of the triangles with the origin: by the divergence theorem that inside a closed surface.
    fn cones(&self) -> f64 {
        let cone = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|node| self.positions[node as usize]);
            a.dot(&b.cross(&c)) / 6.0
        };
        self.mesh.triangles.iter().map(cone).sum()
    }
}

/// [m] Length of a polygonal line.
fn length(line: &[[f64; 2]]) -> f64 {
    line.windows(2).map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1])).sum()
}

/// [m] Largest distance from the axis of a meridian: that of the parabola through the three points around its widest.
fn widest(meridian: &[[f64; 2]]) -> f64 {
    let r = |i: usize| meridian[i][0];
    let last = meridian.len() - 1;
    let most = (0..=last).max_by(|&a, &b| r(a).total_cmp(&r(b))).unwrap_or(0);
    let middle = most.clamp(1, last - 1);
    let (bend, slope) = (r(middle + 1) - 2.0 * r(middle) + r(middle - 1), 0.5 * (r(middle + 1) - r(middle - 1)));
    r(middle) - 0.5 * slope * slope / bend
}
