//! A force of the program's own: a tether k x to the origin along y. A free mass on it swings as y = cos(w t).
//!
//! ```text
//! cargo run --release --example own_force
//! ```

use canopy_fem::simulation::{NetworkBuilder, NodalForce, RunSettings, Simulation, SpringLaw};
use std::error::Error;
use std::sync::Arc;

/// [N/m] stiffness to the plane y = 0, the same for every node.
struct Tether(f64);

impl NodalForce for Tether {
    fn add(&self, _t: f64, x: &[[f64; 3]], _v: &[[f64; 3]], f: &mut [[f64; 3]]) {
        f.iter_mut().zip(x).for_each(|(f, x)| f[1] -= self.0 * x[1]);
    }
}

/// Returns the largest distance [m] from the closed form, with w = sqrt(8/2) rad/s.
pub fn tethered() -> Result<f64, Box<dyn Error>> {
    let network = NetworkBuilder::new(vec![[0.0, 1.0, 0.0], [0.5, 1.0, 0.0]])
        .springs(&[[0, 1]], SpringLaw { stiffness: 1.0, ..SpringLaw::default() })
        .masses(vec![2.0; 2]);
    let mut sim = Simulation::new(network.build()?, RunSettings::fixed("velocity-verlet", 1e-3, 3.0)?)?;
    sim.set_nodal_law("tether", Arc::new(Tether(8.0)))?;
    let mut worst = 0.0_f64;
    for _ in 0..3000 {
        let t = sim.step()?.t;
        worst = worst.max((sim.positions()[0][1] - (2.0 * t).cos()).abs());
    }
    Ok(worst)
}

#[allow(dead_code)] // the test calls `tethered` itself
fn main() -> Result<(), Box<dyn Error>> {
    tethered().map(|error| println!("largest error {error:.2e} m"))
}
