//! What a minimum of least squares says of the values: their errors by the noise of the data.

use nalgebra::DMatrix;
use serde::Serialize;

use super::data::DataSet;
use super::least_squares::Minimum;
use super::parameter::Parameter;
use crate::sweep::sample::student_quantile;

/// [-] Ratio of the singular values of J, its columns scaled to length 1, below which a combination of values is not
/// determined; far above what differences leave of columns that are parallel.
const SINGULAR: f64 = 1e-4;
/// [-] Part that a value has in such a combination from which on it is told.
const PART: f64 = 0.1;

/// A value that was fitted.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Fitted {
    /// the key, and the range in which it was searched
    #[serde(flatten)]
    pub parameter: Parameter,
    /// its value
    pub value: f64,
    /// its standard error; none at an end of the range, or if the data do not determine it
    pub standard_error: Option<f64>,
    /// the interval that holds the value with 95 % confidence, as far as the model is linear there
    pub interval: Option<[f64; 2]>,
    /// whether it came to an end of its range
    pub at_end_of_range: bool,
    /// whether the data determine it
    pub determined: bool,
}

/// The noise of a set of data.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Noise {
    /// standard deviation: that of the file, in the mean, or of the residuals
    pub sigma: f64,
    /// whether it was given with the data
    pub given: bool,
    /// root of the mean square of the residuals
    pub residual: f64,
    /// number of points
    pub points: usize,
}

/// All that follows from a minimum.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Estimate {
    /// the values
    pub values: Vec<Fitted>,
    /// [-] correlation of the errors of values, (n, n); null where a value has no error
    pub correlation: Vec<Vec<Option<f64>>>,
    /// the noise of each set
    pub noise: Vec<Noise>,
    /// points less values
    pub degrees_of_freedom: usize,
    /// [-] mean square of the residuals over their standard deviations, with the degrees of freedom; about 1 where the
    /// model and the given noise are right. None where no noise is given
    pub reduced_chi_square: Option<f64>,
}

/// The weight of each point: one over its standard deviation, or over that which its set is taken to have.
pub(super) fn weights(sets: &[DataSet], taken: &[f64]) -> Vec<f64> {
    let of = |(set, taken): (&DataSet, &f64)| -> Vec<f64> {
        if set.sigma.is_empty() { vec![1.0 / taken; set.t.len()] } else { set.sigma.iter().map(|s| 1.0 / s).collect() }
    };
    sets.iter().zip(taken).flat_map(of).collect()
}

/// The standard deviation of each set by its weighted residuals, which were weighted with `taken`.
pub(super) fn sigma_of(sets: &[DataSet], taken: &[f64], residuals: &[f64], values: usize) -> Vec<f64> {
    let all: usize = sets.iter().map(|set| set.t.len()).sum();
    let share = all.saturating_sub(values).max(1) as f64 / all.max(1) as f64;
    let mut rest = residuals;
    let mut of = |(set, taken): (&DataSet, &f64)| {
        let (own, later) = rest.split_at(set.t.len().min(rest.len()));
        rest = later;
        let mean = own.iter().map(|r| r * r).sum::<f64>() / own.len().max(1) as f64;
        // Data without noise have a weight too.
        taken * (mean / share).sqrt().max(1e-12)
    };
    sets.iter().zip(taken).map(&mut of).collect()
}

impl Estimate {
    /// Of a minimum whose residuals were weighted with the standard deviations `taken`; those of sets without given
    /// noise follow from the residuals.
    pub(super) fn of(minimum: &Minimum, parameters: &[Parameter], sets: &[DataSet], taken: &[f64]) -> Self {
        let found = sigma_of(sets, taken, &minimum.residuals, minimum.u.len());
        let before = weights(sets, taken);
        let after = weights(sets, &found);
        let mut jacobian = minimum.jacobian.clone();
        for (i, (before, after)) in before.iter().zip(&after).enumerate() {
            jacobian.row_mut(i).scale_mut(after / before);
        }
        let at_end = |u: f64| u <= 0.0 || u >= 1.0;
        let inside: Vec<usize> = minimum.u.iter().enumerate().filter(|(_, u)| !at_end(**u)).map(|(i, _)| i).collect();
        let errors = Errors::of(&jacobian.select_columns(&inside));
        let points = minimum.residuals.len();
        let freedom = points.saturating_sub(minimum.u.len());
        let spread = student(freedom);
        let value = |(i, parameter): (usize, &Parameter)| {
            let u = minimum.u.get(i).copied().unwrap_or_default();
            let (range, at) = (parameter.range, inside.iter().position(|free| *free == i));
            let value = range.value(u);
            let standard_error = at.and_then(|at| errors.standard(at)).map(|error| error * range.slope(u));
            let interval = standard_error.map(|error| {
                let wide = spread * error;
                // A logarithm's error is the relative one.
                if range.log {
                    let ratio = (wide / value).exp();
                    [value / ratio, value * ratio]
                } else {
                    [value - wide, value + wide]
                }
            });
            Fitted {
                parameter: parameter.clone(),
                value,
                standard_error,
                interval,
                at_end_of_range: at_end(u),
                determined: at.is_none_or(|at| errors.determined(at)),
            }
        };
        let correlation = |i: usize, j: usize| {
            let place = |i: usize| inside.iter().position(|free| *free == i);
            errors.correlation(place(i)?, place(j)?)
        };
        let n = parameters.len();
        let given = sets.iter().any(|set| !set.sigma.is_empty());
        let weighted: f64 =
            minimum.residuals.iter().zip(&before).zip(&after).map(|((r, b), a)| (r * a / b).powi(2)).sum();
        Estimate {
            values: parameters.iter().enumerate().map(value).collect(),
            correlation: (0..n).map(|i| (0..n).map(|j| correlation(i, j)).collect()).collect(),
            noise: noise(minimum, sets, &before, &found),
            degrees_of_freedom: freedom,
            reduced_chi_square: (given && freedom > 0).then(|| weighted / freedom as f64),
        }
    }
}

