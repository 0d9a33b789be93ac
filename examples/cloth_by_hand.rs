//! A scene built without a case file: a square metre of cloth held along one edge swings down, with implicit Newmark.
//!
//! The springs are undamped and go slack, on which Newmark 1/4 makes energy in large steps: at 2 ms instead of 0.2 ms
//! the ledger's `numerical` shows hundreds of joules out of nothing.
//!
//! ```text
//! cargo run --release --example cloth_by_hand
//! ```

use canopy_fem::drive::clock::Step;
use canopy_fem::drive::observer::LedgerRow;
use canopy_fem::drive::{Explain, RunSpec, run};
use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::integrate::implicit::SolverSpec;
use canopy_fem::integrate::registry::MethodChoice;
use canopy_fem::integrate::stepper::Stepper;
use canopy_fem::mesh::source::MeshSource;
use canopy_fem::model::spec::{NetworkSpec, Slack, SpringGroup};
use canopy_fem::model::stop::Stop;
use canopy_fem::scene::{Scene, build_network};
use std::error::Error;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Swings the cloth for half a second; returns the energy ledger at the end.
pub fn swing() -> Result<LedgerRow, Box<dyn Error>> {
    let source: MeshSource = serde_json::from_str(
        r#"{"rectangle": {"width": 1.0, "height": 1.0, "columns": 12, "rows": 12, "pattern": "crossed"}}"#,
    )?;
    let mesh = source.build(Path::new("."))?;
    let (nodes, edges) = (mesh.nodes.len(), mesh.edges.len());
    let length = |&[a, b]: &[u32; 2]| {
        let [a, b] = [a, b].map(|i| mesh.nodes[i as usize]);
        (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
    };
    let springs = SpringGroup {
        edges: (0..edges as u32).collect(),
        stiffness: vec![500.0; edges],
        rest_length: mesh.edges.iter().map(length).collect(),
        slack: Slack::TensionOnly,
        dashpot: None,
    };
    let spec = NetworkSpec {
        mass: vec![0.05 / nodes as f64; nodes],
        fixed: mesh.nodes.iter().map(|p| [p[0] == 0.0; 3]).collect(),
        springs: vec![springs],
        gravity: Some([0.0, 0.0, -9.81]),
        mesh,
        ..Default::default()
    };
    let scene = build_network(spec, Threads::one())?;
    let method = MethodChoice::with_defaults("newmark")?;
    let mut stepper = Stepper::bind(method.scheme(SolverSpec::default()), scene.abilities())?;
    let spec = RunSpec {
        end: 0.5,
        step: Step::Fixed(2e-4),
        frames_every: None,
        keep_going: false,
        explain: Explain::All,
        interrupt: Stop::NEVER,
        method: &method,
    };
    let outcome = run(&scene, &mut stepper, spec, &mut [], &AtomicBool::new(false))?;
    println!("{:?} after {} steps: {:#?}", outcome.status, outcome.steps, outcome.ledger);
    Ok(outcome.ledger)
}

#[allow(dead_code)] // the test calls `swing` itself
fn main() -> Result<(), Box<dyn Error>> {
    swing().map(|_| ())
}
