//! Which points of the distributions are run: independent draws, Latin hypercubes or Sobol' points, the same for a seed
//! on every machine.
//!
//! A point has a coordinate above 0 and below 1 for each input, whose value is there in its distribution
//! ([`Law::at`](super::law::Law::at)). In Saltelli's design (Saltelli et al. 2010, Comput. Phys. Commun. 181, 259-270)
//! a group of rows is a point A, a point B, and A with each coordinate in turn from B.

use std::ops::Range;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::input::Input;
use super::rule::Rule;
use super::sobol::{self, Coordinate};
use crate::error::StudyError;
use crate::mesh::random::SplitMix64;

/// Rows between two looks at the rule that ends a sweep: a power of two, for Sobol' points.
const BATCH: usize = 64;

/// How points are chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Sampling {
    /// a Latin hypercube: of N points each N-th part of a distribution has one
    #[default]
    Lhs,
    /// Sobol' points with a random shift of their binary digits
    Sobol,
    /// independent draws
    Random,
}

impl Sampling {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Sampling::Lhs => "Latin hypercube",
            Sampling::Sobol => "Sobol' points",
            Sampling::Random => "independent draws",
        }
    }
}

/// What is drawn for a sweep, and when it is enough.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sampled {
    /// what is drawn
    pub inputs: Vec<Input>,
    /// points; with `indices` each is a group of rows
    pub samples: usize,
    /// how they are chosen
    pub sampling: Sampling,
    /// of the random numbers
    pub seed: u64,
    /// whether the rows are those of Saltelli's design
    pub indices: bool,
    /// what ends the sweep before its last row
    pub until: Option<Rule>,
    /// columns of landing points, whose ellipse is drawn; `None`: those of a landing, if there is one
    pub ellipse: Option<[String; 2]>,
}

impl Sampled {
    /// Rows that belong together: the points of Saltelli's design that differ by a coordinate.
    pub fn group(&self) -> usize {
        if self.indices { self.inputs.len() + 2 } else { 1 }
    }

    /// All keys that are drawn.
    pub fn keys(&self) -> impl Iterator<Item = &String> {
        self.inputs.iter().flat_map(|input| &input.keys)
    }

    /// All rows.
    pub fn rows(&self) -> usize {
        self.samples.saturating_mul(self.group())
    }

    /// The ends of the batches after which the rule is looked at, as numbers of rows.
    pub fn batches(&self) -> impl Iterator<Item = usize> + use<> {
        let rows = self.rows();
        let step = if self.until.is_some() { BATCH } else { rows.max(1) };
        (1..=rows.div_ceil(step)).map(move |batch| (batch * step).min(rows))
    }

    /// Keys and values of a point of the distributions, a coordinate a input.
    pub fn values(&self, point: &[f64]) -> Vec<(String, Value)> {
        let of = |(input, u): (&Input, &f64)| input.keys.clone().into_iter().zip(input.law.at(*u));
        self.inputs.iter().zip(point).flat_map(of).collect()
    }

    /// The point of every row.
    ///
    /// # Errors
    /// More inputs than Sobol' points have coordinates.
    pub fn points(&self) -> Result<Vec<Vec<f64>>, StudyError> {
        let d = self.inputs.len();
        let coordinates = if self.indices { 2 * d } else { d };
        let points = match self.sampling {
            Sampling::Random => (0..self.samples).map(|row| random(self.seed, row, coordinates)).collect(),
            Sampling::Lhs => self.hypercubes(coordinates),
            Sampling::Sobol => shifted(self.seed, self.samples, coordinates)?,
        };
        if !self.indices {
            return Ok(points);
        }
        let rows = points.iter().flat_map(|point| {
            let (a, b) = point.split_at(d);
            let mixed = (0..d).map(|i| {
                let mut mixed = a.to_vec();
                mixed[i] = b[i];
                mixed
            });
            [a.to_vec(), b.to_vec()].into_iter().chain(mixed)
        });
        Ok(rows.collect())
    }

    /// A Latin hypercube of all points, or one a batch where a rule may end the sweep after any of them.
    fn hypercubes(&self, coordinates: usize) -> Vec<Vec<f64>> {
        let size = if self.until.is_some() { BATCH } else { self.samples.max(1) };
        let mut points = Vec::with_capacity(self.samples);
        for (number, from) in (0..self.samples).step_by(size).enumerate() {
            let rows = from..self.samples.min(from + size);
            points.extend(hypercube(self.seed, number, rows, coordinates));
        }
        points
    }
}

/// A Latin hypercube of rows, the `number`-th of its seed: each is in another part of each coordinate (McKay, Beckman &
/// Conover 1979).
pub(crate) fn hypercube(seed: u64, number: usize, rows: Range<usize>, coordinates: usize) -> Vec<Vec<f64>> {
    let count = rows.len();
    let orders: Vec<Vec<usize>> = (0..coordinates)
        // The seeds of the orders are none of those of the places within the parts.
        .map(|i| shuffled(count, SplitMix64::new(!seed, (number * coordinates + i) as u64)))
        .collect();
    let point = |(part, row): (usize, usize)| {
        let within = random(seed, row, coordinates);
        let place = |(order, u): (&Vec<usize>, f64)| (order[part] as f64 + u) / count as f64;
        orders.iter().zip(within).map(place).collect()
    };
    rows.enumerate().map(point).collect()
}

