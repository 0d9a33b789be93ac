//! A whole run in one call, for a closure that looks at every state.

use super::{RunSpec, Simulation, SimulationError, build_scene};
use crate::case::spec::Problem;
use crate::drive::Outcome;
use crate::drive::observer::{AcceptedStep, Energies, ObserveError, Observer, Point};
use crate::scene::Scene;
use std::sync::atomic::AtomicBool;

/// One state of a run as a person sees it: nodes in the user's numbering.
#[derive(Clone, Copy, Debug)]
pub struct FollowedState<'a> {
    /// [s] time
    pub t: f64,
    /// [m] positions before any displacement
    pub reference: &'a [[f64; 3]],
    /// [m] positions
    pub positions: &'a [[f64; 3]],
    /// [m/s] velocities
    pub velocities: &'a [[f64; 3]],
    /// energy account
    pub ledger: Energies,
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

/// Runs a case to its end or its failure, without files: `watch` sees the start and every accepted step.
///
/// ```
/// # use canopy_fem_io::{case::Case, simulation::{FollowSpec, follow}};
/// # let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/cases/oscillator.json"));
/// let case = Case::from_file(path, &[])?;
/// let mut highest = 0.0_f64;
/// let outcome = follow(case.problem(), FollowSpec::default(), |seen| highest = highest.max(seen.positions[1][0]))?;
/// assert_eq!((outcome.steps, highest), (2000, 12.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When the scene cannot be built or the scheme not start. A diverged or unsolvable run is an [`Outcome`].
pub fn follow(
    problem: &Problem,
    how: FollowSpec,
    watch: impl FnMut(&FollowedState<'_>),
) -> Result<Outcome, SimulationError> {
    let FollowSpec { threads, keep_going } = how;
    let spec = RunSpec { keep_going, threads, ..problem.run_spec() };
    let mut simulation = Simulation::of_own(build_scene(problem.system.clone(), threads)?.into(), spec)?;
    let scene = simulation.scene();
    let n = scene.reference().len();
    let mut follower = Follower { scene: &*scene, positions: vec![[0.0; 3]; n], velocities: vec![[0.0; 3]; n], watch };
    simulation.run(&mut [&mut follower], &AtomicBool::new(false))
}

struct Follower<'a, W> {
    scene: &'a dyn Scene,
    positions: Vec<[f64; 3]>,
    velocities: Vec<[f64; 3]>,
    watch: W,
}

impl<W: FnMut(&FollowedState<'_>)> Follower<'_, W> {
    fn show(&mut self, at: &Point, ledger: Energies, newton_iterations: u32) -> Result<(), ObserveError> {
        self.scene.trace(at.state.as_ref(), &mut self.positions, &mut self.velocities);
        let Follower { scene, positions, velocities, watch } = self;
        let reference = scene.reference();
        watch(&FollowedState { t: at.state.t, reference, positions, velocities, ledger, newton_iterations });
        Ok(())
    }
}

impl<W: FnMut(&FollowedState<'_>)> Observer for Follower<'_, W> {
    fn started(&mut self, at: &Point, ledger: Energies) -> Result<(), ObserveError> {
        self.show(at, ledger, 0)
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        step.end.map_or(Ok(()), |end| self.show(end, step.ledger, step.newton_iterations))
    }
}
