//! One variant of the case, ready for any number of runs: the scene is built once and shared by all of them.

use super::costs;
use super::error::StudyError;
use super::experiment::Experiment;
use super::row::StepSetting;
use crate::case::fingerprint::{Fingerprint, FingerprintError};
use crate::case::schema::Method;
use crate::case::spec::{Problem, SystemSpec};
use crate::drive::Explain;
use crate::drive::clock::{Step, Tolerance};
use crate::integrate::registry::{Family, MethodChoice};
use crate::scene::Scene;
use crate::simulation::build_scene;

/// Frames a study compares if the case does not say how often it wants them.
const FRAMES: f64 = 50.0;
/// [byte] Most memory that the frames of a reference may take; above it fewer are compared.
const MOST_BYTES: f64 = 2.5e8;

/// A variant of the case with its scene built.
pub struct PreparedCase {
    /// what moves
    pub scene: Box<dyn Scene>,
    /// the case without its system
    pub problem: Problem,
    /// what the case is
    pub fingerprint: Fingerprint,
    /// [s] interval of the frames that are compared
    pub every: f64,
}

/// What a study is a study of: the case, and its end, beyond which its runs cannot be taken.
///
/// # Errors
/// A case that cannot be summed up.
pub fn fingerprint_of(problem: &Problem) -> Result<Fingerprint, FingerprintError> {
    let mut fingerprint = Fingerprint::of(problem)?;
    fingerprint.note_end(problem.time.end);
    Ok(fingerprint)
}

impl PreparedCase {
    /// Builds the scene of a problem for `threads` threads.
    ///
    /// # Errors
    /// A scene that cannot be built, or a case that cannot be summed up.
    pub fn of(mut problem: Problem, threads: usize) -> Result<Self, StudyError> {
        let fingerprint = fingerprint_of(&problem)?;
        let system: SystemSpec = problem.take_system();
        let scene = build_scene(system, threads)?;
        let every = interval(&problem, &*scene);
        Ok(PreparedCase { scene, problem, fingerprint, every })
    }

    /// [s] What a step of a method costs: [`nominal_step`].
    pub fn nominal_step(&self, method: &MethodChoice) -> f64 {
        nominal_step(&*self.scene, method)
    }

    /// [s] End of the runs.
    pub fn end(&self) -> f64 {
        self.problem.time.end
    }

    /// A run to the end that explains failures; its frames are those that are compared.
    pub fn experiment<'a>(&'a self, method: &'a MethodChoice, step: Step) -> Experiment<'a> {
        let run = Experiment::new(&*self.scene, method, self.problem.solver, step, self.end());
        Experiment { frames_every: Some(self.every), explain: Explain::Failures, ..run }
    }
}

/// [s] Interval of the frames that are compared: the case's, but few enough to be held in memory.
pub fn interval(problem: &Problem, scene: &dyn Scene) -> f64 {
    let end = problem.time.end;
    let asked = problem.output.frames_every.unwrap_or(end / FRAMES).min(end);
    let bytes = 24.0 * scene.reference().len() as f64 * (end / asked);
    asked * (bytes / MOST_BYTES).ceil().max(1.0)
}

/// [s] What a step of a method costs, to an order of magnitude, from counts alone: what is decided by it is the same on
/// every machine.
pub fn nominal_step(scene: &dyn Scene, method: &MethodChoice) -> f64 {
    let passes = f64::from(method.info.evaluations[usize::from(scene.velocity_dependent())].max(1));
    let solving = if method.info.family == Family::Implicit { costs::IMPLICIT_DOF * scene.n_dof() as f64 } else { 0.0 };
    solving + passes * (elements(scene) + costs::PASS)
}

/// [s] What the elements of a force pass cost, with a little for the pass, from counts alone as [`nominal_step`].
pub fn nominal_pass(scene: &dyn Scene) -> f64 {
    costs::SMALL_PASS + elements(scene)
}

/// [s] The elements of a force pass.
fn elements(scene: &dyn Scene) -> f64 {
    let [springs, triangles, nodes] =
        [scene.edges().len(), scene.triangles().len(), scene.reference().len()].map(|n| n as f64);
    costs::SPRING * springs + costs::TRIANGLE * triangles + costs::NODE * nodes
}

impl StepSetting {
    /// For the driver.
    pub fn step(self) -> Step {
        match self {
            StepSetting::Step(h) => Step::Fixed(h),
            StepSetting::Tolerance(relative) => Step::Adaptive(Tolerance { relative, absolute: relative / 100.0 }),
        }
    }
}

/// The tolerance of a reference. Its absolute part is so small a share of the scene's size that it is small against the
/// motion too, which is often a small part of that size.
pub(super) fn reference_tolerance(scene: &dyn Scene, relative: f64) -> Tolerance {
    let size = scene.size();
    Tolerance { relative, absolute: 1e-3 * relative * if size > 0.0 { size } else { 1.0 } }
}

/// A method as a case writes it, looked up.
///
/// # Errors
/// An unknown name or a parameter out of range.
pub fn choice(method: &Method) -> Result<MethodChoice, StudyError> {
    Ok(MethodChoice::new(&method.name, &method.parameters)?)
}
