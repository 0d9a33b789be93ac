//! Digits that coordinates leave to lengths: far from the origin a double has none left for a short spring.

use super::geometry::Geometry;
use crate::case::fault::Faults;
use crate::case::pointer::Pointer;
use crate::figures::figures;
use crate::model::spec::NetworkSpec;

/// [-] Rounding of a coordinate over the shortest spring from which on a scene cannot be computed: fewer than three digits of its
/// length are left, and motions smaller than that are lost without a trace.
const LOST: f64 = 1e-3;

/// [-] The same from which on strains are doubtful.
const DOUBTFUL: f64 = 1e-8;

/// Checks the mesh's place against its springs.
pub(super) fn network(at: &Pointer, spec: &NetworkSpec, geometry: &Geometry, faults: &mut Faults<'_>) {
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
    let advice = "move the mesh to the origin: nothing here depends on where it is";
    if share > LOST {
        let allowed = format!("coordinates that leave {LOST:e} of the shortest spring's length");
        faults.add_value(&at.key("mesh"), numbers(), allowed, Some(advice.to_owned()));
    } else if share > DOUBTFUL {
        faults.warn(format!("{}: {}; {advice}", at.key("mesh"), numbers()));
    }
}
