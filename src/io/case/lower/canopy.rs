//! Canopies that the air fills: their parts, their start, and the pressure over the arc length. What a canopy is,
//! [`crate::mesh::canopy`] decides.

use nalgebra::Vector3;

use super::coefficients::checked_coefficients;
use super::filling::{self, SkirtMotion};
use super::geometry::{Geometry, TriangleUse, triangles};
use super::glide::glide;
use super::numbers::rising;
use super::rings;
use super::select;
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{
    Aero, Canopy, Cavity, ClothLaw, FillingSchedule, NodeSelection, OneOrSeveral, PressureCoefficient,
};
use crate::mesh::canopy::{self, CanopyError, CanopyPart, CanopyParts, SkirtGroup};
use crate::model::spec::{CanopyAir, CanopySpec, CavitySpec, ClothSpec, NetworkSpec, RingsSpec, Series};
use crate::preflight::canopies::tight_cloth;
use crate::warning::Warning;

/// [-] Area that a canopy shows along its axis, over its whole area, below which the air has no direction to fill it.
const OPENING: f64 = 1e-3;

/// Checks and resolves a canopy.
pub(super) fn canopy(
    at: &Pointer,
    canopy: &Canopy,
    geometry: Option<&Geometry>,
    faults: &mut Faults<'_>,
) -> Option<CanopySpec> {
    let before = faults.count();
    let pressure = pressure(at, canopy, faults);
    let glide = canopy.glide.as_ref().and_then(|given| glide(&at.key("glide"), given, faults));
    if canopy.law.is_some() && canopy.schedule.is_none() {
        let hint = "cavity and filling have a law of their own, for table the cloth makes no difference";
        faults.add_value(&at.key("law"), "a law without a schedule", "only beside schedule", Some(hint.to_owned()));
    }
    if canopy.inflow_loss.is_some() && (canopy.cavity.is_some() || canopy.filling.is_some()) {
        let hint = "cavity and filling balance the air that enters by themselves: leave it out";
        let allowed = "only beside table and schedule";
        faults.add_value(&at.key("inflow_loss"), "a loss beside a balance", allowed, Some(hint.to_owned()));
    }
    let geometry = geometry?;
    if !triangles(at, "a canopy", geometry, TriangleUse::Areas, faults) {
        return None;
    }
    let triangles = select::triangles(&at.key("on"), &canopy.on, geometry, faults)?;
    let found = parts_of(at, canopy, geometry, &triangles, faults)?;
    let place =
        |t: u32| geometry.mesh.triangles[t as usize].iter().map(|&n| found.place[n as usize]).sum::<f64>() / 3.0;
    let mut pressure_coefficient = vec![1.0; triangles.len()];
    let air = match pressure? {
        Pressure::Coefficient(rows) => {
            let (t, value) = rows.iter().map(|[s, c]| (*s, [*c])).unzip();
            let table = Series { t, value };
            pressure_coefficient = triangles.iter().map(|&t| table.at(place(t))[0]).collect();
            CanopyAir::Coefficient
        }
        Pressure::Filling(stages) => CanopyAir::Filling(filling::stages(stages, || found.nominal_diameter())),
        Pressure::Cavity(spec) => CanopyAir::Cavity(spec),
        Pressure::Rings(spec) => {
            let rows = rings::rows_of(&at.key("filling"), geometry, &triangles, faults)?;
            CanopyAir::Rings(RingsSpec { rows, ..spec })
        }
    };
    (faults.count() == before).then_some(())?;
    let canopy::Canopy { skirt, apex, confluence, nominal_area, .. } = found;
    let [apparent_mass, inflow_loss] =
        [canopy.apparent_mass, canopy.inflow_loss].map(|factor| factor.filter(|factor| *factor > 0.0));
    let parts = CanopySpec {
        triangles,
        pressure_coefficient,
        skirt,
        apex,
        confluence,
        air,
        apparent_mass,
        inflow_loss,
        glide,
        nominal_area,
    };
    Some(parts)
}

