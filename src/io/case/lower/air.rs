//! The air section: checks, the stream and what it acts on, and porous laws reduced to the two coefficients of
//! dp = linear v_n + quadratic v_n |v_n|.

use super::coefficients::{Coefficients, checked_coefficients};
use super::events::Plan;
use super::geometry::{Geometry, TriangleUse, triangles};
use super::glide::glide;
use super::wind::{self, Winds};
use super::{canopy, select, zones};
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{Aero, Atmosphere, Drag, ExponentialAtmosphere, OneOrSeveral, PorousLaw};
use crate::model::spec::{
    AirSpec, AtmosphereSpec, CanopySpec, LineDragSpec, NodeDragSpec, StreamSpec, SurfacePressureSpec,
};
use std::collections::BTreeMap;
use std::path::Path;

/// What the section gives.
#[derive(Debug, Default)]
pub(super) struct Flow {
    /// the air that blows through cloth
    pub air: Option<AirSpec>,
    /// zones of surfaces with pressure coefficients
    pub surface_pressures: Vec<SurfacePressureSpec>,
    /// the stream for the rest
    pub stream: Option<StreamSpec>,
    /// canopies that it fills
    pub canopies: Vec<CanopySpec>,
    /// lines in it
    pub line_drag: Vec<LineDragSpec>,
    /// bodies in it
    pub node_drag: Vec<NodeDragSpec>,
}

/// Heights above sea level [m] that the standard atmosphere has.
const STANDARD: [f64; 2] = [-5e3, 86e3];

