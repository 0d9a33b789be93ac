//! Given pressures and forces, and snow.

use crate::mesh::unit_vector::unit_vector;
use nalgebra::Vector3;

use super::geometry::{Geometry, TriangleUse, triangles};
use super::numbers::series;
use super::select;
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{Load, PressureKindKey};
use crate::model::spec::{NodalLoad, PressureKind, PressureLoad, Series};

/// Loads by kind, in the order of the case.
#[derive(Debug, Default)]
pub(super) struct Loads {
    /// on triangles
    pub pressures: Vec<PressureLoad>,
    /// on nodes
    pub forces: Vec<NodalLoad>,
}

/// Checks and resolves the `loads` section.
pub(super) fn loads(
    at: &Pointer,
    list: &[Load],
    gravity: Option<[f64; 3]>,
    geometry: Option<&Geometry>,
    faults: &mut Faults<'_>,
) -> Loads {
    const ALLOWED: &str = "exactly one of pressure, force and snow";
    let mut loads = Loads::default();
    for (i, load) in list.iter().enumerate() {
        let at = at.index(i);
        let factor = match &load.table {
            None => Some(None),
            Some(table) => series(&at.key("table"), table.iter().map(|[t, f]| (*t, *f)), faults).map(Some),
        };
        if load.shape.is_some() && load.snow.is_none() {
            faults.add(&at.key("shape"), "only with snow");
        }
        match (load.pressure, load.force, load.snow) {
            (Some(p), None, None) => {
                loads.pressures.extend(pressure(&at, &LoadInput { load, value: p, factor }, geometry, faults))
            }
            (None, Some(f), None) => {
                loads.forces.extend(force(&at, &LoadInput { load, value: f, factor }, geometry, faults));
            }
            (None, None, Some(s)) => {
                let down = down(gravity);
                loads.pressures.extend(snow(&at, &LoadInput { load, value: s, factor }, down, geometry, faults));
            }
            (None, None, None) => faults.add_value(&at, "a load without value", ALLOWED, None),
            (pressure, force, snow) => {
                let given = [("pressure", pressure.is_some()), ("force", force.is_some()), ("snow", snow.is_some())];
                let given: Vec<&str> = given.iter().filter(|(_, given)| *given).map(|(name, _)| *name).collect();
                let hint = Some("write a load for each".to_owned());
                faults.add_value(&at, format!("a load with {}", given.join(" and ")), ALLOWED, hint);
            }
        }
    }
    loads
}

/// A load with its value and its factor; the outer `None` of the factor is a faulty table.
struct LoadInput<'a, T> {
    load: &'a Load,
    value: T,
    factor: Option<Option<Series<f64>>>,
}

fn pressure(
    at: &Pointer,
    given: &LoadInput<'_, f64>,
    geometry: Option<&Geometry>,
    faults: &mut Faults<'_>,
) -> Option<PressureLoad> {
    let LoadInput { load, value, factor } = given;
    let kind = pressure_kind(at, load, faults).filter(|_| faults.readable(&at.key("kind")));
    let geometry = geometry?;
    let needs = if let Some(PressureKind::Dead(Some(_))) = kind { TriangleUse::Areas } else { TriangleUse::Normals };
    if !triangles(at, "a pressure", geometry, needs, faults) {
        return None;
    }
    let triangles = select::triangles(&at.key("on"), &load.on, geometry, faults)?;
    Some(PressureLoad { triangles, pressure: *value, kind: kind?, factor: factor.clone()? })
}

/// The direction of gravity; -z without it.
fn down(gravity: Option<[f64; 3]>) -> [f64; 3] {
    gravity.map(Vector3::from).and_then(unit_vector).map_or([0.0, 0.0, -1.0], Into::into)
}

/// A load on the plan, as seen along `down`.
fn snow(
    at: &Pointer,
    LoadInput { load, value, factor }: &LoadInput<'_, f64>,
    down: [f64; 3],
    geometry: Option<&Geometry>,
    faults: &mut Faults<'_>,
) -> Option<PressureLoad> {
    for (key, given) in [("kind", load.kind.is_some()), ("direction", load.direction.is_some())] {
        if given {
            faults.add_hint(&at.key(key), "only with pressure", "snow acts along gravity, on the plan");
        }
    }
    let geometry = geometry?;
    if !triangles(at, "snow", geometry, TriangleUse::Areas, faults) {
        return None;
    }
    let triangles = select::triangles(&at.key("on"), &load.on, geometry, faults)?;
    let pressure = value * load.shape.unwrap_or(1.0);
    Some(PressureLoad { triangles, pressure, kind: PressureKind::Plan(down), factor: factor.clone()? })
}

fn pressure_kind(at: &Pointer, load: &Load, faults: &mut Faults<'_>) -> Option<PressureKind> {
    match (load.kind.unwrap_or_default(), load.direction) {
        (PressureKindKey::Follower, None) => Some(PressureKind::Follower),
        (PressureKindKey::Dead, None) => Some(PressureKind::Dead(None)),
        (PressureKindKey::Dead, Some(direction)) => {
            // Scaled before it is normalised: the squares of large components would overflow.
            let vector = Vector3::from(direction);
            let unit = unit_vector(vector / vector.amax());
            if unit.is_none() {
                faults.add(&at.key("direction"), "a vector that is not zero; its length does not matter");
            }
            unit.map(|unit| PressureKind::Dead(Some(unit.into())))
        }
        (PressureKindKey::Follower, Some(_)) if !faults.readable(&at.key("kind")) => None,
        (PressureKindKey::Follower, Some(_)) => {
            let hint =
                "a follower pressure acts along the current normal; for a fixed direction say \"kind\": \"dead\"";
            faults.add_hint(&at.key("direction"), "only with \"kind\": \"dead\"", hint);
            None
        }
    }
}

fn force(
    at: &Pointer,
    given: &LoadInput<'_, [f64; 3]>,
    geometry: Option<&Geometry>,
    faults: &mut Faults<'_>,
) -> Option<NodalLoad> {
    let LoadInput { load, value, factor } = given;
    if load.kind.is_some() {
        faults.add(&at.key("kind"), "only with pressure");
    }
    if load.direction.is_some() {
        faults.add_hint(&at.key("direction"), "only with pressure", "a force has its direction in its components");
    }
    let nodes = select::nodes(&at.key("on"), &load.on, geometry?, faults)?;
    Some(NodalLoad { nodes, force: *value, factor: factor.clone()? })
}
