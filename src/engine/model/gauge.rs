//! What gauges measure, where, and in which columns: names, units, peaks and lines of reports stand here once.

mod column;

pub use column::{PeakRule, Quantity, ReportLine};

use serde::{Deserialize, Serialize};

/// A vector quantity of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum NodeQuantity {
    /// [m] position
    Position,
    /// [m] displacement from the mesh as given
    Displacement,
    /// [m/s] velocity
    Velocity,
    /// [m/s^2] acceleration, 0 in held directions
    Acceleration,
    /// [N] net force, 0 in held directions
    Force,
    /// [N] reaction of the support, 0 in free directions
    Reaction,
}

/// What a gauge measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum GaugeQuantity {
    /// Tension of the springs on the selected edges with their axial dashpots, N: `tension_sum`, `tension_max`.
    Tension,
    /// Net force on the selected nodes, N: the sum `force_x`, `force_y`, `force_z` with its size `force_total`, and the
    /// largest on a node `force_max`.
    Force,
    /// Reaction of the supports on the selected nodes, N, their own weight included: the sum `reaction_x`,
    /// `reaction_y`, `reaction_z` with its size `reaction_total`, and the largest on a node `reaction_max`.
    Reaction,
    /// Acceleration of the selected nodes, m/s^2: the mean `acceleration_x`, `acceleration_y`, `acceleration_z` and the
    /// largest `acceleration_max`.
    Acceleration,
    /// Velocity of the selected nodes, m/s: the mean `velocity_x`, `velocity_y`, `velocity_z`.
    Velocity,
    /// Speed of the selected nodes, m/s: `speed_mean`, `speed_max`.
    Speed,
    /// Distance of the selected nodes from where they are on the mesh as given, m: `displacement_mean`,
    /// `displacement_max`.
    Displacement,
    /// Position of the selected nodes, m: the mean `position_x`, `position_y`, `position_z`.
    Position,
    /// Number of edges of cloth that pass through triangles of cloth, `crossings`, where all nodes of the edge or of
    /// the triangle are selected.
    Crossings,
    /// Larger principal stress of the membranes on the selected triangles, Pa: `stress_max` and the mean over their
    /// area `stress_mean`. Force per width over the thickness at rest.
    Stress,
    /// Larger principal strain of the membranes on the selected triangles, elongation over rest length: `strain_max`
    /// and the mean over their area `strain_mean`.
    Strain,
    /// Shares of the area of the membranes on the selected triangles: `taut_share`, `wrinkled_share`, `slack_share`.
    Wrinkling,
    /// Gas that the selected triangles are around: its pressure above the ambient one, Pa, `gas_pressure`, and its
    /// volume, m^3, `gas_volume`. They are triangles of one gas only.
    Gas,
    /// Force, N, of the first side of the contact on the second one, such as the load on an obstacle: `contact_x`,
    /// `contact_y`, `contact_z` with its size `contact_total`, and the sum of the pressures of all pairs that touch,
    /// `contact_pressure`. The force is 0 for a contact with itself.
    Contact,
}

impl GaugeQuantity {
    /// Where and how it is measured.
    pub fn kind(self) -> GaugeKind {
        match self {
            GaugeQuantity::Tension => GaugeKind::Springs(SpringGauge::Tension),
            GaugeQuantity::Force => GaugeKind::Nodes(NodeGauge::FORCE),
            GaugeQuantity::Reaction => GaugeKind::Nodes(NodeGauge::REACTION),
            GaugeQuantity::Acceleration => GaugeKind::Nodes(NodeGauge::ACCELERATION),
            GaugeQuantity::Velocity => GaugeKind::Nodes(NodeGauge::VELOCITY),
            GaugeQuantity::Speed => GaugeKind::Nodes(NodeGauge::SPEED),
            GaugeQuantity::Displacement => GaugeKind::Nodes(NodeGauge::DISPLACEMENT),
            GaugeQuantity::Position => GaugeKind::Nodes(NodeGauge::POSITION),
            GaugeQuantity::Crossings => GaugeKind::Cloth,
            GaugeQuantity::Stress => GaugeKind::Membranes(MembraneGauge::Stress),
            GaugeQuantity::Strain => GaugeKind::Membranes(MembraneGauge::Strain),
            GaugeQuantity::Wrinkling => GaugeKind::Membranes(MembraneGauge::Wrinkling),
            GaugeQuantity::Gas => GaugeKind::Gas,
            GaugeQuantity::Contact => GaugeKind::Contact,
        }
    }

