//! One real step of a scheme on the linearised scene, as a linear map of x, v and what the scheme carries, and whether
//! it grows.
//!
//! For partitioned schemes with damping that couples modes, the map is no function of the scene's eigenvalues alone. It
//! is stepped instead, and Arnoldi's iteration estimates its outer eigenvalues.

use super::arnoldi::{Krylov, most_moving_dof};
use super::modes::ModeShape;
use super::operators::{Linearised, Matrices};
use super::vectors::norm;
use crate::assembly::{Assembler, PatternError, SceneInterfaces, TangentSystem};
use crate::force::TangentForm;
use crate::integrate::implicit::SolverSpec;
use crate::integrate::registry::MethodChoice;
use crate::integrate::stepper::{Attempt, Stepper};
use crate::integrate::{CarriedState, Counters, StepError};
use crate::mesh::random::pseudo_random;
use crate::model::at_dof::AtDof;
use crate::model::forces::{Forces, Role, Tally};
use crate::model::point::Point;
use crate::model::state::{State, StateRef};
use crate::model::stop::Stop;
use crate::model::system::{StepMean, System, TermInfo, Weights};
use faer::c64;
use std::sync::Arc;

/// K x and C v together.
static TERMS: [TermInfo; 1] = [TermInfo { velocity_dependent: true, ..TermInfo::of("tangent", Role::Elastic) }];

/// Ritz values with a larger relative residual have not converged.
const CONVERGED: f64 = 0.005;
/// The same as a share of the distance beyond the unit circle: parts of other modes in the vector must not hide its
/// own.
const CLOSE: f64 = 0.2;
/// Products after which growth is looked for. Growing modes are well separated, so they show soon.
const PRODUCTS: [usize; 4] = [20, 40, 70, 120];
/// Products without a value beyond the unit circle that has not converged, after which a step is stable.
const ENOUGH: usize = 40;
/// Differences of steps that an iteration starts with.
const DIFFERENCES: usize = 2;
/// Growth per step that counts as none.
const GROWTH: f64 = 1e-3;
/// Steps made to test for growth, by comparing the last quarter with the second.
const STEPPED: usize = 200;
/// Growth since the first of these steps that needs no further ones: motion that does not grow for good, from nearly
/// parallel eigenvectors, never comes near it.
const BEYOND_DOUBT: f64 = 1e6;
/// Relative width at which the bisection for the limit ends.
const WIDTH: f64 = 0.01;
/// Steps of the outward search from a guess, and the first factor of a step.
const OUTWARDS: usize = 20;
const FIRST: f64 = 0.992;

/// Search for a limit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Search<'a> {
    /// [s]
    pub guess: f64,
    /// [1/s] scale of positions relative to velocities
    pub unit: f64,
    pub stop: Stop<'a>,
}

/// M a = -K x - C v.
pub(super) struct LinearScene {
    matrices: Arc<Matrices>,
    assembler: Assembler,
    inverse_mass: Vec<f64>,
    root: Vec<f64>,
    damped: bool,
}

impl LinearScene {
    /// `None` if the scene has no assembled matrices.
    pub(super) fn of(linear: &Linearised<'_>) -> Option<Self> {
        Some(LinearScene {
            matrices: Arc::clone(linear.matrices.as_ref()?),
            assembler: linear.scene.assembler().ok()?,
            inverse_mass: linear.scene.inverse_mass().to_vec(),
            root: linear.root.clone(),
            damped: linear.scene.velocity_dependent(),
        })
    }

