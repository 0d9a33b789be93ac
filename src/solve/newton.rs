//! Newton's iteration for F(z) = 0 with a backtracking line search. Knows nothing of time or schemes.

use super::LinearError;

/// How often the tangent is factorised.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Strategy {
    /// Chooses from counted work; for now always [`Strategy::Full`].
    #[default]
    Auto,
    /// The exact tangent in every iteration.
    Full,
}

/// What the line search makes smaller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Merit {
    /// The Euclidean norm of the residual.
    #[default]
    ResidualNorm,
}

/// Settings of the iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonSpec {
    /// [-] tolerance on residual and increment, relative to their scales
    pub relative: f64,
    /// iterations after which a step is refused
    pub max_iterations: u32,
    /// how often the tangent is factorised
    pub strategy: Strategy,
    /// what the line search makes smaller
    pub merit: Merit,
}

impl Default for NewtonSpec {
    fn default() -> Self {
        NewtonSpec { relative: 1e-8, max_iterations: 20, strategy: Strategy::Auto, merit: Merit::ResidualNorm }
    }
}

/// Sizes that residuals and increments are compared with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scales {
    /// [N] size of the forces that the residual balances
    pub residual: f64,
    /// [m] size of the unknown
    pub increment: f64,
    /// [m] what rounding alone leaves of an increment
    pub increment_floor: f64,
}

/// F(z) = 0, its tangent and a solver for it.
pub trait NonlinearProblem {
    /// Writes the residual r = F(z) and, one by one, what rounding alone can leave of it.
    fn residual(&mut self, z: &[f64], r: &mut [f64], floor: &mut [f64]);

    /// Called after the residual at a first guess `z`: replaces a guess that went too far by a more cautious one and says
    /// so; `false` keeps it.
    fn retreat(&mut self, z: &mut [f64]) -> bool {
        let _ = z;
        false
    }

    /// Factorises the tangent dF/dz where the residual was last evaluated.
    ///
    /// # Errors
    /// A tangent that is not finite or singular.
    fn linearise(&mut self) -> Result<(), LinearError>;

    /// Replaces b by (dF/dz)^-1 b.
    ///
    /// # Errors
    /// A solution that is not finite.
    fn solve(&mut self, b: &mut [f64]) -> Result<(), LinearError>;
}

/// A converged iteration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NewtonReport {
    /// iterations (factorisations) made
    pub iterations: u32,
    /// [-] final residual over its scale
    pub residual: f64,
}

/// Why an iteration was given up.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
pub enum NewtonFailure {
    /// The tolerance was not reached in the allowed iterations.
    #[error(
        "Newton's iteration did not converge in {iterations} iterations: residual {residual:.3e} N against a tolerance of {tolerance:.3e} N"
    )]
    MaxIterations {
        /// iterations made
        iterations: u32,
        /// [N] last residual
        residual: f64,
        /// [N] what it had to reach
        tolerance: f64,
        /// unknown with the largest residual
        worst: usize,
    },
    /// The line search found no smaller residual along Newton's direction.
    #[error(
        "Newton's iteration {iterations} is stuck: no step along its direction lowers the residual {residual:.3e} N (tolerance {tolerance:.3e} N)"
    )]
    Stuck {
        /// iterations made
        iterations: u32,
        /// [N] last residual
        residual: f64,
        /// [N] what it had to reach
        tolerance: f64,
        /// unknown with the largest residual
        worst: usize,
    },
    /// The residual at the start is not a number.
    #[error("the residual is not finite at the start of the step")]
    NotFinite {
        /// an unknown whose residual is not finite
        worst: usize,
    },
    /// The tangent could not be factorised.
    #[error("iteration {iterations}: {error}")]
    Linear {
        /// iterations made
        iterations: u32,
        /// what was wrong
        error: LinearError,
        /// unknown with the largest residual
        worst: usize,
    },
}

impl NewtonFailure {
    /// The unknown to look at.
    pub fn worst(&self) -> usize {
        match self {
            NewtonFailure::MaxIterations { worst, .. }
            | NewtonFailure::Stuck { worst, .. }
            | NewtonFailure::NotFinite { worst }
            | NewtonFailure::Linear { worst, .. } => *worst,
        }
    }
}

/// Halvings after which a line search gives up: 2^-12 of Newton's step.
const MAX_HALVINGS: u32 = 12;
/// Share of the decrease promised by the tangent that a step must deliver (Armijo 1966).
const ARMIJO: f64 = 1e-4;
/// Share of Newton's step by which the correction at the end of it must be smaller.
const NATURAL: f64 = 0.25;

