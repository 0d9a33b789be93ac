//! Contact against closed forms: a mass on a slope, lines over edges and round a cylinder, a chain on a scale, a tube
//! between plates, sheets that meet; and what must not change, the bits of runs in which nothing touches.

pub mod capstan;
pub mod chain;
pub mod limit;
pub mod load;
pub mod mass;
pub mod order;
pub mod sheets;
pub mod tube;

use serde_json::{Value, json};

/// [m/s] Speed below which friction is smoothed: what it holds creeps by less.
const CREEP: f64 = 1e-3;
/// [m/s^2]
const G: f64 = 9.81;

/// -b' of the barrier at a share s of the gap (Li et al. 2020): the push over kappa g0.
fn push(s: f64) -> f64 {
    let left = 1.0 - s;
    left * left / s - 2.0 * left * s.ln()
}

/// [-] Where the push over kappa g0 is this much: it falls from s = 0 to s = 1.
fn share_of_gap(wanted: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..100 {
        let s = 0.5 * (low + high);
        *(if push(s) > wanted { &mut low } else { &mut high }) = s;
    }
    0.5 * (low + high)
}

/// The plane z = 0, solid below.
fn ground() -> Value {
    json!({"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}})
}
