//! Numbers that belong to elements: one for all, or one each.

use crate::force::kernel::star_batches::{STAR, STARS};
use crate::model::quad::VectorUnit;
use std::sync::Arc;

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

    /// The value of element `i`.
    #[inline]
    pub fn at(&self, i: usize) -> f64 {
        match self {
            Coefficient::Uniform(c) => *c,
            Coefficient::Each(values) => values[i],
        }
    }
}

/// Where four elements stand among those that are gone over.
#[derive(Clone, Copy, Debug)]
pub(in crate::force) struct Place {
    /// number of the block of eight
    pub block: usize,
    /// which half of it, 0 or 1
    pub half: usize,
}

impl Place {
    /// Number of the four among the elements that are gone over.
    #[inline(always)]
    pub fn quad(self) -> usize {
        2 * self.block + self.half
    }
}

/// The values of elements, four at a time.
#[derive(Clone, Copy, Debug)]
pub(in crate::force) struct Column<'a> {
    quads: &'a [[f64; 4]],
    /// 0 where all are the same, else all ones: a choice between two places would cost more than the number itself
    mask: usize,
}

impl<'a> Column<'a> {
    /// One value an element, in whole blocks of eight.
    pub fn each(quads: &'a [[f64; 4]]) -> Self {
        Column { quads, mask: usize::MAX }
    }

    /// The same for all.
    pub fn uniform(quads: &'a [[f64; STARS]; STAR]) -> Self {
        Column { quads, mask: 0 }
    }

    /// Those of the elements from one on, the first of a star or of a block.
    pub fn from(self, first: usize) -> Self {
        Column { quads: &self.quads[(first / 4) & self.mask..], ..self }
    }

    /// One after the other, and what fills up the last block; none where all are the same.
    pub fn values(&self) -> &'a [f64] {
        if self.mask == 0 { &[] } else { self.quads.as_flattened() }
    }

    /// The values of four stars.
    #[inline(always)]
    pub fn stars(&self, group: usize) -> &'a [[f64; STARS]; STAR] {
        &self.quads.as_chunks().0[group & self.mask]
    }

    /// The values of four elements, by the number of the four among those of the column.
    #[inline(always)]
    pub fn quad<U: VectorUnit>(&self, unit: U, number: usize) -> U::Quad {
        unit.quad(self.quads[number & self.mask])
    }
}
