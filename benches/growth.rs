//! How the cost of a step grows with the number of nodes, from 1,000 up: the sagging annulus of `assets/cases/big`, or
//! a square net of stiff springs that is loaded in its plane and across it.
//!
//! ```text
//! cargo bench -p canopy-fem-benches --bench growth -- --most 100000            # below a minute; a million nodes are the default
//! cargo bench -p canopy-fem-benches --bench growth -- --most 10000 --full 10000   # true Newton too, up to so many nodes (default 10,000)
//! cargo bench -p canopy-fem-benches --bench growth -- --scene square --full 0     # the square net; a minute
//! cargo bench -p canopy-fem-benches --bench growth -- --svg growth.svg            # the curves too
//! ```
//!
//! Processor time of all threads, output and start-up apart. An exponent is that of the power law between a size and
//! the one before it. Explicit steps are as short as the size demands, take two passes over the forces each (the
//! dashpots), and are measured after a warm-up; implicit steps are the first ten of 1 ms, the first factorisation
//! included, the median of as many such runs as fill a second.

mod fixture;

use canopy_fem::case::Case;
use canopy_fem::drive::observer::{AcceptedStep, Energies, ObserveError, Observer, Point};
use canopy_fem::plot::chart::{Axis, Chart, Line, Marker, Stroke};
use canopy_fem::process::cpu_seconds;
use canopy_fem::scene::Scene;
use canopy_fem::simulation::{bind, build_scene};
use fixture::figure::{after, draw, wanted};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

const SIZES: [usize; 4] = [1_000, 10_000, 100_000, 1_000_000];
/// Explicit steps that are not measured.
const WARM_UP: u64 = 5;
/// [s] of explicit steps that are measured, and the least number of them
const MEASURED: (f64, u64) = (1.0, 20);
/// Implicit steps.
const IMPLICIT: u64 = 10;

/// A square net held along its rim. A node's mass falls with their number, while its springs stay as stiff.
const SQUARE: &str = r#"{
    "name": "square-net", "acknowledge": ["areal-density"],
    "system": {"network": {
        "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": 1, "rows": 1}},
        "mass": {"areal_density": 2.0},
        "springs": [{"on": "all", "stiffness": 1e5, "dashpot": {"relative": {"time": 5e-4}}}],
        "supports": [{"on": "outer", "fix": "xyz"}],
        "gravity": [3.0, 2.0, -9.0]
    }},
    "time": {"end": 0.01, "method": "newmark", "step": 1e-3}
}"#;

/// What grows.
#[derive(Clone, Copy)]
enum Growing {
    Annulus,
    Square,
}

impl Growing {
    /// Its case with about so many nodes, and a third of its explicit step [s], which the dashpots set.
    fn case(self, nodes: usize) -> (Case, f64) {
        let count = nodes as f64;
        let made = match self {
            Growing::Annulus => {
                let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/cases/big/annulus-10k.json");
                let size = ("system.network.mesh.annulus.nodes".to_owned(), nodes.to_string());
                (Case::from_file(&path, &[size]), 0.5 / count)
            }
            Growing::Square => {
                let cells = (count.sqrt() - 1.0).round().to_string();
                let sizes =
                    ["columns", "rows"].map(|side| (format!("system.network.mesh.rectangle.{side}"), cells.clone()));
                (Case::from_text(SQUARE.to_owned(), "square-net", PathBuf::new(), &sizes), 3e-3 / count)
            }
        };
        (made.0.unwrap_or_else(|fault| panic!("{fault}")), made.1)
    }
}

/// What the command line asks for.
struct Wishes {
    growing: Growing,
    most: usize,
    full: usize,
}

impl Wishes {
    fn read() -> Self {
        let number = |flag: &str| {
            after(flag)
                .map(|word| word.parse().unwrap_or_else(|_| panic!("{flag} wants a number of nodes, not {word}")))
        };
        let growing = match after("--scene").as_deref() {
            None | Some("annulus") => Growing::Annulus,
            Some("square") => Growing::Square,
            Some(other) => panic!("--scene wants annulus or square, not {other}"),
        };
        Wishes { growing, most: number("--most").unwrap_or(usize::MAX), full: number("--full").unwrap_or(10_000) }
    }
}

