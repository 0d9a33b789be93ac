//! A ring of rope around the mouth of a canopy, which the air pushes outward: reefed to half its length, then let out
//! again by a winch, while the simulation runs. The account has the winch's work as external work.
//!
//! ```text
//! cargo run --release --example reefing
//! ```

use canopy_fem::model::spec::DashpotKind;
use canopy_fem::simulation::{NetworkBuilder, RunSpec, Simulation, SpringLaw};
use std::error::Error;
use std::f64::consts::PI;

/// Nodes of the ring, force on each [N], stiffness of a piece [N/m] and radius as made [m].
const RING: (u32, f64, f64, f64) = (12, 3.0, 2000.0, 1.0);

/// Returns by how much [m] the ring misses the radius of its equilibrium, at the end of both stages.
pub fn reef() -> Result<f64, Box<dyn Error>> {
    let (n, push, stiffness, radius) = RING;
    let outward = |i: u32| (2.0 * PI * f64::from(i) / f64::from(n)).sin_cos();
    let nodes = (0..n).map(|i| [radius * outward(i).1, radius * outward(i).0, 0.0]).collect();
    let pairs: Vec<[u32; 2]> = (0..n).map(|i| [i, (i + 1) % n]).collect();
    let rope = SpringLaw { stiffness, dashpot: Some((DashpotKind::Relative, 10.0)), ..SpringLaw::default() };
    let mut network = NetworkBuilder::new(nodes).springs(&pairs, rope).total_mass(0.6);
    for i in 0..n {
        network = network.force(&[i], [push * outward(i).1, push * outward(i).0, 0.0]);
    }
    let mut sim = Simulation::new(network.build()?, RunSpec::fixed("velocity-verlet", 1e-3, 20.0)?)?;
    let line = sim.spring_edges();
    let mut worst = 0.0_f64;
    for (until, target) in [(10.0, 0.5), (20.0, 1.0)] {
        let mut factor = sim.rest_scales()[0];
        while sim.time() < until {
            // The winch takes in or lets out 0.5 of the length a second.
            factor += (target - factor).clamp(-0.005, 0.005);
            sim.set_rest_scale(&line, factor)?;
            sim.run_until(sim.time() + 0.01)?;
        }
        // 2 T sin(pi/n) = F, and a piece is 2 r sin(pi/n) = l0 + T/k long.
        let sine = (PI / f64::from(n)).sin();
        let equilibrium = target * radius + push / (4.0 * stiffness * sine * sine);
        let found = sim.positions()[0][0];
        println!("t = {until} s: radius {found:.6} m, {:?}", sim.energies());
        worst = worst.max((found - equilibrium).abs());
    }
    Ok(worst)
}

#[allow(dead_code)] // the test calls `reef` itself
fn main() -> Result<(), Box<dyn Error>> {
    reef().map(|error| println!("off the equilibrium by {error:.2e} m"))
}
