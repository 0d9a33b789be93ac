//! Why a scene cannot be built, and checks of single values.

use crate::model::spec::Series;

/// Why a scene cannot be built from a specification. The case reader finds these faults first, with more precise
/// messages; a library user may not.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum BuildError {
    /// A list does not have one entry per node, or per spring of its group.
    #[error("{what}: {found} entries where {expected} are needed")]
    Length {
        /// which list
        what: &'static str,
        /// its length
        found: usize,
        /// what it should be
        expected: usize,
    },
    /// A node, edge or triangle number is too large.
    #[error("{what} {index} does not exist; there are {count}")]
    Index {
        /// node, edge or triangle
        what: &'static str,
        /// the number
        index: u32,
        /// how many there are
        count: usize,
    },
    /// A free node without mass cannot be accelerated.
    #[error("node {node} is free and has the mass {mass} kg; a free node needs a positive finite mass")]
    Mass {
        /// user's number
        node: u32,
        /// [kg] its mass
        mass: f64,
    },
    /// Mass scaling that adds nothing.
    #[error(
        "mass scaling for steps of {step} s adds nothing: no node needs more than {needed:.3} of its mass for them; leave time.mass_scaling out"
    )]
    NothingToScale {
        /// [s] the step that is wanted
        step: f64,
        /// [-] largest share of a node's mass that is needed
        needed: f64,
    },
    /// Nothing is free at any time, or moved.
    #[error("the scene has no free degree of freedom")]
    NothingFree,
    /// A value is not a finite number.
    #[error("{what} {index} is not a finite number")]
    NotFinite {
        /// which list, or which value
        what: &'static str,
        /// index in its list; for nodal values the node
        index: usize,
    },
    /// A spring without a rest length, whose law depends on the strain.
    #[error("spring {spring} of its group has no rest length, which its law needs")]
    NoRestLength {
        /// place in its group
        spring: usize,
    },
    /// A material that no sheet has.
    #[error(
        "a membrane with the moduli {} and {} Pa, a Poisson's ratio of {poisson} and a shear modulus of {shear} Pa: thickness and \
         moduli must be above 0, the damping time not below, and poisson^2 E2 below E1",
        modulus[0],
        modulus[1]
    )]
    Membrane {
        /// [Pa] E1 and E2
        modulus: [f64; 2],
        /// [-] nu12
        poisson: f64,
        /// [Pa] G12
        shear: f64,
    },
    /// A triangle of a membrane without an area, or at right angles to the warp.
    #[error("triangle {triangle} of a membrane has no area, or the warp direction is at right angles to it")]
    RestShape {
        /// its number
        triangle: u32,
    },
    /// A hinge of a triangle without an area, or a chain with a segment of no length.
    #[error("bending between nodes {} and {}: a triangle has no area, or a segment no length", ends[0], ends[1])]
    Hinge {
        /// the first nodes
        ends: [u32; 2],
    },
    /// A table over time without rows, without one value per time, or with times that do not increase.
    #[error("the table of the {what} {reason}")]
    Table {
        /// what it is a table of
        what: &'static str,
        /// what is wrong with it
        reason: &'static str,
    },
    /// A gas without a volume, or with values that no gas has.
    #[error("the gas {reason}")]
    Gas {
        /// what it lacks
        reason: &'static str,
    },
    /// A volume of gas that is open at a rim which moves.
    #[error(
        "the volume of gas is open at node {node}, which can move: close the surface, or hold its rim in x, y and z"
    )]
    OpenGas {
        /// user's number
        node: u32,
    },
    /// Canopies, zones or drag without air.
    #[error("canopies, zones of surfaces and drag need a stream")]
    NoStream,
    /// A canopy without nodes that it needs.
    #[error("a canopy has no node of its {what}")]
    NoNodes {
        /// skirt, apex or confluence
        what: &'static str,
    },
    /// The skirt of a canopy with a balance or a loss at its mouth is not on one closed loop of its boundary.
    #[error(
        "the mouth of a canopy needs one closed loop of the boundary with the nodes of the skirt; there are {loops}"
    )]
    Mouth {
        /// how many loops have some of its nodes
        loops: usize,
    },
    /// The mouth of such a canopy has no area at the start.
    #[error("the mouth of the canopy has no area at the start")]
    ClosedMouth,
    /// A canopy whose drag area grows in no stage.
    #[error("a canopy that fills needs at least one stage")]
    NoStage,
    /// A coefficient of a cavity without a meaning.
    #[error("a cavity {reason}")]
    Cavity {
        /// what is wrong
        reason: &'static str,
    },
    /// A glide without a meaning.
    #[error("a glide {reason}")]
    Glide {
        /// what is wrong
        reason: &'static str,
    },
    /// A canopy that cannot fill ring by ring.
    #[error("a canopy that fills ring by ring {reason}{}", at_row(*row))]
    Rings {
        /// which row of its cloth, from the vent or apex (0) on
        row: Option<usize>,
        /// what is wrong
        reason: &'static str,
    },
    /// A motion of what is not held.
    #[error("node {node} is moved along {axis} and not held there")]
    NotHeld {
        /// user's number
        node: u32,
        /// x, y or z
        axis: char,
    },
    /// A support has a velocity.
    #[error("node {node} is held along {axis} and has a velocity there; what is held stands still or has a motion")]
    MovingSupport {
        /// user's number
        node: u32,
        /// x, y or z
        axis: char,
    },
}

pub(super) fn length(what: &'static str, found: usize, expected: usize) -> Result<(), BuildError> {
    if found == expected { Ok(()) } else { Err(BuildError::Length { what, found, expected }) }
}

pub(super) fn below(what: &'static str, indices: &[u32], count: usize) -> Result<(), BuildError> {
    match indices.iter().find(|&&i| i as usize >= count) {
        None => Ok(()),
        Some(&index) => Err(BuildError::Index { what, index, count }),
    }
}

pub(super) fn finite(what: &'static str, values: &[f64]) -> Result<(), BuildError> {
    vectors(what, bytemuck::cast_slice::<_, [f64; 1]>(values))
}

/// The same for vectors.
pub(super) fn vectors<const N: usize>(what: &'static str, values: &[[f64; N]]) -> Result<(), BuildError> {
    match values.iter().position(|value| !value.iter().all(|c| c.is_finite())) {
        None => Ok(()),
        Some(index) => Err(BuildError::NotFinite { what, index }),
    }
}

pub(super) fn times<T>(what: &'static str, table: &Series<T>) -> Result<(), BuildError> {
    let refuse = |reason| Err(BuildError::Table { what, reason });
    if table.t.is_empty() {
        return refuse("has no rows");
    }
    if table.value.len() != table.t.len() {
        return refuse("has not one value a time");
    }
    if !table.t.iter().all(|t| t.is_finite()) || table.t.windows(2).any(|pair| pair[1] <= pair[0]) {
        return refuse("has times that do not increase");
    }
    Ok(())
}

fn at_row(row: Option<usize>) -> String {
    row.map(|row| format!(" (row {row}, counted from the vent or apex)")).unwrap_or_default()
}
