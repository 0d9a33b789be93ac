//! Rounding of coordinates: far from the origin a double has no digits left for the length of a short spring.

use super::geometry::Geometry;
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::format_number::figures;
use crate::model::spec::NetworkSpec;
use crate::warning::WarningCode;

/// [-] Rounding of a coordinate over the shortest spring, above which a scene cannot be computed: fewer than three
/// digits of its length are left, and smaller motions are lost.
const LOST: f64 = 1e-3;

/// [-] The same, above which strains are inaccurate.
const DOUBTFUL: f64 = 1e-8;

/// [-] Share of the motion lost to rounding in each step, above which there is a warning.
const LOST_MOTION: f64 = 0.01;

/// Checks the rounding of coordinates against the lengths of springs, and against the motion of nodes in a step [s].
pub(super) fn network(
    at: &Pointer,
    spec: &NetworkSpec,
    geometry: &Geometry,
    step: Option<f64>,
    faults: &mut Faults<'_>,
) {
    lengths(at, spec, geometry, faults);
    if let Some(step) = step {
        motion(at, spec, step, faults);
    }
}

/// Compares rounding with the shortest spring.
fn lengths(at: &Pointer, spec: &NetworkSpec, geometry: &Geometry, faults: &mut Faults<'_>) {
    let edges = spec.springs.iter().flat_map(|g| g.edges.iter().copied());
    let lengths = edges.filter_map(|e| Some((e, geometry.length.get(e as usize).copied()?)));
    let Some((edge, shortest)) = lengths.min_by(|a, b| a.1.total_cmp(&b.1)) else { return };
    let coordinates = spec.mesh.nodes.as_flattened().iter();
    let largest = coordinates.fold(0.0_f64, |most, x| most.max(x.abs()));
    let rounding = f64::EPSILON * largest;
    let share = rounding / shortest;
    let numbers = || {
        let [x, dx, l] = [largest, rounding, shortest].map(|x| figures(x, 3));
        format!("coordinates of {x} m are rounded to {dx} m, and the spring on edge {edge} is {l} m long")
    };
    let advice = "move the mesh to the origin: results do not depend on its position";
    if share > LOST {
        let allowed = format!("coordinates with a rounding of at most {LOST:e} of the shortest spring's length");
        faults.add_value(&at.key("mesh"), numbers(), allowed, Some(advice.to_owned()));
    } else if share > DOUBTFUL {
        let text = format!("{}: {}; {advice}", at.key("mesh"), numbers());
        faults.warn(WarningCode::RoundedCoordinates, text);
    }
}

/// Compares rounding with the first step of the fastest node: each step loses up to half a last digit.
fn motion(at: &Pointer, spec: &NetworkSpec, step: f64, faults: &mut Faults<'_>) {
    let speeds = spec
        .velocity
        .iter()
        .enumerate()
        .flat_map(|(node, v)| v.iter().enumerate().map(move |(c, v)| (node, c, v.abs())));
    let Some((node, c, speed)) = speeds.max_by(|a, b| a.2.total_cmp(&b.2)) else { return };
    let of = |vectors: &[[f64; 3]]| vectors.get(node).map_or(0.0, |v| v[c]);
    let x = (of(&spec.mesh.nodes) + of(&spec.displacement)).abs();
    let (rounding, moved) = (x.next_up() - x, speed * step);
    let lost = 0.5 * rounding / moved;
    if speed > 0.0 && lost > LOST_MOTION {
        let [speed, moved, step, x, rounding] = [speed, moved, step, x, rounding].map(|x| figures(x, 3));
        let text = format!(
            "{}: node {node} has {speed} m/s, which is {moved} m in a step of {step} s, but its coordinate of {x} m is rounded to \
             {rounding} m: up to {} % of its motion will be lost; take longer steps, or move the mesh to the origin",
            at.key("initial").key("velocity"),
            figures(100.0 * lost.min(1.0), 2)
        );
        faults.warn(WarningCode::LostMotion, text);
    }
}