/// Checks and resolves the section with the events of the case; files are found from the folder `base`.
pub(super) fn flow(
    at: &Pointer,
    aero: Option<&Aero>,
    (base, plan): (&Path, &Plan<'_>),
    geometry: Option<&Geometry>,
    faults: &mut Faults<'_>,
) -> Flow {
    let Some(aero) = aero else { return Flow::default() };
    let canopies = aero.canopy.as_ref().map_or(&[][..], OneOrSeveral::all);
    let fills = !canopies.is_empty();
    if aero.law.is_none() && !fills && aero.drag.is_empty() {
        let hint = "leave the section out for no air".to_owned();
        faults.add_value(at, "nothing that the air acts on", "at least one of law, canopy and drag", Some(hint));
    }
    if aero.law.is_some() && fills {
        let hint = "law is for cloth that is held in a free stream and acts on all triangles; canopy knows the pressure \
                    inside: keep one of them";
        faults.add_hint(&at.key("law"), "not together with canopy", hint);
    }
    let winds = aero
        .wind
        .as_ref()
        .map_or_else(|| Some(Winds::calm()), |w| wind::wind(&at.key("wind"), w, (base, plan), faults));
    let atmosphere = atmosphere(&at.key("atmosphere"), aero, geometry, faults);
    let zoned = match &aero.law {
        Some(PorousLaw::SurfacePressure(zones)) => Some(zones),
        _ => None,
    };
    let in_stream = fills || !aero.drag.is_empty() || zoned.is_some();
    if !in_stream {
        for (key, given) in [("atmosphere", aero.atmosphere.is_some()), ("altitude", aero.altitude.is_some())] {
            if given {
                faults.add_hint(
                    &at.key(key),
                    "only with canopy, drag or surface_pressure",
                    "a law has a density of its own",
                );
            }
        }
    }
    let mut flow = match zoned {
        Some(given) => {
            let at = at.key("law").key("surface_pressure");
            Flow { surface_pressures: zones::zones(&at, given, geometry, faults), ..Flow::default() }
        }
        None => Flow { air: air(at, aero, winds.as_ref(), geometry, faults), ..Flow::default() },
    };
    let listed = matches!(aero.canopy, Some(OneOrSeveral::Several(_)));
    for (i, canopy) in canopies.iter().enumerate() {
        let at = at.key("canopy");
        let at = if listed { at.index(i) } else { at };
        let found = canopy::canopy(&at, canopy, geometry, faults);
        let taken = |t: &u32| flow.canopies.iter().any(|earlier| earlier.triangles.binary_search(t).is_ok());
        if let Some(t) = found.iter().flat_map(|found| &found.triangles).find(|t| taken(t)) {
            let value = format!("triangle {t}, which an earlier canopy has");
            faults.add_value(&at.key("on"), value, "triangles of one canopy only", None);
        }
        flow.canopies.extend(found);
    }
    for (i, one) in aero.drag.iter().enumerate() {
        drag(&at.key("drag").index(i), one, geometry, &mut flow, faults);
    }
    let Some(Winds { table, gusts, profile, by_event }) = winds else { return flow };
    if in_stream || !gusts.is_empty() || !by_event.is_empty() {
        let altitude = aero.altitude.unwrap_or(0.0);
        flow.stream = Some(StreamSpec { wind: table, gusts, profile, by_event, atmosphere, altitude });
    }
    flow
}

fn atmosphere(at: &Pointer, aero: &Aero, geometry: Option<&Geometry>, faults: &mut Faults<'_>) -> AtmosphereSpec {
    match aero.atmosphere {
        None => AtmosphereSpec::Constant { density: 1.225 },
        Some(Atmosphere::Density(density)) => AtmosphereSpec::Constant { density },
        Some(Atmosphere::Exponential(ExponentialAtmosphere { density, scale_height })) => {
            AtmosphereSpec::Exponential { density, scale_height }
        }
        Some(Atmosphere::Isa) => {
            let altitude = aero.altitude.unwrap_or(0.0);
            let heights = || geometry.into_iter().flat_map(|g| &g.mesh.nodes).map(|[_, _, z]| altitude + z);
            let (lowest, highest) = heights().fold((altitude, altitude), |(l, h), z| (l.min(z), h.max(z)));
            if lowest < STANDARD[0] || highest > STANDARD[1] {
                let value = format!("nodes from {lowest} to {highest} m above sea level");
                faults.add_value(at, value, "the standard atmosphere from -5000 to 86000 m", None);
            }
            AtmosphereSpec::Isa
        }
    }
}

/// The air that blows through cloth, as two coefficients and the wind.
fn air(
    at: &Pointer,
    aero: &Aero,
    winds: Option<&Winds>,
    geometry: Option<&Geometry>,
    faults: &mut Faults<'_>,
) -> Option<AirSpec> {
    let given = aero.law.as_ref()?;
    if let Some(geometry) = geometry {
        triangles(at, "the air", geometry, TriangleUse::Normals, faults);
    }
    if winds.is_some_and(|winds| winds.profile.is_some()) {
        let hint = "a law takes the same wind at all heights: give a vector, a table, a file or gusts";
        faults.add_hint(&at.key("wind"), "no profile beside a law", hint);
    }
    let Coefficients { linear, quadratic } = checked_coefficients(&at.key("law"), given, faults)?;
    Some(AirSpec { linear, quadratic, wind: winds?.table.clone() })
}

fn drag(at: &Pointer, drag: &Drag, geometry: Option<&Geometry>, flow: &mut Flow, faults: &mut Faults<'_>) {
    let selects = |what: &str| format!("a selection of {what}");
    let lift = drag.glide.as_ref().and_then(|given| glide(&at.key("glide"), given, faults));
    if drag.glide.is_some() && drag.drag_area.is_none() {
        faults.add_value(&at.key("glide"), "a glide without a drag_area", "only beside drag_area", None);
    }
    match (drag.diameter, drag.coefficient, drag.drag_area) {
        (Some(diameter), Some(coefficient), None) => {
            let Some(on) = drag.on.edges() else {
                let hint = "a diameter belongs to lines; bodies at nodes have a drag_area";
                return faults.add_hint(&at.key("on"), selects("edges"), hint);
            };
            let flags = geometry.and_then(|geometry| select::edges(&at.key("on"), &on, geometry, faults));
            let Some(flags) = flags else { return };
            let edges: Vec<u32> =
                (0_u32..).zip(flags).filter(|(_, selected)| *selected).map(|(edge, _)| edge).collect();
            // Lines side by side are as wide as all of them.
            let mut by_strands: BTreeMap<u64, Vec<u32>> = BTreeMap::new();
            let strands = geometry.and_then(|geometry| geometry.strands(&on, &edges));
            for (i, edge) in edges.into_iter().enumerate() {
                let strands = strands.as_ref().map_or(1.0, |strands| strands[i]);
                by_strands.entry(strands.to_bits()).or_default().push(edge);
            }
            flow.line_drag.extend(by_strands.into_iter().map(|(strands, edges)| LineDragSpec {
                edges,
                diameter: f64::from_bits(strands) * diameter,
                coefficient,
            }));
        }
        (None, None, Some(area)) => {
            let Some(on) = drag.on.nodes() else {
                let hint = "a drag_area belongs to bodies at nodes; lines have a diameter and a coefficient";
                return faults.add_hint(&at.key("on"), selects("nodes"), hint);
            };
            let nodes = geometry.and_then(|geometry| select::nodes(&at.key("on"), &on, geometry, faults));
            let Some(nodes) = nodes else { return };
            let drag_area = area / nodes.len() as f64;
            flow.node_drag.push(NodeDragSpec { nodes, drag_area, glide: lift });
        }
        _ => {
            let value = "drag that is neither that of lines nor that of bodies";
            faults.add_value(at, value, "either diameter and coefficient, or drag_area", None);
        }
    }
}
