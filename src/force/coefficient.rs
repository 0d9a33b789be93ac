//! Numbers that belong to elements: one for all, or one each.

use crate::model::lanes::LANES;
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
pub(super) struct Place {
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
pub(super) struct Column<'a> {
    /// those of whole blocks; none where all are the same
    quads: &'a [[f64; 4]],
    /// the elements that fill no block
    last: [[f64; 4]; 2],
}

impl<'a> Column<'a> {
    /// One value an element.
    pub fn each(values: &'a [f64]) -> Self {
        let (blocks, rest) = values.as_chunks::<LANES>();
        let mut last = [[0.0; 4]; 2];
        last.as_flattened_mut()[..rest.len()].copy_from_slice(rest);
        Column { quads: blocks.as_flattened().as_chunks().0, last }
    }

    /// The same for all.
    pub fn uniform(value: f64) -> Self {
        Column { quads: &[], last: [[value; 4]; 2] }
    }

    /// The value of one element.
    pub fn at(&self, element: usize) -> f64 {
        match self.quads.as_flattened().get(element) {
            Some(value) => *value,
            None => self.last.as_flattened()[element % LANES],
        }
    }

    /// The values of four elements, by the number of the four among those of the column.
    #[inline(always)]
    pub fn quad<U: VectorUnit>(&self, unit: U, number: usize) -> U::Quad {
        unit.quad(*self.quads.get(number).unwrap_or(&self.last[number % 2]))
    }
}
