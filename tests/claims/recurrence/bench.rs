//! The oscillator, the methods to try, and a run with every step in the hands of the test.

use std::collections::BTreeMap;

use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::integrate::Counters;
use canopy_fem::integrate::implicit::SolverSpec;
use canopy_fem::integrate::registry::{Family, MethodChoice, methods};
use canopy_fem::integrate::stepper::{Attempt, Stepper};
use canopy_fem::model::point::Point;
use canopy_fem::model::spec::*;
use canopy_fem::model::system::System;
use canopy_fem::scene::{Network, Scene, build_network};
use canopy_fem::solve::newton::NewtonSpec;

use crate::common::{OscillatorSpec, oscillator};

/// x'' = -w^2 x - d v + g with d = 2 zeta w.
#[derive(Clone, Copy, Debug)]
pub struct Oscillator {
    /// [rad/s] w
    pub frequency: f64,
    /// [-] zeta
    pub ratio: f64,
    /// [m/s^2] g
    pub push: f64,
}

/// Which of the program's terms stands for the damping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Damper {
    Axial,
    Relative,
    /// the relative dashpot c = k h that Kang's filter contains
    FromStep,
    RayleighMass,
    RayleighStiffness,
}

/// [kg]
pub const MASS: f64 = 0.8;
/// [m] length of the spring at rest: only 16 times the displacement, so that few digits are lost in x = l0 + u
pub const REST: f64 = 1.0;

impl Oscillator {
    pub fn d(self) -> f64 {
        2.0 * self.ratio * self.frequency
    }

    pub fn a(self, x: f64, v: f64) -> f64 {
        self.push - self.frequency.powi(2) * x - self.d() * v
    }

    /// The mass hangs on a spring from an anchor and moves along it only, so the net is linear.
    pub fn scene(self, start: [f64; 2], damper: Damper) -> Network {
        let stiffness = MASS * self.frequency.powi(2);
        let mut spec = oscillator(OscillatorSpec { stiffness, mass: MASS, displacement: start[0] });
        spec.mesh.nodes = vec![[-REST, 0.0, 0.0], [0.0; 3]];
        spec.fixed[1] = [false, true, true];
        spec.velocity = vec![[0.0; 3], [start[1], 0.0, 0.0]];
        let coefficient = (MASS * self.d()).into();
        let group = &mut spec.springs[0];
        group.rest_length = vec![REST];
        let dashpot = |kind, from_step| Some(DashpotSpec { kind, coefficient, from_step });
        match damper {
            Damper::Axial => group.dashpot = dashpot(DashpotKind::Axial, false),
            Damper::Relative => group.dashpot = dashpot(DashpotKind::Relative, false),
            Damper::FromStep => group.dashpot = dashpot(DashpotKind::Relative, true),
            Damper::RayleighMass => spec.rayleigh = Some(RayleighSpec { mass: self.d(), stiffness: 0.0 }),
            Damper::RayleighStiffness => {
                spec.rayleigh = Some(RayleighSpec { mass: 0.0, stiffness: self.d() / self.frequency.powi(2) });
            }
        }
        if self.push != 0.0 {
            let force = [MASS * self.push, 0.0, 0.0];
            spec.forces = vec![NodalLoad { nodes: vec![1], force, factor: None }];
        }
        build_network(spec, Threads::one()).expect("an oscillator")
    }
}