/// The iteration and its buffers.
#[derive(Clone, Debug)]
pub struct Newton {
    spec: NewtonSpec,
    r: Vec<f64>,
    r_trial: Vec<f64>,
    floor: Vec<f64>,
    dz: Vec<f64>,
    trial: Vec<f64>,
    correction: Vec<f64>,
}

pub(crate) fn norm(v: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    let chunks = v.chunks_exact(8);
    let rest = chunks.remainder();
    for chunk in chunks {
        for (lane, v) in lanes.iter_mut().zip(chunk) {
            *lane += v * v;
        }
    }
    for (lane, v) in lanes.iter_mut().zip(rest) {
        *lane += v * v;
    }
    lanes.iter().sum::<f64>().sqrt()
}

/// Norm of the parts of `r` beyond their floors: a stiff corner of a scene, whose residual cannot be small, then hides
/// nothing of a soft one.
fn excess(r: &[f64], floor: &[f64]) -> f64 {
    r.iter().zip(floor).map(|(r, floor)| (r.abs() - floor).max(0.0).powi(2)).sum::<f64>().sqrt()
}

impl Newton {
    /// Buffers for `n` unknowns.
    pub fn new(spec: NewtonSpec, n: usize) -> Self {
        let zero = || vec![0.0; n];
        Newton { spec, r: zero(), r_trial: zero(), floor: zero(), dz: zero(), trial: zero(), correction: zero() }
    }

    /// Iterates from `z` until residual and increment are both small. On success the problem's last evaluated residual is
    /// the one at the returned `z`.
    ///
    /// The increment test looks ahead: the next increment is about the last one times the reduction of the residual. So a
    /// linear problem takes one iteration, and a residual that merely stalls does not pass.
    ///
    /// # Errors
    /// When the tolerances are not reached; `z` is then worthless.
    pub fn solve(
        &mut self,
        problem: &mut dyn NonlinearProblem,
        z: &mut [f64],
        scales: Scales,
    ) -> Result<NewtonReport, NewtonFailure> {
        let tolerance = self.spec.relative * scales.residual;
        let over_scale = |r: f64| if scales.residual > 0.0 { r / scales.residual } else { 0.0 };
        problem.residual(z, &mut self.r, &mut self.floor);
        while problem.retreat(z) {
            problem.residual(z, &mut self.r, &mut self.floor);
        }
        let mut residual = norm(&self.r);
        if !residual.is_finite() {
            return Err(NewtonFailure::NotFinite { worst: self.worst() });
        }
        if self.excess() == 0.0 {
            return Ok(NewtonReport { iterations: 0, residual: over_scale(residual) });
        }
        for iterations in 1..=self.spec.max_iterations {
            let linear = |error, worst| NewtonFailure::Linear { iterations, error, worst };
            problem.linearise().map_err(|e| linear(e, self.worst()))?;
            for (dz, r) in self.dz.iter_mut().zip(&self.r) {
                *dz = -r;
            }
            problem.solve(&mut self.dz).map_err(|e| linear(e, self.worst()))?;
            let before = residual;
            let Some(lambda) = self.line_search(problem, z, &mut residual, tolerance) else {
                let worst = self.worst();
                return Err(NewtonFailure::Stuck { iterations, residual: before, tolerance, worst });
            };
            let next_increment = lambda * norm(&self.dz) * (residual / before);
            let small = (self.spec.relative * scales.increment.max(norm(z))).max(scales.increment_floor);
            let excess = self.excess();
            if excess <= tolerance && (next_increment <= small || excess == 0.0) {
                return Ok(NewtonReport { iterations, residual: over_scale(residual) });
            }
        }
        let worst = self.worst();
        Err(NewtonFailure::MaxIterations { iterations: self.spec.max_iterations, residual, tolerance, worst })
    }

