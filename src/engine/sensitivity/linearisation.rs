//! The tangents of a stage: M, K and C at its state, and W = M + alpha K + beta C with its factor.

use crate::assembly::{Assembler, PatternError};
use crate::model::state::StateRef;
use crate::model::system::Weights;
use crate::model::workers::ALONE;
use crate::scene::Scene;
use crate::solve::{LinearChoice, LinearError, LinearSolver, solver_for};

/// C, K or W: its entries on the pattern, and its parts u g^T beside them.
#[derive(Clone, Debug, Default)]
struct Matrix {
    values: Vec<f64>,
    parts: Vec<[Vec<f64>; 2]>,
}

/// A part of W with z = W^-1 u, where W has the parts before, and 1 + g . z.
struct SolvedPart {
    g: Vec<f64>,
    z: Vec<f64>,
    divisor: f64,
}

/// Solves with a factor of an earlier W after which a new one is made.
const MOST: usize = 12;
/// [-] Share of a solution below which a correction ends the repetition.
const SOLVED: f64 = 1e-13;
/// [-] Share of the correction before that a correction must fall below.
const FALLING: f64 = 0.3;

/// The tangents of a stage, over the free degrees of freedom.
pub(super) struct Linearisation {
    assembler: Assembler,
    /// [kg] of every unknown
    masses: Vec<f64>,
    /// parts of the mass beside these
    mass_parts: Vec<[Vec<f64>; 2]>,
    damping: Matrix,
    stiffness: Matrix,
    /// W; its parts alone, where it is M and its parts
    whole: Matrix,
    /// whether W^T is solved with. The factor of an earlier W is then kept as long as it serves: there are as many
    /// solves as quantities, which are few, and each of them takes several with such a factor
    transposed: bool,
    /// the parts of the W that is factorised
    parts: Vec<SolvedPart>,
    solver: Option<Box<dyn LinearSolver>>,
    /// values of the W that is factorised; empty before
    factored: Vec<f64>,
    /// whether that is the W of this stage
    exact: bool,
    /// whether W is more than M and its parts
    implicit: bool,
    /// factorisations so far
    pub(super) factorizations: u64,
    dofs: [Vec<f64>; 2],
}

const MASS: Weights = Weights { m: 1.0, c: 0.0, k: 0.0 };
const DAMPING: Weights = Weights { m: 0.0, c: 1.0, k: 0.0 };
const STIFFNESS: Weights = Weights { m: 0.0, c: 0.0, k: 1.0 };

impl Linearisation {
    /// For a scene between two events; W^T is solved with if `transposed`.
    pub(super) fn new(scene: &dyn Scene, transposed: bool) -> Result<Self, PatternError> {
        let n = scene.n_dof();
        let assembler = scene.assembler()?;
        let mut all = vec![0.0; n];
        scene.mass_times(&vec![1.0; n], &mut all);
        Ok(Linearisation {
            masses: assembler.pattern.dof.iter().map(|&dof| all[dof as usize]).collect(),
            assembler,
            mass_parts: Vec::new(),
            damping: Matrix::default(),
            stiffness: Matrix::default(),
            whole: Matrix::default(),
            transposed,
            parts: Vec::new(),
            solver: None,
            factored: Vec::new(),
            exact: false,
            implicit: false,
            factorizations: 0,
            dofs: [(); 2].map(|()| vec![0.0; n]),
        })
    }

    /// Number of free degrees of freedom.
    pub(super) fn n(&self) -> usize {
        self.assembler.pattern.n()
    }

    /// Picks the free degrees of freedom of a vector.
    pub(super) fn pick(&self, all: &[f64], own: &mut [f64]) {
        own.iter_mut().zip(&self.assembler.pattern.dof).for_each(|(own, &dof)| *own = all[dof as usize]);
    }

