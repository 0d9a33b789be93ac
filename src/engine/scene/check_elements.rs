//! Checks of the elastic elements of a specification.

use super::check_values::{BuildError, below, finite, length};
use crate::model::spec::{BendingSpec, ElasticLaw, MembraneSpec, NetworkSpec, Slack, SpringGroup, SpringValues};

/// Springs of a mesh with so many edges.
pub(super) fn springs(group: &SpringGroup, edges: usize) -> Result<(), BuildError> {
    let m = group.edges.len();
    below("edge", &group.edges, edges)?;
    let dashpot = group.dashpot.as_ref().map(|d| ("dashpot coefficient", &d.coefficient));
    for (what, values) in [("stiffness", &group.stiffness)].into_iter().chain(dashpot) {
        if let SpringValues::PerEdge(list) = values {
            length(what, list.len(), m)?;
        }
        finite(what, values.given())?;
    }
    length("rest_length", group.rest_length.len(), m)?;
    finite("rest_length", &group.rest_length)?;
    if !group.breaks.is_empty() {
        length("breaking tensions", group.breaks.len(), m)?;
        finite("breaking tension", &group.breaks)?;
    }
    if let Slack::DeadZone { eps } | Slack::CompressionLimit { eps } = group.slack {
        finite("slack eps", &[eps])?;
    }
    if let ElasticLaw::Table(rows) = &group.law {
        finite("number in a table of strain and force", rows.as_flattened())?;
        let rises = |pair: &[[f64; 2]]| pair[1][0] > pair[0][0] && pair[1][1] >= pair[0][1];
        if rows.len() < 2 || !rows.windows(2).all(rises) {
            let reason = "needs two rows or more, with strains that increase and forces that do not fall";
            return Err(BuildError::Table { what: "springs", reason });
        }
    }
    let bare = group.rest_length.iter().position(|l0| *l0 <= 0.0).filter(|_| group.law != ElasticLaw::Linear);
    bare.map_or(Ok(()), |spring| Err(BuildError::NoRestLength { spring }))
}

/// Membranes and bending.
pub(super) fn surfaces(spec: &NetworkSpec) -> Result<(), BuildError> {
    let (nodes, triangles) = (spec.mesh.nodes.len(), spec.mesh.triangles.len());
    for MembraneSpec { triangles: list, thickness, modulus, poisson, shear, warp, damping_time, .. } in &spec.membranes
    {
        below("triangle", list, triangles)?;
        let [one, two] = *modulus;
        finite("membrane number", &[*thickness, one, two, *shear, *poisson, *damping_time])?;
        finite("warp direction", warp.as_ref().map_or(&[], |warp| &warp[..]))?;
        let positive = [*thickness, one, two, *shear].iter().all(|number| *number > 0.0);
        if !positive || *damping_time < 0.0 || poisson * poisson * two >= one {
            return Err(BuildError::Membrane { modulus: *modulus, poisson: *poisson, shear: *shear });
        }
    }
    for BendingSpec { hinges, stiffness, chains, flexural_rigidity } in &spec.bending {
        below("node", hinges.as_flattened(), nodes)?;
        below("node", chains.as_flattened(), nodes)?;
        finite("bending stiffness", &[*stiffness, *flexural_rigidity])?;
    }
    Ok(())
}
