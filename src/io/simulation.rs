//! A simulation that a program drives: [`Simulation`] owns its scene, its scheme and its state.
//!
//! A scene comes from a case file ([`Simulation::from_case`]) or from code ([`NetworkBuilder`]); [`RunSpec`] says
//! by which method and in which steps it moves. Every slice of nodes has shape `[n_nodes][3]`, in the numbering of the
//! mesh; units are SI.
//!
//! ```
//! use canopy_fem_io::simulation::{NetworkBuilder, RunSpec, Simulation, SpringLaw};
//!
//! // A mass of 2 kg on a spring of 8 N/m, pulled 0.5 m: x = 1 + 0.5 cos(2 t).
//! let network = NetworkBuilder::new(vec![[0.0; 3], [1.5, 0.0, 0.0]])
//!     .springs(&[[0, 1]], SpringLaw { stiffness: 8.0, rest_length: Some(1.0), ..SpringLaw::default() })
//!     .masses(vec![2.0; 2])
//!     .hold(|node, _| node == 0);
//! let mut sim = Simulation::new(network.build()?, RunSpec::fixed("rk4", 1e-3, 10.0)?)?;
//! sim.run_until(1.0)?;
//! assert!((sim.positions()[1][0] - (1.0 + 0.5 * 2.0_f64.cos())).abs() < 1e-9);
//! assert!(sim.energies().numerical.abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What a program can do
//! | to | call |
//! |---|---|
//! | make a scene in code | [`NetworkBuilder`], [`Simulation::new`] |
//! | take scene, method and step of a case file | [`Simulation::from_case`], or [`follow`] to run it to its end |
//! | write the files of `canopy-fem solve` | [`record`] |
//! | the same in memory | [`record_in_memory`] |
//! | find an equilibrium, as `canopy-fem static` | [`record_static`], [`crate::statics`] |
//! | only its scene, another method | [`build_scene`], [`Problem::run_spec`], [`Simulation::from_scene`] |
//! | make several runs of one scene, also at the same time | [`Simulation::from_scene`] for each |
//! | choose method, steps, threads | [`RunSpec::fixed`], [`RunSpec::adaptive`], [`RunSpec::of`] |
//! | make steps | [`Simulation::step`], [`Simulation::steps`], [`Simulation::run_until`] |
//! | stop on the way | [`Simulation::run_until_or`] |
//! | give up on a step | [`Simulation::stop_on`] |
//! | give the size of a step | [`Simulation::attempt_with_step`] |
//! | look at a step first | [`Simulation::attempt`]; [`Simulation::accept`] or [`Simulation::drop_attempt`] |
//! | read nodes | [`Simulation::positions`], [`Simulation::velocities`], [`Simulation::reactions`] |
//! | read springs and energies | [`Simulation::tensions`], [`Simulation::energies`] |
//! | read derivatives of the state by numbers of the case | [`Simulation::follow_derivatives`] |
//! | read accelerations, gauges and their peaks | [`Simulation::accelerations`], [`Simulation::measure`] |
//! | keep a run at given times | [`crate::output::samples`], [`Simulation::run_sampled`] |
//! | read what it cost | [`Simulation::counters`] |
//! | set positions and velocities | [`Simulation::set_state`] |
//! | set the wind | [`Simulation::set_wind`] |
//! | scale gravity, pressures, forces | [`Simulation::set_load_factor`], [`Simulation::load_factors`] |
//! | reef lines or let them out | [`Simulation::set_rest_scale`]: `examples/reefing.rs` |
//! | push nodes | [`Simulation::set_force`], [`Simulation::remove_force`] |
//! | add a force of its own | [`NodalForce`], [`Simulation::set_force_law`]: `examples/own_force.rs` |
//! | check its derivatives | [`derivative_error`] |
//! | add a law of bars | [`BarLaw`], [`Simulation::with_bars`]: `examples/own_bar_law.rs` |
//! | add a scheme | [`crate::integrate`], [`RunSpec::of`]: `examples/own_scheme.rs` |
//! | watch every step | [`Observer`], [`Simulation::run_until_with`]: `examples/own_observer.rs` |
//! | save and restore | [`Simulation::snapshot`], [`Simulation::restore`] |
//!
//! What is set acts from the present state on, until it is set again. The forces jump there, and the accelerations that
//! schemes and adaptive steps carry jump with them, so a force may be set before every step without a loss of
//! dissipation or order. A value that is set to what it is costs nothing. Where a change gives or takes energy at once,
//! as other rest lengths do, the account has it as external work, so `numerical` remains what the scheme itself makes.
//! By `numerical` a run is judged: the other energies add up by its definition, and with smaller steps h it falls as h
//! to the order of the method.

