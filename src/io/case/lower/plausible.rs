//! Doubtful input, which can run but is seldom intended. Every warning is a sentence with its numbers.

use nalgebra::Vector3;

use super::geometry::Geometry;
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::PorousLaw;
use crate::format_number::figures;
use crate::model::spec::{AirSpec, NetworkSpec, PendulumSpec, Slack};
use crate::preflight::air::{FreeStream, excess_pressure};
use crate::warning::WarningCode;

/// [m/s] Speed of sound in air at 15 degrees Celsius: the laws of the air here do not model compression.
const SOUND: f64 = 340.0;

/// [-] Magnitude of the strain above which mesh and rest lengths probably have different units.
const STRAIN: f64 = 0.5;

/// [kg/m^2] Areal densities from the lightest canopy cloth (PIA-C-44378: 0.038) to roof cloth (PTFE on glass: 1.5;
/// PVC on polyester, French type V: 1.45), with a margin for belts and coatings.
const CLOTH: [f64; 2] = [0.03, 1.8];

/// [kg/m^3] Air at sea level and 15 degrees Celsius.
const SEA_LEVEL: f64 = 1.225;

/// [-] Grams in a kilogram.
const GRAMS: f64 = 1e3;

/// A property of cloth and lines: its usual range with a margin, and a smaller or larger unit that people give it in.
struct Usual {
    key: &'static str,
    unit: &'static str,
    range: [f64; 2],
    of: &'static str,
    /// names of other units, with how many of the case's unit they are
    other_units: &'static [(&'static str, f64)],
}

/// Moduli from soft rubber to carbon, films of a micrometre to thick rubber sheets, and lines from elastic thread on.
/// Bars of any high rigidity are links that do not stretch.
const USUAL: [Usual; 3] = [
    Usual {
        key: "modulus",
        unit: "Pa",
        range: [1e4, 1e12],
        of: "cloth has 1e5 to 1e11",
        other_units: &[("MPa", 1e6), ("GPa", 1e9)],
    },
    Usual {
        key: "thickness",
        unit: "m",
        range: [1e-7, 1e-2],
        of: "cloth has 1e-5 to 2e-3",
        other_units: &[("mm", 1e-3), ("micrometres", 1e-6)],
    },
    Usual {
        key: "axial_rigidity",
        unit: "N",
        range: [10.0, f64::INFINITY],
        of: "lines have 1e2 to 1e6",
        other_units: &[("kN", 1e3)],
    },
];

/// Warns about a modulus, a thickness or an axial rigidity that no cloth and no line has; `at` leads to its key, or to
/// the entry of a list there.
pub(super) fn material(at: &Pointer, key: &str, value: f64, faults: &mut Faults<'_>) {
    let Some(Usual { unit, range: [low, high], of, other_units, .. }) = USUAL.iter().find(|usual| usual.key == key)
    else {
        return;
    };
    if value.is_nan() || value <= 0.0 || (*low..=*high).contains(&value) {
        return;
    }
    let meant = other_units.iter().find(|(_, size)| (100.0 * low..=0.5 * high).contains(&(value * size)));
    let question = meant.map_or(String::new(), |(name, _)| format!("; is it in {name}?"));
    let text = format!("{at}: {} {unit}, where {of} {unit}{question}", figures(value, 4));
    faults.warn(WarningCode::UnlikelyMaterial, text);
}

/// Warns about a network that can run but is seldom intended.
pub(super) fn network(at: &Pointer, spec: &NetworkSpec, geometry: &Geometry, faults: &mut Faults<'_>) {
    if spec.air.is_some() || spec.stream.is_some() {
        let fastest = spec.fastest_wind();
        speed(&at.key("aero").key("wind"), "the wind", fastest, faults);
    }
    let speeds = spec.velocity.iter().map(|v| Vector3::from(*v).norm());
    if let Some((node, fastest)) = speeds.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)) {
        speed(&at.key("initial").key("velocity"), &format!("node {node}"), fastest, faults);
    }
    strain(at, spec, geometry, faults);
    areal_density(at, spec, geometry, faults);
}

/// Warns about an air pressure on cloth across the fastest wind that is larger than that of a free stream.
pub(super) fn pressure(at: &Pointer, law: &PorousLaw, spec: &NetworkSpec, faults: &mut Faults<'_>) {
    let Some(AirSpec { linear, quadratic, wind }) = &spec.air else { return };
    let (density, coefficient) = match law {
        PorousLaw::Ergun(ergun) => (ergun.air_density, false),
        // The law has no density of its own.
        PorousLaw::Permeable(_) => (SEA_LEVEL, false),
        PorousLaw::PressureCoefficient(law) => (law.air_density, true),
        PorousLaw::SurfacePressure(_) => return,
    };
    let winds = || wind.value.iter().map(|w| Vector3::from(*w));
    let first = winds().next().unwrap_or_default();
    let against = spec.velocity.iter().map(|v| (first - Vector3::from(*v)).norm());
    let fall = fall(spec, [*linear, *quadratic]).into_iter();
    let speed = winds().map(|w| w.norm()).chain(against).chain(fall).fold(0.0, f64::max);
    let stream = FreeStream { linear: *linear, quadratic: *quadratic, density, speed, coefficient };
    if let Some(excess) = excess_pressure(stream) {
        faults.warn(WarningCode::AirPressure, format!("{at}: {excess}"));
    }
}

