//! A case made ready to run: the scene and the method bound to each other; and [`follow`], a whole run in one call.

use crate::case::spec::{Problem, SystemSpec};
use crate::drive::observer::{AcceptedStep, LedgerRow, ObserveError, Observer, Point};
use crate::drive::{Outcome, RunError};
use crate::force::schedule::threads::Threads;
use crate::integrate::stepper::{NeedsNetwork, Stepper};
use crate::scene::{BuildError, Pendulum, Scene, build_network};
use std::sync::atomic::AtomicBool;

/// Why a good case cannot be made ready.
#[derive(Debug, thiserror::Error)]
pub enum SetupError {
    /// The specification contradicts itself.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The method does not fit the scene.
    #[error("{method}: {source}")]
    Method {
        /// the method's name
        method: &'static str,
        /// why
        source: NeedsNetwork,
    },
    /// The operating system gave no threads.
    #[error("threads cannot be started: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

/// Builds the scene of a case for `threads` threads, the calling one among them ([`Threads::with_caller`]).
///
/// # Errors
/// A specification that contradicts itself, or no threads.
pub fn build_scene(system: SystemSpec, threads: usize) -> Result<Box<dyn Scene>, SetupError> {
    Ok(match system {
        SystemSpec::Network(spec) => Box::new(build_network(*spec, Threads::with_caller(threads)?)?),
        SystemSpec::Pendulum(spec) => Box::new(Pendulum::new(spec)),
    })
}

/// Binds the method of a case to its scene.
///
/// # Errors
/// When the method needs a network and the scene is none.
pub fn bind<'a>(problem: &Problem, scene: &'a dyn Scene) -> Result<Stepper<'a>, SetupError> {
    let method = &problem.method;
    Stepper::bind(method.scheme(problem.solver), scene.abilities())
        .map_err(|source| SetupError::Method { method: method.info.name, source })
}

/// One state of a run as a person sees it: nodes in the user's numbering.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// [s] time
    pub t: f64,
    /// [m] positions before any displacement
    pub reference: &'a [[f64; 3]],
    /// [m] positions
    pub positions: &'a [[f64; 3]],
    /// [m/s] velocities
    pub velocities: &'a [[f64; 3]],
    /// energy account
    pub ledger: LedgerRow,
    /// Newton iterations of the step that led here
    pub newton_iterations: u32,
}

/// How [`follow`] runs a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FollowSpec {
    /// threads for the force passes of scenes above 2,000 nodes, at least 1; results do not depend on it
    pub threads: usize,
    /// go on past a blow-up until a value stops being finite
    pub keep_going: bool,
}

impl Default for FollowSpec {
    fn default() -> Self {
        FollowSpec { threads: 1, keep_going: false }
    }
}

/// Why a case could not be followed.
#[derive(Debug, thiserror::Error)]
pub enum FollowError {
    /// It cannot be made ready.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// It cannot start.
    #[error(transparent)]
    Run(#[from] RunError),
}

/// Runs a case to its end or its failure, without files: `watch` sees the start and every accepted step.
///
/// ```
/// # use canopy_fem::{case::Case, simulation::{FollowSpec, follow}};
/// # let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/cases/oscillator.json"));
/// let case = Case::from_file(path, &[])?;
/// let mut highest = 0.0_f64;
/// let outcome = follow(case.problem(), FollowSpec::default(), |seen| highest = highest.max(seen.positions[1][0]))?;
/// assert_eq!((outcome.steps, highest), (2000, 12.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When the scene cannot be built or the scheme not start. A diverged or unsolvable run is an [`Outcome`].
pub fn follow(problem: &Problem, how: FollowSpec, watch: impl FnMut(&Seen<'_>)) -> Result<Outcome, FollowError> {
    let scene = build_scene(problem.system.clone(), how.threads)?;
    let mut stepper = bind(problem, &*scene)?;
    let spec = problem.run_spec(how.keep_going);
    let n = scene.reference().len();
    let mut follower = Follower { scene: &*scene, positions: vec![[0.0; 3]; n], velocities: vec![[0.0; 3]; n], watch };
    Ok(crate::drive::run(&*scene, &mut stepper, spec, &mut [&mut follower], &AtomicBool::new(false))?)
}

struct Follower<'a, W> {
    scene: &'a dyn Scene,
    positions: Vec<[f64; 3]>,
    velocities: Vec<[f64; 3]>,
    watch: W,
}

impl<W: FnMut(&Seen<'_>)> Follower<'_, W> {
    fn show(&mut self, at: &Point, ledger: LedgerRow, newton_iterations: u32) -> Result<(), ObserveError> {
        self.scene.trace(at.state.as_ref(), &mut self.positions, &mut self.velocities);
        let Follower { scene, positions, velocities, watch } = self;
        let reference = scene.reference();
        watch(&Seen { t: at.state.t, reference, positions, velocities, ledger, newton_iterations });
        Ok(())
    }
}

impl<W: FnMut(&Seen<'_>)> Observer for Follower<'_, W> {
    fn started(&mut self, at: &Point, ledger: LedgerRow) -> Result<(), ObserveError> {
        self.show(at, ledger, 0)
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        step.end.map_or(Ok(()), |end| self.show(end, step.ledger, step.newton_iterations))
    }
}
