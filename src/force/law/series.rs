//! Values over time: linear between the rows of a table, constant outside it.

use crate::force::law::step_samples::sampled_by_steps;
use crate::model::spec::Series;
use std::sync::{Arc, PoisonError, RwLock};

/// A table, and its replacement in a run of fixed steps: see `step_samples`.
#[derive(Debug)]
pub struct Table<const N: usize> {
    given: Series<[f64; N]>,
    sampled: RwLock<Option<Series<[f64; N]>>>,
}

impl<const N: usize> Table<N> {
    /// A table with at least one row and increasing times.
    pub fn new(given: Series<[f64; N]>) -> Arc<Self> {
        Arc::new(Table { given, sampled: RwLock::new(None) })
    }

    /// Replaces the table by a constant until [`SampledTable::sample`] is called.
    pub fn hold(&self, value: [f64; N]) {
        let constant = Series { t: vec![0.0], value: vec![value] };
        *self.sampled.write().unwrap_or_else(PoisonError::into_inner) = Some(constant);
    }

    /// The value at time `t` [s].
    pub fn at(&self, t: f64) -> [f64; N] {
        let sampled = self.sampled.read().unwrap_or_else(PoisonError::into_inner);
        sampled.as_ref().unwrap_or(&self.given).at(t)
    }
}

/// The preparation of a table for a run.
pub trait SampledTable: Send + Sync {
    /// Makes the table ready for a run of fixed steps of `h` [s] from t = 0, or for any other run.
    fn sample(&self, h: Option<f64>);
}

impl<const N: usize> SampledTable for Table<N> {
    fn sample(&self, h: Option<f64>) {
        let made = h.and_then(|h| sampled_by_steps(&self.given, h));
        *self.sampled.write().unwrap_or_else(PoisonError::into_inner) = made;
    }
}

/// A factor over time; absent means 1.
pub fn factor(table: Option<&Arc<Table<1>>>, t: f64) -> f64 {
    table.map_or(1.0, |table| table.at(t)[0])
}

/// A table with one number per row.
pub fn scalar(series: &Series<f64>) -> Arc<Table<1>> {
    Table::new(Series { t: series.t.clone(), value: series.value.iter().map(|&v| [v]).collect() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_between_rows_and_constant_outside() {
        let s = Series { t: vec![1.0, 2.0, 4.0], value: vec![10.0, 20.0, 0.0] };
        let table = scalar(&s);
        for (t, value) in [(-5.0, 10.0), (1.0, 10.0), (1.5, 15.0), (2.0, 20.0), (3.0, 10.0), (4.0, 0.0), (9.0, 0.0)] {
            assert_eq!(factor(Some(&table), t), value, "at t = {t}");
        }
        assert_eq!(factor(Some(&scalar(&Series { t: vec![0.0], value: vec![3.0] })), 7.0), 3.0);
        assert_eq!(factor(None, 3.0), 1.0);
    }

    #[test]
    fn a_run_of_fixed_steps_leaves_the_table_itself() {
        let table = scalar(&Series { t: vec![0.0, 0.25, 0.26], value: vec![0.0, 0.0, 1.0] });
        let before = table.at(0.2);
        table.sample(Some(0.1));
        assert_ne!(table.at(0.3), [1.0]);
        table.sample(None);
        assert_eq!((table.at(0.2), table.at(0.3)), (before, [1.0]));
    }
}