/// Reads the processor clock at every step, and stops the run when enough was seen.
struct Pacer<'a> {
    stop: &'a AtomicBool,
    warm_up: u64,
    enough: (f64, u64),
    began: f64,
    steps: u64,
    seconds: f64,
    newton: u64,
}

impl Observer for Pacer<'_> {
    fn started(&mut self, _at: &Point, _ledger: Energies) -> Result<(), ObserveError> {
        self.began = cpu();
        Ok(())
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        let now = cpu();
        if step.step == self.warm_up {
            self.began = now;
        }
        if step.step > self.warm_up {
            (self.steps, self.seconds) = (step.step - self.warm_up, now - self.began);
            self.newton += u64::from(step.newton_iterations);
        }
        if self.steps >= self.enough.1 && self.seconds >= self.enough.0 {
            self.stop.store(true, Ordering::Relaxed);
        }
        Ok(())
    }
}

/// [s] processor time of this process
fn cpu() -> f64 {
    cpu_seconds().expect("a system that tells the processor time")
}

/// [s] a step, with its Newton iterations
#[derive(Clone, Copy)]
struct Cost {
    step: f64,
    newton: f64,
}

fn run(case: &Case, scene: &dyn Scene, sets: &[(&str, String)], warm_up: u64, enough: (f64, u64)) -> Cost {
    let sets: Vec<(String, String)> = sets.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect();
    let mut problem = case.with(&sets).unwrap_or_else(|fault| panic!("{fault}")).into_problem();
    drop(problem.take_system());
    let stop = AtomicBool::new(false);
    let mut pacer = Pacer { stop: &stop, warm_up, enough, began: 0.0, steps: 0, seconds: 0.0, newton: 0 };
    let mut stepper = bind(&problem, scene).expect("the method fits a network");
    let spec = problem.run_spec();
    let outcome = canopy_fem::drive::run(scene, &mut stepper, &spec, &mut [&mut pacer], &stop).expect("enough memory");
    assert!(outcome.failure.is_none(), "{:?}", outcome.failure);
    Cost { step: pacer.seconds / pacer.steps as f64, newton: pacer.newton as f64 / pacer.steps as f64 }
}

/// [s] a pass over the forces, and nothing else
fn force_pass(scene: &dyn Scene) -> f64 {
    let (state, mut forces) = (scene.initial_state(), scene.new_forces());
    (0..WARM_UP).for_each(|_| scene.evaluate(state.as_ref(), &mut forces));
    let (began, mut passes) = (cpu(), 0);
    while passes < MEASURED.1 || cpu() - began < MEASURED.0 {
        // Reading the clock takes as long as a part of a small pass.
        (0..WARM_UP).for_each(|_| scene.evaluate(state.as_ref(), &mut forces));
        passes += WARM_UP;
    }
    (cpu() - began) / passes as f64
}

/// What was measured at one size.
struct Row {
    nodes: usize,
    verlet: Cost,
    /// [s]
    pass: f64,
    auto: Cost,
    full: Option<Cost>,
}

impl Row {
    /// Of the power law by which something has grown since a smaller size.
    fn exponent_from(&self, smaller: &Row, of: &Of) -> Option<f64> {
        Some((of(self)? / of(smaller)?).ln() / (self.nodes as f64 / smaller.nodes as f64).ln())
    }
}

