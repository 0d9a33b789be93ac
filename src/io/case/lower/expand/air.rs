//! What a parachute's type and materials say of its air: drag of lines, air through the cloth, numbers of the field.

use super::rig::{Part, Parts};
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{
    Aero, Canopy, ClothLaw, Drag, EdgeSelection, FillingSchedule, Network, NodeOrEdgeSelection, OneOrSeveral,
};
use crate::format_number::figures;
use crate::mesh::parachute::{CanopyType, FieldNumbers};

/// Parts that have drag by their material. Tapes lie on the cloth, and a riser is in the wake of its payload.
const DRAG: [&str; 3] = ["lines", "inner-lines", "centre-line"];

/// Adds what the materials of a parachute say of its `aero` section; a case without one has no air.
pub(super) fn add(
    at: &Pointer,
    parts: &Parts<'_>,
    whole: &mut Network,
    taken: &mut Vec<String>,
    faults: &mut Faults<'_>,
) {
    let Some(aero) = &mut whole.aero else { return };
    add_drag(parts, aero, taken, faults);
    let Some(name) = parts.parachute.cloth.as_deref() else { return };
    let named = Pointer::root().below("/system/network/mesh/parachute/cloth");
    let Some(law) = parts.table.cloth(&named, name, faults).and_then(|cloth| cloth.permeability) else { return };
    for (at, canopy) in canopies(at, aero) {
        if let Some(key) = let_air_through(canopy, ClothLaw::Permeable(law)) {
            taken.push(format!("{}.{key}: the air through {name}", dotted(&at)));
        }
    }
}

/// A place in the network, as `--set` writes it, from there on.
fn dotted(at: &Pointer) -> String {
    at.as_str().trim_start_matches("/system/network/").replace('/', ".")
}

/// Gives canopies the numbers of a parachute's type that they leave out.
pub(super) fn fill_canopies(
    at: &Pointer,
    kind: CanopyType,
    whole: &mut Network,
    taken: &mut Vec<String>,
    faults: &mut Faults<'_>,
) {
    let Some(aero) = &mut whole.aero else { return };
    for (at, canopy) in canopies(at, aero) {
        // Flat canopies are near their CD0 without one, and slots take a part of the others' drag.
        if let (Some(filling), CanopyType::Hemispherical) = (&mut canopy.filling, kind)
            && filling.outer_pressure_coefficient.is_none()
            && filling.drag_coefficient.is_none()
        {
            fill_coefficient(&at.key("filling"), &mut filling.drag_coefficient, kind, taken);
        }
        let Some(schedule) = &mut canopy.schedule else { continue };
        let (at, one) = (at.key("schedule"), matches!(schedule, OneOrSeveral::One(_)));
        let stages = schedule.all_mut();
        let last = stages.len().saturating_sub(1);
        for (i, stage) in stages.iter_mut().enumerate() {
            let at = if one { at.clone() } else { at.index(i) };
            if i == last {
                fill_drag(&at, stage, kind, taken, faults);
            }
            fill_time(&at, stage, kind, taken, faults);
        }
    }
}

/// The canopies, each with its place.
fn canopies<'a>(at: &Pointer, aero: &'a mut Aero) -> Vec<(Pointer, &'a mut Canopy)> {
    let several = matches!(aero.canopy, Some(OneOrSeveral::Several(_)));
    let at = at.key("canopy");
    let place = |i: usize| if several { at.index(i) } else { at.clone() };
    let all = aero.canopy.iter_mut().flat_map(OneOrSeveral::all_mut);
    all.enumerate().map(|(i, canopy)| (place(i), canopy)).collect()
}

