//! Searches that never ended: an eigenvalue iteration of the linear-algebra library, met while the failure of a run was
//! explained.

use super::program::{program, summary};
use crate::common::Random;
use crate::common::run::{case_of, changed, run};
use canopy_fem::analysis::critical::CostLimits;
use canopy_fem::analysis::spectrum::Spectrum;
use canopy_fem::drive::Status;
use canopy_fem::integrate::registry::{Family, methods};
use canopy_fem::model::stop::Stop;
use canopy_fem::simulation::build_scene;
use serde_json::{Value, json};
use std::sync::atomic::AtomicBool;
use std::sync::mpsc;
use std::time::Duration;

/// What a rope, which takes a hundredth of a second, may take on a busy machine.
const HANG: Duration = Duration::from_secs(60);

/// A hanging rope with axial dashpots: segments, length [m], EA [N], [kg/m], dashpot [N s].
fn rope((segments, length): (u32, f64), rigidity: f64, density: f64, dashpot: f64) -> Value {
    json!({
        "name": "rope",
        "system": {"network": {
            "mesh": {"chain": {"from": [0, 0, 0], "to": [0, 0, -length], "segments": segments}},
            "springs": [{"on": "all", "axial_rigidity": rigidity, "linear_density": density,
                "dashpot": {"axial": {"per_strain": dashpot}}}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
            "gravity": [0, 0, -9.81]
        }},
        "time": {"end": 2.0, "method": "euler-cromer", "step": 0.005672718343493411},
        "output": {"frames": {"every": 2.0}}
    })
}

/// The rope of the fault, step and all.
fn endless() -> Value {
    rope((15, 100.0), 1e6, 3.0, 34641.016151377546)
}

/// The failure is explained, as it is with every step near this one.
#[test]
fn the_failure_of_a_damped_rope_is_explained() {
    let folder = tempfile::tempdir().expect("a folder");
    let ran = program(folder.path(), &endless(), &["solve"]);
    assert_eq!(ran.status, Some(3), "{}", ran.stderr);
    let cause = summary(folder.path(), "rope")["failure"]["cause"].as_str().expect("a cause").to_owned();
    assert!(cause.contains("times the critical step of euler-cromer"), "{cause}");
}

#[test]
fn stability_of_a_damped_rope_is_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let ran = program(folder.path(), &endless(), &["stability", "--methods", "velocity-verlet"]);
    assert_eq!(ran.status, Some(0), "{}", ran.stderr);
    assert!(ran.stdout.contains("velocity-verlet"), "{}", ran.stdout);
}

/// Random damped ropes of 5 to 30 segments, all explicit methods, steps about the limit: every run ends, and what fails
/// says why. 4 of 16655 did not end. `CANOPY_FEM_ROPES` asks for more ropes than a test of every day makes.
#[test]
fn random_damped_ropes_end_with_every_explicit_method() {
    let ropes: u64 = std::env::var("CANOPY_FEM_ROPES").ok().and_then(|count| count.parse().ok()).unwrap_or(12);
    let (mut made, mut failed) = (0, 0);
    for seed in 0..ropes {
        let (send, receive) = mpsc::channel();
        std::thread::spawn(move || send.send(runs_of_a_rope(seed)));
        let [runs, failures] = receive.recv_timeout(HANG).unwrap_or_else(|e| panic!("rope {seed}: {e}"));
        (made, failed) = (made + runs, failed + failures);
    }
    println!("{ropes} ropes, {made} runs, {failed} of them failed and were explained");
    assert!(made >= 9 * ropes && failed > made / 10, "{made} runs, {failed} failed");
}

/// Runs, and how many of them failed.
fn runs_of_a_rope(seed: u64) -> [u64; 2] {
    let mut random = Random(seed.wrapping_mul(0x9E37_79B9) + 1);
    let segments = 5 + (13.0 * (1.0 + random.next())) as u32;
    let length = 10_f64.powf(1.0 + random.next());
    let rigidity = 10_f64.powf(5.0 + 2.0 * random.next());
    let density = 10_f64.powf(random.next());
    let element = length / f64::from(segments);
    // The fastest oscillation's damping ratio: a hundredth to a hundred.
    let zeta = 10_f64.powf(2.0 * random.next());
    let dashpot = zeta * element * (rigidity * density).sqrt();
    let case = case_of(&rope((segments, length), rigidity, density, dashpot), &[]);
    let scene = build_scene(case.problem().system.clone(), 1).expect("a rope");
    let at = scene.initial_state();
    let mut spectrum = Spectrum::of(&*scene, at.as_ref());
    let mut counts = [0, 0];
    for info in methods().iter().filter(|info| info.family == Family::Explicit) {
        let method = canopy_fem::integrate::registry::MethodChoice::with_defaults(info.name).expect("registered");
        let limit = spectrum.critical_step(&method).step;
        let limit = if limit > 0.0 && limit.is_finite() { limit } else { element * (density / rigidity).sqrt() };
        let step = limit * 10_f64.powf(0.2 + 0.4 * random.next());
        let sets = [
            ("time.method", info.name),
            ("time.step", &format!("{step:e}")),
            ("time.end", &format!("{:e}", 60.0 * step)),
        ];
        let outcome = run(&changed(&case, &sets)).outcome;
        counts[0] += 1;
        if outcome.status != Status::Completed {
            let failure = outcome.failure.expect("what fails says so");
            assert!(!failure.cause.is_empty() && !failure.advice.is_empty(), "{}: {failure:?}", info.name);
            counts[1] += 1;
        }
    }
    counts
}

/// A search that is asked to stop before it has begun multiplies with no tangent, and says that it was cut short.
#[test]
fn a_search_that_is_asked_to_stop_finds_nothing() {
    let case = case_of(&endless(), &[]);
    let scene = build_scene(case.problem().system.clone(), 1).expect("a rope");
    let (at, flag) = (scene.initial_state(), AtomicBool::new(true));
    let mut spectrum = Spectrum::with(&*scene, at.as_ref(), CostLimits { stop: Stop::on(&flag), ..CostLimits::FULL });
    assert!(spectrum.stopped() && spectrum.rates().frequency == 0.0);
    let cromer = canopy_fem::integrate::registry::MethodChoice::with_defaults("euler-cromer").expect("registered");
    assert!(spectrum.critical_step(&cromer).step.is_infinite());
    let spectrum = Spectrum::of(&*scene, at.as_ref());
    assert!(!spectrum.stopped() && spectrum.rates().frequency > 0.0);
}
