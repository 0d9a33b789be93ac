//! A network as plain resolved data: without files, selections or defaults. The case reader makes it, and
//! [`crate::scene`] builds the scene from it. All numbers are the user's.

use serde::{Deserialize, Serialize};

use crate::mesh::Mesh;

mod canopy;
mod contact;
mod event;
mod glide;
mod over_time;
mod spring_values;
mod stream;
mod surface;
pub use canopy::{CanopyAir, CanopySpec, CavitySpec, ClothSpec, FillingSpec, RingsSpec};
pub use contact::{ContactParts, ContactSide, ContactSpec, ObstacleShape, ObstacleSpec};
pub use event::{Condition, EventSpec, Trigger, Watched};
pub use glide::GlideSpec;
pub use over_time::{MotionSpec, Series, support_velocity};
pub use spring_values::SpringValues;
pub use stream::{AtmosphereSpec, EventWind, GustSpec, StreamSpec, WindOverTime};
pub use surface::{BendingSpec, MembraneSpec};

/// How the tension of a spring grows with its strain r = e/l0, before any slack.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub enum ElasticLaw {
    /// T = k e.
    #[default]
    Linear,
    /// T = k e (1 + r)(1 + r/2), EA lambda (lambda^2 - 1)/2 with k = EA/l0: the St. Venant-Kirchhoff bar.
    Green,
    /// Force [N] over strain [-], linear between the rows and beyond them: at least two rows with strains that increase
    /// and forces that do not fall, 0 at the strain 0. k is then its steepest slope over l0.
    Table(Vec<[f64; 2]>),
}

/// When a spring is slack. `e` is the elongation l - l0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub enum Slack {
    /// T = k e: never.
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
    /// T = k min(e, 0): no tension.
    CompressionOnly,
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
    /// [N s/m] coefficient of the springs, already resolved from its rule
    pub coefficient: SpringValues,
    /// whether the rule was `"step"` (c = k dt), which Kang's filter contains already
    pub from_step: bool,
}

/// Springs that share a rule of the case.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SpringGroup {
    /// edges of the mesh, ascending
    pub edges: Vec<u32>,
    /// [N/m] stiffness of the springs
    pub stiffness: SpringValues,
    /// [m] rest length of every spring
    pub rest_length: Vec<f64>,
    /// tension over strain
    pub law: ElasticLaw,
    /// slack rule
    pub slack: Slack,
    /// optional dashpots
    pub dashpot: Option<DashpotSpec>,
    /// [s] from when on they carry no force, above 0, if they are cut
    pub cut: Option<f64>,
    /// the event at which they are cut, if there is one
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cut_by: Option<usize>,
    /// [N] tension at which every spring breaks; empty if they do not
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub breaks: Vec<f64>,
    /// [-] factor of the rest lengths over time, above 0, if they change
    pub rest_scale: Option<Series<f64>>,
    /// their strength, for reports only
    #[serde(skip)]
    pub strength: Option<StrengthSpec>,
    /// the sheet that they stand for, if its rule gives the stiffness
    #[serde(skip)]
    pub sheet: Option<SheetSpec>,
}

impl SpringGroup {
    /// [-] Factor of the rest lengths at t = 0.
    pub fn rest_scale_at_start(&self) -> f64 {
        self.rest_scale.as_ref().map_or(1.0, |factor| factor.rows().at(0.0)[0])
    }
}

/// The strength of springs; they break only where [`SpringGroup::breaks`] says so.
#[derive(Clone, Debug, PartialEq)]
pub struct StrengthSpec {
    /// what reports call them
    pub name: String,
    /// [N] of each spring, or of each of its strands
    pub strength: f64,
    /// [-] tapes or lines that a spring stands for, one number a spring; one each if there is none
    pub strands: Option<Vec<f64>>,
}

/// A continuous isotropic sheet in place of springs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SheetSpec {
    /// [Pa] Young's modulus
    pub modulus: f64,
    /// [m] thickness
    pub thickness: f64,
}