mod attempt;
mod builder;
mod derivative;
mod derivatives;
mod doubts;
mod equilibrium;
mod error;
mod follow;
mod idle_loads;
mod observe;
mod record;
mod sampled;
mod saved;
mod state;

pub use crate::drive::RunSpec;
pub use crate::force::law::bar_law::{BarForce, BarLaw, Bars};
pub use crate::scene::{ForceDerivative, Load, NodalForce};
pub use builder::{NetworkBuilder, SpringLaw};
pub use derivative::{DerivativeError, derivative_error};
pub use derivatives::{StateDerivative, event_without_derivative};
pub use doubts::{check_solver, doubts_at_end, doubts_at_start};
pub use equilibrium::{
    RecordedStatic, StaticSettings, record_static, record_static_watched, static_spec, warnings_at_rest,
};
pub use error::{RecordError, SetupError, SimulationError};
pub use follow::{FollowSpec, FollowedState, follow};
pub use idle_loads::idle_loads;
pub use observe::GaugeValue;
pub use record::{
    EarlierResults, MemorySettings, RecordSettings, RecordWatch, Recorded, StartLimits, record, record_in_memory,
    record_watched,
};
pub use sampled::Act;
pub use state::NodeMotion;

use crate::case::spec::{Problem, SystemSpec};
use crate::drive::observer::{AcceptedStep, Energies, ObserveError, Observer, UpcomingStep, Wants};
use crate::drive::{Changed, Outcome, Run, RunError, RunState, Snapshot, StepEnd};
use crate::force::schedule::threads::Threads;
use crate::integrate::StepReport;
use crate::integrate::registry::MethodChoice;
use crate::integrate::stepper::{Scheme, Stepper};
use crate::interrupt;
use crate::model::spec::NetworkSpec;
use crate::model::stop::Stop;
use crate::output::live::LiveGauges;
use crate::scene::{Pendulum, Scene, build_network, build_network_with};
use crate::sensitivity::TangentRun;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, OnceLock};

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
    bind_scheme(problem.method.scheme(problem.solver), &problem.method, scene)
}

/// A new scheme bound to a scene.
fn bind_spec<'a>(spec: &RunSpec, scene: &'a dyn Scene) -> Result<Stepper<'a>, SetupError> {
    bind_scheme(spec.scheme(), &spec.method, scene)
}

fn bind_scheme<'a>(scheme: Scheme, method: &MethodChoice, scene: &'a dyn Scene) -> Result<Stepper<'a>, SetupError> {
    let method = method.info.name;
    Stepper::bind(scheme, scene.interfaces()).map_err(|source| SetupError::Method { method, source })
}

/// A step that was made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepInfo {
    /// accepted steps so far
    pub step: u64,
    /// [s] time at its end
    pub time: f64,
    /// energy account at its end
    pub energies: Energies,
}

/// A step that was attempted and waits.
enum Pending {
    /// of a fixed size, in the second point of the run
    Fixed(StepReport),
    /// of adaptive size, accepted already: where it began
    Adaptive(Box<Snapshot>),
}

