//! Membranes and bending.

use serde::Serialize;

/// Triangles that are a membrane of one material.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MembraneSpec {
    /// triangles, ascending
    pub triangles: Vec<u32>,
    /// [m] thickness t, > 0
    pub thickness: f64,
    /// [Pa] Young's moduli E1 along the warp and E2 across it, > 0
    pub modulus: [f64; 2],
    /// [-] Poisson's ratio nu12: contraction across the warp over stretch along it; nu12^2 E2/E1 < 1
    pub poisson: f64,
    /// [Pa] shear modulus G12, > 0; E/(2 (1 + nu)) of an isotropic sheet
    pub shear: f64,
    /// direction of the warp on the mesh as given, projected on every triangle; absent: that of its first side
    pub warp: Option<[f64; 3]>,
    /// whether it wrinkles in place of carrying compression
    pub wrinkling: bool,
    /// [s] time tau of stiffness damping, >= 0
    pub damping_time: f64,
    /// \[N/m\] its strength, for reports only
    #[serde(skip)]
    pub strength: Option<f64>,
}

/// Bending of the edges between triangles, and of chains of edges.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct BendingSpec {
    /// hinges: the ends of an edge between two triangles, and their third corners
    pub hinges: Vec<[u32; 4]>,
    /// [N m] bending stiffness B of the cloth at every hinge; those of several specifications add up
    pub stiffness: f64,
    /// chains: a node, between the two at the other ends of its edges
    pub chains: Vec<[u32; 3]>,
    /// [N m^2] bending stiffness EI of the line at every node
    pub flexural_rigidity: f64,
}
