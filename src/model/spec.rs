//! A network as plain resolved data: without files, selections or defaults. The case reader makes it, and
//! [`crate::scene`] builds the scene from it. All numbers are the user's.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::mesh::Mesh;

/// The force law of a spring in tension and compression. `e` is the elongation l - l0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub enum Slack {
    /// T = k e: tension and compression.
    #[default]
    None,
    /// T = k max(e, 0): no compression.
    TensionOnly,
    /// T = k max(e - eps, 0): tension above the elongation `eps`.
    DeadZone {
        /// [m] elongation below which the spring is slack, >= 0
        eps: f64,
    },
    /// T = k max(e, -eps): the compression is at most k eps.
    CompressionLimit {
        /// [m] shortening above which the compression is constant, >= 0
        eps: f64,
    },
}

/// The direction in which a dashpot acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum DashpotKind {
    /// c ldot along the spring; clamped together with a slack spring.
    Axial,
    /// c (vb - va), all three components, slack or not.
    Relative,
}

/// Dashpots of a spring group.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DashpotSpec {
    /// axial or relative
    pub kind: DashpotKind,
    /// [N s/m] coefficient of every spring of the group, already resolved from its rule
    pub coefficient: Vec<f64>,
    /// whether the rule was `"step"` (c = k dt), which Kang's filter contains already
    pub from_step: bool,
}

/// Springs that share a rule of the case.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpringGroup {
    /// edges of the mesh, ascending
    pub edges: Vec<u32>,
    /// [N/m] stiffness of every spring
    pub stiffness: Vec<f64>,
    /// [m] rest length of every spring
    pub rest_length: Vec<f64>,
    /// slack rule
    pub slack: Slack,
    /// optional dashpots
    pub dashpot: Option<DashpotSpec>,
}

/// A factor or vector over time, linear between its rows, held constant outside them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Series<T> {
    /// [s] strictly increasing times; at least one
    pub t: Vec<f64>,
    /// one value per time
    pub value: Vec<T>,
}

/// The air: pressure jump dp = linear v_n + quadratic v_n |v_n| over the cloth, acting along the relative wind.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AirSpec {
    /// [Pa s/m] viscous coefficient (thickness times A_e, or times a)
    pub linear: f64,
    /// [Pa s^2/m^2] inertial coefficient (thickness times B_e, or times b, or cp rho/2)
    pub quadratic: f64,
    /// [m/s] wind velocity over time
    pub wind: Series<[f64; 3]>,
}

/// How a pressure load follows the surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum PressureKind {
    /// p A N on the current area and normal.
    Follower,
    /// p A0 along a fixed direction (unit vector), or along each triangle's initial normal if `None`.
    Dead(Option<[f64; 3]>),
}

/// A pressure on some triangles.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PressureLoad {
    /// triangles, ascending
    pub triangles: Vec<u32>,
    /// [Pa] pressure
    pub pressure: f64,
    /// follower or dead
    pub kind: PressureKind,
    /// optional factor over time
    pub factor: Option<Series<f64>>,
}

/// A force on some nodes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NodalLoad {
    /// nodes, ascending
    pub nodes: Vec<u32>,
    /// [N] force on each of them
    pub force: [f64; 3],
    /// optional factor over time
    pub factor: Option<Series<f64>>,
}

/// Rayleigh damping f -= (alpha M + beta K0) v, with K0 = sum of k n n^T on the mesh as given: no slack, no geometric
/// part.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Rayleigh")]
pub struct RayleighSpec {
    /// [1/s] Factor alpha of the mass; 0 if not given.
    #[serde(default)]
    #[schemars(range(min = 0))]
    pub mass: f64,
    /// [s] Factor beta of the initial stiffness; 0 if not given.
    #[serde(default)]
    #[schemars(range(min = 0))]
    pub stiffness: f64,
}

/// All data of a network scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct NetworkSpec {
    /// positions as given, before `displacement`
    pub mesh: Mesh,
    /// [kg] lumped mass of every node
    pub mass: Vec<f64>,
    /// which of x, y, z is fixed, `[n_nodes][3]`
    pub fixed: Vec<[bool; 3]>,
    /// springs by rule
    pub springs: Vec<SpringGroup>,
    /// [m/s^2] gravity, if any
    pub gravity: Option<[f64; 3]>,
    /// the air, if any
    pub air: Option<AirSpec>,
    /// pressure loads
    pub pressures: Vec<PressureLoad>,
    /// nodal forces
    pub forces: Vec<NodalLoad>,
    /// Rayleigh damping, if any
    pub rayleigh: Option<RayleighSpec>,
    /// [m] initial displacement of every node; empty = zero
    pub displacement: Vec<[f64; 3]>,
    /// [m/s] initial velocity of every node, zero at fixed degrees of freedom; empty = zero
    pub velocity: Vec<[f64; 3]>,
}

/// A simple pendulum: m L^2 theta'' = -m g L sin(theta) - c theta'. Its bob is node 0 at (L sin, 0, -L cos).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Pendulum")]
pub struct PendulumSpec {
    /// [m] Length L of the line.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub length: f64,
    /// [kg] Mass m of the bob.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub mass: f64,
    /// [N m s] Damping c of the rotation; 0 if not given.
    #[serde(default)]
    #[schemars(range(min = 0))]
    pub damping: f64,
    /// [m/s^2] Gravity g, downwards along -z.
    #[schemars(range(min = 0))]
    pub gravity: f64,
    /// [rad] Initial angle from the lowest position.
    pub angle: f64,
    /// [rad/s] Initial angular velocity; 0 if not given.
    #[serde(default)]
    pub rate: f64,
}
