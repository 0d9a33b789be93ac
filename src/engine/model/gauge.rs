//! What gauges measure, where, and in which columns: names, units, peaks and lines of reports stand here once.

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
        const TENSION: [Quantity; 2] = [Quantity::of("tension_sum", "N"), TENSION_MAX];
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
            Quantity::signed("force_x", "N"),
            Quantity::signed("force_y", "N"),
            Quantity::signed("force_z", "N"),
            Quantity::of("force_total", "N").in_report(ReportLine::Peak("force")),
            Quantity::of("force_max", "N"),
        ]),
    };
    /// [N] reaction of the supports
    pub const REACTION: Self = Self {
        vector: NodeQuantity::Reaction,
        columns: NodeColumns::Sum(&[
            Quantity::signed("reaction_x", "N"),
            Quantity::signed("reaction_y", "N"),
            Quantity::signed("reaction_z", "N"),
            REACTION_TOTAL,
            REACTION_MAX,
        ]),
    };
    /// [m/s^2] acceleration
    pub const ACCELERATION: Self = Self {
        vector: NodeQuantity::Acceleration,
        columns: NodeColumns::MeanAndLargest(&[
            Quantity::signed("acceleration_x", "m/s^2"),
            Quantity::signed("acceleration_y", "m/s^2"),
            Quantity::signed("acceleration_z", "m/s^2"),
            Quantity::of("acceleration_max", "m/s^2").in_report(ReportLine::Peak("acceleration")),
        ]),
    };
    /// [m/s] velocity
    pub const VELOCITY: Self = Self {
        vector: NodeQuantity::Velocity,
        columns: NodeColumns::Mean(&[
            Quantity::signed("velocity_x", "m/s"),
            Quantity::signed("velocity_y", "m/s"),
            Quantity::signed("velocity_z", "m/s"),
        ]),
    };
    /// [m/s] size of the velocity
    pub const SPEED: Self = Self {
        vector: NodeQuantity::Velocity,
        columns: NodeColumns::Sizes(&[Quantity::of("speed_mean", "m/s"), Quantity::of("speed_max", "m/s")]),
    };
    /// [m] distance from the place on the mesh as given
    pub const DISPLACEMENT: Self = Self {
        vector: NodeQuantity::Displacement,
        columns: NodeColumns::Sizes(&[Quantity::of("displacement_mean", "m"), Quantity::of("displacement_max", "m")]),
    };
    /// [m] position
    pub const POSITION: Self = Self {
        vector: NodeQuantity::Position,
        columns: NodeColumns::Mean(&[
            Quantity::signed("position_x", "m"),
            Quantity::signed("position_y", "m"),
            Quantity::signed("position_z", "m"),
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

/// A column of values of a gauge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Quantity {
    /// its name in `gauges.csv` and `summary.json`
    pub name: &'static str,
    /// its unit
    #[serde(skip)]
    pub unit: &'static str,
    /// which of its values is its peak
    #[serde(skip)]
    pub peak: PeakRule,
    /// its line in the report of a run, if it has one
    #[serde(skip)]
    pub line: Option<ReportLine>,
}

/// Which value of a quantity is its peak.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PeakRule {
    /// the largest
    Largest,
    /// that of the largest magnitude, as of components
    LargestMagnitude,
}

/// A line of the report of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReportLine {
    /// the peak, with a word for what it is
    Peak(&'static str),
    /// the peak of a canopy's drag
    Drag,
    /// the speed of a canopy at the end
    Descent,
    /// a ratio at the end
    Ratio {
        /// its symbol
        symbol: &'static str,
        /// what follows its value
        of: &'static str,
    },
}

impl Quantity {
    /// A quantity whose peak is its largest value.
    pub const fn of(name: &'static str, unit: &'static str) -> Self {
        Quantity { name, unit, peak: PeakRule::Largest, line: None }
    }

    /// A quantity whose peak is the value of the largest magnitude.
    pub const fn signed(name: &'static str, unit: &'static str) -> Self {
        Quantity { peak: PeakRule::LargestMagnitude, ..Self::of(name, unit) }
    }

    const fn in_report(self, line: ReportLine) -> Self {
        Quantity { line: Some(line), ..self }
    }
}

/// [N] Largest tension of a spring.
pub const TENSION_MAX: Quantity = Quantity::of("tension_max", "N").in_report(ReportLine::Peak("tension"));
/// [N] Size of the sum of reactions.
pub const REACTION_TOTAL: Quantity = Quantity::of("reaction_total", "N").in_report(ReportLine::Peak("reaction"));
/// [N] Largest reaction on a node.
pub const REACTION_MAX: Quantity = Quantity::of("reaction_max", "N");
/// Edges of cloth that pass through triangles.
pub const CROSSINGS: Quantity = Quantity::of("crossings", "-");

/// [m] Diameter of a circle with the area that a canopy and its openings show along its axis.
pub const PROJECTED_DIAMETER: Quantity = Quantity::of("projected_diameter", "m");
/// [m/s] Speed of a canopy against the air along its axis.
pub const AXIAL_SPEED: Quantity = Quantity::signed("axial_speed", "m/s").in_report(ReportLine::Descent);
/// [Pa] rho V |V|/2.
pub const DYNAMIC_PRESSURE: Quantity = Quantity::signed("dynamic_pressure", "Pa");
/// [m^2] Drag over the dynamic pressure.
pub const DRAG_AREA: Quantity = Quantity::of("drag_area", "m^2");
/// [N] Force of the air on a canopy against its motion along its axis.
pub const DRAG: Quantity = Quantity::of("drag", "N").in_report(ReportLine::Drag);
/// [-] Projected diameter over D0.
pub const PROJECTED_RATIO: Quantity =
    Quantity::of("projected_ratio", "-").in_report(ReportLine::Ratio { symbol: "Dp/D0", of: "" });
/// [-] Drag over the dynamic pressure and S0.
pub const DRAG_COEFFICIENT: Quantity =
    Quantity::signed("drag_coefficient", "-").in_report(ReportLine::Ratio { symbol: "CD0", of: " on S0" });
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
    Quantity::signed("pressure", "Pa"),
    PROJECTED_RATIO,
    DRAG_COEFFICIENT,
    ANGLE_OF_ATTACK,
];