fn measure(nodes: usize, &Wishes { growing, full, .. }: &Wishes) -> Row {
    let (case, short) = growing.case(nodes);
    let scene = build_scene(case.problem().system.clone(), 1).expect("the case is good");
    let scene = &*scene;
    let verlet = [
        ("time.method", "velocity-verlet".to_owned()),
        ("time.step", format!("{short:e}")),
        ("time.end", format!("{:e}", 1e6 * short)),
    ];
    // Ten steps of a small scene are over in a few milliseconds: as many such runs as fill a second, and their median.
    let implicit = |strategy: &str, steps: u64| {
        let sets = [("time.end", format!("{}", 1e-3 * steps as f64)), ("solver.newton.strategy", strategy.to_owned())];
        let (began, mut costs) = (cpu(), Vec::new());
        while costs.is_empty() || cpu() - began < MEASURED.0 {
            costs.push(run(&case, scene, &sets, 0, (0.0, steps)));
        }
        costs.sort_unstable_by(|a, b| f64::total_cmp(&a.step, &b.step));
        costs[costs.len() / 2]
    };
    Row {
        nodes,
        pass: force_pass(scene),
        verlet: run(&case, scene, &verlet, WARM_UP, MEASURED),
        auto: implicit("auto", IMPLICIT),
        // Every step of it factorises several times, so two tell as much as ten.
        full: (nodes <= full).then(|| implicit("full", 2)),
    }
}

/// What is told of a row, if it was measured.
type Of = dyn Fn(&Row) -> Option<f64>;

/// Time a step over the number of nodes.
fn curves(rows: &[Row]) -> Chart {
    let marks = [Marker::Dot, Marker::Square, Marker::Triangle, Marker::Diamond];
    let kinds: [(&str, &Of); 4] = [
        ("newmark, full", &|row| row.full.map(|cost| cost.step)),
        ("newmark, auto", &|row| Some(row.auto.step)),
        ("velocity-verlet", &|row| Some(row.verlet.step)),
        ("a force pass", &|row| Some(row.pass)),
    ];
    let lines = kinds.iter().zip(marks).flat_map(|(&(name, of), marker)| {
        let measured: Vec<&Row> = rows.iter().filter(|row| of(row).is_some()).collect();
        let points: Vec<(f64, f64)> = measured.iter().filter_map(|row| Some((row.nodes as f64, of(row)?))).collect();
        let guide = points.first().zip(points.last()).map(|(&(n, t), &(last, _))| Line {
            points: vec![(n, t), (last, t * last / n)],
            stroke: Stroke::Dashed,
            ..Line::default()
        });
        let exponent = match measured[..] {
            [first, .., last] => last.exponent_from(first, of).map_or_else(String::new, |e| format!(": n^{e:.2}")),
            _ => String::new(),
        };
        [Line { marker, ..Line::new(format!("{name}{exponent}"), points) }].into_iter().chain(guide)
    });
    Chart {
        x: Axis::log("nodes n (dashed: as n)"),
        y: Axis::log("processor time a step [s]"),
        lines: lines.collect(),
        ..Chart::default()
    }
}

fn main() {
    let (wishes, picture) = (Wishes::read(), wanted());
    println!(
        "     nodes   velocity-verlet        a force pass    newmark auto, iterations    newmark full, iterations"
    );
    let mut rows: Vec<Row> = Vec::new();
    for nodes in SIZES.into_iter().filter(|&nodes| nodes <= wishes.most) {
        let row = measure(nodes, &wishes);
        let exponent = |of: &Of| {
            let found = rows.last().and_then(|before| row.exponent_from(before, of));
            found.map_or_else(|| "     ".to_owned(), |e| format!("^{e:<4.2}"))
        };
        let full = row.full.map_or_else(String::new, |c| format!("{:10.2} ms {:5.1}", 1e3 * c.step, c.newton));
        println!(
            "{nodes:>10}  {:10.1} us {}  {:10.1} us {}  {:10.2} ms {} {:5.1}   {full} {}",
            1e6 * row.verlet.step,
            exponent(&|r| Some(r.verlet.step)),
            1e6 * row.pass,
            exponent(&|r| Some(r.pass)),
            1e3 * row.auto.step,
            exponent(&|r| Some(r.auto.step)),
            row.auto.newton,
            exponent(&|r| r.full.map(|c| c.step)),
        );
        rows.push(row);
    }
    if let [first, .., last] = rows.as_slice() {
        let total = |of: &Of| last.exponent_from(first, of).unwrap_or(f64::NAN);
        println!(
            "from the first to the last: velocity-verlet ^{:.3}, newmark auto ^{:.3}",
            total(&|r| Some(r.verlet.step)),
            total(&|r| Some(r.auto.step))
        );
    }
    draw(picture, || curves(&rows));
}