/// Directions of nodes that are held until a time or an event.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ReleaseSpec {
    /// [s] when, above 0; infinite where an event says when
    pub t: f64,
    /// the event
    #[serde(skip_serializing_if = "Option::is_none")]
    pub event: Option<usize>,
    /// the nodes, with those of x, y, z that become free
    pub nodes: Vec<(u32, [bool; 3])>,
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

/// The drag of lines in a cross-flow.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct LineDragSpec {
    /// edges of the mesh, ascending
    pub edges: Vec<u32>,
    /// [m] diameter
    pub diameter: f64,
    /// [-] drag coefficient on the normal speed
    pub coefficient: f64,
}

/// The drag of bodies that nodes stand for.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct NodeDragSpec {
    /// nodes, ascending
    pub nodes: Vec<u32>,
    /// [m^2] drag area of each of them
    pub drag_area: f64,
    /// lift, if they glide
    #[serde(skip_serializing_if = "Option::is_none")]
    pub glide: Option<GlideSpec>,
}

/// The wind on a zone of a surface, by pressure coefficients: cp q against the outer normal.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SurfacePressureSpec {
    /// triangles, ascending, right-handed about the outer normal; no triangle in two zones
    pub triangles: Vec<u32>,
    /// \[-\] cp over the angle \[rad\] between the outer normal and where the wind comes from, in place of a time
    pub coefficient: Series<f64>,
}

/// Gas in a volume that triangles close, or triangles and the ground that holds the rims of their openings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GasSpec {
    /// triangles, ascending; neighbours turn the same way
    pub triangles: Vec<u32>,
    /// [Pa] absolute pressure outside, above 0
    pub ambient: f64,
    /// \[-\] exponent of p V^gamma, at least 1
    pub gamma: f64,
    /// \[m^3\] volume at the start; that which the triangles enclose if not given
    pub volume: Option<f64>,
    /// what fills it
    pub fill: GasFill,
}

/// What fills a volume with gas, over time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum GasFill {
    /// [Pa] Pressure above that outside, which the gas has in the volume at the start.
    Pressure(Series<f64>),
    /// \[m^3\] Its volume at the pressure outside, above 0.
    Amount(Series<f64>),
}

impl GasFill {
    /// The table of either.
    pub fn table(&self) -> &Series<f64> {
        let (GasFill::Pressure(table) | GasFill::Amount(table)) = self;
        table
    }
}

/// How a pressure load follows the surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum PressureKind {
    /// p A N on the current area and normal.
    Follower,
    /// p A0 along a fixed direction (unit vector), or along each triangle's initial normal if `None`.
    Dead(Option<[f64; 3]>),
    /// p on the initial area as seen along a fixed direction (unit vector), and in it: snow on the plan.
    Plan([f64; 3]),
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
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", schemars(rename = "Rayleigh"))]
pub struct RayleighSpec {
    /// [1/s] Factor alpha of the mass; 0 if not given.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(range(min = 0)))]
    pub mass: f64,
    /// [s] Factor beta of the initial stiffness; 0 if not given.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(range(min = 0)))]
    pub stiffness: f64,
}

impl ReleaseSpec {
    /// Frees what it frees, `[n_nodes][3]`; nodes beyond are passed over.
    pub fn apply(&self, fixed: &mut [[bool; 3]]) {
        for (node, directions) in &self.nodes {
            let held = fixed.get_mut(*node as usize).into_iter().flatten();
            held.zip(directions).for_each(|(held, free)| *held &= !free);
        }
    }
}