/// What sets the pressure in a canopy, as the case gives it.
enum Pressure<'a> {
    /// \[-\] rows of arc length and dCp
    Coefficient(Vec<[f64; 2]>),
    Filling(&'a OneOrSeveral<FillingSchedule>),
    Cavity(CavitySpec),
    Rings(RingsSpec),
}

/// The one way in which a canopy gives its pressure.
fn pressure<'a>(at: &Pointer, canopy: &'a Canopy, faults: &mut Faults<'_>) -> Option<Pressure<'a>> {
    // Without `..`, so that a new key is a way too or is named here as none.
    let Canopy {
        table,
        schedule,
        cavity,
        filling,
        law: _,
        on: _,
        apparent_mass: _,
        inflow_loss: _,
        glide: _,
        confluence: _,
        skirt: _,
    } = canopy;
    let table = table.as_ref().map(|table| match &table.pressure_coefficient {
        PressureCoefficient::Constant(c) => Some(vec![[0.0, *c]]),
        PressureCoefficient::Rows(rows) => coefficient_rows(&at.key("table").key("pressure_coefficient"), rows, faults),
    });
    if let Some(schedule) = schedule {
        filling::check(&at.key("schedule"), schedule, faults);
    }
    let cavity = cavity.map(|given| lower_cavity(&at.key("cavity"), given, faults));
    let filling = filling.map(|given| rings::lower(&at.key("filling"), given, faults));
    let ways = [
        ("table", table.map(|rows| rows.map(Pressure::Coefficient))),
        ("schedule", schedule.as_ref().map(|stages| Some(Pressure::Filling(stages)))),
        ("cavity", cavity.map(|spec| spec.map(Pressure::Cavity))),
        ("filling", filling.map(|spec| spec.map(Pressure::Rings))),
    ];
    let given: Vec<&str> = ways.iter().filter(|(_, way)| way.is_some()).map(|(key, _)| *key).collect();
    if given.len() != 1 {
        let value = match given.as_slice() {
            [] => "a canopy without pressure".to_owned(),
            several => format!("a canopy with {}", several.join(" and ")),
        };
        let [others @ .., last] = ways.each_ref().map(|(key, _)| *key);
        faults.add_value(at, value, format!("exactly one of {} and {last}", others.join(", ")), None);
    }
    ways.into_iter().find_map(|(_, way)| way).flatten()
}

fn lower_cavity(at: &Pointer, given: Cavity, faults: &mut Faults<'_>) -> Option<CavitySpec> {
    let Cavity { inflow, outer_pressure_coefficient, law } = given;
    let cloth = cloth(&at.key("law"), law, faults)?;
    Some(CavitySpec { inflow, outer_pressure_coefficient, cloth })
}

/// How a cloth lets air through; `Some(None)` for one that does not.
pub(super) fn cloth(at: &Pointer, law: Option<ClothLaw>, faults: &mut Faults<'_>) -> Option<Option<ClothSpec>> {
    let Some(law) = law else { return Some(None) };
    let found = checked_coefficients(at, &law.into(), faults)?;
    Some(Some(ClothSpec { linear: found.linear, quadratic: found.quadratic }))
}

/// Selects the parts of a canopy with these triangles and checks them.
fn parts_of(
    at: &Pointer,
    canopy: &Canopy,
    geometry: &Geometry,
    triangles: &[u32],
    faults: &mut Faults<'_>,
) -> Option<canopy::Canopy> {
    let mesh = &geometry.mesh;
    let confluence = confluence(at, canopy, geometry, faults)?;
    let of_group = SkirtGroup::of(mesh, mesh.groups.get("skirt"), triangles);
    let chosen = match &canopy.skirt {
        Some(selection) => Some(skirt(&at.key("skirt"), selection, geometry, triangles, faults)?),
        None => None,
    };
    let skirt = match &chosen {
        Some(nodes) => CanopyParts { skirt_nodes: nodes, ..CanopyParts::default() },
        None => of_group.parts(),
    };
    let found = canopy::Canopy::of(mesh, CanopyParts { triangles, confluence: &confluence, ..skirt });
    found.map_err(|error| refuse(at, canopy, &error, faults)).ok()
}

