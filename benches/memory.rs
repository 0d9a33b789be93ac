//! Live heap memory a node after start-up, without output, of a square cloth of 100,489 nodes.
//!
//! ```text
//! cargo bench --bench memory
//! ```

use canopy_fem::force::threads::Threads;
use canopy_fem::integrate::Counters;
use canopy_fem::integrate::implicit::SolverSpec;
use canopy_fem::integrate::registry::MethodChoice;
use canopy_fem::integrate::stepper::{Attempt, Stepper};
use canopy_fem::mesh::source::MeshSource;
use canopy_fem::model::point::Point;
use canopy_fem::model::spec::*;
use canopy_fem::model::system::System;
use canopy_fem::scene::{Scene, build_network};
use std::collections::BTreeMap;
use std::path::Path;

#[global_allocator]
static ALLOCATOR: dhat::Alloc = dhat::Alloc;

const SIDE: u32 = 316;

fn sheet(air: bool) -> NetworkSpec {
    let json = serde_json::json!({"rectangle": {
        "width": 1.0, "height": 1.0, "columns": SIDE, "rows": SIDE, "pattern": "regular"
    }});
    let source: MeshSource = serde_json::from_value(json).expect("a known generator");
    let mesh = source.build(Path::new(".")).expect("a rectangle");
    let (n, m) = (mesh.nodes.len(), mesh.edges.len());
    let length = |&[a, b]: &[u32; 2]| {
        let at = |i: u32| glam::DVec3::from_array(mesh.nodes[i as usize]);
        at(a).distance(at(b))
    };
    let rest_length = mesh.edges.iter().map(length).collect();
    let dashpot = Some(DashpotSpec { kind: DashpotKind::Relative, coefficient: vec![0.5; m], from_step: false });
    let springs = vec![SpringGroup {
        edges: (0..m as u32).collect(),
        stiffness: vec![1000.0; m],
        rest_length,
        slack: Slack::None,
        dashpot,
    }];
    let fixed = mesh.nodes.iter().map(|p| [p[0] < 1e-9; 3]).collect();
    let wind = Series { t: vec![0.0], value: vec![[0.0, 0.0, 5.0]] };
    let air = air.then_some(AirSpec { linear: 0.0, quadratic: 0.08, wind });
    NetworkSpec {
        mesh,
        mass: vec![1e-4; n],
        fixed,
        springs,
        gravity: Some([0.0, 0.0, -9.81]),
        air,
        ..Default::default()
    }
}

fn bytes_a_node(method: &str, air: bool) -> f64 {
    let before = dhat::HeapStats::get().curr_bytes;
    let mut scene = build_network(sheet(air), Threads::one()).expect("the fixture is sound");
    scene.forget_picture();
    let choice = MethodChoice::new(method, &BTreeMap::new()).expect("registered");
    let mut stepper = Stepper::bind(choice.scheme(SolverSpec::default()), scene.abilities()).expect("a network");
    let mut from = Point { state: scene.initial_state(), forces: scene.new_forces() };
    scene.evaluate(from.state.as_ref(), &mut from.forces);
    stepper.start(&from).expect("enough memory");
    let mut to = from.clone();
    let h = 1e-4;
    stepper.attempt(Attempt { from: &from, h, t_next: h }, &mut to, &mut Counters::default()).expect("an easy step");
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
