//! The simulation that a program drives.

use crate::arrays::{filled, indices, of_indices, of_list, of_numbers, of_rows, rows, vector};
use crate::case::{Case, scene_of};
use crate::errors::{CaseError, SimulationError, engine, of_record, of_simulation};
use crate::forces::{PythonForce, Raised};
use crate::interrupt::{LOOK, looking};
use crate::logs;
use crate::network::Network;
use crate::record::checked_threads;
use crate::select::{mesh_of, selected};
use crate::sensitivity;
use crate::values::{Energies, Step, from_json};
use canopy_fem::drive::clock::{self, Tolerance};
use canopy_fem::integrate::registry::MethodChoice;
use canopy_fem::mesh::Mesh;
use canopy_fem::simulation::{self as door, Load, RecordError, RunSpec, SimulationError as Refusal, StepInfo};
use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::{PyKeyError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::pyclass::{PyTraverseError, PyVisit};
use pyo3::types::{PyBytes, PyDict};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::Instant;

/// A scene in motion.
#[pyclass(module = "canopy_fem._core", subclass, frozen)]
pub struct Simulation {
    sim: Mutex<door::Simulation>,
    /// exceptions of forces, and of signals
    raised: Arc<Raised>,
    /// forces that are functions, which the engine has too
    functions: Mutex<BTreeMap<String, Arc<PythonForce>>>,
    /// a state to go on from at the first use: in a copy, what functions refer to may not be whole before
    waiting: Mutex<Option<Vec<u8>>>,
    /// what does not change, in the numbering of the mesh
    mesh: Mesh,
}

type Rows<'py> = PyResult<Bound<'py, PyArray2<f64>>>;
/// Positions and velocities.
type Motion<'py> = PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>)>;

/// How a network of arrays moves: the keywords of `canopy_fem.Simulation`.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Settings {
    method: String,
    parameters: BTreeMap<String, f64>,
    /// [s]
    step: Option<f64>,
    /// [-] relative
    tolerance: Option<f64>,
    /// [s]
    end: f64,
}

impl Settings {
    fn run(self) -> PyResult<RunSpec> {
        let method = MethodChoice::new(&self.method, &self.parameters);
        let method = method.map_err(|error| CaseError::new_err(error.to_string()))?;
        let step = match (self.step, self.tolerance) {
            (Some(step), None) => clock::Step::Fixed(step),
            (None, Some(relative)) => clock::Step::Adaptive(Tolerance { relative, absolute: 0.01 * relative }),
            _ => return Err(PyTypeError::new_err("a network needs either step or tolerance")),
        };
        Ok(RunSpec::of(method, step, self.end))
    }
}

#[pymethods]
impl Simulation {
    /// A case, or a network with its settings, at t = 0.
    #[new]
    #[pyo3(signature = (source, *, threads=1, keep_going=false, free_steps=false, settings=None))]
    fn new(
        py: Python<'_>,
        source: &Bound<'_, PyAny>,
        threads: usize,
        keep_going: bool,
        free_steps: bool,
        settings: Option<Settings>,
    ) -> PyResult<Self> {
        let threads = checked_threads(threads)?;
        let made = match (source.cast::<Case>(), source.cast::<Network>(), settings) {
            (Ok(case), ..) => {
                let case = case.get().case.clone();
                engine(py, move || {
                    let settings = RunSpec { threads, keep_going, free_steps, ..case.problem().run_spec() };
                    let mut sim = door::Simulation::from_scene(&*scene_of(&case, threads)?, settings)?;
                    sim.measure(&case.problem().output)?;
                    Ok::<_, RecordError>(sim)
                })?
            }
            (_, Ok(network), Some(settings)) => {
                let settings = RunSpec { threads, keep_going, free_steps, ..settings.run()? };
                let spec = network.get().spec()?;
                engine(py, move || Ok(door::Simulation::new(spec, settings)?))?
            }
            _ => return Err(PyTypeError::new_err("a simulation is made of a case or of a network")),
        };
        let mut sim = made.map_err(|error| of_record(py, error))?;
        let raised = Arc::<Raised>::default();
        sim.stop_on(raised.flag.clone());
        let mesh = mesh_of(&*sim.scene());
        Ok(Simulation { sim: Mutex::new(sim), raised, functions: Mutex::default(), waiting: Mutex::default(), mesh })
    }