fn noise(minimum: &Minimum, sets: &[DataSet], weights: &[f64], found: &[f64]) -> Vec<Noise> {
    let plain: Vec<f64> = minimum.residuals.iter().zip(weights).map(|(r, weight)| r / weight).collect();
    let mut first = 0;
    let mut of = |(set, found): (&DataSet, &f64)| {
        let own = plain.get(first..first + set.t.len()).unwrap_or_default();
        first += set.t.len();
        let root = |squares: f64| (squares / set.t.len().max(1) as f64).sqrt();
        let given = !set.sigma.is_empty();
        Noise {
            sigma: if given { root(set.sigma.iter().map(|s| s * s).sum()) } else { *found },
            given,
            residual: root(own.iter().map(|r| r * r).sum()),
            points: set.t.len(),
        }
    };
    sets.iter().zip(found).map(&mut of).collect()
}

/// Covariance of the numbers of a linear fit with residuals of variance 1, from the singular values of J.
struct Errors {
    lengths: Vec<f64>,
    covariance: DMatrix<f64>,
    undetermined: Vec<bool>,
}

impl Errors {
    /// C = D^-1 V S^-2 V^T D^-1, where J D^-1 = U S V^T and D has the lengths of J's columns.
    fn of(jacobian: &DMatrix<f64>) -> Self {
        let n = jacobian.ncols();
        let lengths: Vec<f64> = jacobian.column_iter().map(|column| column.norm()).collect();
        let mut scaled = jacobian.clone();
        for (mut column, length) in scaled.column_iter_mut().zip(&lengths) {
            column.scale_mut(if *length > 0.0 { 1.0 / length } else { 0.0 });
        }
        let mut undetermined: Vec<bool> = lengths.iter().map(|length| *length <= 0.0).collect();
        let mut covariance = DMatrix::zeros(n, n);
        if n > 0 && jacobian.nrows() >= n {
            let svd = scaled.qr().r().svd(false, true);
            let most = svd.singular_values.max();
            for (row, s) in svd.v_t.iter().flat_map(|v_t| v_t.row_iter()).zip(svd.singular_values.iter()) {
                if *s > SINGULAR * most {
                    covariance += row.transpose() * row / (s * s);
                } else {
                    undetermined.iter_mut().zip(row.iter()).for_each(|(flag, part)| *flag |= part.abs() > PART);
                }
            }
        }
        Errors { lengths, covariance, undetermined }
    }

    fn determined(&self, i: usize) -> bool {
        !self.undetermined.get(i).copied().unwrap_or(true)
    }

    fn standard(&self, i: usize) -> Option<f64> {
        let length = self.lengths.get(i).filter(|_| self.determined(i))?;
        Some(self.covariance.get((i, i))?.sqrt() / length)
    }

    fn correlation(&self, i: usize, j: usize) -> Option<f64> {
        let at = |i: usize, j: usize| self.covariance.as_slice().get(i + j * self.covariance.nrows()).copied();
        (self.determined(i) && self.determined(j)).then_some(())?;
        if i == j { Some(1.0) } else { Some(at(i, j)? / (at(i, i)? * at(j, j)?).sqrt()) }
    }
}

/// The factor of a standard error that gives an interval of 95 %: Student's t with so many degrees of freedom, within
/// 1 %.
fn student(freedom: usize) -> f64 {
    match freedom {
        0 => f64::INFINITY,
        // The closed form, where the expansion is too coarse.
        1 => (0.475 * std::f64::consts::PI).tan(),
        _ => student_quantile(0.975, freedom as f64),
    }
}

#[cfg(test)]
mod tests {
    use super::student;

    /// Tables of Student's t at 97.5 %: within 1 %.
    #[test]
    fn the_factor_of_an_interval_is_students() {
        for (freedom, table) in
            [(1, 12.706), (2, 4.303), (3, 3.182), (4, 2.776), (10, 2.228), (30, 2.042), (1000, 1.962)]
        {
            let t = student(freedom);
            assert!((t / table - 1.0).abs() < 0.01, "{freedom}: {t} for {table}");
        }
    }
}
