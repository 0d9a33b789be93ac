//! Parameters of the annulus and the disc, the two domains of the graded generator.

use super::layout::GradedRequest;
use super::sdf::Ring;
use super::source::{FaultSink, MAX_NODES, check_count, check_length};
use super::{Mesh, MeshError, distmesh};
use serde::{Deserialize, Serialize};

/// [-] allowed range of `grading`
pub const GRADING_RANGE: [f64; 2] = [0.2, 10.0];
/// [-] largest number of seams; more would need more loop nodes than a real canopy has
pub const MAX_SEAMS: usize = 10_000;
/// [-] largest number of seams of a disc; with more, angles at its centre would be below 22 degrees
pub const MAX_DISC_SEAMS: usize = 16;

/// A flat ring around the origin, meshed with triangles that grow with the distance from its edges.
///
/// The loops' nodes come first (inner loop, then outer loop, each counter-clockwise from the +x axis), then the
/// seams' nodes from the inside out, seam by seam, then the interior.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct AnnulusParameters {
    /// [m] radius of the hole, above 0
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub inner_radius: f64,
    /// [m] radius of the outer edge, above `inner_radius`
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub outer_radius: f64,
    /// [-] number of nodes, met exactly
    #[cfg_attr(feature = "schema", schemars(range(min = 7)))]
    pub nodes: usize,
    /// [-] number of nodes on both loops together, met exactly; derived from `nodes` and `grading` if absent
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 6)))]
    pub boundary_nodes: Option<usize>,
    /// [-] number of radial lines of edges from the inner to the outer loop, evenly spread from the +x axis; none if
    /// absent
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seams: Option<usize>,
    /// [-] seed of the pseudo-random numbers; the same seed gives the same mesh
    #[serde(default = "default_seed")]
    pub seed: u64,
    /// [-] ratio of the wanted edge length in the middle to that at the edges. If absent it is the one at which
    /// `nodes` and `boundary_nodes` agree; 1.5 if `boundary_nodes` is absent too
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.2, max = 10.0)))]
    pub grading: Option<f64>,
}

/// A flat disc around the origin, meshed with triangles that grow with the distance from its edge.
///
/// The loop's nodes come first (counter-clockwise from the +x axis), then, with seams, the centre and the seams'
/// nodes from the inside out, seam by seam, then the interior.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DiscParameters {
    /// [m] radius of the edge, above 0
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub radius: f64,
    /// [-] number of nodes, met exactly
    #[cfg_attr(feature = "schema", schemars(range(min = 4)))]
    pub nodes: usize,
    /// [-] number of nodes on the edge, met exactly; derived from `nodes` and `grading` if absent
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 3)))]
    pub boundary_nodes: Option<usize>,
    /// [-] number of radial lines of edges from the centre to the edge, evenly spread from the +x axis; at most 16,
    /// none if absent
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seams: Option<usize>,
    /// [-] seed of the pseudo-random numbers; the same seed gives the same mesh
    #[serde(default = "default_seed")]
    pub seed: u64,
    /// [-] ratio of the wanted edge length in the middle to that at the edge. If absent it is the one at which
    /// `nodes` and `boundary_nodes` agree; 1.5 if `boundary_nodes` is absent too
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.2, max = 10.0)))]
    pub grading: Option<f64>,
}

fn default_seed() -> u64 {
    1
}

impl AnnulusParameters {
    /// Reports every value out of range; `at` is the JSON pointer of this section.
    pub fn check(&self, at: &str, faults: FaultSink<'_>) {
        check_length(at, "inner_radius", self.inner_radius, faults);
        check_length(at, "outer_radius", self.outer_radius, faults);
        // A thinner ring would need more nodes than MAX_NODES for good triangles.
        if self.outer_radius.is_finite() && self.inner_radius > self.outer_radius * (1.0 - 1e-6) {
            let allowed = format!("below outer_radius = {}", self.outer_radius);
            let hint = "swap the radii or make the hole smaller".to_owned();
            faults(&format!("{at}/inner_radius"), self.inner_radius.to_string(), allowed, hint);
        }
        check_counts(at, &self.request(), [6, MAX_SEAMS], faults);
    }

    fn request(&self) -> GradedRequest {
        let Self { inner_radius, outer_radius, nodes, boundary_nodes, seams, grading, .. } = *self;
        let ring = Ring { inner: inner_radius, outer: outer_radius };
        GradedRequest { ring, nodes, boundary_nodes, seams: seams.unwrap_or(0), grading }
    }

    /// Makes the mesh; the parameters must have passed [`AnnulusParameters::check`].
    ///
    /// # Errors
    /// Inconsistent counts, a relaxation that does not converge, or angles that cannot be made acceptable.
    pub fn build(&self) -> Result<Mesh, MeshError> {
        distmesh::generate(&self.request(), self.seed)
    }
}

impl DiscParameters {
    /// Reports every value out of range; `at` is the JSON pointer of this section.
    pub fn check(&self, at: &str, faults: FaultSink<'_>) {
        check_length(at, "radius", self.radius, faults);
        check_counts(at, &self.request(), [3, MAX_DISC_SEAMS], faults);
    }

    fn request(&self) -> GradedRequest {
        let Self { radius, nodes, boundary_nodes, seams, grading, .. } = *self;
        let ring = Ring { inner: 0.0, outer: radius };
        GradedRequest { ring, nodes, boundary_nodes, seams: seams.unwrap_or(0), grading }
    }

    /// Makes the mesh; the parameters must have passed [`DiscParameters::check`].
    ///
    /// # Errors
    /// Inconsistent counts, a relaxation that does not converge, or angles that cannot be made acceptable.
    pub fn build(&self) -> Result<Mesh, MeshError> {
        distmesh::generate(&self.request(), self.seed)
    }
}

/// Checks what annulus and disc have in common, given the fewest nodes on the loops and the most seams.
fn check_counts(at: &str, request: &GradedRequest, [least_boundary, most_seams]: [usize; 2], faults: FaultSink<'_>) {
    let nodes = request.nodes;
    check_count(at, "nodes", nodes, [least_boundary + 1, MAX_NODES], faults);
    if let Some(count) = request.boundary_nodes {
        check_count(at, "boundary_nodes", count, [least_boundary, nodes.max(least_boundary)], faults);
    }
    if request.seams > MAX_DISC_SEAMS && most_seams == MAX_DISC_SEAMS {
        let hint = "more would make slivers at the centre: take an annulus with a small hole, which is a vent";
        faults(&format!("{at}/seams"), request.seams.to_string(), format!("0 to {MAX_DISC_SEAMS}"), hint.into());
    } else {
        check_count(at, "seams", request.seams, [0, most_seams.min(nodes)], faults);
    }
    let [least, most] = GRADING_RANGE;
    if let Some(value) = request.grading.filter(|g| !(least..=most).contains(g)) {
        let hint = "1 is uniform, 2 doubles the edge length towards the middle".to_owned();
        faults(&format!("{at}/grading"), value.to_string(), format!("{least} to {most}"), hint);
    }
}