    /// Shows Python's collector of garbage the functions, which may refer to this simulation.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        // Both locks are free, unless a thread was halted for the collector while it had one.
        let Ok(functions) = self.functions.try_lock() else { return Ok(()) };
        functions.values().try_for_each(|force| match force.function.try_lock() {
            Ok(function) => visit.call(&*function),
            Err(_) => Ok(()),
        })
    }

    fn __clear__(&self) {
        let take = |force: &Arc<PythonForce>| force.function.lock().unwrap_or_else(PoisonError::into_inner).take();
        // They go after the locks, since their ends may run code.
        let taken: Vec<_> = self.own_functions().values().map(take).collect();
        drop(taken);
    }

    /// Makes n steps; the last one.
    ///
    /// Raises:
    ///     Diverged: a step diverges or cannot be solved; the state is that before it.
    ///     Ended: the end is reached, after the steps that were left.
    ///     SimulationError: an attempted step waits, or another thread uses the simulation.
    ///     KeyboardInterrupt: Ctrl-C; the steps so far are made.
    #[pyo3(signature = (n=1))]
    fn step(&self, py: Python<'_>, n: u64) -> PyResult<Step> {
        if n == 1 {
            return self.with(py, |sim| sim.step()).map(Step::from);
        }
        let last = self.with(py, |sim| Ok(sim.step_count()))?.saturating_add(n);
        self.until(py, last, f64::INFINITY)
    }

    /// Makes steps for a time [s], to the first that ends then or later.
    ///
    /// Raises:
    ///     ValueError: a time below 0 or not finite. Else as step.
    fn advance(&self, py: Python<'_>, duration: f64) -> PyResult<Step> {
        if !(duration >= 0.0 && duration.is_finite()) {
            return Err(PyValueError::new_err(format!("duration is {duration}: give a time [s] of 0 or more")));
        }
        let t = self.time()? + duration;
        self.until(py, u64::MAX, t)
    }

    /// Makes steps up to the first that ends at time t [s] or later; none where that is past.
    ///
    /// Raises:
    ///     ValueError: a time that is not finite. Else as step.
    fn run_until(&self, py: Python<'_>, t: f64) -> PyResult<Step> {
        if !t.is_finite() {
            return Err(PyValueError::new_err(format!("t is {t}: give a time [s]")));
        }
        self.until(py, u64::MAX, t)
    }

    /// Computes the next step without accepting it: its positions and velocities, each (n, 3).
    ///
    /// Its size is step [s], which a simulation with free steps takes, and is cut where an event of the scene lies
    /// within it.
    ///
    /// Raises:
    ///     ValueError: a step of 0 or less, or not finite. Else as `step`.
    #[pyo3(signature = (step=None))]
    fn attempt<'py>(&self, py: Python<'py>, step: Option<f64>) -> Motion<'py> {
        let motion = self.with(py, |sim| {
            match step {
                None => sim.attempt()?,
                Some(h) => sim.attempt_with_step(h)?,
            }
            Ok(sim.attempted())
        })?;
        let motion = motion.ok_or_else(|| SimulationError::new_err("the step has no end"))?;
        Ok((of_rows(py, motion.positions)?, of_rows(py, motion.velocities)?))
    }

    /// Accepts the attempted step.
    ///
    /// Raises:
    ///     SimulationError: there is none.
    ///     Diverged: its end cannot be right; then it is dropped.
    fn accept(&self, py: Python<'_>) -> PyResult<Step> {
        self.with(py, |sim| sim.accept()).map(Step::from)
    }

    /// Drops the attempted step: the state is the one before it.
    ///
    /// Raises:
    ///     SimulationError: there is none.
    fn drop(&self, py: Python<'_>) -> PyResult<()> {
        self.with(py, |sim| sim.drop_attempt())
    }

    /// The whole state as bytes, with forces, factors and wind that were set.
    fn snapshot<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &self.with(py, |sim| sim.snapshot())?))
    }

    /// Goes on from the bytes of a snapshot; what differs from the scene and run that it is of, a phrase each.
    ///
    /// Raises:
    ///     ValueError: damaged bytes, or those of other nodes or connections, or of another version.
    fn restore(&self, py: Python<'_>, state: &[u8]) -> PyResult<Vec<String>> {
        let state = state.to_vec();
        let (differs, set) = self.with(py, move |sim| Ok((sim.restore(&state)?, sim.acting_forces())))?;
        for (name, _) in &set {
            self.forget_function(name);
        }
        Ok(differs)
    }

    /// Goes on from the bytes of a snapshot when it is next used: for copies and pickles.
    fn _restore_later(&self, state: Vec<u8>) {
        *self.waiting.lock().unwrap_or_else(PoisonError::into_inner) = Some(state);
    }

    /// Replaces positions [m] and velocities [m/s], each (n, 3), and with time [s] the time as well. The energy account
    /// begins anew. Steps of fixed size count from 0: the next one ends where one does that began there.
    ///
    /// Raises:
    ///     ValueError, TypeError: another shape or type, a number that is not finite, a time before 0 or after the end.
    #[pyo3(signature = (positions, velocities, *, time=None))]
    fn set_state(
        &self,
        py: Python<'_>,
        positions: &Bound<'_, PyAny>,
        velocities: &Bound<'_, PyAny>,
        time: Option<f64>,
    ) -> PyResult<()> {
        let n = Some(self.mesh.nodes.len());
        let (x, v) = (rows(positions, "positions", n)?, rows(velocities, "velocities", n)?);
        self.with(py, move |sim| sim.set_state_at(time.unwrap_or(sim.time()), &x, &v))
    }

    /// Sets a force from outside: an array [N], (n, 3). As `forces[name] = force`.
    ///
    /// Raises:
    ///     ValueError, TypeError: another shape or type, a number that is not finite.
    ///     SimulationError: a pendulum, which has no forces from outside.
    fn set_force(&self, py: Python<'_>, name: &str, force: &Bound<'_, PyAny>) -> PyResult<()> {
        let force = rows(force, "force", Some(self.mesh.nodes.len()))?;
        self.with(py, |sim| sim.set_force(name, &force))?;
        self.forget_function(name);
        Ok(())
    }

    /// Sets a force that function(t, x, v) computes [N], (n, 3). As `forces.add`.
    ///
    /// Raises:
    ///     TypeError: no function.
    #[pyo3(signature = (name, function, *, velocity_dependent=true))]
    fn set_force_law(
        &self,
        py: Python<'_>,
        name: String,
        function: Py<PyAny>,
        velocity_dependent: bool,
    ) -> PyResult<()> {
        if !function.bind(py).is_callable() {
            return Err(PyTypeError::new_err("a force is an array or a function of t, x, v"));
        }
        let (raised, function) = (self.raised.clone(), Mutex::new(Some(function)));
        let law = Arc::new(PythonForce { name: name.clone(), function, velocity_dependent, raised });
        self.with(py, |sim| sim.set_force_law(&name, law.clone()))?;
        let before = self.own_functions().insert(name, law);
        drop(before);
        Ok(())
    }

    /// Removes a force; False if there is none of this name.
    fn remove_force(&self, py: Python<'_>, name: &str) -> PyResult<bool> {
        let removed = self.with(py, |sim| sim.remove_force(name))?;
        self.forget_function(name);
        Ok(removed)
    }

    /// Forces from outside that act, by name: arrays [N], (n, 3), and functions.
    fn acting_forces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        let set = self.lock()?.acting_forces();
        for (name, force) in set {
            all.set_item(name, of_rows(py, force)?)?;
        }
        for (name, force) in self.own_functions().iter() {
            all.set_item(name, force.function(py)?)?;
        }
        Ok(all)
    }

    /// Forces that are functions, by name, each with whether it depends on velocities.
    fn force_laws<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for (name, force) in self.own_functions().iter() {
            all.set_item(name, (force.function(py)?, force.velocity_dependent))?;
        }
        Ok(all)
    }

    /// Replaces the wind by a constant velocity [m/s], (3,), or goes back to that of the case with None.
    ///
    /// Raises:
    ///     ValueError, TypeError: another shape or type, a number that is not finite.
    ///     SimulationError: a scene without air.
    fn set_wind(&self, py: Python<'_>, wind: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let wind = wind.map(|given| vector(given, "wind")).transpose()?;
        self.with(py, move |sim| sim.set_wind(wind))
    }

    /// Multiplies the rest lengths of the springs on some edges, (k,), by a factor [-] above 0. As `rest_scale`.
    ///
    /// Raises:
    ///     ValueError, TypeError: an edge without a spring, a factor of 0 or less.
    fn set_rest_scale(&self, py: Python<'_>, edges: &Bound<'_, PyAny>, factor: f64) -> PyResult<()> {
        let edges = indices(edges, "edges")?;
        self.with(py, move |sim| sim.set_rest_scale(&edges, factor))
    }

    /// [-] factors of the rest lengths of all edges, (m,); NaN where an edge has no spring
    fn rest_scales<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (springs, factors) = self.with(py, |sim| Ok((sim.spring_edges(), sim.rest_scales())))?;
        let mut all = vec![f64::NAN; factors.len()];
        springs.iter().for_each(|&edge| all[edge as usize] = factors[edge as usize]);
        Ok(of_list(py, all))
    }

    /// Multiplies a load by a factor [-]: "gravity", "pressure 0", "force 0", … in the order of the case. As `loads`.
    ///
    /// Raises:
    ///     KeyError: no such load; the message lists those of the scene.
    ///     ValueError: a factor that is not finite.
    fn set_load_factor(&self, py: Python<'_>, name: &str, factor: f64) -> PyResult<()> {
        let loads = self.with(py, |sim| Ok(sim.load_factors()))?;
        let Some((load, _)) = loads.iter().find(|(load, _)| load_name(*load) == name) else {
            let known: Vec<String> = loads.iter().map(|(load, _)| load_name(*load)).collect();
            let text = format!("there is no load \"{name}\"; the scene has: {}", known.join(", "));
            return Err(PyKeyError::new_err(text));
        };
        self.with(py, |sim| sim.set_load_factor(*load, factor))
    }

    /// [-] factors of all loads, by name
    fn load_factors(&self, py: Python<'_>) -> PyResult<Vec<(String, f64)>> {
        let loads = self.with(py, |sim| Ok(sim.load_factors()))?;
        Ok(loads.into_iter().map(|(load, factor)| (load_name(load), factor)).collect())
    }

    /// Numbers of a group, (k,), or of "all", "boundary", "outer", "inner": of "nodes", "edges" or "triangles".
    ///
    /// Raises:
    ///     KeyError: no such group; the message lists those of the scene.
    ///     ValueError: another kind.
    #[pyo3(signature = (name, kind="nodes"))]
    fn select<'py>(&self, py: Python<'py>, name: &str, kind: &str) -> PyResult<Bound<'py, PyArray1<i64>>> {
        Ok(of_indices(py, &selected(&self.mesh, name, kind)?))
    }

    /// Names of the groups.
    #[getter]
    fn group_names(&self) -> Vec<String> {
        self.mesh.groups.keys().cloned().collect()
    }

    /// [s] time of the present state
    #[getter]
    fn time(&self) -> PyResult<f64> {
        Ok(self.lock()?.time())
    }

    /// [s] time at the end of the attempted step; None without one
    #[getter]
    fn attempted_time(&self) -> PyResult<Option<f64>> {
        Ok(self.lock()?.attempted_time())
    }

    /// [s] end of the run
    #[getter]
    fn end(&self) -> PyResult<f64> {
        Ok(self.lock()?.end())
    }

    /// accepted steps so far
    #[getter]
    fn step_count(&self) -> PyResult<u64> {
        Ok(self.lock()?.step_count())
    }

    /// number of nodes
    #[getter]
    fn node_count(&self) -> usize {
        self.mesh.nodes.len()
    }

    /// [m] positions, (n, 3); a copy, read-only
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> Rows<'py> {
        of_rows(py, self.lock()?.positions())
    }

    /// [m/s] velocities, (n, 3); a copy, read-only
    #[getter]
    fn velocities<'py>(&self, py: Python<'py>) -> Rows<'py> {
        of_rows(py, self.lock()?.velocities())
    }

    /// [m] positions, (n, 3), written into out: a C-contiguous array of float64. Returns out.
    ///
    /// Raises:
    ///     ValueError, TypeError: an out of another shape, type or layout, or one that is read-only.
    #[pyo3(signature = (out=None))]
    fn read_positions<'py>(&self, py: Python<'py>, out: Option<&Bound<'py, PyAny>>) -> Rows<'py> {
        let (sim, n) = (self.lock()?, self.mesh.nodes.len());
        let mut other = vec![[0.0; 3]; n];
        filled(py, n, out, |place| sim.read_nodes(place, &mut other).map_err(|error| of_simulation(py, error)))
    }

    /// [m/s] velocities, (n, 3), likewise.
    #[pyo3(signature = (out=None))]
    fn read_velocities<'py>(&self, py: Python<'py>, out: Option<&Bound<'py, PyAny>>) -> Rows<'py> {
        let (sim, n) = (self.lock()?, self.mesh.nodes.len());
        let mut other = vec![[0.0; 3]; n];
        filled(py, n, out, |place| sim.read_nodes(&mut other, place).map_err(|error| of_simulation(py, error)))
    }

    /// [N] what supports exert on the scene, own weights included, (n, 3), at the end of the last step; read-only
    #[getter]
    fn reactions<'py>(&self, py: Python<'py>) -> Rows<'py> {
        of_rows(py, self.lock()?.reactions())
    }

    /// [N] tension of every edge, (m,), with its axial dashpot; NaN where an edge has no spring; a copy, read-only
    #[getter]
    fn tension<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(of_list(py, self.lock()?.tensions()))
    }

    /// [m/s^2] accelerations by the forces that act now, (n, 3); 0 in held directions; a copy, read-only
    #[getter]
    fn accelerations<'py>(&self, py: Python<'py>) -> Rows<'py> {
        of_rows(py, self.with(py, |sim| Ok(sim.accelerations()))?)
    }

    /// what the gauges of the case and its canopies show now, by "name quantity", each in its SI unit
    #[getter]
    fn gauges<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for value in self.with(py, |sim| Ok(sim.gauges()))? {
            all.set_item(format!("{} {}", value.of.gauge, value.of.quantity), value.value)?;
        }
        Ok(all)
    }

    /// Goes along with the derivatives of the state by keys of the case.
    fn _follow(&self, py: Python<'_>, case: &Bound<'_, Case>, by: Vec<String>, threads: usize) -> PyResult<()> {
        sensitivity::follow(py, &mut *self.lock()?, case.get(), (&by, checked_threads(threads)?))
    }

    /// derivatives of the state by the keys of `sensitivity`: by key, those of the positions and those of the velocities,
    /// each (n, 3), over the unit of the key; copies, read-only
    #[getter]
    fn sensitivity<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        sensitivity::found(py, &*self.lock()?)
    }

    /// units of the gauges, by "name quantity"
    #[getter]
    fn gauge_units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for of in self.lock()?.channels() {
            all.set_item(format!("{} {}", of.gauge, of.quantity), of.unit)?;
        }
        Ok(all)
    }

    /// peaks of the gauges over all steps so far, by "name quantity", as `Result.peaks` has them; of components those
    /// of the largest magnitude. `set_state` begins them anew, and `restore` takes up those of the snapshot.
    #[getter]
    fn peaks<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for peak in self.lock()?.peaks() {
            all.set_item(format!("{} {}", peak.name, peak.quantity), peak.value)?;
        }
        Ok(all)
    }

    /// energy account of the present state
    #[getter]
    fn energies(&self, py: Python<'_>) -> PyResult<Energies> {
        self.with(py, |sim| Ok(sim.energies())).map(Energies::from)
    }

    /// counted work so far: force_evaluations, tangent_assemblies, factorizations, linear_solves, newton_iterations, …
    #[getter]
    fn counters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let counters = self.lock()?.counters();
        from_json(py, &counters)
    }

    /// [m] positions before any displacement, (n, 3); a copy, read-only
    #[getter]
    fn reference<'py>(&self, py: Python<'py>) -> Rows<'py> {
        of_rows(py, self.mesh.nodes.clone())
    }

    /// pairs of nodes, (m, 2); a copy, read-only
    #[getter]
    fn edges<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        of_numbers(py, &self.mesh.edges)
    }

    /// triples of nodes, (k, 3); a copy, read-only
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        of_numbers(py, &self.mesh.triangles)
    }
}