/// Adds the fault of what is no canopy, at the key of the part that is wrong.
fn refuse(at: &Pointer, canopy: &Canopy, error: &CanopyError, faults: &mut Faults<'_>) {
    let (key, value, allowed) = match error.part() {
        CanopyPart::Triangles => (
            "on",
            "triangles that do not form a canopy",
            "a canopy in one piece whose triangles all turn the same way, with at most two at an edge and more cloth than vent",
        ),
        CanopyPart::Skirt if canopy.skirt.is_some() => {
            ("skirt", "nodes that are no skirt", "nodes on one closed loop of the canopy's boundary")
        }
        CanopyPart::Skirt => ("on", "a canopy without a skirt", "a canopy with one closed loop as its skirt"),
        CanopyPart::Confluence => {
            ("confluence", "nodes where no lines can meet", "the nodes where the lines meet, below the canopy")
        }
        CanopyPart::Payload => ("confluence", "a payload without a line", "a payload that hangs on the canopy"),
    };
    faults.add_value(&at.key(key), value, allowed, Some(error.to_string()));
}

/// Rows of arc length, within 0 to 1, and coefficient.
fn coefficient_rows(at: &Pointer, rows: &[[f64; 2]], faults: &mut Faults<'_>) -> Option<Vec<[f64; 2]>> {
    rising(at, "arc length", rows.iter().map(|[s, c]| (*s, *c)), faults)?;
    for (i, [s, _]) in rows.iter().enumerate() {
        if !(0.0..=1.0).contains(s) {
            faults.add(&at.index(i), "arc lengths from 0 at the apex to 1 at the skirt");
            return None;
        }
    }
    Some(rows.to_vec())
}

/// The nodes of the skirt that the case selects.
fn skirt(
    at: &Pointer,
    selection: &NodeSelection,
    geometry: &Geometry,
    triangles: &[u32],
    faults: &mut Faults<'_>,
) -> Option<Vec<u32>> {
    let nodes = select::nodes(at, selection, geometry, faults)?;
    let mut has = vec![false; geometry.nodes()];
    let corners = triangles.iter().flat_map(|&t| geometry.mesh.triangles[t as usize]);
    corners.for_each(|node| has[node as usize] = true);
    if let Some(node) = nodes.iter().find(|&&node| !has[node as usize]) {
        let value = format!("node {node}, which no triangle of the canopy has");
        faults.add_value(at, value, "nodes of the canopy", None);
        return None;
    }
    Some(nodes)
}

fn confluence(at: &Pointer, canopy: &Canopy, geometry: &Geometry, faults: &mut Faults<'_>) -> Option<Vec<u32>> {
    let below = at.key("confluence");
    let group = || {
        let known = geometry.mesh.groups.contains_key("confluence");
        known.then(|| NodeSelection::Group("confluence".to_owned()))
    };
    let Some(selection) = canopy.confluence.clone().or_else(group) else {
        let hint = "name the node or nodes where the lines meet, e.g. \"confluence\": {\"ids\": [12]}".to_owned();
        faults.add_value(&below, "(missing)", "an axis: the nodes where the lines meet", Some(hint));
        return None;
    };
    select::nodes(&below, &selection, geometry, faults)
}

/// Finds filling times by the speed at the start. Adds a fault for every canopy that has no axis there, no side towards
/// which the air can fill it, or no speed, and for a payload that hangs on none.
pub(super) fn at_start(at: &Pointer, aero: Option<&Aero>, spec: &mut NetworkSpec, faults: &mut Faults<'_>) {
    let given = aero.and_then(|aero| aero.canopy.as_ref());
    payload(&at.key("canopy"), spec, faults);
    // Without these the motion at the start is a stand-in.
    let network = Pointer::root().key("system").key("network");
    let known = ["supports", "springs", "initial"].iter().all(|key| faults.readable(&network.key(key)));
    for (i, canopy) in given.map_or(&[][..], OneOrSeveral::all).iter().enumerate().take(spec.canopies.len()) {
        let at = match given {
            Some(OneOrSeveral::Several(_)) => at.key("canopy").index(i),
            _ => at.key("canopy"),
        };
        let start = CanopyStart::of(spec, i);
        let before = faults.count();
        start.check(&at, canopy, faults);
        if let (Some(stages), CanopyAir::Filling(filling)) = (&canopy.schedule, &mut spec.canopies[i].air)
            && faults.count() == before
            && known
        {
            filling::at_speed(&at.key("schedule"), stages, filling, start.motion, faults);
            if let Some(cloth) = cloth(&at.key("law"), canopy.law, faults) {
                let warning = tight_cloth(spec, i, cloth, start.motion.speed).map(Warning::from);
                warning.into_iter().for_each(|warning| faults.pass_on(warning));
            }
        }
    }
}

