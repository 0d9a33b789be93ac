//! Why pieces are not sewn; every message has advice.

/// Failures of sewing.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SewError {
    /// Outlines that stay lines cannot be sewn.
    #[error("outlines are sewn when they are filled with triangles: give \"edge\", the length of their edges")]
    Unfilled,
    /// A seam names a side that is not there.
    #[error("there is no side \"{name}\"; there are {known}")]
    NoSide {
        /// what was named
        name: String,
        /// what there is
        known: String,
    },
    /// A layer that should hold gores has no closed outline.
    #[error("layer \"{name}\" has no closed outline; there are {known}")]
    NoOutline {
        /// the layer
        name: String,
        /// layers with outlines
        known: String,
    },
    /// An outline that would be a hole of most of a gore.
    #[error(
        "a gore of layer \"{layer}\" has an outline inside it with {percent:.0} % of its area, which would be a hole; draw \
         the cut line and give \"allowance\", or draw the seam line alone"
    )]
    TwoOutlines {
        /// layer of the outer one
        layer: String,
        /// [%] of the area of the outer one
        percent: f64,
    },
    /// Both ends of an edge meet.
    #[error(
        "side \"{name}\" is sewn to itself by the seams around it, which run the wrong way round: sew the sides that \
         meet when one piece is laid on the other, or change \"reverse\""
    )]
    Collapsed {
        /// the side
        name: String,
    },
    /// Fewer than three gores go around no axis.
    #[error("{found} gores do not go around an axis: draw 3 or more, or use them several times by \"copies\"")]
    FewGores {
        /// number of gores
        found: usize,
    },
    /// The long sides of an outline cannot be told from the others.
    #[error(
        "outline {outline} of layer \"{layer}\" is no gore with 3 or 4 corners and two equal sides: it has {corners} \
         corners of more than {least:.0} degrees, and {sides}; draw open lines along its sides and name their layers \
         in \"edges\""
    )]
    NoGore {
        /// the layer
        layer: String,
        /// its number on this layer, from 1
        outline: usize,
        /// its corners
        corners: usize,
        /// [deg] angle from which a corner counts
        least: f64,
        /// sides with their lengths
        sides: String,
    },
    /// Lines that should name a side are not on one outline.
    #[error("{name}: its lines do not run along an outline in one piece, {why}; draw them on top of its points")]
    OffOutline {
        /// the layer
        name: String,
        /// what is wrong
        why: String,
    },
    /// Two sides have a part of an outline in common.
    #[error("sides \"{first}\" and \"{second}\" overlap; a part of an outline is in one seam")]
    Overlap {
        /// one of them
        first: String,
        /// the other one
        second: String,
    },
    /// The cloth outside a seam is wider than the piece allows.
    #[error(
        "an allowance of {width} m cannot be cut off side \"{name}\": at ({x:.6}, {y:.6}) m {why}; give less, or draw \
         the seam line itself"
    )]
    Allowance {
        /// the side
        name: String,
        /// [m] the allowance
        width: f64,
        /// [m] where
        x: f64,
        /// [m] where
        y: f64,
        /// what happens there
        why: &'static str,
    },
    /// Edges that are no chain.
    #[error("side \"{name}\" is {found}, but {wanted} {} wanted", if *wanted == 1 { "chain of edges is" } else { "chains of edges are" })]
    NoChain {
        /// the side
        name: String,
        /// what it is
        found: String,
        /// chains that the seam needs of it
        wanted: usize,
    },
    /// An edge within a piece, or one without a triangle.
    #[error("side \"{name}\" has the edge {a}-{b} of {triangles} triangles; the side of a piece has edges of one")]
    NoBoundary {
        /// the side
        name: String,
        /// one node
        a: u32,
        /// the other node
        b: u32,
        /// triangles at the edge
        triangles: usize,
    },
    /// Sides of unequal length.
    #[error(
        "sides \"{first}\" and \"{second}\" have {:.6} and {:.6} m, a difference of {:.1} %; \"ease\": true gathers \
         the longer one, else correct the outlines", lengths[0], lengths[1], 100.0 * excess
    )]
    Lengths {
        /// one side
        first: String,
        /// the other one
        second: String,
        /// [m] their lengths
        lengths: [f64; 2],
        /// [-] the longer one over the shorter one, less 1
        excess: f64,
    },
    /// Sides whose nodes are not at equal parts of their lengths.
    #[error(
        "sides \"{first}\" and \"{second}\" have {} and {} nodes, which are not at equal parts of their lengths; mesh \
         both with the same number of equal edges", nodes[0], nodes[1]
    )]
    Nodes {
        /// one side
        first: String,
        /// the other one
        second: String,
        /// nodes on them
        nodes: [usize; 2],
    },
    /// Both sides are on the same piece.
    #[error(
        "sides \"{first}\" and \"{second}\" are on the same piece; draw outlines apart, so that they do not touch, or cut \
         the piece in two"
    )]
    OntoItself {
        /// one side
        first: String,
        /// the other one
        second: String,
    },
    /// Pieces whose start in space is not known.
    #[error(
        "{pieces} pieces hang together by {links} pairs of neighbours. There is a start in space for rings of pieces, \
         each sewn to its two neighbours by one seam, and for pieces that close no ring; sew others in a CAD program"
    )]
    NoPlace {
        /// pieces that hang together
        pieces: usize,
        /// pairs of them that are sewn to each other
        links: usize,
    },
    /// A ring that closes upside down.
    #[error(
        "the pieces of a ring meet upside down where it closes, as a Moebius strip; change \"reverse\" of one seam"
    )]
    Twisted,
    /// Gores whose seams do not run from end to end.
    #[error("the seams of piece {piece} of a ring run back and forth along it; draw its seams from end to end")]
    Folded {
        /// its place in the ring, from 1
        piece: usize,
    },
    /// Suspension lines that do not reach the axis.
    #[error(
        "lines of {length} m do not reach the axis: the skirt's corners are {radius:.6} m from it; take longer lines"
    )]
    ShortLines {
        /// [m] their length
        length: f64,
        /// [m] from the axis
        radius: f64,
    },
}