impl Simulation {
    /// The function goes after the lock, since its end may run code.
    fn forget_function(&self, name: &str) {
        let gone = self.own_functions().remove(name);
        drop(gone);
    }

    fn own_functions(&self) -> MutexGuard<'_, BTreeMap<String, Arc<PythonForce>>> {
        self.functions.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn lock(&self) -> PyResult<MutexGuard<'_, door::Simulation>> {
        let mut sim = match self.sim.try_lock() {
            Ok(sim) => sim,
            // After a panic the engine says itself what it refuses.
            Err(TryLockError::Poisoned(sim)) => sim.into_inner(),
            Err(TryLockError::WouldBlock) => {
                let text = "the simulation is at work: another thread uses it, or a force of its own does";
                return Err(SimulationError::new_err(text));
            }
        };
        let mut waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(state) = waiting.as_ref() {
            let done = sim.restore(state);
            match self.raised.take() {
                Some(error) => return Err(error),
                None => Python::attach(|py| done.map_err(|error| of_simulation(py, error)))?,
            };
            *waiting = None;
        }
        drop(waiting);
        Ok(sim)
    }

    /// Calls the engine without the interpreter; exceptions of forces come first.
    fn with<R: Send>(
        &self,
        py: Python<'_>,
        act: impl FnOnce(&mut door::Simulation) -> Result<R, Refusal> + Send,
    ) -> PyResult<R> {
        let mut guard = self.lock()?;
        let sim = &mut *guard;
        let done = engine(py, || looking(&self.raised, || act(sim)))?;
        match self.raised.take() {
            Some(error) => Err(error),
            None => logs::tell(py).and_then(|()| done.map_err(|error| of_simulation(py, error))),
        }
    }

    /// Makes steps, with a look at signals in between.
    fn until(&self, py: Python<'_>, step: u64, t: f64) -> PyResult<Step> {
        loop {
            let done: StepInfo = self.with(py, |sim| {
                let start = Instant::now();
                sim.run_until_or(step, t, || start.elapsed() > LOOK)
            })?;
            // As the engine says when a time is reached.
            if done.step >= step || done.time >= t - 8.0 * f64::EPSILON * t.abs() {
                return Ok(done.into());
            }
            py.check_signals()?;
        }
    }
}

/// "gravity", "pressure 0", "force 0".
pub(crate) fn load_name(load: Load) -> String {
    match load {
        Load::Gravity => "gravity".to_owned(),
        Load::Pressure(place) => format!("pressure {place}"),
        Load::Forces(place) => format!("force {place}"),
    }
}
