//! Runs the damped oscillator of the thesis' Appendix A with every method and prints what each is off from the closed
//! form, and what it cost.
//!
//! ```text
//! cargo run --release --example compare_methods
//! ```

use canopy_fem::case::Case;
use canopy_fem::integrate::registry::methods;
use canopy_fem::simulation::{FollowSpec, follow};
use std::error::Error;
use std::path::Path;

/// Appendix A with Eq. 80 corrected: k = 3 N/m, m = 2 kg, c = 0.5 N s/m, x0 = 2 m, v0 = 0.
fn closed_form(t: f64) -> f64 {
    let (k, m, c, x0) = (3.0f64, 2.0, 0.5, 2.0);
    let w = (4.0 * m * k - c * c).sqrt() / (2.0 * m);
    let b = c * x0 / (2.0 * m * w);
    (x0 * x0 + b * b).sqrt() * (-c * t / (2.0 * m)).exp() * (w * t + x0.atan2(b)).sin()
}

/// Runs all methods; returns name and largest error [m] of each.
pub fn compare() -> Result<Vec<(&'static str, f64)>, Box<dyn Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/cases/oscillator-damped.json");
    let base = Case::from_file(&path, &[("time.step".to_owned(), "0.01".to_owned())])?;
    let mut errors = Vec::new();
    println!("{:<20} {:>13} {:>13} {:>15}", "method", "error [m]", "force passes", "factorisations");
    for method in methods() {
        let case = base.with(&[("time.method".to_owned(), method.name.to_owned())])?;
        let mut worst = 0.0_f64;
        // Node 0 is the anchor, node 1 the mass.
        let outcome = follow(case.problem(), FollowSpec::default(), |seen| {
            let x = seen.positions[1][0] - seen.reference[1][0];
            worst = worst.max((x - closed_form(seen.t)).abs());
        })?;
        let c = outcome.counters;
        println!("{:<20} {:>13.3e} {:>13} {:>15}", method.name, worst, c.force_evaluations, c.factorizations);
        errors.push((method.name, worst));
    }
    Ok(errors)
}

#[allow(dead_code)] // the test calls `compare` itself
fn main() -> Result<(), Box<dyn Error>> {
    compare().map(|_| ())
}
