//! Values over time: linear between the rows of a table, constant outside it.

use crate::model::spec::Series;
use glam::DVec3;
use std::ops::{Add, Mul};

/// The value at time `t` [s]; `series` has at least one row and increasing times.
pub fn interpolate<T>(series: &Series<T>, t: f64) -> T
where
    T: Copy + Add<Output = T> + Mul<f64, Output = T>,
{
    let after = series.t.partition_point(|&s| s <= t);
    match after {
        0 => series.value[0],
        n if n == series.t.len() => series.value[n - 1],
        n => {
            let (t0, t1) = (series.t[n - 1], series.t[n]);
            let s = (t - t0) / (t1 - t0);
            series.value[n - 1] * (1.0 - s) + series.value[n] * s
        }
    }
}

/// A factor over time; absent means 1.
pub fn factor(series: Option<&Series<f64>>, t: f64) -> f64 {
    series.map_or(1.0, |s| interpolate(s, t))
}

/// The same table with vectors the kernels use.
pub fn vectors(series: &Series<[f64; 3]>) -> Series<DVec3> {
    Series { t: series.t.clone(), value: series.value.iter().map(|&v| DVec3::from_array(v)).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_between_rows_and_constant_outside() {
        let s = Series { t: vec![1.0, 2.0, 4.0], value: vec![10.0, 20.0, 0.0] };
        for (t, value) in [(-5.0, 10.0), (1.0, 10.0), (1.5, 15.0), (2.0, 20.0), (3.0, 10.0), (4.0, 0.0), (9.0, 0.0)] {
            assert_eq!(interpolate(&s, t), value, "at t = {t}");
        }
        assert_eq!(interpolate(&Series { t: vec![0.0], value: vec![3.0] }, 7.0), 3.0);
        assert_eq!(factor(None, 3.0), 1.0);
    }
}
