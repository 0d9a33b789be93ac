//! Checks of loads, air and what it acts on.

use super::check_values::{BuildError, below, finite, length, times, vectors};
use crate::mesh::Mesh;
use crate::model::spec::{
    AtmosphereSpec, CanopyAir, CavitySpec, ClothSpec, EventWind, FillingSpec, GasFill, GasSpec, GlideSpec, GustSpec,
    NetworkSpec, PressureKind, RingsSpec, StreamSpec, WindOverTime,
};

pub(super) fn loads(spec: &NetworkSpec) -> Result<(), BuildError> {
    vectors("gravity", spec.gravity.as_slice())?;
    if let Some(rayleigh) = spec.rayleigh {
        finite("rayleigh factor", &[rayleigh.mass, rayleigh.stiffness])?;
    }
    if let Some(air) = &spec.air {
        finite("air coefficient", &[air.linear, air.quadratic])?;
        times("wind", &air.wind)?;
        vectors("wind", &air.wind.value)?;
    }
    flow(spec)?;
    for load in &spec.pressures {
        below("triangle", &load.triangles, spec.mesh.triangles.len())?;
        finite("pressure", &[load.pressure])?;
        match load.kind {
            PressureKind::Follower => {}
            PressureKind::Dead(direction) => vectors("direction of a pressure", direction.as_slice())?,
            PressureKind::Plan(direction) => vectors("direction of a load", &[direction])?,
        }
    }
    spec.gases.iter().try_for_each(|one| gas(one, spec.mesh.triangles.len()))?;
    for load in &spec.forces {
        below("node", &load.nodes, spec.mesh.nodes.len())?;
        vectors("force", &[load.force])?;
    }
    let factors = spec.pressures.iter().map(|p| &p.factor).chain(spec.forces.iter().map(|f| &f.factor));
    factors.flatten().try_for_each(|table| {
        times("factor", table)?;
        finite("factor", &table.value)
    })
}

fn gas(gas: &GasSpec, triangles: usize) -> Result<(), BuildError> {
    let GasSpec { ambient, gamma, volume, fill, .. } = gas;
    below("triangle", &gas.triangles, triangles)?;
    finite("gas", &[*ambient, *gamma, volume.unwrap_or(0.0)])?;
    times("gas", fill.table())?;
    finite("gas", &fill.table().value)?;
    let least = fill.table().value.iter().copied().fold(f64::INFINITY, f64::min);
    let there = if let GasFill::Pressure(_) = fill { least + ambient } else { least };
    if *ambient <= 0.0 || *gamma < 1.0 || volume.is_some_and(|volume| volume <= 0.0) || there <= 0.0 {
        let reason = "needs absolute pressures, amounts and volumes above 0, and an exponent of at least 1";
        return Err(BuildError::Gas { reason });
    }
    Ok(())
}

