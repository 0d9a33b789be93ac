//! The adjoint run: derivatives of some numbers with respect to everything at once, from step to step backwards.

use super::columns::combine;
use super::difference::{PLACES, RELATIVE, derivative};
use super::error::SensitivityError;
use super::linearisation::Linearisation;
use super::record::StepRecord;
use crate::integrate::form::Row;
use crate::model::state::StateRef;
use crate::model::system::Weights;
use crate::scene::{Adjoint, Scene, pass_events};

/// [-] Relative change of a solution below which it is found, where the air that a canopy takes along is in it.
const SETTLED: f64 = 1e-13;
/// Solves after which the last one is taken.
const MOST: usize = 40;
const STIFFNESS: Weights = Weights { m: 0.0, c: 0.0, k: 1.0 };
const DAMPING: Weights = Weights { m: 0.0, c: 1.0, k: 0.0 };

/// Derivatives of a number with respect to what single springs and nodes have. Springs are in the order of
/// [`Adjoint::springs`], degrees of freedom in the scene's.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ElementSlopes {
    /// by shares of the stiffness of each spring, k d/dk `[n_springs]`; its dashpot stays
    pub stiffness: Vec<f64>,
    /// by shares of the rest length of each spring, l0 d/dl0 `[n_springs]`; its stiffness and its dashpot stay
    pub rest_length: Vec<f64>,
    /// by the mass at each degree of freedom `[n_dof]`, with its weight: a node has the sum of its three
    pub mass: Vec<f64>,
    /// by a constant force on each degree of freedom `[n_dof]`
    pub force: Vec<f64>,
}

/// Which of them are found; those by forces always are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ElementKinds {
    /// by stiffness
    pub stiffness: bool,
    /// by rest length
    pub rest_length: bool,
    /// by mass
    pub mass: bool,
}

/// The derivatives of a number with respect to a state, and to the forces and tensions there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Seed {
    /// by positions `[n_dof]`
    pub x: Vec<f64>,
    /// by velocities `[n_dof]`
    pub v: Vec<f64>,
    /// by the velocities at which forces were found, which lag in some schemes `[n_dof]`
    pub force_v: Vec<f64>,
    /// by forces, of held degrees of freedom too `[n_dof]`
    pub force: Vec<f64>,
    /// by the tensions of springs: number and derivative
    pub tensions: Vec<(usize, f64)>,
    /// whether those by forces are of accelerations, by which masses count once more
    pub inertia: bool,
}

impl Seed {
    /// A number that depends on nothing.
    pub fn zero(n_dof: usize) -> Self {
        let zero = || vec![0.0; n_dof];
        Seed { x: zero(), v: zero(), force_v: zero(), force: zero(), tensions: Vec::new(), inertia: false }
    }
}

/// A number of which derivatives are found.
struct Target {
    /// by the vectors at the end of the step that comes next, going backwards
    later: Vec<Vec<f64>>,
    /// by the velocities at which forces were found there
    force_v: Vec<f64>,
    slopes: ElementSlopes,
}

/// What springs do at a state.
struct SpringsThere {
    /// [-] from the first end to the second, per spring
    directions: Vec<[f64; 3]>,
    /// [N] k dT/dk and l0 dT/dl0 per spring; empty where it is not asked for
    slopes: [Vec<f64>; 2],
}

/// The adjoint run of some numbers.
pub struct AdjointRun<'a> {
    scene: &'a dyn Scene,
    adjoint: &'a dyn Adjoint,
    kinds: ElementKinds,
    linear: Linearisation,
    /// events that are passed where its matrices were set up
    passed: usize,
    ends: Vec<[u32; 2]>,
    targets: Vec<Target>,
}

fn add(to: &mut [f64], share: f64, of: &[f64]) {
    to.iter_mut().zip(of).for_each(|(to, of)| *to += share * of);
}

/// Adds shares of a vector to columns, as a row has them.
fn spread(row: &Row, of: &[f64], columns: &mut [Vec<f64>]) {
    for (share, column) in row.iter().zip(columns).filter(|(share, _)| **share != 0.0) {
        add(column, *share, of);
    }
}