    /// Halves the step until the merit drops; moves `z`, `self.r` and `residual` there.
    fn line_search(
        &mut self,
        problem: &mut dyn NonlinearProblem,
        z: &mut [f64],
        residual: &mut f64,
        tolerance: f64,
    ) -> Option<f64> {
        let mut lambda = 1.0;
        for _ in 0..=MAX_HALVINGS {
            for ((trial, z), dz) in self.trial.iter_mut().zip(z.iter()).zip(&self.dz) {
                *trial = z + lambda * dz;
            }
            problem.residual(&self.trial, &mut self.r_trial, &mut self.floor);
            let merit = match self.spec.merit {
                Merit::ResidualNorm => norm(&self.r_trial),
            };
            // A step that lands within the tolerance needs no decrease: rounding may not allow any.
            let landed = merit.is_finite() && excess(&self.r_trial, &self.floor) <= tolerance;
            if merit <= (1.0 - ARMIJO * lambda) * *residual || landed || self.nears(problem, lambda, merit) {
                z.copy_from_slice(&self.trial);
                std::mem::swap(&mut self.r, &mut self.r_trial);
                *residual = merit;
                return Some(lambda);
            }
            lambda *= 0.5;
        }
        None
    }

    /// Whether the trial is nearer to the solution although its residual (norm `merit`) is larger: the same tangent asks of it a
    /// correction clearly smaller than the step (restricted natural monotonicity: Deuflhard 2004, section 3.3, algorithm NLEQ-ERR). Where a stiff spring
    /// turns or a flat sheet begins to bulge, the residual must rise first: its norm only sees the stiff direction.
    fn nears(&mut self, problem: &mut dyn NonlinearProblem, lambda: f64, merit: f64) -> bool {
        if !merit.is_finite() {
            return false;
        }
        for (correction, r) in self.correction.iter_mut().zip(&self.r_trial) {
            *correction = -r;
        }
        let solved = problem.solve(&mut self.correction).is_ok();
        solved && norm(&self.correction) <= (1.0 - NATURAL * lambda) * norm(&self.dz)
    }

    /// [N] norm of what the residual has beyond rounding.
    fn excess(&self) -> f64 {
        excess(&self.r, &self.floor)
    }

    fn worst(&self) -> usize {
        let size = |r: f64| if r.is_finite() { r.abs() } else { f64::INFINITY };
        (0..self.r.len()).max_by(|&a, &b| size(self.r[a]).total_cmp(&size(self.r[b]))).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// z -> atan(10 z): Newton without a line search diverges from |z| > 0.14.
    struct Atan {
        z: f64,
        slope: f64,
        evaluations: Vec<f64>,
    }

    impl NonlinearProblem for Atan {
        fn residual(&mut self, z: &[f64], r: &mut [f64], floor: &mut [f64]) {
            self.z = z[0];
            r[0] = (10.0 * z[0]).atan();
            floor[0] = 1e-15;
            self.evaluations.push(r[0].abs());
        }
        fn linearise(&mut self) -> Result<(), LinearError> {
            self.slope = 10.0 / (1.0 + 100.0 * self.z * self.z);
            Ok(())
        }
        fn solve(&mut self, b: &mut [f64]) -> Result<(), LinearError> {
            b[0] /= self.slope;
            Ok(())
        }
    }

    const SCALES: Scales = Scales { residual: 1.0, increment: 1.0, increment_floor: 1e-15 };

    #[test]
    fn the_line_search_converges_where_plain_newton_diverges() {
        let mut problem = Atan { z: 0.0, slope: 0.0, evaluations: vec![] };
        let mut z = [5.0];
        let report = Newton::new(NewtonSpec::default(), 1).solve(&mut problem, &mut z, SCALES).unwrap();
        assert!(z[0].abs() < 1e-8, "{z:?} after {report:?}");
        assert_eq!(problem.z, z[0], "the last evaluation is the accepted one");
    }

    #[test]
    fn convergence_is_quadratic_or_better_near_the_solution() {
        let mut problem = Atan { z: 0.0, slope: 0.0, evaluations: vec![] };
        let mut z = [0.05];
        Newton::new(NewtonSpec::default(), 1).solve(&mut problem, &mut z, SCALES).unwrap();
        for pair in problem.evaluations.windows(2) {
            assert!(pair[1] <= 2.0 * pair[0] * pair[0], "{:?}", problem.evaluations);
        }
    }

    #[test]
    fn an_iteration_limit_is_a_refusal_with_its_numbers() {
        let spec = NewtonSpec { max_iterations: 2, ..Default::default() };
        let mut problem = Atan { z: 0.0, slope: 0.0, evaluations: vec![] };
        let failure = Newton::new(spec, 1).solve(&mut problem, &mut [5.0], SCALES).unwrap_err();
        let NewtonFailure::MaxIterations { iterations: 2, residual, tolerance, worst: 0 } = failure else {
            panic!("{failure:?}")
        };
        assert!(residual > tolerance);
    }
}