/// [m/s] The speed V at which all cloth, held across the air, would carry the weight of a scene without supports:
/// a V + b V^2 = weight/area.
fn fall(spec: &NetworkSpec, [a, b]: [f64; 2]) -> Option<f64> {
    let gravity = Vector3::from(spec.gravity.filter(|_| !spec.fixed.as_flattened().contains(&true))?).norm();
    let point = |node: u32| spec.mesh.point(node);
    let areas =
        spec.mesh.triangles.iter().map(|&[a, b, c]| 0.5 * (point(b) - point(a)).cross(&(point(c) - point(a))).norm());
    let pressure = gravity * spec.mass.iter().sum::<f64>() / areas.sum::<f64>();
    let speed = 2.0 * pressure / (a + (a * a + 4.0 * b * pressure).sqrt());
    speed.is_finite().then_some(speed)
}

/// Warns about a pendulum that starts too fast.
pub(super) fn pendulum(at: &Pointer, spec: &PendulumSpec, faults: &mut Faults<'_>) {
    speed(&at.key("rate"), "the bob", (spec.rate * spec.length).abs(), faults);
}

fn speed(at: &Pointer, what: &str, speed: f64, faults: &mut Faults<'_>) {
    if speed > SOUND {
        let text = format!(
            "{at}: {what} has {} m/s, {} times the speed of sound ({SOUND} m/s); no force of this program models compressible flow",
            figures(speed, 4),
            figures(speed / SOUND, 3)
        );
        faults.warn(WarningCode::SupersonicSpeed, text);
    }
}

/// Whether the second length [m] is the first in another unit: some thousand times as long.
fn in_millimetres(metres: f64, other: f64) -> bool {
    (800.0..1250.0).contains(&(other / metres))
}

fn strain(at: &Pointer, spec: &NetworkSpec, geometry: &Geometry, faults: &mut Faults<'_>) {
    let springs = spec.springs.iter().flat_map(|group| {
        let scale = group.rest_scale_at_start();
        let tension_only = matches!(group.slack, Slack::TensionOnly | Slack::DeadZone { .. });
        group.edges.iter().zip(&group.rest_length).map(move |(edge, rest)| (edge, scale * rest, tension_only))
    });
    let strained = springs.filter_map(|(&edge, rest, tension_only)| {
        let l = geometry.start_length(edge, &spec.displacement)?;
        // A spring without rest length has no strain.
        let strain = if rest > 0.0 { (l - rest) / rest } else { 0.0 };
        // Cloth that starts folded carries nothing.
        let folded = tension_only && strain < 0.0 && !in_millimetres(l, rest);
        (strain.abs() > STRAIN && !folded).then_some((strain, edge, l, rest))
    });
    let mut count = 0_usize;
    let worst = strained.inspect(|_| count += 1).max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    if let Some((strain, edge, length, rest)) = worst {
        let others = if count > 1 { format!(", as do {count} springs in all") } else { String::new() };
        let question = match in_millimetres(length, rest) || in_millimetres(rest, length) {
            true => "one is a thousand times the other: is it in millimetres?",
            false => "are all lengths in metres?",
        };
        let text = format!(
            "{}: the spring on edge {edge} starts with a strain of {} (length {} m, rest length {} m), beyond {STRAIN} in \
             size{others}; {question}",
            at.key("springs"),
            figures(strain, 3),
            figures(length, 4),
            figures(rest, 4)
        );
        faults.warn(WarningCode::InitialStrain, text);
    }
}

/// Whether triangles are a cover of a net of cables: there are springs, but no triangle has them on all its sides, nor
/// a membrane.
fn only_covers(spec: &NetworkSpec, geometry: &Geometry) -> bool {
    let (mut seen, mut sides) = (vec![false; spec.mesh.edges.len()], vec![0; spec.mesh.triangles.len()]);
    let edges = spec.springs.iter().flat_map(|group| &group.edges);
    // An edge with several springs counts once.
    let once = edges.filter(|edge| !std::mem::replace(&mut seen[**edge as usize], true));
    once.flat_map(|edge| geometry.topology.edge_triangles(*edge as usize)).for_each(|t| sides[*t as usize] += 1);
    seen.contains(&true) && spec.membranes.is_empty() && !sides.contains(&3)
}

/// The mass of the triangles' nodes over the triangles' area: a payload on lines does not count.
fn areal_density(at: &Pointer, spec: &NetworkSpec, geometry: &Geometry, faults: &mut Faults<'_>) {
    if only_covers(spec, geometry) {
        return;
    }
    let mut cloth = vec![false; spec.mass.len()];
    for &node in spec.mesh.triangles.as_flattened() {
        if let Some(flag) = cloth.get_mut(node as usize) {
            *flag = true;
        }
    }
    let mass: f64 = spec.mass.iter().zip(&cloth).filter(|(_, cloth)| **cloth).map(|(mass, _)| mass).sum();
    let area: f64 = geometry.area.iter().sum();
    let density = mass / area;
    let [light, heavy] = CLOTH;
    if density.is_finite() && !(light..=heavy).contains(&density) {
        let grams = (light..=heavy).contains(&(density / GRAMS));
        let text = format!(
            "{}: {} kg on {} m^2 of triangles are {} kg/m^2; cloth has {light} to {heavy}{}",
            at.key("mass"),
            figures(mass, 4),
            figures(area, 4),
            figures(density, 3),
            if grams { "; is the mass in grams?" } else { "" }
        );
        faults.warn(WarningCode::ArealDensity, text);
    }
}
