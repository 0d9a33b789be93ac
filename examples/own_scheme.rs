//! A scheme of the program's own: it drifts first, and then kicks by the forces at the new positions.
//!
//! ```text
//! cargo run --release --example own_scheme
//! ```

use canopy_fem::drive::clock::Step;
use canopy_fem::integrate::linear_step::LinearStep;
use canopy_fem::integrate::registry::{Family, MethodChoice, MethodInfo};
use canopy_fem::integrate::stepper::Scheme;
use canopy_fem::integrate::{Counters, Integrator, StepError, StepInput, StepReport};
use canopy_fem::model::point::Point;
use canopy_fem::model::system::System;
use canopy_fem::simulation::{NetworkBuilder, RunSpec, Simulation, SpringLaw};
use std::collections::BTreeMap;
use std::error::Error;

/// x_{n+1} = x_n + h v_n, v_{n+1} = v_n + h M^-1 f(x_{n+1}, v_n)
struct DriftKick;

impl Integrator<dyn System> for DriftKick {
    fn start(&mut self, _system: &dyn System, _at: &Point) -> Result<(), StepError> {
        Ok(())
    }

    fn attempt(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn System>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        to.state.t = t_next;
        to.state.v.copy_from_slice(&from.state.v);
        for ((to, x), v) in to.state.x.iter_mut().zip(&from.state.x).zip(&from.state.v) {
            *to = x + h * v;
        }
        counters.evaluate(system, to.state.as_ref(), &mut to.forces);
        for ((v, f), inverse) in to.state.v.iter_mut().zip(&to.forces.total).zip(system.inverse_mass()) {
            *v += h * inverse * f;
        }
        // The forces are those at the new positions; only those that depend on velocity would differ.
        Ok(StepReport { forces_at_end: !system.velocity_dependent(), ..StepReport::default() })
    }
}

static DRIFT_KICK: MethodInfo = MethodInfo {
    name: "drift-kick",
    order: 1,
    order_with: None,
    family: Family::Explicit,
    color: 0,
    evaluations: [1, 1],
    parameters: &[],
    stability: "w h < 2",
    linear: LinearStep::PARTITIONED,
    source: "the adjoint of Euler-Cromer",
    build: |_, _| Scheme::Explicit(Box::new(DriftKick)),
};

/// Returns the largest distance [m] of an oscillator of 2 rad/s from x = 1 + 0.5 cos(2 t).
pub fn drift_kick() -> Result<f64, Box<dyn Error>> {
    let network = NetworkBuilder::new(vec![[0.0; 3], [1.5, 0.0, 0.0]])
        .springs(&[[0, 1]], SpringLaw { stiffness: 8.0, rest_length: Some(1.0), ..SpringLaw::default() })
        .masses(vec![2.0; 2])
        .hold(|node, _| node == 0);
    let method = MethodChoice::of(&DRIFT_KICK, &BTreeMap::new())?;
    let mut sim = Simulation::new(network.build()?, RunSpec::of(method, Step::Fixed(1e-4), 3.0))?;
    let mut worst = 0.0_f64;
    while sim.time() < 3.0 {
        let t = sim.step()?.time;
        worst = worst.max((sim.positions()[1][0] - (1.0 + 0.5 * (2.0 * t).cos())).abs());
    }
    Ok(worst)
}

#[allow(dead_code)] // the test calls `drift_kick` itself
fn main() -> Result<(), Box<dyn Error>> {
    drift_kick().map(|error| println!("largest error {error:.2e} m"))
}
