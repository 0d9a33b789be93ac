//! Contact: which parts of a scene may touch each other or an obstacle.

use super::Series;
use serde::Serialize;

/// Two sides that may touch. What shares a node never does.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContactSpec {
    /// nodes, lines and cloth of the scene
    pub parts: ContactParts,
    /// what they may touch
    pub other: ContactSide,
    /// [m] distance below which they push each other apart, above 0
    pub gap: f64,
    /// [-] Coulomb's coefficient of friction, at least 0
    pub friction: f64,
}

/// The other side of a contact.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum ContactSide {
    /// the same parts: contact of cloth and lines with themselves
    Itself,
    /// other parts, which may have elements in common with the first ones
    Parts(ContactParts),
    /// a rigid body
    Obstacle(ObstacleSpec),
}

/// Parts of the mesh. No node is given for itself if it is in one of the elements, and no edge that is a side of one of
/// the triangles.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ContactParts {
    /// triangles of the mesh, ascending
    pub triangles: Vec<u32>,
    /// edges of the mesh that are lines, ascending
    pub edges: Vec<u32>,
    /// nodes that are points, ascending
    pub nodes: Vec<u32>,
}

/// A rigid body that nothing moves but its table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObstacleSpec {
    /// where it is without its motion
    pub shape: ObstacleShape,
    /// [m] its displacement over time, if it moves
    pub motion: Option<Series<[f64; 3]>>,
}

/// The shape of an obstacle; lengths in metres.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum ObstacleShape {
    /// a half-space
    Plane {
        /// a point on its surface
        point: [f64; 3],
        /// the unit vector that points out of it
        normal: [f64; 3],
    },
    /// a ball
    Sphere {
        /// its centre
        center: [f64; 3],
        /// above 0
        radius: f64,
    },
    /// a round bar with half a ball at either end
    Cylinder {
        /// the ends of its axis, before the half balls
        from: [f64; 3],
        /// another point than `from`
        to: [f64; 3],
        /// above 0
        radius: f64,
    },
    /// a box with its sides along the axes
    Box {
        /// its corner with the smallest coordinates
        min: [f64; 3],
        /// its corner with the largest coordinates
        max: [f64; 3],
    },
    /// a closed surface of triangles
    Surface {
        /// its corners
        nodes: Vec<[f64; 3]>,
        /// right-handed about the outer normal
        triangles: Vec<[u32; 3]>,
    },
}