/// A scene in motion. It borrows nothing and may move between threads (`Send`).
///
/// A step that diverges or cannot be solved is refused: the state stays that before it, and the error says why. The
/// energy account, the watch for divergence and adaptive steps work as in `canopy-fem solve`.
pub struct Simulation {
    scene: Arc<dyn Scene>,
    /// away only while a step is made
    scheme: Option<Scheme>,
    spec: RunSpec,
    state: RunState,
    pending: Option<Pending>,
    /// [m/s] wind that was set
    wind: Option<[f64; 3]>,
    /// [-] factors of rest lengths that were set, `[n_edges]`; empty if none was
    rest_scales: Vec<f64>,
    /// the edges that have a spring, once they were asked for
    spring_edges: OnceLock<Vec<u32>>,
    /// what was changed since the last step
    changed: Changed,
    /// whether it goes on from a snapshot
    resumed: bool,
    /// when it is set, no failure is looked into
    stop: Option<Arc<AtomicBool>>,
    /// away only while steps are made
    gauges: Option<LiveGauges>,
    /// derivatives that go along; away only while steps are made
    tangent: Option<TangentRun>,
}

impl Simulation {
    /// A network, ready at t = 0.
    ///
    /// # Errors
    /// A specification that contradicts itself, settings out of range, or a method that cannot start.
    pub fn new(network: NetworkSpec, spec: RunSpec) -> Result<Self, SimulationError> {
        Self::with_bars(network, &[], spec)
    }

    /// A network with bars of the program's own laws ([`BarLaw`]).
    ///
    /// # Errors
    /// As [`Simulation::new`], and bars of nodes that do not exist or of rest lengths that are not finite.
    pub fn with_bars(network: NetworkSpec, bars: &[Bars], spec: RunSpec) -> Result<Self, SimulationError> {
        let threads = Threads::new(spec.threads).map_err(SetupError::from)?;
        let scene = build_network_with(network, bars, threads).map_err(SetupError::from)?;
        Self::of_own(Arc::new(scene), spec)
    }