/// A method with its parameters and what the literature says it does.
pub struct Case {
    pub method: &'static str,
    pub parameters: Vec<(&'static str, f64)>,
}

pub fn cases() -> Vec<Case> {
    let mut cases: Vec<Case> = methods().iter().map(|m| Case { method: m.name, parameters: vec![] }).collect();
    let mut add = |method, parameters: &[(&'static str, f64)]| {
        cases.push(Case { method, parameters: parameters.to_vec() });
    };
    add("newmark", &[("gamma", 0.6)]);
    add("newmark", &[("beta", 0.3), ("gamma", 0.5)]);
    add("newmark", &[("beta", 1.0 / 6.0)]);
    add("newmark", &[("beta", 0.5), ("gamma", 1.0)]);
    for alpha in [-1.0 / 3.0, -0.3, -0.05, 0.0] {
        add("hht", &[("alpha", alpha)]);
    }
    for rho_inf in [0.0, 0.3, 0.5, 1.0] {
        add("generalized-alpha", &[("rho_inf", rho_inf)]);
    }
    for substeps in [1.0, 2.0, 5.0] {
        add("multirate", &[("substeps", substeps)]);
    }
    for (substeps, iterations) in [(1.0, 1.0), (1.0, 5.0), (4.0, 2.0)] {
        add("xpbd", &[("substeps", substeps), ("iterations", iterations)]);
    }
    add("vbd", &[("iterations", 1.0)]);
    for dissipation in [0.1, 0.5, 1.0] {
        add("energy-momentum", &[("dissipation", dissipation)]);
    }
    cases
}

impl Case {
    pub fn value(&self, name: &str, default: f64) -> f64 {
        self.parameters.iter().find(|p| p.0 == name).map_or(default, |p| p.1)
    }

    pub fn choice(&self) -> MethodChoice {
        let given: BTreeMap<String, f64> = self.parameters.iter().map(|(k, v)| ((*k).to_owned(), *v)).collect();
        MethodChoice::new(self.method, &given).expect("registered")
    }

    /// Newton asked for all digits: the recurrence has them.
    pub fn stepper<'a>(&self, scene: &'a Network) -> Stepper<'a> {
        let newton = NewtonSpec { relative: 1e-15, ..Default::default() };
        let solver = SolverSpec { newton, ..Default::default() };
        Stepper::bind(self.choice().scheme(solver), scene.interfaces()).expect("a network")
    }

    pub fn name(&self) -> String {
        let parameters = self.parameters.iter().map(|(name, value)| format!(" {name} {value:.4}"));
        std::iter::once(self.method.to_owned()).chain(parameters).collect()
    }

    pub fn is_implicit(&self) -> bool {
        self.choice().info.family == Family::Implicit
    }
}

/// A run step by step, with everything in the hands of the test.
pub struct Walk<'a> {
    pub stepper: Stepper<'a>,
    pub from: Point,
    to: Point,
    counters: Counters,
    scene: &'a Network,
}

impl<'a> Walk<'a> {
    pub fn start(case: &Case, scene: &'a Network) -> Self {
        let mut from = Point { state: scene.initial_state(), forces: scene.new_forces() };
        scene.evaluate(from.state.as_ref(), &mut from.forces);
        Walk::from_point(case, scene, from)
    }

    pub fn from_point(case: &Case, scene: &'a Network, from: Point) -> Self {
        let mut stepper = case.stepper(scene);
        stepper.start(&from).expect("a small scene");
        Walk { stepper, to: from.clone(), from, counters: Counters::default(), scene }
    }

    /// Attempts a step and leaves it at that; the forces at its end are made as the driver makes them.
    pub fn attempt(&mut self, h: f64) {
        let t_next = self.from.state.t + h;
        let attempt = Attempt { from: &self.from, h, t_next };
        let report = self.stepper.attempt(attempt, &mut self.to, &mut self.counters).expect("an easy step");
        if !report.forces_at_end {
            self.scene.evaluate(self.to.state.as_ref(), &mut self.to.forces);
        }
    }

    pub fn step(&mut self, h: f64) {
        self.attempt(h);
        self.stepper.accept();
        std::mem::swap(&mut self.from, &mut self.to);
    }

    pub fn bits(&self) -> Vec<u64> {
        let carried = self.stepper.save();
        let state = &self.from.state;
        let vectors = carried.vectors.iter().flatten();
        state.x.iter().chain(&state.v).chain(&self.from.forces.total).chain(vectors).map(|v| v.to_bits()).collect()
    }
}
