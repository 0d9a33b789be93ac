//! A square metre of cloth made in code, held along one edge, swings down: undamped springs that go slack, implicit
//! Newmark. In steps of 2 ms instead of 0.2 ms Newmark makes energy; the account shows it as `numerical`.
//!
//! ```text
//! cargo run --release --example cloth_by_hand
//! ```

use canopy_fem::drive::observer::Energies;
use canopy_fem::mesh::source::MeshSource;
use canopy_fem::model::spec::Slack;
use canopy_fem::simulation::{NetworkBuilder, RunSpec, Simulation, SpringLaw};
use std::error::Error;
use std::path::Path;

/// Swings the cloth for half a second; returns the energy account at the end.
pub fn swing() -> Result<Energies, Box<dyn Error>> {
    let rectangle = r#"{"rectangle": {"width": 1, "height": 1, "columns": 12, "rows": 12, "pattern": "crossed"}}"#;
    let mesh = serde_json::from_str::<MeshSource>(rectangle)?.build(Path::new("."))?;
    let cloth = NetworkBuilder::from_mesh(mesh)
        .springs_on_edges(SpringLaw { stiffness: 500.0, slack: Slack::TensionOnly, ..SpringLaw::default() })
        .total_mass(0.05)
        .hold(|_, x| x[0] == 0.0)
        .gravity([0.0, 0.0, -9.81]);
    let mut sim = Simulation::new(cloth.build()?, RunSpec::fixed("newmark", 2e-4, 0.5)?)?;
    sim.run_until(0.5)?;
    println!("t = {} s after {} steps: {:#?}", sim.time(), sim.step_count(), sim.energies());
    Ok(sim.energies())
}

#[allow(dead_code)] // the test calls `swing` itself
fn main() -> Result<(), Box<dyn Error>> {
    swing().map(|_| ())
}
