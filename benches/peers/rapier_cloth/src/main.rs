//! rapier-cloth as one of the programs that `benches/peers/run` compares: XPBD and its implicit solver on a net of
//! springs.
//!
//! ```text
//! rapier_cloth SCENE      one run a line of standard input: METHOD step VALUE FILE
//! ```
//! The crate takes masses from the areas of triangles and rest lengths from their sides, and computes bending at every
//! edge that two of them share, however soft. So triangles here carry the masses and nothing else: each node has one of
//! its own, with two of some helpers that are held, and no two triangles share an edge. The springs are the crate's
//! stitches, which join any two nodes at a rest length of their own.

use rapier_cloth_core::mesh::Stitch;
use rapier_cloth_core::{
    Cloth, ClothContactSettings, ClothError, ClothMaterial, ClothMesh, ImplicitSettings, ShellMaterial, Solver,
    SolverSettings, Vec3,
};
use rustix::time::{ClockId, clock_gettime};
use std::error::Error;
use std::io::{BufRead, Write, stdin, stdout};
use std::str::{FromStr, Lines};

type Any = Box<dyn Error>;

/// As in Cargo.toml.
const VERSION: &str = "rapier-cloth-core 0.3.0";

/// So soft that it does not matter, as compliance [m/N] or, inverted, as modulus [Pa] and thickness [m].
const SOFT: f64 = 1e30;

fn main() -> Result<(), Any> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [file] = &args[..] else { return Err("usage: rapier_cloth SCENE < jobs".into()) };
    let scene = Scene::read(&std::fs::read_to_string(file).map_err(|why| format!("{file}: {why}"))?)?;
    let cloth = scene.cloth()?;
    println!("ready {VERSION}");
    for line in stdin().lock().lines() {
        let answer = run(&scene, &cloth, &line?).unwrap_or_else(|why| format!("refused 0 {why}"));
        println!("{}", answer.replace('\n', " "));
        stdout().flush()?;
    }
    Ok(())
}

struct Scene {
    end: f64,
    every: f64,
    nodes: Vec<[f64; 5]>,   // position, mass, whether it is held
    springs: Vec<[f64; 5]>, // ends, stiffness, rest length, dashpot
    gravity: Vec3,
}

impl Scene {
    fn read(text: &str) -> Result<Scene, Any> {
        let mut scene = Scene { end: 0.0, every: 0.0, nodes: vec![], springs: vec![], gravity: Vec3::ZERO };
        let mut rows = text.lines();
        while let Some(row) = rows.next() {
            match row.split_whitespace().collect::<Vec<_>>()[..] {
                ["time", ..] => [scene.end, scene.every] = numbers(&row[4..])?,
                ["gravity", ..] => scene.gravity = numbers(&row[7..])?.into(),
                ["nodes", n] => scene.nodes = table(&mut rows, n)?,
                ["springs", n] => scene.springs = table(&mut rows, n)?,
                ["membranes", "0"] | [] => {}
                _ => return Err(format!("only springs and their weight are modelled, not '{row}'").into()),
            }
        }
        Ok(scene)
    }

    /// [N/m] The one stiffness of all springs, as all stitches share one.
    fn stiffness(&self) -> Result<f64, Any> {
        let [_, _, k, ..] = *self.springs.first().ok_or("the scene has no springs")?;
        if self.springs.iter().any(|s| s[2] != k || s[4] != 0.0) {
            return Err("only springs of one stiffness without dashpots are modelled".into());
        }
        Ok(k)
    }

    fn cloth(&self) -> Result<Cloth, Any> {
        let (rest, triangles, helpers) = mass_carriers(&self.nodes);
        let mut mesh = ClothMesh::new(rest, triangles)?;
        let springs = self.springs.iter();
        let stitch = |&[a, b, _, rest_length, _]: &[f64; 5]| Stitch { vertices: [a as u32, b as u32], rest_length };
        mesh.add_stitches(springs.map(stitch).collect())?;
        let mut cloth = Cloth::new(
            mesh,
            ClothMaterial {
                surface_density: 1.0,
                stretch_compliance: SOFT,
                stitch_compliance: 1.0 / self.stiffness()?,
                damping: 0.0,
                ..ClothMaterial::default()
            },
        )?;
        let nodes = self.nodes.iter().map(|&[x, y, z, ..]| Vec3::new(x, y, z));
        // Away from the cloth, so that no triangle is flattened.
        let aside = (0..helpers).map(|i| Vec3::new(i as f64, 0.0, 100.0));
        cloth.set_positions(&nodes.chain(aside).collect::<Vec<_>>())?;
        for i in 0..cloth.positions().len() {
            if self.nodes.get(i).is_none_or(|node| node[4] != 0.0) {
                cloth.pin(i as u32, cloth.positions()[i])?;
            }
        }
        Ok(cloth)
    }
}