/// Independent coordinates of a row.
fn random(seed: u64, row: usize, coordinates: usize) -> Vec<f64> {
    let mut numbers = SplitMix64::new(seed, row as u64);
    (0..coordinates).map(|_| numbers.uniform()).collect()
}

/// The numbers below `count` in a random order (Fisher and Yates).
fn shuffled(count: usize, mut numbers: SplitMix64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    for last in (1..count).rev() {
        // The upper half of the product is even to 2^-44 for 100,000 numbers.
        let other = (u128::from(numbers.draw()) * (last as u128 + 1)) >> 64;
        order.swap(last, other as usize);
    }
    order
}

/// Sobol' points, each coordinate with a random exclusive or, which keeps the shares of intervals.
fn shifted(seed: u64, count: usize, coordinates: usize) -> Result<Vec<Vec<f64>>, StudyError> {
    let mut numbers = SplitMix64::new(seed, 0);
    let all = (0..coordinates).map(|i| Some((Coordinate::new(i)?, (numbers.draw() >> 32) as u32)));
    let all: Option<Vec<(Coordinate, u32)>> = all.collect();
    let all = all.ok_or_else(|| {
        StudyError::Usage(format!(
            "Sobol' points have up to {} coordinates, and {coordinates} are needed; take --sampling lhs",
            sobol::MOST
        ))
    })?;
    let of = |row: usize| {
        let place = |(coordinate, shift): &(Coordinate, u32)| {
            (f64::from(coordinate.of(row as u32) ^ shift) + 0.5) / 2.0_f64.powi(32)
        };
        all.iter().map(place).collect()
    };
    Ok((0..count).map(of).collect())
}

#[cfg(test)]
mod tests {
    use super::super::law::Law;
    use super::*;

    fn sampled(sampling: Sampling, samples: usize, d: usize) -> Sampled {
        let input = |i: usize| Input { keys: vec![format!("k{i}")], law: Law::Uniform { from: 0.0, to: 1.0 } };
        Sampled { inputs: (0..d).map(input).collect(), samples, sampling, seed: 7, ..Sampled::default() }
    }

    /// Of N points each N-th of every coordinate holds one, for Sobol' points where N is a power of two.
    #[test]
    fn parts_hold_one_point_each() {
        for (sampling, n) in [(Sampling::Lhs, 100), (Sampling::Lhs, 37), (Sampling::Sobol, 128)] {
            let points = sampled(sampling, n, 5).points().expect("points");
            for i in 0..5 {
                let mut parts: Vec<usize> = points.iter().map(|point| (point[i] * n as f64) as usize).collect();
                parts.sort_unstable();
                assert_eq!(parts, (0..n).collect::<Vec<_>>(), "{sampling:?}, coordinate {i}");
            }
        }
    }

    /// A row is that of its number and the seed: more rows change none of random and Sobol' points, nor whole batches.
    #[test]
    fn rows_follow_from_seed_and_number() {
        let until = Some(Rule::parse("2% of mean x").expect("a rule"));
        for (sampling, until) in [(Sampling::Random, None), (Sampling::Sobol, None), (Sampling::Lhs, until)] {
            let with = |samples: usize, seed: u64| {
                Sampled { until: until.clone(), seed, ..sampled(sampling, samples, 3) }.points().expect("points")
            };
            assert_eq!(with(256, 1)[..128], with(128, 1)[..], "{sampling:?}");
            assert_ne!(with(128, 1), with(128, 2), "{sampling:?}");
            assert!(with(256, 1).iter().flatten().all(|u| *u > 0.0 && *u < 1.0));
        }
    }

    /// Independent draws: means and covariances of uniform numbers, within five standard errors.
    #[test]
    fn draws_are_even_and_independent() {
        let n = 20_000;
        let points = sampled(Sampling::Random, n, 3).points().expect("points");
        let mean = |of: &dyn Fn(&Vec<f64>) -> f64| points.iter().map(of).sum::<f64>() / n as f64;
        let error = 5.0 / (n as f64).sqrt();
        for i in 0..3 {
            assert!((mean(&|p| p[i]) - 0.5).abs() < error * 0.289);
            let covariance = mean(&|p| (p[i] - 0.5) * (p[(i + 1) % 3] - 0.5));
            assert!(covariance.abs() < error / 12.0, "{covariance}");
        }
        let next = points.windows(2).map(|pair| (pair[0][0] - 0.5) * (pair[1][0] - 0.5)).sum::<f64>() / n as f64;
        assert!(next.abs() < error / 12.0, "{next}");
    }

    #[test]
    fn groups_differ_by_a_coordinate() {
        let design = Sampled { indices: true, ..sampled(Sampling::Sobol, 8, 2) };
        let rows = design.points().expect("points");
        assert_eq!((rows.len(), design.rows(), design.group()), (32, 32, 4));
        for group in rows.chunks(4) {
            let [a, b, ab0, ab1] = group else { panic!("four rows") };
            assert_eq!((ab0, ab1), (&vec![b[0], a[1]], &vec![a[0], b[1]]));
        }
        assert!(Sampled { indices: true, ..sampled(Sampling::Sobol, 8, 21) }.points().is_err());
    }
}