    /// All of them.
    pub const ALL: [Self; 14] = [
        Self::Tension,
        Self::Force,
        Self::Reaction,
        Self::Acceleration,
        Self::Velocity,
        Self::Speed,
        Self::Displacement,
        Self::Position,
        Self::Crossings,
        Self::Stress,
        Self::Strain,
        Self::Wrinkling,
        Self::Gas,
        Self::Contact,
    ];

    /// Its columns.
    pub fn columns(self) -> &'static [Quantity] {
        match self.kind() {
            GaugeKind::Springs(of) => of.columns().all(),
            GaugeKind::Nodes(of) => of.columns.all(),
            GaugeKind::Cloth => &[CROSSINGS],
            GaugeKind::Membranes(of) => of.columns(),
            GaugeKind::Gas => &GAS_QUANTITIES,
            GaugeKind::Contact => &CONTACT_QUANTITIES,
        }
    }
}

/// Where a gauge measures, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GaugeKind {
    /// on springs
    Springs(SpringGauge),
    /// on nodes
    Nodes(NodeGauge),
    /// on cloth between nodes, whose crossings are counted
    Cloth,
    /// on membrane triangles
    Membranes(MembraneGauge),
    /// on a gas
    Gas,
    /// on the sides of a contact
    Contact,
}

/// What a gauge measures on membrane triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum MembraneGauge {
    /// [Pa] larger principal stress
    Stress,
    /// [-] larger principal strain, elongation over rest length
    Strain,
    /// [-] shares of the area
    Wrinkling,
}

impl MembraneGauge {
    /// The largest value and the mean, or the shares that are taut, wrinkled and slack.
    pub const fn columns(self) -> &'static [Quantity] {
        const STRESS: [Quantity; 2] = [STRESS_MAX, Quantity::of("stress_mean", "Pa").called("mean stress")];
        const STRAIN: [Quantity; 2] = [
            Quantity::of("strain_max", "-").called("largest strain").in_report(ReportLine::Peak("strain")),
            Quantity::of("strain_mean", "-").called("mean strain"),
        ];
        const SHARES: [Quantity; 3] = [
            Quantity::of("taut_share", "-").called("taut share of the area"),
            Quantity::of("wrinkled_share", "-")
                .called("wrinkled share of the area")
                .in_report(ReportLine::Told("wrinkled share")),
            Quantity::of("slack_share", "-").called("slack share of the area"),
        ];
        match self {
            MembraneGauge::Stress => &STRESS,
            MembraneGauge::Strain => &STRAIN,
            MembraneGauge::Wrinkling => &SHARES,
        }
    }
}

/// What a gauge measures on springs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum SpringGauge {
    /// \[N\] tension with the axial dashpot
    Tension,
}

impl SpringGauge {
    /// What is made of its values.
    pub const fn columns(self) -> SpringColumns {
        const TENSION: [Quantity; 2] = [Quantity::of("tension_sum", "N").called("sum of tensions"), TENSION_MAX];
        match self {
            SpringGauge::Tension => SpringColumns::SumAndLargest(&TENSION),
        }
    }
}

/// What is made of the values of several springs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum SpringColumns {
    /// the sum and the largest
    SumAndLargest(&'static [Quantity; 2]),
}

impl SpringColumns {
    /// The columns.
    pub fn all(self) -> &'static [Quantity] {
        match self {
            SpringColumns::SumAndLargest(columns) => columns,
        }
    }
}

/// What a gauge measures on nodes: a vector of each, and what is made of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct NodeGauge {
    /// the vector
    pub vector: NodeQuantity,
    /// what is made of the vectors
    pub columns: NodeColumns,
}

