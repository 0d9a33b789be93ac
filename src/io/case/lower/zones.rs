//! Zones of a surface with pressure coefficients of the wind.

use super::geometry::{Geometry, TriangleUse, triangles};
use super::numbers::rising;
use super::select;
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::ZoneCoefficient;
use crate::model::spec::{Series, SurfacePressureSpec};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// What stands for all triangles, unless a group has this name.
const ALL: &str = "all";

/// Checks and resolves the zones of `surface_pressure`, each a group of triangles.
pub(super) fn zones(
    at: &Pointer,
    zones: &BTreeMap<String, ZoneCoefficient>,
    geometry: Option<&Geometry>,
    faults: &mut Faults<'_>,
) -> Vec<SurfacePressureSpec> {
    if zones.is_empty() {
        let hint = "for example {\"roof\": -0.7}, or {\"all\": -0.7} for all triangles";
        faults.add_value(at, "no zone", "at least one group with its coefficient", Some(hint.to_owned()));
    }
    let coefficients: Vec<Option<Series<f64>>> =
        zones.iter().map(|(name, given)| coefficient(&at.key(name), given, faults)).collect();
    let Some(geometry) = geometry else { return Vec::new() };
    if !triangles(at, "the wind", geometry, TriangleUse::Normals, faults) {
        return Vec::new();
    }
    let mut zone_of: Vec<Option<&str>> = vec![None; geometry.mesh.triangles.len()];
    let mut found = Vec::new();
    for (name, coefficient) in zones.keys().zip(coefficients) {
        let at = at.key(name);
        let everywhere = name == ALL && !geometry.mesh.groups.contains_key(ALL);
        let selected = match everywhere {
            true => Some((0_u32..).take(zone_of.len()).collect()),
            false => select::triangles_of_group(&at, name, geometry, faults),
        };
        let Some(triangles) = selected else { continue };
        let mut twice = None;
        for &triangle in &triangles {
            if let Some(earlier) = zone_of[triangle as usize].replace(name) {
                twice = twice.or(Some((triangle, earlier)));
            }
        }
        if let Some((triangle, earlier)) = twice {
            let value = format!("triangle {triangle}, which the zone \"{earlier}\" has too");
            faults.add_value(&at, value, "zones that share no triangle", None);
        }
        found.extend(coefficient.map(|coefficient| SurfacePressureSpec { triangles, coefficient }));
    }
    found
}

/// cp over the angle \[rad\].
fn coefficient(at: &Pointer, given: &ZoneCoefficient, faults: &mut Faults<'_>) -> Option<Series<f64>> {
    let rows = match given {
        ZoneCoefficient::Constant(cp) => return Some(Series { t: vec![0.0], value: vec![*cp] }),
        ZoneCoefficient::Rows(rows) => rows,
    };
    let table = rising(at, "angle", rows.iter().map(|[angle, cp]| (*angle, *cp)), faults)?;
    // Rounded values of pi are meant.
    let outside = rows.iter().position(|[angle, _]| !(0.0..=PI + 0.01).contains(angle));
    if let Some(row) = outside {
        let [angle, _] = rows[row];
        let hint = match angle {
            _ if angle > PI && angle <= 180.0 => format!("give radians: {angle} degrees are {}", angle.to_radians()),
            _ => "0 is the wind onto the outer face, pi/2 along it, pi on the lee side".to_owned(),
        };
        faults.add_hint(&at.index(row), "angles from 0 to pi", hint);
    }
    outside.is_none().then_some(table)
}
