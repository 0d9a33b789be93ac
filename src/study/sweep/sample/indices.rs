//! Which input makes how much of the scatter: Sobol' indices. The first-order index S_i = Var(E(y | x_i)) / Var(y) is
//! the share that x_i makes alone; the total index is the share that would be left if all others were known.
//!
//! [`given_data`] finds first-order indices from any sample, [`saltelli`] both from the rows of Saltelli's design.

use serde::Serialize;

use super::estimate::{Estimate, errors_of_margin, mean_of};
use crate::mesh::random::SplitMix64;

/// Samples of the bootstrap (Efron 1979, Ann. Stat. 7, 1-26), whose scatter is that of an estimate.
const RESAMPLED: usize = 200;
/// Fewest rows with the same value for which the values are classes.
const CLASS: usize = 5;

/// The indices of a input.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Index {
    /// names of its keys
    pub input: String,
    /// [-] its own share; `None` where it cannot be estimated
    pub first: Option<Estimate>,
    /// [-] its share with all that it does together with others; only from Saltelli's design
    pub total: Option<Estimate>,
}

/// First-order index of one input from a sample: `places` are its coordinates or classes, `values` the results.
///
/// The rows are divided by the input into M parts of as many rows, with a straight line fitted in each. What the lines
/// leave is the rest of the variance: S = 1 - (SSR/(n - 2 M))/(SST/(n - 1)), as Pearson's correlation ratio for given
/// data (Plischke, Borgonovo & Smith 2013, Eur. J. Oper. Res. 226, 536-550), but with lines in place of constants,
/// which a smooth dependence follows to the fourth power of the width of a part. Where a value is there five times in
/// the mean, the parts are its classes. `None` of fewer than ten rows, and where nothing varies.
pub fn given_data(places: &[f64], values: &[f64]) -> Option<Estimate> {
    let n = places.len().min(values.len());
    let mut rows: Vec<(f64, f64)> = places.iter().copied().zip(values.iter().copied()).collect();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let distinct = 1 + rows.windows(2).filter(|pair| pair[0].0 < pair[1].0).count();
    let parts = if distinct * CLASS <= n { Parts::Classes } else { Parts::Lines(parts_for(n)) };
    if n < 10 || distinct < 2 {
        return None;
    }
    let value = explained(&rows, &parts)?;
    let mut numbers = SplitMix64::of_seed(n as u64);
    let resampled: Vec<f64> = (0..RESAMPLED)
        .filter_map(|_| {
            let mut counts = vec![0_usize; n];
            (0..n).for_each(|_| counts[below(n, &mut numbers)] += 1);
            let rows: Vec<(f64, f64)> =
                rows.iter().zip(counts).flat_map(|(row, count)| std::iter::repeat_n(*row, count)).collect();
            explained(&rows, &parts)
        })
        .collect();
    Some(Estimate::with_margin(value, margin_of(&resampled)))
}

/// How the rows are divided.
enum Parts {
    /// rows with the same place
    Classes,
    /// so many parts with a line in each
    Lines(usize),
}

/// Parts for n rows: their number grows so that bias and noise fall alike.
fn parts_for(n: usize) -> usize {
    ((n as f64).cbrt().round() as usize).clamp(2, 40)
}

/// A number below n.
fn below(n: usize, numbers: &mut SplitMix64) -> usize {
    ((u128::from(numbers.draw()) * n as u128) >> 64) as usize
}

fn margin_of(resampled: &[f64]) -> f64 {
    let mean = mean_of(resampled);
    let variance = resampled.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (resampled.len() as f64 - 1.0);
    errors_of_margin() * variance.sqrt()
}

/// The share of the variance that the input explains, corrected for the numbers that were fitted; rows are sorted.
fn explained(rows: &[(f64, f64)], parts: &Parts) -> Option<f64> {
    let n = rows.len();
    let mean = rows.iter().map(|row| row.1).sum::<f64>() / n as f64;
    let total: f64 = rows.iter().map(|row| (row.1 - mean).powi(2)).sum();
    let (mut rest, mut fitted) = (0.0, 0);
    let mut add = |part: &[(f64, f64)], line: bool| {
        let (squares, numbers) = left_by_fit(part, line);
        rest += squares;
        fitted += numbers;
    };
    match parts {
        Parts::Classes => rows.chunk_by(|a, b| a.0 == b.0).for_each(|part| add(part, false)),
        Parts::Lines(count) => {
            let end = |part: usize| part * n / count;
            (0..*count).for_each(|part| add(&rows[end(part)..end(part + 1)], true));
        }
    }
    let freedom = n.checked_sub(fitted).filter(|freedom| *freedom > 0)?;
    (total > 0.0).then(|| 1.0 - rest / freedom as f64 * (n as f64 - 1.0) / total)
}

