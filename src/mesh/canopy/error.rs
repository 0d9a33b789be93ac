//! Why parts of a mesh are no canopy.

use crate::MeshError;

/// The part of a canopy that is at fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CanopyPart {
    /// its triangles
    Triangles,
    /// its skirt
    Skirt,
    /// where its lines meet
    Confluence,
    /// what hangs on it
    Payload,
}

/// Why parts of a mesh are no canopy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CanopyError {
    /// Triangles that cannot be used.
    #[error(transparent)]
    Mesh(MeshError),
    /// Two neighbours turn opposite ways.
    #[error(
        "triangles {first} and {second} of the canopy share the edge {a}-{b} but turn opposite ways, so the pressure inside \
         has no side; turn all its triangles so that their normals point outwards"
    )]
    Orientation {
        /// first triangle
        first: u32,
        /// second triangle
        second: u32,
        /// nodes of the edge
        a: u32,
        /// nodes of the edge
        b: u32,
    },
    /// More than two triangles at an edge.
    #[error("{triangles} triangles of the canopy share the edge {a}-{b}; a sheet has at most two there")]
    Branching {
        /// nodes of the edge
        a: u32,
        /// nodes of the edge
        b: u32,
        /// triangles there
        triangles: usize,
    },
    /// Parts that nothing joins.
    #[error(
        "no edges lead from the skirt to node {node}; join the parts of a canopy by edges, such as radial tapes, or make \
         a canopy of each"
    )]
    Apart {
        /// a node that is not reached
        node: u32,
    },
    /// More vent than canopy.
    #[error(
        "the canopy's vents take {vent:.6} m^2 of {nominal:.6} m^2 of cloth, gaps and vents: it is more vent than canopy; \
         name as its skirt the lower edge, which is the outer one, or make the vent smaller"
    )]
    MoreVent {
        /// [m^2] area of the vents
        vent: f64,
        /// [m^2] nominal area
        nominal: f64,
    },
    /// The surface has no boundary.
    #[error("the canopy is a closed surface, which has no skirt; an open one has an outer boundary")]
    Closed,
    /// The triangles are several sheets, and nothing tells which boundary the skirt is.
    #[error("the canopy has {sheets} sheets; one outer boundary would be its skirt: name the nodes of the lowest one")]
    Sheets {
        /// their number
        sheets: usize,
    },
    /// The skirt's edges are no single closed loop.
    #[error(
        "the skirt is no closed loop: {edges} of its edges meet at node {node}, where there must be two; list every edge \
         along the canopy's lower boundary once"
    )]
    OpenSkirt {
        /// the node
        node: u32,
        /// skirt edges there
        edges: usize,
    },
    /// The skirt's edges are several loops, or none.
    #[error("the skirt is no single loop: from node {node} {found} of its {edges} edges are reached")]
    SeveralLoops {
        /// where the search began
        node: u32,
        /// edges of the loop there
        found: usize,
        /// edges of the skirt
        edges: usize,
    },
    /// A skirt edge is not at the boundary of the canopy.
    #[error(
        "the skirt's edge {a}-{b} is a side of {triangles} triangles of the canopy; the skirt is its boundary, so it must be one"
    )]
    NoBoundary {
        /// nodes of the edge
        a: u32,
        /// nodes of the edge
        b: u32,
        /// triangles there
        triangles: usize,
    },
    /// A node of the skirt is not on the loop of the others.
    #[error(
        "node {node} is not on one closed loop with the others: the nodes of a skirt are all on one loop of the canopy's \
         boundary"
    )]
    OffSkirt {
        /// the node
        node: u32,
    },
    /// A node where the lines meet is one of the canopy.
    #[error("the lines meet at node {node}, which is one of the canopy; they meet below it")]
    ConfluenceInCanopy {
        /// the node
        node: u32,
    },
    /// Apex and confluence coincide.
    #[error(
        "the canopy has no axis: its apex and the confluence of its lines are {distance:.3e} m apart; the axis leads from \
         one to the other, so start with the lines stretched and the confluence below the canopy"
    )]
    NoAxis {
        /// [m] distance
        distance: f64,
    },
    /// The payload does not hang on the canopy.
    #[error(
        "the payload has no line: nothing joins its node {node} to the canopy; add lines with springs from the skirt to it"
    )]
    LoosePayload {
        /// a node of the payload
        node: u32,
    },
}

impl CanopyError {
    /// The part that is at fault.
    pub fn part(&self) -> CanopyPart {
        match self {
            Self::Mesh(_) | Self::Orientation { .. } | Self::Branching { .. } => CanopyPart::Triangles,
            Self::Apart { .. } | Self::MoreVent { .. } | Self::Closed => CanopyPart::Triangles,
            Self::Sheets { .. } | Self::OpenSkirt { .. } | Self::SeveralLoops { .. } => CanopyPart::Skirt,
            Self::NoBoundary { .. } | Self::OffSkirt { .. } => CanopyPart::Skirt,
            Self::ConfluenceInCanopy { .. } | Self::NoAxis { .. } => CanopyPart::Confluence,
            Self::LoosePayload { .. } => CanopyPart::Payload,
        }
    }
}
