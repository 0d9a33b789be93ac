//! Canopies that fill ring by ring: their constants and their rows of cloth.

use super::canopy::cloth;
use super::geometry::Geometry;
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::Filling;
use crate::model::spec::RingsSpec;

/// [-] Cb of flat canopies.
const OUTER: f64 = -0.7;
/// [-] Area of the skirt's circle over S0: of Taylor's shape over lines of one nominal diameter.
const SKIRT_AREA: f64 = 0.43;

/// The constants; the rows are still missing.
pub(super) fn lower(at: &Pointer, given: Filling, faults: &mut Faults<'_>) -> Option<RingsSpec> {
    let Filling { outer_pressure_coefficient: outer, drag_coefficient, law, .. } = given;
    let Filling { geometric_porosity, damping, quadratic_damping, slot_discharge, vent_discharge, .. } = given;
    if outer.is_some() && drag_coefficient.is_some() {
        let value = "a filling with outer_pressure_coefficient and drag_coefficient";
        faults.add_value(at, value, "at most one of outer_pressure_coefficient and drag_coefficient", None);
    }
    let by_drag = drag_coefficient.map(|drag| 1.0 - drag / SKIRT_AREA);
    let cloth = cloth(&at.key("law"), law, faults)?;
    Some(RingsSpec {
        rows: Vec::new(),
        outer_pressure_coefficient: outer.or(by_drag).unwrap_or(OUTER),
        damping: [damping, quadratic_damping],
        cloth,
        geometric_porosity,
        slot_discharge,
        vent_discharge,
    })
}

/// The rows of cloth of a canopy with these triangles, from the vent to the skirt.
pub(super) fn rows_of(
    at: &Pointer,
    geometry: &Geometry,
    triangles: &[u32],
    faults: &mut Faults<'_>,
) -> Option<Vec<Vec<u32>>> {
    let mut has = vec![false; geometry.nodes()];
    let corners = triangles.iter().flat_map(|&t| geometry.mesh.triangles[t as usize]);
    corners.for_each(|node| has[node as usize] = true);
    let of_canopy = |row: &&Vec<u32>| row.iter().all(|&node| has[node as usize]);
    let rows: Vec<Vec<u32>> = geometry.mesh.rows.iter().filter(of_canopy).cloned().collect();
    if rows.is_empty() {
        let value = "a canopy whose rows of cloth are not known";
        let hint = "take the parachute as the mesh of the case, not a file of it; cruciform canopies have no rows: use \
                    schedule or table";
        faults.add_value(at, value, "a generated canopy of gores", Some(hint.to_owned()));
        return None;
    }
    Some(rows)
}
