//! Numbers that belong to elements: one for all, or one each.

use crate::model::spec::SpringValues;
use std::sync::Arc;

/// Elements of a full star, and stars side by side ([`crate::force::kernel::star_batches`]).
pub(in crate::force) const STAR: usize = 3;
pub(in crate::force) const STARS: usize = 4;

/// One value for all elements, or one each; a uniform value is not read from memory again and again.
#[derive(Clone, Debug, PartialEq)]
pub enum Coefficient {
    /// the same for all
    Uniform(f64),
    /// one an element
    Each(Arc<[f64]>),
}

impl Coefficient {
    /// Chooses the compact form.
    pub fn from_values(values: &[f64]) -> Self {
        match values.first() {
            Some(&first) if values.iter().all(|&v| v == first) => Coefficient::Uniform(first),
            _ => Coefficient::Each(values.into()),
        }
    }

    /// Those of springs in this order.
    pub fn of_springs(values: &SpringValues, order: &[usize]) -> Self {
        match values {
            SpringValues::Uniform(value) => Coefficient::Uniform(*value),
            SpringValues::PerEdge(values) => Self::from_values(&order.iter().map(|&i| values[i]).collect::<Vec<_>>()),
        }
    }

    /// The value of element `i`.
    #[inline]
    pub fn at(&self, i: usize) -> f64 {
        match self {
            Coefficient::Uniform(c) => *c,
            Coefficient::Each(values) => values[i],
        }
    }
}

/// The values of elements in the order of a kernel, four at a time.
#[derive(Clone, Copy, Debug)]
pub(in crate::force) struct Column<'a> {
    quads: &'a [[f64; STARS]],
    /// 0 where all are the same, else all ones: a branch would cost more than reading the number
    mask: usize,
}

impl<'a> Column<'a> {
    /// One value an element.
    pub(crate) fn each(quads: &'a [[f64; STARS]]) -> Self {
        Column { quads, mask: usize::MAX }
    }

    /// The same for all.
    pub(crate) fn uniform(quads: &'a [[f64; STARS]; STAR]) -> Self {
        Column { quads, mask: 0 }
    }

    /// The column without its first quads.
    pub(crate) fn after(self, quads: usize) -> Self {
        Column { quads: &self.quads[quads & self.mask..], ..self }
    }

    /// The values of a group of four stars of `N` elements each.
    #[inline(always)]
    pub(crate) fn group<const N: usize>(&self, group: usize) -> &'a [[f64; STARS]; N] {
        &self.quads.as_chunks().0[group & self.mask]
    }
}
