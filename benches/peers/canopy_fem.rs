//! canopy-fem as one of the programs that `benches/peers/run` compares, and the source of the scene they all share.
//!
//! ```text
//! peer_canopy_fem export CASE [KEY=VALUE ...] > scene.txt      the scene, plainly: see benches/peers/README.md
//! peer_canopy_fem serve CASE [KEY=VALUE ...]                   one run a line of standard input: METHOD step|tol VALUE FILE
//! ```
//! A run is what `canopy-fem tradeoff` times: the driver with its ledger and its watch for divergence, frames kept in
//! memory, no files. FILE then receives the frames' positions as little-endian f64.

use canopy_fem::case::Case;
use canopy_fem::case::schema::Method;
use canopy_fem::case::spec::SystemSpec;
use canopy_fem::drive::Status;
use canopy_fem::force::law::nodal::DeadPressure;
use canopy_fem::force::law::series::LoadFactor;
use canopy_fem::model::spec::{DashpotKind, NetworkSpec, PressureKind, Slack};
use canopy_fem::process::cpu_seconds;
use canopy_fem::solve::newton::Strategy;
use canopy_fem::study::experiment::{Experiment, Start};
use canopy_fem::study::frames::{Frames, Sampler};
use canopy_fem::study::prepared_case::{PreparedCase, choice};
use canopy_fem::study::row::StepSetting;
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write as _;
use std::io::{BufRead, Write as _, stdin, stdout};
use std::path::Path;

type Any = Box<dyn Error>;

fn main() -> Result<(), Any> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [verb, case, overrides @ ..] = &args[..] else {
        return Err("usage: peer_canopy_fem export|serve CASE [KEY=VALUE ...]".into());
    };
    let pairs = overrides.iter().map(|pair| pair.split_once('=').ok_or("an override is KEY=VALUE"));
    let overrides = pairs.map(|pair| pair.map(|(k, v)| (k.to_owned(), v.to_owned()))).collect::<Result<Vec<_>, _>>()?;
    let case = Case::from_file(Path::new(case), &overrides)?;
    match verb.as_str() {
        "export" => {
            let problem = case.problem();
            let SystemSpec::Network(network) = &problem.system else { return Err("the case is no network".into()) };
            let every = problem.output.frames_every.ok_or("the case has no output.frames.every")?;
            print!("{}", scene(network, problem.time.end, every)?);
            Ok(())
        }
        "serve" => serve(&PreparedCase::of(case.problem().clone(), 1)?),
        other => Err(format!("export or serve, not {other}").into()),
    }
}

/// The scene as text that any program reads without a library; refuses what the others are not told of.
fn scene(net: &NetworkSpec, end: f64, every: f64) -> Result<String, Any> {
    let still = net.displacement.is_empty() && net.velocity.is_empty();
    let known = net.forces.is_empty() && net.bending.is_empty() && net.rayleigh.is_none();
    if !(still && known && net.springs.iter().all(|group| group.slack == Slack::None)) {
        return Err(
            "only springs without slack, relative dashpots, membranes, weight, dead pressure and air, from rest".into(),
        );
    }
    let mut text = format!("time {end:?} {every:?}\nnodes {}\n", net.mesh.nodes.len());
    for (([x, y, z], m), fixed) in net.mesh.nodes.iter().zip(&net.mass).zip(&net.fixed) {
        if fixed.iter().any(|f| *f != fixed[0]) {
            return Err("a node is fixed in all directions or in none".into());
        }
        writeln!(text, "{x:?} {y:?} {z:?} {m:?} {}", u8::from(fixed[0]))?;
    }
    let [gx, gy, gz] = net.gravity.unwrap_or_default();
    writeln!(text, "gravity {gx:?} {gy:?} {gz:?}")?;
    springs(net, &mut text)?;
    membranes(net, &mut text)?;
    pressures(net, &mut text)?;
    air(net, &mut text)?;
    Ok(text)
}

fn springs(net: &NetworkSpec, text: &mut String) -> Result<(), Any> {
    writeln!(text, "springs {}", net.springs.iter().map(|group| group.edges.len()).sum::<usize>())?;
    for group in &net.springs {
        let damping = match &group.dashpot {
            Some(dashpot) if dashpot.kind == DashpotKind::Axial => return Err("axial dashpots".into()),
            Some(dashpot) => dashpot.coefficient.clone(),
            None => 0.0.into(),
        };
        let values = group.stiffness.of(group.edges.len()).zip(damping.of(group.edges.len()));
        for ((&e, l), (k, c)) in group.edges.iter().zip(&group.rest_length).zip(values) {
            let [a, b] = net.mesh.edges[e as usize];
            writeln!(text, "{a} {b} {k:?} {l:?} {c:?}")?;
        }
    }
    Ok(())
}