    /// [s] The largest step whose map grows only in modes that grow in the scene, and the degree of freedom that moves
    /// most just beyond it.
    pub(super) fn limit(&self, method: &MethodChoice, search: Search<'_>) -> Option<AtDof> {
        let guess = search.guess;
        let grows = |h: f64| self.grows(method, h, search);
        let (mut stable, mut unstable) = (0.0, guess);
        let mut culprit = grows(unstable)?;
        // Search outwards from the guess for a bracket of a stable and a growing step.
        let mut factor = FIRST;
        for _ in 0..OUTWARDS {
            if culprit.is_some() {
                match grows(factor * unstable)? {
                    Some(dof) => (unstable, culprit) = (factor * unstable, Some(dof)),
                    None => {
                        stable = factor * unstable;
                        break;
                    }
                }
            } else {
                (stable, unstable) = (unstable, unstable / factor);
                culprit = grows(unstable)?;
                if culprit.is_some() {
                    break;
                }
            }
            factor *= 0.9;
        }
        let mut dof = culprit.filter(|_| stable > 0.0)?;
        while unstable - stable > WIDTH * unstable {
            let middle = 0.5 * (stable + unstable);
            match grows(middle)? {
                Some(at) => (unstable, dof) = (middle, at),
                None => stable = middle,
            }
        }
        Some(AtDof { value: stable, dof })
    }

    /// The degree of freedom that moves most in a mode beyond the unit circle that does not grow in the scene;
    /// `Some(None)` if there is none.
    fn grows(&self, method: &MethodChoice, h: f64, search: Search<'_>) -> Option<Option<usize>> {
        let unit = search.unit;
        let size = |z: &c64| z.norm();
        let mut step = self.step_map(method, h, search.unit)?;
        let mut krylov = Krylov::from(step.start());
        for products in PRODUCTS {
            krylov.extend(products, search.stop, |q, y| step.apply(q, y))?;
            let mut beyond: Vec<c64> = krylov.values.iter().filter(|z| size(z) > 1.0 + GROWTH).copied().collect();
            beyond.sort_by(|a, b| size(b).total_cmp(&size(a)));
            let mut settled = true;
            for z in beyond {
                let ritz = krylov.ritz(z);
                let vector = krylov.vector(&ritz);
                let close = ritz.residual <= (CONVERGED * size(&z)).min(CLOSE * (size(&z) - 1.0));
                let own = || ModeShape::of(&vector, &self.matrices, &self.root, unit).grows_by_itself([z.re, z.im], h);
                if close && own() {
                    continue;
                }
                if close && self.grows_when_stepped(method, h, search, &vector[0])? {
                    return Some(Some(most_moving_dof(&vector, &self.root)));
                }
                settled = false;
            }
            if settled && products >= ENOUGH {
                break;
            }
        }
        Some(None)
    }

    /// Whether repeated steps from a Ritz vector grow, as a small residual proves nothing if eigenvectors are nearly
    /// parallel. Second differences from step to step remove drift, as of a net without stiffness across itself.
    fn grows_when_stepped(&self, method: &MethodChoice, h: f64, search: Search<'_>, from: &[f64]) -> Option<bool> {
        let mut step = self.step_map(method, h, search.unit)?;
        let mut q = [from.to_vec(), vec![], vec![]];
        let n = q[0].len();
        (q[1], q[2]) = (vec![0.0; n], vec![0.0; n]);
        let [before, now, after] = &mut q;
        step.apply(before, now);
        let (mut largest, mut first) = ([0.0_f64; 4], 0.0);
        for k in 0..STEPPED {
            if search.stop.asked() {
                return None;
            }
            step.apply(now, after);
            let squares = before.iter().zip(&*now).zip(&*after).map(|((a, b), c)| (a - 2.0 * b + c).powi(2));
            let size = squares.sum::<f64>().sqrt();
            if k == 0 {
                first = size;
            }
            if !size.is_finite() || size > BEYOND_DOUBT * first {
                return Some(true);
            }
            let quarter = &mut largest[4 * k / STEPPED];
            *quarter = quarter.max(size);
            std::mem::swap(before, now);
            std::mem::swap(now, after);
        }
        let steps = 0.5 * STEPPED as f64;
        Some(largest[3] > largest[1] * (1.0 + 0.5 * GROWTH).powf(steps))
    }

