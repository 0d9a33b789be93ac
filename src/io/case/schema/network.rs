//! The network: mesh, mass, springs, supports and what acts on it. A section that is absent means physics that is not
//! modelled.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

use super::aero::{Aero, OneOrSeveral};
use super::contact::Contact;
use super::event::When;
use super::gas::Gas;
use super::loads::Load;
use super::per_node::{PerNode, Vectors};
use super::select::NodeSelection;
use super::springs::SpringRule;
use super::surface::{BendingRule, MembraneRule};
use super::table::VectorTable;
use crate::mesh::source::MeshSource;
use crate::model::spec::RayleighSpec;

/// Point masses joined by springs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Network {
    /// `"point"`: the whole parachute is one mass at its payload, with a drag area. It has the mass of all nodes, the
    /// drag areas of the payload and of canopies with a `schedule`, the same air and events. Gauges and probes of the
    /// payload or of all nodes stay, and `tension` of what alone carries the canopies, as a riser. The network as
    /// described if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<NetworkModel>,
    /// Where the nodes, edges and triangles come from.
    pub mesh: MeshSource,
    /// Mass of the nodes; every free node needs a mass, from here or from `springs[].linear_density`.
    pub mass: Option<Mass>,
    /// Springs on edges; an edge follows the first rule that selects it, and every rule for a group that it is in.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub springs: Vec<SpringRule>,
    /// Triangles that are a membrane, in place of springs on their edges or beside them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub membranes: Vec<MembraneRule>,
    /// Bending stiffness of cloth and of lines.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bending: Vec<BendingRule>,
    /// Nodes that are held.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub supports: Vec<Support>,
    /// [m/s^2] Gravity, e.g. [0, 0, -9.81].
    pub gravity: Option<[f64; 3]>,
    /// [m/s^2] Acceleration of the base over time, such as an earthquake's: `{"table": [[t, ax, ay, az], ...]}`. It
    /// shakes all supports alike (uniform excitation): positions, velocities and accelerations are relative to the
    /// base, and on every free mass acts the force -m a. Not together with `aero`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base_acceleration: Option<VectorTable>,
    /// The air; it acts on all triangles.
    pub aero: Option<Aero>,
    /// Gas in a closed volume, or in each of a list of volumes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gas: Option<OneOrSeveral<Gas>>,
    /// What may touch what: cloth, lines and rigid bodies. Without it everything passes through everything.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub contact: Vec<Contact>,
    /// Given pressures and forces.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub loads: Vec<Load>,
    /// Damping of the network as a whole.
    pub damping: Option<Damping>,
    /// Initial displacements and velocities of the nodes.
    pub initial: Option<Initial>,
}

/// What stands for a network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum NetworkModel {
    /// One mass.
    Point,
}

/// Mass of the nodes: the sum of what is given.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Mass {
    /// [kg/m^2] Mass per area: a third of each triangle's area on the mesh as given goes to each of its nodes.
    #[schemars(range(min = 0))]
    pub areal_density: Option<f64>,
    /// [kg] Mass of every node, or a list with one mass per node; none may be negative.
    pub nodal: Option<PerNode>,
    /// Masses on some nodes, such as a payload.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub points: Vec<PointMass>,
}

/// A mass on each of some nodes, or one that they share; exactly one of `mass` and `total` is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointMass {
    /// Which nodes.
    pub on: NodeSelection,
    /// [kg] Mass on each of the nodes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    pub mass: Option<f64>,
    /// [kg] Mass of all the nodes together, an equal share on each.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    pub total: Option<f64>,
}

/// Nodes that are held where the initial displacement puts them, or are moved from there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Support {
    /// Which nodes.
    pub on: NodeSelection,
    /// Directions that are held: any of the letters x, y and z, each at most once. Several supports of a node add up.
    #[schemars(regex(pattern = r"^(x(yz?|zy?)?|y(xz?|zx?)?|z(xy?|yx?)?)$"))]
    pub fix: String,
    /// [s] When the nodes are released, within the run; not given: never. A direction is free once every support that
    /// holds it has released it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub until: Option<f64>,
    /// When the nodes are released, by the state of the scene or after another event; not together with `until`. No
    /// other support may hold the same direction of a node.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub when: Option<When>,
    /// [m] How the support moves: `{"table": [[t, dx, dy, dz], ...]}`, the displacement from where its nodes are at t
    /// = 0. It is 0 at t = 0, and in directions that are not held. The velocity is constant between two rows and jumps
    /// at a row; a step ends there. No other support may hold the same direction of a node.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<VectorTable>,
    /// [m] Settlement `[dx, dy, dz]`: how far the support has moved from where the mesh and `initial` put its nodes; 0
    /// in directions that are not held. A run in time begins with it, at rest; `static` applies it with the loads, in
    /// as many steps. `motion` adds to it. No other support may hold the same direction of a node.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settlement: Option<[f64; 3]>,
}

/// Damping of the network as a whole.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Damping {
    /// Rayleigh damping.
    pub rayleigh: RayleighSpec,
}

/// Initial displacements and velocities of the nodes.
///
/// One vector acts on the free degrees of freedom only. A list with one vector per node may move supports too: a
/// support holds its node where the initial displacement puts it. A velocity at a held degree of freedom must be 0, or
/// that with which its support begins to move.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Initial {
    /// Where the run begins: the last state of another run on the same mesh, by its folder of results, or a frame of
    /// one (`{"frame": "x.vtu"}`). Paths count from the folder of the case. Time begins at 0 again; what is held
    /// stands still where it is then, unless its support moves. It replaces the displacement that the mesh itself
    /// starts with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<InitialFrom>,
    /// What springs keep of the run in `from`; not given: nothing but where their ends are. It stands in for the length
    /// of the edge on the mesh as given: rules with a `rest_length`, or a number as `rest_scale`, go on without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keep: Option<Keep>,
    /// [m] Displacement from the mesh as given; it adds to the displacement that the mesh itself starts with, and to
    /// `from`.
    pub displacement: Option<Vectors>,
    /// [m/s] Velocity; it adds to `from`.
    pub velocity: Option<Vectors>,
}

/// What springs keep of an earlier run, by the arrays of its frame; `static` writes both.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Keep {
    /// Prestress: each spring is cut so long that it has, where the run begins, the tension that its edge had there. So
    /// a form found by force densities carries its tensions as a net of real cables. Several springs at an edge share
    /// its tension by their stiffness. A spring without tension is as long as before, if it was slack, or as its edge.
    Tensions,
    /// Rest lengths: each spring is as long without tension as that of its edge was.
    RestLengths,
}

/// The folder of another run's results, or one of its frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum InitialFrom {
    /// a folder of results
    Folder(String),
    /// a frame
    Frame(FrameFile),
}

/// A frame of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrameFile {
    /// The .vtu file, or a .vtkhdf file, of which the last frame is taken.
    pub frame: String,
}

impl JsonSchema for InitialFrom {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "InitialFrom".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let frame = generator.subschema_for::<FrameFile>().to_value();
        json_schema!({"oneOf": [{"type": "string"}, frame]})
    }
}