/// Corners, thickness, Young's modulus, Poisson's ratio, and whether it wrinkles; at rest where the nodes are given.
fn membranes(net: &NetworkSpec, text: &mut String) -> Result<(), Any> {
    writeln!(text, "membranes {}", net.membranes.iter().map(|rule| rule.triangles.len()).sum::<usize>())?;
    for rule in &net.membranes {
        let (nu, [one, two]) = (rule.poisson, rule.modulus);
        let shear = one / (2.0 * (1.0 + nu));
        if one != two || (rule.shear - shear).abs() > 1e-12 * shear || rule.damping_time != 0.0 {
            return Err("only isotropic membranes without damping".into());
        }
        for &triangle in &rule.triangles {
            let [a, b, c] = net.mesh.triangles[triangle as usize];
            writeln!(text, "{a} {b} {c} {:?} {one:?} {nu:?} {}", rule.thickness, u8::from(rule.wrinkling))?;
        }
    }
    Ok(())
}

/// Dead pressures as forces on nodes.
fn pressures(net: &NetworkSpec, text: &mut String) -> Result<(), Any> {
    let x: Vec<Vector3<f64>> = net.mesh.nodes.iter().map(|&x| x.into()).collect();
    for load in &net.pressures {
        let (PressureKind::Dead(direction), None) = (load.kind, &load.factor) else {
            return Err("a pressure that follows the cloth or has a table".into());
        };
        let triangles: Vec<_> = load.triangles.iter().map(|&t| net.mesh.triangles[t as usize]).collect();
        let (direction, factor) = (direction.map(Vector3::from), LoadFactor::default());
        let lumped = DeadPressure { triangles: &triangles, pressure: load.pressure, direction, factor }.lump(&x);
        writeln!(text, "forces {}", lumped.nodes.len())?;
        for (node, f) in lumped.nodes.iter().zip(lumped.force.iter()) {
            writeln!(text, "{node} {:?} {:?} {:?}", f.x, f.y, f.z)?;
        }
    }
    Ok(())
}

fn air(net: &NetworkSpec, text: &mut String) -> Result<(), Any> {
    let Some(air) = &net.air else { return Ok(()) };
    let [[wx, wy, wz]] = air.wind.value[..] else { return Err("the wind has a table".into()) };
    writeln!(text, "air {:?} {:?} {wx:?} {wy:?} {wz:?}", air.linear, air.quadratic)?;
    writeln!(text, "triangles {}", net.mesh.triangles.len())?;
    for [a, b, c] in &net.mesh.triangles {
        writeln!(text, "{a} {b} {c}")?;
    }
    Ok(())
}

/// Answers every line with `done|diverged|refused SECONDS NOTE`.
fn serve(prepared: &PreparedCase) -> Result<(), Any> {
    println!("ready canopy-fem {}", env!("CARGO_PKG_VERSION"));
    for line in stdin().lock().lines() {
        let answer = run(prepared, &line?).unwrap_or_else(|why| format!("refused 0 {why}"));
        println!("{}", answer.replace('\n', " "));
        stdout().flush()?;
    }
    Ok(())
}

fn run(prepared: &PreparedCase, line: &str) -> Result<String, Any> {
    let [name, kind, value, file] = line.split_whitespace().collect::<Vec<_>>()[..] else {
        return Err("a line is METHOD step|tol VALUE FILE".into());
    };
    // `newmark` solves as the program decides by itself, `newmark-full` with Newton's own tangent in every iteration.
    let (name, full) = name.strip_suffix("-full").map_or((name, false), |name| (name, true));
    let method = choice(&Method { name: name.to_owned(), parameters: BTreeMap::new() })?;
    let value: f64 = value.parse()?;
    let setting = if kind == "step" { StepSetting::Step(value) } else { StepSetting::Tolerance(value) };
    let mut experiment = Experiment { single_steps: 0, ..prepared.experiment(&method, setting.step()) };
    if full {
        experiment.solver.newton.strategy = Strategy::Full;
    }
    let mut sampler = Sampler::keeping(&*prepared.scene, prepared.every);
    let before = cpu_seconds().ok_or("this system does not tell processor time")?;
    let outcome = experiment.run(Start::Initial, Some(&mut sampler), &mut |_, _| false)?;
    let seconds = cpu_seconds().ok_or("this system does not tell processor time")? - before;
    keep(&sampler.into_frames(), Path::new(file))?;
    let done = if outcome.status == Status::Completed { "done" } else { "diverged" };
    let counters = outcome.counters;
    let (forces, factors) = (counters.force_evaluations, counters.factorizations);
    Ok(format!("{done} {seconds:e} {} steps, {forces} force passes, {factors} factorisations", outcome.steps))
}

fn keep(frames: &Frames, file: &Path) -> Result<(), Any> {
    let bytes: Vec<u8> = frames.positions.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    Ok(std::fs::write(file, bytes)?)
}
