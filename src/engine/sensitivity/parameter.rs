//! A parameter of a scene: scenes with other values of it, and what these do to forces at a given state.

use super::difference::{PLACES, Sizes, derivative};
use super::error::SensitivityError;
use crate::model::forces::Forces;
use crate::model::point::Point;
use crate::model::state::{State, StateRef};
use crate::scene::{Scene, event_times, pass_events, sample_tables};

/// How often a law switched within the differences.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Switches {
    /// stages of steps with it
    pub stages: u64,
    /// stages of steps
    pub of: u64,
}

/// A number that a scene is built from, with scenes that have other values of it.
pub struct Varied {
    /// its name
    pub name: String,
    /// scenes with its value at the [places](PLACES) around its own
    pub scenes: [Box<dyn Scene>; 4],
    /// its step, in its own unit
    pub h: f64,
}

/// A number that a scene is built from.
pub struct Parameter {
    /// its name
    pub name: String,
    /// scenes with its value at the [places](PLACES) around its own
    scenes: [Box<dyn Scene>; 4],
    /// its step, in its own unit
    h: f64,
    /// [m] positions of held degrees of freedom in these scenes, less those in the scene itself
    held: Vec<(usize, [f64; 4])>,
    /// stages with a switch
    pub switches: Switches,
    at: State,
    forces: Forces,
    values: [Vec<f64>; 4],
}

impl Parameter {
    /// A parameter of `scene`, whose run starts at `start`. `steps` [s] is the size of the steps, with which tables are
    /// sampled.
    ///
    /// # Errors
    /// Scenes that differ in more than numbers.
    pub fn new(
        scene: &dyn Scene,
        start: &State,
        Varied { name, scenes, h }: Varied,
        steps: Option<f64>,
    ) -> Result<Self, SensitivityError> {
        let fault = |what| SensitivityError::OtherScene { parameter: name.clone(), what };
        let n = scene.n_dof();
        for other in &scenes {
            if other.n_dof() != n {
                return Err(fault("the number of nodes"));
            }
            if (0..n).step_by(3).any(|dof| other.name_of(dof) != scene.name_of(dof)) {
                return Err(fault("how nodes are connected"));
            }
            let fixed = |scene: &dyn Scene, dof: usize| scene.inverse_mass().get(dof).is_some_and(|m| *m == 0.0);
            if (0..n).any(|dof| fixed(&**other, dof) != fixed(scene, dof)) {
                return Err(fault("which nodes are held"));
            }
            if event_times(&**other) != event_times(scene) {
                return Err(fault("the times of events"));
            }
            if other.terms() != scene.terms() || other.rank_ones() != scene.rank_ones() {
                return Err(fault("which forces act"));
            }
            sample_tables(&**other, steps);
            pass_events(&**other, 0);
        }
        let starts = scenes.each_ref().map(|scene| scene.initial_state());
        let held = (0..n).filter(|dof| scene.inverse_mass()[*dof] == 0.0);
        let moved = |dof: usize| (dof, starts.each_ref().map(|other| other.x[dof] - start.x[dof]));
        let held: Vec<_> = held.map(moved).filter(|(_, by)| by.iter().any(|by| *by != 0.0)).collect();
        if scene.moved().iter().any(|&dof| starts.iter().any(|other| other.v[dof as usize] != start.v[dof as usize])) {
            return Err(fault("how supports move"));
        }
        let (forces, zero) = (scene.new_forces(), vec![0.0; n]);
        let values = [(); 4].map(|()| zero.clone());
        Ok(Parameter { name, scenes, h, held, switches: Switches::default(), at: start.clone(), forces, values })
    }

    /// Derivatives of positions and velocities at the start of a run, in the unit of these over that of the parameter.
    pub fn start(&self) -> [Vec<f64>; 2] {
        let starts = self.scenes.each_ref().map(|scene| scene.initial_state());
        let n = self.at.x.len();
        let of = |part: &dyn Fn(&State, usize) -> f64| {
            (0..n).map(|dof| derivative(starts.each_ref().map(|start| part(start, dof)), self.h)).collect()
        };
        [of(&|start, dof| start.x[dof]), of(&|start, dof| start.v[dof])]
    }

    /// Events that are passed in all scenes.
    pub fn pass_events(&self, passed: usize) {
        self.scenes.iter().for_each(|scene| {
            pass_events(&**scene, passed);
        });
    }

    /// Writes d(M^-1 f)/dp at a state into `out` `[n_dof]`; `middle` [m/s^2] is M^-1 f of the scene itself there.
    pub fn acceleration_slope(&mut self, at: StateRef<'_>, middle: &[f64], out: &mut [f64]) {
        for (place, scene) in self.scenes.iter().enumerate() {
            self.at.copy_from(at);
            let held = self.held.iter().filter(|(dof, _)| scene.inverse_mass()[*dof] == 0.0);
            held.for_each(|(dof, by)| self.at.x[*dof] += by[place]);
            scene.evaluate(self.at.as_ref(), &mut self.forces);
            let products = self.forces.total.iter().zip(scene.inverse_mass());
            self.values[place].iter_mut().zip(products).for_each(|(value, (f, m))| *value = m * f);
        }
        let (mut sizes, [a, b, c, d]) = (Sizes::default(), &self.values);
        for (i, (out, middle)) in out.iter_mut().zip(middle).enumerate() {
            let values = [a[i], b[i], c[i], d[i]];
            sizes.add(values, *middle);
            *out = derivative(values, self.h);
        }
        self.switches.of += 1;
        self.switches.stages += u64::from(sizes.switches());
    }

    /// Calls `measure` with each scene at its place along a direction: the state and forces of that scene at
    /// x + s h dx and v + s h dv. `force_v` are the velocities [m/s] and their derivatives at which forces are found,
    /// where these are not the state's.
    pub fn along(
        &mut self,
        at: StateRef<'_>,
        [dx, dv]: [&[f64]; 2],
        force_v: Option<[&[f64]; 2]>,
        mut measure: impl FnMut(usize, &dyn Scene, &Point),
    ) {
        let mut point = Point::default();
        for (place, (scene, share)) in self.scenes.iter().zip(PLACES).enumerate() {
            let by = share * self.h;
            let moved =
                |of: &[f64], along: &[f64]| -> Vec<f64> { of.iter().zip(along).map(|(a, d)| a + by * d).collect() };
            point.state = State { t: at.t, x: moved(at.x, dx), v: moved(at.v, dv) };
            point.forces.clone_from(&self.forces);
            let velocities = force_v.map(|[v, dv]| moved(v, dv));
            let v = velocities.as_deref().unwrap_or(&point.state.v);
            scene.evaluate(StateRef { v, ..point.state.as_ref() }, &mut point.forces);
            measure(place, &**scene, &point);
        }
    }

    /// [1] Its step.
    pub fn h(&self) -> f64 {
        self.h
    }
}
