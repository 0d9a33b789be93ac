//! Least squares within the unit cube by Levenberg and Marquardt's method.
//!
//! A step s solves (J^T J + lambda D^2) s = -J^T r, where D has the lengths of the columns of J, for the numbers that
//! are not held at an end of [0, 1] (Moré 1978, "The Levenberg–Marquardt algorithm: implementation and theory"). It is
//! cut at the cube. lambda follows the ratio of actual to predicted reduction (Nielsen 1999, "Damping parameter in
//! Marquardt's method", section 3). A trial without a result counts as one that is worse.
//!
//! The registries' `levenberg-marquardt` has neither bounds nor trials that fail, and needs a second nalgebra.

use nalgebra::{DMatrix, DVector};

use crate::error::StudyError;

/// Most Jacobians.
const ITERATIONS: usize = 60;
/// [-] Largest cosine between residuals and a column of J at a minimum.
const COSINE: f64 = 1e-7;
/// [-] Relative reduction of the sum of squares, and change of u, below which nothing is left to gain.
const GAIN: f64 = 1e-10;
const STEP: f64 = 1e-9;
/// [-] First lambda, and the one beyond which no shorter step is tried.
const LAMBDA: [f64; 2] = [1e-3, 1e12];

/// Residuals at several points, each (m); `None` where they cannot be had.
type Residuals<'a> = dyn Fn(&[Vec<f64>]) -> Result<Vec<Option<Vec<f64>>>, StudyError> + 'a;

/// A problem.
pub struct LeastSquares<'a> {
    /// the residuals r(u)
    pub residuals: &'a Residuals<'a>,
    /// by how much a number of u is changed for a derivative: its index and its value
    pub change: &'a dyn Fn(usize, f64) -> f64,
}

/// Why the search ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ended {
    /// at a minimum: the residuals are normal to all columns of J, or nothing is left to gain
    #[default]
    Minimum,
    /// after the most iterations
    TooMany,
}

/// Where the search ended.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// the point, (n)
    pub u: Vec<f64>,
    /// the residuals there, (m)
    pub residuals: Vec<f64>,
    /// dr/du there, (m, n)
    pub jacobian: DMatrix<f64>,
    /// Jacobians that were made
    pub iterations: usize,
    /// why it ended
    pub ended: Ended,
}

/// A trial step that was kept.
struct Kept {
    u: Vec<f64>,
    r: DVector<f64>,
    /// whether nothing is left to gain
    last: bool,
}