/// All data of a network scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct NetworkSpec {
    /// positions as given, before `displacement`
    pub mesh: Mesh,
    /// [kg] lumped mass of every node
    pub mass: Vec<f64>,
    /// which of x, y, z is fixed at t = 0, `[n_nodes][3]`
    pub fixed: Vec<[bool; 3]>,
    /// what becomes free later
    pub releases: Vec<ReleaseSpec>,
    /// events that releases, cuts and stages refer to, and those that are only told
    pub events: Vec<EventSpec>,
    /// what supports move; no direction of a node twice
    pub motions: Vec<MotionSpec>,
    /// springs by rule
    pub springs: Vec<SpringGroup>,
    /// membranes; no triangle twice
    pub membranes: Vec<MembraneSpec>,
    /// bending of cloth and of lines
    pub bending: Vec<BendingSpec>,
    /// [m/s^2] gravity, if any
    pub gravity: Option<[f64; 3]>,
    /// [m/s^2] acceleration of the base over time, if it moves: positions and velocities are then relative to it
    pub base_acceleration: Option<Series<[f64; 3]>>,
    /// the air that blows through cloth, if any
    pub air: Option<AirSpec>,
    /// zones of surfaces with pressure coefficients
    pub surface_pressures: Vec<SurfacePressureSpec>,
    /// the stream for canopies, zones and drag, which need one; its wind then replaces that of `air`
    pub stream: Option<StreamSpec>,
    /// canopies that the air fills
    pub canopies: Vec<CanopySpec>,
    /// drag of lines
    pub line_drag: Vec<LineDragSpec>,
    /// drag of nodes
    pub node_drag: Vec<NodeDragSpec>,
    /// gas in closed volumes
    pub gases: Vec<GasSpec>,
    /// what may touch
    pub contacts: Vec<ContactSpec>,
    /// pressure loads
    pub pressures: Vec<PressureLoad>,
    /// nodal forces
    pub forces: Vec<NodalLoad>,
    /// Rayleigh damping, if any
    pub rayleigh: Option<RayleighSpec>,
    /// [s] if given, nodes get more inertia until their elements allow steps of this size with central differences;
    /// weight and Rayleigh damping stay those of `mass`
    pub mass_scaling: Option<f64>,
    /// [m] initial displacement of every node; empty = zero
    pub displacement: Vec<[f64; 3]>,
    /// [m/s] initial velocity of every node, zero at fixed degrees of freedom, which have those of their motion; empty
    /// = zero
    pub velocity: Vec<[f64; 3]>,
}

impl NetworkSpec {
    /// Which of x, y, z is fixed for ever, `[n_nodes][3]`.
    pub fn always_fixed(&self) -> Vec<[bool; 3]> {
        let mut fixed = self.fixed.clone();
        self.releases.iter().for_each(|release| release.apply(&mut fixed));
        fixed
    }

    /// [s] The times of all releases and cuts that are known from the start, ascending.
    pub fn divisions(&self) -> Vec<f64> {
        let cuts = self.springs.iter().filter_map(|group| group.cut);
        let releases = self.releases.iter().filter(|release| release.event.is_none()).map(|release| release.t);
        ascending(releases.chain(cuts).collect())
    }

    /// [s] The same and the times at which a support's velocity changes, ascending.
    pub fn events(&self) -> Vec<f64> {
        let mut times = self.divisions();
        times.extend(self.motions.iter().flat_map(|motion| motion.displacement.bends()));
        ascending(times)
    }

    /// [m/s] A bound on the speed of the wind.
    pub fn fastest_wind(&self) -> f64 {
        match (&self.stream, &self.air) {
            (Some(stream), _) => stream.fastest_wind(),
            (None, air) => air.as_ref().map_or(0.0, |air| stream::fastest(&air.wind)),
        }
    }
}

/// [s] The times in order, each once.
pub(crate) fn ascending(mut times: Vec<f64>) -> Vec<f64> {
    times.sort_by(f64::total_cmp);
    times.dedup();
    times
}

/// A simple pendulum: m L^2 theta'' = -m g L sin(theta) - c theta'. Its bob is node 0 at (L sin, 0, -L cos).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", schemars(rename = "Pendulum"))]
pub struct PendulumSpec {
    /// [m] Length L of the line.
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub length: f64,
    /// [kg] Mass m of the bob.
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub mass: f64,
    /// [N m s] Damping c of the rotation; 0 if not given.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(range(min = 0)))]
    pub damping: f64,
    /// [m/s^2] Gravity g, downwards along -z.
    #[cfg_attr(feature = "schema", schemars(range(min = 0)))]
    pub gravity: f64,
    /// [rad] Initial angle from the lowest position.
    pub angle: f64,
    /// [rad/s] Initial angular velocity; 0 if not given.
    #[serde(default)]
    pub rate: f64,
}
