//! Roofs and air-supported structures: wind by zones, snow on the plan, gas in a closed volume.

mod gas;
mod snow;
mod wind;

use crate::common::run::{Rest, as_given, case_of, follow};
use canopy_fem::case::Case;
use canopy_fem::drive::Status;
use canopy_fem::integrate::registry::methods;
use serde_json::Value;

/// \[N\] The sum of all forces that act at the start of a case without springs that are strained.
fn applied(case: &Case) -> [f64; 3] {
    let Rest { forces, reactions, .. } = as_given(case);
    let sum = |list: &[[f64; 3]], axis: usize| list.iter().map(|f| f[axis]).sum::<f64>();
    [0, 1, 2].map(|axis| sum(&forces, axis) - sum(&reactions, axis))
}

fn close(found: [f64; 3], expected: [f64; 3]) {
    let size = expected.iter().fold(1.0, |most: f64, e| most.max(e.abs()));
    let off = found.iter().zip(expected).fold(0.0, |most: f64, (f, e)| most.max((f - e).abs()));
    assert!(off < 1e-10 * size, "{found:?}, expected {expected:?}");
}

/// Every method goes through the case, to where `velocity-verlet` ends within `share` of the way, and no energy is
/// unexplained beyond `share` of what was exchanged.
fn every_method_agrees(mut case: Value, share: f64) {
    // Soft enough for the steps of methods of first order.
    if let Some(modulus) = case.pointer_mut("/system/network/membranes/0/modulus") {
        *modulus = 1e7.into();
    }
    let end = |method: &str| {
        let case = case_of(&case, &[("time.method", &format!("\"{method}\""))]);
        let (mut start, mut last) = (Vec::new(), Vec::new());
        let outcome = follow(&case, |state| {
            if start.is_empty() {
                start = state.positions.to_vec();
            }
            last = state.positions.to_vec();
        });
        assert_eq!(outcome.status, Status::Completed, "{method}: {:?}", outcome.failure);
        assert!(outcome.energy_error < share, "{method}: {}", outcome.energy_error);
        (start, last)
    };
    let apart = |a: &[[f64; 3]], b: &[[f64; 3]]| {
        a.iter().zip(b).flat_map(|(a, b)| [0, 1, 2].map(|c| (a[c] - b[c]).powi(2))).sum::<f64>().sqrt()
    };
    let (start, expected) = end("velocity-verlet");
    let way = apart(&start, &expected);
    assert!(way > 1e-3, "it moves: {way}");
    for method in methods() {
        let (_, found) = end(method.name);
        let off = apart(&found, &expected) / way;
        assert!(off < share, "{}: {off}", method.name);
    }
}