/// Adds the fault of a payload that no springs join to one of the canopies.
fn payload(at: &Pointer, spec: &NetworkSpec, faults: &mut Faults<'_>) {
    let edges = spec.springs.iter().flat_map(|springs| &springs.edges);
    let joined = edges.filter_map(|&edge| spec.mesh.edges.get(edge as usize)).copied();
    let skirts = spec.canopies.iter().map(|canopy| canopy.skirt.as_slice());
    if let Err(error) = canopy::loose_payload(&spec.mesh, joined, skirts) {
        faults.add_value(at, "a payload without a line", "a payload that hangs on the canopy", Some(error.to_string()));
    }
}

/// A canopy at the start of a run.
struct CanopyStart {
    /// [m] from the apex to the confluence
    axis: Result<Vector3<f64>, CanopyError>,
    /// [m^2] sum of the area vectors of its triangles, and of their sizes
    area: (Vector3<f64>, f64),
    /// of the skirt
    motion: SkirtMotion,
}

impl CanopyStart {
    fn of(spec: &NetworkSpec, i: usize) -> Self {
        let canopy = &spec.canopies[i];
        let vector =
            |list: &[[f64; 3]], node: u32| list.get(node as usize).map_or(Vector3::zeros(), |v| Vector3::from(*v));
        let place = |node: u32| spec.mesh.point(node) + vector(&spec.displacement, node);
        let mean = |nodes: &[u32], of: &dyn Fn(u32) -> Vector3<f64>| {
            nodes.iter().map(|&node| of(node)).sum::<Vector3<f64>>() / nodes.len() as f64
        };
        let areas = canopy.triangles.iter().map(|&t| {
            let [a, b, c] = spec.mesh.triangles[t as usize].map(place);
            0.5 * (b - a).cross(&(c - a))
        });
        let area = areas.fold((Vector3::zeros(), 0.0), |(sum, size), s| (sum + s, size + s.norm()));
        let axis = canopy::axis([mean(&canopy.apex, &place), mean(&canopy.confluence, &place)], area.1);
        let stream = spec.stream.as_ref();
        let wind = stream.map_or([0.0; 3], |stream| stream.wind_at(0.0, mean(&canopy.skirt, &place).z));
        let (velocity, wind) = (mean(&canopy.skirt, &|node| vector(&spec.velocity, node)), Vector3::from(wind));
        let motion = SkirtMotion { speed: (velocity - wind).norm(), scale: velocity.norm() + wind.norm() };
        CanopyStart { axis, area, motion }
    }

    fn check(&self, at: &Pointer, canopy: &Canopy, faults: &mut Faults<'_>) {
        let CanopyStart { axis, area: (sum, size), .. } = self;
        // A tube at line stretch shows little.
        let least = if canopy.filling.is_some() { 0.0 } else { OPENING };
        match axis {
            Err(error) => refuse(at, canopy, error, faults),
            Ok(axis) if sum.dot(axis).abs() <= least * size * axis.norm() => {
                let value = "the canopy shows no area along its axis";
                let hint = "the air speed along the axis fills it: lead the axis from the apex through its opening";
                let allowed = "a canopy that is open towards the confluence";
                faults.add_value(&at.key("confluence"), value, allowed, Some(hint.to_owned()));
            }
            Ok(_) => {}
        }
    }
}