    /// One step of the method as a linear map.
    fn step_map<'s>(&'s self, method: &MethodChoice, h: f64, unit: f64) -> Option<StepMap<'s>> {
        let interfaces = SceneInterfaces { system: self, tangent: self, graph: None };
        let mut stepper = Stepper::bind(method.scheme(SolverSpec::default()), interfaces).ok()?;
        let from = Point { state: self.initial_state(), forces: self.new_forces() };
        stepper.start(&from).ok()?;
        let carried = CarriedState { made_with: h, ..stepper.save() };
        let lags = stepper.lags();
        let scales = vec![1.0; 2 + carried.vectors.len() + usize::from(lags)];
        let (to, inverse) = (from.clone(), self.root.iter().map(|&r| if r > 0.0 { 1.0 / r } else { 0.0 }).collect());
        let mut map = StepMap { scene: self, stepper, h, lags, from, to, carried, scales, inverse };
        map.scales[0] = 1.0 / unit;
        map.balance();
        Some(map)
    }
}

/// A step of `h` [s] as a linear map of x, v, what the scheme carries, and forces that lag behind the state,
/// `[vectors * n_dof]`, scaled: positions by a rate, all by the roots of the masses.
struct StepMap<'s> {
    scene: &'s LinearScene,
    stepper: Stepper<'s>,
    h: f64,
    lags: bool,
    from: Point,
    to: Point,
    carried: CarriedState,
    /// of each vector
    scales: Vec<f64>,
    /// 1 over the roots of the masses, 0 where held
    inverse: Vec<f64>,
}

impl StepMap<'_> {
    /// Start of an iteration: a difference of steps, which has little of the motions that hardly change in a step.
    /// Where nothing holds a net across itself there are many, nearly parallel, and Ritz values made of them stay
    /// beyond the unit circle for long.
    fn start(&mut self) -> Vec<f64> {
        let mut start = self.random();
        let mut next = vec![0.0; start.len()];
        for _ in 0..DIFFERENCES {
            self.apply(&start, &mut next);
            start.iter_mut().zip(&next).for_each(|(start, next)| *start = next - *start);
        }
        start
    }

    /// Pseudo-random positions and velocities of what is free; 0 for what the scheme carries.
    fn random(&self) -> Vec<f64> {
        let n = self.inverse.len();
        let at = |i: usize| if i < 2 * n && self.inverse[i % n] > 0.0 { pseudo_random(i) } else { 0.0 };
        (0..n * self.scales.len()).map(at).collect()
    }

    /// Scales what is carried, whose units are the scheme's own, to be as large after a step as the velocities are.
    fn balance(&mut self) {
        let (from, n) = (self.random(), self.inverse.len());
        let mut next = vec![0.0; from.len()];
        self.apply(&from, &mut next);
        let sizes: Vec<f64> = next.chunks(n.max(1)).map(norm).collect();
        for (scale, size) in self.scales.iter_mut().zip(&sizes).skip(2) {
            if *size > 0.0 && sizes[1] > 0.0 {
                *scale = size / sizes[1];
            }
        }
    }

    /// NaN if the step fails.
    fn apply(&mut self, q: &[f64], y: &mut [f64]) {
        if self.step(q).is_err() {
            y.fill(f64::NAN);
            return;
        }
        let Point { state: State { x, v, .. }, forces } = &self.to;
        let vectors = [x, v].into_iter().chain(&self.carried.vectors).chain(self.lags.then_some(&forces.total));
        for ((y, vector), scale) in y.chunks_mut(self.inverse.len().max(1)).zip(vectors).zip(&self.scales) {
            for ((y, value), inverse) in y.iter_mut().zip(vector).zip(&self.inverse) {
                *y = value * inverse / scale;
            }
        }
    }

    fn step(&mut self, q: &[f64]) -> Result<(), StepError> {
        let Point { state: State { x, v, .. }, forces } = &mut self.from;
        let vectors = [x, v].into_iter().chain(&mut self.carried.vectors).chain(self.lags.then_some(&mut forces.total));
        for ((q, vector), scale) in q.chunks(self.inverse.len().max(1)).zip(vectors).zip(&self.scales) {
            for ((q, value), root) in q.iter().zip(vector).zip(&self.scene.root) {
                *value = q * root * scale;
            }
        }
        if !self.lags {
            self.scene.evaluate(self.from.state.as_ref(), &mut self.from.forces);
        }
        self.stepper.restore(&self.carried)?;
        let attempt = Attempt { from: &self.from, h: self.h, t_next: self.h };
        self.stepper.attempt(attempt, &mut self.to, &mut Counters::default())?;
        self.stepper.accept();
        self.stepper.save_into(&mut self.carried);
        Ok(())
    }
}