impl<'a> AdjointRun<'a> {
    /// At the end of a run, of which `passed` events are passed. The scene stands there too.
    ///
    /// # Errors
    /// A matrix that cannot be set up.
    pub fn new(
        (scene, adjoint): (&'a dyn Scene, &'a dyn Adjoint),
        (numbers, kinds): (usize, ElementKinds),
        passed: usize,
    ) -> Result<Self, SensitivityError> {
        let (n, springs) = (scene.n_dof(), adjoint.springs().len());
        let per_spring = |asked: bool| vec![0.0; if asked { springs } else { 0 }];
        let target = |_| Target {
            later: Vec::new(),
            force_v: vec![0.0; n],
            slopes: ElementSlopes {
                stiffness: per_spring(kinds.stiffness),
                rest_length: per_spring(kinds.rest_length),
                mass: vec![0.0; if kinds.mass { n } else { 0 }],
                force: vec![0.0; n],
            },
        };
        Ok(AdjointRun {
            scene,
            adjoint,
            kinds,
            linear: Linearisation::new(scene, true)?,
            passed,
            ends: adjoint.spring_ends(),
            targets: (0..numbers).map(target).collect(),
        })
    }

    /// Adds a share of the derivatives of a number at the state where the run stands. `force_v` [m/s] are the
    /// velocities at which the forces there were found.
    pub fn add(&mut self, number: usize, share: f64, seed: &Seed, (at, force_v): (StateRef<'_>, &[f64])) {
        let n = self.scene.n_dof();
        let forces = StateRef { v: force_v, ..at };
        let loaded = seed.force.iter().any(|value| *value != 0.0);
        let springs = (loaded || !seed.tensions.is_empty()).then(|| self.springs(if loaded { forces } else { at }));
        let mut product = vec![0.0; n];
        let Some(target) = self.targets.get_mut(number) else { return };
        target.later.resize_with(target.later.len().max(2), || vec![0.0; n]);
        add(&mut target.later[0], share, &seed.x);
        add(&mut target.later[1], share, &seed.v);
        add(&mut target.force_v, share, &seed.force_v);
        if loaded {
            self.adjoint.tangent_transposed_times(forces, STIFFNESS, &seed.force, &mut product);
            add(&mut target.later[0], -share, &product);
            self.adjoint.tangent_transposed_times(forces, DAMPING, &seed.force, &mut product);
            add(&mut target.force_v, -share, &product);
        }
        let Some(springs) = springs else { return };
        let ElementSlopes { stiffness, rest_length, .. } = &mut target.slopes;
        for (slopes, of) in [stiffness, rest_length].into_iter().zip(&springs.slopes).filter(|(_, of)| !of.is_empty()) {
            seed.tensions.iter().for_each(|&(spring, by)| slopes[spring] += share * by * of[spring]);
        }
        if loaded {
            let scaled: Vec<f64> = seed.force.iter().map(|p| share * p).collect();
            let mut a = vec![0.0; n];
            if seed.inertia {
                let mut found = self.scene.new_forces();
                self.scene.evaluate(forces, &mut found);
                let accelerations = found.total.iter().zip(self.scene.inverse_mass());
                a.iter_mut().zip(accelerations).for_each(|(a, (f, m))| *a = f * m);
            }
            self.push(number, (forces, &a), &scaled, Some(&springs));
        }
    }

    /// Puts the scene where the steps before an event were made, or back there after it made others.
    ///
    /// # Errors
    /// A matrix that cannot be set up.
    pub fn enter(&mut self, record: &StepRecord) -> Result<(), SensitivityError> {
        pass_events(self.scene, record.passed);
        if record.passed != self.passed {
            self.passed = record.passed;
            let before = self.linear.factorizations;
            self.linear = Linearisation::new(self.scene, true)?;
            self.linear.factorizations = before;
        }
        Ok(())
    }

    /// Goes back over a step, whose scene was [entered](AdjointRun::enter).
    ///
    /// # Errors
    /// A matrix that cannot be solved with, or derivatives that are not finite.
    pub fn back(&mut self, record: &StepRecord) -> Result<(), SensitivityError> {
        if self.targets.iter().all(|target| target.later.is_empty()) {
            return Ok(());
        }
        let StepRecord { form, columns, times, .. } = record;
        let n = self.scene.n_dof();
        let mut sides: Vec<Vec<Vec<f64>>> = Vec::with_capacity(self.targets.len());
        for target in &mut self.targets {
            let mut own = vec![vec![0.0; n]; columns.len()];
            form.next.iter().zip(&target.later).for_each(|(row, later)| spread(row, later, &mut own));
            match form.stages.last().filter(|_| record.lags) {
                Some(stage) => spread(&stage.v, &target.force_v, &mut own),
                None => spread(&form.next[1], &target.force_v, &mut own),
            }
            target.force_v.fill(0.0);
            sides.push(own);
        }
        for (number, &t) in times.iter().enumerate().rev() {
            self.stage(record, (number, t), &mut sides)?;
        }
        for (target, own) in self.targets.iter_mut().zip(sides) {
            target.later = own;
            target.later.truncate(form.carried());
            if !target.later.iter().flatten().all(|value| value.is_finite()) {
                let parameter = "single springs and nodes".to_owned();
                return Err(SensitivityError::NotFinite { parameter, t: record.t });
            }
        }
        Ok(())
    }

    /// Goes back over a stage: from the derivatives by its acceleration to those by all that it was made of.
    fn stage(
        &mut self,
        StepRecord { form, columns, .. }: &StepRecord,
        (number, t): (usize, f64),
        sides: &mut [Vec<Vec<f64>>],
    ) -> Result<(), SensitivityError> {
        let (stage, own, at) = (&form.stages[number], form.own(number), form.carried() + number);
        let n = self.scene.n_dof();
        let (mut x, mut v) = (vec![0.0; n], vec![0.0; n]);
        combine(&stage.x, columns, &mut x);
        combine(&stage.v, columns, &mut v);
        let there = StateRef { t, x: &x, v: &v };
        let failed = |source| SensitivityError::Linear { t, source };
        self.linear.set_whole(self.scene, there, own).map_err(failed)?;
        let springs = self.springs(there);
        let (mut by_x, mut by_v) = (vec![0.0; n], vec![0.0; n]);
        for (target, side) in sides.iter_mut().enumerate() {
            let p = self.solve((there, &columns[at]), own, &side[at]).map_err(failed)?;
            self.back_through_forces((there, &columns[at]), &p, [&mut by_x, &mut by_v]);
            let earlier = &mut side[..at];
            spread(&stage.x, &by_x, earlier);
            spread(&stage.v, &by_v, earlier);
            self.push(target, (there, &columns[at]), &p, Some(&springs));
        }
        Ok(())
    }

    /// p = W^-T of the derivatives by an acceleration, 0 where degrees of freedom are held.
    fn solve(
        &mut self,
        (at, a): (StateRef<'_>, &[f64]),
        [alpha, beta]: [f64; 2],
        by_acceleration: &[f64],
    ) -> Result<Vec<f64>, crate::solve::LinearError> {
        let (n, free) = (self.scene.n_dof(), self.linear.n());
        let mut side = vec![0.0; free];
        self.linear.pick(by_acceleration, &mut side);
        let coupled = self.scene.mass_parts() > 0 && (alpha != 0.0 || beta != 0.0);
        let (mut p, mut last) = (vec![0.0; n], Vec::new());
        let [mut by_x, mut by_v, mut all] = [(); 3].map(|()| vec![0.0; n]);
        let mut picked = vec![0.0; free];
        for _ in 0..MOST {
            let mut next = side.clone();
            if coupled {
                self.adjoint.apparent_transposed_times(at, a, &p, [&mut by_x, &mut by_v]);
                for ((all, x), v) in all.iter_mut().zip(&by_x).zip(&by_v) {
                    *all = alpha * x + beta * v;
                }
                self.linear.pick(&all, &mut picked);
                add(&mut next, -1.0, &picked);
            }
            self.linear.solve(&mut next)?;
            self.linear.put(&next, &mut p);
            let largest = next.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
            let change = next.iter().zip(&last).fold(0.0, |most: f64, (a, b): (&f64, &f64)| most.max((a - b).abs()));
            if !coupled || last.len() == next.len() && change <= SETTLED * largest {
                break;
            }
            last = next;
        }
        Ok(p)
    }

    /// -K^T p and -C^T p, with the forces of the air that canopies take along at accelerations `a`.
    fn back_through_forces(&self, (at, a): (StateRef<'_>, &[f64]), p: &[f64], [by_x, by_v]: [&mut [f64]; 2]) {
        let n = self.scene.n_dof();
        let (mut x, mut v) = (vec![0.0; n], vec![0.0; n]);
        if self.scene.mass_parts() > 0 {
            self.adjoint.apparent_transposed_times(at, a, p, [&mut x, &mut v]);
        }
        self.adjoint.tangent_transposed_times(at, STIFFNESS, p, by_x);
        match self.scene.velocity_dependent() {
            true => self.adjoint.tangent_transposed_times(at, DAMPING, p, by_v),
            false => by_v.fill(0.0),
        }
        by_x.iter_mut().zip(&x).for_each(|(by, x)| *by = -*by - x);
        by_v.iter_mut().zip(&v).for_each(|(by, v)| *by = -*by - v);
    }

    /// Adds the derivatives of p . (f - M a) by what springs and nodes have.
    fn push(&mut self, number: usize, (at, a): (StateRef<'_>, &[f64]), p: &[f64], springs: Option<&SpringsThere>) {
        let AdjointRun { adjoint, kinds, ends, targets, .. } = self;
        let Some(Target { slopes, .. }) = targets.get_mut(number) else { return };
        add(&mut slopes.force, 1.0, p);
        if kinds.mass {
            let mut per_mass = vec![0.0; p.len()];
            adjoint.force_per_mass(at, &mut per_mass);
            for (((slope, p), q), a) in slopes.mass.iter_mut().zip(p).zip(&per_mass).zip(a) {
                *slope += p * (q - a);
            }
        }
        let Some(SpringsThere { directions, slopes: by }) = springs else { return };
        for (slopes, by) in [&mut slopes.stiffness, &mut slopes.rest_length].into_iter().zip(by) {
            for (((slope, by), ends), n) in slopes.iter_mut().zip(by).zip(&*ends).zip(directions) {
                let [a, b] = ends.map(|dof| &p[dof as usize..dof as usize + 3]);
                let along: f64 = (0..3).map(|axis| (a[axis] - b[axis]) * n[axis]).sum();
                *slope += along * by;
            }
        }
    }

    /// What springs do at a state, as far as it is asked for.
    fn springs(&self, at: StateRef<'_>) -> SpringsThere {
        let ElementKinds { stiffness, rest_length, .. } = self.kinds;
        let asked = |asked: bool, which: usize| if asked { self.tension_slopes(at, which) } else { Vec::new() };
        let slopes = [asked(stiffness, 0), asked(rest_length, 1)];
        let direction = |&[a, b]: &[u32; 2]| {
            let d: [f64; 3] = std::array::from_fn(|axis| at.x[b as usize + axis] - at.x[a as usize + axis]);
            let length = d.iter().map(|d| d * d).sum::<f64>().sqrt();
            d.map(|d| if length > 0.0 { d / length } else { 0.0 })
        };
        let directions = if stiffness || rest_length { self.ends.iter().map(direction).collect() } else { Vec::new() };
        SpringsThere { directions, slopes }
    }

    /// The derivatives of all tensions by shares of the stiffness of each spring (0) or of its rest length (1) \[N\].
    fn tension_slopes(&self, at: StateRef<'_>, which: usize) -> Vec<f64> {
        let values = PLACES.map(|place| {
            let mut factors = [1.0; 2];
            factors[which] += place * RELATIVE;
            let mut tensions = vec![0.0; self.ends.len()];
            self.adjoint.scaled_tensions(at, factors, &mut tensions);
            tensions
        });
        (0..self.ends.len()).map(|spring| derivative(values.each_ref().map(|of| of[spring]), RELATIVE)).collect()
    }

    /// The derivatives of a number, and those by the positions and velocities at the start of the run `[n_dof]`.
    pub fn found(&self, number: usize) -> Option<(&ElementSlopes, [&[f64]; 2])> {
        let target = self.targets.get(number)?;
        let [x, v, ..] = target.later.as_slice() else { return None };
        Some((&target.slopes, [x, v]))
    }

    /// Factorisations so far.
    pub fn factorizations(&self) -> u64 {
        self.linear.factorizations
    }
}