impl LeastSquares<'_> {
    /// Searches from a point; `None` if there are no residuals.
    ///
    /// # Errors
    /// Those of the residuals; a derivative for which neither side has residuals.
    pub fn search(&self, start: &[f64]) -> Result<Option<Minimum>, StudyError> {
        let mut u = start.to_vec();
        let first = (self.residuals)(std::slice::from_ref(&u))?.pop().flatten();
        let Some(mut r) = first.map(DVector::from_vec) else { return Ok(None) };
        let [mut lambda, _] = LAMBDA;
        let (mut iterations, mut last) = (0, false);
        loop {
            let jacobian = self.jacobian(&u, &r)?;
            iterations += 1;
            let free = free(&u, &jacobian, &r);
            let ended = if last || is_minimum(&jacobian, &r, &free) {
                Some(Ended::Minimum)
            } else if iterations >= ITERATIONS {
                Some(Ended::TooMany)
            } else {
                None
            };
            let kept = if ended.is_none() { self.step(&u, &r, &jacobian, &free, &mut lambda)? } else { None };
            match kept {
                Some(kept) => (u, r, last) = (kept.u, kept.r, kept.last),
                None => {
                    let residuals = r.as_slice().to_vec();
                    return Ok(Some(Minimum { u, residuals, jacobian, iterations, ended: ended.unwrap_or_default() }));
                }
            }
        }
    }

    /// dr/du by central differences, one-sided at the ends of [0, 1] and where one side has no residuals.
    fn jacobian(&self, u: &[f64], r: &DVector<f64>) -> Result<DMatrix<f64>, StudyError> {
        let moved = |i: usize, sign: f64| {
            let mut moved = u.to_vec();
            if let Some(x) = moved.get_mut(i) {
                *x = (*x + sign * (self.change)(i, *x)).clamp(0.0, 1.0);
            }
            moved
        };
        let points: Vec<Vec<f64>> = (0..u.len()).flat_map(|i| [moved(i, 1.0), moved(i, -1.0)]).collect();
        let all = (self.residuals)(&points)?;
        let mut jacobian = DMatrix::zeros(r.len(), u.len());
        for ((i, sides), points) in all.chunks(2).enumerate().zip(points.chunks(2)) {
            let side = |k: usize| sides.get(k).and_then(Option::as_ref).map(|r| DVector::from_column_slice(r));
            let place = |k: usize| points.get(k).and_then(|point| point.get(i)).copied().unwrap_or_default();
            let here = u.get(i).copied().unwrap_or_default();
            let (high, low) = match (side(0), side(1)) {
                (Some(high), Some(low)) => ((place(0), high), (place(1), low)),
                (Some(high), None) => ((place(0), high), (here, r.clone())),
                (None, Some(low)) => ((here, r.clone()), (place(1), low)),
                (None, None) => return Err(StudyError::Usage(format!("no run on either side of parameter {i}"))),
            };
            // Both sides at one point: the number is held at an end and the other side has failed.
            let distance = high.0 - low.0;
            if distance > 0.0 {
                jacobian.set_column(i, &((high.1 - low.1) / distance));
            }
        }
        Ok(jacobian)
    }

    /// The first shorter and shorter step that reduces the sum of squares; `None` if none does.
    fn step(
        &self,
        u: &[f64],
        r: &DVector<f64>,
        jacobian: &DMatrix<f64>,
        free: &[usize],
        lambda: &mut f64,
    ) -> Result<Option<Kept>, StudyError> {
        let (columns, mut factor) = (jacobian.select_columns(free), 2.0);
        let (square, gradient) = (columns.tr_mul(&columns), columns.tr_mul(r));
        while *lambda < LAMBDA[1] {
            let mut damped = square.clone();
            for i in 0..free.len() {
                // A column of zeros takes no step.
                damped[(i, i)] = (1.0 + *lambda) * damped[(i, i)] + f64::MIN_POSITIVE.sqrt();
            }
            let solved = damped.cholesky().map(|factor| factor.solve(&-&gradient));
            let mut trial = u.to_vec();
            for (step, &i) in solved.iter().flat_map(|solved| solved.iter()).zip(free) {
                if let Some(x) = trial.get_mut(i) {
                    *x = (*x + step).clamp(0.0, 1.0);
                }
            }
            let moved = DVector::from_iterator(u.len(), trial.iter().zip(u).map(|(to, from)| to - from));
            let length = moved.amax();
            if solved.is_some() && length < STEP {
                return Ok(None);
            }
            let (before, predicted) = (r.norm_squared(), (r + jacobian * &moved).norm_squared());
            let found = (self.residuals)(std::slice::from_ref(&trial))?.pop().flatten().map(DVector::from_vec);
            let reduced = found.as_ref().map_or(f64::NEG_INFINITY, |found| before - found.norm_squared());
            let ratio = reduced / (before - predicted).max(f64::MIN_POSITIVE);
            if let Some(found) = found.filter(|_| solved.is_some() && reduced > 0.0 && ratio > 1e-4) {
                *lambda *= (1.0 - (2.0 * ratio - 1.0).powi(3)).clamp(1.0 / 3.0, 2.0);
                let last = reduced.max(before - predicted) < GAIN * before;
                return Ok(Some(Kept { u: trial, r: found, last }));
            }
            *lambda *= factor;
            factor *= 2.0;
        }
        Ok(None)
    }
}

/// The numbers that are not held at an end of [0, 1]: those from which the sum of squares falls inwards are free.
fn free(u: &[f64], jacobian: &DMatrix<f64>, r: &DVector<f64>) -> Vec<usize> {
    let held = |i: usize, x: f64| {
        let slope = jacobian.column(i).dot(r);
        (x <= 0.0 && slope > 0.0) || (x >= 1.0 && slope < 0.0)
    };
    u.iter().enumerate().filter(|(i, x)| !held(*i, **x)).map(|(i, _)| i).collect()
}

fn is_minimum(jacobian: &DMatrix<f64>, r: &DVector<f64>, free: &[usize]) -> bool {
    free.iter().all(|i| {
        let column = jacobian.column(*i);
        column.dot(r).abs() <= COSINE * column.norm() * r.norm()
    })
}