    /// Puts them back; others stay.
    pub(super) fn put(&self, own: &[f64], all: &mut [f64]) {
        own.iter().zip(&self.assembler.pattern.dof).for_each(|(own, &dof)| all[dof as usize] = *own);
    }

    /// Finds the tangents at a state, and W with the shares alpha [s^2] and beta [s] of the stage's acceleration in its
    /// state.
    pub(super) fn set(&mut self, scene: &dyn Scene, at: StateRef<'_>, own: [f64; 2]) -> Result<(), LinearError> {
        let mut damping = std::mem::take(&mut self.damping);
        let mut stiffness = std::mem::take(&mut self.stiffness);
        if scene.velocity_dependent() {
            self.find(scene, at, DAMPING, &mut damping);
        }
        self.find(scene, at, STIFFNESS, &mut stiffness);
        (self.damping, self.stiffness) = (damping, stiffness);
        self.mass_parts = self.parts_of(scene, at, MASS, scene.mass_parts());
        self.set_whole(scene, at, own)
    }

    /// Finds W alone.
    pub(super) fn set_whole(
        &mut self,
        scene: &dyn Scene,
        at: StateRef<'_>,
        [alpha, beta]: [f64; 2],
    ) -> Result<(), LinearError> {
        self.implicit = alpha != 0.0 || beta != 0.0;
        let mut whole = std::mem::take(&mut self.whole);
        match self.implicit {
            true => self.find(scene, at, Weights { m: 1.0, c: beta, k: alpha }, &mut whole),
            false => whole.parts = self.parts_of(scene, at, MASS, scene.mass_parts()),
        }
        self.whole = whole;
        if self.implicit && self.solver.is_none() {
            let pattern = self.assembler.pattern.clone();
            self.solver = Some(solver_for(pattern, LinearChoice::Auto, scene.workers())?);
        }
        let keeps = self.transposed && self.implicit && !self.factored.is_empty();
        self.exact = false;
        if keeps { Ok(()) } else { self.factor() }
    }

    /// Factorises W, and solves with its parts.
    fn factor(&mut self) -> Result<(), LinearError> {
        match &mut self.solver {
            Some(solver) if self.implicit => {
                solver.factor(&self.whole.values)?;
                self.factorizations += 1;
                self.factored.clone_from(&self.whole.values);
            }
            // The parts below are then those of M.
            _ if !self.whole.parts.is_empty() => self.factored.clear(),
            _ => {}
        }
        self.exact = true;
        self.parts.clear();
        for [u, g] in self.whole.parts.clone() {
            let [mut z, g] = if self.transposed { [g, u] } else { [u, g] };
            self.solve_with_factor(&mut z)?;
            let divisor = 1.0 + ALONE.dot(&g, &z);
            if divisor == 0.0 || !divisor.is_finite() {
                return Err(LinearError::Singular { unknown: None });
            }
            self.parts.push(SolvedPart { g, z, divisor });
        }
        Ok(())
    }

    fn find(&mut self, scene: &dyn Scene, at: StateRef<'_>, weights: Weights, to: &mut Matrix) {
        scene.assemble(at, weights, &mut self.assembler);
        to.values.clear();
        to.values.extend_from_slice(self.assembler.values());
        to.parts = self.parts_of(scene, at, weights, scene.rank_ones());
    }

    /// The first of the parts u g^T with some weights, without those that are 0.
    fn parts_of(&mut self, scene: &dyn Scene, at: StateRef<'_>, weights: Weights, count: usize) -> Vec<[Vec<f64>; 2]> {
        let [u, g] = &mut self.dofs;
        let mut parts = Vec::new();
        for which in 0..count {
            scene.rank_one(which, at, weights, u, g);
            let dofs = &self.assembler.pattern.dof;
            let picked = [&*u, &*g].map(|all| dofs.iter().map(|&dof| all[dof as usize]).collect::<Vec<f64>>());
            if picked.iter().all(|part| part.iter().any(|value| *value != 0.0)) {
                parts.push(picked);
            }
        }
        parts
    }