/// The sum of squares that the mean or a line leaves, and how many numbers were fitted.
fn left_by_fit(part: &[(f64, f64)], line: bool) -> (f64, usize) {
    if part.is_empty() {
        return (0.0, 0);
    }
    let mean = |of: fn(&(f64, f64)) -> f64| part.iter().map(of).sum::<f64>() / part.len() as f64;
    let (x, y) = (mean(|row| row.0), mean(|row| row.1));
    let sum = |of: &dyn Fn(f64, f64) -> f64| part.iter().map(|row| of(row.0 - x, row.1 - y)).sum::<f64>();
    let (xx, xy, yy) = (sum(&|x, _| x * x), sum(&|x, y| x * y), sum(&|_, y| y * y));
    if line && xx > 0.0 { ((yy - xy * xy / xx).max(0.0), 2) } else { (yy, 1) }
}

/// First-order and total indices of all inputs from groups of rows: a group has the results at A, at B, and at A with
/// each coordinate in turn from B. Jansen's estimators (Jansen 1999, Comput. Phys. Commun. 117, 35-43; Saltelli et al.
/// 2010): S_i = 1 - E (f(B) - f(AB_i))^2 / 2V and S_Ti = E (f(A) - f(AB_i))^2 / 2V, with the variance V of the results
/// at A and B. Empty of fewer than ten groups, and where nothing varies.
pub fn saltelli(groups: &[Vec<f64>]) -> Vec<[Estimate; 2]> {
    let n = groups.len();
    if n < 10 {
        return Vec::new();
    }
    let all: Vec<usize> = (0..n).collect();
    let Some(found) = jansen(groups, &all) else { return Vec::new() };
    let mut numbers = SplitMix64::of_seed(n as u64);
    let resampled: Vec<Vec<[f64; 2]>> = (0..RESAMPLED)
        .filter_map(|_| jansen(groups, &(0..n).map(|_| below(n, &mut numbers)).collect::<Vec<_>>()))
        .collect();
    let estimate = |i: usize, kind: usize| {
        let others: Vec<f64> = resampled.iter().map(|indices| indices[i][kind]).collect();
        Estimate::with_margin(found[i][kind], margin_of(&others))
    };
    (0..found.len()).map(|i| [estimate(i, 0), estimate(i, 1)]).collect()
}

/// First-order and total indices from these groups.
fn jansen(groups: &[Vec<f64>], chosen: &[usize]) -> Option<Vec<[f64; 2]>> {
    let inputs = groups.first()?.len().checked_sub(2)?;
    let rows = || chosen.iter().filter_map(|number| groups.get(*number));
    let ends: Vec<f64> = rows().flat_map(|row| [row[0], row[1]]).collect();
    let mean = mean_of(&ends);
    let variance = ends.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / ends.len() as f64;
    let half = |from: usize, i: usize| {
        rows().map(|row| (row[from] - row[2 + i]).powi(2)).sum::<f64>() / (2.0 * chosen.len() as f64 * variance)
    };
    (variance > 0.0).then(|| (0..inputs).map(|i| [1.0 - half(1, i), half(0, i)]).collect())
}

#[cfg(test)]
mod tests {
    use super::super::input::Input;
    use super::super::law::Law;
    use super::*;
    use crate::sweep::sample::{Sampled, Sampling};
    use std::f64::consts::PI;

    /// Ishigami and Homma's function (1990, ISUMA'90, 398-403) with a = 7 and b = 0.1, of uniform numbers in [-pi, pi].
    fn ishigami(x: &[f64]) -> f64 {
        x[0].sin() + 7.0 * x[1].sin().powi(2) + 0.1 * x[2].powi(4) * x[0].sin()
    }

    /// Its indices: V1 = (1 + b pi^4/5)^2/2, V2 = a^2/8, V13 = b^2 pi^8 (1/18 - 1/50), V their sum.
    fn exact() -> ([f64; 3], [f64; 3]) {
        let (v1, v2) = (0.5 * (1.0 + 0.1 * PI.powi(4) / 5.0).powi(2), 49.0 / 8.0);
        let v13 = 0.01 * PI.powi(8) * (1.0 / 18.0 - 1.0 / 50.0);
        let v = v1 + v2 + v13;
        ([v1 / v, v2 / v, 0.0], [(v1 + v13) / v, v2 / v, v13 / v])
    }

    fn design(sampling: Sampling, samples: usize, indices: bool) -> Vec<Vec<f64>> {
        let input = |i: usize| Input { keys: vec![format!("k{i}")], law: Law::Uniform { from: -PI, to: PI } };
        let inputs: Vec<Input> = (0..3).map(input).collect();
        let sampled = Sampled { inputs, samples, sampling, seed: 3, indices, ..Sampled::default() };
        let points = sampled.points().expect("points");
        points.iter().map(|point| point.iter().map(|u| PI * (2.0 * u - 1.0)).collect()).collect()
    }

