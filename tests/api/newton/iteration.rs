//! Newton's iteration itself, on equations of one or two unknowns.

use canopy_fem::model::workers::ALONE;
use canopy_fem::solve::newton::{Curvature, Newton, NewtonFailure, NewtonSpec, NonlinearProblem, Scales};
use canopy_fem::solve::quasi_newton::FactorHistory;
use canopy_fem::solve::{ExpectedUse, Inertia, LinearError};

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
    fn linearise(&mut self, _: Curvature) -> Result<Inertia, LinearError> {
        self.slope = 10.0 / (1.0 + 100.0 * self.z * self.z);
        Ok(Inertia::Unknown)
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
    let report = Newton::new(NewtonSpec::default(), 1, &ALONE)
        .solve(&mut problem, &mut z, SCALES, &mut FactorHistory::default())
        .unwrap();
    assert!(z[0].abs() < 1e-8, "{z:?} after {report:?}");
    assert_eq!(problem.z, z[0], "the last evaluation is the accepted one");
}

#[test]
fn convergence_is_quadratic_or_better_near_the_solution() {
    let mut problem = Atan { z: 0.0, slope: 0.0, evaluations: vec![] };
    let mut z = [0.05];
    Newton::new(NewtonSpec::default(), 1, &ALONE)
        .solve(&mut problem, &mut z, SCALES, &mut FactorHistory::default())
        .unwrap();
    for pair in problem.evaluations.windows(2) {
        assert!(pair[1] <= 2.0 * pair[0] * pair[0], "{:?}", problem.evaluations);
    }
}

/// Flat, with its lowest point at z0 = 1, but for a wall at 0.9, where another unknown is thrown out of range.
struct Wall;

impl NonlinearProblem for Wall {
    fn residual(&mut self, z: &[f64], r: &mut [f64], floor: &mut [f64]) {
        r.copy_from_slice(&[z[0] - 1.0, if z[0] > 0.9 { 1e200 } else { 0.0 }]);
        floor.fill(1e-15);
    }
    fn conservative(&self) -> bool {
        true
    }
    fn linearise(&mut self, _: Curvature) -> Result<Inertia, LinearError> {
        Ok(Inertia::Unknown)
    }
    fn solve(&mut self, _: &mut [f64]) -> Result<(), LinearError> {
        Ok(())
    }
}

/// A search does not step to where the norm of the forces overflows, so that a report has numbers.
#[test]
fn the_search_stays_where_forces_are_numbers() {
    let failure = Newton::new(NewtonSpec::default(), 2, &ALONE)
        .solve(&mut Wall, &mut [0.0; 2], SCALES, &mut FactorHistory::default())
        .unwrap_err();
    let (NewtonFailure::Stuck { residual, .. } | NewtonFailure::MaxIterations { residual, .. }) = failure else {
        panic!("{failure:?}")
    };
    assert!(residual <= 1.0, "{failure:?}");
}

/// z -> z - 1, whose kept matrix no solver copes with.
#[derive(Default)]
struct Keeping {
    kept: bool,
    exact_fails: bool,
}

impl NonlinearProblem for Keeping {
    fn residual(&mut self, z: &[f64], r: &mut [f64], floor: &mut [f64]) {
        r[0] = z[0] - 1.0;
        floor[0] = 1e-15;
    }
    fn linearise(&mut self, _: Curvature) -> Result<Inertia, LinearError> {
        self.kept = false;
        if self.exact_fails { Err(LinearError::Singular { unknown: Some(0) }) } else { Ok(Inertia::Definite) }
    }
    fn freeze(&mut self, _: ExpectedUse) -> Result<bool, LinearError> {
        Ok(true)
    }
    fn take_frozen(&mut self) {
        self.kept = true;
    }
    fn reuses_factors(&self) -> bool {
        true
    }
    fn solve(&mut self, _: &mut [f64]) -> Result<(), LinearError> {
        if self.kept { Err(LinearError::Stalled { iterations: 9, residual: 0.5, asked: 1e-3 }) } else { Ok(()) }
    }
}

/// What fails on the kept matrix is tried with the exact one, and both count.
#[test]
fn a_solver_that_fails_on_the_kept_matrix_leaves_the_step_to_the_exact_one() {
    let mut z = [0.0];
    let mut newton = Newton::new(NewtonSpec::default(), 1, &ALONE);
    let report = newton.solve(&mut Keeping::default(), &mut z, SCALES, &mut FactorHistory::default()).unwrap();
    assert_eq!((z, report.iterations), ([1.0], 2));
    let mut neither = Keeping { exact_fails: true, ..Keeping::default() };
    let failure = newton.solve(&mut neither, &mut [0.0], SCALES, &mut FactorHistory::default()).unwrap_err();
    let NewtonFailure::Linear { iterations: 2, error: LinearError::Singular { .. }, .. } = failure else {
        panic!("{failure:?}")
    };
}

#[test]
fn an_iteration_limit_is_a_refusal_with_its_numbers() {
    let spec = NewtonSpec { max_iterations: 2, ..Default::default() };
    let mut problem = Atan { z: 0.0, slope: 0.0, evaluations: vec![] };
    let failure = Newton::new(spec, 1, &ALONE)
        .solve(&mut problem, &mut [5.0], SCALES, &mut FactorHistory::default())
        .unwrap_err();
    let NewtonFailure::MaxIterations { iterations: 2, residual, tolerance, worst: 0 } = failure else {
        panic!("{failure:?}")
    };
    assert!(residual > tolerance);
}
