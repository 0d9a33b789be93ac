//! Springs and membranes as Newton's iteration takes them when tensions and stresses are unknowns beside the positions
//! (`solve/mixed`).

use nalgebra::{Matrix3, Vector3};

/// A spring with its axial dashpot in a state.
#[derive(Clone, Copy, Debug)]
pub struct SpringState {
    /// its end nodes a and b
    pub nodes: [u32; 2],
    /// unit vector from a to b, zero for coincident nodes
    pub n: Vector3<f64>,
    /// [m] length
    pub length: f64,
    /// [N] tension that its law and its dashpot give
    pub tension: f64,
    /// [N] the same if it were taut
    pub taut: f64,
    /// [N/m] derivative of the taut tension by the length, where the rate of the length changes with it
    pub stiffness: f64,
    /// [N] tension below which it cannot fall; -inf for a spring that acts both ways
    pub least: f64,
}

impl SpringState {
    /// A spring that carries nothing.
    pub const fn idle(nodes: [u32; 2]) -> Self {
        let n = Vector3::new(0.0, 0.0, 0.0);
        SpringState { nodes, n, length: 0.0, tension: 0.0, taut: 0.0, stiffness: 0.0, least: f64::NEG_INFINITY }
    }

    /// Whether its tension is the larger of the taut one and a least one.
    pub fn is_one_sided(&self) -> bool {
        self.least > f64::NEG_INFINITY && self.stiffness > 0.0
    }
}

/// What a spring adds to the matrix of the iteration: `(tension/l)(I - n n^T) + stiffness n n^T`.
#[derive(Clone, Copy, Debug, Default)]
pub struct SpringTangent {
    /// [N] tension of the geometric part
    pub tension: f64,
    /// [N/m] stiffness along the spring
    pub stiffness: f64,
}

/// A membrane triangle with its damping in a state. Strains are those of its law: two along its axes, and the shear.
#[derive(Clone, Copy, Debug, Default)]
pub struct SheetState {
    /// its nodes
    pub nodes: [u32; 3],
    /// [m^2] area at rest
    pub area: f64,
    /// B_a, the derivatives of the strains by the position of every node: the force on one is -area B_a^T S
    pub by_node: [Matrix3<f64>; 3],
    /// S that its law and its damping give
    pub stress: Vector3<f64>,
    /// dS/dE, where the rate of the strain changes with it
    pub stiffness: Matrix3<f64>,
    /// displacement [m] across the triangle, over the stress
    pub flexibility: f64,
}