/// The stream, and what it acts on.
fn flow(spec: &NetworkSpec) -> Result<(), BuildError> {
    let Mesh { nodes, edges, triangles, .. } = &spec.mesh;
    let needs_air = !(spec.canopies.is_empty()
        && spec.surface_pressures.is_empty()
        && spec.line_drag.is_empty()
        && spec.node_drag.is_empty());
    match &spec.stream {
        None if needs_air => return Err(BuildError::NoStream),
        None => {}
        Some(StreamSpec { wind, gusts, profile, by_event, atmosphere, altitude }) => {
            for (what, table) in [("wind", Some(wind)), ("wind profile", profile.as_ref())] {
                let Some(table) = table else { continue };
                times(what, table)?;
                vectors(what, &table.value)?;
            }
            gusts.iter().try_for_each(gust)?;
            for EventWind { event, over_time } in by_event {
                below("event", &[*event as u32], spec.events.len())?;
                match over_time {
                    WindOverTime::Table(table) => {
                        times("wind", table)?;
                        vectors("wind", &table.value)?;
                    }
                    WindOverTime::Gust(one) => gust(one)?,
                }
            }
            finite("altitude", &[*altitude])?;
            match atmosphere {
                AtmosphereSpec::Constant { density } => finite("density", &[*density])?,
                AtmosphereSpec::Exponential { density, scale_height } => {
                    finite("atmosphere", &[*density, *scale_height])?;
                }
                AtmosphereSpec::Isa => {}
            }
        }
    }
    for zone in &spec.surface_pressures {
        below("triangle", &zone.triangles, triangles.len())?;
        times("surface pressure", &zone.coefficient)?;
        finite("surface pressure coefficient", &zone.coefficient.value)?;
    }
    for canopy in &spec.canopies {
        below("triangle", &canopy.triangles, triangles.len())?;
        length("pressure coefficients of a canopy", canopy.pressure_coefficient.len(), canopy.triangles.len())?;
        finite("pressure coefficient", &canopy.pressure_coefficient)?;
        finite("apparent mass", canopy.apparent_mass.as_slice())?;
        finite("inflow loss", canopy.inflow_loss.as_slice())?;
        canopy.glide.as_ref().map_or(Ok(()), glide)?;
        if canopy.glide.is_some() && !matches!(canopy.air, CanopyAir::Point(_)) {
            return Err(BuildError::Glide { reason: "is for canopies that are points: cloth has no lift" });
        }
        match &canopy.air {
            CanopyAir::Coefficient => {}
            CanopyAir::Filling(stages) | CanopyAir::Point(stages) if stages.is_empty() => {
                return Err(BuildError::NoStage);
            }
            CanopyAir::Filling(stages) | CanopyAir::Point(stages) => stages.iter().try_for_each(|stage| {
                let FillingSpec { drag_area, start, duration, by_speed: _, exponent, event } = *stage;
                finite("filling", &[drag_area, if event.is_some() { 0.0 } else { start }, duration, exponent])?;
                event.map_or(Ok(()), |event| below("event", &[event as u32], spec.events.len()))
            })?,
            CanopyAir::Cavity(spec) => cavity(*spec)?,
            CanopyAir::Rings(spec) => {
                spec.rows.iter().try_for_each(|row| below("node", row, nodes.len()))?;
                rings(spec)?;
            }
        }
        for (what, list) in [("skirt", &canopy.skirt), ("apex", &canopy.apex), ("confluence", &canopy.confluence)] {
            below("node", list, nodes.len())?;
            if list.is_empty() {
                return Err(BuildError::NoNodes { what });
            }
        }
    }
    for drag in &spec.line_drag {
        below("edge", &drag.edges, edges.len())?;
        finite("line drag", &[drag.diameter, drag.coefficient])?;
    }
    for drag in &spec.node_drag {
        below("node", &drag.nodes, nodes.len())?;
        finite("drag area", &[drag.drag_area])?;
        drag.glide.as_ref().map_or(Ok(()), glide)?;
    }
    Ok(())
}

fn gust(GustSpec { velocity, start, duration }: &GustSpec) -> Result<(), BuildError> {
    vectors("gust", &[*velocity])?;
    finite("gust", &[*start, *duration])
}

fn glide(GlideSpec { ratio, heading }: &GlideSpec) -> Result<(), BuildError> {
    finite("glide ratio", &[*ratio])?;
    times("heading", heading)?;
    finite("heading", &heading.value)?;
    if *ratio <= 0.0 {
        return Err(BuildError::Glide { reason: "needs a ratio of lift over drag above 0" });
    }
    Ok(())
}

fn cavity(CavitySpec { inflow, outer_pressure_coefficient, cloth }: CavitySpec) -> Result<(), BuildError> {
    finite("cavity", &[inflow, outer_pressure_coefficient])?;
    if inflow <= 0.0 {
        return Err(BuildError::Cavity { reason: "needs an inflow above 0" });
    }
    if outer_pressure_coefficient >= 1.0 {
        return Err(BuildError::Cavity { reason: "needs a pressure coefficient below 1 outside" });
    }
    if let Some(cloth) = cloth
        && !passes_air(cloth)?
    {
        return Err(BuildError::Cavity { reason: "needs cloth whose coefficients are not negative and not both 0" });
    }
    Ok(())
}

fn rings(spec: &RingsSpec) -> Result<(), BuildError> {
    let RingsSpec { outer_pressure_coefficient: outer, damping, geometric_porosity: open, .. } = *spec;
    let RingsSpec { slot_discharge: slots, vent_discharge: vent, .. } = *spec;
    finite("filling", &[outer, damping[0], damping[1], open, slots, vent])?;
    let refused = |reason| Err(BuildError::Rings { row: None, reason });
    if outer >= 1.0 {
        return refused("needs a pressure coefficient below 1 outside");
    }
    if damping[0] < 0.0 || damping[1] < 0.0 || slots < 0.0 || vent < 0.0 || !(0.0..=1.0).contains(&open) {
        return refused("needs damping and discharge coefficients of 0 or more and a porosity from 0 to 1");
    }
    if let Some(cloth) = spec.cloth
        && !passes_air(cloth)?
    {
        return refused("needs cloth whose coefficients are not negative and not both 0");
    }
    Ok(())
}

/// Whether a cloth lets more air through at a larger pressure.
fn passes_air(ClothSpec { linear, quadratic }: ClothSpec) -> Result<bool, BuildError> {
    finite("cloth of a canopy", &[linear, quadratic])?;
    Ok(linear >= 0.0 && quadratic >= 0.0 && linear + quadratic > 0.0)
}
