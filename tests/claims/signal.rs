//! A scalar motion followed through a run: when it crosses zero, how fast it oscillates, by what angle a step turns it.

use crate::common::run::follow_on;
use canopy_fem::case::Case;
use canopy_fem::simulation::FollowedState;
use std::f64::consts::PI;

/// A motion with its rate at every step.
#[derive(Clone, Debug, Default)]
pub struct Signal {
    /// [s]
    pub t: Vec<f64>,
    pub x: Vec<f64>,
    /// [1/s of x]
    pub v: Vec<f64>,
}

impl Signal {
    /// Runs a case to its end and reads a motion and its rate off every step.
    pub fn of(case: &Case, read: impl Fn(&FollowedState<'_>) -> (f64, f64)) -> Self {
        let mut signal = Signal::default();
        let outcome = follow_on(case, |seen| {
            let (x, v) = read(seen);
            signal.t.push(seen.t);
            signal.x.push(x);
            signal.v.push(v);
        });
        assert_eq!(outcome.t_end, case.problem().time.end);
        signal
    }

    /// Cubic Hermite interpolation in the interval that begins with step `i`, at the share `s` of it.
    fn inside(&self, i: usize, s: f64) -> f64 {
        let h = self.t[i + 1] - self.t[i];
        let r = 1.0 - s;
        r * r * ((1.0 + 2.0 * s) * self.x[i] + s * h * self.v[i])
            + s * s * ((1.0 + 2.0 * r) * self.x[i + 1] - r * h * self.v[i + 1])
    }

    /// The motion at a time inside the run.
    pub fn at(&self, t: f64) -> f64 {
        let i = self.t.partition_point(|&ti| ti <= t).clamp(1, self.t.len() - 1) - 1;
        self.inside(i, (t - self.t[i]) / (self.t[i + 1] - self.t[i]))
    }

    /// [s] Times of the zeros.
    pub fn crossings(&self) -> Vec<f64> {
        let changes = |&i: &usize| (self.x[i] < 0.0) != (self.x[i + 1] < 0.0);
        let zero = |i: usize| {
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                let same = (self.inside(i, middle) < 0.0) == (self.x[i] < 0.0);
                *if same { &mut low } else { &mut high } = middle;
            }
            self.t[i] + low * (self.t[i + 1] - self.t[i])
        };
        (0..self.t.len() - 1).filter(changes).map(zero).collect()
    }

    /// [rad/s] Angular frequency, from the first zero to the last.
    pub fn frequency(&self) -> f64 {
        let zeros = self.crossings();
        assert!(zeros.len() > 2, "only {} zeros", zeros.len());
        PI * (zeros.len() - 1) as f64 / (zeros[zeros.len() - 1] - zeros[0])
    }

    /// Cosine of the angle by which a step turns the oscillation. The positions of a linear scheme without dissipation
    /// obey x(n+1) + x(n-1) = 2 cos x(n) exactly, whatever the step; least squares over the run. Beyond 1 the motion
    /// grows.
    pub fn cosine(&self) -> f64 {
        let (mut product, mut square) = (0.0, 0.0);
        for w in self.x.windows(3) {
            product += (w[0] + w[2]) * w[1];
            square += 2.0 * w[1] * w[1];
        }
        product / square
    }
}