    /// The exact index is within the interval and half as much again, and the interval is narrow.
    fn close(found: Estimate, exact: f64, most: f64, what: &str) {
        let margin = found.margin().expect("an interval");
        assert!((found.value - exact).abs() < 1.5 * margin + 1e-3 && margin < most, "{what}: {found:?}, exact {exact}");
    }

    #[test]
    fn ishigami_by_saltellis_design() {
        let (first, total) = exact();
        for sampling in [Sampling::Sobol, Sampling::Lhs, Sampling::Random] {
            let rows = design(sampling, 2048, true);
            let groups: Vec<Vec<f64>> = rows.chunks(5).map(|rows| rows.iter().map(|x| ishigami(x)).collect()).collect();
            for (i, [one, all]) in saltelli(&groups).into_iter().enumerate() {
                close(one, first[i], 0.12, &format!("{sampling:?} first {i}"));
                close(all, total[i], 0.12, &format!("{sampling:?} total {i}"));
            }
        }
    }

    #[test]
    fn ishigami_by_given_data() {
        for (sampling, n, most) in
            [(Sampling::Random, 4000, 0.05), (Sampling::Lhs, 1000, 0.09), (Sampling::Sobol, 1024, 0.09)]
        {
            let rows = design(sampling, n, false);
            let values: Vec<f64> = rows.iter().map(|x| ishigami(x)).collect();
            for (i, exact) in exact().0.into_iter().enumerate() {
                let places: Vec<f64> = rows.iter().map(|row| row[i]).collect();
                close(given_data(&places, &values).expect("rows"), exact, most, &format!("{sampling:?} {i}"));
            }
        }
    }

    /// y = x1 + 2 x2: the indices of a sum of independent numbers are the shares of their variances, 1/5 and 4/5.
    #[test]
    fn sums_have_the_shares_of_their_variances() {
        let rows = design(Sampling::Sobol, 512, true);
        let groups: Vec<Vec<f64>> =
            rows.chunks(5).map(|rows| rows.iter().map(|x| x[0] + 2.0 * x[1]).collect()).collect();
        for (found, share) in saltelli(&groups).into_iter().zip([0.2, 0.8, 0.0]) {
            assert!(found.iter().all(|index| (index.value - share).abs() < 0.02), "{found:?}, exact {share}");
        }
        let all: Vec<&Vec<f64>> = rows.iter().step_by(5).collect();
        let values: Vec<f64> = all.iter().map(|x| x[0] + 2.0 * x[1]).collect();
        for (i, share) in [0.2, 0.8, 0.0].into_iter().enumerate() {
            let places: Vec<f64> = all.iter().map(|x| x[i]).collect();
            assert!((given_data(&places, &values).expect("rows").value - share).abs() < 0.05);
        }
    }

    /// Total indices of `SALib.analyze.sobol` (SALib 1.6.0), which has Jansen's estimator for them, of the same rows:
    /// `scipy.stats.qmc.Sobol(6, scramble=False, bits=32).random(256)`, each coordinate with half a digit added.
    #[test]
    fn total_indices_are_those_of_salib() {
        use crate::sweep::sample::sobol::Coordinate;
        let coordinates: Vec<Coordinate> = (0..6).filter_map(Coordinate::new).collect();
        let group = |point: u32| {
            let x: Vec<f64> = coordinates
                .iter()
                .map(|coordinate| PI * (2.0 * (f64::from(coordinate.of(point)) + 0.5) / 2.0_f64.powi(32) - 1.0))
                .collect();
            let (a, b) = x.split_at(3);
            let mixed = (0..3).map(|i| {
                let mut mixed = a.to_vec();
                mixed[i] = b[i];
                ishigami(&mixed)
            });
            [ishigami(a), ishigami(b)].into_iter().chain(mixed).collect()
        };
        let groups: Vec<Vec<f64>> = (0..256).map(group).collect();
        let salib = [0.564_602_482_194_982_9, 0.457_007_143_001_836_3, 0.250_648_843_537_766_06];
        for (found, expected) in saltelli(&groups).into_iter().zip(salib) {
            assert!((found[1].value - expected).abs() < 1e-10, "{found:?}, not {expected}");
        }
    }

    /// Words are classes: two values whose means are 2 apart, with noise of a sine.
    #[test]
    fn classes_are_told_from_numbers() {
        let places: Vec<f64> = (0..200).map(|i| f64::from(i % 2)).collect();
        let values: Vec<f64> = (0..200).map(|i| 2.0 * f64::from(i % 2) + f64::from(i).sin()).collect();
        let found = given_data(&places, &values).expect("rows");
        // Variances 1 of the classes and 1/2 of the sine.
        close(found, 2.0 / 3.0, 0.1, "classes");
        assert_eq!(given_data(&[1.0; 200], &values), None, "nothing varies");
        assert_eq!(given_data(&places[..9], &values[..9]), None, "too few");
    }
}
