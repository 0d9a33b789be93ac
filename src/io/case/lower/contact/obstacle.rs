//! Rigid bodies: their shapes and their motion.

use super::surface::surface;
use crate::case::diagnostics::Faults;
use crate::case::lower::numbers::series;
use crate::case::pointer::Pointer;
use crate::case::schema::{Ball, Bar, Cuboid, Obstacle, Plane, vectors};
use crate::mesh::unit_vector::unit_vector;
use crate::model::spec::{ObstacleShape, ObstacleSpec};
use nalgebra::Vector3;
use std::path::Path;

/// Checks and resolves a body.
pub(super) fn obstacle(at: &Pointer, body: &Obstacle, base: &Path, faults: &mut Faults<'_>) -> Option<ObstacleSpec> {
    let motion = match &body.motion {
        None => Some(None),
        Some(rows) => series(&at.key("motion").key("table"), vectors(&rows.table), faults).map(Some),
    };
    let shape = shape(at, body, base, faults)?;
    Some(ObstacleSpec { shape, motion: motion? })
}

fn shape(at: &Pointer, body: &Obstacle, base: &Path, faults: &mut Faults<'_>) -> Option<ObstacleShape> {
    let Obstacle { plane, sphere, cylinder, cuboid, file, motion: _ } = body;
    match (plane, sphere, cylinder, cuboid, file) {
        (Some(plane), None, None, None, None) => half_space(&at.key("plane"), *plane, faults),
        (None, Some(Ball { center, radius }), None, None, None) => {
            Some(ObstacleShape::Sphere { center: *center, radius: *radius })
        }
        (None, None, Some(bar), None, None) => cylinder_of(&at.key("cylinder"), *bar, faults),
        (None, None, None, Some(cuboid), None) => box_of(&at.key("box"), *cuboid, faults),
        (None, None, None, None, Some(file)) => surface(&at.key("file"), file, base, faults),
        _ => {
            let given = [
                ("plane", plane.is_some()),
                ("sphere", sphere.is_some()),
                ("cylinder", cylinder.is_some()),
                ("box", cuboid.is_some()),
                ("file", file.is_some()),
            ];
            let given: Vec<&str> = given.iter().filter(|(_, given)| *given).map(|(name, _)| *name).collect();
            let (value, hint) = match given.len() {
                0 => ("a body without a shape".to_owned(), None),
                _ => (format!("a body with {}", given.join(" and ")), Some("write a contact for each".to_owned())),
            };
            faults.add_value(at, value, "exactly one of plane, sphere, cylinder, box and file", hint);
            None
        }
    }
}

fn half_space(at: &Pointer, Plane { point, normal }: Plane, faults: &mut Faults<'_>) -> Option<ObstacleShape> {
    // Scaled before it is normalised: the squares of large components would overflow.
    let vector = Vector3::from(normal);
    let Some(unit) = unit_vector(vector / vector.amax()) else {
        faults.add(&at.key("normal"), "a vector that is not zero; its length does not matter");
        return None;
    };
    Some(ObstacleShape::Plane { point, normal: unit.into() })
}

fn cylinder_of(at: &Pointer, Bar { from, to, radius }: Bar, faults: &mut Faults<'_>) -> Option<ObstacleShape> {
    if !(Vector3::from(to) - Vector3::from(from)).norm().is_normal() {
        faults.add_hint(&at.key("to"), "another point than \"from\"", "for a ball write {\"sphere\": ...}");
        return None;
    }
    Some(ObstacleShape::Cylinder { from, to, radius })
}

fn box_of(at: &Pointer, Cuboid { min, max }: Cuboid, faults: &mut Faults<'_>) -> Option<ObstacleShape> {
    let bad: Vec<&str> = (0..3).filter(|k| min[*k] >= max[*k]).map(|k| ["x", "y", "z"][k]).collect();
    if !bad.is_empty() {
        let allowed = format!("above \"min\" in x, y and z; it is not in {}", bad.join(" and "));
        faults.add_hint(
            &at.key("max"),
            allowed,
            "for a flat obstacle write {\"plane\": ...}, or give the box a height",
        );
        return None;
    }
    Some(ObstacleShape::Box { min, max })
}
