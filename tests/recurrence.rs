//! Every method on a damped oscillator against its own amplification recurrence, written down by hand from the literature
//! and not from the program: as matrix polynomials, two-step formulas or one equation for the new acceleration.

mod common;

use canopy_fem::force::batch::Threads;
use canopy_fem::integrate::implicit::SolverSpec;
use canopy_fem::integrate::registry::{MethodChoice, methods};
use canopy_fem::integrate::stepper::{Attempt, Stepper};
use canopy_fem::integrate::{Carried, Counters};
use canopy_fem::model::point::Point;
use canopy_fem::model::spec::*;
use canopy_fem::model::system::System;
use canopy_fem::scene::{Network, Scene, build_network};
use canopy_fem::solve::newton::NewtonSpec;
use common::{OscillatorSpec, oscillator, patch, spring_group};
use std::collections::BTreeMap;

/// x'' = -w^2 x - d v + g with d = 2 zeta w.
#[derive(Clone, Copy, Debug)]
struct Oscillator {
    /// [rad/s] w
    frequency: f64,
    /// [-] zeta
    ratio: f64,
    /// [m/s^2] g
    push: f64,
}

/// Which of the program's terms stands for the damping.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Damper {
    Axial,
    Relative,
    /// the relative dashpot c = k h that Kang's filter contains
    FromStep,
    RayleighMass,
    RayleighStiffness,
}

/// [kg]
const MASS: f64 = 0.8;
/// [m] where the mass is at rest: short against the displacement, so that few digits are lost in x = l0 + u
const REST: f64 = 1.0;

impl Oscillator {
    fn d(self) -> f64 {
        2.0 * self.ratio * self.frequency
    }

    fn a(self, x: f64, v: f64) -> f64 {
        self.push - self.frequency.powi(2) * x - self.d() * v
    }