    /// out = K x + C v, all `[n]`.
    pub(super) fn forces(&self, x: &[f64], v: &[f64], out: &mut [f64]) {
        self.times(&self.stiffness, x, out);
        if self.damping.values.is_empty() {
            return;
        }
        let mut other = vec![0.0; out.len()];
        self.times(&self.damping, v, &mut other);
        out.iter_mut().zip(&other).for_each(|(out, other)| *out += other);
    }

    /// out = M y.
    pub(super) fn mass_times(&self, y: &[f64], out: &mut [f64]) {
        out.iter_mut().zip(y).zip(&self.masses).for_each(|((out, y), mass)| *out = mass * y);
        add_parts(&self.mass_parts, y, out);
    }

    fn times(&self, Matrix { values, parts }: &Matrix, y: &[f64], out: &mut [f64]) {
        self.assembler.pattern.multiply(values, y, out);
        add_parts(parts, y, out);
    }

    /// out = W y, or W^T y.
    fn whole_times(&self, y: &[f64], out: &mut [f64]) {
        if !self.transposed {
            return self.times(&self.whole, y, out);
        }
        self.assembler.pattern.multiply_transposed(&self.whole.values, y, out);
        for [u, g] in &self.whole.parts {
            ALONE.add(out, ALONE.dot(u, y), g);
        }
    }

    /// Replaces b `[n]` by W^-1 b, or W^-T b; with the factor of an earlier W as long as repetition gains digits fast.
    pub(super) fn solve(&mut self, b: &mut [f64]) -> Result<(), LinearError> {
        if !self.exact {
            let mut x = b.to_vec();
            self.solve_with_factor(&mut x)?;
            if self.refine(b, &mut x)? {
                b.copy_from_slice(&x);
                return Ok(());
            }
            self.factor()?;
        }
        self.solve_with_factor(b)
    }

    /// Corrects x until W x = b. Returns whether it came to that.
    fn refine(&mut self, b: &[f64], x: &mut [f64]) -> Result<bool, LinearError> {
        let largest = |of: &[f64]| of.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        let (mut residual, mut before) = (vec![0.0; b.len()], f64::INFINITY);
        for _ in 0..MOST {
            self.whole_times(x, &mut residual);
            residual.iter_mut().zip(b).for_each(|(r, b)| *r = b - *r);
            self.solve_with_factor(&mut residual)?;
            x.iter_mut().zip(&residual).for_each(|(x, d)| *x += d);
            let (correction, size) = (largest(&residual), largest(x));
            if correction <= SOLVED * size {
                return Ok(true);
            }
            if correction.is_nan() || correction >= FALLING * before {
                return Ok(false);
            }
            before = correction;
        }
        Ok(false)
    }

    /// Solves with the W that is factorised.
    fn solve_with_factor(&mut self, b: &mut [f64]) -> Result<(), LinearError> {
        self.solve_entries(b)?;
        for SolvedPart { g, z, divisor } in &self.parts {
            ALONE.add(b, -ALONE.dot(g, b) / divisor, z);
        }
        Ok(())
    }

    /// The same for its entries on the pattern alone.
    fn solve_entries(&mut self, b: &mut [f64]) -> Result<(), LinearError> {
        match (&mut self.solver, self.implicit) {
            (Some(solver), true) if self.transposed => solver.solve_transposed(&self.factored, b),
            (Some(solver), true) => solver.solve(&self.factored, b),
            _ => {
                b.iter_mut().zip(&self.masses).for_each(|(b, mass)| *b /= mass);
                Ok(())
            }
        }
    }
}

/// out += the sum of u (g . y).
fn add_parts(parts: &[[Vec<f64>; 2]], y: &[f64], out: &mut [f64]) {
    for [u, g] in parts {
        ALONE.add(out, ALONE.dot(g, y), u);
    }
}
