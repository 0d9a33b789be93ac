//! Cases run through the library the way the program runs them, with what passes by kept.

use canopy_fem::case::Case;
use canopy_fem::case::spec::SystemSpec;
use canopy_fem::drive::Outcome;
use canopy_fem::drive::observer::{AcceptedStep, ObserveError, Observer, Point};
use canopy_fem::model::forces::Role;
use canopy_fem::model::observables::MembranePicture;
use canopy_fem::model::spec::NetworkSpec;
use canopy_fem::model::state::State;
use canopy_fem::model::stop::Stop;
use canopy_fem::scene::Scene;
use canopy_fem::simulation::{self, FollowSpec, FollowedState, bind, build_scene};
use canopy_fem::statics::{self, StaticSpec};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// The specification of the network of a case.
pub fn network(case: &Case) -> NetworkSpec {
    match &case.problem().system {
        SystemSpec::Network(spec) => (**spec).clone(),
        SystemSpec::Pendulum(_) => panic!("a network"),
    }
}

/// A case from memory; `sets` are what `--set` would replace.
pub fn case_of(json: &serde_json::Value, sets: &[(&str, &str)]) -> Case {
    Case::from_text(json.to_string(), "test.json", PathBuf::new(), &owned(sets)).unwrap_or_else(|e| panic!("{e}"))
}

/// A case of `assets/cases` by its stem.
pub fn asset(stem: &str, sets: &[(&str, &str)]) -> Case {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/cases").join(format!("{stem}.json"));
    Case::from_file(&path, &owned(sets)).unwrap_or_else(|e| panic!("{e}"))
}

/// The same case with other values; its mesh is not made again.
pub fn changed(case: &Case, sets: &[(&str, &str)]) -> Case {
    case.with(&owned(sets)).unwrap_or_else(|e| panic!("{e}"))
}

fn owned(sets: &[(&str, &str)]) -> Vec<(String, String)> {
    sets.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect()
}

/// Runs a case to its end or its failure.
pub fn run(case: &Case) -> Run {
    run_with(case, 1)
}

/// The same on several threads.
pub fn run_with(case: &Case, threads: usize) -> Run {
    let mut problem = case.problem().clone();
    let scene = build_scene(problem.take_system(), threads).expect("the case is good");
    let mut stepper = bind(&problem, &*scene).expect("the method fits the scene");
    let spec = problem.run_spec();
    let mut last = Last::default();
    let stop = AtomicBool::new(false);
    let outcome = canopy_fem::drive::run(&*scene, &mut stepper, &spec, &mut [&mut last], &stop).expect("it starts");
    let reference = scene.reference();
    let (mut positions, mut velocities) = (vec![[0.0; 3]; reference.len()], vec![[0.0; 3]; reference.len()]);
    scene.trace(last.state.as_ref(), &mut positions, &mut velocities);
    let reference = reference.to_vec();
    Run { outcome, state: last.state, reference, positions, velocities, most_iterations: last.most_iterations }
}

/// Runs a case and shows its start and every accepted step to `watch`.
pub fn follow(case: &Case, watch: impl FnMut(&FollowedState<'_>)) -> Outcome {
    simulation::follow(case.problem(), FollowSpec::default(), watch).expect("it starts")
}

/// The same past a divergence: what a method does there can be known, too.
pub fn follow_on(case: &Case, watch: impl FnMut(&FollowedState<'_>)) -> Outcome {
    simulation::follow(case.problem(), FollowSpec { keep_going: true, ..FollowSpec::default() }, watch)
        .expect("it starts")
}

/// What a run left.
pub struct Run {
    pub outcome: Outcome,
    /// last good state, in the scene's own numbering
    pub state: State,
    /// positions before any displacement, in the user's numbering
    pub reference: Vec<[f64; 3]>,
    /// last good positions, in the user's numbering
    pub positions: Vec<[f64; 3]>,
    /// last good velocities, in the user's numbering
    pub velocities: Vec<[f64; 3]>,
    /// most Newton iterations of any step
    pub most_iterations: u32,
}

impl Run {
    /// Whether every number of the last state is finite.
    pub fn is_finite(&self) -> bool {
        self.positions.iter().chain(&self.velocities).flatten().all(|v| v.is_finite())
    }
}

#[derive(Default)]
struct Last {
    state: State,
    most_iterations: u32,
}

impl Observer for Last {
    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        self.most_iterations = self.most_iterations.max(step.newton_iterations);
        Ok(())
    }

    fn finished(&mut self, last: &Point) -> Result<(), ObserveError> {
        self.state = last.state.clone();
        Ok(())
    }
}

/// [-] Root mean square distance of the ends of two runs over that of the motion.
pub fn apart(a: &Run, b: &Run) -> f64 {
    let sum = |from: &Run, to: &[[f64; 3]]| -> f64 {
        from.positions.iter().zip(to).flat_map(|(a, b)| (0..3).map(move |c| (a[c] - b[c]).powi(2))).sum()
    };
    (sum(a, &b.positions) / sum(a, &a.reference)).sqrt()
}

/// The static equilibrium of a case that has one, from its start.
pub fn at_rest(case: &Case) -> Rest {
    let mut problem = case.problem().clone();
    let scene = build_scene(problem.take_system(), 1).expect("the case is good");
    let spec = StaticSpec {
        at: 0.0,
        relative: problem.solver.newton.relative,
        max_iterations: 3000,
        load_steps: 1,
        linear: problem.solver.linear,
    };
    let found = statics::find(&*scene, spec, Stop::NEVER);
    assert!(found.failure.is_none(), "{}: {:?}", problem.name, found.failure);
    Rest::of(scene, found.point)
}

/// A case as it is at its start.
pub fn as_given(case: &Case) -> Rest {
    let scene = build_scene(case.problem().clone().take_system(), 1).expect("the case is good");
    let mut point = Point { state: scene.initial_state(), forces: scene.new_forces() };
    scene.evaluate(point.state.as_ref(), &mut point.forces);
    Rest::of(scene, point)
}

/// A state with its forces, in the user's numbering.
pub struct Rest {
    pub positions: Vec<[f64; 3]>,
    /// [N] sums of forces on free nodes
    pub forces: Vec<[f64; 3]>,
    /// [N] of what is held
    pub reactions: Vec<[f64; 3]>,
    /// of every triangle
    pub membranes: Vec<MembranePicture>,
    /// [J]
    pub elastic: f64,
}

impl Rest {
    fn of(scene: Box<dyn Scene>, point: Point) -> Self {
        let nodes = scene.reference().len();
        let at = point.state.as_ref();
        let [mut positions, mut velocities] = [(); 2].map(|()| vec![[0.0; 3]; nodes]);
        let [mut forces, mut reactions] = [(); 2].map(|()| vec![[0.0; 3]; nodes]);
        let mut membranes = vec![MembranePicture::default(); scene.triangles().len()];
        scene.trace(at, &mut positions, &mut velocities);
        scene.node_forces(at, &point.forces, &mut forces);
        scene.node_reactions(&point.forces, &mut reactions);
        scene.triangle_membranes(at, &mut membranes);
        let elastic = scene.terms().iter().zip(&point.forces.tallies);
        let elastic = elastic.filter(|(term, _)| term.role == Role::Elastic).map(|(_, tally)| tally.energy).sum();
        Rest { positions, forces, reactions, membranes, elastic }
    }
}
