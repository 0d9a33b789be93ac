//! Where points land: the ellipse of their covariance, and the circle that holds half of them.

use serde::Serialize;

use super::estimate::{mean_of, quantile};

/// [-] Share of a normal distribution that the larger ellipse holds.
const SHARE: f64 = 0.95;

/// The scatter of points in a plane. A normal distribution has the share 1 - exp(-k^2/2) within k times the half axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ellipse {
    /// mean of the points
    pub centre: [f64; 2],
    /// the standard deviations along the axes, the longer one first
    pub deviations: [f64; 2],
    /// [deg] from the first coordinate to the longer axis, towards the second, above -90 and up to 90
    pub angle: f64,
    /// half axes of the ellipse that holds 95 % of a normal distribution
    pub half_axes: [f64; 2],
    /// [-] share of the points that it holds
    pub within: f64,
    /// radius of the circle around the mean that holds half of the points
    pub half_radius: f64,
}

impl Ellipse {
    /// Of some points; `None` of fewer than three.
    pub fn of(points: &[[f64; 2]]) -> Option<Self> {
        if points.len() < 3 {
            return None;
        }
        let centre = [0, 1].map(|i| mean_of(&points.iter().map(|point| point[i]).collect::<Vec<f64>>()));
        let from_centre: Vec<[f64; 2]> = points.iter().map(|point| [0, 1].map(|i| point[i] - centre[i])).collect();
        let covariance =
            |i: usize, j: usize| from_centre.iter().map(|d| d[i] * d[j]).sum::<f64>() / (points.len() - 1) as f64;
        let (xx, xy, yy) = (covariance(0, 0), covariance(0, 1), covariance(1, 1));
        let (mean, half) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
        let deviations = [mean + half, mean - half].map(|variance| variance.max(0.0).sqrt());
        let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
        let reach = (-2.0 * (1.0 - SHARE).ln()).sqrt();
        let (sin, cos) = angle.sin_cos();
        let along = |d: &&[f64; 2]| {
            let [u, v] = [cos * d[0] + sin * d[1], cos * d[1] - sin * d[0]];
            // Along an axis without scatter every point is at the centre.
            let part = |x: f64, deviation: f64| if deviation > 0.0 { x / deviation } else { 0.0 };
            part(u, deviations[0]).hypot(part(v, deviations[1])) <= reach
        };
        let mut distances: Vec<f64> = from_centre.iter().map(|d| d[0].hypot(d[1])).collect();
        distances.sort_by(f64::total_cmp);
        Some(Ellipse {
            centre,
            deviations,
            angle: angle.to_degrees(),
            half_axes: deviations.map(|deviation| reach * deviation),
            within: from_centre.iter().filter(along).count() as f64 / points.len() as f64,
            half_radius: quantile(&distances, 0.5).value,
        })
    }

    /// Points of the larger ellipse, closed.
    pub(crate) fn outline(&self) -> Vec<(f64, f64)> {
        const POINTS: usize = 120;
        let (sin, cos) = self.angle.to_radians().sin_cos();
        let point = |i: usize| {
            let (b, a) = (std::f64::consts::TAU * i as f64 / POINTS as f64).sin_cos();
            let [u, v] = [a * self.half_axes[0], b * self.half_axes[1]];
            (self.centre[0] + cos * u - sin * v, self.centre[1] + sin * u + cos * v)
        };
        (0..=POINTS).map(point).collect()
    }

    /// Points of the circle that holds half of the points, closed.
    pub(crate) fn half_circle(&self) -> Vec<(f64, f64)> {
        Ellipse { half_axes: [self.half_radius; 2], ..*self }.outline()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::random::SplitMix64;
    use crate::sweep::sample::normal::normal_quantile;

    /// Normal points with deviations 3 and 1, turned by 30 degrees: the ellipse is theirs, it holds 95 % of them, and
    /// half are within the radius. Standard errors of 20,000 points are half a percent.
    #[test]
    fn normal_points_have_their_ellipse() {
        let mut numbers = SplitMix64::of_seed(11);
        let mut draw = || normal_quantile(numbers.uniform());
        let (sin, cos) = 30_f64.to_radians().sin_cos();
        let points: Vec<[f64; 2]> = (0..20_000)
            .map(|_| {
                let [u, v] = [3.0 * draw(), draw()];
                [10.0 + cos * u - sin * v, -4.0 + sin * u + cos * v]
            })
            .collect();
        let ellipse = Ellipse::of(&points).expect("points");
        let near = |found: f64, expected: f64, by: f64| assert!((found - expected).abs() < by, "{ellipse:?}");
        near(ellipse.centre[0], 10.0, 0.1);
        near(ellipse.centre[1], -4.0, 0.1);
        near(ellipse.deviations[0], 3.0, 0.06);
        near(ellipse.deviations[1], 1.0, 0.02);
        near(ellipse.angle, 30.0, 1.0);
        near(ellipse.half_axes[0], 2.447_75 * ellipse.deviations[0], 1e-4);
        near(ellipse.within, 0.95, 0.006);
        let inside = points.iter().filter(|p| (p[0] - 10.0).hypot(p[1] + 4.0) < ellipse.half_radius).count();
        near(inside as f64 / 20_000.0, 0.5, 0.01);
        for (x, y) in ellipse.outline() {
            let (u, v) = (x - ellipse.centre[0], y - ellipse.centre[1]);
            assert!(u.hypot(v) <= ellipse.half_axes[0] * (1.0 + 1e-12));
        }
    }

    #[test]
    fn points_on_a_line_have_a_flat_ellipse() {
        let points: Vec<[f64; 2]> = (0..11).map(|i| [f64::from(i), 2.0 * f64::from(i)]).collect();
        let ellipse = Ellipse::of(&points).expect("points");
        assert!(ellipse.deviations[1] < 1e-6 && (ellipse.angle - 2_f64.atan().to_degrees()).abs() < 1e-9);
        assert_eq!(Ellipse::of(&points[..2]), None);
    }
}
