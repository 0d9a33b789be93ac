//! A law of bars of the program's own: T = k (l - l0)^3, with implicit Newmark. Energy gives speed by elongation.
//!
//! ```text
//! cargo run --release --example own_bar_law
//! ```

use canopy_fem::drive::clock::Tolerance;
use canopy_fem::simulation::{BarForce, BarLaw, Bars, NetworkBuilder, RunSpec, Simulation};
use std::error::Error;
use std::sync::Arc;

/// [N/m^3]
struct Cubic(f64);

impl BarLaw for Cubic {
    fn at(&self, length: f64, rest_length: f64) -> BarForce {
        let e = length - rest_length;
        BarForce { tension: self.0 * e.powi(3), stiffness: 3.0 * self.0 * e * e, energy: 0.25 * self.0 * e.powi(4) }
    }
}

/// Pulls a mass of 2 kg by 0.5 m and lets go. Returns how far 1/2 m v^2 + 1/4 k e^4 = 1/4 k 0.5^4 is missed [m], as an
/// elongation.
pub fn cubic() -> Result<f64, Box<dyn Error>> {
    let (k, m) = (100.0, 2.0);
    let network = NetworkBuilder::new(vec![[0.0; 3], [1.5, 0.0, 0.0]]).masses(vec![m; 2]).hold(|node, _| node == 0);
    let bars = Bars { pairs: vec![[0, 1]], rest_length: vec![1.0], law: Arc::new(Cubic(k)) };
    let tolerance = Tolerance { relative: 1e-5, absolute: 1e-7 };
    let mut sim = Simulation::with_bars(network.build()?, &[bars], RunSpec::adaptive("newmark", tolerance, 1.0)?)?;
    let mut worst = 0.0_f64;
    while sim.time() < 1.0 {
        sim.step()?;
        let (e, v) = (sim.positions()[1][0] - 1.0, sim.velocities()[1][0]);
        let amplitude = (e.powi(4) + 2.0 * m / k * v * v).powf(0.25);
        worst = worst.max((amplitude - 0.5).abs());
    }
    Ok(worst)
}

#[allow(dead_code)] // the test calls `cubic` itself
fn main() -> Result<(), Box<dyn Error>> {
    cubic().map(|error| println!("largest error {error:.2e} m"))
}
