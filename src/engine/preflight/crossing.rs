//! Cloth that passes through cloth at the start.

use crate::format_number::{counted, figures};
use crate::mesh::CrossingFinder;
use crate::model::spec::{ContactSide, ContactSpec, NetworkSpec};
use crate::warning::{Warning, WarningCode};

/// A warning for cloth that passes through cloth at the start.
pub fn at_start(spec: &NetworkSpec) -> Option<Warning> {
    let mut finder = CrossingFinder::new(&spec.mesh.triangles)?;
    let moved = |(x, u): (&[f64; 3], &[f64; 3])| std::array::from_fn(|k| x[k] + u[k]);
    let displaced: Vec<[f64; 3]> = spec.mesh.nodes.iter().zip(&spec.displacement).map(moved).collect();
    let found = finder.find(if displaced.is_empty() { &spec.mesh.nodes } else { &displaced });
    let deepest = found.iter().copied().reduce(|deepest, one| if one.depth > deepest.depth { one } else { deepest })?;
    let ([a, b], triangle) = (deepest.edge, deepest.triangle);
    let parts = |contact: &ContactSpec| !matches!(contact.other, ContactSide::Obstacle(_));
    let why = match spec.contacts.iter().any(parts) {
        true => "contact leaves every sheet on the side where it starts",
        false => "no contact is declared",
    };
    let text = format!(
        "cloth passes through cloth at the start: {}, the deepest of the edge of nodes {a} and {b} through triangle \
         {triangle}, {} m deep; {why}, so they stay entangled: place them apart",
        counted(found.len() as u64, "crossing", "crossings"),
        figures(deepest.depth, 2)
    );
    Some(Warning::new(WarningCode::ClothCrossing, text))
}