/// Rest positions and triangles that give every node its mass at a density of 1, and how many helpers come after the
/// nodes. A triangle gives each corner a third of its area.
fn mass_carriers(nodes: &[[f64; 5]]) -> (Vec<Vec3>, Vec<[u32; 3]>, usize) {
    let helpers = (2..).find(|m| m * (m - 1) / 2 >= nodes.len()).unwrap_or(2);
    let pairs = (0..helpers).flat_map(|p| (p + 1..helpers).map(move |q| (p, q)));
    let (mut rest, mut triangles) = (vec![], vec![]);
    for (i, (node, (p, q))) in nodes.iter().zip(pairs).enumerate() {
        rest.push(Vec3::new(p as f64, 6.0 * node[3] / (q - p) as f64, 0.0));
        triangles.push([i, nodes.len() + p, nodes.len() + q].map(|corner| corner as u32));
    }
    rest.extend((0..helpers).map(|i| Vec3::new(i as f64, 0.0, 0.0)));
    (rest, triangles, helpers)
}

fn numbers<const N: usize>(row: &str) -> Result<[f64; N], Any> {
    let read: Result<Vec<f64>, _> = row.split_whitespace().map(f64::from_str).collect();
    let read = read.map_err(|why| format!("'{row}': {why}"))?;
    read.try_into().map_err(|_| format!("'{row}' should have {N} numbers").into())
}

fn table<const N: usize>(rows: &mut Lines, n: &str) -> Result<Vec<[f64; N]>, Any> {
    (0..n.parse::<usize>()?).map(|_| numbers(rows.next().ok_or("the scene ends in a table")?)).collect()
}

/// `xpbd`, with one sweep over the springs a step; `xpbd-N` with N; `backward-euler`, the implicit solver.
fn set_method(cloth: &mut Cloth, method: &str) -> Result<SolverSettings, Any> {
    let settings = SolverSettings { iterations: 1, max_substep: 1.0, ..SolverSettings::default() };
    if method == "xpbd" {
        return Ok(settings);
    }
    if let Some(sweeps) = method.strip_prefix("xpbd-") {
        return Ok(SolverSettings { iterations: sweeps.parse()?, ..settings });
    }
    if method != "backward-euler" {
        return Err("xpbd, xpbd-SWEEPS or backward-euler".into());
    }
    let stitch_stiffness = 1.0 / cloth.material().stitch_compliance;
    let soft = ShellMaterial { youngs_modulus: 1.0 / SOFT, thickness: 1.0 / SOFT, ..ShellMaterial::default() };
    // It demands settings of contact; without contacts of the cloth with itself nothing is searched.
    cloth.set_contact_settings(Some(ClothContactSettings { self_collision: false, ..Default::default() }))?;
    cloth.set_implicit_solver(Some(ImplicitSettings {
        material: ShellMaterial { stitch_stiffness, ..soft },
        velocity_tolerance: 1e-5,
        convergence_window: 1,
        ..ImplicitSettings::default()
    }))?;
    Ok(settings)
}

fn run(scene: &Scene, start: &Cloth, line: &str) -> Result<String, Any> {
    let [method, "step", value, file] = line.split_whitespace().collect::<Vec<_>>()[..] else {
        return Err("a line is METHOD step VALUE FILE".into());
    };
    let ratio = scene.every / value.parse::<f64>()?;
    let each = ratio.round();
    if !ratio.is_finite() || each < 1.0 || (ratio - each).abs() > 1e-6 * ratio {
        return Err("the step does not divide the frames' distance".into());
    }
    let mut cloth = start.clone();
    let settings = set_method(&mut cloth, method)?;
    let mut frames = Vec::new();
    let before = cpu_seconds();
    let outcome = integrate(scene, &mut cloth, &settings, each as usize, &mut frames);
    let seconds = cpu_seconds() - before;
    let bytes: Vec<u8> = frames.iter().flat_map(|x| x.to_le_bytes()).collect();
    std::fs::write(file, bytes).map_err(|why| format!("{file}: {why}"))?;
    Ok(match outcome {
        Ok(steps) if frames.iter().all(|x| x.abs() < 1e4) => format!("done {seconds:e} {steps} steps"),
        Ok(steps) => format!("diverged {seconds:e} {steps} steps"),
        Err(why) => format!("diverged {seconds:e} {why}"),
    })
}

/// Keeps the nodes' positions at every frame; returns the number of steps.
fn integrate(
    scene: &Scene,
    cloth: &mut Cloth,
    settings: &SolverSettings,
    each: usize,
    frames: &mut Vec<f64>,
) -> Result<usize, ClothError> {
    let (mut solver, count) = (Solver::new(), (scene.end / scene.every).round() as usize);
    for _ in 0..count {
        for _ in 0..each {
            solver.step(cloth, scene.every / each as f64, scene.gravity, settings)?;
        }
        frames.extend(cloth.positions().iter().take(scene.nodes.len()).flat_map(|x| x.to_array()));
    }
    Ok(count * each)
}

fn cpu_seconds() -> f64 {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}