    /// The mass hangs on a spring from an anchor and moves along it only, so the net is linear.
    fn scene(self, start: [f64; 2], damper: Damper) -> Network {
        let stiffness = MASS * self.frequency.powi(2);
        let mut spec = oscillator(OscillatorSpec { stiffness, mass: MASS, displacement: start[0] });
        spec.mesh.nodes = vec![[-REST, 0.0, 0.0], [0.0; 3]];
        spec.fixed[1] = [false, true, true];
        spec.velocity = vec![[0.0; 3], [start[1], 0.0, 0.0]];
        let coefficient = vec![MASS * self.d()];
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

/// x, v, a of the recurrence; `a` is the acceleration that the method itself carries.
#[derive(Clone, Copy, Debug)]
struct Motion {
    x: f64,
    v: f64,
    a: f64,
}

type Matrix = [[f64; 2]; 2];

fn product(a: Matrix, b: Matrix) -> Matrix {
    [0, 1].map(|i| [0, 1].map(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
}

/// p(h A) y for x' = A y + (0, g) where p is the truncated exponential series of `degree`, and the forcing
/// enters through phi(h A) = sum (h A)^k/(k+1)!: what any Runge-Kutta method with as many stages as its order does.
fn taylor(o: Oscillator, h: f64, degree: i32, m: Motion) -> Motion {
    let za = [[0.0, h], [-h * o.frequency.powi(2), -h * o.d()]];
    let (mut power, mut factorial) = ([[1.0, 0.0], [0.0, 1.0]], 1.0);
    let mut y = [m.x, m.v];
    for k in 1..=degree {
        // h g (hA)^(k-1)/k! before, (hA)^k/k! after the power is raised.
        factorial *= f64::from(k);
        for (i, y) in y.iter_mut().enumerate() {
            *y += power[i][1] * h * o.push / factorial;
        }
        power = product(za, power);
        for (i, y) in y.iter_mut().enumerate() {
            *y += (power[i][0] * m.x + power[i][1] * m.v) / factorial;
        }
    }
    Motion { x: y[0], v: y[1], a: 0.0 }
}

/// Weights of M [(1 - am) a1 + am a0] = (1 - af) f1 + af f0 with Newmark's x1 and v1.
struct Weighted {
    beta: f64,
    gamma: f64,
    am: f64,
    af: f64,
}

/// One linear equation for a1 (the program solves for the displacement instead).
fn newmark_family(o: Oscillator, h: f64, w: &Weighted, m: Motion) -> Motion {
    let Weighted { beta, gamma, am, af } = *w;
    let x_predicted = m.x + h * m.v + h * h * (0.5 - beta) * m.a;
    let v_predicted = m.v + h * (1.0 - gamma) * m.a;
    let right = (1.0 - af) * o.a(x_predicted, v_predicted) + af * o.a(m.x, m.v) - am * m.a;
    let left = (1.0 - am) + (1.0 - af) * (gamma * h * o.d() + beta * h * h * o.frequency.powi(2));
    let a = right / left;
    Motion { x: x_predicted + beta * h * h * a, v: v_predicted + gamma * h * a, a }
}

/// The states that PEC *predicts* follow Adams-Bashforth 2 after one step of Euler; the corrected state is
/// y_n = p_n + h/2 (p'_n - p'_{n-1}).
fn adams_bashforth(o: Oscillator, h: f64, start: Motion, steps: usize) -> Vec<Motion> {
    let slope = |p: [f64; 2]| [p[1], o.a(p[0], p[1])];
    let mut p = [start.x, start.v];
    let mut before = slope(p);
    p = [0, 1].map(|i| p[i] + h * before[i]);
    let mut motions = Vec::new();
    for _ in 0..steps {
        let now = slope(p);
        let y = [0, 1].map(|i| p[i] + 0.5 * h * (now[i] - before[i]));
        motions.push(Motion { x: y[0], v: y[1], a: 0.0 });
        p = [0, 1].map(|i| p[i] + h * (1.5 * now[i] - 0.5 * before[i]));
        before = now;
    }
    motions
}

/// dv = F h/(m + h^2 k) with F = -k x + h k (0 - v); damping and load act outside the filter.
fn kang(o: Oscillator, h: f64, damper: Damper, m: Motion) -> Motion {
    let k = o.frequency.powi(2);
    let filtered = -k * m.x - h * k * m.v;
    // A "step" dashpot is the h k (0 - v) above and does not act again, whatever its coefficient is.
    let outside = o.push - if damper == Damper::FromStep { 0.0 } else { o.d() * m.v };
    let v = m.v + filtered * h / (1.0 + h * h * k) + h * outside;
    Motion { x: m.x + h * v, v, a: 0.0 }
}

/// A method with its parameters and what the literature says it does.
struct Case {
    method: &'static str,
    parameters: Vec<(&'static str, f64)>,
}

fn cases() -> Vec<Case> {
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
    cases
}

impl Case {
    fn value(&self, name: &str, default: f64) -> f64 {
        self.parameters.iter().find(|p| p.0 == name).map_or(default, |p| p.1)
    }

    /// The recurrence, `steps` steps from rest of everything but x and v.
    fn expected(&self, o: Oscillator, h: f64, damper: Damper, start: Motion, steps: usize) -> Vec<Motion> {
        let newmark = |beta, gamma| Weighted { beta, gamma, am: 0.0, af: 0.0 };
        let step: Box<dyn Fn(Motion) -> Motion> = match self.method {
            "explicit-euler" => Box::new(move |m| taylor(o, h, 1, m)),
            "euler-richardson" | "improved-euler" => Box::new(move |m| taylor(o, h, 2, m)),
            "rk4" => Box::new(move |m| taylor(o, h, 4, m)),
            "improved-euler-pec" => return adams_bashforth(o, h, start, steps),
            "euler-cromer" => Box::new(move |m| {
                // x_{n+1} from its own row of the matrix [[1 - w^2 h^2, h - d h^2], [-w^2 h, 1 - d h]].
                let (w2, d) = (o.frequency.powi(2), o.d());
                let x = (1.0 - w2 * h * h) * m.x + (h - d * h * h) * m.v + h * h * o.push;
                Motion { x, v: -w2 * h * m.x + (1.0 - d * h) * m.v + h * o.push, a: 0.0 }
            }),
            "velocity-verlet" => Box::new(move |m| {
                let a = o.a(m.x, m.v);
                let x = m.x + h * m.v + 0.5 * h * h * a;
                let star = o.a(x, m.v + h * a);
                Motion { x, v: m.v + 0.5 * h * (a + star), a: 0.0 }
            }),
            "newmark" => {
                let w = newmark(self.value("beta", 0.25), self.value("gamma", 0.5));
                Box::new(move |m| newmark_family(o, h, &w, m))
            }
            "hht" => {
                let alpha = self.value("alpha", -0.1);
                let w = Weighted { beta: (1.0 - alpha).powi(2) / 4.0, gamma: 0.5 - alpha, am: 0.0, af: -alpha };
                Box::new(move |m| newmark_family(o, h, &w, m))
            }
            "generalized-alpha" => {
                let r = self.value("rho_inf", 0.8);
                let (am, af) = ((2.0 * r - 1.0) / (r + 1.0), r / (r + 1.0));
                let w = Weighted { beta: (1.0 - am + af).powi(2) / 4.0, gamma: 0.5 - am + af, am, af };
                Box::new(move |m| newmark_family(o, h, &w, m))
            }
            "backward-euler" => Box::new(move |m| {
                // (I - h A) y1 = y0 + h (0, g), solved by Cramer's rule.
                let (w2, d) = (o.frequency.powi(2), o.d());
                let det = 1.0 + h * d + h * h * w2;
                let right = m.v + h * o.push;
                Motion { x: ((1.0 + h * d) * m.x + h * right) / det, v: (right - h * w2 * m.x) / det, a: 0.0 }
            }),
            "kang" => Box::new(move |m| kang(o, h, damper, m)),
            other => panic!("write the recurrence of {other} here"),
        };
        let mut m = Motion { a: o.a(start.x, start.v), ..start };
        let mut advance = || {
            m = step(m);
            m
        };
        (0..steps).map(|_| advance()).collect()
    }

    fn choice(&self) -> MethodChoice {
        let given: BTreeMap<String, f64> = self.parameters.iter().map(|(k, v)| ((*k).to_owned(), *v)).collect();
        MethodChoice::new(self.method, &given).expect("registered")
    }

    /// Newton asked for all digits: the recurrence has them.
    fn stepper<'a>(&self, scene: &'a Network) -> Stepper<'a> {
        let newton = NewtonSpec { relative: 1e-15, ..Default::default() };
        let solver = SolverSpec { newton, ..Default::default() };
        Stepper::bind(self.choice().scheme(solver), scene.abilities()).expect("a network")
    }

    fn name(&self) -> String {
        format!("{} {:?}", self.method, self.parameters)
    }
}

/// A run step by step, with everything in the hands of the test.
struct Walk<'a> {
    stepper: Stepper<'a>,
    from: Point,
    to: Point,
    counters: Counters,
    scene: &'a Network,
}

impl<'a> Walk<'a> {
    fn start(case: &Case, scene: &'a Network) -> Self {
        let mut from = Point { state: scene.initial_state(), forces: scene.new_forces() };
        scene.evaluate(from.state.as_ref(), &mut from.forces);
        Walk::from_point(case, scene, from)
    }

    fn from_point(case: &Case, scene: &'a Network, from: Point) -> Self {
        let mut stepper = case.stepper(scene);
        stepper.start(&from).expect("a small scene");
        Walk { stepper, to: from.clone(), from, counters: Counters::default(), scene }
    }

    /// Attempts a step and leaves it at that; the forces at its end are made as the driver makes them.
    fn attempt(&mut self, h: f64) {
        let t_next = self.from.state.t + h;
        let attempt = Attempt { from: &self.from, h, t_next };
        let report = self.stepper.attempt(attempt, &mut self.to, &mut self.counters).expect("an easy step");
        if !report.forces_at_end {
            self.scene.evaluate(self.to.state.as_ref(), &mut self.to.forces);
        }
    }

    fn step(&mut self, h: f64) {
        self.attempt(h);
        self.stepper.accept();
        std::mem::swap(&mut self.from, &mut self.to);
    }

    fn bits(&self) -> Vec<u64> {
        let carried = self.stepper.save();
        let state = &self.from.state;
        let vectors = carried.vectors.iter().flatten();
        state.x.iter().chain(&state.v).chain(&self.from.forces.total).chain(vectors).map(|v| v.to_bits()).collect()
    }
}

/// Degree of freedom of the mass along the spring, whatever the inner numbering is.
fn moving(scene: &Network) -> usize {
    (0..scene.n_dof()).find(|&i| scene.inverse_mass()[i] > 0.0).expect("one free degree of freedom")
}

fn follow(case: &Case, o: Oscillator, wh: f64, damper: Damper) -> f64 {
    let h = wh / o.frequency;
    let start = Motion { x: 0.0625, v: -0.03125, a: 0.0 };
    let scene = o.scene([start.x, start.v], damper);
    let mut walk = Walk::start(case, &scene);
    let dof = moving(&scene);
    let (mut size, mut worst, mut followed) = (start.x.abs(), 0.0_f64, 0);
    for expected in case.expected(o, h, damper, start, 40) {
        walk.step(h);
        let (x, v) = (walk.from.state.x[dof], walk.from.state.v[dof]);
        // An unstable step throws the mass through its anchor, where the spring is no longer linear; the predicted states of
        // a step go farther than its result.
        if expected.x.abs() > 0.25 * REST {
            break;
        }
        size = size.max(expected.x.abs()).max(expected.v.abs() / o.frequency);
        let error = (x - expected.x).abs().max((v - expected.v).abs() / o.frequency) / size;
        worst = worst.max(error);
        followed += 1;
    }
    assert!(followed >= 2, "{}: w h {wh}, {o:?}: nothing was followed", case.name());
    worst
}

/// Each method is exactly the method of the literature on x'' = -w^2 x - 2 zeta w x' + g, whichever term damps.
#[test]
fn every_method_follows_its_recurrence() {
    let dampers = [Damper::Axial, Damper::Relative, Damper::FromStep, Damper::RayleighMass, Damper::RayleighStiffness];
    for case in cases() {
        for (wh, ratio) in [0.1, 0.7, 1.5].into_iter().flat_map(|wh| [0.0, 0.1, 1.0].map(|ratio| (wh, ratio))) {
            for (damper, push) in dampers.into_iter().zip([0.0, 0.15, 0.0, 0.15, 0.0]) {
                let o = Oscillator { frequency: 1.7, ratio, push };
                let error = follow(&case, o, wh, damper);
                assert!(error < 1e-13, "{} w h {wh} zeta {ratio} {damper:?}: off by {error:e}", case.name());
            }
        }
    }
}

/// Under a constant load with damping every implicit method comes to rest at x = F/K: its force weights sum to one.
/// (The thesis' Eq. 41 would end at F/((1 - 2 alpha) K).)
#[test]
fn the_static_answer_is_exact_for_every_parameter() {
    let o = Oscillator { frequency: 1.7, ratio: 0.5, push: 0.6 };
    let implicit = ["newmark", "hht", "generalized-alpha", "backward-euler"];
    for case in cases().iter().filter(|c| implicit.contains(&c.method)) {
        for damper in [Damper::Axial, Damper::RayleighMass] {
            let scene = o.scene([0.0, 0.0], damper);
            let mut walk = Walk::start(case, &scene);
            (0..400).for_each(|_| walk.step(0.6));
            let (x, exact) = (walk.from.state.x[moving(&scene)], o.push / o.frequency.powi(2));
            assert!((x - exact).abs() < 1e-14, "{}: {x} for {exact}", case.name());
        }
    }
}

/// A sheet with every kind of term that a tangent or a carried vector could go wrong on.
fn sheet() -> Network {
    let mut spec = patch();
    let mut group = spring_group(&spec, Slack::TensionOnly);
    let coefficient = vec![0.5; group.edges.len()];
    group.dashpot = Some(DashpotSpec { kind: DashpotKind::Axial, coefficient, from_step: false });
    spec.springs = vec![group];
    spec.gravity = Some([0.0, 0.0, -9.81]);
    let wind = Series { t: vec![0.0, 1.0], value: vec![[0.0, 0.5, 5.0], [1.0, 0.0, 9.0]] };
    spec.air = Some(AirSpec { linear: 0.8, quadratic: 0.2, wind });
    spec.rayleigh = Some(RayleighSpec { mass: 0.1, stiffness: 1e-3 });
    build_network(spec, Threads::one()).expect("the fixture is sound")
}

/// What a scheme saves is all it needs: a new stepper that starts at the saved point and takes the saved vectors over goes on
/// with the same bits.
#[test]
fn a_restored_scheme_goes_on_with_the_same_bits() {
    let scene = sheet();
    for case in cases() {
        let mut whole = Walk::start(&case, &scene);
        (0..10).for_each(|_| whole.step(2e-3));
        let (carried, point): (Carried, Point) = (whole.stepper.save(), whole.from.clone());
        let mut second = Walk::from_point(&case, &scene, point);
        second.stepper.restore(&carried).expect("it fits");
        for step in 0..10 {
            whole.step(2e-3);
            second.step(2e-3);
            assert!(whole.bits() == second.bits(), "{}: step {step} after the restart differs", case.name());
        }
    }
}

/// Vectors of another scene or scheme are refused, not taken over.
#[test]
fn a_foreign_saved_state_is_refused() {
    let scene = sheet();
    for case in cases() {
        let mut walk = Walk::start(&case, &scene);
        let mut carried = walk.stepper.save();
        carried.vectors.push(vec![1.0; 3]);
        assert!(walk.stepper.restore(&carried).is_err(), "{} took a vector too many", case.name());
        let mut carried = walk.stepper.save();
        if let Some(first) = carried.vectors.first_mut() {
            first.pop();
            assert!(walk.stepper.restore(&carried).is_err(), "{} took a vector that is too short", case.name());
        }
    }
}

/// Rejecting a step is not accepting it: attempts that are dropped leave no trace in what follows.
#[test]
fn a_dropped_attempt_leaves_no_trace() {
    let scene = sheet();
    for case in cases() {
        let (mut plain, mut hesitant) = (Walk::start(&case, &scene), Walk::start(&case, &scene));
        for step in 0..12 {
            hesitant.attempt(7e-3);
            hesitant.attempt(5e-4);
            plain.step(2e-3);
            hesitant.step(2e-3);
            assert!(plain.bits() == hesitant.bits(), "{}: step {step} differs", case.name());
        }
    }
}