/// What is made of the vectors of several nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum NodeColumns {
    /// the sum, its size, and the largest size
    Sum(&'static [Quantity; 5]),
    /// the mean
    Mean(&'static [Quantity; 3]),
    /// the mean and the largest size
    MeanAndLargest(&'static [Quantity; 4]),
    /// the mean size and the largest one
    Sizes(&'static [Quantity; 2]),
}

impl NodeGauge {
    /// [N] net force
    pub const FORCE: Self = Self {
        vector: NodeQuantity::Force,
        columns: NodeColumns::Sum(&[
            Quantity::signed("force_x", "N").called("force along x"),
            Quantity::signed("force_y", "N").called("force along y"),
            Quantity::signed("force_z", "N").called("force along z"),
            Quantity::of("force_total", "N").called("force").in_report(ReportLine::Peak("force")),
            Quantity::of("force_max", "N").called("largest force on a node"),
        ]),
    };
    /// [N] reaction of the supports
    pub const REACTION: Self = Self {
        vector: NodeQuantity::Reaction,
        columns: NodeColumns::Sum(&[
            Quantity::signed("reaction_x", "N").called("reaction along x"),
            Quantity::signed("reaction_y", "N").called("reaction along y"),
            Quantity::signed("reaction_z", "N").called("reaction along z"),
            REACTION_TOTAL,
            REACTION_MAX,
        ]),
    };
    /// [m/s^2] acceleration
    pub const ACCELERATION: Self = Self {
        vector: NodeQuantity::Acceleration,
        columns: NodeColumns::MeanAndLargest(&[
            Quantity::signed("acceleration_x", "m/s^2").called("acceleration along x"),
            Quantity::signed("acceleration_y", "m/s^2").called("acceleration along y"),
            Quantity::signed("acceleration_z", "m/s^2").called("acceleration along z"),
            Quantity::of("acceleration_max", "m/s^2")
                .called("largest acceleration")
                .in_report(ReportLine::Peak("acceleration")),
        ]),
    };
    /// [m/s] velocity
    pub const VELOCITY: Self = Self {
        vector: NodeQuantity::Velocity,
        columns: NodeColumns::Mean(&[
            Quantity::signed("velocity_x", "m/s")
                .called("velocity along x")
                .in_report(ReportLine::Told("velocity along x")),
            Quantity::signed("velocity_y", "m/s")
                .called("velocity along y")
                .in_report(ReportLine::Told("velocity along y")),
            Quantity::signed("velocity_z", "m/s")
                .called("velocity along z")
                .in_report(ReportLine::Told("velocity along z")),
        ]),
    };
    /// [m/s] size of the velocity
    pub const SPEED: Self = Self {
        vector: NodeQuantity::Velocity,
        columns: NodeColumns::Sizes(&[
            Quantity::of("speed_mean", "m/s").called("mean speed"),
            Quantity::of("speed_max", "m/s").called("largest speed").in_report(ReportLine::Told("speed")),
        ]),
    };
    /// [m] distance from the place on the mesh as given
    pub const DISPLACEMENT: Self = Self {
        vector: NodeQuantity::Displacement,
        columns: NodeColumns::Sizes(&[
            Quantity::of("displacement_mean", "m").called("mean displacement"),
            Quantity::of("displacement_max", "m")
                .called("largest displacement")
                .in_report(ReportLine::Told("displacement")),
        ]),
    };
    /// [m] position
    pub const POSITION: Self = Self {
        vector: NodeQuantity::Position,
        columns: NodeColumns::Mean(&[
            Quantity::signed("position_x", "m")
                .called("position along x")
                .in_report(ReportLine::Told("position along x")),
            Quantity::signed("position_y", "m")
                .called("position along y")
                .in_report(ReportLine::Told("position along y")),
            Quantity::signed("position_z", "m")
                .called("position along z")
                .in_report(ReportLine::Told("position along z")),
        ]),
    };
}

impl NodeColumns {
    /// The columns.
    pub fn all(self) -> &'static [Quantity] {
        match self {
            NodeColumns::Sum(columns) => columns,
            NodeColumns::Mean(columns) => columns,
            NodeColumns::MeanAndLargest(columns) => columns,
            NodeColumns::Sizes(columns) => columns,
        }
    }
}

/// [N] Largest tension of a spring.
pub const TENSION_MAX: Quantity =
    Quantity::of("tension_max", "N").called("largest tension").in_report(ReportLine::Peak("tension"));
/// [Pa] Largest stress of a membrane.
pub const STRESS_MAX: Quantity =
    Quantity::of("stress_max", "Pa").called("largest stress").in_report(ReportLine::Peak("stress"));
/// [N] Size of the sum of reactions.
pub const REACTION_TOTAL: Quantity =
    Quantity::of("reaction_total", "N").called("reaction").in_report(ReportLine::Peak("reaction"));
/// [N] Largest reaction on a node.
pub const REACTION_MAX: Quantity = Quantity::of("reaction_max", "N").called("largest reaction of a node");
/// Edges of cloth that pass through triangles.
pub const CROSSINGS: Quantity =
    Quantity::of("crossings", "-").called("crossings of cloth").in_report(ReportLine::Told("crossings"));

/// What a gas shows of itself, in the order of [`gas_values`](super::abilities::Air::gas_values): \[Pa\] pressure above
/// the ambient one, \[m^3\] volume.
pub const GAS_QUANTITIES: [Quantity; 2] = [
    Quantity::signed("gas_pressure", "Pa").in_report(ReportLine::Told("gas pressure")),
    Quantity::of("gas_volume", "m^3").in_report(ReportLine::Told("gas volume")),
];

/// What the first side of a contact does to the second one: \[N\] the force and its size, the sum of pressures.
pub const CONTACT_QUANTITIES: [Quantity; 5] = [
    Quantity::signed("contact_x", "N").called("force of contact along x"),
    Quantity::signed("contact_y", "N").called("force of contact along y"),
    Quantity::signed("contact_z", "N").called("force of contact along z"),
    Quantity::of("contact_total", "N").called("force of contact").in_report(ReportLine::Peak("force")),
    Quantity::of("contact_pressure", "N").called("pressure of contact").in_report(ReportLine::Peak("pressure")),
];

/// [m] Diameter of a circle with the area that a canopy and its openings show along its axis.
pub const PROJECTED_DIAMETER: Quantity = Quantity::of("projected_diameter", "m");
/// [m/s] Speed of a canopy against the air along its axis.
pub const AXIAL_SPEED: Quantity =
    Quantity::signed("axial_speed", "m/s").called("speed against the air").in_report(ReportLine::Descent);
/// [Pa] rho V |V|/2.
pub const DYNAMIC_PRESSURE: Quantity = Quantity::signed("dynamic_pressure", "Pa");
/// [m^2] Drag over the dynamic pressure.
pub const DRAG_AREA: Quantity = Quantity::of("drag_area", "m^2");
/// [N] Force of the air on a canopy against its motion along its axis.
pub const DRAG: Quantity = Quantity::of("drag", "N").in_report(ReportLine::Drag);
/// [-] Projected diameter over D0.
pub const PROJECTED_RATIO: Quantity = Quantity::of("projected_ratio", "-")
    .called("projected diameter over D0, Dp/D0")
    .in_report(ReportLine::Ratio { symbol: "Dp/D0", of: "" });
/// [-] Drag over the dynamic pressure and S0.
pub const DRAG_COEFFICIENT: Quantity = Quantity::signed("drag_coefficient", "-")
    .called("drag coefficient CD0")
    .in_report(ReportLine::Ratio { symbol: "CD0", of: " on S0" });
/// \[deg\] Angle between the axis of a canopy and its motion through the air.
pub const ANGLE_OF_ATTACK: Quantity = Quantity::of("angle_of_attack", "deg");

/// What a canopy shows of itself, in the order of
/// [`canopy_values`](super::abilities::Air::canopy_values).
pub const CANOPY_QUANTITIES: [Quantity; 11] = [
    PROJECTED_DIAMETER,
    Quantity::of("skirt_diameter", "m"),
    Quantity::of("volume", "m^3"),
    AXIAL_SPEED,
    DYNAMIC_PRESSURE,
    DRAG_AREA,
    DRAG,
    Quantity::signed("pressure", "Pa").called("mean pressure"),
    PROJECTED_RATIO,
    DRAG_COEFFICIENT,
    ANGLE_OF_ATTACK,
];