/// Gives lines the drag of their material, unless the case gives them a diameter.
fn add_drag(parts: &Parts<'_>, aero: &mut Aero, taken: &mut Vec<String>, faults: &mut Faults<'_>) {
    let on_lines = aero.drag.iter().filter(|drag| drag.diameter.is_some()).filter_map(|drag| drag.on.edges());
    let mut written: Vec<String> = Vec::new();
    for selection in on_lines {
        match selection {
            EdgeSelection::Group(name) => written.push(name),
            _ => written.extend(DRAG.map(str::to_owned)),
        }
    }
    let written: Vec<&str> = written.iter().map(String::as_str).collect();
    // Its faults are those of the springs.
    let lines = parts.lines(&Pointer::root().key("system").key("network"));
    for Part { group, material: name, at } in lines.iter().filter(|part| DRAG.contains(&part.group)) {
        let Some(material) = parts.table.line(at, name, faults) else { continue };
        let (Some(diameter), Some(coefficient)) = (material.diameter, material.drag_coefficient) else { continue };
        for group in parts.groups_left(group, &written) {
            taken.push(format!(
                "aero.drag of {group}: {} m wide, coefficient {} ({name})",
                figures(diameter, 4),
                figures(coefficient, 4)
            ));
            let on = NodeOrEdgeSelection::Group(group);
            aero.drag.push(Drag {
                on,
                diameter: Some(diameter),
                coefficient: Some(coefficient),
                drag_area: None,
                glide: None,
            });
        }
    }
}

/// Gives a canopy the law of its cloth if it gives none; returns the key of the law.
fn let_air_through(canopy: &mut Canopy, law: ClothLaw) -> Option<&'static str> {
    let (place, key) = match canopy {
        Canopy { filling: Some(filling), .. } => (&mut filling.law, "filling.law"),
        Canopy { cavity: Some(cavity), .. } => (&mut cavity.law, "cavity.law"),
        Canopy { schedule: Some(_), .. } => (&mut canopy.law, "law"),
        _ => return None,
    };
    if place.is_some() {
        return None;
    }
    *place = Some(law);
    Some(key)
}

/// Gives a stage the CD0 of a type if it has no drag area; adds a fault if the type has none.
fn fill_drag(
    at: &Pointer,
    stage: &mut FillingSchedule,
    kind: CanopyType,
    taken: &mut Vec<String>,
    faults: &mut Faults<'_>,
) {
    if stage.drag_area.is_some() || stage.drag_coefficient.is_some() {
        return;
    }
    fill_coefficient(at, &mut stage.drag_coefficient, kind, taken);
    if stage.drag_coefficient.is_none() {
        let hint = format!("no measured CD0 of type \"{kind}\" was found, so it has no default");
        let allowed = "exactly one of drag_area and drag_coefficient";
        faults.add_value(at, "a stage without a drag area", allowed, Some(hint));
    }
}

/// Gives a drag coefficient that is left out the CD0 of a type, if that is known.
fn fill_coefficient(at: &Pointer, place: &mut Option<f64>, kind: CanopyType, taken: &mut Vec<String>) {
    let Some([low, high]) = kind.numbers().drag_coefficient else { return };
    *place = Some(low);
    let [low, high] = [low, high].map(|cd| figures(cd, 4));
    let source = FieldNumbers::source();
    taken.push(format!("{}.drag_coefficient {low}: {kind}, {low} to {high} by {source}", dotted(at)));
}

/// Gives a stage the filling constant of a type, and its exponent, if it has no filling time; adds a fault if the type
/// has none.
fn fill_time(
    at: &Pointer,
    stage: &mut FillingSchedule,
    kind: CanopyType,
    taken: &mut Vec<String>,
    faults: &mut Faults<'_>,
) {
    if stage.filling_constant.is_some() || stage.filling_time.is_some() {
        return;
    }
    let FieldNumbers { filling_constant: Some(n), exponent, .. } = kind.numbers() else {
        let hint = format!("no measured filling constant of type \"{kind}\" was found, so it has no default");
        let allowed = "exactly one of filling_constant and filling_time";
        return faults.add_value(at, "a stage without a filling time", allowed, Some(hint));
    };
    stage.filling_constant = Some(n);
    stage.exponent = stage.exponent.or(exponent);
    let exponent = stage.exponent.map_or(String::new(), |j| format!(" and exponent {}", figures(j, 4)));
    let (n, source) = (figures(n, 4), FieldNumbers::source());
    taken.push(format!("{}.filling_constant {n}{exponent}: {kind}, {source}", dotted(at)));
}
