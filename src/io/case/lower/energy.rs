//! The energy of the initial state, which must be finite.

use nalgebra::Vector3;

use super::geometry::Geometry;
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::format_number::figures;
use crate::model::spec::{NetworkSpec, PendulumSpec};

const ALLOWED: &str = "a start whose energy is within the range of a double";

/// Adds a fault for a kinetic or elastic energy at the start that overflows.
pub(super) fn network(at: &Pointer, spec: &NetworkSpec, geometry: &Geometry, faults: &mut Faults<'_>) {
    let speeds = spec.velocity.iter().map(|v| Vector3::from(*v));
    let kinetic = speeds.zip(&spec.mass).map(|(v, m)| 0.5 * m * v.norm_squared());
    if let Some(node) = first_overflow(kinetic) {
        let [x, y, z] = spec.velocity.get(node).copied().unwrap_or_default().map(|v| figures(v, 4));
        let value = format!("node {node} at ({x}, {y}, {z}) m/s");
        faults.add_value(&at.key("initial").key("velocity"), value, ALLOWED, None);
    }
    let length = |edge: u32| geometry.start_length(edge, &spec.displacement).unwrap_or_default();
    let springs = || {
        spec.springs.iter().flat_map(|g| {
            let scale = g.rest_scale_at_start();
            let values = g.edges.iter().zip(g.stiffness.of(g.edges.len()).zip(&g.rest_length));
            values.map(move |(&edge, (k, &rest))| (edge, k, scale * rest))
        })
    };
    let elastic = springs().map(|(edge, k, rest)| 0.5 * k * (length(edge) - rest).powi(2));
    if let Some((edge, k, rest)) = first_overflow(elastic).and_then(|i| springs().nth(i)) {
        let value = format!(
            "the spring on edge {edge} with {} N/m, {} m long at rest, starts with a length of {} m",
            figures(k, 4),
            figures(rest, 4),
            figures(length(edge), 4)
        );
        faults.add_value(&at.key("springs"), value, ALLOWED, None);
    }
}

/// The same for a pendulum.
pub(super) fn pendulum(at: &Pointer, spec: &PendulumSpec, faults: &mut Faults<'_>) {
    let speed = spec.rate * spec.length;
    if !(spec.mass * speed * speed).is_finite() {
        let value = format!("the bob at {} m/s", figures(speed, 4));
        faults.add_value(&at.key("rate"), value, ALLOWED, None);
    }
}

/// The first term at which a sum of energies [J] is not finite.
fn first_overflow(energies: impl Iterator<Item = f64>) -> Option<usize> {
    let mut sum = 0.0;
    energies.into_iter().position(|e| {
        sum += e;
        !sum.is_finite()
    })
}
