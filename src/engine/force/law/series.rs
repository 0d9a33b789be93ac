//! Values over time: linear between the rows of a table, constant outside it.

use crate::force::Copies;
use crate::force::law::step_samples::sampled_by_steps;
use crate::model::spec::Series;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, PoisonError, RwLock};

/// A table, and its replacement in a run of fixed steps: see `step_samples`.
#[derive(Debug)]
pub struct Table<const N: usize> {
    given: Arc<Series<[f64; N]>>,
    replaced: RwLock<Replaced<N>>,
}

/// What stands in for a table.
#[derive(Clone, Debug)]
struct Replaced<const N: usize> {
    /// the table as a run of fixed steps samples it
    sampled: Option<Series<[f64; N]>>,
    /// a constant that a program has set
    held: Option<[f64; N]>,
}

impl<const N: usize> Clone for Table<N> {
    /// Another table of the same rows; what stands in for one of them does not stand in for the other.
    fn clone(&self) -> Self {
        let replaced = self.replaced.read().unwrap_or_else(PoisonError::into_inner).clone();
        Table { given: self.given.clone(), replaced: RwLock::new(replaced) }
    }
}

impl<const N: usize> Table<N> {
    /// A table with at least one row and increasing times.
    pub fn new(given: Series<[f64; N]>) -> Self {
        Table { given: Arc::new(given), replaced: RwLock::new(Replaced { sampled: None, held: None }) }
    }

    /// Replaces the table by a constant, or goes back to it.
    pub fn hold(&self, value: Option<[f64; N]>) {
        self.replaced.write().unwrap_or_else(PoisonError::into_inner).held = value;
    }

    /// [s] The first row with the lowest first value.
    pub fn lowest_at(&self) -> Option<f64> {
        let rows = self.given.t.iter().zip(&self.given.value);
        rows.min_by(|a, b| a.1[0].total_cmp(&b.1[0])).map(|(t, _)| *t)
    }

    /// The value at time `t` [s].
    pub fn at(&self, t: f64) -> [f64; N] {
        let replaced = self.replaced.read().unwrap_or_else(PoisonError::into_inner);
        replaced.held.unwrap_or_else(|| replaced.sampled.as_ref().unwrap_or(&*self.given).at(t))
    }
}

/// Values over time, as a run sees them.
pub trait SampledTable: Send + Sync {
    /// [s] Times at which it has a corner or a jump.
    fn corners(&self) -> Vec<f64>;

    /// [s] Beginnings and ends of its changes.
    fn changing(&self) -> Vec<[f64; 2]>;

    /// Makes the table ready for a run of fixed steps of `h` [s] from t = 0, or for any other run.
    fn sample(&self, h: Option<f64>);

    /// That of another run.
    fn for_run(self: Arc<Self>, copies: &mut Copies) -> Arc<dyn SampledTable>;
}

impl<const N: usize> SampledTable for Table<N> {
    fn corners(&self) -> Vec<f64> {
        self.given.t.clone()
    }

    fn changing(&self) -> Vec<[f64; 2]> {
        self.given.changing().collect()
    }

    fn sample(&self, h: Option<f64>) {
        let made = h.and_then(|h| sampled_by_steps(&self.given, h));
        self.replaced.write().unwrap_or_else(PoisonError::into_inner).sampled = made;
    }

    fn for_run(self: Arc<Self>, copies: &mut Copies) -> Arc<dyn SampledTable> {
        let copy: Arc<Self> = copies.of(&self);
        copy
    }
}

/// A factor that a program sets while a simulation runs.
#[derive(Debug)]
pub struct Scale(AtomicU64);

impl Default for Scale {
    fn default() -> Self {
        Scale(AtomicU64::new(1.0_f64.to_bits()))
    }
}

impl Clone for Scale {
    /// Another factor of the same value.
    fn clone(&self) -> Self {
        Scale(AtomicU64::new(self.0.load(Ordering::Relaxed)))
    }
}

impl Scale {
    /// [-] The factor: 1 until it is set.
    pub fn get(&self) -> f64 {
        f64::from_bits(self.0.load(Ordering::Relaxed))
    }

    /// Sets it, between two steps.
    pub fn set(&self, factor: f64) {
        self.0.store(factor.to_bits(), Ordering::Relaxed);
    }
}

/// The factor of a load: a table over time, times what a program has set. The load shares it with its scene.
#[derive(Clone, Debug, Default)]
pub struct LoadFactor {
    /// factor over time; absent means 1
    pub table: Option<Arc<Table<1>>>,
    /// what a program has set
    pub scale: Arc<Scale>,
}

impl LoadFactor {
    /// That of another run.
    #[must_use]
    pub(crate) fn for_run(&self, copies: &mut Copies) -> Self {
        LoadFactor { table: self.table.as_ref().map(|table| copies.of(table)), scale: copies.of(&self.scale) }
    }

    /// [-] The factor at time `t` [s].
    pub fn at(&self, t: f64) -> f64 {
        self.table.as_ref().map_or(1.0, |table| table.at(t)[0]) * self.scale.get()
    }
}

/// A table with one number per row.
pub fn scalar(series: &Series<f64>) -> Arc<Table<1>> {
    Arc::new(Table::new(series.rows()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_between_rows_and_constant_outside() {
        let s = Series { t: vec![1.0, 2.0, 4.0], value: vec![10.0, 20.0, 0.0] };
        let table = scalar(&s);
        for (t, value) in [(-5.0, 10.0), (1.0, 10.0), (1.5, 15.0), (2.0, 20.0), (3.0, 10.0), (4.0, 0.0), (9.0, 0.0)] {
            assert_eq!(table.at(t), [value], "at t = {t}");
        }
        let constant = scalar(&Series { t: vec![0.0], value: vec![3.0] });
        let factor = LoadFactor { table: Some(constant), ..LoadFactor::default() };
        factor.scale.set(0.5);
        assert_eq!((factor.at(7.0), LoadFactor::default().at(3.0)), (1.5, 1.0));
    }

    #[test]
    fn a_run_of_fixed_steps_leaves_the_table_itself() {
        let table = scalar(&Series { t: vec![0.0, 0.25, 0.26], value: vec![0.0, 0.0, 1.0] });
        let before = table.at(0.2);
        table.sample(Some(0.1));
        assert_ne!(table.at(0.3), [1.0]);
        table.hold(Some([7.0]));
        table.sample(None);
        assert_eq!(table.at(0.3), [7.0]);
        table.hold(None);
        assert_eq!((table.at(0.2), table.at(0.3)), (before, [1.0]));
    }
}