impl System for LinearScene {
    fn n_dof(&self) -> usize {
        self.root.len()
    }

    fn initial_state(&self) -> State {
        State { t: 0.0, x: vec![0.0; self.n_dof()], v: vec![0.0; self.n_dof()] }
    }

    fn terms(&self) -> &[TermInfo] {
        &TERMS
    }

    fn new_forces(&self) -> Forces {
        Forces { total: vec![0.0; self.n_dof()], tallies: vec![Tally::default()], ..Forces::default() }
    }

    fn evaluate(&self, at: StateRef<'_>, out: &mut Forces) {
        self.matrices.times([-1.0, -1.0], [at.x, at.v], &mut out.total);
    }

    fn inverse_mass(&self) -> &[f64] {
        &self.inverse_mass
    }

    fn mass_times(&self, a: &[f64], out: &mut [f64]) {
        for ((out, a), inverse) in out.iter_mut().zip(a).zip(&self.inverse_mass) {
            *out = if *inverse > 0.0 { a / inverse } else { 0.0 };
        }
    }

    fn kinetic_energy(&self, v: &[f64]) -> f64 {
        let moving = v.iter().zip(&self.inverse_mass).filter(|(_, inverse)| **inverse > 0.0);
        moving.map(|(v, inverse)| 0.5 * v * v / inverse).sum()
    }

    fn velocity_dependent(&self) -> bool {
        self.damped
    }
}

impl TangentSystem for LinearScene {
    fn symmetric(&self) -> bool {
        self.assembler.pattern.symmetric
    }

    fn assembler(&self) -> Result<Assembler, PatternError> {
        Ok(self.assembler.clone())
    }

    fn assemble(&self, _at: StateRef<'_>, w: Weights, assembler: &mut Assembler) {
        let pattern = Arc::clone(&assembler.pattern);
        for (j, &column) in pattern.dof.iter().enumerate() {
            let values = assembler.values_mut().iter_mut().skip(pattern.col_ptr[j] as usize);
            for (&i, value) in pattern.column(j).iter().zip(values) {
                let row = pattern.dof[i as usize];
                let [k, c] = self.matrices.entry(row, column);
                let mass = if row == column { 1.0 / self.inverse_mass[row as usize] } else { 0.0 };
                *value = w.m * mass + w.c * c + w.k * k;
            }
        }
    }

    /// The whole of K counts as that of elastic forces.
    fn mean_forces(&self, middle: StateRef<'_>, mean: StepMean, out: &mut Forces) {
        let ahead = mean.dissipation * mean.half;
        let x: Vec<f64> = middle.x.iter().zip(middle.v).map(|(x, v)| x + ahead * v).collect();
        self.evaluate(StateRef { x: &x, ..middle }, out);
    }

    fn assemble_mean(
        &self,
        middle: StateRef<'_>,
        mean: StepMean,
        w: Weights,
        _: TangentForm,
        assembler: &mut Assembler,
    ) {
        self.assemble(middle, Weights { k: (1.0 + mean.dissipation) * w.k, ..w }, assembler);
    }

    fn nodal_stiffness(&self) -> Vec<f64> {
        vec![0.0; self.n_dof()]
    }

    fn force_scale(&self, forces: &Forces) -> f64 {
        norm(&forces.total)
    }
}
