//! A force of the program's own: a tether k y to the plane y = 0, with its derivatives, so that implicit methods take
//! it too. A free mass on it swings as y = cos(w t).
//!
//! ```text
//! cargo run --release --example own_force
//! ```

use canopy_fem::simulation::{ForceDerivative, NetworkBuilder, NodalForce, RunSpec, Simulation, SpringLaw};
use std::error::Error;
use std::sync::Arc;

/// Ties every node to the plane y = 0.
pub struct Tether {
    /// [N/m]
    pub stiffness: f64,
    /// number of nodes
    pub nodes: u32,
}

impl NodalForce for Tether {
    fn add(&self, _t: f64, x: &[[f64; 3]], _v: &[[f64; 3]], f: &mut [[f64; 3]]) {
        f.iter_mut().zip(x).for_each(|(f, x)| f[1] -= self.stiffness * x[1]);
    }

    fn velocity_dependent(&self) -> bool {
        false
    }

    fn pairs(&self) -> Vec<[u32; 2]> {
        (0..self.nodes).map(|i| [i, i]).collect()
    }

    fn derivatives(&self, _t: f64, _x: &[[f64; 3]], _v: &[[f64; 3]], out: &mut [ForceDerivative]) {
        out.iter_mut().for_each(|d| d.position[1][1] = -self.stiffness);
    }
}

/// Returns the largest distance [m] of a method from the closed form, with w = sqrt(8/2) rad/s.
pub fn tethered(method: &str) -> Result<f64, Box<dyn Error>> {
    let network = NetworkBuilder::new(vec![[0.0, 1.0, 0.0], [0.5, 1.0, 0.0]])
        .springs(&[[0, 1]], SpringLaw { stiffness: 1.0, ..SpringLaw::default() })
        .masses(vec![2.0; 2]);
    let mut sim = Simulation::new(network.build()?, RunSpec::fixed(method, 1e-3, 3.0)?)?;
    sim.set_force_law("tether", Arc::new(Tether { stiffness: 8.0, nodes: 2 }))?;
    let mut worst = 0.0_f64;
    for _ in 0..3000 {
        let t = sim.step()?.time;
        worst = worst.max((sim.positions()[0][1] - (2.0 * t).cos()).abs());
    }
    Ok(worst)
}

#[allow(dead_code)] // the test calls `tethered` itself
fn main() -> Result<(), Box<dyn Error>> {
    for method in ["velocity-verlet", "newmark"] {
        println!("{method}: largest error {:.2e} m", tethered(method)?);
    }
    Ok(())
}
