//! Every method on the damped oscillator of the thesis' Appendix A: error against the closed form, and what it cost.
//!
//! ```text
//! cargo run --release --example compare_methods
//! ```

use canopy_fem::case::Case;
use canopy_fem::drive::observer::{LedgerRow, ObserveError, Observer, Point, StepView};
use canopy_fem::drive::{RunSpec, run};
use canopy_fem::integrate::registry::methods;
use canopy_fem::simulation::{bind, build_scene};
use std::error::Error;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Keeps the largest distance to the closed form. The mass is the only node that moves, so the largest displacement is its own.
struct Against {
    exact: fn(f64) -> f64,
    /// [m] position without displacement, along x
    rest: f64,
    dof: usize,
    worst: f64,
}

impl Observer for Against {
    fn started(&mut self, at: &Point, _ledger: LedgerRow) -> Result<(), ObserveError> {
        // The degree of freedom that starts displaced by x0 = 2 m is the mass' x.
        let offset = |x: &f64| (x - self.rest - 2.0).abs();
        let nearest = (0..at.state.x.len()).min_by(|&a, &b| offset(&at.state.x[a]).total_cmp(&offset(&at.state.x[b])));
        self.dof = nearest.unwrap_or(0);
        Ok(())
    }

    fn accepted(&mut self, step: StepView<'_>) -> Result<(), ObserveError> {
        let state = &step.to.state;
        self.worst = self.worst.max((state.x[self.dof] - self.rest - (self.exact)(state.t)).abs());
        Ok(())
    }

    fn finished(&mut self, _last: &Point) -> Result<(), ObserveError> {
        Ok(())
    }
}

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
    let mut errors = Vec::new();
    println!("{:<20} {:>13} {:>13} {:>15}", "method", "error [m]", "force passes", "factorisations");
    for method in methods() {
        let set = [("time.method".to_owned(), method.name.to_owned()), ("time.step".to_owned(), "0.01".to_owned())];
        let mut problem = Case::from_file(&path, &set)?.into_problem();
        let scene = build_scene(problem.take_system(), 1)?;
        let mut stepper = bind(&problem, &*scene)?;
        let rest = scene.reference().iter().map(|p| p[0]).fold(f64::NEG_INFINITY, f64::max);
        let mut against = Against { exact: closed_form, rest, dof: 0, worst: 0.0 };
        let spec = RunSpec { end: problem.time.end, step: problem.time.step, keep_going: false, method };
        let outcome = run(&*scene, &mut stepper, spec, &mut [&mut against], &AtomicBool::new(false))?;
        let c = outcome.counters;
        println!("{:<20} {:>13.3e} {:>13} {:>15}", method.name, against.worst, c.force_evaluations, c.factorizations);
        errors.push((method.name, against.worst));
    }
    Ok(errors)
}

#[allow(dead_code)] // the test calls `compare` itself
fn main() -> Result<(), Box<dyn Error>> {
    compare().map(|_| ())
}
