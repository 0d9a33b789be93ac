//! An observer of the program's own: it sees the account of every step, and the state of every hundredth only.
//!
//! ```text
//! cargo run --release --example own_observer
//! ```

use canopy_fem::drive::observer::{AcceptedStep, ObserveError, Observer, UpcomingStep, Wants};
use canopy_fem::simulation::{NetworkBuilder, RunSpec, Simulation, SpringLaw};
use std::error::Error;

/// Compares the kinetic energy of every hundredth state with that of x = 1 + 0.5 cos(2 t).
#[derive(Default)]
struct Compare {
    accounts: u64,
    worst: f64,
}

impl Observer for Compare {
    fn wants(&self, step: UpcomingStep) -> Wants {
        Wants::end_if(step.step.is_multiple_of(100))
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        self.accounts += 1;
        if let Some(end) = step.end.filter(|_| step.step.is_multiple_of(100)) {
            // Kinetic energy does not depend on the engine's numbering: 1/2 m (0.5 w sin(w t))^2.
            let kinetic = end.state.v.iter().map(|v| v * v).sum::<f64>();
            self.worst = self.worst.max((kinetic - (2.0 * step.t).sin().powi(2)).abs());
        }
        Ok(())
    }
}

/// Returns the largest error of the kinetic energy [J] of 2 kg at 2 rad/s.
pub fn compare_states() -> Result<f64, Box<dyn Error>> {
    let network = NetworkBuilder::new(vec![[0.0; 3], [1.5, 0.0, 0.0]])
        .springs(&[[0, 1]], SpringLaw { stiffness: 8.0, rest_length: Some(1.0), ..SpringLaw::default() })
        .masses(vec![2.0; 2])
        .hold(|node, _| node == 0);
    let mut sim = Simulation::new(network.build()?, RunSpec::fixed("velocity-verlet", 1e-3, 3.0)?)?;
    let mut compare = Compare::default();
    sim.run_until_with(3.0, &mut [&mut compare])?;
    assert_eq!(compare.accounts, 3000);
    Ok(compare.worst)
}

#[allow(dead_code)] // the test calls `compare_states` itself
fn main() -> Result<(), Box<dyn Error>> {
    compare_states().map(|error| println!("largest error {error:.2e} J"))
}