    /// A case, ready at t = 0, on `threads` threads; results do not depend on their number.
    ///
    /// ```
    /// # use canopy_fem_io::{case::Case, simulation::Simulation};
    /// # let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/cases/oscillator.json"));
    /// let case = Case::from_file(path, &[])?;
    /// let mut sim = Simulation::from_case(case.problem(), 1)?;
    /// sim.steps(100)?;
    /// assert_eq!(sim.step_count(), 100);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn from_case(problem: &Problem, threads: usize) -> Result<Self, SimulationError> {
        let spec = RunSpec { threads, ..problem.run_spec() };
        match &problem.system {
            SystemSpec::Network(network) => Self::new((**network).clone(), spec),
            SystemSpec::Pendulum(pendulum) => Self::of_own(Arc::new(Pendulum::new(*pendulum)), spec),
        }
    }

    /// A scene, ready at t = 0. The simulation works on a copy that shares what does not change
    /// ([`Scene::for_run`]), so that any number of simulations may begin from one scene, also on other threads.
    /// Observers that ask a scene about its states need that of [`Simulation::scene`].
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn from_scene(scene: &dyn Scene, spec: RunSpec) -> Result<Self, SimulationError> {
        Self::of_own(scene.for_run().into(), spec)
    }

    /// The same with a scene that no other run has, without a copy.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn of_own(scene: Arc<dyn Scene>, spec: RunSpec) -> Result<Self, SimulationError> {
        let mut stepper = bind_spec(&spec, &*scene)?;
        let state = RunState::start(&*scene, &mut stepper, &spec, scene.initial_state())?;
        let scheme = stepper.unbind();
        Ok(Self::at(scene, spec, scheme, state))
    }

    /// A scene where a snapshot was taken of a run with the same scene and settings: every further step has the bits of
    /// a run that was never stopped.
    ///
    /// # Errors
    /// As [`Simulation::new`], and when the snapshot does not fit.
    pub fn resume(scene: &dyn Scene, spec: RunSpec, snapshot: Snapshot) -> Result<Self, SimulationError> {
        Self::resume_own(scene.for_run().into(), spec, snapshot)
    }

    /// A scene that no other run has.
    fn resume_own(scene: Arc<dyn Scene>, spec: RunSpec, snapshot: Snapshot) -> Result<Self, SimulationError> {
        let mut stepper = bind_spec(&spec, &*scene)?;
        let state = RunState::restore(&*scene, &mut stepper, &spec, snapshot)?;
        let scheme = stepper.unbind();
        Ok(Simulation { resumed: true, ..Self::at(scene, spec, scheme, state) })
    }

    fn at(scene: Arc<dyn Scene>, spec: RunSpec, scheme: Scheme, state: RunState) -> Self {
        Simulation {
            scene,
            scheme: Some(scheme),
            spec,
            state,
            pending: None,
            wind: None,
            rest_scales: Vec::new(),
            spring_edges: OnceLock::new(),
            changed: Changed::Nothing,
            resumed: false,
            stop: None,
            gauges: None,
            tangent: None,
        }
    }

    /// Makes one step: of the fixed size, or of the size that the tolerance allows. An adaptive step whose error was
    /// found from two halves counts as two.
    ///
    /// # Errors
    /// [`SimulationError::Failed`] with the state unchanged, or [`SimulationError::Ended`].
    pub fn step(&mut self) -> Result<StepInfo, SimulationError> {
        self.steps(1)
    }

    /// Makes `n` steps.
    ///
    /// # Errors
    /// As [`Simulation::step`]; the steps before a failed one are made.
    pub fn steps(&mut self, n: u64) -> Result<StepInfo, SimulationError> {
        let last = self.state.steps.saturating_add(n);
        self.go(StopAt { step: last, t: f64::INFINITY }, &mut [], &mut || false)
    }

    /// Makes steps up to the first that ends at time `t` [s] or later, up to rounding of the time; none where that is
    /// now or past.
    ///
    /// # Errors
    /// As [`Simulation::steps`]; also when `t` is not finite. Where `t` is beyond the end of the run, all its steps
    /// are made and [`SimulationError::Ended`] is returned.
    pub fn run_until(&mut self, t: f64) -> Result<StepInfo, SimulationError> {
        self.run_until_with(t, &mut [])
    }

    /// The same with observers, which see every step.
    ///
    /// # Errors
    /// As [`Simulation::run_until`], and when an observer cannot write.
    pub fn run_until_with(&mut self, t: f64, observers: &mut [&mut dyn Observer]) -> Result<StepInfo, SimulationError> {
        if !t.is_finite() {
            return Err(SimulationError::NotFinite { what: "time [s]", row: 0 });
        }
        self.go(StopAt { step: u64::MAX, t }, observers, &mut || false)
    }

    /// Makes steps up to step number `step` or to the first that ends at time `t` [s] or later, whichever comes first,
    /// or until `pause` says so, which is asked after every step or block of steps. [`StepInfo`] tells where it is; the
    /// same call goes on from there, with the bits of a run without a pause.
    ///
    /// # Errors
    /// As [`Simulation::run_until`], but `t` may be infinite.
    pub fn run_until_or(
        &mut self,
        step: u64,
        t: f64,
        mut pause: impl FnMut() -> bool,
    ) -> Result<StepInfo, SimulationError> {
        if t.is_nan() {
            return Err(SimulationError::NotFinite { what: "time [s]", row: 0 });
        }
        self.go(StopAt { step, t }, &mut [], &mut pause)
    }

    fn go(
        &mut self,
        until: StopAt,
        observers: &mut [&mut dyn Observer],
        pause: &mut dyn FnMut() -> bool,
    ) -> Result<StepInfo, SimulationError> {
        self.idle()?;
        let mut limit = until;
        self.watched(observers, Some(&mut limit), |sim, all| sim.make_steps(until, all, pause))
    }

    fn make_steps(
        &mut self,
        until: StopAt,
        observers: &mut [&mut dyn Observer],
        pause: &mut dyn FnMut() -> bool,
    ) -> Result<StepInfo, SimulationError> {
        if let Some(tangent) = self.tangent.take() {
            return self.make_followed_steps(tangent, until, observers, pause);
        }
        while !until.reached(self.state.steps, self.state.from.state.t) {
            let made = self.at_work(Stop::NEVER, |run, stepper| {
                if run.next().is_none() {
                    return Ok(None);
                }
                if !run.spec.keep_going {
                    run.state.failure = None;
                }
                match run.step_block(stepper, observers)? {
                    true => Ok(Some(StepEnd::Accepted)),
                    false => run.advance(stepper, observers).map(Some),
                }
            })?;
            match made {
                None => return Err(SimulationError::Ended { t: self.time() }),
                Some(StepEnd::Failed(_)) => return Err(self.failed()),
                Some(_) if pause() || interrupt::asked() => break,
                Some(_) => {}
            }
        }
        Ok(self.info())
    }

    /// Makes all steps that are left, watched by `observers`, until `stop` is set. A run that diverges or cannot be
    /// solved is not an error but an [`Outcome`].
    ///
    /// # Errors
    /// When an observer cannot write.
    pub fn run(&mut self, observers: &mut [&mut dyn Observer], stop: &AtomicBool) -> Result<Outcome, SimulationError> {
        self.idle()?;
        let begins = self.state.steps == 0 && !self.resumed;
        self.watched(observers, None, |sim, observers| {
            sim.at_work(Stop::on(stop), |run, stepper| match begins {
                true => run.begin(stepper, observers),
                false => run.go_on(stepper, observers),
            })
        })
    }

    fn info(&self) -> StepInfo {
        StepInfo { step: self.state.steps, time: self.time(), energies: self.state.row }
    }

    fn failed(&self) -> SimulationError {
        SimulationError::Failed(Box::new(self.state.failure.clone().unwrap_or_default()))
    }

    /// Binds the scheme to the scene for as long as `act` runs.
    fn at_work<R>(
        &mut self,
        stop: Stop<'_>,
        act: impl FnOnce(&mut Run<'_>, &mut Stepper<'_>) -> Result<R, RunError>,
    ) -> Result<R, SimulationError> {
        let scheme = self.scheme.take().ok_or(SimulationError::Broken)?;
        let scene = &*self.scene;
        let mut stepper = bind_scheme(scheme, &self.spec.method, scene)?;
        let interrupt = self.stop.as_deref().map_or(Stop::NEVER, Stop::on);
        let mut run = Run { scene, spec: &self.spec, stop, interrupt, state: &mut self.state };
        let ready = match self.changed {
            Changed::Nothing => Ok(()),
            changed => run.state.refresh(scene, &mut stepper, changed),
        };
        let done = ready.map(|()| act(&mut run, &mut stepper));
        self.scheme = Some(stepper.unbind());
        let done = done.map_err(RunError::from)?;
        self.changed = Changed::Nothing;
        Ok(done?)
    }
}

/// Ends [`Simulation::go`]; as an observer it wants the state there.
#[derive(Clone, Copy)]
struct StopAt {
    step: u64,
    /// [s]
    t: f64,
}

impl StopAt {
    /// Whether a step that ends at `t` [s] is the last, up to rounding of the time.
    fn reached(self, step: u64, t: f64) -> bool {
        step >= self.step || t >= self.t - 8.0 * f64::EPSILON * self.t.abs()
    }
}

impl Observer for StopAt {
    fn wants(&self, next: UpcomingStep) -> Wants {
        Wants::end_if(self.reached(next.step, next.t))
    }

    fn accepted(&mut self, _step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        Ok(())
    }
}
