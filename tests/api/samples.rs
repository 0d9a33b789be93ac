//! What a program keeps of a run: samples at given times, gauges and their peaks.

use canopy_fem::case::Case;
use canopy_fem::drive::Status;
use canopy_fem::output::samples::{SampleArrays, SampleSpec, Samples};
use canopy_fem::simulation::Simulation;
use std::sync::atomic::AtomicBool;

fn case() -> Case {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/cases/oscillator-damped.json");
    let gauges = r#"[{"name": "mass", "on": {"ids": [1]}, "of": "acceleration"}]"#;
    Case::from_file(&path, &[("output.gauges".to_owned(), gauges.to_owned())]).expect("a case")
}

/// A force that is set at the times of the samples acts as in a loop of steps: states, gauges, energies and peaks have
/// the same bits, and no sample shows what is set at its own time.
#[test]
fn a_sampled_run_is_a_loop_of_steps() {
    let case = case();
    let problem = case.problem();
    let times = [0.0, 0.25, 0.5, 0.75];
    let mut sim = Simulation::from_case(problem, 1).expect("it starts");
    sim.measure(&problem.output).expect("gauges");
    let (n, columns) = (sim.node_count(), sim.channels().len());
    let mut x = vec![0.0; 4 * n * 3];
    let (mut gauges, mut energies, mut peaks) = (vec![0.0; 4 * columns], vec![0.0; 4 * 6], vec![0.0; columns]);
    let arrays = SampleArrays {
        positions: &mut x,
        gauges: &mut gauges,
        energies: &mut energies,
        peaks: &mut peaks,
        ..SampleArrays::default()
    };
    let push = |sim: &mut Simulation, number: usize| sim.set_force("push", &vec![[0.5 * number as f64, 0.0, 0.0]; n]);
    let spec = SampleSpec { times: &times, nodes: &[], output: &problem.output, end: sim.end(), ends_run: false };
    let mut samples = Samples::new(&*sim.scene(), spec, arrays).expect("gauges");
    let mut run = Simulation::from_case(problem, 1).expect("it starts");
    let mut act = |sim: &mut Simulation, number: usize| push(sim, number);
    let outcome = run.run_sampled(&mut samples, None, Some(&mut act), &AtomicBool::new(false)).expect("it runs");
    assert_eq!(outcome.t_end, sim.end());
    for (number, &t) in times.iter().enumerate() {
        sim.run_until(t).expect("it goes on");
        assert_eq!(x[number * n * 3..(number + 1) * n * 3], *sim.positions().as_flattened(), "{t}");
        let shown: Vec<f64> = sim.gauges().iter().map(|of| of.value).collect();
        assert_eq!(gauges[number * columns..(number + 1) * columns], shown, "{t}");
        assert_eq!(energies[number * 6], sim.energies().kinetic, "{t}");
        push(&mut sim, number).expect("a force");
    }
    sim.run(&mut [], &AtomicBool::new(false)).expect("it runs");
    assert_eq!(peaks, sim.peaks().iter().map(|peak| peak.value).collect::<Vec<f64>>());
    assert_eq!(run.positions(), sim.positions());
}

/// A time within a step shows the state there: of an oscillator up to the fourth power of the step.
#[test]
fn times_within_steps_are_interpolated() {
    let case = case();
    let problem = case.problem();
    let step = problem.time.step.fixed().expect("fixed steps");
    let time = [100.5 * step];
    let fine = case.with(&[("time.step".to_owned(), (0.5 * step).to_string())]).expect("a case");
    let mut x = vec![0.0; 6];
    let mut sim = Simulation::from_case(problem, 1).expect("it starts");
    let spec = SampleSpec { times: &time, nodes: &[], output: &problem.output, end: sim.end(), ends_run: false };
    let arrays = SampleArrays { positions: &mut x, ..SampleArrays::default() };
    let mut samples = Samples::new(&*sim.scene(), spec, arrays).expect("no gauges");
    sim.run_sampled(&mut samples, None, None, &AtomicBool::new(false)).expect("it runs");
    let mut other = Simulation::from_case(fine.problem(), 1).expect("it starts");
    other.run_until(time[0]).expect("it goes on");
    let (found, wanted) = (x[3], other.positions()[1][0]);
    assert!((found - wanted).abs() < 1e-4 && found != 0.0, "{found} {wanted}");
}

/// A run that ends with its times makes no step after the first that reaches the last of them, and has the states,
/// gauges and peaks of a simulation that stops there, with actions and without. Times that are past need no step.
#[test]
fn a_run_ends_with_the_last_of_its_times() {
    let case = case();
    let problem = case.problem();
    let step = problem.time.step.fixed().expect("fixed steps");
    for (last, steps) in [(100.0, 100), (100.5, 101), (0.0, 0)] {
        let times = [0.0, last * step];
        let times = if last > 0.0 { &times[..] } else { &times[..1] };
        for acts in [false, true] {
            let mut sim = Simulation::from_case(problem, 1).expect("it starts");
            sim.measure(&problem.output).expect("gauges");
            let mut peaks = vec![0.0; sim.channels().len()];
            let arrays = SampleArrays { peaks: &mut peaks, ..SampleArrays::default() };
            let end = sim.end();
            let spec = SampleSpec { times, nodes: &[], output: &problem.output, end, ends_run: true };
            let mut samples = Samples::new(&*sim.scene(), spec, arrays).expect("gauges");
            let mut run = Simulation::from_case(problem, 1).expect("it starts");
            let mut act = |_: &mut Simulation, _: usize| Ok(());
            let act: Option<&mut canopy_fem::simulation::Act<'_>> = if acts { Some(&mut act) } else { None };
            let outcome = run.run_sampled(&mut samples, None, act, &AtomicBool::new(false)).expect("it runs");
            assert_eq!((outcome.steps, outcome.status), (steps, Status::Completed), "{last} {acts}");
            if steps > 0 {
                sim.steps(steps).expect("it goes on");
            }
            assert_eq!(peaks, sim.peaks().iter().map(|peak| peak.value).collect::<Vec<f64>>(), "{last} {acts}");
            assert_eq!(run.positions(), sim.positions());
        }
    }
}
