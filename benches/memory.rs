//! Live heap memory a node after start-up, without output, of a square cloth of 100,489 nodes.
//!
//! ```text
//! cargo bench -p canopy-fem-benches --bench memory
//! ```

mod fixture;

use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::model::spec::{AirSpec, DashpotKind, DashpotSpec, NetworkSpec, Series};
use canopy_fem::model::system::System;
use canopy_fem::scene::build_network;
use fixture::sheet::sheet;
use fixture::steps::Steps;

#[global_allocator]
static ALLOCATOR: dhat::Alloc = dhat::Alloc;

const SIDE: u32 = 316;

fn damped(air: bool) -> NetworkSpec {
    let mut spec = sheet(SIDE, 1e-4);
    for group in &mut spec.springs {
        group.dashpot = Some(DashpotSpec { kind: DashpotKind::Relative, coefficient: 0.5.into(), from_step: false });
    }
    let wind = Series { t: vec![0.0], value: vec![[0.0, 0.0, 5.0]] };
    let air = air.then_some(AirSpec { linear: 0.0, quadratic: 0.08, wind });
    NetworkSpec { air, ..spec }
}

fn bytes_a_node(method: &str, air: bool) -> f64 {
    let before = dhat::HeapStats::get().curr_bytes;
    let mut scene = build_network(damped(air), Threads::one()).expect("the fixture is sound");
    scene.forget_picture();
    let mut steps = Steps::new(&scene, method, 1e-4);
    steps.step();
    let live = dhat::HeapStats::get().curr_bytes - before;
    live as f64 / (scene.n_dof() / 3) as f64
}

fn main() {
    let _profiler = dhat::Profiler::builder().testing().build();
    println!(
        "velocity-verlet, springs, dashpots, gravity:      {:7.0} bytes a node",
        bytes_a_node("velocity-verlet", false)
    );
    println!(
        "velocity-verlet, the same and air:                {:7.0} bytes a node",
        bytes_a_node("velocity-verlet", true)
    );
    println!("newmark (Cholesky), springs, dashpots, gravity:   {:7.0} bytes a node", bytes_a_node("newmark", false));
}
