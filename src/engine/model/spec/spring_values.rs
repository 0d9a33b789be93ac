//! A number of the springs of a group.

use serde::Serialize;

/// One value for all springs of a group, or one each.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum SpringValues {
    /// the same for all
    Uniform(f64),
    /// one a spring
    PerEdge(Vec<f64>),
}

impl SpringValues {
    /// The values as they are given: one, or one a spring.
    pub fn given(&self) -> &[f64] {
        match self {
            SpringValues::Uniform(value) => std::slice::from_ref(value),
            SpringValues::PerEdge(values) => values,
        }
    }

    /// The value of spring `i`; `None` beyond the last one that is given.
    pub fn get(&self, i: usize) -> Option<f64> {
        match self {
            SpringValues::Uniform(value) => Some(*value),
            SpringValues::PerEdge(values) => values.get(i).copied(),
        }
    }

    /// The values of `n` springs; fewer if fewer are given.
    pub fn of(&self, n: usize) -> impl Iterator<Item = f64> + Clone {
        (0..n).map_while(|i| self.get(i))
    }

    /// What a function makes of the values.
    #[must_use]
    pub fn map(&self, f: impl Fn(f64) -> f64) -> Self {
        match self {
            SpringValues::Uniform(value) => SpringValues::Uniform(f(*value)),
            SpringValues::PerEdge(values) => SpringValues::PerEdge(values.iter().map(|value| f(*value)).collect()),
        }
    }

    /// The values times a factor for each spring.
    #[must_use]
    pub fn times(&self, factors: &[f64]) -> Self {
        self.of(factors.len()).zip(factors).map(|(value, factor)| value * factor).collect()
    }
}

impl Default for SpringValues {
    fn default() -> Self {
        SpringValues::PerEdge(Vec::new())
    }
}

impl From<f64> for SpringValues {
    fn from(value: f64) -> Self {
        SpringValues::Uniform(value)
    }
}

impl FromIterator<f64> for SpringValues {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        SpringValues::PerEdge(values.into_iter().collect())
    }
}

impl From<Vec<f64>> for SpringValues {
    fn from(values: Vec<f64>) -> Self {
        SpringValues::PerEdge(values)
    }
}
